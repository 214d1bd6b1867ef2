"""Wheels on one axle: the creepage at which they roll freely, vertical forces in balance, and the numbers.

Free: no torque acts on the axle. The sum of the torques of the wheels grows with the creepage xi_0, so that
its zero is bracketed; steps are those of the secant, or bisections. The approaches of the wheels follow their
vertical forces from step to step. All is solved on elements four times, twice and once as large, each time
from the creepage, the approaches and the tractions before, with the distance of wheels that are displaced by
these approaches; the differences tell the errors.

Numbers are creepages, creep forces in axes of the track, and the work of friction. Those of a wheel are sums
over its patches, and so are their errors. On larger elements the wheelset has found a creepage and approaches
of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from femic.contact import estimates
from femic.contact.datasets import CHANGE, FLOOR, LARGER, MISSED, difference_errors_of_all
from femic.contact.estimates import Kind, Measured, changes, errors, from_grids
from femic.contact.motions.rolling import OF_ROLLING, measured_rolling
from femic.contact.pairs.quantities import kinds, measured
from femic.shifts.specification import RollingTable
from femic.shifts.wheel import PatchBeyondGrid, RollingWheel, WheelContact
from geometries.errors import Failure
from geometries.patches import N, S, X

# --- how the axle rolls ---

TORQUE = 1e-5  # of friction times load times nominal radius: the largest torque of a free wheelset
VERTICAL = 1e-5  # of the load: the largest error of the vertical forces
LEVELS = 3  # of grids
FIRST_SLOPE = 500.0  # of the torque over friction, load and radius by the creepage: less than that at rest
WIDEST_STEP = 0.01  # of the creepage outside of a bracket
MOST_STEPS = 80


@dataclass(frozen=True, eq=False)
class AxleState:
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
    coarser: "AxleState | None" = None

    @property
    def levels(self) -> "list[AxleState]":
        """The state, and those on larger and larger elements."""
        return [self, *(self.coarser.levels if self.coarser else ())]


@dataclass(frozen=True, eq=False)
class RollingWheelset:
    """The wheels of an axle under a vertical load each [N], and how they roll."""

    wheels: tuple[RollingWheel, ...]
    load: float
    rolling: RollingTable

    @property
    def xi_0(self) -> float | None:
        """The given creepage; None where the axle is free."""
        return None if isinstance(self.rolling.longitudinal, str) else self.rolling.longitudinal

    def solve(self, levels: int = LEVELS) -> AxleState:
        """Return the wheelset as it rolls.

        Raises Failure, and PatchBeyondGrid where a patch comes near the ends of its grid.
        """
        coarser, coarsened = None, [wheel.coarsened for wheel in self.wheels]
        wheels = tuple(wheel for wheel in coarsened if wheel is not None)
        if levels > 1 and len(wheels) == len(self.wheels):
            try:
                coarser = replace(self, wheels=wheels).solve(levels - 1)
            except Failure:
                coarser = None
        if coarser is not None:
            approaches = [contact.approach for contact in coarser.contacts]
            starts = [contact.finer for contact in coarser.contacts]
            own = self.linearised_about(approaches)
            state = own.solve_equilibrium(own.state_at(coarser.xi_0, approaches, starts, coarser.slope))
            return replace(state, coarser=coarser)
        xi_0 = self.xi_0
        if xi_0 is None:  # that at which the wheels together would roll without slip
            without = [wheel.creepages(0.0).longitudinal for wheel in self.wheels]
            xi_0 = -sum(without) / len(without)
        approaches = [wheel.about for wheel in self.wheels]
        guess = self.state_at(xi_0, approaches, [None] * len(approaches), FIRST_SLOPE)
        first = self.solve_equilibrium(guess)
        approaches = [contact.approach for contact in first.contacts]
        again = self.linearised_about(approaches)
        return again.solve_equilibrium(again.state_at(first.xi_0, approaches, first.contacts, first.slope))

    def linearised_about(self, approaches: Sequence[float]) -> "RollingWheelset":
        """Return the wheelset with the distances of wheels that are displaced by approaches [mm]."""
        pairs = zip(self.wheels, approaches, strict=True)
        return replace(self, wheels=tuple(wheel.linearised_about(approach) for wheel, approach in pairs))

    def state_at(
        self, xi_0: float, approaches: Sequence[float], starts: Sequence[WheelContact | None], slope: float
    ) -> AxleState:
        """Return the contacts at a creepage under approaches [mm]."""
        contacts = []
        for wheel, approach, start in zip(self.wheels, approaches, starts, strict=True):
            try:
                contacts.append(wheel.contact(xi_0, approach, start))
            except PatchBeyondGrid:
                raise
            except Failure as failure:
                along = wheel.creepages(xi_0).longitudinal
                raise Failure(f"{wheel.place.side} wheel, creepage {along:.4g}: {failure}") from failure
        unit = self.rolling.friction * self.load * self.wheels[0].nominal_radius
        torque = sum(contact.torque for contact in contacts) / unit
        return AxleState(self.wheels, xi_0, tuple(contacts), torque, slope, unit, self.xi_0 is not None)

    def solve_equilibrium(self, state: AxleState) -> AxleState:
        """Return the wheelset without a torque, or at its given creepage, with the loads in balance."""
        low, high = -np.inf, np.inf
        for _ in range(MOST_STEPS):
            balanced = all(abs(contact.vertical / self.load - 1) <= VERTICAL for contact in state.contacts)
            if not balanced:  # only then the sign of the torque tells on which side its zero is
                state = self.step(state, state.xi_0)
                continue
            if state.given or abs(state.torque) <= TORQUE:
                return state
            low, high = (low, state.xi_0) if state.torque > 0 else (state.xi_0, high)
            secant = state.xi_0 + float(np.clip(-state.torque / state.slope, -WIDEST_STEP, WIDEST_STEP))
            state = self.step(state, secant if low < secant < high else (low + high) / 2)
        raise Failure(
            f"wheelset: after {MOST_STEPS} steps a torque of {state.torque:.1e} of friction, load and "
            f"radius is left at a creepage of {state.xi_0:g}; give rolling.longitudinal"
        )

    def step(self, before: AxleState, xi_0: float) -> AxleState:
        """Return the wheelset at another creepage, with approaches that follow the forces before."""
        approaches = [
            wheel.approach_for(self.load, contact)
            for wheel, contact in zip(self.wheels, before.contacts, strict=True)
        ]
        after = self.state_at(xi_0, approaches, before.contacts, before.slope)
        if xi_0 == before.xi_0:
            return after
        slope = (after.torque - before.torque) / (xi_0 - before.xi_0)
        return replace(after, slope=slope) if slope > 0 else after


# --- numbers with their errors ---

OF_WHEEL = {  # by name: unit and meaning
    "xi": ("1", "longitudinal creepage at the contact point, positive if the wheel is driven"),
    "F_x": ("N", "longitudinal force on the wheel, positive in the rolling direction"),
    "F_y": ("N", "lateral force on the wheel with friction, positive towards the middle of the track"),
    "M_z": (
        "N mm",
        "moment on the wheel about the vertical through the contact point, positive if it "
        "turns the front outwards",
    ),
    "work": ("N", "work of friction per unit of rolled distance (T-gamma), J/m"),
    "sliding": ("1", "sliding area divided by contact area"),
    "utilised": ("1", "tangential force divided by the sum of friction coefficient times pressure"),
    "p_max_rolling": ("MPa", "largest pressure of the rolling contact"),
    "vertical_rolling": ("N", "vertical force on the rolling wheel"),
    "resistance": ("N", "torque about the axle divided by the rolling radius, minus F_x"),
}
OF_PATCH = {  # of each patch of a wheel
    "F_x": ("N", "longitudinal force on the wheel from the patch"),
    "F_s": ("N", "tangential force on the wheel along the rail profile, from the patch"),
    "F_n": ("N", "normal force on the wheel from the patch"),
    "slip_x": ("1", "rigid slip along x in the centre of pressure of the patch"),
    "slip_s": ("1", "rigid slip along the rail's profile in the centre of pressure of the patch"),
    "spin": ("1/mm", "spin: rotation of the rigid wheel about the normal at that point, per rolled distance"),
    "p_max": ("MPa", "largest pressure of the patch"),
    "angle": (
        "deg",
        "contact angle from the track plane, averaged with the pressures as weights, positive on a flange",
    ),
    "area": ("mm2", "area of the patch"),
    "centre": ("mm", "centre of pressure of the patch, arc length of the rail's profile"),
    "work": ("N", "work of friction of the patch per unit of rolled distance, J/m"),
}
OF_WHEELSET = {
    "xi_0": ("1", "creepage of the wheelset at the nominal radius, omega R_0 / V - 1"),
    "axle_torque": ("N mm", "driving torque of the axle"),
    "sum_F_y": ("N", "sum of the lateral forces on both wheels, to the left"),
    "steering": (
        "N mm",
        "steering moment of the longitudinal forces on the wheelset, positive to the right",
    ),
}
WORK = "work"
SUMMED = ("F_x", "F_y", "M_z", WORK)
Other = tuple[RollingWheel, WheelContact]  # the same wheel with changed ICs


@dataclass(frozen=True, eq=False)
class WheelNumbers:
    """Numbers of a wheel by the names of `OF_WHEEL`, and the estimated errors of those that have one.

    `patches` are those of each grid by the names of `OF_PATCH`, by growing arc length. `variations` are those
    of `SUMMED` by the prefixes of `femic.contact.datasets`.
    """

    numbers: Mapping[str, float]
    errors: Mapping[str, float]
    patches: tuple[Mapping[str, float], ...]
    variations: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def axle_numbers(
    state: AxleState, left: WheelNumbers, right: WheelNumbers
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the numbers of a wheelset by the names of `OF_WHEELSET`, and estimated errors of most.

    The creepage is known to what larger elements say, or to the errors of the forces over the slope of the
    torque, if that is more; one that is given is exact.
    """
    at = [abs(float(wheel.place.touch.point[0])) for wheel in state.wheels]
    along, across = ([wheel.numbers[name] for wheel in (left, right)] for name in ("F_x", "F_y"))
    errors_along, errors_across = ([wheel.errors[name] for wheel in (left, right)] for name in ("F_x", "F_y"))
    error, levels = 0.0, [level.xi_0 for level in state.levels]
    if not state.given:
        torque = float(np.linalg.norm(errors_along)) * state.wheels[0].nominal_radius
        by_forces = torque / abs(state.slope * state.unit)
        error = max(from_grids(*levels[:3]), by_forces) if len(levels) > 1 else np.nan
    numbers = {
        "xi_0": state.xi_0,
        "axle_torque": sum(contact.torque for contact in state.contacts),
        "sum_F_y": across[1] - across[0],
        "steering": along[0] * at[0] - along[1] * at[1],
    }
    known = {"xi_0": error, "sum_F_y": sum(errors_across), "steering": float(np.dot(errors_along, at))}
    return numbers, known


def wheel_numbers(state: AxleState, number: int, ics: str, others: Sequence[Other] = ()) -> WheelNumbers:
    """Return the numbers of one of the wheels; changes by the ICs of `others` add to estimated errors."""
    wheel, contact, levels = state.wheels[number], state.contacts[number], state.levels
    error_kinds: dict[str, Kind] = {**kinds(OF_ROLLING), WORK: estimates.WORK}
    by_level = [_measure(level.wheels[number], level.contacts[number], ics) for level in levels]
    by_other = [_measure(*other, ics) for other in others]
    own, known = [fine.numbers for fine in by_level[0]], list[Mapping[str, float]]()
    for patch, fine in enumerate(by_level[0]):
        larger = [measures[patch] for measures in by_level[1:3]]
        parts = [changes(fine, error_kinds, measures[patch].numbers) for measures in by_other]
        known.append(errors(error_kinds, fine, larger, parts))
    patches = [_patch_numbers(wheel, contact, patch, own[patch][WORK]) for patch in range(len(own))]
    bound = sum(
        float(np.sum(problem.problem.bound(pressed.p[..., N]))) * problem.problem.grid.area
        for problem, pressed in zip(wheel.problems, contact.states, strict=True)
    )
    tangential = float(np.hypot(sum(each["F_x"] for each in patches), sum(each["F_s"] for each in patches)))
    area = np.array([max(numbers["area"], 1e-300) for numbers in own])
    highest = int(np.argmax([numbers["p_max"] for numbers in own]))
    total = _total(wheel, contact, by_level[0])
    numbers = {
        "xi": contact.creepages.longitudinal,
        "F_x": total["F_x"],
        "F_y": total["F_y"],
        "M_z": total["M_z"],
        "work": total[WORK],
        "sliding": float(np.average([numbers["sliding_share"] for numbers in own], weights=area)),
        "utilised": tangential / bound,
        "p_max_rolling": own[highest]["p_max"],
        "vertical_rolling": contact.vertical,
        "resistance": contact.torque / wheel.radius - total["F_x"],
    }
    estimated = {name: float(sum(each[name] for each in known)) for name in SUMMED} | {
        "sliding": float(np.average([each["sliding_share"] for each in known], weights=area)),
        "p_max_rolling": known[highest]["p_max"],
    }
    estimated["utilised"] = float(np.hypot(estimated["F_x"], estimated["F_y"])) / bound
    larger_level, nothing = levels[1] if len(levels) > 1 else None, dict.fromkeys(SUMMED, np.nan)
    moved = [
        {name: abs(value - total[name]) for name, value in _total(*other, measures).items()}
        for other, measures in zip(others, by_other, strict=True)
    ]
    uncommon = difference_errors_of_all(by_level[0], OF_ROLLING)
    variations = {
        LARGER: _total(larger_level.wheels[number], larger_level.contacts[number], by_level[1])
        if larger_level
        else nothing,
        CHANGE: {name: float(sum(each[name] for each in moved)) for name in SUMMED},
        **{
            prefix: {
                name: float(
                    of_all(each["dissipation" if name == WORK else name] for each in uncommon[prefix])
                )
                for name in SUMMED
            }
            for prefix, of_all in ((FLOOR, sum), (MISSED, max))
        },
    }
    return WheelNumbers(numbers, estimated, tuple(patches), variations)


def _total(wheel: RollingWheel, contact: WheelContact, measures: Sequence[Measured]) -> dict[str, float]:
    """Return the numbers `SUMMED` of a wheel from those of its patches; F_y is in axes of the track."""
    total = {name: float(sum(each.numbers[name] for each in measures)) for name in SUMMED}
    return total | {"F_y": -wheel.place.in_track(contact.force)[0]}


def _patch_numbers(wheel: RollingWheel, contact: WheelContact, patch: int, work: float) -> dict[str, float]:
    """Return the numbers of a patch by the names of `OF_PATCH`."""
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
    }


def _measure(wheel: RollingWheel, contact: WheelContact, ics: str) -> list[Measured]:
    """Return the quantities of each patch, with the work of friction.

    It is that of the tractions on the rigid motion, which converges faster than that of friction on the
    slip; with C it is the latter, because the tractions there act on a raised surface.
    """
    patches = []
    for on_grid, problem, rolling in zip(wheel.on_grids, wheel.problems, contact.patches, strict=True):
        if ics == "C":
            own = measured_rolling(on_grid, problem, rolling)
            work = own.numbers["dissipation"]
        else:
            own = measured(on_grid, rolling.contact, OF_ROLLING)
            work = problem.power(rolling) - problem.climbing(rolling)
        patches.append(replace(own, numbers={**own.numbers, WORK: work, "approach": contact.approach}))
    return patches
