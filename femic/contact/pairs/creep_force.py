"""Creep-force curves of a wheel: contacts from one creepage to the next, and at prescribed forces.

The distance of the bodies is linearised in the approach; what that does to the numbers is known from a few
contacts with the distance of the displaced body (`displaced`) and from contact without friction
(`Linearisation`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from femic.contact.estimates import CREEPAGE, Kind, Measured, Numbers, Scale, changes
from femic.contact.friction.motion import Creepages
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import (
    OF_CURVE,
    OF_FRICTIONLESS,
    OF_ROLLING,
    Quantity,
    kinds,
    measured,
    measured_rolling,
    numbers,
)
from femic.contact.rolling import RollingContact, RollingProblem
from geometries.errors import Failure
from geometries.patches import N

# --- contacts along a curve ---

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


# --- distance of the displaced body ---

OF_DISPLACED: Mapping[str, Quantity] = {
    **OF_ROLLING,
    "zero_creepage": OF_CURVE["zero_creepage"],
    "xi": Quantity("ξ", "1", "creepage of these numbers", CREEPAGE),
}
OF_OWN = "F_y", "M_x", "area"  # change by the share of p_max, besides what they do without friction
OF_SCALES = {
    "F_x": 1.0,
    "M_z": 1.0,
    "sliding_share": 1.0,
    "dissipation": 3.0,
}  # shares of it, of their scales
STEPS = 10  # largest number of contacts
TOLERANCE = 1e-4  # of the approach: of a change of the distance that is itself small


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
        of_all, normal = kinds(OF_FRICTIONLESS), operator.restricted((N,))
        try:
            linear, exact = (
                on_grid.solve(normal, Loading(load), exact=exact).normal for exact in (False, True)
            )
        except Failure:
            return cls(dict.fromkeys(of_all, np.nan), np.nan)
        fine = measured(on_grid, linear, prescribed=("load", "position"))
        away = changes(fine, of_all, numbers(on_grid, exact))
        return cls(away, away["p_max"] / fine.numbers["p_max"])

    def part(self, fine: Measured, of_all: Mapping[str, Kind]) -> dict[str, float]:
        """Return the part of the estimates of a contact with friction."""
        of_own = {name: self.share * abs(fine.numbers[name]) for name in OF_OWN}
        of_scales = {
            name: times * self.share * fine.scale(name, of_all[name]).changes
            for name, times in OF_SCALES.items()
            if name in of_all and name not in fine.exact
        }
        tangential = of_own | of_scales
        return {name: self.changes.get(name, 0.0) + tangential.get(name, 0.0) for name in of_all}

    def part_of_curve(self, fine: Measured, zero_creepage: float) -> dict[str, float]:
        """Return the part of the estimates of `OF_CURVE`, from the creepage without force as displaced."""
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


def displaced_numbers(continuation: Continuation, curve: CreepForceCurve) -> Mapping[str, float]:
    """Return the numbers of `OF_DISPLACED` at the creepage nearest 0; NaN where the grid has no such contact.

    They are NaN, too, where one of both contacts is found in a less accurate form than the other: that would
    change more than the distance does. The creepage without force is moved by the change of the force over
    the slope.
    """
    try:
        linear = continuation.at(min(continuation.xi, key=abs), curve.equal)
        exact = displaced(continuation, linear)
    except Failure:  # the patch is larger than the grid, or not found: the curve itself stands
        return dict.fromkeys(OF_DISPLACED, np.nan)
    if exact.contact.motion.depth != linear.contact.motion.depth:
        return dict.fromkeys(OF_DISPLACED, np.nan)
    change = float(exact.contact.force[0] - linear.contact.force[0])
    moved = curve.free.numbers["zero_creepage"] - change / curve.free.numbers["slope"]
    numbers = continuation.measured(exact).numbers
    return {**numbers, "zero_creepage": moved, "xi": exact.creepages.longitudinal}


def displaced(
    continuation: Continuation, contact: RollingContact, force: float | None = None
) -> RollingContact:
    """Return the contact with the distance at its own approach: a fixed point.

    It is at the same creepages, or under the same longitudinal `force` [N].
    Heights of rolling circles stay those of the linearised contact: the displacements of the same size that
    they lack along s are not known from the approach, and would make slip depend on the rigid-body discount.
    """
    on_grid, rolling = continuation.pair.on_grid, continuation.problem
    for _ in range(STEPS):
        approach = contact.contact.approach
        distance = on_grid.distance_at(approach) + approach * on_grid.cosine
        problem = replace(rolling, problem=replace(rolling.problem, distance=distance))
        contact = replace(continuation, problem=problem).solve(contact.creepages.longitudinal, contact, force)
        if abs(contact.contact.approach - approach) <= TOLERANCE * abs(approach):
            return contact
    raise Failure(f"{continuation.label}: the approach with the exact distance does not converge")
