"""Advice: the cheapest ICs that are good enough for a scene."""

import numpy as np
import xarray as xr

from compare.campaigns.results.kind import SHARE, ResultKind
from compare.campaigns.results.on_lines import jobs_on_lines
from compare.studies.frontier import cheapest, worst_shares
from femic.reference.run_options import RunOptions
from femic.results.ics import Results, compute, measure_of, reference_of
from femic.scenes.scene import Scene


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


def _error_bounds(results: Results, body: str) -> list[float]:
    """Return error bounds of all ICs of a body, the worst over lines and components; of C its estimate."""
    measure, c = measure_of(results, body), reference_of(results, body)
    floor = worst_shares(results.scene, measure.shares(c.estimate))
    bounds = {
        variant: worst_shares(results.scene, measure.shares(ics - c.ic)) + floor
        for (variant, of_body), ics in results.approximations.items()
        if of_body == body
    }
    return [float(np.max(bounds.get(variant, floor))) for variant in results.variants]


ADVICE = ResultKind(
    advice, jobs_on_lines, names=frozenset({"variant", "body", "known_error", "ic_seconds", "advised"})
)
