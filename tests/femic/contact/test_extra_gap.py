"""Gaps that are added: linear between their points, 0 beyond them; what cannot be read between points."""

import numpy as np
import pytest

from femic.contact.specification import extra_gap
from geometries.errors import WrongInput

X, S = np.linspace(-3.0, 3.0, 7)[:, None], np.linspace(-4.4, 4.6, 10)[None]
LATTICE = np.array([(x, s) for x in (-4.0, -1.0, 5.0) for s in (-5.0, 0.5, 6.0)])


def plane(x, s):
    """A gap that is linear: interpolation between any points gives it back."""
    return 0.3 + 0.02 * x - 0.05 * s


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9, (1e-6, 1.0)], ids=["nano", "one", "giga", "narrow band"])
@pytest.mark.parametrize("away", [0.0, 1e3])
def test_gap_is_linear_between_points_of_any_spacing(size, away):
    """About places that are a thousand spacings from the origin, too, and on a narrow band."""
    size_x, size_s = np.broadcast_to(size, 2)
    gap = extra_gap(np.column_stack([(LATTICE + away) * size, plane(*LATTICE.T)]))
    result = gap.at(size_x * (X + away), size_s * (S + away))
    np.testing.assert_allclose(result, plane(X, S), rtol=0, atol=1e-9)


def test_gap_on_a_grid_does_not_depend_on_the_order_of_its_points():
    """Each square of a grid has two diagonals: which one bounds triangles must not follow from the order."""
    chance = np.random.default_rng(3)
    x, s = (places.ravel() for places in np.meshgrid(np.linspace(-4, 4, 7), np.linspace(-3, 3, 5)))
    columns = np.column_stack([x, s, chance.uniform(-0.02, 0.02, x.size)])
    at = np.linspace(-4, 4, 33)[:, None], np.linspace(-3, 3, 29)
    for _ in range(5):
        other = extra_gap(chance.permutation(columns)).at(*at)
        np.testing.assert_array_equal(other, extra_gap(columns).at(*at))


def test_gap_is_zero_beyond_its_points():
    gap = extra_gap(np.column_stack([LATTICE, np.ones(len(LATTICE))]))
    np.testing.assert_array_equal(gap.at(np.array([[-4.1], [5.1]]), np.array([[0.0]])), 0.0)
    profile = extra_gap(np.array([(-1.0, 2.0), (1.0, 2.0)]))
    np.testing.assert_array_equal(profile.at(X, np.array([[-1.01, 1.01]])), 0.0)


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_profile_is_the_same_at_all_x_in_all_formats(order):
    """As columns s, gap, at one x, or as a strip of points that is long along x."""
    s = np.array([-5.0, -1.0, 0.5, 6.0])
    rows = np.column_stack([s, np.abs(s)])[order]
    forms = (
        rows,
        np.column_stack([np.full(4, 2.0), rows]),
        np.concatenate([np.column_stack([np.full(4, x), rows]) for x in (-9.0, 9.0)]),
    )
    expected = np.interp(S, s, np.abs(s)) + 0 * X
    for columns in forms:
        np.testing.assert_allclose(extra_gap(columns).at(X, S), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("columns", "reason"),
    [
        ([(0.0, 1.0)], "one point: give two or more"),
        ([(2.0, 0.0, 1.0)], "one point: give two or more"),
        ([(1.0, 1.0, 1.0)] * 5, r"points 1 and 2 are at the same place \(1\): remove one"),
        ([(0.0, 1.0), (2.0, 1.0), (0.0, 3.0)], r"points 1 and 3 are at the same place \(0\)"),
        (
            [*((*place, 0.0) for place in LATTICE), (5.0, 6.0, 0.0)],
            r"points 9 and 10 .* \(5, 6\): remove one",
        ),
        ([(x, 2.0, 1.0) for x in range(4)], "4 points on one line, not at one x"),
        ([(x, 2.0 * x + 1, 1.0) for x in range(4)], "give points beside it, too, or columns s, gap"),
        ([(0.0, 0.0, 1.0), (1.0, 1.0, 1.0)], "2 points on one line"),
    ],
)
def test_points_without_a_unique_gap_between_them_are_refused(columns, reason):
    with pytest.raises(WrongInput, match=reason):
        extra_gap(np.array(columns))
