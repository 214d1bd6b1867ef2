"""Wheels on one axle: the creepage at which they roll freely, and the loads in balance.

Free: no torque acts on the axle. The sum of the torques of the wheels grows with the creepage xi_0, so that
its zero is bracketed; steps are those of the secant, or bisections. The loads perpendicular to the axle
follow the lateral forces from step to step. All is solved on elements four times, twice and once as large,
each time from the creepage and the tractions before; the differences tell the errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from femic.contact.frictional import FrictionalContact
from femic.contact.normal import PotentialAreaTooSmall
from femic.shifts.rolling.wheel import RollingWheel, WheelContact
from geometries.errors import Failure

TORQUE = 1e-5  # of friction times load times nominal radius: the largest torque of a free wheelset
VERTICAL = 1e-5  # of the load: the largest error of the vertical forces
LEVELS = 3  # of grids
FIRST_SLOPE = 500.0  # of the torque over friction, load and radius by the creepage: less than that at rest
WIDEST_STEP = 0.01  # of the creepage outside of a bracket
MOST_STEPS = 40


class BeyondGrid(Failure):
    """A contact comes near the end of its grid; `number` is that of the wheel."""

    def __init__(self, number: int, short: PotentialAreaTooSmall) -> None:
        super().__init__(str(short))
        self.number, self.short = number, short


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

    @property
    def states(self) -> list[FrictionalContact]:
        """The contacts with friction of the wheels."""
        return [contact.rolling.contact for contact in self.contacts]


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

    def rolled(self, loads: Sequence[float], levels: int = LEVELS) -> Rolled:
        """Return the wheelset as it rolls; the loads perpendicular to the axle [N] are a first guess.

        Raises Failure, and BeyondGrid where a contact comes near the ends of its grid.
        """
        coarser = self._coarser(loads, levels)
        if coarser is None:
            return self.found(self.at(self.first_creepage(), loads, [None] * len(loads), FIRST_SLOPE))
        loads = [contact.load for contact in coarser.contacts]
        starts = [_finer(state) for state in coarser.states]
        first = self.at(coarser.xi_0, loads, starts, coarser.slope)
        return replace(self.found(first), coarser=coarser)

    def _coarser(self, loads: Sequence[float], levels: int) -> Rolled | None:
        coarsened = self.coarsened if levels > 1 else None
        if coarsened is None:
            return None
        try:
            return coarsened.rolled(loads, levels - 1)
        except Failure:
            return None

    def first_creepage(self) -> float:
        """Return the given creepage, or that at which the wheels together would roll without slip."""
        if self.longitudinal is not None:
            return self.longitudinal
        without = [wheel.creepages(0.0).longitudinal for wheel in self.wheels]
        return -sum(without) / len(without)

    def at(
        self, xi_0: float, loads: Sequence[float], starts: Sequence[FrictionalContact | None], slope: float
    ) -> Rolled:
        """Return the contacts at a creepage under loads perpendicular to the axle [N]."""
        contacts = tuple(
            self._contact(number, xi_0, load, start)
            for number, (load, start) in enumerate(zip(loads, starts, strict=True))
        )
        nominal = sum(self.wheels[0].place.layout.nominal_radius) / 2
        unit = self.friction * self.load * nominal
        torque = sum(contact.torque for contact in contacts) / unit
        return Rolled(self.wheels, xi_0, contacts, torque, slope, unit, self.longitudinal is not None)

    def _contact(
        self, number: int, xi_0: float, load: float, start: FrictionalContact | None
    ) -> WheelContact:
        wheel = self.wheels[number]
        try:
            return wheel.contact(xi_0, load, start)
        except PotentialAreaTooSmall as short:
            raise BeyondGrid(number, short) from short
        except Failure as failure:
            along = wheel.creepages(xi_0).longitudinal
            raise Failure(f"{wheel.place.side} wheel, creepage {along:.4g}: {failure}") from failure

    def found(self, rolled: Rolled) -> Rolled:
        """Return the wheelset without a torque, or at its given creepage, with the loads in balance."""
        low, high = -np.inf, np.inf
        for _ in range(MOST_STEPS):
            free = self.longitudinal is None and abs(rolled.torque) > TORQUE
            if not free and self.balanced(rolled):
                return rolled
            if not free:
                rolled = self.step(rolled, rolled.xi_0)
                continue
            low, high = (low, rolled.xi_0) if rolled.torque > 0 else (rolled.xi_0, high)
            rolled = self.step(rolled, _next(rolled, low, high))
        raise Failure(
            f"wheelset: after {MOST_STEPS} steps a torque of {rolled.torque:.1e} of friction, load and "
            f"radius is left at a creepage of {rolled.xi_0:g}; give rolling.longitudinal"
        )

    def step(self, before: Rolled, xi_0: float) -> Rolled:
        """Return the wheelset at another creepage, from that before, with loads that follow its forces."""
        loads = [
            wheel.load_for(self.load, contact)
            for wheel, contact in zip(self.wheels, before.contacts, strict=True)
        ]
        after = self.at(xi_0, loads, before.states, before.slope)
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


def _finer(state: FrictionalContact) -> FrictionalContact:
    """Return a contact whose tractions are those on elements half as large."""
    return replace(state, p=state.p.repeat(2, axis=0).repeat(2, axis=1))
