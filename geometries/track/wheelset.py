"""The position of a wheelset: its roll and height follow from both wheels touching their rails.

`settle` finds it at one shift, `over_shifts` at many, with the jumps of the touching points between them.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.track.curves import STEEPEST, Moved, turned
from geometries.track.layout import Layout, Side, SideName
from geometries.track.touching import Minimum, followed_to, gap_minima, posed

# --- one shift ---

ROLL_STEP = 1e-3  # rad: the search of the roll goes outwards in such steps at most
ROLL_STEPS = 200
NEWTON_STEPS = 20
BISECTED = 3  # each third step halves the bracket: where pieces of a standard do not meet, heights jump
HEIGHT_ROUNDING = 2e-12  # mm: left and right
LARGEST_ROLL = 0.1  # rad
ROLL_ROUNDING = 1e-16  # rad
NEAR_END = 3.0  # mm of arc length: a touching point as near to the end of a profile is noted
DEEP = 20.0  # mm below the rail top: beyond the flanks that flanges touch
SECOND_WITHIN = 0.1  # mm: default distance below which a second touching point is reported

RollRule = Literal["about axle", "about rails"]


@dataclass(frozen=True, eq=False)
class Touch:
    """A point where a wheel touches its rail, or comes near it with a common tangent.

    s_rail, s_wheel: arc lengths [mm] of the curves. on_rail, on_wheel: the points in the axes of the
    profiles. point: that on the rail in the axes of the side, shape (2,) each. angle: contact angle [rad]
    between tangent and track plane, positive on a flange. radius: rolling radius [mm]. gap: vertical gap
    [mm], 0 where they touch. curvature_rail, curvature_wheel: positive on a crown [1/mm].
    """

    s_rail: float
    s_wheel: float
    on_rail: Array
    on_wheel: Array
    point: Array
    angle: float
    radius: float
    gap: float
    curvature_rail: float
    curvature_wheel: float

    @property
    def distance(self) -> float:
        """Distance [mm] of the parallel tangents."""
        return float(self.gap * np.cos(self.angle))


@dataclass(frozen=True, eq=False)
class Position:
    """A wheelset on a track: shift [mm] of the middle of the axle to the left, roll [rad], heights [mm].

    `shift_at_rails` is that of the point of the middle plane a nominal radius below the axle; `given_shift`
    is the one of both that was given. Roll is positive where the left wheel is higher. Heights are those of
    the middle of the axle above the rail tops at which the left and the right wheel touch: equal, unless the
    roll was given. `left` and `right` are the touching points, the least gap first; `notes` are sentences
    about those that are not where wheels usually touch.
    """

    shift: float
    shift_at_rails: float
    given_shift: float
    roll: float
    heights: tuple[float, float]
    left: tuple[Touch, ...]
    right: tuple[Touch, ...]
    notes: tuple[str, ...] = ()

    @property
    def height(self) -> float:
        """Mean of the two heights [mm]."""
        return sum(self.heights) / 2

    @property
    def rolling_radius_difference(self) -> float:
        """Rolling radius of the left wheel less that of the right one [mm]."""
        return self.left[0].radius - self.right[0].radius

    def pose(self, side: SideName) -> tuple[float, float, float]:
        """Shift, roll and height of the axle in the axes of a side."""
        sign = 1 if side == "left" else -1
        return sign * self.shift, sign * self.roll, self.heights[0 if side == "left" else 1]


def settle(
    layout: Layout,
    shift: float,
    *,
    roll: float | RollRule = "about axle",
    yaw: float = 0.0,
    within: float = SECOND_WITHIN,
) -> Position:
    """The wheelset shifted by `shift` [mm] to the left, resting on both rails.

    The roll follows from this. "about axle": the shift is that of the middle of the axle; "about rails": of
    the point a nominal radius below it, which determines the position on a flange of any slope. A given roll
    [rad] leaves each wheel to touch at a height of its own, as if the axle could be cut.

    Touching points up to `within` [mm] of distance are reported. Raises Failure where both wheels touch at no
    roll, where a profile ends before it touches, and where a wheel stands on the tip of its flange; and
    WrongInput for a yaw.
    """
    if not np.isfinite(shift):
        raise WrongInput(f"shift = {shift!r}: must be a number [mm]")
    if isinstance(roll, str) and roll not in get_args(RollRule):
        raise WrongInput(f"roll = {roll!r}: must be one of {get_args(RollRule)} or a number [rad]")
    if yaw != 0:
        raise WrongInput(
            f"yaw = {yaw!r}: must be 0. With yaw the wheel touches ahead of the section through the axle or "
            "behind it, and only this section is searched"
        )
    radius = sum(layout.nominal_radius) / 2
    arm = radius if roll == "about rails" else 0.0
    if isinstance(roll, str):
        turn, left, right = _find_roll(layout, shift, arm, within)
    else:
        turn, (left, right) = float(roll), _minima(layout, shift, arm, float(roll), within)
    axle = float(shift - arm * np.sin(turn))
    position = Position(
        shift=axle,
        shift_at_rails=float(axle + radius * np.sin(turn)),
        given_shift=shift,
        roll=turn,
        heights=(-left[0].gap, -right[0].gap),
        left=_touches(layout.left, left, within),
        right=_touches(layout.right, right, within),
    )
    return _add_notes(layout, position, f"shift = {shift:g} mm")


def settle_wheel(
    layout: Layout,
    side: SideName,
    lateral: float,
    *,
    roll: float = 0.0,
    within: float = SECOND_WITHIN,
) -> Position:
    """One wheel at a given place on its rail, whatever the other one does, as measured on vehicles.

    `lateral` [mm] is the distance of the lowest point of the tape circle to the field side from its place
    under a wheelset that is neither shifted nor rolled; `roll` [rad] is positive where the axle rises to the
    field side. Both are in the axes of the side. The wheel touches at a height of its own: the position has
    no touching points on the other side, and its height there is nan; shift and roll are those of the axle in
    the track. Raises as `settle`.
    """
    for name, value in (("lateral", lateral), ("roll", roll)):
        if not np.isfinite(value):
            raise WrongInput(f"{name} = {value!r}: must be a number")
    own, sign = layout.side(side), 1 if side == "left" else -1
    tape = np.array(own.tape)
    shift = lateral + float(tape[0] - turned(tape, roll)[0])
    minima = gap_minima(own, shift, roll, within / np.cos(STEEPEST))
    touches, height = _touches(own, minima, within), -minima[0].gap
    radius = sum(layout.nominal_radius) / 2
    position = Position(
        shift=sign * shift,
        shift_at_rails=sign * (shift + radius * float(np.sin(roll))),
        given_shift=sign * lateral,
        roll=sign * roll,
        heights=(height, np.nan) if side == "left" else (np.nan, height),
        left=touches if side == "left" else (),
        right=touches if side == "right" else (),
    )
    return _add_notes(layout, position, f"lateral = {lateral:g} mm")


def _add_notes(layout: Layout, position: Position, given: str) -> Position:
    """A position with notes on what is unusual; raises Failure where a wheel has climbed its rail."""
    notes: tuple[str, ...] = ()
    sides: tuple[tuple[SideName, tuple[Touch, ...]], ...] = (
        ("left", position.left),
        ("right", position.right),
    )
    for name, touches in sides:
        for touch in touches[:1]:
            _check_flange(name, layout.side(name), touch, given)
            notes += _unusual(name, layout.side(name), touch)
    return replace(position, notes=notes)


def curves_in_place(layout: Layout, position: Position, side: SideName) -> tuple[Moved, Moved]:
    """Rail and wheel of a side as they touch, in the axes of the side."""
    both = layout.side(side)
    return both.rail, posed(both, *position.pose(side))


def _find_roll(
    layout: Layout, shift: float, arm: float, within: float
) -> tuple[float, list[Minimum], list[Minimum]]:
    """The roll of least size at which both wheels touch at one height of the axle, and both sides' minima.

    The shift is that of the point of the middle plane at the distance `arm` [mm] below the axle. From 0 on
    the roll at which the present touching points are at one height is taken, in bounded steps outwards until
    the root is bracketed, and then confined to it: on a flange the slope changes abruptly. Each roll is
    judged by all minima of the gap.
    """
    roll, low, high = 0.0, -np.inf, np.inf
    first = excess = 0.0
    for k in range(ROLL_STEPS):
        left, right = _minima(layout, shift, arm, roll, within)
        excess = right[0].gap - left[0].gap
        first = excess if k == 0 else first
        if abs(excess) <= HEIGHT_ROUNDING or high - low <= ROLL_ROUNDING:
            return float(roll), left, right
        low, high = (roll, high) if excess > 0 else (low, roll)
        near = _roll_near(layout, shift, arm, roll, (left[0], right[0]))
        outwards = roll + np.copysign(ROLL_STEP, excess)
        if np.isfinite(low) and np.isfinite(high):
            roll = near if low < near < high and k % BISECTED else (low + high) / 2
        else:
            roll = near if low < near < high and abs(near - roll) < ROLL_STEP else outwards
        if abs(roll) > LARGEST_ROLL:
            break
    raise Failure(
        f"shift = {shift:g} mm: no roll up to {LARGEST_ROLL:g} rad brings both wheels into contact. "
        f"Without roll the left wheel rests {first:g} mm higher than the right one, at {roll:g} rad "
        f"{excess:g} mm; give a smaller shift"
    )


def _roll_near(
    layout: Layout, shift: float, arm: float, roll: float, touching: tuple[Minimum, Minimum]
) -> float:
    """The roll at which two touching points, followed from a roll, have one height: Newton's method.

    Where a point is lost it is the roll before; nan where heights do not fall with the roll.
    """
    left, right = touching
    for _ in range(NEWTON_STEPS):
        lever = _lever(layout.left, left, roll, arm) + _lever(layout.right, right, -roll, arm)
        if lever <= 0:
            return np.nan
        step = (right.gap - left.gap) / lever
        roll += step
        axle = shift - arm * np.sin(roll)
        at_left = followed_to(layout.left, left, axle, roll)
        at_right = followed_to(layout.right, right, -axle, -roll)
        if abs(step) * lever <= HEIGHT_ROUNDING or at_left is None or at_right is None:
            break
        left, right = at_left, at_right
    return roll


def _lever(side: Side, minimum: Minimum, roll: float, arm: float) -> float:
    """Fall [mm/rad] of the height of the axle at which a wheel touches, per roll of its side."""
    on_wheel = side.wheel.at(minimum.t_wheel)
    y, z = turned(np.array([on_wheel.y, on_wheel.z]), roll)
    return float(y + (z + arm * np.cos(roll)) * np.tan(minimum.angle))


def _minima(
    layout: Layout, shift: float, arm: float, roll: float, within: float
) -> tuple[list[Minimum], list[Minimum]]:
    """Minima of the gaps of both sides, up to a distance of `within` [mm] of the tangents."""
    axle, gap = shift - arm * np.sin(roll), within / np.cos(STEEPEST)  # the distance is a part of the gap
    return gap_minima(layout.left, axle, roll, gap), gap_minima(layout.right, -axle, -roll, gap)


def _touches(side: Side, minima: list[Minimum], within: float) -> tuple[Touch, ...]:
    """The touching points of a wheel within a distance [mm]."""
    touches = (make_touch(side, minimum, -minima[0].gap) for minimum in minima)
    return tuple(touch for touch in touches if touch.distance <= within)


def make_touch(side: Side, minimum: Minimum, height: float) -> Touch:
    """A touching point from a minimum of the gap, with the axle at a height [mm]."""
    t_rail, t_wheel = minimum.t_rail, minimum.t_wheel
    on_rail, on_wheel = side.rail.at(t_rail), side.wheel.at(t_wheel)
    return Touch(
        s_rail=t_rail,
        s_wheel=t_wheel,
        on_rail=side.rail.unmoved(on_rail),
        on_wheel=side.wheel.unmoved(on_wheel),
        point=np.array([on_rail.y, on_rail.z]),
        angle=minimum.angle,
        radius=-on_wheel.z,
        gap=minimum.gap + height,
        curvature_rail=on_rail.curvature,
        curvature_wheel=on_wheel.curvature,
    )


def _check_flange(name: SideName, side: Side, touch: Touch, given: str) -> None:
    """Raise Failure where a wheel stands on the tip of its flange: no force leads it back to its tread."""
    if touch.s_wheel < side.steepest and touch.angle <= 0:
        raise Failure(
            f"{given}: the {name} wheel has climbed the rail and stands on the tip of its flange, "
            f"{side.steepest - touch.s_wheel:.3f} mm beyond the steepest part, at a contact angle of "
            f"{np.degrees(touch.angle):.2f} degrees. No force brings it back; give a smaller shift"
        )


def _unusual(name: SideName, side: Side, touch: Touch) -> tuple[str, ...]:
    """Sentences about a touching point that is not where wheels usually touch."""
    notes = []
    if touch.s_wheel < side.steepest:
        wheel = side.wheel.at(side.steepest)
        climbs = bool(touch.curvature_wheel < 0 < touch.curvature_rail)  # docs/theory/wheel-on-rail.md
        notes.append(
            f"touches {side.steepest - touch.s_wheel:.2f} mm beyond the steepest part of its flange "
            f"({np.degrees(np.arctan2(wheel.t_z, wheel.t_y)):.1f} degrees), at {np.degrees(touch.angle):.1f} "
            f"degrees{': the angle falls as it climbs, so a constant lateral force lifts it on' * climbs}"
        )
    for part, curve, s, place in (
        ("rail", side.rail, touch.s_rail, touch.on_rail),
        ("wheel", side.wheel, touch.s_wheel, touch.on_wheel),
    ):
        to_end = min(s, curve.limits[1] - s)
        if to_end < NEAR_END:
            notes.append(
                f"touches {to_end:.2f} mm from the end of the profile of the {part}, at its (y, z) = "
                f"({place[0]:.2f}, {place[1]:.2f}) mm; extend the profile"
            )
    if -touch.point[1] > DEEP:
        notes.append(
            f"touches the rail {-touch.point[1]:.1f} mm below its top, at (y, z) = "
            f"({touch.on_rail[0]:.2f}, {touch.on_rail[1]:.2f}) mm of its profile; check that the profile "
            "is real there"
        )
    return tuple(f"the {name} wheel {note}" for note in notes)


# --- many shifts ---

MOVE = 0.2  # mm along rail or wheel: a touching point that moves more within JUMP_WIDTH jumps
JUMP_WIDTH = 1e-6  # mm of shift
CONTINUOUS = 0.5  # mm: a move below this between neighbouring shifts is not looked into


@dataclass(frozen=True, eq=False)
class Jump:
    """A shift [mm] at which the touching point of a side jumps: the positions next to it.

    The wheel touches there at two points: the rolling radius jumps, roll and height do not.
    """

    side: SideName
    before: Position
    after: Position

    @property
    def shift(self) -> float:
        """Shift [mm] of the jump, within half of `JUMP_WIDTH`."""
        return (self.before.given_shift + self.after.given_shift) / 2

    @property
    def touches(self) -> tuple[Touch, Touch]:
        """The touching points before and after."""
        return _touch(self.before, self.side), _touch(self.after, self.side)


@dataclass(frozen=True, eq=False)
class Shifts:
    """Positions at growing shifts, and the jumps between them."""

    positions: tuple[Position, ...]
    jumps: tuple[Jump, ...]

    def rolling_radius_differences(self) -> tuple[Array, Array]:
        """Shifts and rolling-radius differences [mm], (n,) each, with both values on either side of jumps."""
        beside = [position for jump in self.jumps for position in (jump.before, jump.after)]
        ordered = sorted([*self.positions, *beside], key=lambda position: position.given_shift)
        return (
            np.array([position.given_shift for position in ordered]),
            np.array([position.rolling_radius_difference for position in ordered]),
        )


def over_shifts(
    layout: Layout,
    shifts: ArrayLike,
    *,
    roll: float | RollRule = "about axle",
    within: float = SECOND_WITHIN,
) -> Shifts:
    """The wheelset at growing shifts [mm]; `roll` and `within` are those of `settle`.

    Where the touching point of a side moves by more than 0.5 mm from one shift to the next, the interval
    is halved until the move is small or the interval is: the move is then a jump. One jump a side is sought
    in an interval.
    """
    shifts = np.asarray(shifts, dtype=float)
    if shifts.ndim != 1 or len(shifts) == 0 or not np.all(np.diff(shifts) > 0):
        raise WrongInput(f"shifts = {shifts}: must be numbers (n,), at least one, and grow")
    positions = tuple(settle(layout, float(shift), roll=roll, within=within) for shift in shifts)
    sides: tuple[SideName, SideName] = ("left", "right")
    found = [
        _jump(layout, before, after, side, roll)
        for before, after in pairwise(positions)
        for side in sides
        if _move(before, after, side) > CONTINUOUS
    ]
    jumps = (jump for jump in found if jump is not None)
    return Shifts(positions, tuple(sorted(jumps, key=lambda jump: jump.shift)))


def _jump(
    layout: Layout, before: Position, after: Position, side: SideName, roll: float | RollRule
) -> Jump | None:
    """The jump between two positions by halving: always the half in which the point moves more."""
    while after.given_shift - before.given_shift > JUMP_WIDTH:
        if _move(before, after, side) < MOVE:
            return None
        middle = settle(layout, (before.given_shift + after.given_shift) / 2, roll=roll)
        first = _move(before, middle, side) > _move(middle, after, side)
        before, after = (before, middle) if first else (middle, after)
    return Jump(side, before, after) if _move(before, after, side) >= MOVE else None


def _move(before: Position, after: Position, side: SideName) -> float:
    """How far [mm] the touching point of a side moves along rail or wheel."""
    first, second = _touch(before, side), _touch(after, side)
    return max(abs(second.s_rail - first.s_rail), abs(second.s_wheel - first.s_wheel))


def _touch(position: Position, side: SideName) -> Touch:
    """The touching point of a side."""
    return position.left[0] if side == "left" else position.right[0]
