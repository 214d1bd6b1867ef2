"""Numbers of the contact of a scene: without friction, in rolling, in compression."""

from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

from compare.contact.compute import C, c_jobs, cases_of, compute_contact, grids_of
from compare.contact.dataset import to_dataset
from compare.contact.pair_on_grid import placed_on
from compare.contact.quantities import QUANTITIES
from compare.friction.compression import compute_compression
from compare.friction.displaced import PREFIX
from compare.friction.quantities import OF_PATCH, OF_ROLLING
from compare.friction.rolling import OF_FREE, compute_rolling
from femic.campaigns.results.kind import Jobs, ResultKind
from femic.reference.run_options import Means
from femic.scenes.scene import Scene

WITH_FRICTION: Mapping[str, Callable[[Scene, Means], xr.Dataset]] = {
    "rolling": compute_rolling,
    "compression": compute_compression,
}
OF_CURVES = ("rms", "largest", "estimate_rms", "estimate_largest")  # distances of creep-force curves
OF_CURVE = "_of_curve"  # the end of their names in campaigns: errors have an rms, too
CURVES_LARGEST = f"largest{OF_CURVE}"
NUMBERS = {*QUANTITIES, *OF_PATCH, *OF_ROLLING, *OF_FREE}
NAMES = frozenset(
    {*NUMBERS, *(f"estimate_{name}" for name in NUMBERS), *(name + OF_CURVE for name in OF_CURVES)}
    | {"case", "ics", "friction", "load", "xi", "simplified"}
)


def contact(scene: Scene, means: Means) -> xr.Dataset:
    """Return numbers of the contact with their estimates, as `femic contact` does, without maps of the patch.

    Those without friction have dims `case` and `ics`; with friction they are over friction, ICs and load or
    creepage.
    """
    if scene.contact.friction is None:
        solved = to_dataset(compute_contact(scene, means))
        names = [f"{prefix}{name}" for prefix in ("", "estimate_") for name in QUANTITIES]
        return solved[names].assign_coords(case=np.arange(solved.sizes["case"], dtype=float))
    solved = WITH_FRICTION[scene.contact.motion](scene, means)
    solved = solved.drop_vars(["C_seconds", "seconds"], errors="ignore")
    numbers = [
        name
        for name, variable in solved.data_vars.items()
        if not ({"x", "s"} & set(variable.dims) or str(name).startswith(PREFIX))
    ]
    numbers_only = solved[numbers].drop_vars(["x", "s", "direction", "tangential"], errors="ignore")
    distances = {name: name + OF_CURVE for name in OF_CURVES if name in numbers}
    return numbers_only.astype(float).rename(distances)


def _jobs(scene: Scene) -> list[Jobs]:
    """The jobs of C on each grid of the contact; none where C is not among the ICs.

    The grids are found with approximations; C may make them longer.
    """
    if C not in scene.contact.ics:
        return []
    return [c_jobs(scene, placed_on(scene, grid)) for grid, _ in grids_of(scene)]


CONTACT = ResultKind(contact, _jobs, cases_of, NAMES)
