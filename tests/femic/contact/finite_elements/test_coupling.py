"""Opposite points of both surfaces, and integrals over overlapping triangles of their meshes."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from femic.contact.finite_elements.coupling import barycentric, on_lower, on_upper, overlaps
from femic.contact.undeformed import Undeformed
from geometries.contours import ellipse
from geometries.surfaces import LOWER, UPPER, Surface

# ---- opposite points

FLANK = 1.3  # rad; the lower contour has a radius of 3.5 mm where its flanks begin


@pytest.mark.parametrize("shift", [0.0, 0.4])
def test_opposite_points_are_opposite_in_both_directions(shift):
    """The wheel rises by 0 to 87 mm above the rail, so distances are up to 25 radii of curvature."""
    wheel = Surface(UPPER, ellipse(13.7, 6.49, FLANK, FLANK), rolling_radius=650.0)
    rail = Surface(LOWER, ellipse(12.97, 6.485, FLANK, FLANK))
    undeformed = Undeformed(wheel, rail, (-14.8, 14.8), shift)
    xi, t = (grid.ravel() for grid in np.meshgrid([0.0, 40.0, 160.0, 340.0], np.linspace(-20, 20, 41)))
    opposite = on_lower(undeformed, np.stack([xi, t]))
    back = on_upper(undeformed, opposite, undeformed.distance(*opposite))
    np.testing.assert_allclose(back, [xi, t], rtol=0, atol=1e-9)


# ---- overlaps


def triangulation(seed, n):
    """Triangles (2, 3, n) of the rectangle 0..2 x 0..1, its edges divided differently for each seed."""
    rng = np.random.default_rng(seed)
    edge = rng.uniform(0, 1, (n // 4, 2)) * [2, 1]
    sides = [edge * [1, 0], edge * [1, 0] + [0, 1], edge * [0, 1], edge * [0, 1] + [2, 0]]
    points = np.concatenate([[[0, 0], [2, 0], [0, 1], [2, 1]], *sides, rng.uniform(0, 1, (n, 2)) * [2, 1]])
    return np.moveaxis(points[Delaunay(points).simplices], -1, 0).swapaxes(1, 2)


def moment(i, j):
    """The integral of x^i y^j over the rectangle."""
    return 2 ** (i + 1) / (i + 1) / (j + 1)


@pytest.mark.parametrize("seeds", [(0, 1), (2, 3), (4, 4)])  # the last: the same triangles twice
def test_polynomials_are_integrated_exactly(seeds):
    first, second = (triangulation(seed, n) for seed, n in zip(seeds, (24, 37), strict=True))
    (x, y), weights, _, _ = overlaps(first, first if seeds[0] == seeds[1] else second)
    for i, j in ((0, 0), (1, 0), (0, 2), (3, 2), (1, 4)):
        assert weights @ (x**i * y**j) == pytest.approx(moment(i, j), rel=1e-11)


def test_points_lie_in_both_of_their_triangles():
    first, second = triangulation(5, 20), triangulation(6, 33)
    points, weights, *numbers = overlaps(first, second)
    for triangles, of in zip((first, second), numbers, strict=True):
        shares = barycentric(triangles[:, :, of], points)
        assert shares.min() > -1e-9
        whole = np.bincount(of, weights, triangles.shape[2])
        a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        assert whole == pytest.approx(np.abs(a[0] * b[1] - a[1] * b[0]) / 2, rel=1e-9, abs=1e-13)


def test_triangles_that_turn_the_other_way_overlap_as_well():
    first, second = triangulation(7, 12), triangulation(8, 15)[:, ::-1]
    assert overlaps(first, second)[1].sum() == pytest.approx(2.0, rel=1e-12)
