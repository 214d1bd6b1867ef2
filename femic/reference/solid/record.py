"""The record of the solid engine."""

from femic.late import Late
from femic.reference.engine import Comparison, Engine, ErrorEstimate, Fields, Limits, Models, TunedCells
from femic.reference.estimate import SAFETY
from femic.reference.meshing.cell_size import Cells
from femic.reference.solid.pardiso import available as direct_available
from geometries.patches import Patch

CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH = 12, 0.14, 0.05
FAR_RADIUS = 320.0  # mm, of the far arc, the same for all tolerances


def _least_side(patch: Patch) -> float:
    """The half-side [mm] that cells must resolve."""
    return min(patch.a, patch.b)


def _cells(patch: Patch) -> Cells:
    """Cells that meet the tuned tolerance under a patch."""
    return Cells(_least_side(patch) / CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH)


def _solvers() -> list[dict[str, str]]:
    """Return every linear solver that is installed, as keys of the table `engine`."""
    return [{"solver": solver} for solver in ("multigrid", *(("direct",) if direct_available() else ()))]


SOLID = Engine(
    name="solid",
    description="solid: quadratic tetrahedra",
    limits=Limits(nu=0.49, aspect=10.0, rolling_radius=50.0, inclination=75.0, distance=1e3),
    tuned=TunedCells(tolerance=0.01, cells=_cells, coarsest=3.0),
    far_radius=lambda _tolerance: FAR_RADIUS,
    least_side=_least_side,
    infinite_length=False,
    solves_transposes=False,
    outlines=False,
    shares_a_model=False,
    estimate=ErrorEstimate(models=("fine", "coarse", "small"), safety=SAFETY, growth_of_unknowns=2.7),
    models=Models(
        request=Late("femic.reference.solid.request:request_for"),
        solve=Late("femic.reference.solid.tasks:solve_tasks"),
        key=Late("femic.reference.solid.tasks:model_key"),
        displacements=lambda _request, solved: solved,  # a solved model is its displacements
        expected_cost=Late("femic.reference.solid.plan:expected_cost"),
    ),
    fields=Fields(
        Late("femic.reference.solid.engine:build_mesh"), Late("femic.reference.solid.fields:nodal_fields")
    ),
    comparison=Comparison((1e-1, 3e-2, 1e-2), _solvers, colour="tab:red", marker="^"),
)
