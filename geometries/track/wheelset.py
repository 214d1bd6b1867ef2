"""The position of a wheelset: its roll and height follow from both wheels touching their rails."""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.track.curves import Moved, turned
from geometries.track.graphs import STEEPEST
from geometries.track.layout import Layout, Side
from geometries.track.touching import Minimum, gap_minima, posed

ROLL_STEP = 1e-3  # rad: the search of the roll goes outwards in such steps at most
ROLL_STEPS = 200
HEIGHT_ROUNDING = 2e-12  # mm: left and right
LARGEST_ROLL = 0.1  # rad
ROLL_ROUNDING = 1e-16  # rad
SECOND_WITHIN = 0.1  # mm: default distance below which a second touching point is reported

SideName = Literal["left", "right"]
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
    roll was given. `left` and `right` are the touching points, the least gap first.
    """

    shift: float
    shift_at_rails: float
    given_shift: float
    roll: float
    heights: tuple[float, float]
    left: tuple[Touch, ...]
    right: tuple[Touch, ...]

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

    Touching points up to `within` [mm] of distance are reported. Raises Failure where a wheel climbs its
    rail, and WrongInput for a yaw.
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
    turn = _roll(layout, shift, arm) if isinstance(roll, str) else float(roll)
    axle = float(shift - arm * np.sin(turn))
    left = _touches(layout.left, axle, turn, within)
    right = _touches(layout.right, -axle, -turn, within)
    at_rails = float(axle + radius * np.sin(turn))
    position = Position(axle, at_rails, shift, turn, (left[0], right[0]), left[1], right[1])
    _check_flange("left", layout.left, position)
    _check_flange("right", layout.right, position)
    return position


def side_of(layout: Layout, name: SideName) -> Side:
    """The side of a name."""
    if name not in {"left", "right"}:
        raise WrongInput(f"side = {name!r}: must be 'left' or 'right'")
    return layout.left if name == "left" else layout.right


def curves_in_place(layout: Layout, position: Position, side: SideName) -> tuple[Moved, Moved]:
    """Rail and wheel of a side as they touch, in the axes of the side."""
    both = side_of(layout, side)
    return both.rail, posed(both, *position.pose(side))


def _roll(layout: Layout, shift: float, arm: float) -> float:
    """The roll of least size at which both wheels touch at one height of the axle.

    The shift is that of the point of the middle plane at the distance `arm` [mm] below the axle. Newton's
    method from 0 on, in bounded steps outwards until the root is bracketed, and then confined to it: on a
    flange the slope changes abruptly.
    """
    roll, low, high = 0.0, -np.inf, np.inf
    first = excess = 0.0
    for k in range(ROLL_STEPS):
        left, right = _resting(layout.left, shift, roll, arm), _resting(layout.right, -shift, -roll, arm)
        excess = left[0] - right[0]
        first = excess if k == 0 else first
        if abs(excess) <= HEIGHT_ROUNDING or high - low <= ROLL_ROUNDING:
            return float(roll)
        low, high = (roll, high) if excess > 0 else (low, roll)
        newton = roll + excess / lever if (lever := left[1] + right[1]) > 0 else np.nan
        outwards = roll + np.copysign(ROLL_STEP, excess)
        if np.isfinite(low) and np.isfinite(high):
            roll = newton if low < newton < high else (low + high) / 2
        else:
            roll = newton if abs(newton - roll) < ROLL_STEP else outwards
        if abs(roll) > LARGEST_ROLL:
            break
    raise Failure(
        f"shift = {shift:g} mm: no roll up to {LARGEST_ROLL:g} rad lets both wheels touch: without roll the "
        f"left wheel rests {first:g} mm higher than the right one, at {roll:g} rad {excess:g} mm; "
        "take a smaller shift"
    )


def _resting(side: Side, shift: float, roll: float, arm: float) -> tuple[float, float]:
    """Height [mm] of the axle at which a wheel touches, and its fall per roll of its side [mm]."""
    minimum = gap_minima(side, shift - arm * np.sin(roll), roll)[0]
    y, z = turned(side.wheel.position(minimum.t_wheel), roll)
    return -minimum.gap, float(y + (z + arm * np.cos(roll)) * np.tan(minimum.angle))


def _touches(side: Side, shift: float, roll: float, within: float) -> tuple[float, tuple[Touch, ...]]:
    """Height of the axle, and the touching points of a wheel within a distance [mm]."""
    minima = gap_minima(side, shift, roll, within / np.cos(STEEPEST))  # the distance is a part of the gap
    height = -minima[0].gap
    touches = (touch_of(side, minimum, height) for minimum in minima)
    return height, tuple(touch for touch in touches if touch.distance <= within)


def touch_of(side: Side, minimum: Minimum, height: float) -> Touch:
    """A touching point from a minimum of the gap, with the axle at a height [mm]."""
    t_rail, t_wheel = minimum.t_rail, minimum.t_wheel
    return Touch(
        s_rail=t_rail,
        s_wheel=t_wheel,
        on_rail=side.rail.curve.position(np.array(t_rail)),
        on_wheel=side.wheel.curve.position(np.array(t_wheel)),
        point=side.rail.position(t_rail),
        angle=minimum.angle,
        radius=-float(side.wheel.position(t_wheel)[1]),
        gap=minimum.gap + height,
        curvature_rail=float(side.rail.curvature(t_rail)),
        curvature_wheel=float(side.wheel.curvature(t_wheel)),
    )


def _check_flange(name: str, side: Side, position: Position) -> None:
    """Raise Failure if a wheel touches beyond the steepest part of its flange."""
    touch = position.left[0] if name == "left" else position.right[0]
    if touch.s_wheel >= side.steepest:
        return
    largest = float(np.arctan2(*side.wheel.tangent(side.steepest)[::-1]))
    raise Failure(
        f"shift = {position.given_shift:g} mm: the {name} wheel climbs its rail. It touches "
        f"{side.steepest - touch.s_wheel:.3f} mm beyond the steepest part of its flange "
        f"({np.degrees(largest):.2f} degrees), at a contact angle of {np.degrees(touch.angle):.2f} degrees, "
        f"with the axle at {position.height:.3f} mm and a roll of {1e3 * position.roll:.3f} mrad; "
        "take a smaller shift"
    )
