"""Wheels on one axle: the creepage at which they roll freely, and the vertical forces in balance.

Free: no torque acts on the axle. The sum of the torques of the wheels grows with the creepage xi_0, so that
its zero is bracketed; steps are those of the secant, or bisections. The approaches of the wheels follow their
vertical forces from step to step. All is solved on elements four times, twice and once as large, each time
from the creepage, the approaches and the tractions before, with the distance of wheels that are displaced by
these approaches; the differences tell the errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from femic.contact.normal import PotentialAreaTooSmall
from femic.shifts.rolling.wheel import PatchBeyondGrid, RollingWheel, WheelContact
from geometries.errors import Failure

TORQUE = 1e-5  # of friction times load times nominal radius: the largest torque of a free wheelset
VERTICAL = 1e-5  # of the load: the largest error of the vertical forces
LEVELS = 3  # of grids
FIRST_SLOPE = 500.0  # of the torque over friction, load and radius by the creepage: less than that at rest
WIDEST_STEP = 0.01  # of the creepage outside of a bracket
MOST_STEPS = 80


class BeyondGrid(Failure):
    """A patch comes near the end of its grid; `number` is that of the wheel, `grid` that of the patch."""

    def __init__(self, number: int, grid: int, short: PotentialAreaTooSmall) -> None:
        super().__init__(str(short))
        self.number, self.grid, self.short = number, grid, short


@dataclass(frozen=True, eq=False)
class Rolled:
    """The wheels of an axle at a creepage of the wheelset.

    `torque` is over friction, load and nominal radius, `slope` its derivative by the creepage, as far as
    known. `coarser` is the same on elements twice as large, None where it was not found.
    """

    wheels: tuple[RollingWheel, ...]
    xi_0: float
    contacts: tuple[WheelContact, ...]
    torque: float
    slope: float
    unit: float  # friction times load times nominal radius [N mm]
    given: bool = False  # the creepage
    coarser: "Rolled | None" = None

    @property
    def torque_slope(self) -> float:
        """Derivative of the torque by the creepage [N mm]."""
        return self.slope * self.unit


@dataclass(frozen=True, eq=False)
class RollingWheelset:
    """The wheels of an axle under a vertical load each [N]; `longitudinal` is xi_0, None where it is free."""

    wheels: tuple[RollingWheel, ...]
    load: float
    friction: float
    longitudinal: float | None

    @property
    def coarsened(self) -> "RollingWheelset | None":
        """The wheelset on elements twice as large, None where a wheel has none."""
        coarsened = [wheel.coarsened for wheel in self.wheels]
        wheels = tuple(wheel for wheel in coarsened if wheel is not None)
        return replace(self, wheels=wheels) if len(wheels) == len(self.wheels) else None

    def rolled(self, levels: int = LEVELS) -> Rolled:
        """Return the wheelset as it rolls.

        Raises Failure, and BeyondGrid where a patch comes near the ends of its grid.
        """
        coarser = self._coarser(levels)
        if coarser is not None:
            approaches = [contact.approach for contact in coarser.contacts]
            starts = [contact.finer for contact in coarser.contacts]
            own = self.linearised_about(approaches)
            found = own.found(own.at(coarser.xi_0, approaches, starts, coarser.slope))
            return replace(found, coarser=coarser)
        approaches = [wheel.about for wheel in self.wheels]
        first = self.found(self.at(self.first_creepage(), approaches, [None] * len(approaches), FIRST_SLOPE))
        approaches = [contact.approach for contact in first.contacts]
        again = self.linearised_about(approaches)
        return again.found(again.at(first.xi_0, approaches, first.contacts, first.slope))

    def linearised_about(self, approaches: Sequence[float]) -> "RollingWheelset":
        """Return the wheelset with the distances of wheels that are displaced by approaches [mm]."""
        pairs = zip(self.wheels, approaches, strict=True)
        return replace(self, wheels=tuple(wheel.linearised_about(approach) for wheel, approach in pairs))

    def _coarser(self, levels: int) -> Rolled | None:
        coarsened = self.coarsened if levels > 1 else None
        if coarsened is None:
            return None
        try:
            return coarsened.rolled(levels - 1)
        except Failure:
            return None

    def first_creepage(self) -> float:
        """Return the given creepage, or that at which the wheels together would roll without slip."""
        if self.longitudinal is not None:
            return self.longitudinal
        without = [wheel.creepages(0.0).longitudinal for wheel in self.wheels]
        return -sum(without) / len(without)

    def at(
        self, xi_0: float, approaches: Sequence[float], starts: Sequence[WheelContact | None], slope: float
    ) -> Rolled:
        """Return the contacts at a creepage under approaches [mm]."""
        contacts = tuple(
            self._contact(number, xi_0, approach, start)
            for number, (approach, start) in enumerate(zip(approaches, starts, strict=True))
        )
        unit = self.friction * self.load * self.wheels[0].nominal_radius
        torque = sum(contact.torque for contact in contacts) / unit
        return Rolled(self.wheels, xi_0, contacts, torque, slope, unit, self.longitudinal is not None)

    def _contact(self, number: int, xi_0: float, approach: float, start: WheelContact | None) -> WheelContact:
        wheel = self.wheels[number]
        try:
            return wheel.contact(xi_0, approach, start)
        except PatchBeyondGrid as beyond:
            raise BeyondGrid(number, beyond.number, beyond.short) from beyond
        except Failure as failure:
            along = wheel.creepages(xi_0).longitudinal
            raise Failure(f"{wheel.place.side} wheel, creepage {along:.4g}: {failure}") from failure

    def found(self, rolled: Rolled) -> Rolled:
        """Return the wheelset without a torque, or at its given creepage, with the loads in balance."""
        low, high = -np.inf, np.inf
        for _ in range(MOST_STEPS):
            free = self.longitudinal is None and abs(rolled.torque) > TORQUE
            if not self.balanced(rolled):  # only then the sign of the torque tells on which side its zero is
                rolled = self.step(rolled, rolled.xi_0)
                continue
            if not free:
                return rolled
            low, high = (low, rolled.xi_0) if rolled.torque > 0 else (rolled.xi_0, high)
            rolled = self.step(rolled, _next(rolled, low, high))
        raise Failure(
            f"wheelset: after {MOST_STEPS} steps a torque of {rolled.torque:.1e} of friction, load and "
            f"radius is left at a creepage of {rolled.xi_0:g}; give rolling.longitudinal"
        )

    def step(self, before: Rolled, xi_0: float) -> Rolled:
        """Return the wheelset at another creepage, with approaches that follow the forces before."""
        approaches = [
            wheel.approach_for(self.load, contact)
            for wheel, contact in zip(self.wheels, before.contacts, strict=True)
        ]
        after = self.at(xi_0, approaches, before.contacts, before.slope)
        if xi_0 == before.xi_0:
            return after
        slope = (after.torque - before.torque) / (xi_0 - before.xi_0)
        return replace(after, slope=slope) if slope > 0 else after

    def balanced(self, rolled: Rolled) -> bool:
        """Whether the vertical forces are the load."""
        return all(abs(contact.vertical / self.load - 1) <= VERTICAL for contact in rolled.contacts)


def _next(rolled: Rolled, low: float, high: float) -> float:
    """Return the next creepage: by the secant within the bracket, else its middle, or a step outwards."""
    step = float(np.clip(-rolled.torque / rolled.slope, -WIDEST_STEP, WIDEST_STEP))
    if low < rolled.xi_0 + step < high:
        return rolled.xi_0 + step
    return (low + high) / 2
