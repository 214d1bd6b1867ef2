"""Contacts that are not symmetric: forces, moments and the centre of pressure against closed forms.

Two arcs side by side touch where the line between their centres inclines by delta. A small contact there is
Hertz's: its pressures act along that line, so F_y / N = tan(delta), and no vertical load changes that.
"""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.finite_elements.bodies import Expected
from femic.contact.finite_elements.meshed_contact import Bodies, mesh_bodies, solved
from femic.contact.finite_elements.result import compute_numbers
from geometries.bodies import Body, Domain
from geometries.contours import arc
from geometries.surfaces import LOWER, UPPER
from tests.femic.contact.finite_elements.ellipse import BRASS, STEEL

R_LOWER, R_UPPER, R_ROLLING = 60.0, 90.0, 400.0  # mm; both arcs are convex
DELTA = np.radians(35.0)
ASIDE = (R_LOWER + R_UPPER) * np.sin(DELTA)  # of the upper body [mm]
MIDDLE = R_LOWER * DELTA  # arc length where they touch [mm]
CIRCLE = R_ROLLING - R_UPPER * (1 - np.cos(DELTA))  # radius of the wheel there [mm]
LOAD, CELLS, FAR, SOUGHT = 600.0, 4.0, 80.0, 10.0
# the contact lies in a plane that inclines: the load on it is N / cos(delta)
HERTZ = PointContact(
    np.cos(DELTA) / CIRCLE, 1 / R_LOWER + 1 / R_UPPER, combined_modulus(STEEL, BRASS)
).at_load(LOAD / np.cos(DELTA))


def bodies(side=1):
    """The pair with the upper body moved towards +y, or towards -y."""
    domain = Domain(FAR, FAR)
    lower = Body(LOWER, arc(R_LOWER, 0.9, 1.0), STEEL, domain)
    upper = Body(UPPER, arc(-R_UPPER, 0.9, 1.0), BRASS, domain, rolling_radius=R_ROLLING)
    if side < 0:
        lower = replace(lower, contour=arc(R_LOWER, 1.0, 0.9))
        upper = replace(upper, contour=arc(-R_UPPER, 1.0, 0.9))
    low, high = sorted((side * (MIDDLE - SOUGHT), side * (MIDDLE + SOUGHT)))
    return Bodies(lower, upper, (low, high), side * ASIDE)


def level(side=1):
    """The contact on meshes for Hertz's patch."""
    whole, half = bodies(side), HERTZ.b
    patch = Expected(HERTZ.a, (side * MIDDLE - half, side * MIDDLE + half))
    return solved(whole, mesh_bodies(whole, patch, CELLS), LOAD)


@pytest.fixture(scope="module")
def result():
    return level()


def test_small_contact_on_the_flank_agrees_with_hertz(result):
    """Largest pressure and half-lengths, at 4 cells along the shorter one."""
    numbers = compute_numbers(result)
    assert numbers.p_max == pytest.approx(HERTZ.p_max, rel=0.03)
    assert [numbers.a, numbers.b] == pytest.approx([HERTZ.a, HERTZ.b], rel=0.06)


def test_lateral_force_is_the_load_times_the_tangent(result):
    """The centre of pressure is known to a twentieth of a cell, which turns the force by 1/6000."""
    numbers = compute_numbers(result)
    assert numbers.s_centre == pytest.approx(MIDDLE, abs=0.05 * HERTZ.b / CELLS)
    assert numbers.F_y == pytest.approx(LOAD * np.tan(DELTA), rel=1e-3)


def test_moment_is_that_of_a_force_through_the_centre_of_the_arc(result):
    """All normals of an arc meet at its centre, which is R below the crown: M_x = R F_y."""
    numbers = compute_numbers(result)
    assert numbers.M_x == pytest.approx(R_LOWER * numbers.F_y, rel=1e-9)


def test_supports_of_both_bodies_balance_the_lateral_force(result):
    """To the tolerance of the linear problems."""
    lower, upper = result.support_forces
    assert [lower[1], upper[1]] == pytest.approx([result.lateral_force, -result.lateral_force], rel=1e-3)
    assert [lower[2], upper[2]] == pytest.approx([LOAD, -LOAD], rel=1e-5)


def test_mirrored_contact_has_the_opposite_lateral_force(result):
    """Meshes are no mirror images: numbers agree as well as each of them is known."""
    numbers, mirrored = compute_numbers(result), compute_numbers(level(-1))
    assert mirrored.F_y == pytest.approx(-numbers.F_y, rel=2e-3)
    assert mirrored.M_x == pytest.approx(-numbers.M_x, rel=2e-3)
    assert mirrored.s_centre == pytest.approx(-numbers.s_centre, abs=0.1 * HERTZ.b / CELLS)
    assert mirrored.p_max == pytest.approx(numbers.p_max, rel=0.03)
