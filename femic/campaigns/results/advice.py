"""Advice: the cheapest ICs that are good enough for a scene."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from compare.frontier.advice import AS_CHEAP
from compare.ics.compute import Results, compute, reference_of
from compare.ics.errors import measure_of
from femic.campaigns.results.kind import SHARE, ResultKind
from femic.campaigns.results.on_lines import jobs_on_lines
from femic.reference.accuracy import component_of
from femic.reference.run_options import RunOptions
from femic.scenes.scene import Scene
from geometries.arrays import Array


def advice(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return the errors of all ICs, and by body the cheapest ICs that are good enough.

    `known_error` (variant, body) is the worst over lines and components, with the estimate of C. `advised`
    is the number of a variant: of those whose known error is at most the scene's `ics_tolerance` and that
    take less than `AS_CHEAP` times the seconds of the fastest of them, the most accurate one; -1: none is.
    """
    results = compute(scene, options)
    variants, bodies = list(results.variants), list(scene.compared)
    bounds = np.array([_error_bounds(results, body) for body in bodies]).T  # (n_variants, n_bodies)
    seconds = np.array([[results.seconds[v, body] for body in bodies] for v in variants])
    advised = [float(cheapest(bounds[:, k], seconds[:, k], scene.ics_tolerance)) for k in range(len(bodies))]
    about = "number of the variant that is good enough and cheap; -1: none"
    by = ("variant", "body")
    return xr.Dataset(
        {
            "known_error": (by, bounds, SHARE | {"long_name": "error and estimate of C"}),
            "ic_seconds": (by, seconds, {"units": "s", "long_name": "seconds of the ICs"}),
            "advised": ("body", advised, {"long_name": about}),
        },
        coords={"variant": variants, "body": bodies},
    )


def cheapest(bounds: Array, seconds: Array, tolerance: float) -> int:
    """Return the number of the cheapest ICs whose known error is at most `tolerance`, -1 without any."""
    good = np.flatnonzero(bounds <= tolerance)
    if not good.size:
        return -1
    cheap = good[seconds[good] <= AS_CHEAP * np.min(seconds[good])]
    return int(cheap[np.argmin(bounds[cheap])])


def _error_bounds(results: Results, body: str) -> list[float]:
    """Return error bounds of all ICs of a body, the worst over lines and components; of C its estimate."""
    measure, c = measure_of(results, body), reference_of(results, body)
    floor = _worst(results, measure.shares(c.estimate))
    bounds = {
        variant: _worst(results, measure.shares(ics - c.ic)) + floor
        for (variant, compared), ics in results.approximations.items()
        if compared == body
    }
    return [float(np.max(bounds.get(variant, floor))) for variant in results.variants]


def _worst(results: Results, shares: Mapping[str, Array]) -> Array:
    """Return the largest share over the lines by component of the scene, (n_components,)."""
    largest = np.max(list(shares.values()), axis=0)
    return np.array([component_of(largest, component) for component in results.scene.components])


ADVICE = ResultKind(
    advice, jobs_on_lines, names=frozenset({"variant", "body", "known_error", "ic_seconds", "advised"})
)
