"""Numbers in tables: with the digits that their estimates allow, changes due to supports."""

import numpy as np
import pytest
import xarray as xr

from compare.report.tables import Cell, changes_table, number_text, with_estimate
from femic.contact.pairs.quantities import OF_FRICTIONLESS


@pytest.mark.parametrize(
    ("value", "estimate", "text"),
    [
        (684.3123, 4.31, "684.3 ± 4.3"),
        (12345.6, 678.0, "12350 ± 680"),
        (-0.0123456, 0.000996, "−0.0123 ± 0.0010"),
        (2.0, 0.0996, "2.00 ± 0.10"),
        (2.9e-8, 19.1, "0 ± 19"),
        (-1e-12, 0.25, "0 ± 0.25"),
        (0.5, 2.0, "0 ± 2.0"),
        (np.nan, 1.0, "–"),
    ],
)
def test_numbers_have_the_digits_that_their_estimate_allows(value, estimate, text):
    assert with_estimate(value, estimate) == text
    assert with_estimate(xr.DataArray(value), xr.DataArray(estimate)) == text


def test_numbers_of_rounding_stand_alone_and_unknown_errors_are_shown():
    """A number whose error is not known must not look like one that is exact."""
    assert with_estimate(684.25, 0.0) == "684.25"
    assert with_estimate(684.25, np.nan) == "684.2 ± ?"


def test_small_numbers_have_a_common_power_of_ten():
    assert with_estimate(1.2362e-6, 3.1e-8) == "(1.236 ± 0.031)e-6"


def test_other_supports_have_a_column_each_and_changes_far_below_the_estimate_are_0():
    keys = ("p_max", "F_y")
    before = xr.Dataset({"p_max": 1000.0, "estimate_p_max": 10.0, "F_y": 1e-8, "estimate_F_y": 5.0})
    changed = xr.Dataset(
        {"supported_p_max": ("supports", [1010.0, 990.0]), "supported_F_y": ("supports", [3e-8, 4.0])},
        coords={"supports": ["near", "flat"]},
    )
    table = changes_table("t", {key: OF_FRICTIONLESS[key] for key in keys}, before, changed, "supported_")
    assert [head.title for head in table.heads] == ["near", "flat"]
    assert [row.name for row in table.rows] == ["p_max [MPa]", "F_y [N]"]
    assert [[cell.text for cell in row.filled] for row in table.rows] == [["+10", "−10"], ["0", "+4"]]
    assert [row.filled[0].below for row in table.rows] == ["of 1000 ± 10", "of 0 ± 5.0"]


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (-0.0, ".1f", "0.0"),
        (-0.004, "+.0%", "0%"),
        (0.004, "+.0%", "0%"),
        (-0.012, "+.1%", "−1.2%"),
        (0.012, "+.1%", "+1.2%"),
        (-1.5e-7, ".2g", "−1.5e-07"),
        (np.inf, "+.2f", "+inf"),
        (0.0, "+.1e", "0.0e+00"),
    ],
)
def test_numbers_have_minus_signs_and_zero_has_none(value, form, text):
    assert number_text(value, form) == text
    assert Cell(value, form).text == text


@pytest.mark.parametrize(
    ("value", "estimate", "text"),
    [(520, 640, "500 ± 600"), (-520, 640, "−500 ± 600"), (684.3, 43, "684 ± 43"), (40, 640, "0 ± 640")],
)
def test_a_number_has_no_digits_that_its_estimate_does_not_allow(value, estimate, text):
    assert with_estimate(value, estimate) == text
