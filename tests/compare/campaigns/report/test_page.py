"""The page of a campaign: its answer, failures, random points, advice, and what is on request."""

from dataclasses import replace

import numpy as np
import pytest

from compare.campaigns.report import tables
from compare.campaigns.report.charts import MOST_POINTS
from compare.campaigns.report.fields import COLUMN, NONE, ROW, find_advice, find_fields, read_axes
from compare.campaigns.report.page import count_scenes, write_sweep
from compare.report.files import figures_as
from tests.compare.campaigns.report import datasets
from tests.compare.pages import read_texts, require_room


def test_first_sentence_counts_scenes(grid):
    assert count_scenes(grid) == (
        "21 scenes over flank = 0 ... 60 u and ratio = 1.05 ... 1.5 u: 21 computed, 0 failed, 0 not computed "
        "yet."
    )
    some = datasets.with_failures(grid, (datasets.FLANKS[:, None] > 35) & (datasets.RATIOS < 1.3)).isel(
        ratio=[0, 2]
    )
    assert "over flank = 0 ... 60 u and ratio = 1.05 and 1.5 u: 15 computed, 6 failed, 0" in count_scenes(
        some
    )


def test_answer_has_the_largest_errors_with_estimates_and_where_they_are_too_large(grid):
    (field,) = find_fields(grid)
    table = tables.answer_table(field, grid)
    assert [column.title for column in table.columns] == ["nn [%]", "sn [%]"]
    percent = read_texts(table)
    for symbol, variant in (("A", "A"), ("B̂", "Bhat")):
        largest, known = 100 * datasets.error(variant, 60), 100 * datasets.ESTIMATE
        assert percent[symbol] == [f"{largest / 10:.3f} ± {known / 10:.3f}", f"{largest:.2f} ± {known:.2f}"]
    sizes = field.sizes.sel({COLUMN: "sn"})
    of_a, of_bhat = (int((sizes.sel({ROW: row}) + datasets.ESTIMATE <= 0.05).sum()) for row in field.rows)
    below = [row.cells[1].below for row in table.rows]
    assert below[0].startswith(f"within 5 %: {of_a} of 21")
    assert below[0].endswith(f"; exceeded above {datasets.crossing('A', 0.05):.1f}")
    assert below[1] == f"within 5 %: {of_bhat} of 21"
    assert "where along flank [u] it is exceeded" in tables.answer_note(field, grid)


def test_scenes_count_as_within_only_with_the_estimate(curve):
    """Errors of A in sn: 0.05 is 15.8 times the estimate."""
    (field,) = find_fields(curve)
    part = field.select(rows=["A"], columns=["sn"])
    sizes, known = part.sizes.values.ravel(), datasets.ESTIMATE
    expected = np.sum(sizes <= 0.05 - known), np.sum(sizes > 0.05 + known)
    counts = tables.verdict_counts(part)
    assert (counts["yes"], counts["no"]) == expected
    assert counts["not decided"] == 7 - sum(expected)
    near = part.values * 0 + 0.05 - known / 2
    unsure = tables.verdict_counts(replace(part, values=near))
    assert unsure == {"yes": 0, "no": 0, "not decided": 7}


def test_summary_names_the_largest_errors_and_what_is_always_within(curve):
    (field,) = find_fields(curve)
    text = tables.largest_sentence(field, curve)
    largest = [f"{100 * datasets.error(name, 60) / 10:.3f} ± 0.020 % with" for name in ("Bhat", "A")]
    assert text.startswith(f"Largest error of nn over all scenes: {largest[0]} B̂; {largest[1]} A. ")
    assert text.endswith("in every computed scene and column: B̂.")


def test_answer_has_the_first_columns(grid):
    rng = np.random.default_rng(0)
    many = grid.assign(error=(grid.error.dims, rng.uniform(0.1, 1, grid.error.shape)))
    (field,) = find_fields(many)
    assert [column.head for column in tables.answer_table(field, many).columns] == field.columns[:6]


def test_failed_scenes_are_reported_as_gaps(grid, tmp_path):
    failing = (datasets.FLANKS[:, None] > 35) & (datasets.RATIOS < 1.3)
    broken = datasets.with_failures(grid, failing)
    table = tables.failure_table(broken)
    assert [row.name for row in table.rows][:2] == ["flank = 40, ratio = 1.05", "flank = 40, ratio = 1.2"]
    assert table.rows[0].cells == ["not converged"]
    (doubt,) = tables.doubts(broken)
    assert doubt == "Failed: 6 of 21 scenes (6 × not converged). Their numbers are missing below."
    assert not list(tables.doubts(grid))
    text = write_sweep(broken, tmp_path).read_text(encoding="utf-8")
    assert "Failed scenes (6)" in text
    assert "not converged" in text
    assert "15 of 21</td>" in text


def test_of_many_failures_the_first_are_listed(samples):
    broken = datasets.with_failures(samples, np.arange(200) < 50)
    table = tables.failure_table(broken)
    assert len(table.rows) == tables.MOST_FAILURES + 1
    assert table.rows[-1].name == "and 30 more"


def test_rank_correlations_depend_on_order_only(samples):
    (field,) = find_fields(samples)
    flank, ratio = read_axes(samples)
    (row,) = (row for row in tables.correlation_table(field, [flank, ratio]).rows if row.name == "sn, A")
    assert row.cells[0].value > 0.4
    assert row.cells[1].value < -0.4
    assert tables.rank_correlation(flank, samples.flank.values**3) == pytest.approx(1.0)


def test_errors_at_random_points_are_reported_as_shares_of_scenes(samples):
    (field,) = find_fields(samples)
    sizes = field.values.sel({ROW: "A", COLUMN: "sn"}).values
    yes, no = np.sum(sizes + datasets.ESTIMATE <= 0.05), np.sum(sizes - datasets.ESTIMATE > 0.05)
    below = tables.answer_table(field, samples).rows[0].cells[1].below
    assert below == f"within 5 %: {yes} of 200, not decided: {200 - yes - no}"


def test_cost_has_the_fastest_and_the_slowest_scenes(curve):
    seconds = np.array([np.nan, 3.0, 1.0, 5.0, 2.0, 4.0, np.nan])
    rows = tables.cost_table(curve.assign(seconds=("flank", seconds))).rows
    assert [row.cells[0].value for row in rows] == [15.0, 1.0, 5.0, 4.0, 3.0]
    assert [row.name for row in rows[1:3]] == ["flank = 20", "flank = 30"]


def test_advice_is_shown_with_symbols(curve):
    advised = np.stack([np.zeros(7), [0, 0, 0, 1, 1, -1, np.nan]], axis=-1)
    kept = datasets.keeping(curve, "advice", {"advised": (("flank", "body"), advised)})
    advice = find_advice(kept)
    assert list(advice[1]) == ["A", "B̂", NONE]
    assert {row.name: row.cells[0] for row in tables.advice_table(advice).rows} == {
        "A": "3",
        "B̂": "2",
        NONE: "1",
    }
    assert list(find_advice(kept.isel(flank=slice(0, 5)))[1]) == ["A", "B̂"]
    (panel,) = datasets.charts(kept)["advice"]["steps"][0]
    assert panel["layout"]["yaxis"]["ticktext"] == list(advice[1])
    assert panel["traces"][0]["y"] == [0, 0, 0, 1, 1, 2, None]


@pytest.mark.parametrize(("count", "drawn"), [(1, 0), (2, 1)])
def test_one_scene_has_numbers_and_no_charts(curve, count, drawn, tmp_path):
    one = curve.isel(flank=slice(5, 5 + count)).assign_attrs(scenes=count, computed=count)
    assert len(datasets.charts(one)) == drawn
    text = write_sweep(one, tmp_path).read_text(encoding="utf-8")
    assert ("15.83 ± 0.20" if count == 1 else "19.00 ± 0.20") in text


def test_page_says_that_nothing_is_computed(grid, tmp_path):
    empty = grid[["failure", "seconds"]].assign(seconds=grid.seconds * np.nan).assign_attrs(computed=0)
    text = write_sweep(empty, tmp_path).read_text(encoding="utf-8")
    assert "0 computed, 0 failed, 21 not computed yet" in text
    assert "Nothing is computed yet." in text


def test_of_three_axes_the_closest_ics_are_shown_and_others_on_request(grid, tmp_path):
    text = write_sweep(datasets.on_three_axes(grid.isel(flank=[0, 6], ratio=[0, 2])), tmp_path).read_text(
        encoding="utf-8"
    )
    assert "<h2>B̂: Errors over flank, ratio and third</h2>" in text
    assert ">A: Errors over flank, ratio and third</summary>" in text
    assert "At most 20 values of third are shown" in text


def test_page_says_how_many_points_are_drawn(tmp_path):
    flank, ratio = np.linspace(0, 60, 900), np.linspace(1.05, 1.5, 900)
    many = datasets.campaign({"flank": flank, "ratio": ratio}, flank, ratio, points="samples")
    assert f"{MOST_POINTS} of 900 scenes are drawn." in write_sweep(many, tmp_path).read_text(
        encoding="utf-8"
    )
    assert len(datasets.charts(many)["errors"]["steps"][0][0]["traces"][0]["x"]) == MOST_POINTS


def test_figures_of_before_are_removed(grid, tmp_path):
    (tmp_path / "figures").mkdir()
    for ending in ("png", "svg"):
        (tmp_path / "figures" / f"sweep_of_before.{ending}").touch()
    with figures_as(["svg"]):
        write_sweep(grid, tmp_path)
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == ["sweep_errors.svg", "sweep_within_errors.svg"]


@pytest.mark.slow
@pytest.mark.parametrize("points", ["grid", "third", "samples"])
def test_page_is_not_wider_than_the_window(request, points, browser, tmp_path):
    grid = request.getfixturevalue("grid" if points == "third" else points)
    dataset = datasets.on_three_axes(grid) if points == "third" else grid
    failing = np.zeros(dataset.seconds.shape, dtype=bool)
    failing.flat[0] = True
    page = write_sweep(datasets.with_failures(dataset, failing), tmp_path)
    require_room(browser, page, {1280: 1280, 800: 800, 400: 800})
