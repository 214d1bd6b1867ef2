"""The inverse of ICs of half-spaces on a ring: for all grids, and near the inverse on the plane."""

import numpy as np
import pytest
from scipy import fft

from approx.pair import Pair, Solid
from femic.contact.operators.approximations import half_space_operator
from geometries.contours import plane
from geometries.materials import Material
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface

STEEL, BRASS = Material(210e3, 0.28), Material(100e3, 0.35)
BODIES = Pair(Solid(BRASS, Surface(UPPER, plane())), Solid(STEEL, Surface(LOWER, plane())))


def flat(n_x, n_s, aspect=1.0):
    return half_space_operator(BODIES, Grid(n_x, n_s, 0.3 * aspect, 0.3), (N,))


@pytest.mark.parametrize("aspect", [0.05, 0.3, 1.0, 4.0, 20.0])
@pytest.mark.parametrize("sizes", [(1, 1), (1, 8), (2, 2), (5, 3), (16, 16), (17, 40), (64, 9), (101, 100)])
def test_inverse_is_positive_at_all_frequencies(sizes, aspect):
    inverse = flat(*sizes, aspect).ring_inverse.factors[..., 0, 0]
    assert np.min(inverse.real) > 0
    assert np.max(np.abs(inverse.imag)) < 1e-6 * np.max(inverse.real)


@pytest.mark.parametrize("directions", [(N,), (X, S), (X, S, N)])
@pytest.mark.parametrize("sizes", [(6, 10), (7, 5)])
def test_inverse_undoes_the_operator_on_its_grid(sizes, directions):
    """On the ring displacements of tractions on the grid are the operator's there, and lead back to them."""
    operator = half_space_operator(BODIES, Grid(*sizes, 0.21, 0.3), directions)
    ring, m = operator.ring_inverse, len(directions)
    p = np.zeros((*ring.padded, m))
    p[: sizes[0], : sizes[1]] = np.random.default_rng(0).normal(size=(*sizes, m))
    spectrum = np.einsum("xsij,xsj->xsi", np.linalg.inv(ring.factors), fft.rfft2(p, axes=(0, 1)))
    u = fft.irfft2(spectrum, ring.padded, axes=(0, 1))
    np.testing.assert_allclose(
        u[: sizes[0], : sizes[1]], operator(p[: sizes[0], : sizes[1]]), atol=1e-12 * np.max(u)
    )
    back = np.einsum("xsij,xsj->xsi", ring.factors, fft.rfft2(u, axes=(0, 1)))
    np.testing.assert_allclose(fft.irfft2(back, ring.padded, axes=(0, 1)), p, atol=1e-10)


@pytest.mark.parametrize("directions", [(N,), (X, S)])
def test_displacements_become_those_of_strips_alone(directions):
    """On the ring: those of all strips lead to those of each strip's own tractions, found by a loop."""
    operator = half_space_operator(BODIES, Grid(6, 5, 0.21, 0.3), directions)
    alone, m = operator.strips_alone, len(directions)
    n_x, n_s = alone.padded
    p = np.random.default_rng(0).normal(size=(n_x, n_s, m))
    inverse = operator.ring_inverse
    u = fft.irfft2(
        np.einsum("xsij,xsj->xsi", np.linalg.inv(inverse.factors), fft.rfft2(p, axes=(0, 1))),
        alone.padded,
        axes=(0, 1),
    )
    result = fft.irfft2(
        np.einsum("xsij,xsj->xsi", alone.factors, fft.rfft2(u, axes=(0, 1))), alone.padded, axes=(0, 1)
    )
    kernel, expected = operator.own_strip, np.zeros_like(p)
    for observer, load in np.ndindex(n_x, n_x):
        lag = (observer - load + n_x // 2) % n_x - n_x // 2  # the shortest way round
        expected[observer] += p[load] @ kernel[5 + np.clip(lag, -5, 5)].T
    np.testing.assert_allclose(result, expected, atol=1e-9 * np.max(np.abs(expected)))


def test_inverse_is_symmetric_and_positive_on_the_grid():
    operator = flat(5, 7, 0.4)
    inverse = np.stack([operator.ring_inverse(unit.reshape(5, 7, 1)).ravel() for unit in np.eye(35)])
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-12 * np.max(inverse))
    assert np.min(np.linalg.eigvalsh((inverse + inverse.T) / 2)) > 0


@pytest.mark.parametrize("aspect", [0.05, 1.0, 20.0])
def test_ring_inverse_is_near_the_exact_inverse(aspect):
    """Conditions of 2 to 5 for any number of elements, where those of the operator grow with it."""
    conditions = []
    for sizes in ((6, 8), (12, 16)):
        operator, n = flat(*sizes, aspect), sizes[0] * sizes[1]
        units = np.eye(n).reshape(n, *sizes)
        S = np.stack([operator(unit[..., None]).ravel() for unit in units])
        inverse = np.stack([operator.ring_inverse(unit[..., None]).ravel() for unit in units])
        values = np.linalg.eigvals(inverse @ S).real
        conditions.append(values.max() / values.min())
    assert max(conditions) < 5
    assert conditions[1] < 1.5 * conditions[0]
