"""Measures of stress: closed forms of simple states, invariance, what lies between points."""

import numpy as np
import pytest

from femic.stresses.field import mean_stress, principal_values, rise_between, tresca, von_mises
from femic.stresses.half_space import half_space_field
from tests.femic.stresses.samples import flat, grid_of, section_points, unsymmetric


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


TENSION = np.diag([7.0, 0.0, 0.0])
SHEAR = np.array([[0.0, 3.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
PRESSURE = -5.0 * np.eye(3)


@pytest.mark.parametrize("seed", range(3))
def test_tension_shear_and_pressure_in_any_axes(seed):
    turned = rotation(seed) @ np.stack([TENSION, SHEAR, PRESSURE]) @ rotation(seed).T
    for stress in (turned, turned + 4 * PRESSURE):  # which changes neither of them
        np.testing.assert_allclose(von_mises(stress), [7, 3 * np.sqrt(3), 0], atol=1e-13)
        np.testing.assert_allclose(tresca(stress), [7, 6, 0], atol=1e-13)
    np.testing.assert_allclose(tresca(turned) / 2, [3.5, 3, 0], atol=1e-13)
    np.testing.assert_allclose(mean_stress(turned), [7 / 3, 0, -5], atol=1e-13)
    np.testing.assert_allclose(principal_values(turned), [[0, 0, 7], [-3, 0, 3], [-5, -5, -5]], atol=1e-13)


def test_between_points_a_paraboloid_rises_to_its_top():
    axes = np.array([-1.0, 0.0, 0.4, 2.0]), np.array([0.0, 0.7, 1.5]), np.linspace(-1, 1, 6)
    x, y, z = np.meshgrid(*axes, indexing="ij")
    values = 9.0 - 2 * (x - 0.1) ** 2 - 3 * (y - 0.8) ** 2 - (z + 0.1) ** 2
    assert np.max(values) + rise_between(values, axes) == pytest.approx(9.0, rel=1e-12)


def test_at_the_end_of_an_axis_nothing_rises():
    axes = np.linspace(0, 1, 5), np.linspace(-1, 1, 4)
    x, y = np.meshgrid(*axes, indexing="ij")
    for values in (4 - x - y, 4 + x - y, 4 - x + y, 4 + x + y):
        assert rise_between(values, axes) == 0.0
    assert rise_between(4 - x - (y - 0.3) ** 2, axes) == pytest.approx((1 / 3 - 0.3) ** 2, rel=1e-9)
    assert rise_between(np.zeros((5, 4)), axes) == 0.0


def test_a_field_of_closed_form_has_an_estimated_error_of_0():
    tractions = unsymmetric(grid_of(4, 3, 1.0, 1.0), 1.0, 1.0)
    field = half_space_field(flat(-1), tractions, section_points([0.0, 0.5], [0.0, 1.0, 2.0]))
    np.testing.assert_array_equal(np.broadcast_to(field.estimate, field.points.shape), np.zeros((2, 3)))
