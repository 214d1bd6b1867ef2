"""Creep-force curves of a wheel: contacts from one creepage to the next, and at prescribed forces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from femic.contact.estimates import Measured, Scale
from femic.contact.friction.kinematics import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.rolling_numbers import measured_rolling
from femic.contact.rolling import RollingContact, RollingProblem
from geometries.errors import Failure

MOST_HALVINGS = 2  # of a step of creepage that fails
ACCURACY = 1e-9  # of creepages that are searched for
AROUND_ZERO = 0.02  # forces over friction times load between which the slope at no force is taken


@dataclass(frozen=True, eq=False)
class CreepForceCurve:
    """A creep-force curve on one grid: contacts by creepage, and at certain forces."""

    contacts: Mapping[float, RollingContact]
    points: Mapping[float, Measured]  # by creepage, as contacts
    free: Measured  # the numbers of `OF_CURVE`
    equal: RollingContact  # with the force at which ICs are compared


@dataclass(frozen=True, eq=False)
class Continuation:
    """Continuation along a creep-force curve, outward from the creepage nearest 0."""

    pair: PairWithFriction
    problem: RollingProblem
    label: str

    @classmethod
    def of(cls, pair: PairWithFriction, problem: FrictionalProblem, label: str) -> "Continuation":
        """Return the continuation along the curve of a problem on its own grid."""
        return cls(pair, pair.rolling(problem), label)

    @property
    def xi(self) -> tuple[float, ...]:
        """The creepages, growing."""
        return self.pair.specification.longitudinal

    @property
    def largest(self) -> float:
        """Friction times load [N]."""
        return self.problem.problem.friction * self.pair.loads[0]

    def curve(self) -> CreepForceCurve:
        """Return the contacts at all creepages, each from its neighbour, and at prescribed forces."""
        contacts = self.contacts()
        free, equal = self.free(list(contacts.values()))
        points = {xi: self.measured(contact) for xi, contact in contacts.items()}
        return CreepForceCurve(contacts, points, free, equal)

    def free(self, contacts: Sequence[RollingContact]) -> tuple[Measured, RollingContact]:
        """Return the numbers of `OF_CURVE` from `contacts`, and the contact at which ICs are compared."""
        zero, below, above, equal = (
            self.with_force(share * self.largest, contacts)
            for share in (0.0, -AROUND_ZERO, AROUND_ZERO, self.pair.specification.equal_force)
        )
        rise = float(above.creepages.longitudinal - below.creepages.longitudinal)
        slope = 2 * AROUND_ZERO * self.largest / rise
        numbers = {
            "zero_creepage": float(zero.creepages.longitudinal),
            "slope": slope,
            "equal_creepage": float(equal.creepages.longitudinal),
        }
        saturated = abs(self.largest / slope)  # the creepage at which the slope reaches friction times load
        scales = {"creepage": Scale(saturated, saturated)}
        return Measured(numbers, scales, self.measured(zero).floors), equal

    def contacts(self) -> dict[float, RollingContact]:
        """Return the contacts by creepage, growing; without those that have no solution."""
        first = self.first()
        by_creepage = {first.creepages.longitudinal: first}
        number = self.xi.index(first.creepages.longitudinal)
        for side in (self.xi[number + 1 :], self.xi[:number][::-1]):
            before = first
            for xi in side:
                if contact := self.at_if_possible(xi, before):
                    before = by_creepage[xi] = contact
        return {xi: by_creepage[xi] for xi in sorted(by_creepage)}

    def first(self) -> RollingContact:
        """Return the contact at the creepage nearest 0 that has a solution without a neighbour's."""
        for xi in sorted(self.xi, key=abs):
            if contact := self.at_if_possible(xi, None):
                return contact
        raise Failure(f"{self.label}: no contact at any creepage; use smaller or larger elements")

    def at_if_possible(self, xi: float, before: RollingContact | None) -> RollingContact | None:
        """Return the contact at a creepage; None where it has no solution, which is reported."""
        try:
            return self.at(xi, before)
        except PotentialAreaTooSmall:
            raise
        except Failure as failure:
            self.pair.options.watch.on_stage(f"  left out: {failure}")
            return None

    def with_force(self, force: float, contacts: Sequence[RollingContact]) -> RollingContact:
        """Return the contact with a longitudinal force [N], from where the curve of `contacts` has it."""
        forces = [contact.contact.force[0] for contact in contacts]
        xi = [contact.creepages.longitudinal for contact in contacts]
        nearest = contacts[int(np.argmin(np.abs(np.array(forces) - force)))]
        start = self.at(float(np.interp(force, forces, xi)), nearest)
        try:
            return self.solve(start.creepages.longitudinal, start, force)
        except Failure:
            return self.search_force(force, start)

    def search_force(self, force: float, start: RollingContact) -> RollingContact:
        """Return the contact with a force [N] by a search over creepages; Failure where none has it."""
        by_creepage = {start.creepages.longitudinal: start}

        def beyond(xi: float) -> float:
            nearest = by_creepage[min(by_creepage, key=lambda other: abs(other - xi))]
            by_creepage[xi] = self.at(xi, nearest)
            return float(by_creepage[xi].contact.force[0]) - force

        if beyond(self.xi[0]) * beyond(self.xi[-1]) > 0:
            raise Failure(f"{self.label}: F_x = {force:g} N is beyond the curve; give further creepages")
        return by_creepage[float(brentq(beyond, self.xi[0], self.xi[-1], xtol=ACCURACY))]

    def at(self, xi: float, before: RollingContact | None, halvings: int = MOST_HALVINGS) -> RollingContact:
        """Return the contact at a creepage, from a neighbour; where that fails, in two steps of this kind."""
        try:
            return self.solve(xi, before)
        except PotentialAreaTooSmall:
            raise
        except Failure as failure:
            if before is None or halvings == 0:
                raise Failure(f"{self.label}, xi = {xi:g}: {failure}") from failure
            half_way = self.at((xi + before.creepages.longitudinal) / 2, before, halvings - 1)
            return self.at(xi, half_way, halvings - 1)

    def solve(self, xi: float, before: RollingContact | None, force: float | None = None) -> RollingContact:
        """Return the contact at a creepage, or with a longitudinal force [N] near it."""
        specification = self.pair.specification
        return self.problem.contact(
            Creepages(xi, specification.lateral, specification.spin),
            Loading(self.pair.loads[0]),
            forces={} if force is None else {"longitudinal": force},
            start=None if before is None else before.contact,
        )

    def measured(self, rolling: RollingContact) -> Measured:
        """Return the numbers of a contact, with what estimates need."""
        return measured_rolling(self.pair.on_grid, self.problem, rolling)
