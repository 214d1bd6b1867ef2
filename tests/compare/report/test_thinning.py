"""Polylines with fewer points stay within their tolerance."""

import numpy as np
import pytest

from compare.report.thinning import thin


def test_a_circle_has_the_chords_of_the_tolerance():
    """The sagitta of a chord over the angle t is r (1 - cos(t / 2)); points between are halved again."""
    angle = np.linspace(0, 2 * np.pi, 4001)
    x, y = thin(10 * np.cos(angle), 10 * np.sin(angle), 0.04)
    chords = np.hypot(np.diff(x), np.diff(y))
    sagitta = 10 - np.sqrt(100 - chords**2 / 4)
    assert np.max(sagitta) <= 0.04 + 1e-9
    assert len(x) < 120


def test_straight_lines_have_their_ends_and_parts_stay_apart():
    s = np.linspace(0, 1, 50)
    gap = [np.nan, np.nan]
    x, y = thin([*s, *gap, *(s + 2), np.nan], [*(2 * s), *gap, *s, np.nan], 1e-9)
    np.testing.assert_allclose(x, [0, 1, np.nan, 2, 3])
    np.testing.assert_allclose(y, [0, 2, np.nan, 0, 1])


@pytest.mark.parametrize("count", [0, 1])
def test_few_points_stay(count):
    x, y = thin([3.0] * count, [4.0] * count, 1.0)
    assert (x.tolist(), y.tolist()) == ([3.0] * count, [4.0] * count)
