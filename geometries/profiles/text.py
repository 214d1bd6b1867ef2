"""Text files of profiles: lines, comments, numbers and points; errors name the file and the line.

Points keep the lines they came from; repeated ones and zigzags are left out.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy

from geometries.arrays import Array, Indices, Mask
from geometries.errors import WrongInput

# --- lines and numbers ---

MAX_BYTES = 20_000_000  # of a file; the largest measured profiles have less than 1 MB
MAX_POINTS = 200_000
LARGEST = 1e7  # magnitude of a coordinate in the unit of its file
LONGEST = 64  # number of characters of a number

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity)", re.IGNORECASE | re.ASCII)
BINARY = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
QUOTED = re.compile(r"""(?<![^\s,;])(["'])[ \t]*([-+]?\.?\d[-+.,\deEdD]*)[ \t]*\1(?![^\s,;])""")  # a number
LINE_END = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Source:
    """A text file as lines without their ends; the first has the number 1."""

    path: Path
    lines: tuple[str, ...]

    def wrong(self, line: int, text: str) -> WrongInput:
        """Error at a line of this file."""
        return WrongInput(f"{self.path}, line {line}: {text}")

    def refused(self, text: str) -> WrongInput:
        """Error of the file as a whole."""
        return WrongInput(f"{self.path}: {text}")


def read_source(path: Path) -> Source:
    """Lines of a text file. Raises WrongInput for what is no file, too large, empty or binary."""
    if "\0" in str(path):
        raise WrongInput(f"path = {str(path)!r}: no path; give the path of a profile")
    try:
        data = _read_bytes(path)
    except OSError as error:
        raise WrongInput(f"{path}: cannot be read ({error.strerror}); give the path of a profile") from None
    return parse_source(path, data)


def _read_bytes(path: Path) -> bytes:
    """Content of a file that is not too large."""
    size = path.stat().st_size
    if not path.is_file():
        raise WrongInput(f"{path}: not a file; give the path of a profile")
    if size > MAX_BYTES:
        raise WrongInput(
            f"{path}: {size} bytes; profiles have {MAX_BYTES} at most: thin the points out, or check the path"
        )
    return path.read_bytes()


def parse_source(path: Path, data: bytes) -> Source:
    """Lines of the bytes of a file, numbers without quotes. Raises WrongInput where they are no text."""
    data = data.rstrip(b"\x1a")  # end of file of old systems
    if binary := BINARY.search(data):
        line = len(re.findall(rb"\r\n|\r|\n", data[: binary.start()])) + 1
        raise WrongInput(f"{path}, line {line}: byte {binary[0][0]} is no text; save the file as plain text")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if not text.strip():
        raise WrongInput(f"{path}, line 1: the file is empty; it must hold the points of a profile")
    return Source(path, tuple(LINE_END.split(QUOTED.sub(r"\2", text))))


def uncommented(line: str, marks: str) -> str:
    """The line before the first of the comment marks, without blanks at its ends."""
    for mark in marks:
        if mark in line:
            line = line.partition(mark)[0]
    return line.strip()


def is_number(token: str) -> bool:
    """Whether a token is written as a finite decimal number."""
    return len(token) <= LONGEST and NUMBER.fullmatch(token) is not None


def number(source: Source, line: int, token: str, name: str) -> float:
    """Value of a token. Raises WrongInput where it is no number, not finite, or huge."""
    if not is_number(token):
        if NOT_FINITE.fullmatch(token):
            raise source.wrong(line, f"{name} = {token}: not a finite number; delete the line or correct it")
        raise source.wrong(
            line, f"{name} = {shortened(token)}: not a number; correct it, or make the line a comment"
        )
    value = as_float(token)
    if not abs(value) <= LARGEST:
        raise source.wrong(line, f"{name} = {shortened(token)}: larger than {LARGEST:g}; correct it")
    return value


def as_float(token: str) -> float:
    """Value of a number, also with the exponents of Fortran (1.0D+00)."""
    return float(token.lower().replace("d", "e"))


def split_columns(source: Source, line: int, text: str) -> list[str]:
    """Fields of a row, separated by blanks, commas or semicolons. Raises WrongInput for decimal commas."""
    if "," not in text and ";" not in text:
        return text.split()
    fields = [field for field in re.split(r"[\s,;]+", text) if field]
    mixed = re.search(r"\d,\d", text) and (re.search(r"\d[\s;]+[-+\d]", text) or text.count(",") > 1)
    if mixed and "." not in text:
        raise source.wrong(
            line, f"{shortened(text)}: looks like decimal commas; write a point before the decimals"
        )
    return fields


def shortened(text: str) -> str:
    """Text in quotes, cut to what fits into a message."""
    return repr(text if len(text) <= 40 else text[:37] + "...")


# --- last decimals ---

AROUND = 21  # coordinates among which the last decimal is sought
SHARE = 0.4  # of them that may have a finer one: nine of ten numbers do not end in 0
SAME_STEP = 1e-6  # of a step: rounding of the differences of decimal numbers


def steps_as_written(tokens: Sequence[str], values: Array) -> Array:
    """Steps of the last decimals of a column, in its unit, for each of its numbers, (n,).

    A number's own last decimal is that of its last digit; zeros at the end of its decimals are no digits,
    since many programs fill up with them. A few finer numbers among coarse ones change nothing, nor do zeros
    that a single number happens to end in; formats with a fixed number of digits are followed. Numbers that
    repeat their predecessor say nothing. A column that goes on by equal steps was not rounded but chosen: its
    step is 0.
    """
    places = np.array([last_place(token) for token in tokens], dtype=float)
    new = np.append(True, np.diff(values) != 0)
    around = scipy.ndimage.percentile_filter(places[new], 100 * SHARE, size=AROUND, mode="mirror")
    steps = 10.0 ** around[np.cumsum(new) - 1]
    return np.where(_regular(values), 0.0, steps)


def last_place(token: str) -> int:
    """Power of ten of the last digit of a number, zeros at the end of its decimals left out."""
    mantissa, _, exponent = token.lower().replace("d", "e").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2].rstrip("0"))


def _regular(values: Array) -> Array:
    """Whether all steps around each number of a column are equal and not 0, (n,)."""
    steps = np.diff(values)
    low, high = (
        each(steps, AROUND, mode="nearest")
        for each in (scipy.ndimage.minimum_filter1d, scipy.ndimage.maximum_filter1d)
    )
    equal = (low * high > 0) & (high - low <= SAME_STEP * np.abs(high))
    return np.append(equal, equal[-1:])


# --- points ---

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
