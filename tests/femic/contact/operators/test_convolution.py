"""Kernels at all lags, and those of elements twice as large."""

import numpy as np

from approx.halfspace import HalfSpace
from femic.contact.operators.convolution import merged
from geometries.patches import Grid, N
from tests.femic.contact.operators.test_ring import BODIES, flat


def test_merged_kernels_are_means_over_pairs_of_sums_over_pairs():
    """Lags -3 ... 3 of 4 elements, unsymmetric; -1 ... 1 of 2 pairs."""
    kernel = np.array([7.0, 5.0, 11.0, 2.0, 3.0, 13.0, 17.0])
    fine = np.array([[kernel[3 + i - j] for j in range(4)] for i in range(4)])
    pairs = fine.reshape(2, 2, 2, 2).sum(axis=3).mean(axis=1)
    expected = [pairs[0, 1], (pairs[0, 0] + pairs[1, 1]) / 2, pairs[1, 0]]
    np.testing.assert_allclose(merged(kernel[:, None], 0)[:, 0], expected)
    np.testing.assert_allclose(merged(kernel[None], 1)[0], expected)


def test_kernel_is_that_of_the_half_space():
    """Lags along x and s, dx != ds."""
    operator = flat(4, 3, 2.0)
    ((places, kernel),) = operator.kernels.items()
    assert [direction for direction, _ in places] == [N, N]
    element = Grid(1, 1, 0.6, 0.3).patch(0)
    x, s = 0.6 * np.arange(-3, 4)[:, None], 0.3 * np.arange(-2, 3)
    expected = HalfSpace(BODIES.constants).ics(element, x, s)[N, N]
    np.testing.assert_allclose(kernel, expected, rtol=1e-13)
