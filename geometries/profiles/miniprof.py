"""Files of MiniProf, `.ban` (rails) and `.whl` (wheels), in mm.

New style: lines `key=value` up to the first blank line, then the columns that `ColumnDef` names. Old
style: a first line with MINIWHEELPROF or MINIPROF and lines of free text, then two or three columns.
Where the blank line is missing, the header ends at the first line of numbers alone.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from geometries.profiles.profile import Content, kind_by_name, only_numbers, parse_rows, point, row
from geometries.profiles.text import Source, is_number, number, shortened, split_columns, uncommented

COMMENTS = '!"#%'
COLUMNS = frozenset("XYACNK")
USED = ("columndef", "xoffset", "yoffset", "xypoints")  # keys
OLD_STYLE = re.compile(r"#?\s*MINI(WHEEL|RAIL)?PROF\b", re.IGNORECASE)
KEY = re.compile(r"[A-Za-z]\w*\s*=", re.ASCII)
LEAST_POINTS = 4  # of a profile: as many lines of numbers, one behind the other, are no header


@dataclass(frozen=True)
class Header:
    """Keys of the header, the number of its lines, whether the file is of the old style.

    `numbers` are its lines that consist of numbers.
    """

    keys: Mapping[str, tuple[int, str]]  # line and text of the value, by key in lower case
    n_lines: int
    old: bool
    numbers: list[int]

    def value(self, key: str) -> tuple[int, str]:
        """Line and text of the value of a key, "" where it is missing or empty."""
        line, text = self.keys.get(key.lower(), (0, ""))
        return line, uncommented(text, COMMENTS)


def is_miniprof(source: Source) -> bool:
    """Whether the file is one of MiniProf: by its ending or its first line, whatever the ending."""
    first = next(text.strip() for text in source.lines if text.strip())
    return source.path.suffix.lower() in (".ban", ".whl") or bool(OLD_STYLE.match(first) or KEY.match(first))


def read_miniprof(source: Source) -> Content:
    """Points of a file of MiniProf with its offsets added; the axes are not stated."""
    header = _read_header(source)
    columns, notes = _find_columns(source, header)
    points, lines, remarks = [], [], []
    for line, text in _rows(source, header.n_lines):
        fields = split_columns(source, line, text)
        if len(fields) > len(columns) and not is_number(fields[len(columns)]):
            fields = fields[: len(columns)]
            remarks.append(line)
        fields = row(source, line, " ".join(fields), range(len(columns), len(columns) + 1))
        points.append(point(source, line, fields[columns.index("X")], fields[columns.index("Y")]))
        lines.append(line)
    rows = parse_rows(source, points, lines)
    if header.numbers:
        where = ", ".join(map(str, header.numbers))
        notes.append(f"Numbers in the header were not read as points (lines {where}).")
    if remarks:
        notes.append(f"Text behind the columns was not read (the first in line {remarks[0]}).")
    line, announced = header.value("XYPoints")
    if announced:
        expected = number(source, line, announced, "XYPoints")
        behind = (text.strip() for text in source.lines[header.n_lines :])
        comments = (text[1:] for text in behind if text and text[0] in COMMENTS)
        hidden = sum(only_numbers(uncommented(text, COMMENTS)) for text in comments)  # rows in comments
        if rows.count + hidden < expected:
            raise source.wrong(
                len(source.lines),
                f"{rows.count} rows, but XYPoints = {announced} in line {line}: cut off? If not, correct "
                "XYPoints",
            )
        if rows.count != expected:
            notes.append(f"The header announces {announced} points, the file has {rows.count}.")
    offsets = [(key, *header.value(key)) for key in ("xoffset", "yoffset")]
    shift = [number(source, line, text, key) if text else 0.0 for key, line, text in offsets]
    if any(shift):
        notes.append(f"Offsets of the header were added: {shift[0]:g} to y, {shift[1]:g} to z.")
    moved = rows.moved(rows.points + np.array(shift)[:, None])
    return Content(moved, kind_by_name(source), 1.0, notes=tuple(notes))


def _read_header(source: Source) -> Header:
    """Header of a file. Raises WrongInput where there is none, and for keys given twice with two values."""
    old = bool(OLD_STYLE.match(source.lines[0].strip()))
    n_lines, numbers = _header_end(source)
    keys: dict[str, tuple[int, str]] = {}
    for line, text in enumerate(source.lines[:n_lines], 1):
        if not text.strip() or text.lstrip()[0] in COMMENTS or line in numbers:
            continue
        if "=" in text:
            key, _, value = (part.strip() for part in text.partition("="))
            earlier, first = keys.get(key.lower(), (line, ""))
            if first and value and value != first and key.lower() in USED:
                raise source.wrong(
                    line, f"{key}: also given in line {earlier}, with another value; delete one"
                )
            keys[key.lower()] = (line, value or first)
        elif not old and not is_number(text.strip()):
            raise source.wrong(line, f"{shortened(text)}: a line KEY=VALUE is expected in the header")
    if n_lines == len(source.lines):
        raise source.wrong(
            n_lines,
            "the file ends within its header, without points; is it cut off, or one of settings? Export the "
            "measured profile as .ban (rail) or .whl (wheel)",
        )
    if not old and not keys:
        raise source.wrong(
            n_lines + 1,
            "a header of MiniProf is expected (KEY=VALUE, or MINIPROF in line 1); "
            "name a file of two columns .txt",
        )
    return Header(keys, n_lines, old, numbers)


def _header_end(source: Source) -> tuple[int, list[int]]:
    """Number of the header's lines, and those of its lines that consist of numbers.

    The header ends at the first blank line. Where a run of numbers as long as a profile begins before it,
    the blank line is missing: points begin there. Fewer numbers belong to the header.
    """
    numbers: list[int] = []
    run: list[int] = []
    for line, text in enumerate(source.lines, 1):
        if not text.strip():
            if len(run) < LEAST_POINTS:
                if any(only_numbers(behind) for behind in source.lines[line:]):
                    return line, numbers + run
                continue
            if any(only_numbers(behind) for behind in source.lines[line:]):
                raise source.wrong(
                    run[0],
                    f"numbers before the first blank line, {line}, and behind it: delete the blank line, or "
                    "make these numbers a comment if they belong to the header",
                )
            return run[0] - 1, numbers
        if only_numbers(text):
            run.append(line)
        elif text.lstrip()[0] not in COMMENTS and len(run) < LEAST_POINTS:
            numbers, run = numbers + run, []
    return run[0] - 1 if run else len(source.lines), numbers


def _find_columns(source: Source, header: Header) -> tuple[list[str], list[str]]:
    """Names of the columns, and a note where the header does not give them."""
    line, value = header.keys.get("columndef", (0, ""))
    if value:
        names = re.split(r"[\s,;]+", value.upper().strip())
        if not set(names) <= COLUMNS or len(set(names)) < len(names) or not {"X", "Y"} <= set(names):
            raise source.wrong(
                line,
                f"ColumnDef = {shortened(value)}: must name X and Y, and any of A, C, N, K, each once",
            )
        return names, []
    note = [] if header.old else ["The header has no ColumnDef: the first columns were taken as X, Y."]
    for line, text in _rows(source, header.n_lines):
        count = len(split_columns(source, line, text))
        if not 2 <= count <= (3 if header.old else 5):
            raise source.wrong(line, f"{shortened(text)}: {count} columns; 2 or 3 expected")
        return ["X", "Y", *"ACK"[: count - 2]], note
    return ["X", "Y"], note


def _rows(source: Source, n_header: int) -> Iterator[tuple[int, str]]:
    """Numbers and texts of the lines behind the header, without comments."""
    for line, text in enumerate(source.lines[n_header:], n_header + 1):
        if content := uncommented(text, COMMENTS):
            yield line, content
