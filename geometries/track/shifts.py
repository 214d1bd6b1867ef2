"""A wheelset at many shifts: curves of its radii and angles, and the jumps of its touching points."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.track.layout import Layout
from geometries.track.wheelset import SECOND_WITHIN, Position, RollRule, SideName, Touch, settle

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
