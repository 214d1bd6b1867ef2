"""Two bodies on a grid with friction: ICs by name, and the contact problem with each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

from femic.contact.friction.by_angle import Pairs, friction_factors
from femic.contact.friction.kinematics import RollingKinematics
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.motions import MOTIONS, ContactMotion
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.automatic_grid import grids_of, on_fitting_grid
from femic.contact.pairs.given_ics import NONE_GIVEN, C, GivenICs, given_of
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.reference_ics import ReferenceICs, approximation, full_reference_ics
from femic.contact.rolling import RollingProblem
from femic.contact.specification import ContactProblem, FrictionSpecification
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.errors import WrongInput

Outcome = TypeVar("Outcome")


@dataclass(frozen=True, eq=False)
class PairWithFriction:
    """Two bodies on a grid, and ICs of the caller by name; raises WrongInput without friction."""

    problem: ContactProblem
    on_grid: PairOnGrid
    options: RunOptions = DEFAULT
    given: Mapping[str, GivenICs] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.problem.specification.friction is None:
            raise WrongInput(f"{self.problem.name}: without friction: give a specification of it")

    @cached_property
    def reference(self) -> ReferenceICs:
        """C on the grid, computed when it is needed for the first time."""
        rolls = self.motion.wheel_rolls
        return full_reference_ics(self.problem, self.on_grid, self.options, wheel_rolls=rolls)

    @property
    def specification(self) -> FrictionSpecification:
        """The specification of friction and motion."""
        assert self.problem.specification.friction is not None
        return self.problem.specification.friction

    @property
    def motion(self) -> ContactMotion:
        """The motion."""
        return MOTIONS[self.problem.specification.motion]

    @property
    def loads(self) -> tuple[float, ...]:
        """The loads [N]."""
        return self.problem.specification.loads

    def operator(self, name: str) -> FullOperator:
        """Return the ICs of a name."""
        if name in self.given:
            return self.given[name].operator
        return self.reference.operator if name == C else approximation(self.on_grid, name)

    def perturbed(self, name: str) -> FullOperator | None:
        """Return the ICs of a name with their estimated errors added; None where no errors are known."""
        if name in self.given:
            return self.given[name].perturbed
        return self.reference.perturbed if name == C else None

    def frictional(self, operator: FullOperator, friction: float) -> FrictionalProblem:
        """Return the contact problem with some ICs and a coefficient of friction."""
        return frictional_problem(self.on_grid, operator, friction, self.specification.friction_by_angle)

    def rolling(self, problem: FrictionalProblem) -> RollingProblem:
        """Return the rolling problem of a contact problem, on the grid of this."""
        return rolling_problem(self.on_grid, problem)


def frictional_problem(
    on_grid: PairOnGrid, operator: FullOperator, friction: float, by_angle: Pairs = ()
) -> FrictionalProblem:
    """Return the contact problem of bodies with some ICs and a coefficient of friction.

    `by_angle` are pairs of contact angle [deg] and the factor of the coefficient there; none: 1 everywhere.
    """
    inclination = on_grid.undeformed.lower.contour.inclination(on_grid.grid.strips)
    return FrictionalProblem(
        on_grid.grid,
        operator,
        half_space_operator(on_grid.pair, on_grid.grid),
        on_grid.distance,
        inclination,
        friction,
        factor=friction_factors(by_angle, inclination) if by_angle else None,
    )


def rolling_problem(on_grid: PairOnGrid, problem: FrictionalProblem) -> RollingProblem:
    """Return the rolling problem of bodies, on the grid of their contact problem."""
    on_grid = replace(on_grid, grid=problem.grid)
    undeformed, strips = on_grid.undeformed, on_grid.grid.strips
    height, contour = undeformed.upper_height(strips), undeformed.lower.contour
    radius = undeformed.upper.rolling_radius
    return RollingProblem(problem, RollingKinematics(contour, radius, on_grid.x, strips, height))


def solve_with_friction(
    problem: ContactProblem,
    solve: Callable[[PairWithFriction], Outcome],
    options: RunOptions = DEFAULT,
    given: Mapping[str, GivenICs] = NONE_GIVEN,
) -> Outcome:
    """Return the solution of `solve` on a grid that fits the largest load, made longer where needed.

    `given` are ICs of the caller by name; with some of them among those of the problem, the grid is theirs.
    """
    own = given_of(problem.specification.ics, given)
    ((grid, loadings),) = grids_of(problem, own)

    def solve_on(on_grid: PairOnGrid) -> Outcome:
        n_x, n_s = on_grid.grid.n_x, on_grid.grid.n_s
        size = f"{on_grid.grid.dx:.3g} x {on_grid.grid.ds:.3g} mm"
        options.watch.on_stage(f"  {n_x} x {n_s} elements of {size}: {loadings[-1]}")
        return solve(PairWithFriction(problem, on_grid, options, own))

    return on_fitting_grid(problem, grid, solve_on, longer=not own)
