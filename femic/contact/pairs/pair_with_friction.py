"""Two bodies on a grid with friction: ICs by name, the contact problem with each, and what estimates need.

For estimates of errors a motion is solved again: on larger elements, and with ICs plus their estimated
errors. What the distance of the bodies, which is linearised in the approach, does to the numbers is known
from contact without friction (`Linearisation`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypeVar

import numpy as np

from femic.contact.estimates import Kind, Measured, Numbers, changes
from femic.contact.friction.motion import Pairs, RollingKinematics, friction_factors
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.ics import C, GivenICs, ReferenceICs, approximation, full_reference_ics
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import OF_FRICTIONLESS, kinds, measured, numbers
from femic.contact.rolling import RollingProblem
from femic.contact.specification import ContactProblem, FrictionSpecification
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.errors import Failure, WrongInput
from geometries.patches import N

# --- bodies and contact problems ---


@dataclass(frozen=True, eq=False)
class PairWithFriction:
    """Two bodies on a grid, and ICs of the caller by name; raises WrongInput without friction.

    `wheel_rolls`: the rail sees the displacements of the wheel as it rolls. `femic.contact.motions` knows
    which motions have this: `pair_in_motion`.
    """

    problem: ContactProblem
    on_grid: PairOnGrid
    wheel_rolls: bool
    options: RunOptions = DEFAULT
    given: Mapping[str, GivenICs] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.problem.specification.friction is None:
            raise WrongInput(f"{self.problem.name}: without friction: give a specification of it")

    @cached_property
    def reference(self) -> ReferenceICs:
        """C on the grid, computed when it is needed for the first time."""
        return full_reference_ics(self.problem, self.on_grid, self.options, wheel_rolls=self.wheel_rolls)

    @property
    def specification(self) -> FrictionSpecification:
        """The specification of friction and motion."""
        assert self.problem.specification.friction is not None
        return self.problem.specification.friction

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


# --- solved again for estimates ---

Solution = TypeVar("Solution")
Solve = Callable[[PairWithFriction, FrictionalProblem, str], Solution]  # the last is a label for messages


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
    for elements in ("larger elements", "still larger elements"):
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


# --- distance of the displaced body ---

OWN_SHARES = "F_y", "M_x", "area"  # change by the share of p_max, besides what they do without friction
SCALE_SHARES = {"F_x": 1.0, "M_z": 1.0, "sliding_share": 1.0, "dissipation": 3.0}  # of it, of their scales


@dataclass(frozen=True)
class Linearisation:
    """What the linearised distance does to a contact: to that without friction under the same load.

    `changes` are those of `OF_FRICTIONLESS`, `share` is that of p_max. Tangential tractions, which follow the
    size of the patch, are taken to change by this share, and their work, which follows the slip by spin on a
    wider patch, too, by three times as much (docs/theory/errors.md). NaN where the displaced bodies have no
    contact on the grid.
    """

    changes: Numbers
    share: float

    @classmethod
    def measure(cls, on_grid: PairOnGrid, operator: FullOperator, load: float) -> "Linearisation":
        """Return what it does with some ICs under a load [N]."""
        normal = operator.restricted((N,))
        try:
            linear, exact = (
                on_grid.solve(normal, Loading(load), exact=exact).normal for exact in (False, True)
            )
        except Failure:
            return cls(dict.fromkeys(OF_FRICTIONLESS, np.nan), np.nan)
        fine = measured(on_grid, linear, prescribed=("load", "position"))
        away = changes(fine, kinds(OF_FRICTIONLESS), numbers(on_grid, exact))
        return cls(away, away["p_max"] / fine.numbers["p_max"])

    def part(self, fine: Measured, error_kinds: Mapping[str, Kind]) -> dict[str, float]:
        """Return the part of the estimates of a contact with friction."""
        tangential = {name: self.share * abs(fine.numbers[name]) for name in OWN_SHARES} | {
            name: times * self.share * fine.scale(name, error_kinds[name]).changes
            for name, times in SCALE_SHARES.items()
            if name in error_kinds and name not in fine.exact
        }
        return {name: self.changes.get(name, 0.0) + tangential.get(name, 0.0) for name in error_kinds}

    def part_of_curve(self, fine: Measured, zero_creepage: float) -> dict[str, float]:
        """Return the part of the estimates of a curve, from its creepage without force as displaced."""
        free = fine.numbers
        moved = abs(zero_creepage - free["zero_creepage"])
        if not np.isfinite(moved):
            moved = self.share * fine.scales["creepage"].changes
        apart = abs(free["equal_creepage"] - free["zero_creepage"])
        return {
            "zero_creepage": moved,
            "slope": self.share * abs(free["slope"]),
            "equal_creepage": moved + self.share * apart,
        }
