"""The fields of a campaign's dataset: errors, contacts with and without friction."""

import json

import numpy as np
import pytest
import xarray as xr

from compare.campaigns.report.fields import COLUMN, ROW, find_fields, prepare
from compare.campaigns.report.page import write_sweep
from compare.campaigns.report.tables import answer_table, worst_table
from tests.compare.campaigns.report.datasets import ESTIMATE, error


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
    kept = curve.drop_vars(["error", "vanishes"]).assign(
        p_max=(by, 100 * numbers), estimate_p_max=(by, numbers)
    )
    kept = kept.assign_coords(ics=["A", "Bhat", "C"]).assign_attrs(keep=json.dumps(["contact"]))
    off, reference = find_fields(kept)
    assert (off.kind, off.rows, off.columns) == ("deviation", ["A", "Bhat"], ["p_max"])
    of_a = 1.1 * np.linspace(1.0, 0.7, 7) - 1
    np.testing.assert_allclose(off.values.sel({ROW: "A"})[0], np.where(-of_a > 0.1, of_a, 0.1))
    np.testing.assert_allclose(off.values.sel({ROW: "Bhat"})[0], -0.02)
    np.testing.assert_allclose(off.floor[0], 0.01)
    np.testing.assert_allclose(reference.values, 200.0)


def of_friction(curve, **numbers):
    """A campaign of contacts with friction: numbers over the flanks, one friction, ICs and two creepages."""
    by = ("flank", "friction", "ics", "xi")
    kept = curve.drop_vars(["error", "vanishes"]).assign(
        {name: (by, np.broadcast_to(values, (7, 1, 2, 2)).copy()) for name, values in numbers.items()}
    )
    kept = kept.assign_coords(ics=["A", "Bhat"], friction=[0.3], xi=[0.0, 0.01])
    return kept.assign_attrs(keep=json.dumps(["contact"]))


def test_shares_of_contacts_with_friction_are_compared_as_differences(curve, tmp_path):
    sliding = np.array([[0.2, 0.9], [0.5, 1.0]])  # by ICs and creepage
    kept = of_friction(curve, p_max=np.array([[110.0], [100.0]]), sliding_share=sliding)
    kept = kept.assign(
        largest_of_curve=(("flank", "friction", "ics"), np.broadcast_to([0.07, 0.0], (7, 1, 2)).copy())
    )
    kept = kept.assign(estimate_p_max=xr.full_like(kept.p_max, 3.0))
    off, reference = find_fields(kept)
    assert (off.rows, off.columns) == (["A"], ["p_max", "F_x(ξ)", "sliding"])
    np.testing.assert_allclose(off.values.sel({ROW: "A"}).isel(flank=0), [0.1, 0.07, -0.3])
    assert reference.columns == ["p_max [1]", "sliding [1]"]
    np.testing.assert_allclose(reference.values.sel({COLUMN: "sliding [1]"}), 1.0)
    (row,) = answer_table(off, kept).rows
    assert [(cell.text, cell.below) for cell in row.cells] == [
        ("+10.0 ± 3.0", "everywhere"),
        ("+7", "everywhere"),
        ("-30", "everywhere"),
    ]
    text = write_sweep(kept, tmp_path).read_text(encoding="utf-8")
    assert "the estimate of B̂" in text
    assert "the estimate of C" not in text


def test_ics_that_differ_between_scenes_are_named_after_their_places(curve):
    mixed = prepare(curve.assign_coords(variant=["variant 0", "variant 1", "variant 2"]))
    (field,) = find_fields(mixed)
    assert field.rows == ["ICs 1", "ICs 2"]
    np.testing.assert_array_equal(
        field.values.sel({ROW: "ICs 1"}), find_fields(curve)[0].values.sel({ROW: "A"})
    )
    np.testing.assert_allclose(field.floor.sel({COLUMN: "sn"}), ESTIMATE)


def of_stresses(curve, **numbers):
    """A campaign of stresses: numbers over the flanks, which have to be given for the upper body alone."""
    flat = curve.drop_vars(["error", "vanishes"])
    kept = flat.assign({name: ("flank", np.broadcast_to(value, 7).copy()) for name, value in numbers.items()})
    return kept.assign_attrs(keep=json.dumps(["stresses"]))


def test_half_spaces_are_compared_with_true_bodies(curve, tmp_path):
    """Off by a share of flank / 200: 5 % is exceeded from 10 on."""
    kept = of_stresses(
        curve,
        mises_upper=1000.0,
        half_space_mises_upper=1000.0 * (1 - curve.flank.values / 200),
        estimate_mises_upper=10.0,
        dang_van_upper=400.0,
        half_space_dang_van_upper=404.0,
    )
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
    assert [cell.below for cell in row.cells] == ["from 10 on", "nowhere"]
    text = write_sweep(kept, tmp_path).read_text(encoding="utf-8")
    assert "the estimate of true bodies" in text


def test_wear_is_compared_between_ics(curve):
    kept = of_stresses(curve).assign_coords(ics=["A", "C"])
    kept = kept.assign(t_gamma=(("flank", "ics"), np.broadcast_to([113.0, 100.0], (7, 2)).copy()))
    off, reference = find_fields(kept)
    assert (off.rows, off.columns) == (["A"], ["Tγ"])
    np.testing.assert_allclose(off.values, 0.13)
    np.testing.assert_allclose(reference.values, 100.0)
