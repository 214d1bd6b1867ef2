"""Slip at the centres of elements: the mean where smooth, nothing only where there is none, continuous."""

import numpy as np
import pytest

from femic.contact.friction.motion import centred, centred_derivative


def pairs(n=400, seed=0):
    """Slips of two elements in rows, the second of which is looked at, over 12 decades of ratios."""
    random = np.random.default_rng(seed)
    slip = random.normal(size=(2, n, 2))
    slip[0] *= 10.0 ** random.uniform(-6, 6, (n, 1))
    return slip


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_centred_slip_is_the_mean_up_to_second_order(turn):
    """Of slips whose sizes and directions change along x."""
    errors = []
    for n in (40, 80):
        x = np.arange(n)[:, None] / n
        slip = np.stack([(1 + x) * np.cos(turn * x), (1 + x) * np.sin(turn * x)], axis=-1)
        mean = (slip[1:] + slip[:-1]) / 2
        errors.append(np.max(np.abs(centred(slip)[1:] - mean)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(3, abs=0.2)  # and a difference of both slips


def test_centred_slip_vanishes_only_with_the_slip_ahead():
    slip = pairs()
    result = np.linalg.norm(centred(slip)[1], axis=-1)
    assert np.all(result > 0.49 * np.linalg.norm(slip[1], axis=-1))
    slip[1] = 0
    np.testing.assert_array_equal(centred(slip)[1], 0)
    slip[0] = 0
    np.testing.assert_array_equal(centred(slip), 0)


def test_centred_slip_is_the_slip_ahead_where_the_one_behind_vanishes_or_opposes():
    slip = pairs()
    stuck, opposed = slip.copy(), slip.copy()
    stuck[0] *= 1e-12 / np.linalg.norm(slip[0], axis=-1, keepdims=True)
    opposed[0] *= -np.sign(np.sum(slip[0] * slip[1], axis=-1, keepdims=True))
    np.testing.assert_allclose(centred(stuck)[1], slip[1], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(centred(opposed)[1], slip[1])


def test_centred_slip_grows_with_the_slips():
    slip = pairs()
    np.testing.assert_allclose(centred(3.0 * slip), 3.0 * centred(slip), rtol=1e-12)


def test_derivative_agrees_with_differences():
    slip, change = pairs(seed=1), np.random.default_rng(2).normal(size=(2, 400, 2))
    change *= 1e-6 * np.linalg.norm(slip, axis=-1, keepdims=True)
    difference = (centred(slip + change) - centred(slip - change)) / 2
    np.testing.assert_allclose(
        centred_derivative(slip)(change), difference, rtol=1e-5, atol=1e-9 * np.max(np.abs(difference[1]))
    )
