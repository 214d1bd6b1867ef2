"""The common refinement of two triangulations of a plane: quadrature on the overlaps of their triangles.

A field that is a polynomial on each triangle of the one and of the other is one on each overlap, so that
products of both are integrated exactly. An overlap is convex: the triangles from its middle to its sides.
"""

from dataclasses import dataclass

import numpy as np
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTri

from geometries.arrays import Array, Indices

ORDER = 5  # of the quadrature on each part of an overlap
ROUNDING = 1e-12  # of barycentric coordinates
SMALLEST = 1e-14  # area of a part that counts, as a share of that of the triangle


@dataclass(frozen=True, eq=False)
class Quadrature:
    """Points (2, n) and weights (n,) on overlaps; the triangle of each mesh in which each lies, (n,)."""

    points: Array
    weights: Array
    of_first: Indices
    of_second: Indices


def overlaps(first: Array, second: Array) -> Quadrature:
    """Quadrature on the overlaps of triangles with the corners first (2, 3, n) and second (2, 3, m)."""
    i, j = _near(first, second)
    corners = _corners(first[:, :, i], second[:, :, j])  # (2, 15, n_pairs), nan where there is none
    parts, pair = _parts(corners)  # (2, 3, n_parts)
    area = np.abs(_cross(parts[:, 1] - parts[:, 0], parts[:, 2] - parts[:, 0])) / 2
    whole = np.abs(_cross(first[:, 1] - first[:, 0], first[:, 2] - first[:, 0])) / 2
    large_enough = area > SMALLEST * whole[i[pair]]
    parts, pair, area = parts[:, :, large_enough], pair[large_enough], area[large_enough]
    local, weights = get_quadrature(RefTri, ORDER)
    shares = np.stack([1 - local.sum(axis=0), *local])  # (3, n_q)
    points = np.einsum("dcn,cq->dnq", parts, shares).reshape(2, -1)
    pair = np.repeat(pair, len(weights))
    return Quadrature(points, np.outer(area, 2 * weights).ravel(), i[pair], j[pair])


def barycentric(corners: Array, points: Array) -> Array:
    """Barycentric coordinates (3, n) of points (2, n) in triangles (2, 3, n)."""
    origin = corners[:, 0]
    to_1, to_2, to_point = corners[:, 1] - origin, corners[:, 2] - origin, points - origin
    twice = _cross(to_1, to_2)
    second, third = _cross(to_point, to_2) / twice, _cross(to_1, to_point) / twice
    return np.stack([1 - second - third, second, third])


def _cross(a: Array, b: Array) -> Array:
    """Return the z component of the product of plane vectors (2, ...)."""
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def _near(first: Array, second: Array) -> tuple[Indices, Indices]:
    """Return numbers of the pairs of triangles whose bounding boxes overlap, (n_pairs,) each."""
    (low_1, high_1), (low_2, high_2) = ((t.min(axis=1), t.max(axis=1)) for t in (first, second))
    near = np.ones((first.shape[2], second.shape[2]), dtype=bool)
    for d in range(2):
        near &= (low_1[d][:, None] <= high_2[d]) & (low_2[d] <= high_1[d][:, None])
    i, j = np.nonzero(near)
    return i, j


def _corners(first: Array, second: Array) -> Array:
    """Corners of the overlaps of pairs of triangles (2, 3, n), shape (2, 15, n), nan for missing ones."""
    inner = [_inside(first, second), _inside(second, first)]
    crossings = [
        _crossing(first[:, [k, (k + 1) % 3]], second[:, [m, (m + 1) % 3]])[:, None]
        for k in range(3)
        for m in range(3)
    ]
    return np.concatenate([*inner, *crossings], axis=1)


def _inside(corners: Array, triangles: Array) -> Array:
    """Return the corners (2, 3, n) that lie in the triangles (2, 3, n); nan for the others."""
    shares = np.stack([barycentric(triangles, corners[:, k]) for k in range(3)], axis=1)  # (3, corner, n)
    return np.where(np.all(shares >= -ROUNDING, axis=0), corners, np.nan)


def _crossing(a: Array, b: Array) -> Array:
    """Return points (2, n) in which segments a and b (2, 2 ends, n) cross; nan where they do not."""
    along_a, along_b, between = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0], b[:, 0] - a[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        twice = _cross(along_a, along_b)
        on_a, on_b = _cross(between, along_b) / twice, _cross(between, along_a) / twice
    cross = (on_a >= 0) & (on_a <= 1) & (on_b >= 0) & (on_b <= 1)  # False for parallel ones
    return np.where(cross, a[:, 0] + np.where(cross, on_a, 0.0) * along_a, np.nan)


def _parts(corners: Array) -> tuple[Array, Indices]:
    """Triangles (2, 3, n_parts) from the middle of each overlap to its sides, and the overlap of each.

    Corners are sorted by their direction from the middle; the missing ones, nan, are put in the place of
    the first, where they make triangles without area.
    """
    pairs = np.flatnonzero(np.sum(~np.isnan(corners[0]), axis=0) >= 3)
    corners = corners[:, :, pairs]
    middle = np.nanmean(corners, axis=1)
    direction = np.arctan2(*(corners - middle[:, None])[::-1])
    order = np.argsort(direction, axis=0)  # nan come last
    ring = np.take_along_axis(corners, np.broadcast_to(order, corners.shape), axis=1)
    ring = np.where(np.isnan(ring), ring[:, :1], ring)
    following = np.roll(ring, -1, axis=1)
    parts = np.stack([np.broadcast_to(middle[:, None], ring.shape), ring, following], axis=1)
    return parts.reshape(2, 3, -1), np.tile(pairs, ring.shape[1])
