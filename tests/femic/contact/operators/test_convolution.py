"""Kernels of half-spaces at all lags, merged ones, and their inverse on a ring, for all grids."""

import numpy as np
import pytest
from scipy import fft

from approx.halfspace import HalfSpace
from femic.contact.operators.approximations import half_space_operator
from femic.contact.operators.convolution import merged
from geometries.patches import Grid, N, S, X
from tests.femic.contact.problems import BRASS, STEEL, dense, level

BODIES = level((BRASS, STEEL))


def flat(n_x, n_s, aspect=1.0):
    return half_space_operator(BODIES, Grid(n_x, n_s, 0.3 * aspect, 0.3), (N,))


@pytest.mark.parametrize("aspect", [0.05, 0.3, 1.0, 4.0, 20.0])
@pytest.mark.parametrize("sizes", [(1, 1), (1, 8), (2, 2), (5, 3), (16, 16), (17, 40), (64, 9), (101, 100)])
def test_inverse_is_positive_at_all_frequencies(sizes, aspect):
    inverse = flat(*sizes, aspect).ring_inverse.factors[..., 0, 0]
    assert np.min(inverse.real) > 0
    assert np.max(np.abs(inverse.imag)) < 1e-6 * np.max(inverse.real)


def multiplied(factors, p):
    """Tractions or displacements on a ring, times factors of their waves."""
    waves = np.einsum("xsij,xsj->xsi", factors, fft.rfft2(p, axes=(0, 1)))
    return fft.irfft2(waves, p.shape[:2], axes=(0, 1))


@pytest.mark.parametrize("directions", [(N,), (X, S), (X, S, N)])
@pytest.mark.parametrize("sizes", [(6, 10), (7, 5)])
def test_inverse_undoes_the_operator_on_its_grid(sizes, directions):
    """On the ring displacements of tractions on the grid are the operator's there, and lead back to them."""
    operator = half_space_operator(BODIES, Grid(*sizes, 0.21, 0.3), directions)
    ring, on_grid = operator.ring_inverse, np.s_[: sizes[0], : sizes[1]]
    p = np.zeros((*ring.padded, len(directions)))
    p[on_grid] = np.random.default_rng(0).normal(size=(*sizes, len(directions)))
    u = multiplied(np.linalg.inv(ring.factors), p)
    np.testing.assert_allclose(u[on_grid], operator(p[on_grid]), atol=1e-12 * np.max(u))
    np.testing.assert_allclose(multiplied(ring.factors, u), p, atol=1e-10)


@pytest.mark.parametrize("directions", [(N,), (X, S)])
def test_displacements_become_those_of_strips_alone(directions):
    """On the ring: those of all strips lead to those of each strip's own tractions, found by a loop."""
    operator = half_space_operator(BODIES, Grid(6, 5, 0.21, 0.3), directions)
    alone, inverse = operator.strips_alone, operator.ring_inverse
    n_x, n_s = alone.padded
    p = np.random.default_rng(0).normal(size=(n_x, n_s, len(directions)))
    result = multiplied(alone.factors, multiplied(np.linalg.inv(inverse.factors), p))
    kernel, expected = operator.own_strip, np.zeros_like(p)
    for observer, load in np.ndindex(n_x, n_x):
        lag = (observer - load + n_x // 2) % n_x - n_x // 2  # the shortest way round
        expected[observer] += p[load] @ kernel[5 + np.clip(lag, -5, 5)].T
    np.testing.assert_allclose(result, expected, atol=1e-9 * np.max(np.abs(expected)))


@pytest.mark.parametrize("aspect", [0.05, 0.4, 1.0, 20.0])
def test_inverse_is_symmetric_positive_and_near_the_exact_one(aspect):
    """Conditions of 2 to 5 for any number of elements, where those of the operator grow with it."""
    conditions = []
    for sizes in ((6, 8), (12, 16)):
        operator = flat(*sizes, aspect)
        S, inverse = (dense(linear, (*sizes, 1)) for linear in (operator, operator.ring_inverse))
        np.testing.assert_allclose(inverse, inverse.T, atol=1e-12 * np.max(inverse))
        assert np.min(np.linalg.eigvalsh((inverse + inverse.T) / 2)) > 0
        values = np.linalg.eigvals(inverse @ S).real
        conditions.append(values.max() / values.min())
    assert max(conditions) < 5
    assert conditions[1] < 1.5 * conditions[0]


# ---- kernels


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
