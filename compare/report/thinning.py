"""Polylines with no more points than a drawing shows.

Source: D. H. Douglas, T. K. Peucker, Cartographica 10 (1973) 112-122.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array


def thin(x: ArrayLike, y: ArrayLike, tolerance: float) -> tuple[Array, Array]:
    """Return points of a polyline, (n,) each, whose polyline passes all left-out ones within a tolerance.

    NaN separates parts and stays.
    """
    points = np.array([np.asarray(x, dtype=float), np.asarray(y, dtype=float)])
    known = np.isfinite(points).all(axis=0)
    edges = np.flatnonzero(np.diff(known.astype(int), prepend=0, append=0))
    spans = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    kept = _kept(spans, len(known), lambda first, last: _distances(points[:, first : last + 1]), tolerance)
    kept[[first - 1 for first, _ in spans[1:]]] = True
    return points[0, kept], points[1, kept]


def thin_together(x: Array, curves: Array, tolerance: float) -> list[int]:
    """Return the points between which straight lines replace all curves (k, n) over x, to a tolerance.

    Where one curve is NaN it counts as 0.
    """
    drawn = np.nan_to_num(curves)

    def distances(first: int, last: int) -> Array:
        ends = drawn[:, [first, last]]
        share = (x[first : last + 1] - x[first]) / (x[last] - x[first])
        lines = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * share
        return np.max(np.abs(drawn[:, first : last + 1] - lines), axis=0)

    kept = _kept([(0, len(x) - 1)], len(x), distances, tolerance)
    return [int(number) for number in np.flatnonzero(kept)]


def _kept(
    spans: list[tuple[int, int]], count: int, distances: Callable[[int, int], Array], tolerance: float
) -> Array:
    """Return which of some points stay: the ends of spans, and what is too far from a line, furthest first.

    `distances` has the distances of the points of a span, with both ends, from its line.
    """
    kept, spans = np.zeros(count, dtype=bool), list(spans)
    while spans:
        first, last = spans.pop()
        kept[[first, last]] = True
        away = distances(first, last)
        furthest = int(np.argmax(away))
        if away[furthest] > tolerance:
            spans += [(first, first + furthest), (first + furthest, last)]
    return kept


def _distances(points: Array) -> Array:
    """Return the distances of points (2, n) from the straight line between the first and the last one."""
    start, along = points[:, :1], points[:, -1] - points[:, 0]
    length = float(np.hypot(*along))
    offset = points - start
    if length == 0:
        return np.asarray(np.hypot(*offset))
    t = np.clip(along @ offset / length**2, 0.0, 1.0)
    return np.asarray(np.hypot(*(offset - along[:, None] * t)))
