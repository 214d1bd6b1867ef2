"""A creep-force curve by some ICs on one grid: contacts along it, and those at prescribed forces."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from compare.friction.bodies import Solver
from compare.friction.quantities import OF_ROLLING, measured
from femic.contact.estimates import Measured, Scale
from femic.contact.friction.kinematics import Creepages, Rolling
from femic.contact.frictional import FrictionalProblem, Pressing
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.rolling import RollingContact, RollingProblem
from geometries.errors import Failure

MOST_HALVINGS = 2  # of a step of creepage that fails
ACCURACY = 1e-9  # of creepages that are searched for
AROUND_ZERO = 0.02  # forces over friction times load between which the slope at no force is taken


@dataclass(frozen=True, eq=False)
class Curve:
    """A creep-force curve on one grid: what is found at creepages, and at certain forces."""

    contacts: Mapping[float, RollingContact]
    points: Mapping[float, Measured]  # by creepage, as contacts
    free: Measured  # what `OF_FREE` names
    equal: RollingContact  # with the force at which ICs are compared


@dataclass(frozen=True, eq=False)
class Path:
    """The way along a creep-force curve, outward from the creepage nearest 0."""

    solver: Solver
    problem: RollingProblem
    label: str

    @classmethod
    def of(cls, solver: Solver, problem: FrictionalProblem, label: str) -> "Path":
        """The way along the curve of a problem on its own grid."""
        bodies, placed = solver.scene.bodies, replace(solver.placed, grid=problem.grid)
        contour, radius = bodies["lower"].contour, bodies["upper"].rolling_radius
        strips = placed.grid.strips
        rolling = Rolling(contour, radius, placed.x, strips, placed.undeformed.upper_height(strips))
        return cls(solver, RollingProblem(problem, rolling), label)

    @property
    def xi(self) -> tuple[float, ...]:
        """The creepages, growing."""
        return self.solver.wanted.longitudinal

    @property
    def largest(self) -> float:
        """Friction times load [N]."""
        return self.problem.problem.friction * self.solver.scene.contact.loads[0]

    def curve(self) -> Curve:
        """The contacts at all creepages, each from its neighbour, and those at prescribed forces."""
        contacts = self.contacts()
        free, equal = self.free(list(contacts.values()))
        return Curve(contacts, {xi: self.measured(one) for xi, one in contacts.items()}, free, equal)

    def free(self, contacts: Sequence[RollingContact]) -> tuple[Measured, RollingContact]:
        """What `OF_FREE` names, near a curve of `contacts`, and the contact at which ICs are compared."""
        zero, below, above, equal = (
            self.with_force(share * self.largest, contacts)
            for share in (0.0, -AROUND_ZERO, AROUND_ZERO, self.solver.wanted.equal_force)
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
        """The contacts by creepage, growing; without those that have no solution."""
        first = self.first()
        found = {first.creepages.longitudinal: first}
        number = self.xi.index(first.creepages.longitudinal)
        for way in (self.xi[number + 1 :], self.xi[:number][::-1]):
            before = first
            for xi in way:
                if contact := self.tried(xi, before):
                    before = found[xi] = contact
        return {xi: found[xi] for xi in sorted(found)}

    def first(self) -> RollingContact:
        """The contact at the creepage nearest 0 that has a solution without a neighbour's."""
        for xi in sorted(self.xi, key=abs):
            if contact := self.tried(xi, None):
                return contact
        raise Failure(f"{self.label}: no contact at any creepage; use smaller or larger elements")

    def tried(self, xi: float, before: RollingContact | None) -> RollingContact | None:
        """The contact at a creepage; None where it has no solution, which is said."""
        try:
            return self.at(xi, before)
        except PotentialAreaTooSmall:
            raise
        except Failure as failure:
            self.solver.options.watch.on_stage(f"  left out: {failure}")
            return None

    def with_force(self, force: float, contacts: Sequence[RollingContact]) -> RollingContact:
        """The contact with a longitudinal force [N], near that which the curve of `contacts` says."""
        forces = [contact.contact.force[0] for contact in contacts]
        xi = [contact.creepages.longitudinal for contact in contacts]
        nearest = contacts[int(np.argmin(np.abs(np.array(forces) - force)))]
        begun = self.at(float(np.interp(force, forces, xi)), nearest)
        try:
            return self.solved(begun.creepages.longitudinal, begun, force)
        except Failure:
            return self.searched(force, begun)

    def searched(self, force: float, begun: RollingContact) -> RollingContact:
        """The same by a search over creepages; raises Failure where the curve does not reach the force."""
        found = {begun.creepages.longitudinal: begun}

        def beyond(xi: float) -> float:
            nearest = found[min(found, key=lambda other: abs(other - xi))]
            found[xi] = self.at(xi, nearest)
            return float(found[xi].contact.force[0]) - force

        if beyond(self.xi[0]) * beyond(self.xi[-1]) > 0:
            raise Failure(f"{self.label}: F_x = {force:g} N is beyond the curve; give further creepages")
        return found[float(brentq(beyond, self.xi[0], self.xi[-1], xtol=ACCURACY))]

    def at(self, xi: float, before: RollingContact | None, halvings: int = MOST_HALVINGS) -> RollingContact:
        """The contact at a creepage, from a neighbour; where that fails in two steps, each likewise."""
        try:
            return self.solved(xi, before)
        except PotentialAreaTooSmall:
            raise
        except Failure as failure:
            if before is None or halvings == 0:
                raise Failure(f"{self.label}, xi = {xi:g}: {failure}") from failure
            half_way = self.at((xi + before.creepages.longitudinal) / 2, before, halvings - 1)
            return self.at(xi, half_way, halvings - 1)

    def solved(self, xi: float, before: RollingContact | None, force: float | None = None) -> RollingContact:
        """The contact at a creepage, or with a longitudinal force [N] near it."""
        wanted = self.solver.wanted
        return self.problem.contact(
            Creepages(xi, wanted.lateral, wanted.spin),
            Pressing(load=self.solver.scene.contact.loads[0]),
            forces={} if force is None else {"longitudinal": force},
            start=None if before is None else before.contact,
        )

    def measured(self, rolling: RollingContact) -> Measured:
        """The numbers of a contact, with what estimates need."""
        return measured(OF_ROLLING, self.solver.placed, rolling.contact)
