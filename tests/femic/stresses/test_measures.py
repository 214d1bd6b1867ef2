"""Measures of stress: closed forms of simple states, invariance, the largest value."""

import numpy as np
import pytest

from femic.stresses.measures import largest, largest_shear, mean_stress, principal_values, tresca, von_mises
from femic.stresses.points import section_points
from geometries.errors import WrongInput


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


TENSION = np.diag([7.0, 0.0, 0.0])
SHEAR = np.array([[0.0, 3.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
PRESSURE = -5.0 * np.eye(3)


@pytest.mark.parametrize("seed", range(3))
def test_tension_shear_and_pressure_in_any_axes(seed):
    turned = rotation(seed) @ np.stack([TENSION, SHEAR, PRESSURE]) @ rotation(seed).T
    np.testing.assert_allclose(von_mises(turned), [7, 3 * np.sqrt(3), 0], atol=1e-13)
    np.testing.assert_allclose(tresca(turned), [7, 6, 0], atol=1e-13)
    np.testing.assert_allclose(largest_shear(turned), [3.5, 3, 0], atol=1e-13)
    np.testing.assert_allclose(mean_stress(turned), [7 / 3, 0, -5], atol=1e-13)
    np.testing.assert_allclose(principal_values(turned), [[0, 0, 7], [-3, 0, 3], [-5, -5, -5]], atol=1e-13)


def test_pressure_does_not_change_von_mises_and_tresca():
    stress = TENSION + 2 * SHEAR
    for measure in (von_mises, tresca):
        assert measure(stress + 40 * PRESSURE) == pytest.approx(float(measure(stress)), rel=1e-12)


def test_the_largest_value_has_its_place():
    points = section_points([-1.0, 0.5, 2.0], [0.0, 0.3], x=0.7)
    values = np.zeros(points.shape)
    values[1, 1], values[2, 0] = 4.0, 3.0
    assert largest(values, points) == type(largest(values, points))(4.0, 0.7, 0.5, 0.3)
    with pytest.raises(WrongInput, match="shape"):
        largest(values[:2], points)
