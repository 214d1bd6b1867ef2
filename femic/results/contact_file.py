"""Write and read files of numerical influence coefficients for the program CONTACT (option C3 = 9).

The layout follows CONTACT's reader, which differs from its user guide; docs/how-to/contact-file.md shows it.
An entry is the displacement difference upper minus lower body [mm] due to traction on one element of the
upper body, times the combined shear modulus over this traction, in local directions. Entries are given for
lags ix >= 0 only: for ix < 0 the reader changes the signs of nx, xn, xs and sx.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from femic.cache.files import replacing
from geometries.arrays import Array
from geometries.errors import WrongInput

COLUMN_NAMES = ("nn", "nx", "ns", "xn", "xx", "xs", "sn", "sx", "ss")  # in the order of the columns
ROWS, COLUMNS = [2, 2, 2, 0, 0, 0, 1, 1, 1], [2, 0, 1, 2, 0, 1, 2, 0, 1]  # as indices of x, s, n
NO_QUASI_IDENTITY, ORDER_OF_DIRECTIONS = 0, 312  # numbers that the reader requires
MIRRORED_IN_X, MIRRORED_IN_S = 1, 0
SKIPPED_PER_STRIP, SKIPPED_PER_OFFSET = 4, 2  # lines that the reader skips
HEADER = 4  # lines


@dataclass(frozen=True, eq=False)
class ContactFile:
    """The content of such a file.

    `values` (n_matrix, 2 n_s - 1, n_x, 3, 3) [mm] has the axes: loaded strip (one matrix for all strips if
    the ICs do not depend on it), offset of the observing strip, starting at -(n_s - 1), lag, displacement and
    traction in the order x, s, n. `dx` and `ds` [mm] are the sides of an element. `convex` is the number of
    the convex body: 1 for the upper, 2 for the lower one. Raises WrongInput if shapes or values do not fit.
    """

    values: Array
    dx: float
    ds: float
    convex: int

    def __post_init__(self) -> None:
        shape = self.values.shape
        if len(shape) != 5 or shape[1] % 2 == 0 or shape[3:] != (3, 3) or shape[0] not in (1, self.n_s):
            raise WrongInput(f"values of shape {shape}: (1 or n_s, 2 n_s - 1, n_x, 3, 3) is needed")
        if self.convex not in (1, 2):
            raise WrongInput(f"convex = {self.convex!r}: 1 (the upper body) or 2 (the lower one)")
        if not (0 < self.dx < np.inf and 0 < self.ds < np.inf):
            raise WrongInput(f"dx = {self.dx!r}, ds = {self.ds!r}: must be positive and finite [mm]")
        if not np.all(np.isfinite(self.values)):
            raise WrongInput(f"values: {np.sum(~np.isfinite(self.values))} are not finite")

    @property
    def n_s(self) -> int:
        """The number of strips."""
        return (self.values.shape[1] + 1) // 2

    @property
    def n_x(self) -> int:
        """The number of lags."""
        return int(self.values.shape[2])

    @property
    def one_for_all(self) -> bool:
        """Whether one matrix holds for all loaded strips: ICs depend on the offset of the strips only."""
        return len(self.values) == 1


def by_offsets(ics: Array) -> Array:
    """Arrange ICs (n_x, n_s, n_s, 3, 3) of observing and loaded strips by offset, in the same unit.

    Returns (n_s, 2 n_s - 1, n_x, 3, 3), with zeros at offsets that lead out of the grid.
    """
    n_x, n_s = ics.shape[:2]
    values = np.zeros((n_s, 2 * n_s - 1, n_x, 3, 3))
    for loaded in range(n_s):
        first = n_s - 1 - loaded
        values[loaded, first : first + n_s] = np.swapaxes(ics[:, :, loaded], 0, 1)
    return values


def common_by_offsets(ics: Array) -> Array:
    """Arrange ICs (n_x, n_s, n_s, 3, 3) by offset if they do not depend on the loaded strip.

    Returns (1, 2 n_s - 1, n_x, 3, 3) in the same unit.
    """
    backward, forward = ics[:, :-1, -1], ics[:, :, 0]
    return np.concatenate([backward, forward], axis=1).swapaxes(0, 1)[None]


def write(file: ContactFile, path: Path) -> None:
    """Write a file, every number with all of its digits."""
    with replacing(path) as unfinished, unfinished.open("w", encoding="ascii") as out:
        out.writelines(f"{line}\n" for line in _lines(file))


def _lines(file: ContactFile) -> Iterator[str]:
    n_s = file.n_s
    yield f"{len(file.values)} {file.convex}"
    yield f"{NO_QUASI_IDENTITY} {ORDER_OF_DIRECTIONS}"
    yield f"{MIRRORED_IN_X} {MIRRORED_IN_S}"
    yield f"{file.n_x} {n_s} {float(file.dx)!r} {float(file.ds)!r}"
    for strip, strip_values in enumerate(file.values):
        if not file.one_for_all:
            yield f"% load on strip {strip + 1} of {n_s}"
            yield from ["%"] * (SKIPPED_PER_STRIP - 1)
        for offset, offset_values in zip(range(1 - n_s, n_s), strip_values, strict=True):
            yield f"% iy = {offset}"
            yield "% ix x " + " ".join(f"C{name}" for name in COLUMN_NAMES)
            for ix, coefficients in enumerate(offset_values[:, ROWS, COLUMNS].tolist()):
                yield f"{ix} {ix * file.dx:.10g} " + " ".join(map(repr, coefficients))


def read(path: Path) -> ContactFile:
    """Read a file as CONTACT does; raises WrongInput, naming the line, where CONTACT would stop."""
    with path.open(encoding="ascii", errors="replace") as lines:
        n_matrix, convex, n_x, n_s, dx, ds = _header(path, lines)
        values = np.empty((n_matrix, 2 * n_s - 1, n_x, 3, 3))
        lines_before = HEADER
        for strip_values in values:
            lines_before += len(list(islice(lines, SKIPPED_PER_STRIP if n_matrix > 1 else 0)))
            for offset_values in strip_values:
                lines_before += len(list(islice(lines, SKIPPED_PER_OFFSET)))
                offset_values[:, ROWS, COLUMNS] = _numbers(path, lines, lines_before, n_x)
                lines_before += n_x
    return ContactFile(values, dx, ds, convex)


def _header(path: Path, lines: TextIO) -> tuple[int, int, int, int, float, float]:
    header = [line.split() for line in islice(lines, HEADER)]
    try:
        (n_matrix, convex), quasi, mirrored = ([int(word) for word in line[:2]] for line in header[:3])
        n_x, n_s, dx, ds = (
            kind(word) for kind, word in zip((int, int, float, float), header[3], strict=False)
        )
    except (IndexError, ValueError) as error:
        raise WrongInput(
            f"{path}: the first {HEADER} lines must be n_matrix iaconvex / 0 312 / 1 0 / mx my dx dy"
        ) from error
    for line_number, found_numbers, only_numbers in (
        (2, quasi, [NO_QUASI_IDENTITY, ORDER_OF_DIRECTIONS]),
        (3, mirrored, [MIRRORED_IN_X, MIRRORED_IN_S]),
    ):
        if found_numbers != only_numbers:
            raise WrongInput(f"{path}, line {line_number}: {found_numbers}; only {only_numbers} is read")
    if n_matrix not in (1, n_s) or n_x < 1 or n_s < 1:
        raise WrongInput(f"{path}: n_matrix = {n_matrix}, mx = {n_x}, my = {n_s}: n_matrix must be 1 or my")
    return n_matrix, convex, n_x, n_s, dx, ds


def _numbers(path: Path, lines: TextIO, lines_before: int, n_x: int) -> list[list[float]]:
    """Read the nine columns of n_x lines; `lines_before` is the number of lines before them."""
    rows = []
    for ix in range(n_x):
        words = next(lines, "").split()
        try:
            numbers = [float(word) for word in words[2:]]
        except ValueError:
            numbers = []
        if len(numbers) != len(COLUMN_NAMES) or words[0] != str(ix):
            raise WrongInput(f"{path}, line {lines_before + ix + 1}: expected ix = {ix}, x and nine numbers")
        rows.append(numbers)
    return rows
