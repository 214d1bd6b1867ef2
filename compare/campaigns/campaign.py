"""A campaign: a scene, the axes along which its keys vary, and the points at which scenes are computed.

Points are all combinations of the axes' values (a grid), or random ones, or the rows of a table. Their order
covers the ranges coarsely first. The scenes of some points are checked before a run.
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

from compare.campaigns.keys import OUT_OF_RANGE, is_number, is_out_of_range, text_of
from femic.scenes.errors import BadScene
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute, set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from femic.scenes.values import Value, value_of
from geometries.arrays import Indices

Point = tuple[Value, ...]  # one value of each axis


# --- the campaign ---------------------------------------------------------------------------------------


SEPARATOR = re.compile(r",(?=\s*[^\s,=]+=)")  # between axes in the name of a point; lists have commas, too
MOST_CHECKED = 1000  # scenes that are built before the run, a few ms each
MOST_OTHERS = 16  # combinations that are tried with a value before it is refused


@dataclass(frozen=True)
class SweptAxis:
    """An axis of a campaign, with the `values` of a grid; () where points are random or from a table."""

    name: str
    label: str
    unit: str
    values: Point
    factors: Mapping[str, float | None]  # by key: the factor of a value; None: the value itself
    spacing: str = "linear"  # how distances between values are measured

    def entries(self, value: Value) -> Iterator[tuple[str, Value]]:
        """Yield the keys of this axis with their entries at a value; raise BadScene."""
        for key, factor in self.factors.items():
            if factor is not None and not is_number(value):
                raise BadScene(f"sweep.{self.name}: {value!r}: is not a number, and {key} has a factor")
            entry = value if factor is None else factor * float(value)  # type: ignore[arg-type]
            if is_out_of_range(entry):
                raise BadScene(f"sweep.{self.name}: {key} = {entry:g}: {OUT_OF_RANGE}")
            yield key, entry


@dataclass(frozen=True)
class Campaign:
    """A valid campaign."""

    name: str
    title: str
    text: str  # TOML
    keep: tuple[str, ...]
    table: Mapping[str, Any] = field(repr=False)  # the scene, with the keys that all scenes share
    axes: tuple[SweptAxis, ...] = ()
    listed: tuple[Point, ...] = ()  # points that are not a grid
    is_random: bool = False  # whether `listed` is random
    folder: Path = Path()  # to which paths in swept values are relative

    @property
    def is_grid(self) -> bool:
        """Whether the points are all combinations of values."""
        return not self.listed

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values of the axes of a grid, else the number of points."""
        return tuple(len(axis.values) for axis in self.axes) if self.is_grid else (len(self.listed),)

    @property
    def size(self) -> int:
        """The number of points."""
        return prod(self.shape)

    @cached_property
    def order(self) -> Sequence[int]:
        """The numbers of the points (of a grid: in C order), coarse over the ranges first."""
        return grid_order(self.shape) if self.is_grid else range(self.size)

    @property
    def checked_points(self) -> Iterator[Point]:
        """Up to `MOST_CHECKED` points: each value, and each row of a table.

        Each value of an axis comes with the first values of the others; random points give the ends. It must
        be possible with them, or with one of `others`.
        """
        if self.is_grid:
            points = one_at_a_time(self.point(0), [coarse_first(axis.values) for axis in self.axes])
        elif self.is_random:
            points = one_at_a_time(self.listed[0], [*self._ends])
        else:
            points = informative(self.listed, MOST_CHECKED)
        return islice(points, MOST_CHECKED)

    @property
    def checked_combinations(self) -> Iterator[Point]:
        """Up to `MOST_CHECKED` points that show impossible combinations: of ends, or random ones."""
        if self.is_grid:
            return islice(product(*self._ends), MOST_CHECKED)
        return islice(self.listed, MOST_CHECKED if self.is_random else 0)

    def others(self, point: Point) -> Iterator[Iterator[Point]]:
        """Yield points with the same value and other ends, for each value of a checked point that differs.

        It differs from the first point; of that, each value counts. Rows of a table have no such points.
        """
        first = self.point(0)
        own = [k for k, value in enumerate(point) if value != first[k]] or range(len(point))
        ends = [*self._ends] if self.is_grid or self.is_random else []
        for k in own:
            with_value = product(*ends[:k], (point[k],), *ends[k + 1 :]) if ends else ()
            yield islice(with_value, MOST_OTHERS)

    @property
    def _ends(self) -> Iterator[Point]:
        """The first and the last value of each axis; of random ones the least and the largest."""
        of_listed = (sorted(column) for column in zip(*self.listed, strict=True))
        columns = (axis.values for axis in self.axes) if self.is_grid else of_listed
        return (tuple(column[:: len(column) - 1 or 1]) for column in columns)

    def is_possible(self, point: Point) -> bool:
        """Whether there is a scene at a point."""
        try:
            self.scene(point)
        except BadScene:
            return False
        return True

    def point(self, number: int) -> Point:
        """Return the values of the axes at a point."""
        if not self.is_grid:
            return self.listed[number]
        places = np.unravel_index(number, self.shape)
        return tuple(axis.values[place] for axis, place in zip(self.axes, places, strict=True))

    def point_name(self, point: Point) -> str:
        """Return the name of a point, such as flank=30,ratio=1.1."""
        return ",".join(f"{axis.name}={text_of(v)}" for axis, v in zip(self.axes, point, strict=True))

    def scene_table(self, point: Point) -> dict[str, Any]:
        """Return the table of the scene at a point; raise BadScene where a key does not exist."""
        table = deepcopy(dict(self.table))
        for axis, value in zip(self.axes, point, strict=True):
            for key, entry in axis.entries(value):
                set_key(table, key, deepcopy(entry), axis.name)
        make_files_absolute(table, SceneFile, self.folder)
        return table

    def scene(self, point: Point) -> Scene:
        """Return the scene at a point; raise BadScene."""
        return scene_from_table(self.scene_table(point), self.point_name(point))


def find_points(campaign: Campaign, name: str) -> list[Point]:
    """Return the points with a name such as flank=30,ratio=1.1; raise BadScene.

    A name with all axes stands for one point, of the campaign or not; one with some of them for all points
    of the campaign with these values.
    """
    parts = [part.strip().partition("=") for part in SEPARATOR.split(name)]
    given = {axis: value_of(value) for axis, _, value in parts}
    names = [axis.name for axis in campaign.axes]
    if not all(sign for _, sign, _ in parts) or not given.keys() <= {*names} or len(given) < len(parts):
        usage = ",".join(f"{axis}=..." for axis in names)
        raise BadScene(f"{campaign.name}: point {name!r}: give {usage}, or some of them")
    if len(given) == len(names):
        return [tuple(given[axis] for axis in names)]
    places = {names.index(axis): text_of(value) for axis, value in given.items()}
    points = [campaign.point(number) for number in range(campaign.size)]
    matching = [point for point in points if all(text_of(point[k]) == value for k, value in places.items())]
    if not matching:
        known = "; ".join(
            f"{names[k]}: {', '.join(dict.fromkeys(text_of(point[k]) for point in points))}" for k in places
        )
        raise BadScene(f"{campaign.name}: no points with {name}; there are {known}")
    return matching


# --- the order of points --------------------------------------------------------------------------------


def stages(count: int) -> Indices:
    """Return the stage of each of `count` values: 0 for the ends and the middle, then by bisection."""
    stage = np.full(count, -1)
    done, latest = sorted({0, (count - 1) // 2, count - 1}), 0
    stage[done] = 0
    while np.any(stage < 0):
        latest += 1
        middles = {(a + b) // 2 for a, b in pairwise(done)} - set(done)
        stage[list(middles)] = latest
        done = sorted({*done, *middles})
    return stage


def coarse_first(values: Point) -> Point:
    """Return values of an axis by stage."""
    return tuple(values[k] for k in np.argsort(stages(len(values)), kind="stable"))


def grid_order(shape: Sequence[int]) -> list[int]:
    """Return the numbers (C order) of the points of a grid, coarse over all ranges first."""
    latest = np.zeros(tuple(shape), dtype=int)
    for along, stage in enumerate(map(stages, shape)):
        latest = np.maximum(latest, np.expand_dims(stage, [k for k in range(len(shape)) if k != along]))
    return [int(number) for number in np.argsort(latest, axis=None, kind="stable")]


def one_at_a_time(first: Point, values: Sequence[Sequence[Value]]) -> Iterator[Point]:
    """Yield `first` with one value replaced by each value of its axis; the axes take turns."""
    for place in range(max(map(len, values))):
        for k, axis_values in enumerate(values):
            if place < len(axis_values):
                yield *first[:k], axis_values[place], *first[k + 1 :]


def informative(points: Sequence[Point], count: int) -> Iterator[Point]:
    """Yield the first point, those with extreme numbers and with each text, then `count` evenly spaced."""
    yield points[0]
    for column in zip(*points, strict=True):
        numbers = [k for k, value in enumerate(column) if is_number(value)]
        if numbers:
            yield points[min(numbers, key=column.__getitem__)]
            yield points[max(numbers, key=column.__getitem__)]
        texts = {str(value): k for k, value in enumerate(column) if not is_number(value)}
        yield from (points[k] for k in texts.values())
    yield from points[:: -(-len(points) // count)]
