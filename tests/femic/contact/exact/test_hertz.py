"""Hertz against his textbook formulas, by integration, and in the limits of one form in the other."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

from approx.halfspace import HalfSpace
from femic.contact.exact.hertz import LineContact, PointContact, combined_modulus
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies
from geometries.patches import Patch

STEEL, BRASS = Material(210e3, 0.28), Material(100e3, 0.35)
MODULUS = combined_modulus(STEEL, BRASS)
ELLIPSE = PointContact(0.01, 0.05, MODULUS).at_load(3000.0)  # long along x


def test_the_combined_modulus_is_that_of_the_half_spaces_ics():
    """Far from a small patch the normal displacement of both bodies is load / (pi E* r)."""
    nn = HalfSpace(both_bodies(STEEL, BRASS)).ics(Patch(1e-4, 2e-4), 3.0, 4.0)[2, 2]
    assert nn == pytest.approx(8e-8 / (np.pi * MODULUS * 5.0), rel=1e-8, abs=0)


def test_circle_agrees_with_the_textbook():
    radius, load = 40.0, 500.0
    contact = PointContact(1 / radius, 1 / radius, MODULUS).at_load(load)
    a = (3 * load * radius / (4 * MODULUS)) ** (1 / 3)
    assert [contact.a, contact.b] == pytest.approx([a, a], rel=1e-13)
    assert contact.approach == pytest.approx(a**2 / radius, rel=1e-13)
    assert contact.p_max == pytest.approx(2 * MODULUS * a / (np.pi * radius), rel=1e-13)
    assert contact.stiffness == pytest.approx(2 * MODULUS * a, rel=1e-13)


def test_ellipse_agrees_with_legendres_form():
    """Johnson 3.4: u = p_max / E* (L - M x^2 - N s^2) for a > b, with K and E of the eccentricity."""
    a, b = ELLIPSE.a, ELLIPSE.b
    assert a > 2 * b
    e2 = 1 - (b / a) ** 2
    K, E = ellipk(e2), ellipe(e2)
    scale = ELLIPSE.p_max * b / MODULUS
    assert ELLIPSE.approach == pytest.approx(scale * K, rel=1e-12)
    assert ELLIPSE.surfaces.curvature_x / 2 == pytest.approx(scale * (K - E) / (e2 * a**2), rel=1e-12)
    expected = scale * ((a / b) ** 2 * E - K) / (e2 * a**2)
    assert ELLIPSE.surfaces.curvature_s / 2 == pytest.approx(expected, rel=1e-12)


def test_pressures_lift_the_surfaces_apart():
    """The displacement at a point inside, by integration of 1/r in polar coordinates about it."""
    at = np.array([0.4 * ELLIPSE.a, -0.3 * ELLIPSE.b])

    def along_ray(angle):
        """Pressures are the root of a quadratic along a ray: c0 + c1 r + c2 r^2, c2 < 0."""
        ray = np.array([np.cos(angle), np.sin(angle)]) / [ELLIPSE.a, ELLIPSE.b]
        start = at / [ELLIPSE.a, ELLIPSE.b]
        c0, c1, c2 = 1 - start @ start, -2 * start @ ray, -ray @ ray
        end = (-c1 - np.sqrt(c1**2 - 4 * c0 * c2)) / (2 * c2)
        r = end * (1 - np.linspace(0, 1, 2001) ** 2)  # crowds where the root ends
        p = np.sqrt(np.maximum(c0 + c1 * r + c2 * r**2, 0))
        return -np.trapezoid(p, r)

    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    integral = 2 * np.pi * np.mean([along_ray(angle) for angle in angles])
    u = ELLIPSE.p_max * integral / (np.pi * MODULUS)
    h = (ELLIPSE.surfaces.curvature_x * at[0] ** 2 + ELLIPSE.surfaces.curvature_s * at[1] ** 2) / 2
    assert u + h == pytest.approx(ELLIPSE.approach, rel=1e-5)


def test_pressures_carry_the_load():
    t = (np.arange(400) + 0.5) / 400
    radius, angle = 1 - t[:, None] ** 2, 2 * np.pi * t  # crowd at the edge
    p = ELLIPSE.pressure(ELLIPSE.a * radius * np.cos(angle), ELLIPSE.b * radius * np.sin(angle))
    weights = 2 * t[:, None] / 400 * 2 * np.pi / 400 * radius * ELLIPSE.a * ELLIPSE.b
    assert np.sum(weights * p) == pytest.approx(ELLIPSE.load, rel=1e-5)
    assert not ELLIPSE.pressure(1.01 * ELLIPSE.a, 0.0)


@pytest.mark.parametrize("ratio", [1e-4, 0.3, 1.0, 20.0, 1e4])
def test_exchanged_axes_exchange_the_semi_axes(ratio):
    here, there = (
        PointContact(*c, MODULUS).at_load(70.0) for c in ((0.02, 0.02 * ratio), (0.02 * ratio, 0.02))
    )
    assert [here.a, here.b] == pytest.approx([there.b, there.a], rel=1e-12)
    assert here.approach == pytest.approx(there.approach, rel=1e-12)


def test_load_is_the_derivative_of_energy_by_approach():
    assert ELLIPSE.surfaces.at_approach(ELLIPSE.approach).load == pytest.approx(ELLIPSE.load, rel=1e-12)
    energy, _ = quad(lambda zeta: ELLIPSE.surfaces.at_approach(zeta).load, 1e-12, ELLIPSE.approach)
    assert ELLIPSE.energy == pytest.approx(energy, rel=1e-6)
    near = [ELLIPSE.surfaces.at_approach(ELLIPSE.approach * factor).load for factor in (1 - 1e-5, 1 + 1e-5)]
    slope = (near[1] - near[0]) / (2e-5 * ELLIPSE.approach)
    assert ELLIPSE.stiffness == pytest.approx(slope, rel=1e-8)


def test_other_units_change_nothing_else():
    """Metres and N/m^2."""
    surfaces = PointContact(0.01e3, 0.05e3, MODULUS * 1e6).at_load(3000.0)
    assert surfaces.a == pytest.approx(1e-3 * ELLIPSE.a, rel=1e-12)
    assert surfaces.p_max == pytest.approx(1e6 * ELLIPSE.p_max, rel=1e-12)


def test_a_slender_ellipse_is_a_line_contact_in_its_middle():
    """Its pressure is that of the line which carries p_max; the difference falls with (b / a)^2 ln."""
    differences = []
    for slender in (1e-3, 1e-5):
        point = PointContact(slender, 0.05, MODULUS).at_load(3000.0)
        line, load = LineContact(0.05, MODULUS), np.pi * point.b * point.p_max / 2
        differences.append(abs(line.half_width(load) / point.b - 1))
        assert line.p_max(load) == pytest.approx(point.p_max, rel=10 * differences[-1] + 1e-12)
        assert 0 < differences[-1] < 2 * (point.b / point.a) ** 2 * np.log(point.a / point.b)


def test_a_line_contact_is_in_equilibrium_and_its_gap_opens_as_the_pressures_say():
    line, load = LineContact(0.05, MODULUS), 900.0
    half_width = line.half_width(load)
    carried, _ = quad(lambda s: line.pressure(load, s), -half_width, half_width)
    assert carried == pytest.approx(load, rel=1e-8)

    def slope(s):
        """Of the displacements: 2 / (pi E*) times the integral of p(t) / (s - t), t = half_width sin."""
        t, step = np.linspace(-np.pi / 2, np.pi / 2, 2000, endpoint=False, retstep=True)
        t = t + step / 2
        p = line.p_max(load) * np.cos(t)
        return (
            -2 / (np.pi * MODULUS) * np.sum(p * half_width * np.cos(t) / (s - half_width * np.sin(t))) * step
        )

    at = np.array([1.2, -2.0]) * half_width
    grown = [(line.gap(load, s + 1e-5) - line.gap(load, s - 1e-5)) / 2e-5 for s in at]
    expected = [0.05 * s + slope(s) for s in at]
    np.testing.assert_allclose(grown, expected, rtol=1e-6)
    assert not line.gap(load, 0.9 * half_width)


def test_input_that_is_not_positive_is_refused():
    with pytest.raises(WrongInput, match=r"curvature_s = 0\.0: must be positive"):
        PointContact(0.1, 0.0, MODULUS)
    with pytest.raises(WrongInput, match=r"load = -1\.0: must be positive"):
        PointContact(0.1, 0.2, MODULUS).at_load(-1.0)
    with pytest.raises(WrongInput, match=r"curvature = inf"):
        LineContact(np.inf, MODULUS)
