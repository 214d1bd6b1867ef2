"""Polylines with fewer points stay within their tolerance."""

import numpy as np
import pytest

from compare.report.thinning import thin, thin_together


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


def test_curves_over_the_same_points_keep_those_that_any_of_them_needs():
    """A line needs two points, a corner three; between them all curves stay within the tolerance."""
    x = np.linspace(0.0, 1.0, 101)
    line, corner, unknown = 2 * x, np.abs(x - 0.3), np.full(101, np.nan)
    assert thin_together(x, np.array([line]), 1e-9) == [0, 100]
    assert thin_together(x, np.array([line, corner, unknown]), 1e-9) == [0, 30, 100]
    waves = np.array([np.sin(9 * x), x**3])
    kept = thin_together(x, waves, 0.01)
    # chords of length h miss the wave by 81 h^2 / 8; spans are cut in halves at best
    assert len(kept) < 2 * 32
    for wave in waves:
        np.testing.assert_allclose(np.interp(x, x[kept], wave[kept]), wave, atol=0.01 + 1e-12)
