"""Files of MiniProf, `.ban` (rails) and `.whl` (wheels), in mm.

New style: lines `key=value` up to the first blank line, then the columns that `ColumnDef` names. Old
style: a first line with MINIWHEELPROF or MINIPROF and lines of free text, then two or three columns.
Where the blank line is missing, the header ends at the first line of numbers alone.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from geometries.profiles.profile import Content, Written, kind_by_name, only_numbers, parse_rows, point, row
from geometries.profiles.text import Source, is_number, number, shortened, split_columns, uncommented

COMMENTS = '!"#%'
COLUMNS = frozenset("XYACNK")
OLD_STYLE = re.compile(r"#?\s*MINI(WHEEL|RAIL)?PROF\b", re.IGNORECASE)
KEY = re.compile(r"[A-Za-z]\w*\s*=", re.ASCII)
LEAST_POINTS = 4  # of a profile: as many lines of numbers, one behind the other, are no header

Keys = Mapping[str, tuple[int, str]]  # line and text of the value, by key in lower case


@dataclass(frozen=True)
class Header:
    """Keys of the header, the number of its lines, whether the file is of the old style.

    `numbers` are its lines that consist of numbers.
    """

    keys: Keys
    n_lines: int
    old: bool
    numbers: list[int]


def is_miniprof(source: Source) -> bool:
    """Whether the file is one of MiniProf: by its ending or its first line, whatever the ending."""
    first = next(text.strip() for text in source.lines if text.strip())
    return source.path.suffix.lower() in (".ban", ".whl") or bool(OLD_STYLE.match(first) or KEY.match(first))


def read_miniprof(source: Source) -> Content:
    """Points of a file of MiniProf with its offsets added; the axes are not stated."""
    header = _read_header(source)
    columns, notes = _columns(source, header)
    points, lines, remarks = [], [], []
    for line, text in _rows(source, header):
        values, remark = _read_row(source, line, text, columns)
        points.append(values)
        lines.append(line)
        remarks += [line] if remark else []
    rows = parse_rows(source, points, lines)
    if header.numbers:
        where = ", ".join(map(str, header.numbers))
        notes.append(f"Numbers in the header were not read as points (lines {where}).")
    if remarks:
        notes.append(f"Text behind the columns was not read (the first in line {remarks[0]}).")
    notes += _compare_count(source, header, rows.count)
    shift = [_offset(source, header.keys, key) for key in ("xoffset", "yoffset")]
    if any(shift):
        notes.append(f"Offsets of the header were added: {shift[0]:g} to y, {shift[1]:g} to z.")
    return Content(
        rows.moved(rows.points + np.array(shift)[:, None]), kind_by_name(source), 1.0, notes=tuple(notes)
    )


def _read_header(source: Source) -> Header:
    """Header of a file. Raises WrongInput where there is none, and for keys given twice with two values."""
    old = bool(OLD_STYLE.match(source.lines[0].strip()))
    n_lines, numbers = _header_end(source)
    keys: dict[str, tuple[int, str]] = {}
    for line, text in enumerate(source.lines[:n_lines], 1):
        if not text.strip() or text.lstrip()[0] in COMMENTS or line in numbers:
            continue
        if "=" in text:
            _add_key(source, keys, line, text)
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
            _check_blank_line(source, run[0], line)
            return run[0] - 1, numbers
        if only_numbers(text):
            run.append(line)
        elif text.lstrip()[0] not in COMMENTS and len(run) < LEAST_POINTS:
            numbers, run = numbers + run, []
    return run[0] - 1 if run else len(source.lines), numbers


def _check_blank_line(source: Source, line: int, blank: int) -> None:
    """Raise WrongInput where points begin before the first blank line and numbers stand behind it."""
    if any(only_numbers(text) for text in source.lines[blank:]):
        raise source.wrong(
            line,
            f"numbers before the first blank line, {blank}, and behind it: delete the blank line, or make "
            "these numbers a comment if they belong to the header",
        )


def _add_key(source: Source, keys: dict[str, tuple[int, str]], line: int, text: str) -> None:
    """Add a key; a second value is an error where the first was not empty."""
    key, _, value = (part.strip() for part in text.partition("="))
    earlier, first = keys.get(key.lower(), (line, ""))
    if first and value and value != first and key.lower() in ("columndef", "xoffset", "yoffset", "xypoints"):
        raise source.wrong(line, f"{key}: also given in line {earlier}, with another value; delete one")
    keys[key.lower()] = (line, value or first)


def _columns(source: Source, header: Header) -> tuple[list[str], list[str]]:
    """Names of the columns, and a note where the header does not give them."""
    if "columndef" not in header.keys or not header.keys["columndef"][1]:
        count = _first_count(source, header)
        note = [] if header.old else ["The header has no ColumnDef: the first columns were taken as X, Y."]
        return ["X", "Y", *"ACK"[: count - 2]], note
    line, value = header.keys["columndef"]
    names = re.split(r"[\s,;]+", value.upper().strip())
    if not set(names) <= COLUMNS or len(set(names)) < len(names) or not {"X", "Y"} <= set(names):
        raise source.wrong(
            line,
            f"ColumnDef = {shortened(value)}: must name X and Y, and any of A, C, N, K, each once",
        )
    return names, []


def _first_count(source: Source, header: Header) -> int:
    """Number of columns of the first row, 2 or 3 (in the old style) or up to 5."""
    for line, text in _rows(source, header):
        count = len(split_columns(source, line, text))
        if not 2 <= count <= (3 if header.old else 5):
            raise source.wrong(line, f"{shortened(text)}: {count} columns; 2 or 3 expected")
        return count
    return 2


def _rows(source: Source, header: Header) -> Iterable[tuple[int, str]]:
    """Numbers and texts of the lines behind the header, without comments."""
    for line, text in enumerate(source.lines[header.n_lines :], header.n_lines + 1):
        if content := uncommented(text, COMMENTS):
            yield line, content


def _read_row(source: Source, line: int, text: str, columns: list[str]) -> tuple[Written, bool]:
    """X and Y of a row, and whether text follows its columns."""
    fields = split_columns(source, line, text)
    behind = fields[len(columns) :]
    if behind and not is_number(behind[0]):
        fields = fields[: len(columns)]
    fields = row(source, line, " ".join(fields), range(len(columns), len(columns) + 1))
    y, z = (fields[columns.index(name)] for name in "XY")
    return point(source, line, y, z), len(behind) > 0


def _offset(source: Source, keys: Keys, key: str) -> float:
    """Value of an offset [mm], 0 where it is missing or empty."""
    line, value = keys.get(key, (0, ""))
    value = uncommented(value, COMMENTS)
    return number(source, line, value, key) if value else 0.0


def _compare_count(source: Source, header: Header, count: int) -> list[str]:
    """A note where there are more rows than XYPoints; WrongInput for fewer, rows in comments counted."""
    line, value = header.keys.get("xypoints", (0, ""))
    value = uncommented(value, COMMENTS)
    if not value:
        return []
    expected = number(source, line, value, "XYPoints")
    hidden = sum(_is_hidden(text) for text in source.lines[header.n_lines :])
    if count + hidden < expected:
        raise source.wrong(
            len(source.lines),
            f"{count} rows, but XYPoints = {value} in line {line}: cut off? If not, correct XYPoints",
        )
    return [f"The header announces {value} points, the file has {count}."] if count != expected else []


def _is_hidden(text: str) -> bool:
    """Whether a line is a row that was made a comment."""
    text = text.strip()
    return text[:1] in COMMENTS and text != "" and only_numbers(uncommented(text[1:], COMMENTS))
