"""The circular inverse of nn ICs of half-spaces: it exists for all grids, and inverts on a ring."""

import numpy as np
import pytest
from scipy import fft

from approx.halfspace import HalfSpace
from approx.pair import Pair, Solid
from contact.operators.convolution import merged
from contact.operators.turned import turned
from geometries.contours import plane
from geometries.grids import Grid
from geometries.materials import Material
from geometries.patches import N
from geometries.surfaces import LOWER, UPPER, Surface

STEEL, BRASS = Material(210e3, 0.28), Material(100e3, 0.35)
BODIES = Pair(Solid(BRASS, Surface(UPPER, plane())), Solid(STEEL, Surface(LOWER, plane())))


def flat(n_x, n_s, aspect=1.0):
    return turned("A", BODIES, Grid(n_x, n_s, 0.3 * aspect, 0.3), (N,))


@pytest.mark.parametrize("aspect", [0.05, 0.3, 1.0, 4.0, 20.0])
@pytest.mark.parametrize("sizes", [(1, 1), (1, 8), (2, 2), (5, 3), (16, 16), (17, 40), (64, 9), (101, 100)])
def test_the_spectrum_on_a_ring_is_positive(sizes, aspect):
    ring = flat(*sizes, aspect)._ring
    assert np.min(ring) > 0


@pytest.mark.parametrize("sizes", [(6, 10), (7, 5)])
def test_it_inverts_on_the_ring(sizes):
    """Of displacements that pressures cause on a ring, the pressures are left, and elsewhere nothing."""
    operator = flat(*sizes, 0.7)
    p = np.zeros(operator._padded)
    p[: sizes[0], : sizes[1]] = np.random.default_rng(0).normal(size=sizes)
    u = fft.irfft2(operator._ring * fft.rfft2(p), operator._padded)
    np.testing.assert_allclose(fft.irfft2(fft.rfft2(u) / operator._ring, operator._padded), p, atol=1e-12)
    direct = operator(p[: sizes[0], : sizes[1], None])[..., 0]
    np.testing.assert_allclose(
        u[: sizes[0], : sizes[1]], direct, rtol=1e-12
    )  # lags of the grid are all there


def test_it_is_symmetric_and_positive_on_the_grid_as_a_preconditioner_must_be():
    operator = flat(5, 7, 0.4)
    inverse = np.stack([operator.circular_inverse(unit.reshape(5, 7)).ravel() for unit in np.eye(35)])
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-12 * np.max(inverse))
    assert np.min(np.linalg.eigvalsh((inverse + inverse.T) / 2)) > 0


@pytest.mark.parametrize("aspect", [0.05, 1.0, 20.0])
def test_it_is_near_the_inverse(aspect):
    """Conditions of 2 to 5 for any number of elements, where those of the operator grow with it."""
    conditions = []
    for sizes in ((6, 8), (12, 16)):
        operator, n = flat(*sizes, aspect), sizes[0] * sizes[1]
        units = np.eye(n).reshape(n, *sizes)
        S = np.stack([operator(unit[..., None]).ravel() for unit in units])
        inverse = np.stack([operator.circular_inverse(unit).ravel() for unit in units])
        values = np.linalg.eigvals(inverse @ S).real
        conditions.append(values.max() / values.min())
    assert max(conditions) < 5
    assert conditions[1] < 1.5 * conditions[0]


def test_merged_kernels_are_means_over_pairs_of_sums_over_pairs():
    """Lags -3 ... 3 of 4 elements, unsymmetric; -1 ... 1 of 2 pairs."""
    kernel = np.array([7.0, 5.0, 11.0, 2.0, 3.0, 13.0, 17.0])
    fine = np.array([[kernel[3 + i - j] for j in range(4)] for i in range(4)])
    pairs = fine.reshape(2, 2, 2, 2).sum(axis=3).mean(axis=1)
    expected = [pairs[0, 1], (pairs[0, 0] + pairs[1, 1]) / 2, pairs[1, 0]]
    np.testing.assert_allclose(merged(kernel[:, None], 0)[:, 0], expected)
    np.testing.assert_allclose(merged(kernel[None], 1)[0], expected)


def test_its_kernel_is_that_of_the_half_space():
    """Lags along x and s, dx != ds."""
    operator = flat(4, 3, 2.0)
    ((places, kernel),) = operator.kernels.items()
    assert [direction for direction, _ in places] == [N, N]
    element = Grid(1, 1, 0.6, 0.3).patch(0)
    x, s = 0.6 * np.arange(-3, 4)[:, None], 0.3 * np.arange(-2, 3)
    expected = HalfSpace(BODIES.constants).ics(element, x, s)[N, N]
    np.testing.assert_allclose(kernel, expected, rtol=1e-13)
