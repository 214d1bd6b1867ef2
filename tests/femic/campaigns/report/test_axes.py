"""Swept axes as pages name and draw them."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from femic.campaigns.report.axes import ShownAxis, prepared
from tests.femic.campaigns.report.datasets import FLANKS


def test_values_are_sorted(grid):
    mixed = prepared(grid.isel(flank=[3, 0, 6, 1, 2, 5, 4], ratio=[2, 0, 1]))
    xr.testing.assert_identical(mixed, grid)


def test_values_spread_over_powers_have_a_logarithmic_axis():
    assert ShownAxis("E", "E", np.geomspace(1e3, 1e6, 7)).is_logarithmic
    assert not ShownAxis("E", "E", np.linspace(1e3, 1e6, 7)).is_logarithmic
    assert not ShownAxis("flank", "flank", FLANKS).is_logarithmic
    assert ShownAxis("P", "P", np.geomspace(1e4, 1e5, 4), "logarithmic").is_logarithmic
    np.testing.assert_allclose(ShownAxis("E", "E", np.array([1.0, 100, 10000])).edges, [0.1, 10, 1000, 1e5])


def test_lists_are_shown_without_quotes():
    assert ShownAxis("ics", "ics", np.array(["['A', 'C']", "['C']"])).categories == ["[A, C]", "C"]


def ticks(axis):
    panel = Figure().subplots()
    axis.scale(panel, "x")
    return list(panel.xaxis.get_major_locator()())


def test_overlapping_ticks_are_left_out():
    assert ticks(ShownAxis("n", "n", np.array([0.0, 1, 2, 3, 4]))) == [0, 1, 2, 3, 4]
    assert ticks(ShownAxis("n", "n", np.linspace(0, 0.0008, 9))) == pytest.approx(
        [0, 0.0002, 0.0004, 0.0006, 0.0008]
    )
    assert ticks(ShownAxis("n", "n", np.array([1e4, 1.1e4, 5e4]))) == [1e4, 5e4]
