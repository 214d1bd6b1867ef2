"""The staircase of uniform elements: below centres its stresses are those of steady tractions."""

import numpy as np
import pytest

from femic.stresses.half_space import half_space_field
from femic.stresses.points import InnerPoints
from tests.femic.stresses.samples import SIDES, flat, grid_of, tractions_of

COUNTS = np.array([12, 36, 108])  # along x, and 10 / 12 of them along s: all have the same middles


def smooth(x, s):
    """Tractions that vary in both directions and fall smoothly to 0 at |x| = 2, |s| = 3."""
    p = np.maximum(1 - (x / 2) ** 2, 0) ** 3 * np.maximum(1 - (s / 3) ** 2, 0) ** 3
    return p * (1 + x - 0.4 * s), p * (0.5 - x + 0.7 * s), p * (1 + 0.6 * x - 0.3 * s)


def below_a_middle(side, n_x, depth, function=smooth):
    grid = grid_of(n_x, 10 * n_x // 12, 2.0, 3.0)
    points = InnerPoints(np.array([-0.5]), np.array([0.9]), np.array([depth]))
    return half_space_field(flat(side), tractions_of(grid, function), points).stress[0]


@pytest.mark.parametrize("side", SIDES)
def test_stresses_of_the_surface_are_of_second_order(side):
    """Without the staircase they are of first order; the truth is that of elements three times as fine."""
    truth = below_a_middle(side, 324, 0.0)
    errors = [np.max(np.abs(below_a_middle(side, n, 0.0) - truth)) for n in COUNTS]
    rates = -np.diff(np.log(errors)) / np.log(3)
    assert np.all(rates > 1.8), rates
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("depth", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("side", SIDES)
def test_steady_tractions_have_the_stresses_of_finer_elements_at_any_depth(side, depth):
    """No curvature: only the jumps at the ends of the grid differ, like h^2; without the staircase 0.28."""

    def steady(x, s):
        shape = 1 + 0 * (x + s)
        return shape * (x - s), shape * (0.3 * x + s), shape * (2 + 0.5 * x - s)

    coarse, fine = (below_a_middle(side, n, depth, steady) for n in (12, 36))
    np.testing.assert_allclose(coarse, fine, atol=0.015)
