"""The page of a campaign: sentences, failures, figures, random points, advice."""

import json
import re
from itertools import product

import numpy as np
import pytest
import xarray as xr

from femic.campaigns.report.advised import NONE, advice_of
from femic.campaigns.report.axes import axes_of
from femic.campaigns.report.clouds import correlations
from femic.campaigns.report.contents import fields_of
from femic.campaigns.report.fields import COLUMN, ROW
from femic.campaigns.report.figures import MOST_PANELS, parts
from femic.campaigns.report.page import write_sweep
from femic.campaigns.report.summary import summary
from femic.campaigns.report.tables import MOST_FAILURES, failure_table
from tests.femic.campaigns.report.datasets import FLANKS, RATIOS, pictures, with_failures


def test_summary_says_where_ics_fail(grid):
    sentences = summary(grid, fields_of(grid), None).split("\n")
    assert sentences[0] == "21 scenes over flank = 0 ... 60 u and ratio = 1.05 ... 1.5 u: all computed."
    assert sentences[1] == "C is known to 0.2 % or better."
    assert sentences[2] == (
        "A is off by more than 5 % in sn from flank = 15.8 on at ratio = 1.05, nowhere at ratio = 1.5, at "
        "most by 19 % (in nn nowhere)."
    )
    assert sentences[3] == "B̂ is within 5 % in nn and sn everywhere."
    assert sentences[4] == "These values of flank are interpolated linearly between scenes."
    nowhere = grid.assign(error=grid.error * (grid.variant == "C"))
    assert "interpolated" not in summary(nowhere, fields_of(nowhere), None)


def test_summary_reports_nn_besides_the_worst_component(curve):
    much = curve.assign(error=10 * curve.error)
    sentences = summary(much, fields_of(much), None).split("\n")
    assert sentences[2] == (
        "A is off by more than 5 % in nn from flank = 15.8 on; in sn from flank = 1.58 on, at most by 190 %."
    )


def test_failed_scenes_are_reported_as_gaps(grid, tmp_path):
    failing = (FLANKS[:, None] > 35) & (RATIOS < 1.3)
    broken = with_failures(grid, failing)
    (field,) = fields_of(broken)
    sentences = summary(broken, [field], None)
    assert "15 computed, 6 failed." in sentences
    assert "(in nn nowhere; 15 of 21 scenes are known)" in sentences
    assert "B̂ is within 5 % in nn and sn wherever they are known (15 of 21 scenes)." in sentences
    assert "everywhere" not in sentences
    table = failure_table(broken)
    assert [row.name for row in table.rows][:2] == ["flank = 40, ratio = 1.05", "flank = 40, ratio = 1.2"]
    assert table.rows[0].cells == ["not converged"]
    page = write_sweep(broken, tmp_path)
    assert pictures(page) == 1
    assert "Lines: 1, 2, 5 and 10 %, where most scenes are known." in page.read_text(encoding="utf-8")
    assert "not converged" in page.read_text(encoding="utf-8")


def test_of_many_failures_the_first_are_listed(samples):
    broken = with_failures(samples, np.arange(200) < 50)
    table = failure_table(broken)
    assert len(table.rows) == MOST_FAILURES + 1
    assert table.rows[-1].name == "and 30 more"


def test_rank_correlations_depend_on_order_only(samples):
    (field,) = fields_of(samples)
    coefficients = correlations(field, axes_of(samples)).sel({ROW: "A", COLUMN: "sn"})
    assert float(coefficients.sel(axis="flank")) > 0.4
    assert float(coefficients.sel(axis="ratio")) < -0.4
    same = xr.zeros_like(field.values) + samples.flank**3
    of_order = type(field)("", "error", "", "", same)
    np.testing.assert_allclose(correlations(of_order, axes_of(samples)).sel(axis="flank"), 1.0)


def test_errors_at_random_points_are_reported_as_shares_of_scenes(samples, tmp_path):
    over = np.mean(samples.error.sel(body="combined", variant="A", line="s = 0", i="s", j="n") > 0.05)
    assert f"in {float(over):.0%} of the scenes" in summary(samples, fields_of(samples), None)
    assert pictures(write_sweep(samples, tmp_path)) == 2  # nn and sn


def test_columns_without_panels_are_named(samples):
    rng = np.random.default_rng(0)
    many = samples.assign(error=xr.zeros_like(samples.error) + rng.uniform(0.1, 1, (200, 2, 3, 2, 3, 3)))
    many = many.isel(variant=[0, 0, 0, 0, 1, 1, 1, 2])
    many = many.assign_coords(variant=[*(f"variant {k}" for k in range(7)), "C"])
    drawn = list(parts(many, fields_of(many), None))
    panels = sum(len(part.figure.axes) - 1 for part in drawn)  # less bars of colours
    assert 0 < panels <= MOST_PANELS
    names = [part.heading.split(":")[0] for part in drawn]
    (left_out,) = re.findall(r"Not drawn: (.*?);", drawn[0].text)
    assert sorted([*names, *re.split(", | and ", left_out)]) == sorted(map("".join, product("xsn", repeat=2)))


def test_errors_of_zero_are_drawn_at_the_lower_end(curve):
    exact = curve.assign(error=curve.error.where((curve.variant != "A") | (curve.j != "n"), 0.0))
    (part,) = parts(exact, fields_of(exact), None)
    assert "Errors below 0.01 % are drawn there." in part.text
    for panel in part.figure.axes:
        (of_a,) = (line for line in panel.get_lines() if line.get_label() == "A")
        low, high = panel.get_ylim()
        assert len(of_a.get_ydata()) == 7
        assert np.all((of_a.get_ydata() > low) & (of_a.get_ydata() < high))


def test_the_estimate_is_drawn_where_it_is_known(curve):
    gap = np.arange(7) == 3
    broken = with_failures(curve, gap)
    (part,) = parts(broken, fields_of(broken), None)
    (band, *_) = part.figure.axes[0].collections
    at = band.get_paths()[0].vertices[:, 0]
    np.testing.assert_allclose(np.unique(at), FLANKS[~gap])


def test_advice_is_shown_with_symbols(curve, tmp_path):
    advised = np.array([0.0, 0, 0, 1, 1, -1, np.nan])
    kept = curve.drop_vars(["error", "vanishes"]).assign(
        advised=(("flank", "body"), np.stack([np.zeros(7), advised], axis=-1)),
    )
    advice = advice_of(kept)
    assert advice.labels == ["A", "B̂", NONE]
    assert advice.counts() == {"A": 3, "B̂": 2, NONE: 1}
    assert pictures(write_sweep(kept.assign_attrs(keep='["advice"]'), tmp_path)) == 1
    assert advice_of(kept.isel(flank=slice(0, 5))).labels == ["A", "B̂"]


@pytest.mark.parametrize(("count", "drawn"), [(1, 0), (2, 1)])
def test_one_scene_has_numbers_and_no_figures(curve, count, drawn, tmp_path):
    one = curve.isel(flank=slice(5, 5 + count)).assign_attrs(scenes=count, computed=count)
    page = write_sweep(one, tmp_path)
    assert pictures(page) == drawn
    assert ("16 %" if count == 1 else "19 %") in page.read_text(encoding="utf-8")


def test_page_says_that_nothing_is_computed(grid, tmp_path):
    empty = grid[["failure", "seconds"]].assign(seconds=grid.seconds * np.nan).assign_attrs(computed=0)
    text = write_sweep(empty, tmp_path).read_text(encoding="utf-8")
    assert "none computed, 21 not computed yet" in text
    assert "Nothing is computed yet." in text


@pytest.mark.parametrize("third", [np.arange(6.0), np.array(["steel", "bronze"])])
def test_third_axis_has_small_multiples_and_old_figures_are_removed(grid, third, tmp_path):
    thick = grid.expand_dims(third=third).transpose("flank", "ratio", "third", ...)
    thick = thick.assign_attrs(axes=json.dumps([{"name": name} for name in ("flank", "ratio", "third")]))
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "sweep_of_before.png").touch()
    page = write_sweep(thick.assign(third=("third", third)), tmp_path)
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == ["sweep_errors_0.png", "sweep_errors_by_third_0_0.png"]
    text = page.read_text(encoding="utf-8")
    assert "The worst over third." in text
    assert "<h2>B̂: Errors over flank, ratio and third</h2>" in text
    assert "<h2>A: Errors" not in text
    assert ("4 of 6" in text) == (len(third) == 6)
    assert "<h2>The campaign</h2>" in text
