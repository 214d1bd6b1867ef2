"""Columns of numbers in text files: points of contours, and of extra gaps."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from femic.key_types import LARGEST_LENGTH
from geometries.arrays import Array
from geometries.errors import WrongInput


def columns(path: Path, headings: Sequence[str]) -> Array:
    """Return lengths [mm] in columns of one of the headings, such as "y, z", shape (rows, columns).

    They are separated by blanks; # begins a comment. Raise WrongInput that names the line with anything else.
    """
    counts = {len(heading.split(", ")) for heading in headings}
    expected = f"{' or '.join(headings)}, separated by blanks"
    rows: list[list[float]] = []
    for number, cells in _lines(path):
        if len(cells) not in counts or (rows and len(cells) != len(rows[0])):
            before = f", {len(rows[0])} before" if rows else ""
            raise WrongInput(f"line {number}: {len(cells)} columns{before}; give {expected}")
        rows.append([_length(cell, number) for cell in cells])
    if not rows:
        raise WrongInput(f"no numbers; give columns {expected}")
    return np.array(rows)


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the numbers and cells of lines that have some."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise WrongInput(
            f"not a text in UTF-8 ({error.reason} at byte {error.start}): save it as such"
        ) from error
    for number, line in enumerate(text.splitlines(), start=1):
        if cells := line.partition("#")[0].split():
            yield number, cells


def _length(cell: str, line: int) -> float:
    """Return a number of a cell."""
    try:
        value = float(cell)
    except ValueError:
        value = np.nan
    if "_" in cell or not abs(value) <= LARGEST_LENGTH:
        raise WrongInput(
            f"line {line}: {cell[:40]!r}: give a number, at most {LARGEST_LENGTH:g}, such as 1.5 or -2e-3"
        )
    return value
