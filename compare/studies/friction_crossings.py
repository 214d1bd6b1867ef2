"""Errors of rolling forces and of sliding over the load: laws whose crossings can be solved for.

At each load a wheel rolls with C at two creepages: where the longitudinal force is half of friction times
load, and where it vanishes. Other ICs have forces of their own at these creepages; the force with C is
prescribed there, so that a difference at the first of them is half as large a share of friction times load
as of the force itself.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from compare.studies.contact_crossings import QUANTITIES, Deviation, Law
from femic.contact.estimates import Measured, Numbers, changes, errors, floors, from_grids
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.motions.rolling import Continuation
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.ics import C
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import kinds, measured
from femic.contact.rolling import RollingContact

HALF = 0.5  # of friction times load: the force with C at the first creepage
NUMBERS = {
    "half": "F_x where C has half of friction times load, as a share of friction times load",
    "free": "F_x where C rolls freely, as a share of friction times load",
    "sliding": "sliding share of the patch where F_x with C is half of friction times load",
}


@dataclass(frozen=True, eq=False)
class OperatingPoint:
    """What is compared at a load with some ICs: the numbers of `NUMBERS`, and the contacts they are of."""

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
        """Return the difference of a number of `NUMBERS` with the ICs of a name to C, by the load [N]."""

        def deviation(load: float) -> Deviation:
            by_level = [self.difference(number, name, load, level) for level in range(self._levels)]
            estimate = self.change(number, name, load) + self.floor(number, name, load)
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
        """Return by how much a difference to C changes with the estimated error of C."""

        def change(sampled: float) -> float:
            given, changed = (self.difference(number, name, sampled, changed=of) for of in (False, True))
            return abs(changed - given)

        return self._interpolated(load, (name, number), change)

    def _interpolated(self, load: float, key: tuple[str, str], change: Callable[[float], float]) -> float:
        """Return a change with the estimated error of C at a load [N], by those at the sampled loads."""
        if self.perturbed is None:
            return 0.0
        if key not in self._changes:
            self._changes[key] = [change(sampled) for sampled in self.sampled]
        return float(np.interp(np.log(load), np.log(self.sampled), self._changes[key]))

    def floor(self, number: str, name: str, load: float) -> float:
        """Return what elements that could be in another state may change of a sliding share, of both ICs."""
        if number != "sliding":
            return 0.0
        contacts = (self.solved(load, ics).contacts[0].contact for ics in (name, C))
        return sum(floors(contact.slip_state)["sliding"] for contact in contacts)

    def angle(self, load: float) -> tuple[float, float]:
        """Return the angle of the patch with C at the first creepage and its estimated error [deg]."""
        fine, *larger = (self._measured(load, level) for level in range(self._levels))
        of_elements = errors(kinds(QUANTITIES), fine, larger)["angle"]
        return fine.numbers["angle"], of_elements + self.change_of_angle(load)

    def change_of_angle(self, load: float) -> float:
        """Return by how much the angle with C changes with the estimated error of C [deg]."""
        return self._interpolated(load, (C, "angle"), self._changed_angle)

    def _changed_angle(self, load: float) -> float:
        given, changed = self._measured(load), self._measured(load, changed=True)
        return changes(given, kinds(QUANTITIES), changed.numbers)["angle"]

    def _measured(self, load: float, level: int = 0, *, changed: bool = False) -> Measured:
        """Return the numbers of the contact with C at the first creepage."""
        contact = self.solved(load, C, level, changed=changed).contacts[0].contact
        return measured(self.pair.on_grid, contact, QUANTITIES)

    def solved(self, load: float, name: str, level: int = 0, *, changed: bool = False) -> OperatingPoint:
        """Return what is compared, on elements 2^level times as large. Raises Failure as `Continuation`."""
        key = load, name, level, changed
        if key not in self._solved:
            along = self._along(load, "changed" if changed and name == C else name, level)
            if name == C:
                contacts = _with_forces(along)
            else:
                of_c = self.solved(load, C, level, changed=changed)
                half, free = (along.at(contact.creepages.longitudinal, contact) for contact in of_c.contacts)
                contacts = half, free
            self._solved[key] = OperatingPoint(_numbers(along, contacts), contacts)
        return self._solved[key]

    @property
    def _levels(self) -> int:
        return 2 if self._problem(C, 0).has_coarser else 1

    def _along(self, load: float, name: str, level: int) -> Continuation:
        problem = self.pair.problem
        specification = replace(problem.specification, loads=(load,))
        pair = replace(self.pair, problem=replace(problem, specification=specification))
        label = f"{load:g} N, friction {self.friction:g}, {name}"
        return Continuation(pair, pair.rolling(self._problem(name, level)), label)

    def _problem(self, name: str, level: int) -> FrictionalProblem:
        if (name, level) not in self._problems:
            if level:
                self._problems[name, level] = self._problem(name, level - 1).coarsened
            else:
                operator = self.perturbed if name == "changed" else self.operators[name]
                assert operator is not None
                self._problems[name, level] = self.pair.frictional(operator, self.friction)
        return self._problems[name, level]


def _with_forces(along: Continuation) -> tuple[RollingContact, RollingContact]:
    """Return the contacts with half of friction times load, and without longitudinal force."""
    still = along.at(0.0, None)
    free = along.with_force(0.0, [still])
    known = sorted([still, free], key=lambda contact: contact.contact.force[0])
    return along.with_force(HALF * along.largest, known), free


def _numbers(along: Continuation, contacts: tuple[RollingContact, RollingContact]) -> dict[str, float]:
    half, free = contacts
    return {
        "half": float(half.contact.force[0]) / along.largest,
        "free": float(free.contact.force[0]) / along.largest,
        "sliding": half.contact.sliding_share,
    }
