"""The fields of a campaign's dataset over its axes: errors, contacts with and without friction, stresses."""

import numpy as np
import pytest
import xarray as xr

from compare.campaigns.report.fields import COLUMN, ROW, ShownAxis, find_fields, prepare
from compare.campaigns.report.page import write_sweep
from compare.campaigns.report.tables import answer_table, worst_table
from compare.report.tables import MINUS
from tests.compare.campaigns.report.datasets import ESTIMATE, FLANKS, error, keeping


def test_field_has_the_largest_combined_error_over_lines(grid):
    (field,) = find_fields(grid)
    assert field.rows == ["A", "Bhat"]
    assert field.columns == ["nn", "sn"]  # xs vanishes by symmetry, others are not computed
    at = field.values.sel({ROW: "A", "flank": 30.0, "ratio": 1.2})
    assert float(at.sel({COLUMN: "sn"})) == pytest.approx(error("A", 30, 1.2))
    np.testing.assert_allclose(field.floor.sel({COLUMN: "sn"}), ESTIMATE)
    (row,) = (row for row in worst_table(field, grid).rows if row.name == "sn, B̂")
    assert row.cells == ["4.75 ± 0.20", "flank = 60, ratio = 1.05"]


def test_contacts_are_compared_with_the_contact_with_c(curve):
    numbers = (
        np.array([1.1, 0.98, 1.0])[None, None, :] * np.array([1.0, 2.0])[None, :, None] * np.ones((7, 1, 1))
    )
    numbers[:, 1, 0] *= np.linspace(1.0, 0.7, 7)  # of the second case, by A
    by = ("flank", "case", "ics")
    values = {"p_max": (by, 100 * numbers), "estimate_p_max": (by, numbers)}
    off, reference = find_fields(keeping(curve, "contact", values, ics=["A", "Bhat", "C"]))
    assert (off.kind, off.rows, off.columns) == ("deviation", ["A", "Bhat"], ["p_max"])
    of_a = 1.1 * np.linspace(1.0, 0.7, 7) - 1
    np.testing.assert_allclose(off.values.sel({ROW: "A"})[0], np.where(-of_a > 0.1, of_a, 0.1))
    np.testing.assert_allclose(off.values.sel({ROW: "Bhat"})[0], -0.02)
    np.testing.assert_allclose(off.floor[0], 0.01)
    np.testing.assert_allclose(reference.values, 200.0)


def test_shares_of_contacts_with_friction_are_compared_as_differences(curve, tmp_path):
    """At seven flanks, one friction, by A and B-hat, at two creepages."""
    by = ("flank", "friction", "ics", "xi")
    numbers = {"p_max": [[110.0], [100.0]], "estimate_p_max": 3.0, "sliding_share": [[0.2, 0.9], [0.5, 1.0]]}
    values = {name: (by, np.broadcast_to(value, (7, 1, 2, 2)).copy()) for name, value in numbers.items()}
    values["largest_of_curve"] = by[:3], np.broadcast_to([0.07, 0.0], (7, 1, 2)).copy()
    kept = keeping(curve, "contact", values, ics=["A", "Bhat"], friction=[0.3], xi=[0.0, 0.01])
    off, reference = find_fields(kept)
    assert (off.rows, off.columns) == (["A"], ["p_max", "F_x(ξ)", "sliding"])
    np.testing.assert_allclose(off.values.sel({ROW: "A"}).isel(flank=0), [0.1, 0.07, -0.3])
    assert reference.columns == ["p_max [1]", "sliding [1]"]
    np.testing.assert_allclose(reference.values.sel({COLUMN: "sliding [1]"}), 1.0)
    (row,) = answer_table(off, kept).rows
    assert [(cell.text, cell.below) for cell in row.cells] == [
        ("+10.0 ± 3.0", "within 5 %: 0 of 7; exceeded everywhere"),
        ("+7", "within 5 %: 0 of 7, not decided: 7; exceeded everywhere"),  # without an estimate
        (f"{MINUS}30", "within 5 %: 0 of 7, not decided: 7; exceeded everywhere"),
    ]
    text = write_sweep(kept, tmp_path).read_text(encoding="utf-8")
    assert "the estimated error of B̂" in text
    assert "the estimated error of C" not in text


def test_ics_that_differ_between_scenes_are_named_after_their_places(curve):
    mixed = prepare(curve.assign_coords(variant=["variant 0", "variant 1", "variant 2"]))
    (field,) = find_fields(mixed)
    assert field.rows == ["ICs 1", "ICs 2"]
    np.testing.assert_array_equal(
        field.values.sel({ROW: "ICs 1"}), find_fields(curve)[0].values.sel({ROW: "A"})
    )
    np.testing.assert_allclose(field.floor.sel({COLUMN: "sn"}), ESTIMATE)


def test_half_spaces_are_compared_with_true_bodies(curve, tmp_path):
    """Off by a share of flank / 200: 5 % is exceeded from 10 on."""
    numbers = {
        "mises_upper": 1000.0,
        "half_space_mises_upper": 1000.0 * (1 - curve.flank.values / 200),
        "estimate_mises_upper": 10.0,
        "dang_van_upper": 400.0,
        "half_space_dang_van_upper": 404.0,
    }
    values = {name: ("flank", np.broadcast_to(value, 7).copy()) for name, value in numbers.items()}
    kept = keeping(curve, "stresses", values)
    off, true = find_fields(kept)
    columns = ["σ_Mises, upper body", "τ_DV, upper body"]
    assert (off.kind, off.rows, off.columns) == ("deviation", ["half-space"], columns)
    np.testing.assert_allclose(off.values.sel({COLUMN: columns[0]})[0], -curve.flank / 200, atol=1e-12)
    np.testing.assert_allclose(off.values.sel({COLUMN: columns[1]})[0], 0.01)
    np.testing.assert_allclose(off.floor.sel({COLUMN: columns[0]}), 0.01)
    assert np.all(np.isnan(off.floor.sel({COLUMN: columns[1]})))
    assert (true.kind, true.columns) == ("value", [f"{column} [MPa]" for column in columns])
    np.testing.assert_allclose(true.values.sel({COLUMN: true.columns[1]}), 400.0)
    (row,) = answer_table(off, kept).rows
    assert [cell.below for cell in row.cells] == [
        "within 5 %: 1 of 7, not decided: 1; exceeded above 10",  # at 10 it is 5 ± 1 %
        "within 5 %: 0 of 7, not decided: 7",  # without an estimate
    ]
    text = write_sweep(kept, tmp_path).read_text(encoding="utf-8")
    assert "the estimated error of actual bodies" in text


def test_wear_is_compared_between_ics(curve):
    t_gamma = ("flank", "ics"), np.broadcast_to([113.0, 100.0], (7, 2)).copy()
    off, reference = find_fields(keeping(curve, "stresses", {"t_gamma": t_gamma}, ics=["A", "C"]))
    assert (off.rows, off.columns) == (["A"], ["Tγ"])
    np.testing.assert_allclose(off.values, 0.13)
    np.testing.assert_allclose(reference.values, 100.0)


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
