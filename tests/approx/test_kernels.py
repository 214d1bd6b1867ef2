"""Integrals over rectangles and hats: closed forms in many digits, quadrature, rays, an exact sum rule."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec

from approx.kernels import over_hat, over_hat_lags, over_lags, over_rectangle
from compare.validation.extremes.analytic import exact_integrals
from geometries.patches import Patch

TOLERANCE = 5e-15  # 2e-15 seen: some twenty roundings, not all of one sign
quiet = settings(deadline=None, max_examples=300, database=None)


def by_quadrature(patch, x, s):
    """The kernels of Boussinesq and Cerruti, integrated numerically in 40 digits away from the patch."""
    with mpmath.workdps(40):
        nodes = mpmath.calculus.quadrature.GaussLegendre(mpmath.mp).calc_nodes(5, 140)
        total = [mpmath.mpf(0)] * 5
        for u, weight_u in nodes:
            for v, weight_v in nodes:
                X, S = x - patch.a * u, s - patch.b * v
                R, weight = mpmath.sqrt(X * X + S * S), patch.a * patch.b * weight_u * weight_v
                kernels = (X * X / R**3, S * S / R**3, X * S / R**3, X / R**2, S / R**2)
                total = [t + weight * k for t, k in zip(total, kernels, strict=True)]
    return total


def error(patch, x, s, exact):
    """Largest relative error: of I_xx, I_ss in I_0, with which they appear in the ICs, else of the value."""
    got = over_rectangle(patch, np.array(float(x)), np.array(float(s)))
    scale = [exact[0] + exact[1]] * 2 + exact[2:]
    pairs = zip(got, exact, scale, strict=True)
    return max(float(abs((g - e) / c)) if c else (0.0 if g == 0 else np.inf) for g, e, c in pairs)


# --- every digit everywhere ----------------------------------------------------------------------------

decades = st.floats(-6, 6)
signs = st.sampled_from([-1.0, 1.0])


@st.composite
def coordinates(draw, half, other):
    """On the axis, on an edge, 1e-12 beside either, near, and up to 1e10 patches away."""
    kind = draw(st.integers(0, 6))
    power = draw(st.floats(-12, 0))
    return (
        draw(signs)
        * [
            0.0,
            half,
            half * (1 + 10**power),
            half * (1 - 10**power),
            half * 10**power,
            max(half, other) * 10 ** (power * 10 / 12 + 10),
            other * 10 ** (power / 6 + 1),
        ][kind]
    )


@st.composite
def cases(draw):
    a = 10 ** draw(st.floats(-3, 3))
    b = a * 10 ** draw(decades)
    return Patch(a, b), draw(coordinates(a, b)), draw(coordinates(b, a))


@quiet
@given(cases())
def test_fourteen_digits_at_any_distance_and_aspect(case):
    patch, x, s = case
    assert error(patch, x, s, exact_integrals(patch, x, s)) <= TOLERANCE


LINES = (0.0, 1e-12, 0.3, 1 - 1e-12, 1.0, 1 + 1e-12, 3.0, 1e3, 1e8, 1e10)


@pytest.mark.parametrize("aspect", [1e-6, 1e-2, 0.7, 30.0, 1e6])
def test_fourteen_digits_on_every_axis_edge_and_corner_and_1e_12_beside(aspect):
    patch = Patch(0.4, 0.4 / aspect)
    for i in LINES:
        for j in LINES:
            x, s = i * patch.a, -j * patch.b
            assert error(patch, x, s, exact_integrals(patch, x, s)) <= TOLERANCE, (i, j)


@pytest.mark.parametrize(("x", "s"), [(0.9, 0.4), (-3.0, 1.1), (0.0, -0.8), (40.0, 1e-3), (0.2, 7e3)])
def test_closed_forms_are_the_integrals_of_the_kernels(x, s):
    patch = Patch(0.5, 0.2)
    quadrature = by_quadrature(patch, x, s)
    for exact, closed in zip(quadrature, exact_integrals(patch, x, s), strict=True):
        assert abs(exact - closed) <= 1e-25 * (quadrature[0] + quadrature[1])  # 3 half-sides: 2.6^(-96)
    assert error(patch, x, s, [v if abs(v) > 1e-30 else mpmath.mpf(0) for v in quadrature]) <= TOLERANCE


def test_corners_and_edges_are_not_singular():
    patch = Patch(0.5, 0.2)
    lines = np.array(
        [-np.nextafter(0.5, 1), -0.5, -0.2, -5e-324, 0.0, 1e-300, 0.2, np.nextafter(0.5, 0), 0.5, 9.0]
    )
    assert np.all(np.isfinite(over_rectangle(patch, *np.meshgrid(lines, lines))))


def test_lengths_may_be_tiny_or_huge():
    x, s = np.array([0.3, 2.0, 0.0]), np.array([-0.7, 0.2, 5.0])
    at_one = over_rectangle(Patch(0.5, 0.2), x, s)
    for power in (-220, 220):  # of two: exact scaling, 1e-66 and 1e66
        unit = 2.0**power
        scaled = over_rectangle(Patch(0.5 * unit, 0.2 * unit), unit * x, unit * s)
        np.testing.assert_array_equal(scaled, unit * at_one)


# --- shapes and the grid of lags -------------------------------------------------------------------------


def test_each_point_is_its_own_also_where_many_are_worked_on_in_parts():
    x, s = np.random.default_rng(1).normal(0, 0.6, (2, 40_001))
    whole, patch = over_rectangle(Patch(0.5, 0.2), x, s), Patch(0.5, 0.2)
    for k in range(0, 40_001, 977):
        np.testing.assert_array_equal(over_rectangle(patch, x[k], s[k]), whole[:, k])


@pytest.mark.parametrize(("n_x", "n_s"), [(1, 1), (1, 5), (6, 1), (9, 4), (3, 9000)])
def test_lags_are_points(n_x, n_s):
    patch = Patch(0.5, 0.2)
    x, s = np.meshgrid(1.0 * np.arange(n_x), 0.4 * np.arange(n_s), indexing="ij")
    lags, points = over_lags(patch, n_x, n_s), over_rectangle(patch, x, s)
    scale = np.abs(points)
    scale[:2] = points[0] + points[1]
    # corners at 0.2 (2 l + 1) and at 0.4 l + 0.2 differ by a rounding
    assert np.all(np.abs(lags - points) <= TOLERANCE * scale)
    np.testing.assert_array_equal(lags == 0, points == 0)


# --- hats: bilinear elements ---------------------------------------------------------------------------

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


def test_lags_of_hats_are_points():
    x, s = np.meshgrid(1.0 * np.arange(5), 0.4 * np.arange(3), indexing="ij")
    np.testing.assert_array_equal(over_hat_lags(PATCH, 5, 3), over_hat(PATCH, x, s))
