"""The rolling wheelset in one position with several ICs, on the grids of its frictionless contacts.

C stands in for B-hat at the wheels where it was solved without friction, and rolls with B-hat at the other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

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
    AxleNumbers,
    AxleState,
    BeyondGrid,
    Other,
    RollingWheelset,
    WheelNumbers,
    axle_numbers,
    wheel_numbers,
)
from femic.shifts.contact import SIZING
from femic.shifts.sides import Place
from femic.shifts.specification import C, RollingTable
from femic.shifts.wheel import Friction, Motion, RollingWheel
from geometries.errors import Failure
from geometries.patches import Grid
from geometries.track.layout import SideName

BALANCES = 4  # steps to the load with changed ICs


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


@dataclass(frozen=True, eq=False)
class RolledICs:
    """The wheelset with some ICs: numbers of the axle and of wheels by side, and reasons for missing ones."""

    ics: str
    axle: AxleNumbers | None
    wheels: Mapping[SideName, WheelNumbers]
    reasons: Mapping[SideName, str] = field(default_factory=dict)
    seconds: float = 0.0


def roll(
    sides: Sequence[RollingSide],
    load: float,
    rolling: RollingTable,
    ics: Sequence[str],
    options: RunOptions = DEFAULT,
) -> list[RolledICs]:
    """Return the wheelset under a vertical load on each wheel [N] with all ICs.

    `sides` are those that have a contact. A wheelset of one side does not roll freely. C is solved where a
    side has it.
    """
    names = [name for name in dict.fromkeys(ics) if name != C]
    names += [C] if any(side.with_c for side in sides) else []
    return [_Roller(tuple(sides), load, rolling, name, options).rolled() for name in names]


@dataclass(frozen=True, eq=False)
class _Roller:
    sides: tuple[RollingSide, ...]
    load: float
    rolling: RollingTable
    ics: str
    options: RunOptions

    @property
    def given(self) -> float | None:
        """The given creepage of the wheelset; None where it rolls freely."""
        return None if isinstance(self.rolling.longitudinal, str) else self.rolling.longitudinal

    def rolled(self) -> RolledICs:
        """Return the wheelset; where its creepage is given, each wheel has a contact of its own."""
        start = perf_counter()
        solved = self.solve_axle() if self.given is None else self.solve_wheels()
        return replace(solved, seconds=perf_counter() - start)

    def solve_axle(self) -> RolledICs:
        """Return the wheelset that rolls freely; without any numbers if one contact has no solution."""
        names: list[SideName] = [side.place.side for side in self.sides]
        if len(names) < 2:
            return self.missing(names, "the other wheel has no contact, so the axle does not roll freely")
        try:
            rolled, sides = self.on_long_enough_grids(self.sides)
            wheels = {name: self.wheel(sides[k], rolled, k) for k, name in enumerate(names)}
        except Failure as failure:
            return self.missing(names, str(failure))
        return RolledICs(self.ics, axle_numbers(rolled, wheels["left"], wheels["right"]), wheels)

    def solve_wheels(self) -> RolledICs:
        """Return the wheelset at its given creepage."""
        wheels: dict[SideName, WheelNumbers] = {}
        reasons: dict[SideName, str] = {}
        solved: list[AxleState] = []
        for side in self.sides:
            name = side.place.side
            try:
                rolled, (own,) = self.on_long_enough_grids((side,))
                wheels[name] = self.wheel(own, rolled, 0)
                solved.append(rolled)
            except Failure as failure:
                reasons[name] = str(failure)
        if len(solved) < 2:
            return RolledICs(self.ics, None, wheels, reasons)
        both = replace(
            solved[0],
            wheels=(*solved[0].wheels, *solved[1].wheels),
            contacts=(*solved[0].contacts, *solved[1].contacts),
        )
        return RolledICs(self.ics, axle_numbers(both, wheels["left"], wheels["right"]), wheels)

    def missing(self, names: Sequence[SideName], reason: str) -> RolledICs:
        return RolledICs(self.ics, None, {}, dict.fromkeys(names, reason))

    def on_long_enough_grids(
        self, sides: tuple[RollingSide, ...]
    ) -> tuple[AxleState, tuple[RollingSide, ...]]:
        """Return the wheelset and its sides, whose grids are made longer where patches need it."""
        for _ in range(MOST_TRIES):
            wheels = tuple(self.wheel_on(side) for side in sides)
            wheelset = RollingWheelset(wheels, self.load, self.rolling.friction, self.given)
            try:
                return wheelset.solve(), sides
            except BeyondGrid as beyond:
                last = beyond
                sides = tuple(
                    side.longer(last.grid, last.short) if k == last.number else side
                    for k, side in enumerate(sides)
                )
        raise Failure(f"{sides[last.number].place.side} wheel: {last}")

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
        friction = Friction(self.rolling.friction, self.rolling.by_angle)
        motion = Motion(self.rolling.lateral, self.rolling.spin)
        return RollingWheel.on_areas(side.place, pressed, operators, friction, motion)

    def reference(self, side: RollingSide, on_grid: PairOnGrid) -> ReferenceICs:
        """Return C of a side on a grid as the rail sees it; its models are stored."""
        return full_reference_ics(side.problem, on_grid, self.options, wheel_rolls=True)

    def wheel(self, side: RollingSide, rolled: AxleState, number: int) -> WheelNumbers:
        """Return the numbers of a wheel; with C the changes by its error and its supports are estimated."""
        name = self.ics_on(side)
        others = self.others(side, rolled, number) if name == C else []
        return wheel_numbers(rolled, number, name, others)

    def others(self, side: RollingSide, rolled: AxleState, number: int) -> list[Other]:
        """Return the wheel with C plus its estimated error, and with nearer supports, at its creepages."""
        specification = replace(
            side.problem.specification, motion="rolling", friction=FrictionSpecification()
        )  # for all components of C
        problem, on_grid = (
            replace(side.problem, specification=specification),
            rolled.wheels[number].on_grids[0],
        )
        nearer = next(other_supports(problem, on_grid, self.options))
        operators = (
            self.reference(side, on_grid).perturbed,
            nearer.operator(on_grid, friction=True, wheel_rolls=True),
        )
        contact, others = rolled.contacts[number], []
        for operator in operators:
            wheel = self.wheel_on(side, operator).linearised_about(rolled.wheels[number].about)
            own = wheel.contact(rolled.xi_0, contact.approach, contact)
            for _ in range(BALANCES):  # of the load, by other ICs
                own = wheel.contact(rolled.xi_0, wheel.approach_for(self.load, own), own)
            others.append((wheel, own))
        return others
