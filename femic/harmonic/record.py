"""The record of the harmonic engine."""

from femic.engine import Engine, Limits, Tuned
from femic.harmonic.plan import planned
from femic.harmonic.request import TUNED_TOLERANCE, HarmonicRequest, request_for
from femic.harmonic.synthesis import Responses, displacements
from femic.harmonic.tasks import solve_tasks
from femic.level import TRUNCATION_ORDER
from femic.meshing.cell_size import Cells
from femic.models import RawICs
from geometries.patches import Patch

CELLS_PER_HALF_SIDE, GROWTH = 12, 0.34
FAR_RADIUS = 1280.0  # mm, of the far arc at the tuned tolerance
HARMONIC_SAFETY = 2.0  # with it the estimate bounds 99 of 100 errors where C is known


def _least_side(patch: Patch) -> float:
    """The half-side [mm] that cells must resolve: across x only, along x there are no cells."""
    return patch.b


def _cells(patch: Patch) -> Cells:
    """Cells that meet the tuned tolerance under a patch."""
    return Cells(_least_side(patch) / CELLS_PER_HALF_SIDE, GROWTH, GROWTH)


TUNED = Tuned(tolerance=TUNED_TOLERANCE, cells=_cells, coarsest=1.5)


def _far_radius(tolerance: float) -> float:
    """Radius [mm] of the far arc that is likely to meet a tolerance."""
    return FAR_RADIUS * TUNED.tighter(tolerance) ** (1 / TRUNCATION_ORDER)


def _displacements(request: HarmonicRequest, solved: Responses) -> RawICs:
    """The displacements at the points of a request, from the responses to it."""
    return displacements(solved, request.loads, request.points)


HARMONIC = Engine(
    name="harmonic",
    describes="harmonic: quartic triangles of the section",
    models=("fine", "coarse"),
    safety=HARMONIC_SAFETY,
    growth_of_unknowns=2.0,
    tuned=TUNED,
    far_radius=_far_radius,
    least_side=_least_side,
    limits=Limits(nu=0.4999, aspect=100.0, rolling_radius=20.0, inclination=85.0, distance=1e4),
    endless=True,
    both_loads=True,
    shares_a_model=True,
    has_fields=False,
    request=request_for,
    solve=solve_tasks,
    displacements=_displacements,
    planned=planned,
)
