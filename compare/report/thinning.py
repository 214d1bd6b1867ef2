"""Polylines with no more points than a drawing shows."""

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array


def thin(x: ArrayLike, y: ArrayLike, tolerance: float) -> tuple[Array, Array]:
    """Return points of a polyline, (n,) each, whose polyline passes all left-out ones within a tolerance.

    NaN separates parts and stays. Source: D. H. Douglas, T. K. Peucker, Cartographica 10 (1973) 112-122.
    """
    points = np.array([np.asarray(x, dtype=float), np.asarray(y, dtype=float)])
    known = np.isfinite(points).all(axis=0)
    edges = np.flatnonzero(np.diff(known.astype(int), prepend=0, append=0))
    spans = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    kept = np.zeros(len(known), dtype=bool)
    kept[[first - 1 for first, _ in spans[1:]]] = True
    while spans:
        first, last = spans.pop()
        kept[[first, last]] = True
        distances = _distances(points[:, first : last + 1])
        furthest = int(np.argmax(distances))
        if distances[furthest] > tolerance:
            spans += [(first, first + furthest), (first + furthest, last)]
    return points[0, kept], points[1, kept]


def _distances(points: Array) -> Array:
    """Return the distances of points (2, n) from the straight line between the first and the last one."""
    start, along = points[:, :1], points[:, -1] - points[:, 0]
    length = float(np.hypot(*along))
    offset = points - start
    if length == 0:
        return np.asarray(np.hypot(*offset))
    t = np.clip(along @ offset / length**2, 0.0, 1.0)
    return np.asarray(np.hypot(*(offset - along[:, None] * t)))
