"""The numbers of a rolling wheelset: creepages, creep forces in axes of the track, work of friction.

Their errors are estimated from elements twice and four times as large, on which the wheelset has found a
creepage and approaches of its own. Numbers of a wheel are sums over its patches, and so are their errors.
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
from geometries.patches import N, S, X

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
OF_PATCH = {  # of each patch of a wheel
    "F_x": ("N", "longitudinal force on the wheel by the patch"),
    "F_s": ("N", "tangential force on the wheel along the rail's profile by the patch"),
    "F_n": ("N", "force along its normals by the patch"),
    "slip_x": ("1", "rigid slip along x in the centre of pressure of the patch"),
    "slip_s": ("1", "rigid slip along the rail's profile in the centre of pressure of the patch"),
    "spin": ("1/mm", "turning of the rigid wheel about the normal there, per rolled distance"),
    "p_max": ("MPa", "largest pressure of the patch"),
    "angle": ("deg", "contact angle to the track plane, mean weighted with pressures, positive on a flange"),
    "area": ("mm2", "area of the patch"),
    "centre": ("mm", "centre of pressure of the patch, arc length of the rail's profile"),
    "work": ("N", "work of friction of the patch per unit of rolled distance, J/m"),
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
SUMMED = ("F_x", "F_y", "M_z", WORK)


@dataclass(frozen=True, eq=False)
class WheelNumbers:
    """Numbers of a wheel by the names of `OF_WHEEL`, and the estimated errors of those that have one.

    `patches` are those of each grid by the names of `OF_PATCH`, by growing arc length. `simplified`: steady
    rolling has a solution in its less accurate form only.
    """

    ics: str
    numbers: Mapping[str, float]
    errors: Mapping[str, float]
    patches: tuple[Mapping[str, float], ...]
    simplified: bool


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
    of_all: dict[str, Kind] = {**kinds(OF_ROLLING), WORK: estimates.WORK}
    own, known = list[Mapping[str, float]](), list[Mapping[str, float]]()
    for patch in range(len(wheel.problems)):
        fine, *larger = (
            _measured(level.wheels[number], level.contacts[number], patch, ics) for level in levels
        )
        parts = [changes(fine, of_all, _measured(*other, patch, ics).numbers) for other in others]
        own.append(fine.numbers)
        known.append(errors(of_all, fine, larger[:2], parts))
    forces = [_patch(wheel, contact, patch, work=own[patch][WORK]) for patch in range(len(own))]
    bound = sum(each["bound"] for each in forces)
    tangential = float(np.hypot(sum(each["F_x"] for each in forces), sum(each["F_s"] for each in forces)))
    area = np.array([max(numbers["area"], 1e-300) for numbers in own])
    highest = int(np.argmax([numbers["p_max"] for numbers in own]))
    total = {name: float(sum(numbers[name] for numbers in own)) for name in SUMMED}
    numbers = {
        "xi": contact.creepages.longitudinal,
        "F_x": total["F_x"],
        "F_y": -wheel.place.in_track(contact.force)[0],
        "M_z": total["M_z"],
        "work": total[WORK],
        "sliding": float(np.average([numbers["sliding_share"] for numbers in own], weights=area)),
        "utilised": tangential / bound,
        "p_max_rolling": own[highest]["p_max"],
        "vertical_rolling": contact.vertical,
        "resistance": contact.torque / wheel.radius - total["F_x"],
    }
    of_numbers = {name: float(sum(each[name] for each in known)) for name in SUMMED} | {
        "sliding": float(np.average([each["sliding_share"] for each in known], weights=area)),
        "p_max_rolling": known[highest]["p_max"],
    }
    of_numbers["utilised"] = float(np.hypot(of_numbers["F_x"], of_numbers["F_y"])) / bound
    patches = tuple({name: each[name] for name in OF_PATCH} for each in forces)
    return WheelNumbers(ics, numbers, of_numbers, patches, contact.simplified)


def _patch(wheel: RollingWheel, contact: WheelContact, patch: int, *, work: float) -> dict[str, float]:
    """Return the numbers of a patch, and its `bound`, friction times pressures [N]."""
    state, problem = contact.states[patch], wheel.problems[patch]
    area, p = problem.problem.grid.area, state.p
    strips = np.sum(p[..., N], axis=0)
    x, s, slip = problem.rolling.x, problem.rolling.s, problem.rolling.rigid_slip(contact.creepages)
    at = float(np.average(s, weights=strips)) if np.any(strips) else np.nan
    across = np.gradient(slip[p.shape[0] // 2, :, X], s)
    turning = ((slip[-1, :, S] - slip[0, :, S]) / (x[-1] - x[0]) - across) / 2
    along = {"slip_x": slip[p.shape[0] // 2, :, X], "slip_s": slip[p.shape[0] // 2, :, S], "spin": turning}
    angles = wheel.place.roll - wheel.on_grids[patch].undeformed.lower.contour.inclination(s)
    f_x, f_s, f_n = (float(np.sum(p[..., direction])) * area for direction in (X, S, N))
    return {
        "F_x": f_x,
        "F_s": f_s,
        "F_n": f_n,
        **{name: float(np.interp(at, s, values)) for name, values in along.items()},
        "p_max": float(np.max(p[..., N])),
        "angle": float(np.degrees(np.average(angles, weights=strips))) if np.any(strips) else np.nan,
        "area": float(np.count_nonzero(p[..., N])) * area,
        "centre": wheel.place.touch.s_rail + at,
        "work": work,
        "bound": float(np.sum(problem.problem.bound(p[..., N]))) * area,
    }


def _measured(wheel: RollingWheel, contact: WheelContact, patch: int, ics: str) -> Measured:
    """Return the quantities of a patch, with the work of friction.

    It is that of the tractions on the rigid motion, which converges faster than that of friction on the
    slip; with C it is the latter, because the tractions there act on a raised surface.
    """
    on_grid, problem, rolling = wheel.on_grids[patch], wheel.problems[patch], contact.patches[patch]
    if ics == "C":
        own = measured_rolling(on_grid, problem, rolling)
        work = own.numbers["dissipation"]
    else:
        own = measured(on_grid, rolling.contact, OF_ROLLING)
        work = problem.power(rolling) - problem.climbing(rolling)
    return replace(own, numbers={**own.numbers, WORK: work, "approach": contact.approach})
