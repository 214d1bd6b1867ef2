"""The rolling wheelset in one position with several ICs, on the grids of its frictionless contacts.

C stands in for B-hat at the wheels where it was solved without friction, and rolls with B-hat at the other.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from femic.contact.datasets import CHANGE, FLOOR, LARGER, MISSED, PREFIXES
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.area_grids import MOST_TRIES, longer
from femic.contact.pairs.areas import Areas, AreasContact, AreaTooSmall
from femic.contact.pairs.ics import ReferenceICs, approximation, full_reference_ics
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.contact.specification import ContactProblem, FrictionSpecification
from femic.contact.supports import other_supports
from femic.reference.run_options import DEFAULT, RunOptions
from femic.shifts.axle import (
    OF_PATCH,
    OF_WHEEL,
    OF_WHEELSET,
    SUMMED,
    AxleState,
    Other,
    RollingWheelset,
    WheelNumbers,
    axle_numbers,
    wheel_numbers,
)
from femic.shifts.contact import SIZING
from femic.shifts.sides import SIDES, Place
from femic.shifts.specification import C, RollingTable
from femic.shifts.wheel import PatchBeyondGrid, RollingWheel
from geometries.errors import Failure
from geometries.patches import Grid
from geometries.track.layout import SideName

BALANCES = 4  # steps to the load with changed ICs
ESTIMATE = "estimate_"  # before the name of a number
GRID = "area_"  # before the names of numbers of each contact area that rolls


@dataclass(frozen=True, eq=False)
class RollingSide:
    """One wheel and its rail: the contact problem, the grids of its patches, and the approach [mm].

    `with_c`: whether C is among its ICs.
    """

    place: Place
    problem: ContactProblem
    grids: tuple[Grid, ...]
    approach: float
    with_c: bool

    def pressed(self, variant: str, load: float) -> AreasContact:
        """Return the wheel pressed on under a load [N] without friction, with an approximation of the ICs.

        Its grids are longer where patches need it.
        """
        pair, grids = pair_on_grid(self.problem, self.grids[0]), self.grids
        for _ in range(MOST_TRIES):
            areas = Areas.with_approximation(variant, pair, grids, self.place.roll)
            try:
                return areas.solve(load, self.approach)
            except AreaTooSmall as short:
                last, grids = short, tuple(longer(areas, short))
        raise Failure(f"{self.place.side} wheel: {last}")

    def longer(self, number: int, short: PotentialAreaTooSmall) -> "RollingSide":
        """Return the side with a longer grid in the place of one."""
        pair = pair_on_grid(self.problem, self.grids[0])
        areas = Areas.with_approximation(SIZING, pair, self.grids, self.place.roll)
        return replace(self, grids=tuple(longer(areas, AreaTooSmall(number, short))))


def roll(
    sides: Sequence[RollingSide],
    load: float,
    rolling: RollingTable,
    ics: Sequence[str],
    options: RunOptions = DEFAULT,
) -> xr.Dataset:
    """Return the wheelset under a vertical load on each wheel [N] with all ICs, as `label_wheelset`.

    `sides` are those that have a contact. A wheelset of one side does not roll freely. C is solved where a
    side has it.
    """
    names = [name for name in dict.fromkeys(ics) if name != C]
    names += [C] if any(side.with_c for side in sides) else []
    return concat_ics([_Roller(load, rolling, name, options).roll(sides) for name in names])


def label_wheelset(
    ics: str,
    wheels: Mapping[SideName, WheelNumbers],
    axle: tuple[Mapping[str, float], Mapping[str, float]] = ({}, {}),
    reasons: Mapping[SideName, str] | None = None,
    seconds: float = 0.0,
) -> xr.Dataset:
    """Return the numbers of wheels and axle with some ICs, and `estimate_NUMBER`, NaN where there is none.

    Beside forces, moments and work of wheels stand their variations (`femic.contact.datasets`).
    Those of each contact area of a wheel are `area_NUMBER` (side, ics, area). The attribute `reasons` says by
    side why a wheel has no numbers.
    """
    variables: dict[str, Any] = {"seconds_rolling": ("ics", [seconds])}
    both = [wheels.get(side) or WheelNumbers({}, {}, ()) for side in SIDES]
    by_wheel = [wheel.numbers for wheel in both], [wheel.errors for wheel in both]
    for name, (unit, meaning) in {**OF_WHEEL, **OF_WHEELSET}.items():
        abouts = meaning, f"estimated error of {name}"
        for prefix, rows, own, about in zip(("", ESTIMATE), by_wheel, axle, abouts, strict=True):
            values = (
                [[row.get(name, np.nan)] for row in rows] if name in OF_WHEEL else [own.get(name, np.nan)]
            )
            dims = ("side", "ics") if name in OF_WHEEL else ("ics",)
            variables[prefix + name] = dims, values, {"units": unit, "long_name": about}
    for name, prefix in product(SUMMED, (LARGER, CHANGE, FLOOR, MISSED)):
        unit, meaning = OF_WHEEL[name]
        values = [[wheel.variations.get(prefix, {}).get(name, np.nan)] for wheel in both]
        attributes = {"units": "1" if prefix == MISSED else unit, "long_name": meaning + PREFIXES[prefix]}
        variables[prefix + name] = ("side", "ics"), values, attributes
    most = max((len(wheel.patches) for wheel in wheels.values()), default=1)
    for name, (unit, meaning) in OF_PATCH.items():
        array = np.full((len(SIDES), 1, most), np.nan)
        for side, wheel in wheels.items():
            array[SIDES.index(side), 0, : len(wheel.patches)] = [patch[name] for patch in wheel.patches]
        variables[GRID + name] = ("side", "ics", "area"), array, {"units": unit, "long_name": meaning}
    return xr.Dataset(
        variables,
        coords={"side": list(SIDES), "ics": [ics], "area": np.arange(1, most + 1)},
        attrs={"reasons": json.dumps({side: f"{ics}: {reason}" for side, reason in (reasons or {}).items()})},
    )


def concat_ics(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return wheelsets of `label_wheelset` with all ICs."""
    reasons: dict[str, str] = {}
    for part in parts:
        for side, reason in json.loads(part.attrs["reasons"]).items():
            reasons[side] = f"{reasons[side]}; {reason}" if side in reasons else reason
    dataset = xr.concat(parts, "ics", join="outer", combine_attrs="drop_conflicts")
    return dataset.assign_attrs(reasons=json.dumps(reasons))


@dataclass(frozen=True, eq=False)
class _Roller:
    """How a wheelset rolls with some ICs."""

    load: float
    rolling: RollingTable
    ics: str
    options: RunOptions

    def roll(self, sides: Sequence[RollingSide]) -> xr.Dataset:
        """Return the wheelset. Without a given creepage, it has numbers only where both wheels have."""
        start, is_free = perf_counter(), isinstance(self.rolling.longitudinal, str)
        wheels: dict[SideName, WheelNumbers] = {}
        reasons: dict[SideName, str] = {}
        states: list[AxleState] = []
        for group in [tuple(sides)] if is_free else [(side,) for side in sides]:
            try:
                if is_free and len(group) < 2:
                    raise Failure("the other wheel has no contact, so the axle does not roll freely")
                state, longer = self.solve(group)
                numbers = {side.place.side: self.numbers(side, state, k) for k, side in enumerate(longer)}
            except Failure as failure:
                reasons |= {side.place.side: str(failure) for side in group}
                continue
            wheels |= numbers
            states.append(state)
        axle: tuple[Mapping[str, float], Mapping[str, float]] = {}, {}
        if len(wheels) == 2:
            both = replace(
                states[0],
                wheels=tuple(wheel for state in states for wheel in state.wheels),
                contacts=tuple(contact for state in states for contact in state.contacts),
            )
            axle = axle_numbers(both, wheels["left"], wheels["right"])
        beside_c = [side.place.side for side in sides if self.ics_on(side) != self.ics]
        own = {side: wheel for side, wheel in wheels.items() if side not in beside_c}
        return label_wheelset(self.ics, own, axle, reasons, perf_counter() - start)

    def solve(self, sides: tuple[RollingSide, ...]) -> tuple[AxleState, tuple[RollingSide, ...]]:
        """Return the wheelset and its sides, whose grids are made longer where patches need it."""
        for _ in range(MOST_TRIES):
            wheels = tuple(self.wheel_on(side) for side in sides)
            try:
                return RollingWheelset(wheels, self.load, self.rolling).solve(), sides
            except PatchBeyondGrid as beyond:
                last = beyond
                sides = tuple(
                    side.longer(beyond.number, beyond.short) if side.place is beyond.place else side
                    for side in sides
                )
        raise Failure(f"{last.place.side} wheel: {last}")

    def ics_on(self, side: RollingSide) -> str:
        """Return the ICs of a side."""
        return SIZING if self.ics == C and not side.with_c else self.ics

    def wheel_on(self, side: RollingSide, operator: FullOperator | None = None) -> RollingWheel:
        """Return the wheel of a side with its ICs, or with others, on one grid."""
        name = self.ics_on(side)
        pressed = side.pressed(SIZING if name == C else name, self.load)
        if operator is not None:
            operators = [operator]
        elif name == C:
            operators = [self.reference(side, pressed.areas.on_grids[0]).operator]
        else:
            operators = [approximation(on_grid, name) for on_grid in pressed.areas.on_grids]
        return RollingWheel.on_areas(side.place, pressed, operators, self.rolling)

    def reference(self, side: RollingSide, on_grid: PairOnGrid) -> ReferenceICs:
        """Return C of a side on a grid as the rail sees it; its models are stored."""
        return full_reference_ics(side.problem, on_grid, self.options, wheel_rolls=True)

    def numbers(self, side: RollingSide, state: AxleState, number: int) -> WheelNumbers:
        """Return the numbers of a wheel.

        With C there are, for its estimates, the wheel with C plus its estimated error, and with nearer
        supports, at its creepages.
        """
        others: list[Other] = []
        if (ics := self.ics_on(side)) == C:
            # for all components of C
            specification = replace(
                side.problem.specification, motion="rolling", friction=FrictionSpecification()
            )
            problem = replace(side.problem, specification=specification)
            wheel, contact = state.wheels[number], state.contacts[number]
            on_grid = wheel.on_grids[0]
            nearer = next(other_supports(problem, on_grid, self.options))
            for operator in (
                self.reference(side, on_grid).perturbed,
                nearer.operator(on_grid, friction=True, wheel_rolls=True),
            ):
                changed = self.wheel_on(side, operator).linearised_about(wheel.about)
                own = changed.contact(state.xi_0, contact.approach, contact)
                for _ in range(BALANCES):  # of the load, by other ICs
                    own = changed.contact(state.xi_0, changed.approach_for(self.load, own), own)
                others.append((changed, own))
        return wheel_numbers(state, number, ics, others)
