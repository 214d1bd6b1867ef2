"""Points with the lines of the file they came from, and what is left out of them."""

import math
from dataclasses import dataclass, replace

import numpy as np

from geometries.arrays import Array, Indices, Mask

DUPLICATE = 1e-6  # distance [mm] below which two points are one
NEAREST, NEAR = 5e-3, 0.02  # mm and share of the median spacing: the lower is the least distance of points
ZIGZAG_PASSES = 100
ZIGZAG = 5  # largest way back of a zigzag, as a multiple of the median spacing
FOLD = math.radians(150)  # turn at a single point beyond which the contour would lie on itself
GAP = 10  # spacing that is reported, as a multiple of the median spacing


@dataclass(frozen=True, eq=False)
class Rows:
    """Points (y, z), shape (2, n), in the order of the file, and the number of its line for each, (n,).

    `steps` are those of the last decimals of y and z, (2, n), along the axes and in the unit of the points.
    """

    points: Array
    lines: Indices
    steps: Array

    def only(self, keep: Mask | Indices | slice) -> "Rows":
        """The points that `keep` selects: a mask, a slice, or indices."""
        return Rows(self.points[:, keep], self.lines[keep], self.steps[:, keep])

    def moved(self, points: Array) -> "Rows":
        """The same points shifted, mirrored, or clipped."""
        return replace(self, points=points)

    def scaled(self, factor: float) -> "Rows":
        """The same points in another unit."""
        return replace(self, points=self.points * factor, steps=self.steps * factor)

    def turned(self, turn: Array) -> "Rows":
        """The same points turned by an orthogonal matrix (2, 2): variances of y and z mix."""
        return replace(self, points=turn @ self.points, steps=np.sqrt(turn**2 @ self.steps**2))

    @property
    def count(self) -> int:
        """Number of points."""
        return self.points.shape[1]


def drop_near(rows: Rows, distance: float, *, both_ends: bool = False) -> tuple[Rows, list[str]]:
    """Without the points that are no farther than `distance` from the last one left; a note if any.

    With `both_ends` the last point stays instead of those before it.
    """
    steps = np.hypot(*np.diff(rows.points, axis=1))
    if not np.any(steps <= distance):
        return rows, []
    keep = _spaced(rows.points, distance)
    if both_ends and len(keep) > 1:
        keep[-1] = rows.count - 1
    left_out = np.setdiff1d(np.arange(rows.count), keep)
    first = int(rows.lines[left_out[0]])
    return rows.only(keep), [
        f"{len(left_out)} points repeat the one before them and were left out (the first in line {first})."
        if distance <= DUPLICATE
        else f"{len(left_out)} points nearer than {distance:.3g} to the one before were left out "
        f"(the first in line {first})."
    ]


def nearest(rows: Rows) -> float:
    """Distance [mm] below which points in mm are one: it shows no shape, and makes a kink of any error."""
    if rows.count < 2:
        return DUPLICATE
    usual = float(np.median(np.hypot(*np.diff(rows.points, axis=1))))
    return max(DUPLICATE, min(NEAREST, NEAR * usual))


def _spaced(points: Array, distance: float) -> Indices:
    """Indices of points, each farther than `distance` from the one before."""
    y, z = points.tolist()
    keep = [0]
    for k in range(1, len(y)):
        if math.hypot(y[k] - y[keep[-1]], z[k] - z[keep[-1]]) > distance:
            keep.append(k)
    return np.array(keep)


def turns(points: Array) -> Array:
    """Angles [rad] by which the polyline turns left at its inner points, (n - 2,)."""
    (y, z), (y_next, z_next) = np.diff(points, axis=1)[:, :-1], np.diff(points, axis=1)[:, 1:]
    return np.arctan2(y * z_next - z * y_next, y * y_next + z * z_next)


def drop_zigzags(rows: Rows) -> tuple[Rows, list[str]]:
    """Without zigzags: the polyline turns back (by more than 90 degrees), turns back again, and goes on.

    All points where it turns go, so that the order of the points does not matter. Repeated until none is
    left, `ZIGZAG_PASSES` times at most: what is left then is refused as a fold or a crossing.
    """
    before = rows
    for _ in range(ZIGZAG_PASSES):
        if rows.count < 4:
            break
        zigzag = _zigzags(rows.points)
        if not np.any(zigzag):
            break
        rows = rows.only(~zigzag)
    if rows is before:
        return rows, []
    lines = np.setdiff1d(before.lines, rows.lines)
    where = ", ".join(str(line) for line in lines[:6]) + (", ..." if len(lines) > 6 else "")
    return rows, [f"{len(lines)} points of zigzags were left out (lines {where})."]


def _zigzags(points: Array) -> Mask:
    """Whether each point is one of two neighbours of a zigzag, (n,)."""
    chords = np.diff(points, axis=1)
    back = np.sum(chords[:, 1:] * chords[:, :-1], axis=0) < 0  # at the points 1 ... n - 2
    on = np.sum(chords[:, 2:] * chords[:, :-2], axis=0) > 0
    steps = np.hypot(*chords)
    short = steps[1:-1] <= ZIGZAG * np.median(steps)
    first = np.flatnonzero(back[:-1] & back[1:] & on & short) + 1
    zigzag = np.zeros(points.shape[1], dtype=bool)
    zigzag[first] = zigzag[first + 1] = True
    return zigzag


def first_fold(rows: Rows) -> int | None:
    """Index of the first point at which the polyline turns back on itself, or None."""
    folds = np.flatnonzero(np.abs(turns(rows.points)) > FOLD)
    return int(folds[0]) + 1 if len(folds) else None


def note_gaps(rows: Rows) -> list[str]:
    """A note on steps larger than `GAP` times the median step."""
    steps = np.hypot(*np.diff(rows.points, axis=1))
    gaps = np.flatnonzero(steps > GAP * np.median(steps))
    if not len(gaps):
        return []
    k = int(gaps[np.argmax(steps[gaps])])
    return [
        f"{len(gaps)} gaps are larger than {GAP} times the median spacing of {np.median(steps):.3g} mm; the "
        f"largest, {steps[k]:.3g} mm, lies between lines {rows.lines[k]} and {rows.lines[k + 1]}."
    ]
