"""The records of the engines, and all engines by name: a new engine is a folder, and its record here."""

from collections.abc import Callable, Mapping

from femic.late import Late
from femic.reference.engine import (
    Comparison,
    Engine,
    ErrorEstimate,
    Fields,
    Limits,
    Matrices,
    Models,
    TunedCells,
)
from femic.reference.harmonic import request as harmonic
from femic.reference.meshing import Cells
from femic.reference.result import SAFETY
from femic.reference.solid.pardiso import available as direct_available
from geometries.patches import Patch

# --- the harmonic engine ---

HARMONIC_SAFETY = 2.0  # with it the estimate bounds 99 of 100 errors where C is known
displacements = Late("femic.reference.harmonic.synthesis:displacements")

HARMONIC = Engine(
    name="harmonic",
    description="harmonic: quartic triangles of the section",
    limits=Limits(nu=0.4999, aspect=100.0, rolling_radius=20.0, inclination=85.0, distance=1e4),
    tuned=harmonic.TUNED,
    far_radius=harmonic.far_radius,
    least_side=harmonic.least_side,
    infinite_length=True,
    solves_transposes=True,
    outlines=True,
    shares_a_model=True,
    estimate=ErrorEstimate(models=("fine",), safety=HARMONIC_SAFETY, growth_of_unknowns=2.0),
    models=Models(
        request=Late("femic.reference.harmonic.request:request_for"),
        solve=Late("femic.reference.harmonic.engine:solve_tasks"),
        key=Late("femic.reference.harmonic.stored:model_key"),
        displacements=lambda request, solved: displacements(solved, request.loads, request.points),
        expected_cost=Late("femic.reference.harmonic.engine:expected_cost"),
    ),
    matrices=Matrices(
        harmonic.TUNED_ON_STRIPS,
        harmonic.far_radius_of_grid,
        request=Late("femic.reference.harmonic.request:request_on_strips"),
        columns=Late("femic.reference.harmonic.synthesis:syntheses"),
        displacements=displacements,
    ),
    comparison=Comparison((1e-1, 1e-2, 1e-3, 1e-4), colour="black", marker="s"),
)


# --- the solid engine ---

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
        request=Late("femic.reference.solid.engine:request_for"),
        solve=Late("femic.reference.solid.engine:solve_tasks"),
        key=Late("femic.reference.solid.engine:model_key"),
        displacements=lambda _request, solved: solved,  # a solved model is its displacements
        expected_cost=Late("femic.reference.solid.engine:expected_cost"),
    ),
    fields=Fields(
        Late("femic.reference.solid.engine:build_mesh"), Late("femic.reference.solid.fields:nodal_fields")
    ),
    comparison=Comparison((1e-1, 3e-2, 1e-2), _solvers, colour="tab:red", marker="^"),
)


# --- all engines ---

ENGINES: Mapping[str, Engine] = {engine.name: engine for engine in (HARMONIC, SOLID)}


def kinds_that(can: Callable[[Engine], object]) -> str:
    """Return the setting of a scene file that chooses an engine with a property: engine.kind = 'harmonic'."""
    names = [repr(name) for name, engine in ENGINES.items() if can(engine)]
    return f"engine.kind = {' or '.join(names)}"
