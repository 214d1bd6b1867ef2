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
from dataclasses import dataclass
from io import StringIO
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from pydantic import ValidationError

from compare.campaigns.campaign import Campaign, Point, SweptAxis
from compare.campaigns.keys import DIGITS, AxisTable, CampaignFile
from femic.scenes.errors import BadScene, bad_scene
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute
from femic.scenes.load import merged, message, name_of, read_scene, read_toml, scene_path
from femic.scenes.values import SHOWN, Value, value_of

# --- campaigns ------------------------------------------------------------------------------------------


MOST_SCENES = 10_000_000
MOST_AXES = 32  # of a grid


def load_campaign(path: Path) -> Campaign:
    """Load the campaign of a TOML file; raise BadScene before any work.

    Scenes at the first point and at the ends of each axis are built, to see whether keys and values fit.
    """
    if not path.is_file():
        raise BadScene(
            f"campaign {str(path)!r}: no such file; docs/how-to/campaigns.md has one to begin with"
        )
    text, given = read_toml(path)
    parsed = _parse(given, path)
    local = path.parent / parsed.scene
    base = local if local.is_file() else scene_path(parsed.scene)
    _, table = read_scene(base)
    changes = deepcopy(parsed.set)
    make_files_absolute(changes, SceneFile, path.parent)
    campaign = Campaign(
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
    for point in _first_points(campaign):
        try:
            campaign.scene(point)
        except BadScene as error:
            if all(any(map(campaign.is_possible, points)) for points in campaign.others(point)):
                continue  # this combination will be recorded as a failure
            raise BadScene(f"{path}: at {campaign.point_name(point)}: {error}") from error
    return campaign


def _parse(given: dict[str, Any], path: Path) -> CampaignFile:
    if isinstance(given.get("points"), str) and given["points"] not in ("all", "random"):
        given["points"] = path.parent / given["points"]
    try:
        return CampaignFile.model_validate(given)
    except ValidationError as error:
        raise bad_scene(path, map(message, error.errors())) from error


def _axes(parsed: CampaignFile, path: Path) -> tuple[SweptAxis, ...]:
    """Return the axes; raise BadScene where a grid is too large."""
    is_grid, axes = parsed.points == "all", []
    for name, table in parsed.sweep.items():
        try:
            axes.append(_axis(name, table, is_grid=is_grid))
        except BadScene as error:
            raise BadScene(f"{path}: sweep.{name}: {error}") from error
    scenes = prod(len(axis.values) for axis in axes)
    if is_grid and (scenes > MOST_SCENES or len(axes) > MOST_AXES):
        raise BadScene(
            f"{path}: sweep: {scenes:.3g} scenes over {len(axes)} axes; at most {MOST_SCENES:.0e} over "
            f"{MOST_AXES}: give fewer values, or points = 'random'"
        )
    return tuple(axes)


def _axis(name: str, table: AxisTable, *, is_grid: bool) -> SweptAxis:
    factors = dict(table.keys) if isinstance(table.keys, dict) else dict.fromkeys(table.keys)
    values = _values(table) if is_grid else ()
    return SweptAxis(name, table.label or name, table.unit, values, factors, table.spacing)


def _values(table: AxisTable) -> Point:
    """Return the values of an axis of a grid; raise BadScene where a range gives one value twice."""
    if table.start is None or table.to is None or table.count is None:
        return table.values
    values = (table.start, *map(table.between, np.linspace(0, 1, table.count)[1:-1].tolist()), table.to)
    if not np.all(np.diff(values) > 0):
        raise BadScene(f"count = {table.count}: values are the same to {DIGITS} digits: give fewer")
    return values


def _list_points(parsed: CampaignFile, path: Path) -> list[Point]:
    """Return the points of a campaign that is not a grid."""
    if parsed.points == "all":
        return []
    if parsed.points == "random":
        return _random(parsed)
    try:
        return points_in(Path(parsed.points), list(parsed.sweep))
    except BadScene as error:
        raise BadScene(f"{path}: points = {error}") from error


def _random(parsed: CampaignFile) -> list[Point]:
    """Return points of a scrambled Sobol sequence, whose first points cover the ranges, too."""
    sequence = scipy.stats.qmc.Sobol(len(parsed.sweep), rng=parsed.seed)
    shares = sequence.random_base2(int(np.ceil(np.log2(max(parsed.samples, 2)))))[: parsed.samples]
    columns = []
    for axis, share in zip(parsed.sweep.values(), shares.T, strict=True):
        columns.append([axis.between(float(value)) for value in share])
    return list(zip(*columns, strict=True))


def _first_points(campaign: Campaign) -> Iterator[Point]:
    """Yield points whose scenes are built when a file is loaded: the first one, then one axis at its end."""
    if not campaign.is_grid:
        yield from islice(campaign.listed, 2)
        return
    first = campaign.point(0)
    yield first
    for k, axis in enumerate(campaign.axes):
        yield (*first[:k], axis.values[-1], *first[k + 1 :])


# --- tables of points -----------------------------------------------------------------------------------


SEPARATORS = ",;\t"
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
