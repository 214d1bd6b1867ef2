"""The bodies of a scene with friction on a grid that fits, with all ICs."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

from compare.contact.compute import C, grids_of, sizing_of
from compare.contact.pair_on_grid import Placed, placed_on
from compare.friction.operators import FullReferenceICs, approximation, full_reference_ics
from femic.contact.frictional import FrictionalProblem, FullOperator
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.approximations import half_space_operator
from femic.contact.specification import FrictionSpecification
from femic.reference.run_options import RunOptions
from femic.scenes.scene import Scene
from geometries.errors import Failure

Outcome = TypeVar("Outcome")


@dataclass(frozen=True, eq=False)
class Solver:
    """The bodies of a scene on a grid."""

    scene: Scene
    placed: Placed
    options: RunOptions

    @cached_property
    def reference(self) -> FullReferenceICs:
        """C on the grid, computed when it is needed for the first time."""
        return full_reference_ics(self.scene, self.placed, self.options)

    @property
    def wanted(self) -> FrictionSpecification:
        """The motion."""
        if self.scene.contact.friction is None:
            raise ValueError(f"{self.scene.name}: without friction")
        return self.scene.contact.friction

    def operator(self, name: str) -> FullOperator:
        """The ICs of a name."""
        return self.reference.operator if name == C else approximation(self.placed, name)

    def known_of(self, name: str) -> dict[str, float | str]:
        """What is known of C on the grid; nothing of other ICs."""
        if name != C:
            return {}
        c = self.reference
        return {
            "C_estimate": c.estimate,
            "C_asymmetry": c.asymmetry.share,
            "C_asymmetry_component": c.asymmetry.component,
            "C_seconds": c.seconds,
        }

    def problem(self, operator: FullOperator, friction: float) -> FrictionalProblem:
        """The contact with some ICs and a coefficient of friction."""
        placed = self.placed
        return FrictionalProblem(
            placed.grid,
            operator,
            half_space_operator(placed.pair, placed.grid),
            placed.distance,
            placed.undeformed.lower.contour.inclination(placed.grid.strips),
            friction,
        )


def on_fitting_grid(scene: Scene, options: RunOptions, solve: Callable[[Solver], Outcome]) -> Outcome:
    """What is solved on a grid that fits the largest load; it is made longer where a contact needs it."""
    ((grid, cases),) = grids_of(scene)
    largest = cases[-1]
    while True:
        placed = placed_on(scene, grid)
        options.watch.on_stage(
            f"  {grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm: {largest}"
        )
        try:
            return solve(Solver(scene, placed, options))
        except PotentialAreaTooSmall as short:
            if not scene.contact.automatic:
                raise Failure(f"contact at {largest}: {short}") from short
            grid = sizing_of(scene).longer(grid, short, largest)
