"""Where errors exceed levels: crossings of known functions, gaps, categories."""

import csv
from itertools import product

import numpy as np
import pytest
import xarray as xr

from compare.campaigns.report import tables
from compare.campaigns.report.fields import LEVELS, ShownAxis, find_fields, read_axes
from compare.campaigns.report.page import CROSSINGS, write_sweep
from compare.report.tables import Cell
from tests.compare.campaigns.report.datasets import RATIOS, SHARES, crossing


def test_ranges_in_which_a_level_is_exceeded_are_interpolated_linearly():
    at = np.array([0.0, 1.0, 3.0, 4.0])

    def ends(values, level):
        return tables.ranges_above(at, np.array(values), level)

    assert ends([0.0, 1.0, 3.0, 4.0], 2.0) == [(2.0, None)]
    assert ends([4.0, 3.0, 1.0, 0.0], 2.0) == [(None, 2.0)]
    assert ends([3.0, 1.0, 1.0, 4.0], 2.0) == [(None, 0.5), (pytest.approx(3 + 1 / 3), None)]
    assert ends([1.0, 3.0, np.nan, 0.0], 2.0) == [(0.5, 2.0)]
    assert ends([3.0, 3.0, 3.0, 3.0], 2.0) == [(None, None)]
    assert ends([2.0, 2.0, 2.0, 2.0], 2.0) == []


def test_repeated_crossings_and_gaps_are_reported_and_small_values_rounded_to_the_span():
    axis = ShownAxis("flank", "flank", np.array([0.0, 1.0, 2.0, 3.0, 4.0]))
    again = np.array([0.0, 2.0, 0.0, 2.0, 0.0])
    assert tables.crossing_texts(axis, again, 1.0) == ["from 0.5 to 1.5", "from 2.5 to 3.5"]
    assert tables.exceeding_share(axis, again, 1.0) == 0.5
    assert tables.crossing_cell(xr.DataArray(again, dims="flank"), [axis], 1.0) == Cell(
        "from 0.5 to 1.5", below="again from 2.5 to 3.5"
    )
    sizes = xr.DataArray([0.0, 0.5, np.nan, 0.5, np.nan], dims="flank")
    assert tables.crossing_cell(sizes, [axis], 1.0) == Cell(tables.NOWHERE)
    assert tables.crossing_cell(sizes * np.nan, [axis], 1.0) == Cell("–")
    fine = ShownAxis("spin", "spin", np.array([0.0, 0.002]))
    assert tables.crossing_texts(fine, np.array([0.0, 0.002]) - 6.0345e-5, 0.0) == ["above 0.00006"]


def shown(place):
    return f"above {float(f'{place:.3g}'):g}" if place < 60 else tables.NOWHERE


def test_crossings_of_largest_and_least_extent_are_exact(grid):
    (field,) = find_fields(grid)
    table = tables.level_table(field, read_axes(grid))
    for k, level in enumerate(LEVELS):
        for variant, symbol in (("A", "A"), ("Bhat", "B̂")):
            (row,) = (row for row in table.rows if row.name == f"sn, {symbol}")
            most, least = (shown(crossing(variant, level, ratio)) for ratio in (RATIOS[0], RATIOS[-1]))
            more = f"at ratio = 1.05; {least} at ratio = 1.5"
            assert row.cells[k] == Cell(most, below=more if most != least else "")


def test_all_crossings_are_written_to_a_file(grid, tmp_path):
    write_sweep(grid, tmp_path)
    with (tmp_path / CROSSINGS).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    by_place = {
        (row["number"], row["ics"], float(row["more_than"]), float(row["ratio"])): row for row in rows
    }
    for variant, level, ratio in product(SHARES, LEVELS, RATIOS):
        expected, row = crossing(variant, level, ratio), by_place.get(("sn", variant, level, ratio))
        if expected >= 60:
            assert row is None
        else:
            assert (float(row["flank_from"]), row["flank_to"]) == (pytest.approx(expected, rel=1e-5), "")


def test_text_values_are_categories():
    names = np.array(["steel", "bronze", "polyamide"])
    axis = ShownAxis("material", "material", names)
    assert tables.crossing_texts(axis, np.array([2.0, 0.0, 2.0]), 1.0) == ["at steel and polyamide"]
    assert tables.crossing_texts(axis, np.array([2.0, 2.0, np.nan]), 1.0) == [tables.EVERYWHERE]
    np.testing.assert_array_equal(axis.at, [0, 1, 2])
    assert axis.categories == list(names)
    assert not axis.is_logarithmic
