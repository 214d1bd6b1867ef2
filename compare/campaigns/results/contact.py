"""Numbers of the contact of a scene: without friction, or in a motion with friction."""

import xarray as xr

from compare.campaigns.maps import maps_of_scene
from compare.campaigns.results.kind import Jobs, ResultKind
from femic.contact.motions import MOTIONS
from femic.contact.motions.rolling import OF_CURVE
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import C, c_jobs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.reference.run_options import RunOptions
from femic.results.contact import compute_contact, require_solvable, to_dataset
from femic.results.friction import compute_with_friction
from femic.scenes.scene import Scene

DISTANCES = ("rms", "largest", "estimate_rms", "estimate_largest")  # between creep-force curves
SECONDS_OF_CONTACT = 0.15  # by element across the patch: 1.2 s with 8, without and with friction
END_OF_CURVE = "_of_curve"  # the end of their names in campaigns: errors have an rms, too
CURVES_LARGEST = f"largest{END_OF_CURVE}"
NUMBERS = {name for motion in MOTIONS.values() for name in motion.quantities} | {*OF_CURVE}
NAMES = frozenset(
    {*NUMBERS, *(f"estimate_{name}" for name in NUMBERS), *(name + END_OF_CURVE for name in DISTANCES)}
    | {"ics", "friction", "load", "simplified", *(motion.dimension for motion in MOTIONS.values())}
)


def contact(scene: Scene, options: RunOptions) -> xr.Dataset:
    """Return numbers of the contact with their estimates, as `femic contact` does, without maps of the patch.

    Those without friction have dims `case` (a load or an approach) and `ics`; with friction they are over
    friction, ICs and the dimension of the motion.
    """
    if scene.contact.friction is None:
        solved = to_dataset(compute_contact(scene, options, maps_of_scene(scene)))
        names = [f"{prefix}{name}" for prefix in ("", "estimate_") for name in OF_FRICTIONLESS]
        return solved[names]
    solved = compute_with_friction(scene, options)
    solved = solved.rename({name: name + END_OF_CURVE for name in DISTANCES if name in solved})
    numbers = solved[[name for name in solved.data_vars if name in NAMES]]
    return numbers.drop_vars([name for name in numbers.coords if name not in NAMES]).astype(float)


def jobs_of_contact(scene: Scene) -> list[Jobs]:
    """Return the jobs of C on each grid of the contact; none where C is not among the ICs.

    Approximations size the grids; C may make them longer.
    """
    if C not in scene.contact.ics:
        return []
    problem, maps = scene.contact_problem, maps_of_scene(scene)
    return [c_jobs(problem, pair_on_grid(problem, grid)) for grid, _ in grids_of(problem, maps)]


def seconds_of_contacts(scene: Scene) -> float:
    """Return about how many seconds all contacts of a scene take, besides C."""
    contact, friction = scene.contact, scene.contact.friction
    count = len(contact.ics) * len(contact.loadings)
    if friction is not None:
        count *= len(friction.coefficients) * (
            len(friction.longitudinal) if contact.motion == "rolling" else 1
        )
    return SECONDS_OF_CONTACT * contact.elements * count


CONTACT = ResultKind(contact, jobs_of_contact, require_solvable, NAMES, seconds_of_contacts)
