"""Tables of points in CSV: a header line with the names of the axes, and a row of values for each point.

Cells are separated by commas, semicolons or tabs; the text is UTF-8 or UTF-16. Decimal commas are read where
semicolons separate the cells. Ambiguous cells are refused with their line.
"""

import csv
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

from femic.scenes.errors import BadScene
from femic.scenes.values import SHOWN, Value, value_of

SEPARATORS = ",;\t"
LONGEST = csv.field_size_limit()  # characters of a cell
WITH_COMMA = re.compile(r"[+-]?([0-9]+,[0-9]*|,[0-9]+)([eE][+-]?[0-9]+)?")
WITH_POINT = re.compile(r"[+-]?([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class _Row:
    """A row of a table: the line where it ends, and its cells."""

    line: int
    cells: list[str]


def points_in(path: Path, axes: Sequence[str]) -> list[tuple[Value, ...]]:
    """Return the values of the axes by row; raise BadScene with line and reason for unclear tables."""
    text = _text(path)
    separator = _separator(path, text, axes)
    header, *rows = _rows(path, text, separator)
    _require_columns(path, header, rows, axes)
    places = [header.cells.index(name) for name in axes]
    commas = separator == ";" and any(WITH_COMMA.fullmatch(row.cells[k]) for row in rows for k in places)
    points = []
    for row in rows:
        try:
            points.append(tuple(_value(row.cells[k], decimal_commas=commas) for k in places))
        except BadScene as error:
            raise BadScene(f"{path}, line {row.line}: {error}") from error
    return points


def _text(path: Path) -> str:
    """Return the text of a table; raise BadScene for encodings other than UTF-8 and marked UTF-16."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadScene(f"{path}: cannot be read: {error}") from error
    encoding = "utf-16" if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise BadScene(
            f"{path}, line {line}: is not text in {encoding.upper().removesuffix('-SIG')}: save the table as "
            "CSV in UTF-8"
        ) from error
    if "\0" in text:
        raise BadScene(f"{path}: is not text in UTF-8: save the table as CSV in UTF-8")
    return text


def _separator(path: Path, text: str, axes: Sequence[str]) -> str:
    """Return the separator with which the first line has the names of the axes; raise BadScene."""
    headers: list[list[str]] = []
    for separator in SEPARATORS:
        with suppress(BadScene):  # quotes may be in order with another separator
            headers.append(next(_rows(path, text, separator), _Row(1, [])).cells)
            if {*axes} <= {*headers[-1]}:
                return separator
    columns = max(headers, key=len, default=[])
    missing = ", ".join(name for name in axes if name not in columns)
    raise BadScene(
        f"{path}, line 1: no column {missing}; columns are {', '.join(columns)[:80] or 'none'}: separate "
        "them by commas, semicolons or tabs"
    )


def _rows(path: Path, text: str, separator: str) -> Iterator[_Row]:
    """Yield the rows of a table without the empty ones, the header first; raise BadScene."""
    reader = csv.reader(StringIO(text, newline=""), delimiter=separator, skipinitialspace=True, strict=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield _Row(reader.line_num, [cell.strip() for cell in cells])
    except csv.Error as error:
        reason = str(error).replace(
            "field larger than field limit", "a cell has more characters than allowed"
        )
        raise BadScene(f"{path}, line {reader.line_num}: not CSV: {reason}") from error


def _require_columns(path: Path, header: _Row, rows: Sequence[_Row], axes: Sequence[str]) -> None:
    """Raise BadScene where a column is there twice, or a row has other cells than there are columns."""
    twice = [name for name, count in Counter(header.cells).items() if name and count > 1]
    if twice:
        raise BadScene(f"{path}, line {header.line}: column {', '.join(twice)} is there twice: remove one")
    if not rows:
        raise BadScene(f"{path}: no rows below the header: add one for each point")
    columns = len(header.cells)
    for row in rows:
        if len(row.cells) != columns:
            raise BadScene(
                f"{path}, line {row.line}: cells: {len(row.cells)}, columns: {columns}: fill every cell, "
                "write decimals with a point, and text with separators in double quotes"
            )
        empty = [
            name for name, cell in zip(header.cells, row.cells, strict=True) if name in axes and not cell
        ]
        if empty:
            raise BadScene(f"{path}, line {row.line}: {', '.join(empty)}: no value: add it")


def _value(cell: str, *, decimal_commas: bool) -> Value:
    """Return the value of a cell; raise BadScene where decimals are written in two ways, or ambiguously."""
    if decimal_commas and WITH_POINT.fullmatch(cell):
        raise BadScene(f"{cell[:SHOWN]}: other cells have decimal commas: write all decimals alike")
    if WITH_COMMA.fullmatch(cell):
        if not decimal_commas:
            raise BadScene(
                f"{cell[:SHOWN]}: decimal commas are read where semicolons separate the cells: write a point"
            )
        return value_of(cell.replace(",", "."))
    return value_of(cell)
