"""What a rolling problem reads from contacts: forces and work, by loops."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.rolling import RollingContact
from geometries.patches import N
from tests.femic.contact.friction_problems import WHEEL, groove, wheel_on

LOAD, CREEPAGES = Loading(3000.0), Creepages(-2e-3, 7e-4, 3e-4)
WHEEL_ON_RAIL = wheel_on(groove(6, 8))
SHAPE = WHEEL_ON_RAIL.problem.distance.shape


def tractions(seed):
    return np.random.default_rng(seed).normal(size=(*SHAPE, 3))


def forces_on_elements(p):
    """(x, y, delta, height, F_x, F_y, F_z) of each element."""
    rolling, problem = WHEEL_ON_RAIL.rolling, WHEEL_ON_RAIL.problem
    for i, j in np.ndindex(*SHAPE):
        p_x, p_s, p_n = p[i, j] * problem.grid.dx * problem.grid.ds
        delta, y = problem.inclination[j], rolling.contour.position(rolling.s[j])[0]
        sin, cos = np.sin(delta), np.cos(delta)
        yield rolling.x[i], y, delta, rolling.height[j], p_x, p_s * cos + p_n * sin, p_n * cos - p_s * sin


def test_weights_give_the_forces_and_the_moment_about_z():
    for seed in range(3):
        p = tractions(seed)
        each = list(forces_on_elements(p))
        assert np.sum(WHEEL_ON_RAIL.weights["longitudinal"] * p) == pytest.approx(sum(f[4] for f in each))
        assert np.sum(WHEEL_ON_RAIL.weights["lateral"] * p) == pytest.approx(sum(f[5] for f in each))
        moment = sum(x * F_y - y * F_x for x, y, _, _, F_x, F_y, _ in each)
        assert np.sum(WHEEL_ON_RAIL.weights["spin"] * p) == pytest.approx(moment)


@pytest.mark.parametrize("creepages", [CREEPAGES, Creepages(0.3, -0.2, 0.05), Creepages()], ids=str)
def test_power_is_that_of_the_torque_about_the_axle_less_that_of_the_forces(creepages):
    """For any tractions."""
    p, drives, gives = tractions(4), 0.0, 0.0
    for x, y, _, height, F_x, F_y, F_z in forces_on_elements(p):
        drives += ((WHEEL - height) * F_x + x * F_z) * (1 + creepages.longitudinal) / WHEEL
        gives += F_x + creepages.lateral * F_y + creepages.spin * (x * F_y - y * F_x)
    power = WHEEL_ON_RAIL.power(RollingContact(SimpleNamespace(p=p), creepages))
    assert power == pytest.approx(drives - gives, rel=1e-9)


def test_pressures_climb_where_lateral_velocity_and_spin_move_along_normals():
    p, climbing = tractions(5), 0.0
    p_n = np.zeros_like(p)
    p_n[..., N] = p[..., N]
    for x, _, delta, _, _, F_y, F_z in forces_on_elements(p_n):
        F_n = F_y * np.sin(delta) + F_z * np.cos(delta)
        climbing -= F_n * (CREEPAGES.lateral + CREEPAGES.spin * x) * np.sin(delta)
    assert WHEEL_ON_RAIL.climbing(RollingContact(SimpleNamespace(p=p), CREEPAGES)) == pytest.approx(climbing)
