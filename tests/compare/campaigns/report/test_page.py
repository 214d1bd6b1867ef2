"""The page of a campaign: its answer, failures, random points, advice, and what is on request."""

import numpy as np
import pytest

from compare.campaigns.report.fields import COLUMN, ROW, axes_of, fields_of
from compare.campaigns.report.page import (
    MOST_FAILURES,
    correlation_table,
    failure_table,
    rank_correlation,
    write_sweep,
)
from compare.campaigns.report.summary import NONE, advice_of, answer_note, answer_table, summary
from tests.compare.campaigns.report.datasets import (
    ESTIMATE,
    FLANKS,
    RATIOS,
    campaign,
    charts,
    crossing,
    error,
    on_three_axes,
    with_failures,
)
from tests.pages import widest


def test_summary_says_which_ics_are_good_enough_and_where_they_fail(grid):
    assert summary(grid, fields_of(grid), None).split("\n") == [
        "B̂, the closest to C, is within 5 % in nn and sn everywhere.",
        "Further off: A by up to 19 % in sn.",
        "21 scenes over flank = 0 ... 60 u and ratio = 1.05 ... 1.5 u: all computed; C is known to 0.2 % or "
        "better.",
    ]
    of_a = grid.sel(variant=["A", "C"])
    assert summary(of_a, fields_of(of_a), None).split("\n")[0] == (
        "A is within 5 % in nn everywhere, but off by more in sn from flank = 15.8 on at ratio = 1.05, "
        "nowhere at ratio = 1.5, at most by 19 %."
    )


def test_ics_alike_share_a_sentence(grid):
    same = grid.assign(error=grid.error.where(grid.variant != "Bhat", grid.error.sel(variant="A")))
    first, *others = summary(same, fields_of(same), None).split("\n")
    assert first.startswith("A and B̂ are within 5 % in nn everywhere")
    assert len(others) == 1


def test_summary_reports_nn_besides_the_worst_component(curve):
    much = curve.assign(error=10 * curve.error).sel(variant=["A", "C"])
    first, _ = summary(much, fields_of(much), None).split("\n")
    assert first == (
        "A is off by more than 5 % in nn from flank = 15.8 on; in sn from flank = 1.58 on, at most by 190 %."
    )


def test_answer_has_the_largest_errors_with_estimates_and_where_they_are_too_large(grid):
    (field,) = fields_of(grid)
    table = answer_table(field, grid)
    assert [column.title for column in table.columns] == ["nn [%]", "sn [%]"]
    percent = {row.name: [cell.text for cell in row.cells] for row in table.rows}
    for symbol, variant in (("A", "A"), ("B̂", "Bhat")):
        largest, known = 100 * error(variant, 60), 100 * ESTIMATE
        assert percent[symbol] == [f"{largest / 10:.3f} ± {known / 10:.3f}", f"{largest:.2f} ± {known:.2f}"]
    assert table.rows[0].cells[1].below == f"from {crossing('A', 0.05):.1f} on"
    assert table.rows[1].cells[1].below == "nowhere"
    assert "flank [u] at which it exceeds 5 %, at the ratio where" in answer_note(field, grid)


def test_answer_of_many_columns_names_those_further_down(grid):
    rng = np.random.default_rng(0)
    many = grid.assign(error=(grid.error.dims, rng.uniform(0.1, 1, grid.error.shape)))
    (field,) = fields_of(many)
    assert [column.head for column in answer_table(field, many).columns] == field.columns[:6]
    assert answer_note(field, many).endswith("Further down: sx, nx and ns.")


def test_failed_scenes_are_reported_as_gaps(grid, tmp_path):
    failing = (FLANKS[:, None] > 35) & (RATIOS < 1.3)
    broken = with_failures(grid, failing)
    (field,) = fields_of(broken)
    sentences = summary(broken, [field], None)
    assert "15 computed, 6 failed;" in sentences
    assert "B̂, the closest to C, is within 5 % in nn and sn wherever known (15 of 21 scenes)." in sentences
    assert "everywhere" not in sentences
    large = broken.assign(error=100 * broken.error)
    assert "(15 of 21 scenes are known)" in summary(large, fields_of(large), None)
    table = failure_table(broken)
    assert [row.name for row in table.rows][:2] == ["flank = 40, ratio = 1.05", "flank = 40, ratio = 1.2"]
    assert table.rows[0].cells == ["not converged"]
    text = write_sweep(broken, tmp_path).read_text(encoding="utf-8")
    assert "Failed scenes (6)" in text
    assert "not converged" in text
    assert "15 of 21</td>" in text


def test_of_many_failures_the_first_are_listed(samples):
    broken = with_failures(samples, np.arange(200) < 50)
    table = failure_table(broken)
    assert len(table.rows) == MOST_FAILURES + 1
    assert table.rows[-1].name == "and 30 more"


def test_rank_correlations_depend_on_order_only(samples):
    (field,) = fields_of(samples)
    flank, ratio = axes_of(samples)
    (row,) = (row for row in correlation_table(field, [flank, ratio]).rows if row.name == "sn, A")
    assert row.cells[0].value > 0.4
    assert row.cells[1].value < -0.4
    assert rank_correlation(flank, samples.flank.values**3) == pytest.approx(1.0)


def test_errors_at_random_points_are_reported_as_shares_of_scenes(samples):
    (field,) = fields_of(samples)
    over = f"{100 * float(np.mean(field.values.sel({ROW: 'A', COLUMN: 'sn'}) > 0.05)):.0f} %"
    of_a = samples.sel(variant=["A", "C"])
    assert f"in sn in {over} of the scenes" in summary(of_a, fields_of(of_a), None)
    assert answer_table(field, samples).rows[0].cells[1].below == f"{over} of scenes"


def with_advice(curve):
    advised = np.array([0.0, 0, 0, 1, 1, -1, np.nan])
    return curve.drop_vars(["error", "vanishes"]).assign(
        advised=(("flank", "body"), np.stack([np.zeros(7), advised], axis=-1)),
    )


def test_advice_is_shown_with_symbols(curve):
    kept = with_advice(curve)
    advice = advice_of(kept)
    assert advice.labels == ["A", "B̂", NONE]
    assert advice.counts() == {"A": 3, "B̂": 2, NONE: 1}
    assert advice_of(kept.isel(flank=slice(0, 5))).labels == ["A", "B̂"]
    first, _ = summary(kept, [], advice).split("\n")
    assert first == "The cheapest ICs that are good enough (scenes): A in 3, B̂ in 2 and none in 1."
    (panel,) = charts(kept.assign_attrs(keep='["advice"]'))["advice"]["steps"][0]
    assert panel["layout"]["yaxis"]["ticktext"] == advice.labels
    assert panel["traces"][0]["y"] == [0, 0, 0, 1, 1, 2, None]


def test_summary_has_at_most_three_sentences(curve):
    both = curve.assign(advised=with_advice(curve).advised)
    assert len(summary(both, fields_of(both), advice_of(both)).split("\n")) == 3


@pytest.mark.parametrize(("count", "drawn"), [(1, 0), (2, 1)])
def test_one_scene_has_numbers_and_no_charts(curve, count, drawn, tmp_path):
    one = curve.isel(flank=slice(5, 5 + count)).assign_attrs(scenes=count, computed=count)
    assert len(charts(one)) == drawn
    text = write_sweep(one, tmp_path).read_text(encoding="utf-8")
    assert ("15.83 ± 0.20" if count == 1 else "19.00 ± 0.20") in text


def test_page_says_that_nothing_is_computed(grid, tmp_path):
    empty = grid[["failure", "seconds"]].assign(seconds=grid.seconds * np.nan).assign_attrs(computed=0)
    text = write_sweep(empty, tmp_path).read_text(encoding="utf-8")
    assert "none computed, 21 not computed yet" in text
    assert "Nothing is computed yet." in text


def test_of_three_axes_the_closest_ics_are_shown_and_others_on_request(grid, tmp_path):
    text = write_sweep(on_three_axes(grid.isel(flank=[0, 6], ratio=[0, 2])), tmp_path).read_text(
        encoding="utf-8"
    )
    assert "<h2>B̂: Errors over flank, ratio and third</h2>" in text
    assert ">A: Errors over flank, ratio and third</summary>" in text
    assert "the worst over third" in text


def test_page_says_how_many_points_are_drawn(tmp_path):
    flank, ratio = np.linspace(0, 60, 900), np.linspace(1.05, 1.5, 900)
    many = campaign({"flank": flank, "ratio": ratio}, flank, ratio, points="samples")
    assert "500 of 900 scenes are drawn." in write_sweep(many, tmp_path).read_text(encoding="utf-8")


def test_figures_of_before_are_removed(grid, tmp_path):
    (tmp_path / "figures").mkdir()
    for ending in ("png", "svg"):
        (tmp_path / "figures" / f"sweep_of_before.{ending}").touch()
    write_sweep(grid, tmp_path)
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == ["sweep_errors.svg", "sweep_within_errors.svg"]


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, 800, 400])
@pytest.mark.parametrize("points", ["grid", "third", "samples"])
def test_page_is_not_wider_than_the_window(request, points, width, browser, tmp_path):
    grid = request.getfixturevalue("grid" if points == "third" else points)
    dataset = on_three_axes(grid) if points == "third" else grid
    failing = np.zeros(dataset.seconds.shape, dtype=bool)
    failing.flat[0] = True
    page, table = widest(browser, write_sweep(with_failures(dataset, failing), tmp_path), width)
    assert page <= width
    assert table <= max(width, 800)


@pytest.mark.slow
def test_console_says_nothing_while_sliders_move(grid, browser, tmp_path):
    page, said = browser.new_page(viewport={"width": 1280, "height": 900}), []
    page.on("console", lambda message: said.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda failure: said.append(str(failure)))
    page.goto(write_sweep(grid, tmp_path).as_uri())
    page.wait_for_selector("#chart-within_errors .js-plotly-plot")
    for chart, shown in (("within_errors", "1 %"), ("errors", "A")):
        page.locator(f"#chart-{chart} input[type=range]").press("Home")
        assert page.locator(f"#chart-{chart} output").inner_text() == shown
    page.wait_for_selector("#chart-errors .js-plotly-plot")
    page.close()
    assert said == []
