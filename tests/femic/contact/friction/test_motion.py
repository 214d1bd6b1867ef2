"""Slip of shifts and of rolling against its definition, element by element, and against smooth fields."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.friction.motion import DEPTH, FreeSlip, Motion, RollingStep, Shift, SteadyRolling
from femic.contact.patch import Box, block_mean
from geometries.errors import WrongInput

RANDOM = np.random.default_rng(0)
U, W, BEFORE = RANDOM.normal(size=(3, 8, 6, 2))
DX = 0.3


def test_slip_of_a_shift_is_the_shift_plus_the_growth_of_displacements():
    result = Shift(W, before=BEFORE)
    np.testing.assert_allclose(result.elastic_slip(U) + result.given, W + U - BEFORE)
    np.testing.assert_allclose(Shift(W).elastic_slip(U) + Shift(W).given, W + U)
    np.testing.assert_array_equal(result.at_elements(U), U)
    assert result.depth == 0


def test_a_vertical_approach_shifts_by_its_component_along_s():
    """Down by d, over the tangent (cos, -sin) in (y, z): d sin along s."""
    delta = np.linspace(-0.5, 0.7, 6)
    shift = Shift(W, before=BEFORE, per_approach=np.sin(delta), approach_before=0.02)
    added = shift.given_at(0.05) - shift.given
    for column in range(6):
        along_s = np.array([0.0, -0.03]) @ [np.cos(delta[column]), -np.sin(delta[column])]
        np.testing.assert_allclose(added[:, column], np.tile([0.0, along_s], (8, 1)), atol=1e-15)
    from_none = Shift(W, per_approach=np.sin(delta))
    np.testing.assert_allclose(from_none.given_at(0.03) - W, added, atol=1e-15)
    np.testing.assert_array_equal(Shift(W).given_at(3.0), W)


@pytest.mark.parametrize("order", [1, 2])
def test_steady_rolling_takes_displacements_from_the_next_element_ahead(order):
    motion = SteadyRolling(W, dx=DX, order=order)
    result = motion.elastic_slip(U) + motion.given
    for row, column in np.ndindex(7, 6):
        w = W[row, column] if order == 1 else (W[row, column] + W[row + 1, column]) / 2
        expected = w + (U[row, column] - U[row + 1, column]) / DX
        np.testing.assert_allclose(result[row, column], expected)
    assert motion.depth == (0 if order == 1 else DEPTH)


@pytest.mark.parametrize("order", [1, 2])
def test_step_of_rolling_takes_displacements_of_the_step_before(order):
    motion = RollingStep(W, dx=DX, order=order, before=BEFORE)
    result = motion.elastic_slip(U) + motion.given
    for row, column in np.ndindex(7, 6):
        w = W[row, column] if order == 1 else (W[row, column] + W[row + 1, column]) / 2
        expected = w + (U[row, column] - BEFORE[row + 1, column]) / DX
        np.testing.assert_allclose(result[row, column], expected)
    first = RollingStep(W, dx=DX, order=order)
    np.testing.assert_allclose(
        result - first.given - first.elastic_slip(U), -np.r_[BEFORE[1:], BEFORE[-1:]] / DX
    )


def test_step_with_current_displacements_is_steady_rolling():
    step, steady = RollingStep(W, dx=DX, before=U), SteadyRolling(W, dx=DX)
    np.testing.assert_allclose(step.elastic_slip(U) + step.given, steady.elastic_slip(U) + steady.given)


def smooth(n):
    """Slip of the smooth field u = sin, w = cos at elements and between them, and what motions make of it."""
    dx = 2.0 / n
    x = dx * np.arange(n)[:, None, None] + np.zeros((1, 1, 2))
    exact = lambda at: np.cos(0.4 * at) - 0.7 * np.cos(0.7 * at)  # noqa: E731
    return dx, x, np.sin(0.7 * x), np.cos(0.4 * x), exact


def largest_errors(order):
    """At the places where the slip of an order holds, for two grids; the ends of the grid do not count."""
    errors = []
    for n in (40, 80):
        dx, x, u, w, exact = smooth(n)
        motion = SteadyRolling(w, dx=dx, order=order)
        slip = motion.elastic_slip(u) + motion.given
        between = x if order == 1 else x + dx / 2
        centred = motion.at_elements(slip)
        errors.append([
            np.max(np.abs((slip - exact(between))[:-1])),
            np.max(np.abs((centred - exact(x))[1:-1])),
        ])  # fmt: skip
    return np.array(errors)


@pytest.mark.parametrize("order", [1, 2])
def test_slip_has_the_error_of_its_order(order):
    coarse, fine = largest_errors(order)
    np.testing.assert_allclose(np.log2(coarse / fine), order, atol=0.1)


BOX = Box((2, 7), (1, 4))


@pytest.mark.parametrize(
    "motion",
    [
        Motion(W),
        Shift(W, before=BEFORE, per_approach=W[0, :, 0], approach_before=0.1),
        SteadyRolling(W, (FreeSlip(BEFORE, RANDOM.normal(size=(8, 6, 3)), 2.0),), dx=DX),
        SteadyRolling(W, dx=DX, order=1),
        RollingStep(W, dx=DX, before=BEFORE),
        RollingStep(W, dx=DX),
    ],
    ids=["motion", "shift", "with a free slip", "order 1", "step", "step from nothing"],
)
def test_in_a_box_slip_is_that_of_its_elements(motion):
    """But for its last row, which has no neighbour ahead."""
    part = motion.within(BOX)
    for here, there in (
        (part.elastic_slip(BOX.crop(U)), motion.elastic_slip(U)),
        (part.given_at(0.3), motion.given_at(0.3)),
        *zip(part.free_slips, motion.free_slips, strict=True),
    ):
        np.testing.assert_allclose(here[:-1], BOX.crop(there)[:-1], rtol=1e-12)
    for here, there in zip(part.free, motion.free, strict=True):
        np.testing.assert_array_equal(here.weights, BOX.crop(there.weights))
        assert here.force == there.force
    assert (type(part), part.depth) == (type(motion), motion.depth)


def test_free_slips_are_taken_where_rigid_ones_are():
    free = FreeSlip(W, RANDOM.normal(size=(8, 6, 3)), 3.0)
    for motion in (SteadyRolling(0 * W, (free,), dx=DX), SteadyRolling(0 * W, (free,), dx=DX, order=1)):
        np.testing.assert_array_equal(motion.free_slips[0], SteadyRolling(W, dx=DX, order=motion.order).given)
    for motion in (Motion(W), SteadyRolling(W, dx=DX, order=1)):
        for number in range(3):
            several = replace(motion, free=(free,) * number).free_slips
            np.testing.assert_array_equal(several, np.broadcast_to(W, (number, *W.shape)), strict=True)


@pytest.mark.parametrize("motion", [Motion(W), SteadyRolling(W, dx=DX, order=1), SteadyRolling(W, dx=DX)])
def test_derivative_of_the_slip_at_elements_agrees_with_differences(motion):
    change = 1e-6 * BEFORE
    difference = motion.at_elements(U + change) - motion.at_elements(U - change)
    np.testing.assert_allclose(motion.derivative_at_elements(U)(change), difference / 2, atol=1e-12)


def test_simpler_forms_of_rolling_have_one_follower_less_each():
    motion, depths = SteadyRolling(W, dx=DX, followers=3), []
    while motion is not None and len(depths) < 9:
        depths.append(motion.depth)
        motion = motion.simpler
    assert depths == [3, 2, 1, 0]
    for simplest in (SteadyRolling(W, dx=DX, order=1), Shift(W)):
        assert simplest.simpler is None


def fine(coarse):
    return coarse.repeat(2, axis=0).repeat(2, axis=1)


def test_on_coarser_elements_fields_are_means_and_forces_stay():
    coarse = RANDOM.normal(size=(4, 3, 2))
    np.testing.assert_allclose(block_mean(fine(coarse)), coarse)
    np.testing.assert_allclose(block_mean(W)[1, 2], W[2:4, 4:6].mean(axis=(0, 1)))
    weights, p = RANDOM.normal(size=(8, 6, 3)), RANDOM.normal(size=(4, 3, 3))
    rolling = SteadyRolling(W, (FreeSlip(W, weights, 3.0),), dx=DX, order=1).coarsened()
    assert np.sum(rolling.free[0].weights * p) == pytest.approx(np.sum(weights * fine(p)))
    assert rolling.free[0].force == 3.0
    assert (rolling.dx, rolling.order) == (2 * DX, 1)
    np.testing.assert_array_equal(rolling.rigid, block_mean(W))
    np.testing.assert_array_equal(rolling.free_slips[0], block_mean(W))
    sines = RANDOM.normal(size=6)
    shift = Shift(W, before=BEFORE, per_approach=sines, approach_before=0.1).coarsened()
    np.testing.assert_allclose(
        shift.given_at(0.4)[1, 2], block_mean(W - BEFORE)[1, 2] + [0, 0.15 * sum(sines[4:])]
    )
    assert Shift(W).coarsened().before is None
    assert [motion.has_coarser for motion in (Shift, SteadyRolling, RollingStep)] == [True, True, False]


@pytest.mark.parametrize("order", [0, 3, 1.5])
def test_other_orders_are_refused(order):
    with pytest.raises(WrongInput, match=f"order = {order}: 1 or 2"):
        SteadyRolling(W, dx=DX, order=order)
