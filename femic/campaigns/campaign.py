"""Campaigns: a scene and the keys that are swept over ranges and lists, from a TOML file.

    scene = "geometry1"                     # built-in name, or a file beside this one
    keep = ["errors"]

    [set]                                   # keys that all scenes of the campaign have
    engine = { tolerance = 0.02 }

    [sweep.flank]                           # an axis
    keys = ["lower.contour.flank_inclination_deg", "upper.contour.flank_inclination_deg"]
    from = 0
    to = 60
    count = 7

    [sweep.ratio]
    keys = { "upper.contour.radius" = 10 }  # value times 10
    values = [1.05, 1.2, 1.5]

Points are all combinations of values, or random ones, or the rows of a table. They have an order in which
early ones tell most: coarse over the ranges first.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice, pairwise, product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from pydantic import ValidationError

from femic.campaigns.campaign_file import (
    ABSURD,
    DIGITS,
    AxisTable,
    CampaignFile,
    Keep,
    is_absurd,
    is_number,
    text_of,
)
from femic.campaigns.points_table import points_in
from femic.scenes.errors import BadScene
from femic.scenes.keys import set_key
from femic.scenes.load import merged, read_scene, resolve_files, scene_from_table, scene_path
from femic.scenes.messages import message
from femic.scenes.names import name_of
from femic.scenes.scene import Scene
from femic.scenes.values import Value, value_of

Point = tuple[Value, ...]  # a value of each axis
SEPARATOR = re.compile(r",(?=\s*[^\s,=]+=)")  # of the axes in the name of a point; lists have commas, too
MOST_SCENES = 10_000_000
MOST_AXES = 32  # of a grid
MOST_TRIED = 1000  # scenes that are built before the run, a few ms each


@dataclass(frozen=True)
class Axis:
    """An axis of a campaign. `values` are those of a grid; () where points are random or of a table."""

    name: str
    label: str
    unit: str
    values: Point
    factors: Mapping[str, float | None]  # by key: what a value is multiplied by; None: it is taken as it is
    spacing: str = "linear"  # how distances between values are measured

    @property
    def heading(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def entries(self, value: Value) -> Iterator[tuple[str, Value]]:
        """Yield the keys of this axis, and what they have at a value."""
        for key, factor in self.factors.items():
            if factor is not None and not is_number(value):
                raise BadScene(f"sweep.{self.name}: {value!r}: is no number, and {key} has a factor")
            entry = value if factor is None else factor * float(value)  # type: ignore[arg-type]
            if is_absurd(entry):
                raise BadScene(f"sweep.{self.name}: {key} = {entry:g}: {ABSURD}")
            yield key, entry


@dataclass(frozen=True)
class Campaign:
    """A valid campaign."""

    name: str
    title: str
    text: str  # TOML
    keep: tuple[Keep, ...]
    table: Mapping[str, Any] = field(repr=False)  # of the scene, with what all scenes have
    axes: tuple[Axis, ...] = ()
    listed: tuple[Point, ...] = ()  # points that are not a grid
    is_random: bool = False  # whether these are random
    folder: Path = Path()  # where names of files that are swept begin

    @property
    def is_grid(self) -> bool:
        """Whether the points are all combinations of values."""
        return not self.listed

    @property
    def shape(self) -> tuple[int, ...]:
        """The numbers of values of the axes of a grid, else of points."""
        return tuple(len(axis.values) for axis in self.axes) if self.is_grid else (len(self.listed),)

    @property
    def size(self) -> int:
        """The number of points."""
        return prod(self.shape)

    @cached_property
    def order(self) -> Sequence[int]:
        """The numbers of the points (those of a grid in C order), coarse over the ranges first."""
        if not self.is_grid:
            return range(self.size)  # random ones come so; a table has the order of its author
        stages = [_stages(len(axis.values)) for axis in self.axes]
        latest = np.zeros(self.shape, dtype=int)
        for along, of_axis in enumerate(stages):
            others = [k for k in range(len(stages)) if k != along]
            latest = np.maximum(latest, np.expand_dims(of_axis, others))
        return [int(number) for number in np.argsort(latest, axis=None, kind="stable")]

    @property
    def required(self) -> Iterator[Point]:
        """Points whose scenes must be possible, `MOST_TRIED` at most: each value, and each row of a table.

        Values are those of an axis with the first ones of the others; of random points the ends.
        """
        if self.is_grid:
            points = _one_by_one(self.point(0), [_coarse_first(axis.values) for axis in self.axes])
        elif self.is_random:
            columns = zip(*self.listed, strict=True)
            points = _one_by_one(self.listed[0], [(min(column), max(column)) for column in columns])
        else:
            points = _telling(self.listed)
        return islice(points, MOST_TRIED)

    @property
    def combined(self) -> Iterator[Point]:
        """Points that tell of impossible combinations, `MOST_TRIED` at most: of ends, or random ones."""
        if self.is_grid:
            return islice(product(*(_ends(axis.values) for axis in self.axes)), MOST_TRIED)
        return islice(self.listed, MOST_TRIED if self.is_random else 0)

    def point(self, number: int) -> Point:
        """The values of the axes at a point."""
        if not self.is_grid:
            return self.listed[number]
        places = np.unravel_index(number, self.shape)
        return tuple(axis.values[place] for axis, place in zip(self.axes, places, strict=True))

    def named(self, point: Point) -> str:
        """The name of a point, such as flank=30,ratio=1.1."""
        return ",".join(f"{axis.name}={text_of(v)}" for axis, v in zip(self.axes, point, strict=True))

    def scene_table(self, point: Point) -> dict[str, Any]:
        """The table of the scene at a point; raises BadScene where a key does not exist."""
        table = deepcopy(dict(self.table))
        for axis, value in zip(self.axes, point, strict=True):
            for key, entry in axis.entries(value):
                set_key(table, key, deepcopy(entry), axis.name)
        resolve_files(table, self.folder)
        return table

    def scene(self, point: Point) -> Scene:
        """The scene at a point; raises BadScene."""
        return scene_from_table(self.scene_table(point), self.named(point))


def load_campaign(path: Path) -> Campaign:
    """The campaign of a TOML file; raises BadScene before any work.

    Its scenes at the first point, and at the ends of each axis, are built, to see whether keys and values
    fit.
    """
    if not path.is_file():
        raise BadScene(f"campaign {str(path)!r}: no such file; docs/campaigns.md has one to begin with")
    text, given = read_scene(path)
    parsed = _parsed(given, path)
    base = _beside(parsed.scene, path.parent)
    _, table = read_scene(base)
    changes = deepcopy(parsed.set)
    resolve_files(table, base.parent.absolute())
    resolve_files(changes, path.parent.absolute())
    campaign = Campaign(
        name_of(path),
        parsed.title or name_of(path),
        text,
        parsed.keep,
        merged(table, changes),
        _axes(parsed, path),
        tuple(_listed(parsed, path)),
        parsed.points == "random",
        path.parent.absolute(),
    )
    for point in _tried(campaign):
        try:
            campaign.scene(point)
        except BadScene as error:
            raise BadScene(f"{path}: at {campaign.named(point)}: {error}") from error
    return campaign


def points_named(campaign: Campaign, name: str) -> list[Point]:
    """The points that a name such as flank=30,ratio=1.1 stands for; raises BadScene.

    It is a single one, of the campaign or not, where all axes have a value; else all of the campaign's with
    these values.
    """
    parts = [part.strip().partition("=") for part in SEPARATOR.split(name)]
    given = {axis: value_of(value) for axis, _, value in parts}
    names = [axis.name for axis in campaign.axes]
    if not all(sign for _, sign, _ in parts) or not given.keys() <= {*names} or len(given) < len(parts):
        wanted = ",".join(f"{axis}=..." for axis in names)
        raise BadScene(f"{campaign.name}: point {name!r}: give {wanted}, or some of them")
    if len(given) == len(names):
        return [tuple(given[axis] for axis in names)]
    places = {names.index(axis): text_of(value) for axis, value in given.items()}
    points = [campaign.point(number) for number in range(campaign.size)]
    found = [point for point in points if all(text_of(point[k]) == value for k, value in places.items())]
    if not found:
        known = "; ".join(
            f"{names[k]}: {', '.join(dict.fromkeys(text_of(point[k]) for point in points))}" for k in places
        )
        raise BadScene(f"{campaign.name}: no points with {name}; there are {known}")
    return found


def _parsed(given: dict[str, Any], path: Path) -> CampaignFile:
    if isinstance(given.get("points"), str) and given["points"] not in ("all", "random"):
        given["points"] = path.parent / given["points"]
    try:
        return CampaignFile.model_validate(given)
    except ValidationError as error:
        lines = [message(detail) for detail in error.errors()]
        raise BadScene(f"{path}: {len(lines)} error(s)\n  " + "\n  ".join(lines)) from error


def _beside(scene: str, folder: Path) -> Path:
    """The path of a scene: a built-in one, or a file in a folder."""
    local = folder / scene
    return local if local.is_file() else scene_path(scene)


def _axes(parsed: CampaignFile, path: Path) -> tuple[Axis, ...]:
    """The axes; raises BadScene where a grid is too large."""
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


def _axis(name: str, table: AxisTable, *, is_grid: bool) -> Axis:
    factors = dict(table.keys) if isinstance(table.keys, dict) else dict.fromkeys(table.keys)
    values = _values(table) if is_grid else ()
    return Axis(name, table.label or name, table.unit, values, factors, table.spacing)


def _values(table: AxisTable) -> Point:
    """The values of an axis of a grid; raises BadScene where those of a range are the same."""
    if table.start is None or table.to is None or table.count is None:
        return table.values
    values = (table.start, *map(table.between, np.linspace(0, 1, table.count)[1:-1].tolist()), table.to)
    if not np.all(np.diff(values) > 0):
        raise BadScene(f"count = {table.count}: values are the same to {DIGITS} digits: give fewer")
    return values


def _listed(parsed: CampaignFile, path: Path) -> list[Point]:
    """The points of a campaign that is not a grid."""
    if parsed.points == "all":
        return []
    if parsed.points == "random":
        return _random(parsed)
    try:
        return points_in(Path(parsed.points), list(parsed.sweep))
    except BadScene as error:
        raise BadScene(f"{path}: points = {error}") from error


def _random(parsed: CampaignFile) -> list[Point]:
    """Points of a scrambled Sobol sequence: so the first ones cover the ranges, too."""
    sequence = scipy.stats.qmc.Sobol(len(parsed.sweep), rng=parsed.seed)
    shares = sequence.random_base2(int(np.ceil(np.log2(max(parsed.samples, 2)))))[: parsed.samples]
    columns = []
    for axis, share in zip(parsed.sweep.values(), shares.T, strict=True):
        columns.append([axis.between(float(value)) for value in share])
    return list(zip(*columns, strict=True))


def _tried(campaign: Campaign) -> Iterator[Point]:
    """Points whose scenes are tried before any work: the first one, then one axis at an end each."""
    if not campaign.is_grid:
        yield from islice(campaign.listed, 2)
        return
    first = campaign.point(0)
    yield first
    for k, axis in enumerate(campaign.axes):
        yield (*first[:k], axis.values[-1], *first[k + 1 :])


def _one_by_one(first: Point, values: Sequence[Sequence[Value]]) -> Iterator[Point]:
    """Yield a point with one of its values replaced by each one of an axis, those of all axes in turn."""
    for place in range(max(map(len, values))):
        for k, of_axis in enumerate(values):
            if place < len(of_axis):
                yield *first[:k], of_axis[place], *first[k + 1 :]


def _coarse_first(values: Point) -> Point:
    return tuple(values[k] for k in np.argsort(_stages(len(values)), kind="stable"))


def _ends(values: Point) -> Point:
    return values if len(values) < 2 else (values[0], values[-1])


def _telling(points: Sequence[Point]) -> Iterator[Point]:
    """Yield the first point, those with extreme values and with each text, then others evenly."""
    yield points[0]
    for column in zip(*points, strict=True):
        numbers = [k for k, value in enumerate(column) if is_number(value)]
        if numbers:
            yield points[min(numbers, key=column.__getitem__)]
            yield points[max(numbers, key=column.__getitem__)]
        texts = {str(value): k for k, value in enumerate(column) if not is_number(value)}
        yield from (points[k] for k in texts.values())
    yield from points[:: -(-len(points) // MOST_TRIED)]


def _stages(count: int) -> np.ndarray[Any, np.dtype[np.int_]]:
    """When each of some values is taken: 0 the ends and the middle, then always the middles between."""
    stage = np.full(count, -1)
    taken, latest = sorted({0, (count - 1) // 2, count - 1}), 0
    stage[taken] = 0
    while np.any(stage < 0):
        latest += 1
        middles = {(a + b) // 2 for a, b in pairwise(taken)} - set(taken)
        stage[list(middles)] = latest
        taken = sorted({*taken, *middles})
    return stage
