"""C_nn of both bodies on the grid of a scene, and B-hat_nn there: a node of a map of C."""

import numpy as np
import xarray as xr

from compare.campaigns.maps import bhat_nn
from compare.campaigns.results.kind import ResultKind
from femic.contact.pairs.ics import c_jobs, normal_ics
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.reference.matrix.job import MatrixJob
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene

DIMS = ("lag", "observed", "loaded")
ABOUT = {
    "c": "C_nn of both bodies after the discount",
    "c_estimate": "its estimated error",
    "bhat": "B-hat_nn of both bodies",
}


def matrix(scene: Scene, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return `c`, `c_estimate`, `bhat` (lag, observed, loaded) [mm/MPa] on the grid of a scene.

    These are the ICs of frictionless contact, with the strips of the upper body opposite those of the lower
    one. Raises as `femic.reference.matrix.reference.matrices`.
    """
    problem = scene.contact_problem
    on_grid = pair_on_grid(problem, scene.grid)
    ic, estimate = normal_ics(problem, on_grid, options)
    values = {"c": ic, "c_estimate": estimate.astype(np.float32), "bhat": bhat_nn(on_grid)}
    mm = {"units": "mm"}
    return xr.Dataset(
        {name: (DIMS, value, {"units": "mm/MPa", "long_name": ABOUT[name]}) for name, value in values.items()}
        | {
            "lag_x": ("lag", scene.grid.lags, mm | {"long_name": "lag along x"}),
            "observed_s": ("observed", scene.grid.strips, mm | {"long_name": "arc length of a strip"}),
            "loaded_s": ("loaded", scene.grid.strips, mm | {"long_name": "arc length of a strip"}),
        }
    )


def _jobs(scene: Scene) -> dict[str, MatrixJob]:
    """Return the jobs of C_nn on the scene's grid."""
    return c_jobs(scene.contact_problem, pair_on_grid(scene.contact_problem, scene.grid))


def _require_frictionless(scene: Scene) -> None:
    """Raise BadScene with friction: maps of C have nn only."""
    if scene.contact.friction is not None:
        raise BadScene(
            f'{scene.name}: contact.motion = {scene.contact.motion!r}: "matrix" keeps C_nn, for contact '
            "without friction; leave the motion out"
        )
    _jobs(scene)


MATRIX = ResultKind(
    matrix,
    lambda scene: [_jobs(scene)],
    _require_frictionless,
    frozenset({*DIMS, *ABOUT, "lag_x", "observed_s", "loaded_s"}),
)
