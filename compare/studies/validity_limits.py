"""Validity limits: the load and the angle at which the error of a number with some ICs passes a tolerance.

The contact is solved at some loads on one grid, with ICs and with C; between the two loads where the error
passes the tolerance first, the load at which it does so is solved for. Errors are differences of numbers on
the same elements, of which most of the error of the elements is no part; what is left of it comes from the
same difference on elements twice and four times as large.

With friction a wheel rolls with C at two creepages: where the longitudinal force is half of friction times
load, and where it vanishes. Other ICs have forces of their own at these creepages; the force with C is
prescribed there, so that a difference at the first of them is half as large a share of friction times load
as of the force itself.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from scipy.optimize import brentq

from femic.contact.datasets import Difference, estimate_of_difference
from femic.contact.estimates import Measured, Numbers, changes, errors, floors, from_grids
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.motions.none import SolvedContact, by_ics, load_at_angle
from femic.contact.motions.rolling import Continuation
from femic.contact.operators.protocols import FullOperator, Operator
from femic.contact.pairs.grids import contact_size, grids_of, make_sizing, on_fitting_grid
from femic.contact.pairs.ics import C, normal_reference_ics
from femic.contact.pairs.pair_on_grid import PairContact, PairOnGrid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import kinds, measured, select
from femic.contact.rolling import RollingContact
from femic.contact.specification import ContactProblem
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.errors import Failure, WrongInput

LOAD_ACCURACY = 0.01  # of a load, relative: the angle goes like its third root or slower


@dataclass(frozen=True)
class Deviation:
    """The error of a number with some ICs relative to C at a load [N], and the angle of the patch with C.

    The error is a share [-], of what its law says; angles are in degrees. Estimates are those of both.
    """

    load: float
    angle: float
    angle_estimate: float
    error: float
    estimate: float


Law = Callable[[float], Deviation]  # by the load [N]
Outcome = TypeVar("Outcome")

# --- where the error of a law passes a tolerance --------------------------------------------------------


@dataclass(frozen=True)
class Crossing:
    """Where the error passes a tolerance first, as the load grows.

    `at` is None where it stays within the tolerance up to the largest load, whose deviation is `end`;
    `largest` is the largest of the deviations at the loads that were solved first. `estimate` is the
    estimated error of the angle at the crossing [deg]. `before`: the tolerance is passed at the smallest load
    already. `stays`: the error is beyond the tolerance at all larger loads.
    """

    tolerance: float
    at: Deviation | None
    estimate: float
    before: bool
    stays: bool
    largest: Deviation
    end: Deviation


def find_crossing(
    law: Law, loads: Sequence[float], tolerance: float, accuracy: float = LOAD_ACCURACY
) -> Crossing:
    """Return where the error of a law passes a tolerance first; `loads` [N] grow.

    `accuracy` is that of the load, relative. Raises WrongInput for less than two loads.
    """
    if len(loads) < 2 or np.any(np.diff(loads) <= 0):
        raise WrongInput(f"loads = {list(loads)}: give two or more that grow [N]")
    ladder = [law(load) for load in loads]
    beyond = [abs(deviation.error) > tolerance for deviation in ladder]
    largest, end = max(ladder, key=lambda deviation: abs(deviation.error)), ladder[-1]
    if not any(beyond):
        return Crossing(tolerance, None, np.nan, before=False, stays=False, largest=largest, end=end)
    first = beyond.index(True)
    low, high = ladder[max(first - 1, 0)], ladder[max(first, 1)]
    at = ladder[0]
    if first:
        known = {float(np.log(one.load)): one for one in (low, high)}

        def excess(logarithm: float) -> float:
            return abs((known.get(logarithm) or law(float(np.exp(logarithm)))).error) - tolerance

        root = float(brentq(excess, *known, xtol=accuracy))
        at = known.get(root) or law(float(np.exp(root)))
    tiny = np.finfo(float).tiny
    slope = abs(abs(high.error) - abs(low.error)) / max(abs(high.angle - low.angle), tiny)
    estimate = at.estimate / max(slope, tiny) + at.angle_estimate
    if first and abs(at.error) != tolerance:
        # The angle bends over the logarithm of the load: of the slopes to both neighbours the steeper one is
        # no smaller than that at the crossing. A neighbour nearer than the accuracy tells none, as readings
        # of angles have errors.
        slopes = [
            abs(above.angle - below.angle) / span
            for below, above in ((low, high), (low, at), (at, high))
            if (span := float(np.log(above.load / below.load))) > accuracy or (below, above) == (low, high)
        ]
        estimate += max(slopes) * accuracy
    return Crossing(
        tolerance, at, estimate, before=first == 0, stays=all(beyond[first:]), largest=largest, end=end
    )


# --- without friction -----------------------------------------------------------------------------------


NUMBERS = ("p_max", "a", "b", "approach")  # whose errors are sought without friction


@dataclass(frozen=True, eq=False)
class PairDeviations:
    """Frictionless contacts of two bodies on one grid with some ICs and with C, solved when asked for."""

    on_grid: PairOnGrid
    operators: Mapping[str, Operator]  # by name, C among them
    perturbed: Operator | None = None  # C plus its estimated error
    _contacts: dict[tuple[float, str], SolvedContact] = field(default_factory=dict)

    def law(self, number: str, name: str) -> Law:
        """Return the error of a number of `NUMBERS` with the ICs of a name over that with C, by the load."""
        return lambda load: Deviation(load, *self.angle(load), *self.error(number, name, load))

    def contact(self, load: float, name: str) -> SolvedContact:
        """Return the contact under a load [N] with some ICs. Raises as `PairOnGrid.solve_in_place`."""
        if (load, name) not in self._contacts:
            loading = Loading(load)

            def solved(operator: Operator) -> PairContact:
                return PairContact(self.on_grid, self.on_grid.solve_in_place(operator, loading))

            perturbed = solved(self.perturbed) if name == C and self.perturbed is not None else None
            self._contacts[load, name] = SolvedContact(loading, name, solved(self.operators[name]), perturbed)
        return self._contacts[load, name]

    def angle(self, load: float) -> tuple[float, float]:
        """Return the angle of the patch with C at a load [N] and its estimated error [deg]."""
        contact = self.contact(load, C)
        return contact.measured.numbers["angle"], contact.estimated_errors()["angle"]

    def error(self, number: str, name: str, load: float) -> tuple[float, float]:
        """Return the error of a number with the ICs of a name over that with C, and its estimated error."""
        contacts, error = by_ics([self.contact(load, ics) for ics in (name, C)]), relative_error(number)
        return float(error(contacts)), float(estimate_of_difference(contacts, error))


def relative_error(number: str) -> Difference:
    """Return how the error of a number with the first ICs over that with the second follows from contacts."""
    return lambda contacts: contacts[number].isel(ics=0) / contacts[number].isel(ics=1) - 1


def solve_deviations(
    problem: ContactProblem,
    loads: Sequence[float],
    names: Sequence[str],
    use: Callable[[PairDeviations], Outcome],
    options: RunOptions = DEFAULT,
) -> Outcome:
    """Return what `use` makes of the deviations of some ICs on the grid of the largest of some loads [N].

    The grid is made longer where a contact needs it. Raises Failure and NotConverged as C and contacts do.
    """
    specification = replace(problem.specification, loads=(max(loads),), approaches=(), ics=(*names, C))
    problem = replace(problem, specification=specification)
    ((grid, _),) = grids_of(problem)

    def on_grid(pair: PairOnGrid) -> Outcome:
        reference = normal_reference_ics(problem, pair, options)
        operators = {name: pair.operator(name) for name in names} | {C: reference.operator}
        return use(PairDeviations(pair, operators, reference.perturbed))

    return on_fitting_grid(problem, grid, on_grid)


LEAST, MOST = 1.0, 1e9  # loads [N] between which the one with an angle is sought
BEYOND = 180.0  # degrees, of patches that reach the end of a contour: more than any other
ANGLE_ACCURACY = 0.05  # of the load that has an angle on the grid, relative


@dataclass(frozen=True)
class Ladder:
    """Which loads are solved first: how many, from which angle [deg] to which, the largest load [N]."""

    smallest_angle: float
    largest_angle: float
    largest_load: float = MOST
    steps: int = 9

    def loads(self, problem: ContactProblem) -> list[float]:
        """Return loads of a problem in equal ratios, by the angles of contact with B-hat.

        Raises Failure where the patch turns by more than an angle under any load.
        """
        bodies = make_sizing(problem).bodies

        def angle(load: float) -> float:
            try:
                size = contact_size(bodies, Loading(load))
            except Failure:  # it reaches the end of a contour
                return BEYOND
            ends = bodies.undeformed.lower.contour.inclination(np.array(size.s))
            return float(np.degrees(np.ptp(ends)))

        def load_at(degrees: float, most: float) -> float:
            if angle(most) <= degrees:
                return most
            return load_at_angle(angle, degrees, (LEAST, most), ANGLE_ACCURACY, "the patch with B-hat")

        largest = load_at(self.largest_angle, self.largest_load)
        smallest = load_at(self.smallest_angle, largest / 2)
        return [float(load) for load in np.geomspace(smallest, largest, self.steps)]


# --- rolling --------------------------------------------------------------------------------------------


PERTURBED = "C plus its estimated error"
OF_PATCH = select("p_max", "angle")  # numbers of the patch with C: the angle, and what it follows
HALF = 0.5  # of friction times load: the force with C at the first creepage
ROLLING_NUMBERS = {
    "half": "error of F_x where F_x with C is half of friction times load, relative to friction times load",
    "free": "error of F_x at the creepage where F_x with C is zero, relative to friction times load",
    "sliding": "sliding part of the patch where F_x with C is half of friction times load",
}


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """What is compared at a load with some ICs: `ROLLING_NUMBERS`, and the contacts they are of."""

    numbers: Numbers
    contacts: tuple[RollingContact, RollingContact]  # with half of friction times load by C, and freely

    @property
    def creepages(self) -> tuple[float, ...]:
        """Longitudinal creepages of both contacts."""
        return tuple(float(contact.creepages.longitudinal) for contact in self.contacts)


@dataclass(frozen=True, eq=False)
class RollingDeviations:
    """Rolling of a pair on one grid with some ICs and with C at a coefficient of friction, when asked for.

    With C plus its estimated error rolling is solved at the loads of `sampled` [N] alone; the change is
    linear in the logarithm of the load between them.
    """

    pair: PairWithFriction
    operators: Mapping[str, FullOperator]  # by name, C among them
    friction: float
    perturbed: FullOperator | None = None
    sampled: tuple[float, ...] = ()
    _problems: dict[tuple[str, int], FrictionalProblem] = field(default_factory=dict)
    _solved: dict[tuple[float, str, int, bool], OperatingPoint] = field(default_factory=dict)
    _changes: dict[tuple[str, str], list[float]] = field(default_factory=dict)

    def law(self, number: str, name: str) -> Law:
        """Return the difference of a number of `ROLLING_NUMBERS` with some ICs to C, by the load [N]."""

        def deviation(load: float) -> Deviation:
            by_level = [self.difference(number, name, load, level) for level in self._levels]
            estimate = self.change(number, name, load)
            if number == "sliding":  # elements may be in another state, with both ICs
                contacts = (self.solved(load, ics).contacts[0].contact for ics in (name, C))
                estimate += sum(floors(contact.slip_state)["sliding"] for contact in contacts)
            if len(by_level) > 1:
                estimate += from_grids(*by_level)
            return Deviation(load, *self.angle(load), by_level[0], estimate)

        return deviation

    def difference(
        self, number: str, name: str, load: float, level: int = 0, *, changed: bool = False
    ) -> float:
        """Return the difference of a number to C; `changed`: to C plus its estimated error."""
        ours = self.solved(load, name, level, changed=changed)
        theirs = self.solved(load, C, level, changed=changed)
        return ours.numbers[number] - theirs.numbers[number]

    def change(self, number: str, name: str, load: float) -> float:
        """Return by how much a difference to C changes with the estimated error of C.

        The number `angle` of the ICs C is the angle of the patch [deg].
        """
        if self.perturbed is None:
            return 0.0
        if (name, number) not in self._changes:
            self._changes[name, number] = [
                changes(
                    self._measured(sampled),
                    kinds(OF_PATCH),
                    self._measured(sampled, changed=True).numbers,
                )["angle"]
                if number == "angle"
                else abs(
                    self.difference(number, name, sampled, changed=True)
                    - self.difference(number, name, sampled)
                )
                for sampled in self.sampled
            ]
        return float(np.interp(np.log(load), np.log(self.sampled), self._changes[name, number]))

    def angle(self, load: float) -> tuple[float, float]:
        """Return the angle of the patch with C at the first creepage and its estimated error [deg]."""
        fine, *larger = (self._measured(load, level) for level in self._levels)
        by_elements = errors(kinds(OF_PATCH), fine, larger)["angle"]
        return fine.numbers["angle"], by_elements + self.change("angle", C, load)

    def _measured(self, load: float, level: int = 0, *, changed: bool = False) -> Measured:
        """Return the numbers of the contact with C at the first creepage."""
        contact = self.solved(load, C, level, changed=changed).contacts[0].contact
        return measured(self.pair.on_grid, contact, OF_PATCH)

    def solved(self, load: float, name: str, level: int = 0, *, changed: bool = False) -> OperatingPoint:
        """Return what is compared, on elements 2^level times as large. Raises Failure as `Continuation`."""
        key = load, name, level, changed
        if key not in self._solved:
            specification = replace(self.pair.problem.specification, loads=(load,))
            pair = replace(self.pair, problem=replace(self.pair.problem, specification=specification))
            problem = self._problem(PERTURBED if changed and name == C else name, level)
            label = f"{load:g} N, friction {self.friction:g}, {name}"
            along = Continuation(pair, pair.rolling(problem), label)
            if name == C:
                still = along.at(0.0, None)
                free = along.with_force(0.0, [still])
                known = sorted([still, free], key=lambda contact: contact.contact.force[0])
                half = along.with_force(HALF * along.largest, known)
            else:
                reference = self.solved(load, C, level, changed=changed).contacts
                half, free = (along.at(contact.creepages.longitudinal, contact) for contact in reference)
            numbers = {
                "half": float(half.contact.force[0]) / along.largest,
                "free": float(free.contact.force[0]) / along.largest,
                "sliding": half.contact.sliding_share,
            }
            self._solved[key] = OperatingPoint(numbers, (half, free))
        return self._solved[key]

    @property
    def _levels(self) -> range:
        return range(2 if self._problem(C, 0).has_coarser else 1)

    def _problem(self, name: str, level: int) -> FrictionalProblem:
        if (name, level) not in self._problems:
            if level:
                self._problems[name, level] = self._problem(name, level - 1).coarsened
            else:
                operator = self.perturbed if name == PERTURBED else self.operators[name]
                assert operator is not None
                self._problems[name, level] = self.pair.frictional(operator, self.friction)
        return self._problems[name, level]
