"""The numbers of a rolling wheelset: creepages, creep forces in axes of the track, work of friction.

Their errors are estimated from elements twice and four times as large, on which the wheelset has found a
creepage of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from femic.contact import estimates
from femic.contact.estimates import Kind, Measured, changes, errors, from_grids
from femic.contact.pairs.quantities import OF_ROLLING, kinds, measured
from femic.contact.pairs.rolling_numbers import measured_rolling
from femic.shifts.rolling.wheel import RollingWheel, WheelContact
from femic.shifts.rolling.wheelset import Rolled
from geometries.patches import N

OF_WHEEL = {  # by name: unit and meaning
    "xi": ("1", "longitudinal creepage of the touching point, positive where the wheel is driven"),
    "F_x": ("N", "longitudinal force on the wheel, in the rolling direction"),
    "F_y": ("N", "lateral force on the wheel with friction, positive towards the middle of the track"),
    "M_z": ("N mm", "moment on the wheel about the touching point's vertical, turning its front outwards"),
    "work": ("N", "work of friction per unit of rolled distance (T-gamma), J/m"),
    "sliding": ("1", "area of sliding over that of contact"),
    "utilised": ("1", "tangential force over the sum of friction times pressures"),
    "p_max_rolling": ("MPa", "largest pressure of the rolling contact"),
    "vertical_rolling": ("N", "vertical force on the rolling wheel"),
    "resistance": ("N", "torque about the axle over the rolling radius, less F_x"),
}
OF_WHEELSET = {
    "xi_0": ("1", "creepage of the wheelset at the nominal radius, omega R_0 / V - 1"),
    "axle_torque": ("N mm", "torque with which the axle is driven"),
    "sum_F_y": ("N", "sum of the lateral forces on both wheels, to the left"),
    "steering": (
        "N mm",
        "moment of longitudinal forces on the wheelset, positive where it turns it to the right",
    ),
}
WORK = "work"


Other = tuple[RollingWheel, WheelContact]  # the same wheel with changed ICs


@dataclass(frozen=True, eq=False)
class WheelNumbers:
    """Numbers of a wheel by the names of `OF_WHEEL`, and the estimated errors of those that have one.

    `simplified`: steady rolling has a solution in its less accurate form only.
    """

    ics: str
    numbers: Mapping[str, float]
    errors: Mapping[str, float]
    simplified: bool
    grid: str


@dataclass(frozen=True)
class AxleNumbers:
    """Numbers of a wheelset by the names of `OF_WHEELSET`, and estimated errors of those that have one."""

    numbers: Mapping[str, float]
    errors: Mapping[str, float]


def axle_numbers(rolled: Rolled, left: WheelNumbers, right: WheelNumbers) -> AxleNumbers:
    """Return the numbers of a wheelset by those of its wheels."""
    at = [abs(float(wheel.place.touch.point[0])) for wheel in rolled.wheels]
    along, across = ([wheel.numbers[name] for wheel in (left, right)] for name in ("F_x", "F_y"))
    errors_along, errors_across = ([wheel.errors[name] for wheel in (left, right)] for name in ("F_x", "F_y"))
    numbers = {
        "xi_0": rolled.xi_0,
        "axle_torque": sum(contact.torque for contact in rolled.contacts),
        "sum_F_y": across[1] - across[0],
        "steering": along[0] * at[0] - along[1] * at[1],
    }
    known = {
        "xi_0": _error_of_creepage(rolled, errors_along),
        "sum_F_y": sum(errors_across),
        "steering": float(np.dot(errors_along, at)),
    }
    return AxleNumbers(numbers, known)


def _error_of_creepage(rolled: Rolled, of_forces: Sequence[float]) -> float:
    """Return the estimated error of the creepage: by larger elements, or by the errors of the forces."""
    if rolled.given:
        return 0.0
    levels = [level.xi_0 for level in _levels(rolled)]
    nominal = sum(rolled.wheels[0].place.layout.nominal_radius) / 2
    by_forces = float(np.linalg.norm(of_forces)) * nominal / abs(rolled.torque_slope)
    return max(from_grids(*levels[:3]), by_forces) if len(levels) > 1 else np.nan


def _levels(rolled: Rolled) -> list[Rolled]:
    levels = [rolled]
    while levels[-1].coarser is not None:
        levels.append(levels[-1].coarser)
    return levels


def wheel_numbers(rolled: Rolled, number: int, ics: str, others: Sequence[Other] = ()) -> WheelNumbers:
    """Return the numbers of one of the wheels; changes by the ICs of `others` add to estimated errors."""
    levels = _levels(rolled)
    wheel, contact = rolled.wheels[number], rolled.contacts[number]
    fine, *larger = (_measured(level.wheels[number], level.contacts[number], ics) for level in levels)
    of_all: dict[str, Kind] = {**kinds(OF_ROLLING), WORK: estimates.WORK}
    parts = [changes(fine, of_all, _measured(*other, ics).numbers) for other in others]
    known = errors(of_all, fine, larger[:2], parts)
    state, frictional = contact.rolling.contact, wheel.problem.problem
    bound = float(np.sum(frictional.bound(state.p[..., N]))) * frictional.grid.area
    tangential = np.linalg.norm(np.sum(state.p[..., :N], axis=(0, 1))) * frictional.grid.area
    own = fine.numbers
    numbers = {
        "xi": contact.rolling.creepages.longitudinal,
        "F_x": own["F_x"],
        "F_y": -wheel.place.in_track(contact.force)[0],
        "M_z": own["M_z"],
        "work": own[WORK],
        "sliding": own["sliding_share"],
        "utilised": float(tangential) / bound,
        "p_max_rolling": own["p_max"],
        "vertical_rolling": contact.vertical,
        "resistance": contact.torque / wheel.radius - own["F_x"],
    }
    of_numbers = {name: known[name] for name in ("F_x", "F_y", "M_z", WORK)} | {
        "sliding": known["sliding_share"],
        "p_max_rolling": known["p_max"],
        "utilised": float(np.hypot(known["F_x"], known["F_y"])) / bound,
    }
    grid = frictional.grid
    return WheelNumbers(
        ics,
        numbers,
        of_numbers,
        contact.rolling.simplified,
        f"{grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm",
    )


def _measured(wheel: RollingWheel, contact: WheelContact, ics: str) -> Measured:
    """Return the quantities of a contact, with the work of friction.

    It is that of the tractions on the rigid motion, which converges faster than that of friction on the
    slip; with C it is the latter, because the tractions there act on a raised surface.
    """
    if ics == "C":
        own = measured_rolling(wheel.on_grid, wheel.problem, contact.rolling)
        work = own.numbers["dissipation"]
    else:
        own = measured(wheel.on_grid, contact.rolling.contact, OF_ROLLING)
        work = wheel.problem.power(contact.rolling) - wheel.problem.climbing(contact.rolling)
    return replace(own, numbers={**own.numbers, WORK: work})
