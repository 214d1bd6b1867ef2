"""Surfaces of bodies, and the patches and lines on them."""

import numpy as np
import pytest

from geometries.contours import arc, ellipse, plane, through_points
from geometries.errors import WrongInput
from geometries.patches import Patch, line_along_s, line_along_x
from geometries.surfaces import LOWER, UPPER, Surface

Y = np.linspace(-7.0, 9.0, 15)
SURFACES = {
    "upper": Surface(UPPER, arc(10.0, 0.45, 1.1), 120.0),
    "lower": Surface(LOWER, through_points(Y, -(Y**2) / 25 + 0.1 * Y, 1.7), 80.0),
    "prismatic": Surface(UPPER, ellipse(5.0, 11.0, 1.3, 0.8)),
}
XI, S = np.array([0.0, 3.0, -40.0, 100.0]), np.array([2.0, -1.0, 0.5, 6.0])


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_axes_are_the_directions_of_growing_xi_and_s_and_right_handed(surface):
    step = 1e-5
    along_xi = surface.position(XI + step, S) - surface.position(XI - step, S)
    along_s = surface.position(XI, S + step) - surface.position(XI, S - step)
    x, s, n = surface.axes(XI, S)
    np.testing.assert_allclose(along_xi / np.linalg.norm(along_xi, axis=0), x, atol=1e-8)
    np.testing.assert_allclose(along_s / (2 * step), s, atol=1e-8)
    np.testing.assert_allclose(np.cross(x.T, s.T).T, n, atol=1e-15)
    assert np.all(n[2, :2] > 0)  # near the contact the normal points up, into the upper body


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_the_chart_inverts_global_positions(surface):
    section = np.stack([XI, np.array([5.0, -3.0, 0.0, 8.0]), np.array([1.0, -20.0, 4.0, -2.0])])
    np.testing.assert_allclose(surface.to_chart(surface.to_global(section)), section, atol=1e-11)


def test_prismatic_is_the_limit_of_a_large_rolling_radius():
    wheel, prism = (Surface(UPPER, arc(10.0, 0.45, 1.1), radius) for radius in (1e9, np.inf))
    np.testing.assert_allclose(wheel.position(XI, S), prism.position(XI, S), atol=1e-5)
    np.testing.assert_allclose(wheel.axes(XI, S), prism.axes(XI, S), atol=2e-7)
    np.testing.assert_allclose(wheel.chart_x(XI, S, 0.0), XI, atol=1e-5)
    np.testing.assert_array_equal(prism.chart_x(XI, S, 3.0), XI)


@pytest.mark.parametrize("surface", list(SURFACES.values())[:2], ids=["upper", "lower"])
def test_circles_have_the_radius_of_the_surface_and_angles_are_lag_over_their_mean(surface):
    points = surface.position(XI, S)
    height = surface.rolling_radius - surface.side * points[2]
    np.testing.assert_allclose(np.hypot(points[0], height), surface.circle_radius(S), rtol=1e-14)
    angle = surface.chart_x(5.0, S, 1.0) / surface.rolling_radius
    np.testing.assert_allclose(angle, 5.0 / (surface.circle_radius(S) + surface.circle_radius(1.0)) * 2)


@pytest.mark.parametrize(
    ("side", "radius", "message"),
    [
        *((UPPER, radius, f"rolling_radius = {radius}: must be positive") for radius in (0.0, -5.0, np.nan)),
        (0, 100.0, "side = 0: "),
    ],
)
def test_impossible_surfaces_are_refused(side, radius, message):
    with pytest.raises(WrongInput, match=message):
        Surface(side, plane(), radius)


# --- patches and lines -----------------------------------------------------------------------------


def test_area_is_that_of_both_full_sides():
    assert Patch(a=0.3, b=0.2).area == pytest.approx((2 * 0.3) * (2 * 0.2), rel=1e-15)


@pytest.mark.parametrize(
    ("a", "b", "s", "message"),
    [
        *(
            (a, b, 0.0, rf"a = {a!r}, b = {b!r} must be positive")
            for a, b in ((0.0, 0.2), (0.3, 0.0), (-0.3, -0.2), (np.nan, 0.2), (0.3, np.nan), (np.inf, 0.2))
        ),
        (1.0, 1.0, np.nan, "s = nan"),
    ],
)
def test_impossible_patches_are_refused(a, b, s, message):
    with pytest.raises(WrongInput, match=message):
        Patch(a, b, s)


def test_line_along_x_keeps_its_arc_length():
    line = line_along_x(1.6, 25.0, 11)
    assert (line.along, line.name) == ("x", "s = 1.6 mm")
    np.testing.assert_array_equal(line.s, 1.6)
    np.testing.assert_allclose(line.x, 5.0 * np.arange(-5, 6), rtol=1e-15)
    np.testing.assert_array_equal(line.running, line.x)


def test_line_along_s_keeps_its_distance():
    line = line_along_s(-0.4, (-7.0, 2.0), 4)
    assert (line.along, line.name) == ("s", "x = -0.4 mm")
    np.testing.assert_array_equal(line.x, -0.4)
    np.testing.assert_allclose(line.s, [-7.0, -4.0, -1.0, 2.0], rtol=1e-15)
    np.testing.assert_array_equal(line.running, line.s)
