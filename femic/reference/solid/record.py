"""The record of the solid engine."""

from femic.reference.engine import Engine, Limits, Tuned
from femic.reference.estimate import SAFETY
from femic.reference.meshing.cell_size import Cells
from femic.reference.solid.plan import planned
from femic.reference.solid.request import request_for
from femic.reference.solid.tasks import model_key, solve_tasks
from geometries.patches import Patch

CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH = 12, 0.14, 0.05
FAR_RADIUS = 320.0  # mm, of the far arc, the same for all tolerances


def _least_side(patch: Patch) -> float:
    """The half-side [mm] that cells must resolve."""
    return min(patch.a, patch.b)


def _cells(patch: Patch) -> Cells:
    """Cells that meet the tuned tolerance under a patch."""
    return Cells(_least_side(patch) / CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH)


SOLID = Engine(
    name="solid",
    describes="solid: quadratic tetrahedra",
    models=("fine", "coarse", "small"),
    safety=SAFETY,
    growth_of_unknowns=2.7,
    tuned=Tuned(tolerance=0.01, cells=_cells, coarsest=3.0),
    far_radius=lambda _tolerance: FAR_RADIUS,
    least_side=_least_side,
    limits=Limits(nu=0.49, aspect=10.0, rolling_radius=50.0, inclination=75.0, distance=1e3),
    endless=False,
    both_loads=False,
    shares_a_model=False,
    has_fields=True,
    request=request_for,
    solve=solve_tasks,
    key=model_key,
    displacements=lambda _request, solved: solved,  # all that is kept of a solved model
    planned=planned,
)
