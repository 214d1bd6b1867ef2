"""ICs for rolling: a wheel that is moved as a rigid body does not slip by that, but by its wheel's turn."""

import numpy as np
import pytest

from femic.contact.operators.approximations import rolled
from geometries.contours import arc
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface

WHEEL = Surface(UPPER, arc(10.2, 1.2, 1.2), 300.0)
LENGTH = 12.0  # mm along x


def moved(n_x, motion):
    """ICs of a wheel whose points move by motion(points (3, n)) for any load, in local directions."""
    grid = Grid(n_x, 5, LENGTH / n_x, 2.0, 1.0)
    ics = np.zeros((n_x, 5, 5, 3, 3))
    for strip, s in enumerate(grid.strips):
        xi = grid.lags * WHEEL.rolling_radius / WHEEL.circle_radius(s)
        along = motion(WHEEL.position(xi, np.full(n_x, s)))
        local = np.einsum("ikn,kn->ni", WHEEL.axes(xi, np.full(n_x, s)), along)
        ics[:, strip] = local[:, None, :, None]
    return ics, grid


def raised(points):
    return np.stack([np.zeros(points.shape[1]), np.zeros(points.shape[1]), np.ones(points.shape[1])])


def spun(points):
    x, _, z = points
    return np.stack([z - WHEEL.rolling_radius, np.zeros_like(x), -x]) / WHEEL.rolling_radius


def slip_along_x(ics, grid):
    """-du/dx, between elements."""
    return -np.diff(ics[..., X, 0], axis=0) / grid.dx


def test_a_wheel_raised_as_a_rigid_body_slips_by_less_than_the_square_of_an_element():
    errors = []
    for n_x in (12, 24, 48):
        ics, grid = moved(n_x, raised)
        slip = slip_along_x(rolled(ics, WHEEL, grid), grid)
        assert np.max(np.abs(slip_along_x(ics, grid))) > 0.9 / 310  # that of the ICs as they are: 1 / R
        errors.append(np.max(np.abs(slip)))
    assert errors[0] < 1e-4 / 300
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2, 2], abs=0.05)


def test_a_wheel_spun_about_its_axle_does_not_slip_by_its_displacements():
    ics, grid = moved(24, spun)
    assert np.min(np.abs(ics[..., X, 0])) > 0.9
    assert np.max(np.abs(slip_along_x(rolled(ics, WHEEL, grid), grid))) < 1e-12


def test_other_directions_and_prismatic_bodies_stay():
    ics, grid = moved(12, raised)
    ics += np.random.default_rng(0).normal(size=ics.shape)
    unchanged = ics.copy()
    result = rolled(ics, WHEEL, grid)
    np.testing.assert_array_equal(ics, unchanged)
    np.testing.assert_array_equal(result[..., (S, N), :], ics[..., (S, N), :])
    np.testing.assert_array_equal(result[0], ics[0])
    assert np.max(np.abs(result - ics)) > 0.01
    for surface in (Surface(UPPER, arc(10.2, 1.2, 1.2)), Surface(LOWER, arc(10.0, 1.2, 1.2))):
        np.testing.assert_array_equal(rolled(ics, surface, grid), ics)


def test_slip_by_height_is_over_the_radius_of_its_own_circle():
    """Of a height that grows in proportion to x, at the observer's place: x^2 / 2 over R."""
    grid = Grid(30, 4, 0.4, 1.5, 2.0)
    delta = WHEEL.contour.inclination(grid.strips)
    ics = np.zeros((30, 4, 4, 3, 3))
    x = grid.lags[:, None, None, None]
    ics[..., N, :] = x * np.cos(delta)[:, None, None]
    ics[..., S, :] = -x * np.sin(delta)[:, None, None]
    lost = -rolled(ics, WHEEL, grid)[..., X, :]
    radius = 300.0 - WHEEL.contour.position(grid.strips)[1]
    np.testing.assert_allclose(
        lost, np.broadcast_to(x**2 / 2 / radius[:, None, None], lost.shape), rtol=1e-12
    )
