"""The order of points, and the points whose scenes are checked before a run."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from femic.campaigns.files.keys import is_number
from femic.scenes.values import Value
from geometries.arrays import Indices

Point = tuple[Value, ...]  # one value of each axis


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
