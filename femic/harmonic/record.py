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
FAR_RADIUS = 1280.0  # mm, at the tuned tolerance
SAFETY = 2.0  # so that 99 of 100 errors are bounded where C is known


def _least_side(patch: Patch) -> float:
    return patch.b


def _cells(patch: Patch) -> Cells:
    return Cells(_least_side(patch) / CELLS_PER_HALF_SIDE, GROWTH, GROWTH)


TUNED = Tuned(tolerance=TUNED_TOLERANCE, cells=_cells, coarsest=1.5)


def _far_radius(tolerance: float) -> float:
    return FAR_RADIUS * TUNED.tighter(tolerance) ** (1 / TRUNCATION_ORDER)


def _displacements(request: HarmonicRequest, solved: Responses) -> RawICs:
    return displacements(solved, request.loads, request.points)


HARMONIC = Engine(
    name="harmonic",
    describes="harmonic: quartic triangles of the section",
    models=("fine", "coarse"),
    safety=SAFETY,
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
