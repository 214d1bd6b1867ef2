"""The page of a campaign: crossings of known functions, gaps, categories, random points, figures."""

import csv
import json
import re
from itertools import product

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from femic.campaigns.report.advised import NONE, advice_of
from femic.campaigns.report.axes import ShownAxis, axes_of, prepared
from femic.campaigns.report.clouds import correlations
from femic.campaigns.report.contents import fields_of
from femic.campaigns.report.crossings import EVERYWHERE, NOWHERE, Found, Line, Lines, exceeded
from femic.campaigns.report.fields import COLUMN, LEVELS, ROW
from femic.campaigns.report.figures import MOST_PANELS, parts
from femic.campaigns.report.page import CROSSINGS, write_sweep
from femic.campaigns.report.summary import summary
from femic.campaigns.report.tables import MOST_FAILURES, crossing_table, failure_table, worst_table

VARIANTS = ["A", "Bhat", "C"]
FLANKS, RATIOS = np.linspace(0.0, 60.0, 7), np.array([1.05, 1.2, 1.5])
ESTIMATE = 0.002
SHARES = {"A": 1.0, "Bhat": 0.25}
# error = share * 0.19 * flank / 60 / (20 (ratio - 1)): linear in flank, so that crossings are exact


def error(variant, flank, ratio=1.05):
    return SHARES[variant] * 0.19 * flank / 60 / (20 * (ratio - 1))


def crossing(variant, level, ratio=1.05):
    return level * 60 * 20 * (ratio - 1) / (0.19 * SHARES[variant])


def campaign(axes, flank, ratio, **attrs):
    """A dataset of errors of sn (twice as large on the second line, as of `error`) and nn (a tenth)."""
    is_grid = attrs.get("points", "grid") == "grid"
    dims = tuple(axes) if is_grid else ("sample",)
    flank, ratio = np.broadcast_arrays(flank, ratio)
    errors = np.full((*flank.shape, 2, len(VARIANTS), 2, 3, 3), np.nan)
    for k, name in enumerate(VARIANTS):
        sn = np.full(flank.shape, ESTIMATE) if name == "C" else error(name, flank, ratio)
        for line, (column, part) in product(range(2), ((1, 1.0), (2, 0.1))):
            errors[..., 1, k, line, column, 2] = part * sn * (line + 1) / 2
        errors[..., 1, k, :, 0, 1] = 1e-15  # xs vanishes by symmetry
    errors[..., 0, :, :, :, :] = 7.0  # of another body
    coords = {
        name: (name if is_grid else "sample", values, {"long_name": f"the {name}", "units": "u"})
        for name, values in axes.items()
    }
    return xr.Dataset(
        {
            "failure": (dims, np.full(flank.shape, "", dtype=object)),
            "seconds": (dims, np.ones(flank.shape)),
            "error": ((*dims, "body", "variant", "line", "i", "j"), errors),
            "vanishes": ((*dims, "body", "i", "j"), np.zeros((*flank.shape, 2, 3, 3))),
        },
        coords=coords
        | {
            "body": ["lower", "combined"],
            "variant": VARIANTS,
            "line": ["x = 0", "s = 0"],
            "i": list("xsn"),
            "j": list("xsn"),
        },
        attrs={
            "title": "a title",
            "campaign": "the text of the campaign",
            "axes": json.dumps([{"name": name} for name in axes]),
            "keep": json.dumps(["errors"]),
            "points": "grid",
            "scenes": flank.size,
            "computed": flank.size,
            "failed": 0,
        }
        | attrs,
    )


def with_failures(dataset, failing):
    """The dataset where some scenes, a mask over the swept dims, have failed."""
    dims = dataset.seconds.dims
    mask = xr.DataArray(failing, dims=dims)
    failed = int(mask.sum())
    broken = dataset.assign(
        error=dataset.error.where(~mask),
        vanishes=dataset.vanishes.where(~mask),
        failure=(dims, np.where(failing, "not converged", "").astype(object)),
    )
    return broken.assign_attrs(computed=dataset.attrs["scenes"] - failed, failed=failed)


@pytest.fixture
def grid():
    return campaign({"flank": FLANKS, "ratio": RATIOS}, FLANKS[:, None], RATIOS)


@pytest.fixture
def curve():
    return campaign({"flank": FLANKS}, FLANKS, 1.05)


@pytest.fixture
def samples():
    rng = np.random.default_rng(0)
    flank, ratio = rng.uniform(0, 60, 200), rng.uniform(1.05, 1.5, 200)
    return campaign({"flank": flank, "ratio": ratio}, flank, ratio, points="samples")


def cells(table, row):
    return [cell["text"] for one in table.rows if one.name == row for cell in one.cells]


def pictures(page):
    return page.read_text(encoding="utf-8").count("data:image/png;base64,")


def test_ranges_in_which_a_level_is_exceeded_are_interpolated_linearly():
    at = np.array([0.0, 1.0, 3.0, 4.0])

    def ends(values, level):
        return [(one.start, one.end) for one in exceeded(at, np.array(values), level)]

    assert ends([0.0, 1.0, 3.0, 4.0], 2.0) == [(2.0, None)]
    assert ends([4.0, 3.0, 1.0, 0.0], 2.0) == [(None, 2.0)]
    assert ends([3.0, 1.0, 1.0, 4.0], 2.0) == [(None, 0.5), (pytest.approx(3 + 1 / 3), None)]
    assert ends([1.0, 3.0, np.nan, 0.0], 2.0) == [(0.5, 2.0)]
    assert ends([3.0, 3.0, 3.0, 3.0], 2.0) == [(None, None)]
    assert ends([2.0, 2.0, 2.0, 2.0], 2.0) == []


def test_a_level_that_is_exceeded_again_and_gaps_are_told():
    axis = ShownAxis("flank", "flank", np.array([0.0, 1.0, 2.0, 3.0, 4.0]))
    again = Line(axis, {}, np.array([0.0, 2.0, 0.0, 2.0, 0.0]))
    assert again.found(1.0) == Found("from 0.5 to 1.5", more="again from 2.5 to 3.5")
    assert again.extent(1.0) == 0.5
    sizes = xr.DataArray([0.0, 0.5, np.nan, 0.5, np.nan], dims="flank")
    lines = Lines.of(sizes, [axis])
    assert (lines.found(1.0), lines.known_of) == ([Found(NOWHERE)], "3 of 5 scenes")
    assert Lines.of(sizes * np.nan, [axis]).found(1.0) == []


def test_small_values_have_the_digits_of_the_span():
    axis = ShownAxis("spin", "spin", np.array([0.0, 0.002]))
    low = 6.0345e-5
    sizes = np.array([0.0, 0.002]) - low
    assert Line(axis, {}, sizes).found(0.0).text == "from 0.00006 on"


def shown(place):
    return f"from {float(f'{place:.3g}'):g} on" if place < 60 else NOWHERE


def test_crossings_of_errors_are_those_of_the_function_where_most_and_where_least(grid):
    (field,) = fields_of(grid)
    table = crossing_table(field, axes_of(grid))
    for k, level in enumerate(LEVELS):
        for variant, symbol in (("A", "A"), ("Bhat", "B̂")):
            (row,) = (row for row in table.rows if row.name == f"sn, {symbol}")
            most, least = (shown(crossing(variant, level, ratio)) for ratio in (RATIOS[0], RATIOS[-1]))
            more = f"at ratio = 1.05; {least} at ratio = 1.5"
            assert row.cells[k] == {"text": most, "below": more if most != least else ""}


def test_all_crossings_are_in_a_file(grid, tmp_path):
    write_sweep(grid, tmp_path)
    with (tmp_path / CROSSINGS).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    found = {(row["number"], row["ics"], float(row["more_than"]), float(row["ratio"])): row for row in rows}
    for variant, level, ratio in product(SHARES, LEVELS, RATIOS):
        expected, row = crossing(variant, level, ratio), found.get(("sn", variant, level, ratio))
        if expected >= 60:
            assert row is None
        else:
            assert (float(row["flank_from"]), row["flank_to"]) == (pytest.approx(expected, rel=1e-5), "")


def test_the_largest_error_over_lines_of_both_bodies_together_is_shown(grid):
    (field,) = fields_of(grid)
    assert field.rows == ["A", "Bhat"]
    assert field.columns == ["nn", "sn"]  # xs vanishes by symmetry, others are not computed
    at = field.values.sel({ROW: "A", "flank": 30.0, "ratio": 1.2})
    assert float(at.sel({COLUMN: "sn"})) == pytest.approx(error("A", 30, 1.2))
    np.testing.assert_allclose(field.floor.sel({COLUMN: "sn"}), ESTIMATE)
    cell = worst_table(field, grid).rows[1].cells[1]  # of B-hat, sn
    assert cell == {"text": "4.75 %", "below": "flank = 60, ratio = 1.05"}


def test_the_sentences_answer_the_question_of_the_campaign(grid):
    told_all = summary(grid, fields_of(grid), None).split("\n")
    assert told_all[0] == "21 scenes over flank = 0 ... 60 u and ratio = 1.05 ... 1.5 u: all computed."
    assert told_all[1] == "C is known to 0.2 % or better."
    assert told_all[2] == (
        "A is off by more than 5 % in sn from flank = 15.8 on at ratio = 1.05, nowhere at ratio = 1.5, at "
        "most by 19 % (in nn nowhere)."
    )
    assert told_all[3] == "B̂ is within 5 % in nn and sn everywhere."
    assert told_all[4] == "These values of flank are interpolated linearly between scenes."
    nowhere = grid.assign(error=grid.error * (grid.variant == "C"))
    assert "interpolated" not in summary(nowhere, fields_of(nowhere), None)


def test_where_nn_fails_is_told_beside_the_worst_component(curve):
    much = curve.assign(error=10 * curve.error)
    told_all = summary(much, fields_of(much), None).split("\n")
    assert told_all[2] == (
        "A is off by more than 5 % in nn from flank = 15.8 on; in sn from flank = 1.58 on, at most by 190 %."
    )


def test_values_that_are_not_in_order_are_put_in_order(grid):
    mixed = prepared(grid.isel(flank=[3, 0, 6, 1, 2, 5, 4], ratio=[2, 0, 1]))
    xr.testing.assert_identical(mixed, grid)


def test_failed_and_missing_scenes_leave_gaps_that_are_told(grid, tmp_path):
    failing = (FLANKS[:, None] > 35) & (RATIOS < 1.3)
    broken = with_failures(grid, failing)
    (field,) = fields_of(broken)
    told_all = summary(broken, [field], None)
    assert "15 computed, 6 failed." in told_all
    assert "(in nn nowhere; 15 of 21 scenes are known)" in told_all
    assert "B̂ is within 5 % in nn and sn wherever they are known (15 of 21 scenes)." in told_all
    assert "everywhere" not in told_all
    table = failure_table(broken)
    assert [row.name for row in table.rows][:2] == ["flank = 40, ratio = 1.05", "flank = 40, ratio = 1.2"]
    assert table.rows[0].cells[0]["text"] == "not converged"
    page = write_sweep(broken, tmp_path)
    assert pictures(page) == 1
    assert "Lines: 1, 2, 5 and 10 %, where most scenes are known." in page.read_text(encoding="utf-8")
    assert "not converged" in page.read_text(encoding="utf-8")


def test_of_many_failures_the_first_are_listed(samples):
    broken = with_failures(samples, np.arange(200) < 50)
    table = failure_table(broken)
    assert len(table.rows) == MOST_FAILURES + 1
    assert table.rows[-1].name == "and 30 more"


def test_text_is_told_as_categories():
    names = np.array(["steel", "bronze", "polyamide"])
    axis = ShownAxis("material", "material", names)
    assert Line(axis, {}, np.array([2.0, 0.0, 2.0])).found(1.0) == Found("at steel and polyamide")
    assert Line(axis, {}, np.array([2.0, 2.0, np.nan])).found(1.0) == Found(EVERYWHERE)
    assert Found("at steel", "ratio = 1.2").along(axis) == "at material = steel at ratio = 1.2"
    np.testing.assert_array_equal(axis.edges, [-0.5, 0.5, 1.5, 2.5])
    assert not axis.is_logarithmic


def test_values_spread_over_powers_have_a_logarithmic_axis():
    assert ShownAxis("E", "E", np.geomspace(1e3, 1e6, 7)).is_logarithmic
    assert not ShownAxis("E", "E", np.linspace(1e3, 1e6, 7)).is_logarithmic
    assert not ShownAxis("flank", "flank", FLANKS).is_logarithmic
    assert ShownAxis("P", "P", np.geomspace(1e4, 1e5, 4), "logarithmic").is_logarithmic
    np.testing.assert_allclose(ShownAxis("E", "E", np.array([1.0, 100, 10000])).edges, [0.1, 10, 1000, 1e5])


def test_rank_correlations_see_order_only(samples):
    (field,) = fields_of(samples)
    found = correlations(field, axes_of(samples)).sel({ROW: "A", COLUMN: "sn"})
    assert float(found.sel(axis="flank")) > 0.4
    assert float(found.sel(axis="ratio")) < -0.4
    same = xr.zeros_like(field.values) + samples.flank**3
    of_order = type(field)("", "error", "", "", same)
    np.testing.assert_allclose(correlations(of_order, axes_of(samples)).sel(axis="flank"), 1.0)


def test_random_points_are_told_as_shares_of_scenes(samples, tmp_path):
    over = np.mean(samples.error.sel(body="combined", variant="A", line="s = 0", i="s", j="n") > 0.05)
    assert f"in {float(over):.0%} of the scenes" in summary(samples, fields_of(samples), None)
    assert pictures(write_sweep(samples, tmp_path)) == 2  # nn and sn


def test_contacts_are_compared_with_that_by_c(curve):
    numbers = (
        np.array([1.1, 0.98, 1.0])[None, None, :] * np.array([1.0, 2.0])[None, :, None] * np.ones((7, 1, 1))
    )
    numbers[:, 1, 0] *= np.linspace(1.0, 0.7, 7)  # of the second case, by A
    by = ("flank", "case", "ics")
    kept = curve.drop_vars(["error", "vanishes"]).assign(
        p_max=(by, 100 * numbers), estimate_p_max=(by, numbers)
    )
    kept = kept.assign_coords(ics=["A", "Bhat", "C"]).assign_attrs(keep=json.dumps(["contact"]))
    off, reference = fields_of(kept)
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


def test_contacts_with_friction_have_shares_as_differences_and_name_their_reference(curve, tmp_path):
    sliding = np.array([[0.2, 0.9], [0.5, 1.0]])  # by ICs and creepage
    kept = of_friction(curve, p_max=np.array([[110.0], [100.0]]), sliding_share=sliding)
    kept = kept.assign(
        largest_of_curve=(("flank", "friction", "ics"), np.broadcast_to([0.07, 0.0], (7, 1, 2)).copy())
    )
    kept = kept.assign(estimate_p_max=xr.full_like(kept.p_max, 3.0))
    off, reference = fields_of(kept)
    assert (off.rows, off.columns) == (["A"], ["p_max", "F_x(ξ)", "sliding"])
    np.testing.assert_allclose(off.values.sel({ROW: "A"}).isel(flank=0), [0.1, 0.07, -0.3])
    assert reference.columns == ["p_max [1]", "sliding [1]"]
    np.testing.assert_allclose(reference.values.sel({COLUMN: "sliding [1]"}), 1.0)
    told_all = summary(kept, [off, reference], None).split("\n")
    assert told_all[1] == "The numbers by B̂ are known, at the worst scene, to 3 % (p_max)."
    assert told_all[2] == (
        "A is off by more than 5 % in p_max everywhere; in sliding everywhere, at most by 30 % (also in "
        "F_x(ξ))."
    )
    text = write_sweep(kept, tmp_path).read_text(encoding="utf-8")
    assert "estimate of B̂" in text
    assert "estimate of C" not in text


def test_ics_that_differ_between_scenes_are_called_by_their_places(curve):
    mixed = prepared(curve.assign_coords(variant=["variant 0", "variant 1", "variant 2"]))
    (field,) = fields_of(mixed)
    assert field.rows == ["ICs 1", "ICs 2"]
    np.testing.assert_array_equal(
        field.values.sel({ROW: "ICs 1"}), fields_of(curve)[0].values.sel({ROW: "A"})
    )
    np.testing.assert_allclose(field.floor.sel({COLUMN: "sn"}), ESTIMATE)


def test_lists_are_told_without_quotes():
    assert ShownAxis("ics", "ics", np.array(["['A', 'C']", "['C']"])).categories == ["[A, C]", "C"]


def ticks(axis):
    panel = Figure().subplots()
    axis.scale(panel, "x")
    return list(panel.xaxis.get_major_locator()())


def test_ticks_that_would_lie_on_each_other_are_left_out():
    assert ticks(ShownAxis("n", "n", np.array([0.0, 1, 2, 3, 4]))) == [0, 1, 2, 3, 4]
    assert ticks(ShownAxis("n", "n", np.linspace(0, 0.0008, 9))) == pytest.approx(
        [0, 0.0002, 0.0004, 0.0006, 0.0008]
    )
    assert ticks(ShownAxis("n", "n", np.array([1e4, 1.1e4, 5e4]))) == [1e4, 5e4]


def test_what_is_left_out_of_many_panels_is_told(samples):
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


def test_advice_is_shown_by_symbol(curve, tmp_path):
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


def test_nothing_computed_is_told(grid, tmp_path):
    empty = grid[["failure", "seconds"]].assign(seconds=grid.seconds * np.nan).assign_attrs(computed=0)
    text = write_sweep(empty, tmp_path).read_text(encoding="utf-8")
    assert "none computed, 21 not computed yet" in text
    assert "Nothing is computed yet." in text


@pytest.mark.parametrize("third", [np.arange(6.0), np.array(["steel", "bronze"])])
def test_a_third_axis_has_small_multiples_and_old_figures_go(grid, third, tmp_path):
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
