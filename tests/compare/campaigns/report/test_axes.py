"""Swept axes as pages name and draw them."""

import numpy as np
import xarray as xr

from compare.campaigns.report.fields import ShownAxis, prepare
from tests.compare.campaigns.report.datasets import FLANKS


def test_values_are_sorted(grid):
    mixed = prepare(grid.isel(flank=[3, 0, 6, 1, 2, 5, 4], ratio=[2, 0, 1]))
    xr.testing.assert_identical(mixed, grid)


def test_values_spread_over_powers_have_a_logarithmic_axis():
    assert ShownAxis("E", "E", np.geomspace(1e3, 1e6, 7)).is_logarithmic
    assert not ShownAxis("E", "E", np.linspace(1e3, 1e6, 7)).is_logarithmic
    assert not ShownAxis("flank", "flank", FLANKS).is_logarithmic
    assert ShownAxis("P", "P", np.geomspace(1e4, 1e5, 4), "logarithmic").is_logarithmic


def test_lists_are_shown_without_quotes():
    assert ShownAxis("ics", "ics", np.array(["['A', 'C']", "['C']"])).categories == ["[A, C]", "C"]


def test_axes_have_short_labels_and_say_what_their_names_mean():
    flank = ShownAxis("flank", "inclination of the flanks [deg]", FLANKS, unit="deg")
    assert (flank.label, flank.meaning) == ("flank [deg]", "flank: inclination of the flanks [deg]")
    plain = ShownAxis("E", "E [MPa]", FLANKS, unit="MPa")
    assert (plain.label, plain.meaning) == ("E [MPa]", "E [MPa]")
