"""The engines by name: a new one is a folder, a class derived from `Engine`, and its instance here.

What checks a scene needs the engines, but no solver: their modules run when they are first used.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from femic.cache.store import Store
from femic.lazy import lazy_imports
from femic.reference.engine import Engine, ExpectedCost, Limits, Points, RawICs, Request, scale_cells
from femic.reference.harmonic.request import FAR_RADIUS, TUNED_TOLERANCE, tightening
from femic.reference.meshing import Cells
from femic.reference.result import SAFETY
from femic.reference.run_options import TRUNCATION_ORDER, RunOptions, Solved, Task
from geometries.arrays import Array
from geometries.patches import Grid, Load, Patch

with lazy_imports():
    import femic.reference.harmonic.engine as harmonic
    import femic.reference.harmonic.request as harmonic_requests
    import femic.reference.harmonic.stored as harmonic_models
    import femic.reference.harmonic.synthesis as harmonic_synthesis
    import femic.reference.solid.engine as solid
    import femic.reference.solid.fields as solid_fields


class HarmonicEngine(Engine):
    """Quartic triangles of the section, and wavenumbers along x."""

    name = "harmonic"
    description = "harmonic: quartic triangles of the section"
    limits = Limits(nu=0.4999, aspect=100.0, rolling_radius=20.0, inclination=85.0, distance=1e4)
    models = ("fine",)
    safety = 2.0  # with it the estimate bounds 99 of 100 errors where C is known
    growth_of_unknowns = 2.0
    infinite_length = solves_transposes = follows_outlines = shares_a_model = has_matrices = True

    cells_per_half_side, growth = 12, 0.34
    cells_per_half_strip, growth_on_strips = 2, 0.5  # displacements are read at the centres of strips only
    far_over_half_width = 600.0  # far radius over the half-width of a grid

    def least_side(self, patch: Patch) -> float:
        """Return b: along x there are no cells."""
        return patch.b

    def first_cells(self, tolerance: float, patch: Patch, *, on_strips: bool = False) -> Cells:
        """Return the cells of the first model, under a patch or on strips as wide."""
        number, growth = self.cells_per_half_side, self.growth
        if on_strips:
            number, growth = self.cells_per_half_strip, self.growth_on_strips
        cells = Cells(patch.b / number, growth, growth)
        return scale_cells(cells, tolerance, TUNED_TOLERANCE, coarsest=1.25 if on_strips else 1.5)

    def far_radius(self, tolerance: float, grid: Grid | None = None) -> float:
        """Return the radius [mm] of the far arc; it grows with the width of a grid."""
        half_width = grid.n_s * grid.ds / 2 if grid else 0.0
        far_radius = max(FAR_RADIUS, self.far_over_half_width * half_width)
        return far_radius * tightening(tolerance) ** (1 / TRUNCATION_ORDER)

    def request(self, model: Request) -> Any:
        """Return the `HarmonicRequest` for a model."""
        return harmonic_requests.request_for(model)

    def key(self, request: Any, store: Store) -> str:
        """Return the key of a model in a store, which is independent of E."""
        return harmonic_models.model_key(request, store)

    def expected_cost(self, request: Any, workers: int) -> ExpectedCost:
        """Return the cost of a model: its section is meshed, its wavenumbers are those of a half-space."""
        return harmonic.expected_cost(request, workers)

    def solve(self, tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
        """Solve models one after the other; one begun by an interrupted run goes on where that one ended."""
        for task in tasks:
            yield harmonic.solve_task(task, options)

    def displacements(self, solved: Any, loads: Sequence[Load], points: Points) -> RawICs:
        """Return displacements from the responses of a section."""
        return harmonic_synthesis.displacements(solved, loads, points)

    def columns(
        self, solved: Any, grid: Grid, components: Sequence[str]
    ) -> Mapping[str, Callable[[int], Array]]:
        """Return the columns of an IC matrix from the responses of a section."""
        return harmonic_synthesis.columns(solved, grid, components)


class SolidEngine(Engine):
    """Quadratic tetrahedra."""

    name = "solid"
    description = "solid: quadratic tetrahedra"
    limits = Limits(nu=0.49, aspect=10.0, rolling_radius=50.0, inclination=75.0, distance=1e3)
    models = ("fine", "coarse", "small")
    safety = SAFETY
    growth_of_unknowns = 2.7
    has_fields = True

    tuned_tolerance = 0.01
    cells_per_half_side, growth, line_growth = 12, 0.14, 0.05

    def least_side(self, patch: Patch) -> float:
        """Return the smaller half-side."""
        return min(patch.a, patch.b)

    def first_cells(self, tolerance: float, patch: Patch, *, on_strips: bool = False) -> Cells:
        """Return the cells of the first model; there are none on strips alone."""
        assert not on_strips
        cells = Cells(self.least_side(patch) / self.cells_per_half_side, self.growth, self.line_growth)
        return scale_cells(cells, tolerance, self.tuned_tolerance, coarsest=3.0)

    def far_radius(self, tolerance: float, grid: Grid | None = None) -> float:  # noqa: ARG002
        """Return the radius [mm] of the far arc, the same for all tolerances."""
        return 320.0

    def key(self, request: Any, store: Store) -> str:
        """Return the key of a model in a store."""
        return solid.model_key(request, store)

    def expected_cost(self, request: Any, workers: int) -> ExpectedCost:  # noqa: ARG002 (one model each)
        """Return the cost of a model, without a mesh."""
        return solid.expected_cost(request)

    def solve(self, tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
        """Solve models in parallel processes; what an earlier run has finished comes first."""
        return solid.solve_tasks(tasks, options)

    def displacements(self, solved: Any, loads: Sequence[Load], points: Points) -> RawICs:  # noqa: ARG002
        """Return a solved model: it consists of its displacements."""
        return solved

    def mesh(self, request: Any) -> Any:
        """Return the mesh of a model."""
        return solid.build_mesh(request)

    def nodal_fields(self, request: Any) -> Iterator[tuple[Load, Any]]:
        """Solve the loads of a model, and yield each with its field on the whole body."""
        return solid_fields.nodal_fields(request)


HARMONIC, SOLID = HarmonicEngine(), SolidEngine()
ENGINES: Mapping[str, Engine] = {engine.name: engine for engine in (HARMONIC, SOLID)}


def kinds_that(can: Callable[[Engine], object]) -> str:
    """Return the setting of a scene file that chooses an engine with a property: engine.kind = 'harmonic'."""
    names = [repr(name) for name, engine in ENGINES.items() if can(engine)]
    return f"engine.kind = {' or '.join(names)}"
