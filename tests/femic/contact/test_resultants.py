"""Forces and moments: one traction after the other, an arc's centre, equilibrium of a closed surface."""

import numpy as np
import pytest

from femic.contact.patch import centre_of_pressure, resultant
from geometries.contours import arc, ellipse

X = np.array([-1.0, 0.5, 2.0])
S = np.array([-3.0, -1.0, 0.5, 4.0, 5.0])
AREA = 0.7
PRESSURES = [0.0, 0.0, 1.0]  # along n
CONTOUR = ellipse(9.0, 14.0, 0.6, 1.0)


@pytest.mark.parametrize("direction", range(3))
@pytest.mark.parametrize("place", [(0, 3), (2, 1)])
def test_one_traction_is_a_force_at_its_place(direction, place):
    """r x f, with the local directions (1, 0, 0), (0, cos, -sin), (0, sin, cos) in global axes."""
    tractions = np.zeros((3, 5, 3))
    tractions[*place, direction] = 2.0
    s = S[place[1]]
    delta = float(CONTOUR.inclination(s))
    axis = [
        (1.0, 0.0, 0.0),
        (0.0, np.cos(delta), -np.sin(delta)),
        (0.0, np.sin(delta), np.cos(delta)),
    ][direction]
    force = 2.0 * AREA * np.array(axis)
    total = resultant(tractions, CONTOUR, X, S, AREA)
    np.testing.assert_allclose(total.force, force, atol=1e-14)
    moment = np.cross([X[place[0]], *CONTOUR.position(s)], force)
    np.testing.assert_allclose(total.moment, moment, atol=1e-12)


def test_pressures_on_an_arc_pass_through_its_centre():
    """It is R below the contact centre: M_x = R F_y. M_z = 0 where pressures are even in x."""
    x, s = np.array([-1.0, 1.0]), np.linspace(-4, 6, 11)
    p = np.random.default_rng(1).uniform(0, 5, 11) * np.ones((2, 1))
    total = resultant(p[..., None] * PRESSURES, arc(10.0, 0.9, 0.9), x, s, AREA)
    assert total.moment[0] == pytest.approx(10.0 * total.force[1], rel=1e-12)
    assert abs(total.force[1]) > 0.05 * total.force[2]
    np.testing.assert_allclose(total.moment[1:], 0.0, atol=1e-10)
    assert total.force[0] == 0.0


def test_the_moment_about_z_has_the_part_of_pressures_on_inclined_places():
    """Pressures that are odd in x have no force along z on a slope, but turn about z."""
    p = np.array([[-1.0], [1.0]])
    total = resultant(
        p[..., None] * PRESSURES, arc(10.0, 0.9, 0.9), np.array([-2.0, 2.0]), np.array([5.0]), AREA
    )
    assert total.moment[2] == pytest.approx(4.0 * AREA * np.sin(0.5))
    assert total.force[2] == pytest.approx(0.0, abs=1e-14)


def test_centre_of_pressure_is_the_mean_arc_length():
    p = np.array([[1.0, 0.0, 3.0], [1.0, 0.0, 0.0]])
    assert centre_of_pressure(p, np.array([-1.0, 0.0, 4.0])) == pytest.approx(10 / 5)
