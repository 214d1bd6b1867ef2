"""Two bodies on a grid with friction: ICs by name, and the contact problem with each.

For estimates of errors a motion is solved again: on larger elements, and with ICs plus their estimated
errors.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np

from femic.contact.estimates import Numbers
from femic.contact.friction.motion import Pairs, RollingKinematics, friction_factors
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.motions import MOTIONS, ContactMotion
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.grids import grids_of, on_fitting_grid
from femic.contact.pairs.ics import (
    NONE_GIVEN,
    C,
    GivenICs,
    ReferenceICs,
    approximation,
    full_reference_ics,
    select_given,
)
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.rolling import RollingProblem
from femic.contact.specification import ContactProblem, FrictionSpecification
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

# --- bodies and contact problems ---

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
    own = select_given(problem.specification.ics, given)
    ((grid, loadings),) = grids_of(problem, own)

    def solve_on(on_grid: PairOnGrid) -> Outcome:
        n_x, n_s = on_grid.grid.n_x, on_grid.grid.n_s
        size = f"{on_grid.grid.dx:.3g} x {on_grid.grid.ds:.3g} mm"
        options.watch.on_stage(f"  {n_x} x {n_s} elements of {size}: {loadings[-1]}")
        return solve(PairWithFriction(problem, on_grid, options, own))

    return on_fitting_grid(problem, grid, solve_on, longer=not own)


# --- solved again for estimates ---

Solution = TypeVar("Solution")
Solve = Callable[[PairWithFriction, FrictionalProblem, str], Solution]  # the last is a label for messages
ELEMENTS = ("larger elements", "still larger elements")


@dataclass(frozen=True, eq=False)
class Change:
    """By how much a solution changes when the estimated errors of its ICs are added to these.

    0 where no errors of ICs are known, NaN where the changed ICs have no solution.
    """

    points: Sequence[Numbers]  # by creepage or load
    p: Array  # of tractions in the contact that has maps [MPa], (n_x, n_s, 3)


def if_possible(pair: PairWithFriction, consequence: str, solve: Callable[[], Solution]) -> Solution | None:
    """Return a solution; None where there is none, which is reported. Raises PotentialAreaTooSmall."""
    try:
        return solve()
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        pair.options.watch.on_stage(f"  {consequence}: {failure}")
        return None


def on_larger_elements(
    pair: PairWithFriction, problem: FrictionalProblem, label: str, solve: Solve[Solution]
) -> list[Solution | None]:
    """Return the solutions on elements twice and four times as large, None where there is none."""
    solutions: list[Solution | None] = []
    for elements in ELEMENTS:
        if not problem.has_coarser:
            break
        problem = problem.coarsened
        solve_coarse = partial(solve, pair, problem, f"{label}, {elements}")
        solutions.append(if_possible(pair, "not in estimates", solve_coarse))
    return solutions


def with_perturbed_ics(
    pair: PairWithFriction, friction: float, name: str, label: str, solve: Solve[Solution]
) -> Solution | None:
    """Return the solution with ICs plus their estimated errors; None where no errors are known."""
    operator = pair.perturbed(name)
    if operator is None:
        return None
    return solve(pair, pair.frictional(operator, friction), f"{label} plus its estimate")


def differences(numbers: Numbers, changed: Numbers | None) -> dict[str, float]:
    """Return changed numbers less the numbers themselves; NaN where there are none."""
    return {name: np.nan if changed is None else changed[name] - value for name, value in numbers.items()}


def change_of_tractions(contact: FrictionalContact, changed: FrictionalContact | None) -> Array:
    """Return changed tractions less those of a contact [MPa], (n_x, n_s, 3); NaN where there are none."""
    return np.full_like(contact.p, np.nan) if changed is None else changed.p - contact.p
