"""Errors of results as shares: of C's components, of max |C_nn|, and on the scale of refinement.

`body` is "lower", "upper", or "combined" for both together.
"""

import numpy as np

from compare.ics.compute import Results, check_of, parts_of, reference_of, solids
from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.result import scales
from geometries.arrays import Array
from geometries.patches import N


def measure_of(results: Results, body: str) -> Measure:
    """Return the measure of errors of a body's ICs: `femic.ic_errors.error_measure`."""
    points, patch = (results.points.x, results.points.s), results.scene.patch
    a = solids(results.scene)[body].approximate("A", patch, points) / patch.area
    return Measure.of(reference_of(results, body), a[N, N], results.lines, far_from(patch, *points))


def engine_differences(results: Results, body: str) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return differences between C of both engines and sums of their estimates, by line, (3, 3) [-]."""
    c, check, measure = reference_of(results, body), check_of(results, body), measure_of(results, body)
    return measure.shares(c.ic - check.ic), measure.shares(c.estimate + check.estimate)


def refinement_scales_of(results: Results, body: str) -> dict[str, Array]:
    """Return the scale of refinement of C per line, (3, 3) [mm/N]: `femic.reference.accuracy`."""
    jobs = [results.jobs[name] for name in parts_of(body)]
    return scales(jobs, reference_of(results, body).ic)


def refinement_shares_of(results: Results, body: str, deviations: Array) -> dict[str, Array]:
    """Return deviations from C, (3, 3, n_points) [mm/N], as shares of the scale of refinement, by line.

    These shares are compared with a tolerance.
    """
    scales = refinement_scales_of(results, body)
    return {
        line: np.max(np.abs(deviations[..., part]), axis=-1) / scales[line]
        for line, part in results.lines.items()
    }
