"""Forces that friction can supply, against closed forms and by brute force over directions of amplitudes."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import ForcesBeyondFriction, attainable_factor
from tests.femic.contact.friction.laws import with_forces

BOUND = np.random.default_rng(0).uniform(0.0, 2.0, (9, 8)) - 0.4
BOUND[BOUND < 0] = 0.0
X, Y = np.meshgrid(np.linspace(-4.0, 4.0, 9), np.linspace(-3.0, 3.0, 8), indexing="ij")
ONE, ZERO = np.ones_like(X), np.zeros_like(X)
ALONG, ACROSS, TURNING = (np.stack(pair, axis=-1) for pair in ((ONE, ZERO), (ZERO, ONE), (-Y, X)))


def test_one_force_may_be_the_sum_of_all_bounds():
    for way, most in ((ALONG, BOUND.sum()), (TURNING, np.sum(BOUND * np.hypot(X, Y)))):
        assert attainable_factor(np.array([way]), BOUND, np.array([0.25 * most])) == pytest.approx(4.0)
        assert attainable_factor(np.array([way]), BOUND, np.array([-2.0 * most])) == pytest.approx(0.5)


def test_two_forces_may_be_as_large_in_any_direction():
    for angle in (0.0, 0.7, 2.0, -1.1):
        targets = 0.5 * BOUND.sum() * np.array([np.cos(angle), np.sin(angle)])
        assert attainable_factor(np.array([ALONG, ACROSS]), BOUND, targets) == pytest.approx(2.0, rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_three_forces_are_within_what_all_directions_allow(seed):
    """The least of sum g |c W| over c f = 1, c by steps of 0.03 rad: at most that of the grid, not below."""
    weights = np.array([ALONG, ACROSS, TURNING])
    targets = BOUND.sum() * np.random.default_rng(seed).normal(size=3) * [1.0, 1.0, 3.0]
    t, u = np.meshgrid(np.linspace(0, np.pi, 106), np.linspace(0, 2 * np.pi, 210))
    c = np.stack([np.sin(t) * np.cos(u), np.sin(t) * np.sin(u), np.cos(t) / 3], axis=-1).reshape(-1, 3)
    work = np.linalg.norm(np.tensordot(c, weights, 1), axis=-1).reshape(len(c), -1) @ BOUND.ravel()
    power = c @ targets
    least = np.min(work[power > 0] / power[power > 0])
    assert least * (1 - 3e-3) < attainable_factor(weights, BOUND, targets) <= least * (1 + 1e-9)


def test_limit_is_independent_of_units_and_scales_with_forces():
    weights, targets = np.array([ALONG, ACROSS, TURNING]), np.array([20.0, -5.0, 40.0])
    here = attainable_factor(weights, BOUND, targets)
    scales = np.array([1.0, 1.0, 1e-3])
    for unit in (1e6, 1e-9):
        there = attainable_factor(
            weights * scales[:, None, None, None], unit * BOUND, unit * targets * scales
        )
        assert there == pytest.approx(here, rel=1e-6)
    assert attainable_factor(weights, BOUND, 3 * targets) == pytest.approx(here / 3)


def test_limit_is_infinite_without_forces_and_zero_without_bounds():
    assert attainable_factor(np.array([ALONG]), BOUND, np.zeros(1)) == np.inf
    assert attainable_factor(np.array([ALONG]), np.zeros_like(BOUND), np.zeros(1)) == 0
    assert attainable_factor(np.array([ALONG, ACROSS]), np.zeros_like(BOUND), np.array([1.0, 0.0])) == 0


def test_force_that_no_traction_contributes_to_is_not_attainable():
    assert attainable_factor(np.array([ALONG, 0 * ALONG]), BOUND, np.array([1.0, 1.0])) == 0


def test_contradictory_forces_are_not_attainable():
    assert attainable_factor(np.array([ALONG, ALONG]), BOUND, np.array([1.0, -1.0])) < 1e-12


def test_force_that_is_prescribed_twice_may_be_as_large_as_once():
    targets = np.array([0.25, 0.25]) * BOUND.sum()
    assert attainable_factor(np.array([ALONG, ALONG]), BOUND, targets) == pytest.approx(4.0, rel=1e-6)


def test_limit_is_found_from_amplitudes_that_leave_an_element_without_slip():
    """Elements at y = 0, 2, 4 with bounds 13/4, 3/2, 13/4: the first amplitudes turn about the second one.

    The limit is reached with all friction of the first two: F = p0 + p2 + p4 and M = 2 p2 + 4 p4 = -2 F.
    """
    y, g = np.array([0.0, 2.0, 4.0]), np.array([3.25, 1.5, 3.25])[:, None]
    weights = np.zeros((2, 3, 1, 2))
    weights[0, :, 0, 0], weights[1, :, 0, 0] = 1.0, y
    p = np.array([3.25, 1.5, -(3.25 + 2 * 1.5) / 3])
    force, moment = p.sum(), y @ p
    assert moment == pytest.approx(-2 * force)
    assert attainable_factor(weights, g, np.array([8.0, -16.0])) == pytest.approx(force / 8.0, rel=1e-4)


def test_one_element_bears_no_moment_of_its_own():
    """Its force and its moment go together: the moment is x times the lateral force."""
    lone = np.zeros_like(BOUND)
    lone[6, 3] = 2.0
    lateral, lever = 1.0, X[6, 3]
    together = np.array([0.0, lateral, lateral * lever])
    weights = np.array([ALONG, ACROSS, TURNING])
    assert Y[6, 3] != 0
    assert attainable_factor(weights, lone, together) == pytest.approx(2.0, rel=1e-3)
    assert attainable_factor(weights, lone, together * [1, 1, -1]) < 1e-3


def test_forces_beyond_friction_are_refused():
    problem = with_forces([0.0, 0.0])
    most = problem.bound.sum()
    for share in (1.0001, 2.0, -2.0):
        free = replace(problem.free, targets=np.array([share * most, 0.0]))
        with pytest.raises(
            ForcesBeyondFriction, match=r"prescribed forces exceed what friction can supply: .* no more than"
        ):
            coulomb.tractions(replace(problem, free=free))
