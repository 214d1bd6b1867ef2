"""Bilinear elements against an integral over rays, an exact sum rule, and their own symmetries."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad_vec

from approx.kernels import over_hat, over_hat_lags, over_rectangle
from geometries.patches import Patch

PATCH = Patch(0.5, 0.2)
NEAR = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (0.31, -0.17), (-0.5, 0.2), (1.7, 0.11), (-0.03, 0.9), (2.0, 0.4)]
BESIDE = [(2.6, 0.3), (0.2, 1.7), (-4.0, 2.2), (9.0, -0.1), (0.0, 6.0)]


def kernels(c, d):
    """X^2/R^3, S^2/R^3, XS/R^3, X/R^2, S/R^2 at R = 1 in direction (c, d)."""
    return np.array([c * c, d * d, c * d, c, d])


def pieces_of(patch):
    """The four elements of the hat: bounds in x' and s', and the slopes of the two factors."""
    for i in (-1, 1):
        for j in (-1, 1):
            bounds_x, bounds_s = sorted((0, 2 * i * patch.a)), sorted((0, 2 * j * patch.b))
            yield bounds_x, bounds_s, -i / (2 * patch.a), -j / (2 * patch.b)


def integrals_by_rays(patch, x, s):
    """Polar coordinates about the observer: kernels fall as 1/R, the hat is a polynomial along a ray."""
    return sum(over_piece(x, s, piece) for piece in pieces_of(patch))


def over_piece(x, s, piece):
    bounds_x, bounds_s, slope_x, slope_s = piece
    corners = [np.arctan2(s - v, x - u) for u in bounds_x for v in bounds_s]
    breaks = np.unique([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi, *corners])

    def along(theta):
        c, d = np.cos(theta), np.sin(theta)
        ends = np.sort([[(x - u) / c for u in bounds_x], [(s - v) / d for v in bounds_s]], axis=1)
        start, end = max(ends[0, 0], ends[1, 0], 0.0), min(ends[0, 1], ends[1, 1])
        if end <= start:
            return np.zeros(5)
        fx = np.poly1d([-slope_x * c, 1 + slope_x * x])  # at x' = x - rho c
        fs = np.poly1d([-slope_s * d, 1 + slope_s * s])
        whole = np.polyint(fx * fs)
        return kernels(c, d) * (whole(end) - whole(start))

    parts = (quad_vec(along, lo, hi, epsrel=1e-13)[0] for lo, hi in pairwise(breaks))
    return sum(parts)


def assert_close(got, exact, tolerance):
    scale = np.max(np.abs(exact), axis=0)
    assert np.max(np.abs(got - exact) / scale) <= tolerance


@pytest.mark.parametrize("at", NEAR + BESIDE)
def test_hat_is_the_integral_over_rays(at):
    got = over_hat(PATCH, *(np.array(v) for v in at))
    assert_close(got, integrals_by_rays(PATCH, *at), 1e-11)  # of quad_vec, some thirty sectors


PLACES = ((0.0, 0.0), (0.7, 1.3), (1.0, 6.0), (2.9, 0.2))  # half-sides from the centre


@pytest.mark.parametrize(
    ("a", "b", "at"),
    [
        *((0.3, 3e-4, at) for at in PLACES),
        *((2e-6, 0.5, at) for at in PLACES[-1:]),
        *(pytest.param(2e-6, 0.5, at, marks=pytest.mark.slow) for at in PLACES[:-1]),
    ],
)
def test_extreme_aspects(a, b, at):
    x, s = at[0] * a, at[1] * b
    got = over_hat(Patch(a, b), np.array(x), np.array(s))
    exact = integrals_by_rays(Patch(a, b), x, s)
    assert_close(got, exact, 1e-10)


def test_hats_of_a_grid_add_up_to_a_uniform_traction_but_for_its_rim():
    """Nodes within +-7 x +-9 elements: 1 within, falling to 0 over one element at the rim."""
    k, m = np.mgrid[-7:8, -9:10]
    x, s = 0.3, -0.05
    hats = over_hat(PATCH, x - 2 * PATCH.a * k, s - 2 * PATCH.b * m).sum(axis=(1, 2))
    # the same trapezium, as a box averaged over an element: 15 x 19 elements each way
    nodes, weights = np.polynomial.legendre.leggauss(30)
    at_x, at_s = x + PATCH.a * nodes[:, None], s + PATCH.b * nodes
    box = over_rectangle(Patch(15 * PATCH.a, 19 * PATCH.b), *np.broadcast_arrays(at_x, at_s))
    trapezium = np.einsum("kij,i,j->k", box, weights, weights) / 4
    assert_close(hats, trapezium, 1e-12)


def test_far_away_it_is_the_uniform_element_with_an_error_of_second_order():
    r = np.array([20.0, 40.0, 80.0, 160.0])
    x, s = 0.96 * r, -0.28 * r
    defect = np.abs(over_hat(PATCH, x, s) / over_rectangle(PATCH, x, s) - 1)
    rates = -np.polyfit(np.log(r), np.log(defect).T, 1)[0]
    np.testing.assert_allclose(rates, 2, atol=0.02)  # next term: (0.5 / 20)^2


def test_ten_decades_away_digits_are_kept():
    x, s = np.array([3e6, -8e9]), np.array([-4e6, 6e9])
    np.testing.assert_allclose(over_hat(PATCH, x, s), over_rectangle(PATCH, x, s), rtol=1e-13)  # (a / r)^2


def test_symmetries_are_exact():
    x, s = np.array(NEAR + BESIDE).T
    at = over_hat(PATCH, x, s)
    signs_x, signs_s = np.array([1, 1, -1, -1, 1]), np.array([1, 1, -1, 1, -1])
    np.testing.assert_array_equal(over_hat(PATCH, -x, s), signs_x[:, None] * at)
    np.testing.assert_array_equal(over_hat(PATCH, x, -s), signs_s[:, None] * at)
    swapped = over_hat(Patch(PATCH.b, PATCH.a), s, x)[[1, 0, 2, 4, 3]]
    assert_close(swapped, at, 1e-13)
    np.testing.assert_array_equal(over_hat(PATCH, 0 * x, s)[[2, 3]], 0)


def test_lags_are_points():
    x, s = np.meshgrid(1.0 * np.arange(5), 0.4 * np.arange(3), indexing="ij")
    np.testing.assert_array_equal(over_hat_lags(PATCH, 5, 3), over_hat(PATCH, x, s))
