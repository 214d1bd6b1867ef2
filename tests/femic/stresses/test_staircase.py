"""The staircase of uniform elements: below centres its stresses are those of steady tractions."""

import numpy as np
import pytest

from femic.stresses.half_space import half_space_field
from femic.stresses.points import InnerPoints
from tests.femic.stresses.samples import SIDES, flat, grid_of, tractions_of

COUNTS = np.array([12, 24, 48])


def smooth(x, s):
    """Tractions that vary in both directions and fall smoothly to 0 at |x| = 2, |s| = 3."""
    p = np.maximum(1 - (x / 2) ** 2, 0) ** 3 * np.maximum(1 - (s / 3) ** 2, 0) ** 3
    return p * (1 + x - 0.4 * s), p * (0.5 - x + 0.7 * s), p * (1 + 0.6 * x - 0.3 * s)


def stress_at(side, n, depth, refined=1):
    """Stresses of n x 5/6 n elements near the places of the coarsest centres."""
    grid = grid_of(n * refined, 10 * n * refined // 12, 2.0, 3.0)
    points = InnerPoints(np.array([-0.5, 0.17, 1.1]), np.array([0.3, -1.2, 1.9]), depth + np.zeros(3))
    return half_space_field(flat(side), tractions_of(grid, smooth), points).stress


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("depth", [0.0, 0.02])
def test_stresses_near_the_surface_are_of_second_order(side, depth):
    """Without the staircase they are of first order; the truth is that of elements six times as fine."""
    truth = stress_at(side, 48, depth, refined=6)
    errors = [np.max(np.abs(stress_at(side, n, depth) - truth)) for n in COUNTS]
    assert -np.polyfit(np.log(COUNTS), np.log(errors), 1)[0] > 1.7
    assert errors[-1] < 2e-3
