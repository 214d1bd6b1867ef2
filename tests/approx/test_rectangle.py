"""The integrals against closed forms in many digits, against quadrature, and over ten decades."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from approx.kernels import over_lags, over_rectangle
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


def test_each_point_is_its_own():
    rng = np.random.default_rng(1)
    x, s = rng.normal(0, 0.6, (2, 7, 11))
    whole = over_rectangle(Patch(0.5, 0.2), x, s)
    assert whole.shape == (5, 7, 11)
    for k in np.ndindex(7, 11):
        np.testing.assert_array_equal(over_rectangle(Patch(0.5, 0.2), x[k], s[k]), whole[(slice(None), *k)])


def test_many_points_are_worked_on_in_parts():
    x, s = np.linspace(-30, 20, 40_001), np.linspace(5, -9, 40_001)
    whole = over_rectangle(Patch(0.5, 0.2), x, s)
    some = np.arange(0, 40_001, 977)
    np.testing.assert_array_equal(over_rectangle(Patch(0.5, 0.2), x[some], s[some]), whole[:, some])


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
