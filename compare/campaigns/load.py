"""Campaigns from TOML files, and from tables of points that these name.

    scene = "geometry1"                     # built-in name, or a file beside this one
    keep = ["errors"]

    [set]                                   # keys that all scenes of the campaign share
    engine = { tolerance = 0.02 }

    [sweep.flank]                           # an axis
    keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
    from = 0
    to = 60
    count = 7

    [sweep.ratio]
    keys = { "upper.contour.radius" = 10 }  # value times 10
    values = [1.05, 1.2, 1.5]

Tables of points are CSV: a header line with the names of the axes, and a row of values for each point. Cells
are separated by commas, semicolons or tabs; the text is UTF-8 or UTF-16. Decimal commas are read where
semicolons separate the cells. Ambiguous cells are refused with their line.
"""

import csv
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from copy import deepcopy
from io import StringIO
from math import prod
from pathlib import Path

import numpy as np
import scipy
from pydantic import ValidationError

from compare.campaigns.campaign import Campaign, Point, SweptAxis
from compare.campaigns.keys import DIGITS, CampaignFile
from femic.scenes.errors import BadScene, bad_scene
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute
from femic.scenes.load import merged, message, name_of, read_scene, read_toml, scene_path
from femic.scenes.values import SHOWN, Value, value_of

# --- campaigns ------------------------------------------------------------------------------------------


MOST_SCENES = 10_000_000
MOST_AXES = 32  # of a grid


def load_campaign(path: Path) -> Campaign:
    """Load the campaign of a TOML file; raise BadScene where it is none.

    Its scenes are not built: `compare.campaigns.plan.require_computable` tries some.
    """
    if not path.is_file():
        raise BadScene(
            f"campaign {str(path)!r}: no such file; docs/how-to/campaigns.md has one to begin with"
        )
    text, given = read_toml(path)
    if isinstance(given.get("points"), str) and given["points"] not in ("all", "random"):
        given["points"] = path.parent / given["points"]
    try:
        parsed = CampaignFile.model_validate(given)
    except ValidationError as error:
        raise bad_scene(path, map(message, error.errors())) from error
    local = path.parent / parsed.scene
    _, table = read_scene(local if local.is_file() else scene_path(parsed.scene))
    changes = deepcopy(parsed.set)
    make_files_absolute(changes, SceneFile, path.parent)
    return Campaign(
        name_of(path),
        parsed.title or name_of(path),
        text,
        parsed.keep,
        merged(table, changes),
        _axes(parsed, path),
        tuple(_list_points(parsed, path)),
        parsed.points == "random",
        path.parent.absolute(),
    )


def _axes(parsed: CampaignFile, path: Path) -> tuple[SweptAxis, ...]:
    """Return the axes; raise BadScene where a grid is too large, or a range gives one value twice."""
    is_grid, axes = parsed.points == "all", []
    for name, table in parsed.sweep.items():
        factors = dict(table.keys) if isinstance(table.keys, dict) else dict.fromkeys(table.keys)
        values = table.values if is_grid else ()
        if is_grid and table.start is not None and table.to is not None and table.count is not None:
            between = map(table.between, np.linspace(0, 1, table.count)[1:-1].tolist())
            values = (table.start, *between, table.to)
        if len(values) > 1 and table.count and not np.all(np.diff(values) > 0):
            raise BadScene(
                f"{path}: sweep.{name}: count = {table.count}: values are the same to {DIGITS} digits: give "
                "fewer"
            )
        axes.append(SweptAxis(name, table.label or name, table.unit, values, factors, table.spacing))
    scenes = prod(len(axis.values) for axis in axes)
    if is_grid and (scenes > MOST_SCENES or len(axes) > MOST_AXES):
        raise BadScene(
            f"{path}: sweep: {scenes:.3g} scenes over {len(axes)} axes; at most {MOST_SCENES:.0e} over "
            f"{MOST_AXES}: give fewer values, or points = 'random'"
        )
    return tuple(axes)


def _list_points(parsed: CampaignFile, path: Path) -> list[Point]:
    """Return the points of a campaign that is not a grid.

    Random ones are of a scrambled Sobol sequence, whose first points cover the ranges, too.
    """
    if parsed.points == "all":
        return []
    if parsed.points == "random":
        sequence = scipy.stats.qmc.Sobol(len(parsed.sweep), rng=parsed.seed)
        shares = sequence.random_base2(int(np.ceil(np.log2(max(parsed.samples, 2)))))[: parsed.samples]
        axes = parsed.sweep.values()
        return [
            tuple(axis.between(share) for axis, share in zip(axes, row, strict=True))
            for row in shares.tolist()
        ]
    try:
        return read_points(Path(parsed.points), list(parsed.sweep))
    except BadScene as error:
        raise BadScene(f"{path}: points = {error}") from error


# --- tables of points -----------------------------------------------------------------------------------


SEPARATORS = ",;\t"
WITH_COMMA = re.compile(r"[+-]?([0-9]+,[0-9]*|,[0-9]+)([eE][+-]?[0-9]+)?")
WITH_POINT = re.compile(r"[+-]?([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
Row = tuple[int, list[str]]  # the line where it ends, and its cells


def read_points(path: Path, axes: Sequence[str]) -> list[tuple[Value, ...]]:
    """Return the values of the axes by row; raise BadScene with line and reason for unclear tables."""
    text = _read_text(path)
    separator = _find_separator(path, text, axes)
    (header_line, header), *rows = _rows(path, text, separator)
    if twice := [name for name, count in Counter(header).items() if name and count > 1]:
        raise BadScene(f"{path}, line {header_line}: column {', '.join(twice)} is there twice: remove one")
    if not rows:
        raise BadScene(f"{path}: no rows below the header: add one for each point")
    for line, cells in rows:
        if len(cells) != len(header):
            raise BadScene(
                f"{path}, line {line}: cells: {len(cells)}, columns: {len(header)}: fill every cell, write "
                "decimals with a point, and text with separators in double quotes"
            )
        if empty := [name for name, cell in zip(header, cells, strict=True) if name in axes and not cell]:
            raise BadScene(f"{path}, line {line}: {', '.join(empty)}: no value: add it")
    places = [header.index(name) for name in axes]
    commas = separator == ";" and any(WITH_COMMA.fullmatch(cells[k]) for _, cells in rows for k in places)
    points = []
    for line, cells in rows:
        try:
            points.append(tuple(_value(cells[k], decimal_commas=commas) for k in places))
        except BadScene as error:
            raise BadScene(f"{path}, line {line}: {error}") from error
    return points


def _read_text(path: Path) -> str:
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


def _find_separator(path: Path, text: str, axes: Sequence[str]) -> str:
    """Return the separator with which the first line has the names of the axes; raise BadScene."""
    headers: list[list[str]] = []
    for separator in SEPARATORS:
        with suppress(BadScene):  # quotes may be in order with another separator
            headers.append(next(_rows(path, text, separator), (1, []))[1])
            if {*axes} <= {*headers[-1]}:
                return separator
    columns = max(headers, key=len, default=[])
    missing = ", ".join(name for name in axes if name not in columns)
    raise BadScene(
        f"{path}, line 1: no column {missing}; columns are {', '.join(columns)[:80] or 'none'}: separate "
        "them by commas, semicolons or tabs"
    )


def _rows(path: Path, text: str, separator: str) -> Iterator[Row]:
    """Yield the rows of a table without the empty ones, the header first; raise BadScene."""
    reader = csv.reader(StringIO(text, newline=""), delimiter=separator, skipinitialspace=True, strict=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield reader.line_num, [cell.strip() for cell in cells]
    except csv.Error as error:
        reason = str(error).replace(
            "field larger than field limit", "a cell has more characters than allowed"
        )
        raise BadScene(f"{path}, line {reader.line_num}: not CSV: {reason}") from error


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
