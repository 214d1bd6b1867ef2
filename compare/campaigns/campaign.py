"""A campaign: a scene, the axes along which its keys vary, and the points at which scenes are computed.

Points are all combinations of the axes' values (a grid), or random ones, or the rows of a table. Their order
covers the ranges coarsely first.
"""

import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from compare.campaigns.keys import OUT_OF_RANGE, is_number, is_out_of_range, value_text
from femic.scenes.errors import BadScene
from femic.scenes.file import SceneFile
from femic.scenes.input_files import make_files_absolute, set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from femic.scenes.values import Value, value_of

Point = tuple[Value, ...]  # one value of each axis
SEPARATOR = re.compile(r",(?=\s*[^\s,=]+=)")  # between axes in the name of a point; lists have commas, too


@dataclass(frozen=True)
class SweptAxis:
    """An axis of a campaign, with the `values` of a grid; () where points are random or from a table."""

    name: str
    label: str
    unit: str
    values: Point
    factors: Mapping[str, float | None]  # by key: the factor of a value; None: the value itself
    spacing: str = "linear"  # how distances between values are measured


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
        return coarse_order(self.shape) if self.is_grid else range(self.size)

    def point(self, number: int) -> Point:
        """Return the values of the axes at a point."""
        if not self.is_grid:
            return self.listed[number]
        places = np.unravel_index(number, self.shape)
        return tuple(axis.values[place] for axis, place in zip(self.axes, places, strict=True))

    def point_name(self, point: Point) -> str:
        """Return the name of a point, such as flank=30,ratio=1.1."""
        return ",".join(f"{axis.name}={value_text(v)}" for axis, v in zip(self.axes, point, strict=True))

    def scene_table(self, point: Point) -> dict[str, Any]:
        """Return the table of the scene at a point; raise BadScene where a key does not exist."""
        table = deepcopy(dict(self.table))
        for axis, value in zip(self.axes, point, strict=True):
            for key, factor in axis.factors.items():
                if factor is None:
                    entry = deepcopy(value)
                elif is_number(value):
                    entry = factor * float(value)
                else:
                    raise BadScene(f"sweep.{axis.name}: {value!r}: is not a number, and {key} has a factor")
                if is_out_of_range(entry):
                    raise BadScene(f"sweep.{axis.name}: {key} = {entry:g}: {OUT_OF_RANGE}")
                set_key(table, key, entry, axis.name)
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
    places = {names.index(axis): value_text(value) for axis, value in given.items()}
    points = [campaign.point(number) for number in range(campaign.size)]
    matching = [point for point in points if all(value_text(point[k]) == text for k, text in places.items())]
    if not matching:
        known = "; ".join(
            f"{names[k]}: {', '.join(dict.fromkeys(value_text(point[k]) for point in points))}"
            for k in places
        )
        raise BadScene(f"{campaign.name}: no points with {name}; there are {known}")
    return matching


def coarse_order(shape: Sequence[int]) -> list[int]:
    """Return the numbers (C order) of the points of a grid, coarse over all ranges first.

    Along each axis the ends and the middle come first, then always the middles between: by bisection.
    """
    stages = np.zeros(tuple(shape), dtype=int)
    for along, count in enumerate(shape):
        stage = np.full(count, -1)
        done, latest = sorted({0, (count - 1) // 2, count - 1}), 0
        stage[done] = 0
        while np.any(stage < 0):
            latest += 1
            middles = {(a + b) // 2 for a, b in pairwise(done)} - set(done)
            stage[list(middles)] = latest
            done = sorted({*done, *middles})
        stages = np.maximum(stages, stage.reshape([-1 if k == along else 1 for k in range(len(shape))]))
    return [int(number) for number in np.argsort(stages, axis=None, kind="stable")]
