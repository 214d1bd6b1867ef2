"""Rigid velocities against the velocities of a rigid wheel that turns about its axle, in three dimensions."""

import numpy as np
import pytest

from femic.contact.friction.motion import NAMES, Creepages, RollingKinematics
from geometries.contours import arc, plane
from geometries.errors import WrongInput

CONTOUR, RADIUS, SPEED = arc(10.0, 1.2, 0.9), 460.0, 3.0
X, S = np.linspace(-6.0, 5.0, 7), np.linspace(-11.0, 8.0, 9)
HEIGHT = CONTOUR.position(S)[1] - 0.8 + 0.05 * S  # of another contour, that of the wheel
ROLLING = RollingKinematics(CONTOUR, RADIUS, X, S, HEIGHT)
CASES = [
    Creepages(),
    Creepages(2e-3),
    Creepages(lateral=-3e-3),
    Creepages(spin=1e-4),
    Creepages(-0.3, 0.2, 0.05),
]


def of_a_rigid_wheel(creepages, x, s, height):
    """Velocity over the rail along x, s, n per unit of rolled distance, one point at a time.

    In axes that move with the contact the rail runs back with the speed V, and the wheel turns about an axle
    at the height R_roll over its crown. Turning about y so that the lowest point runs back is omega > 0.
    """
    y, _ = CONTOUR.position(s)
    tangent_y, tangent_z = CONTOUR.tangent(s)
    omega = (1 + creepages.longitudinal) * SPEED / RADIUS
    about_axle = np.cross([0.0, omega, 0.0], [x, y, height - RADIUS])
    about_z = np.cross([0.0, 0.0, creepages.spin * SPEED], [x, y, height])
    aside = np.array([0.0, creepages.lateral * SPEED, 0.0])
    rail = np.array([-SPEED, 0.0, 0.0])
    over_rail = (about_axle + about_z + aside - rail) / SPEED
    along_x, along_s = np.array([1.0, 0.0, 0.0]), np.array([0.0, tangent_y, tangent_z])
    return [over_rail @ direction for direction in (along_x, along_s, np.cross(along_x, along_s))]


@pytest.mark.parametrize("creepages", CASES, ids=str)
def test_rigid_velocity_is_that_of_a_rotating_wheel(creepages):
    expected = np.array(
        [[of_a_rigid_wheel(creepages, x, *at) for at in zip(S, HEIGHT, strict=True)] for x in X]
    )
    np.testing.assert_allclose(ROLLING.rigid_velocity(creepages), expected, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(ROLLING.rigid_slip(creepages), ROLLING.rigid_velocity(creepages)[..., :2])


def test_a_driven_wheel_slips_back_and_a_lateral_creepage_is_a_slip_to_larger_s():
    crown = RollingKinematics(CONTOUR, RADIUS, np.zeros(1), np.zeros(1), np.zeros(1))
    assert crown.rigid_slip(Creepages(1e-3, 2e-3)).ravel() == pytest.approx([-1e-3, 2e-3])


def test_each_creepage_adds_its_own_slip():
    result = ROLLING.rigid_slip(Creepages())
    for name, value in zip(NAMES, (-2e-3, 5e-3, 3e-4), strict=True):
        result = result + value * ROLLING.per_creepage(name)
    np.testing.assert_allclose(result, ROLLING.rigid_slip(Creepages(-2e-3, 5e-3, 3e-4)), atol=1e-16)


def test_a_plane_on_a_plane_only_slides_and_turns():
    flat = RollingKinematics(plane(), np.inf, X, S, 0 * S)
    assert np.all(flat.rigid_velocity(Creepages()) == 0)
    slip = flat.rigid_slip(Creepages(1e-3, 2e-3, 1e-4))
    np.testing.assert_allclose(slip[..., 0], np.broadcast_to(-1e-3 - 1e-4 * S, (7, 9)))
    np.testing.assert_allclose(slip[..., 1], np.broadcast_to(2e-3 + 1e-4 * X[:, None], (7, 9)))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_creepages_must_be_numbers(name, value):
    with pytest.raises(WrongInput, match=f"{name}=.*: must be finite"):
        Creepages(**{name: value})
