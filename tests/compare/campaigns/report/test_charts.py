"""The charts of the page of a campaign have the numbers of its dataset."""

import numpy as np
import pytest

from compare.campaigns.report.charts import BETWEEN, OTHERS, Plane, within_chart
from compare.campaigns.report.fields import COLUMN, LOWEST, ROW, find_fields, read_axes
from tests.compare.campaigns.report.datasets import (
    ESTIMATE,
    FLANKS,
    RATIOS,
    charts,
    crossing,
    error,
    keeping,
    on_three_axes,
    values_of,
    with_failures,
)
from tests.compare.pages import require_map


def curve_of(cell, label):
    """The curve with a label in a cell of a chart, and its band, if there is one."""
    (curve,) = (trace for trace in cell["traces"] if trace.get("name") == label)
    bands = [trace for trace in cell["traces"] if trace.get("fill") and trace["legendgroup"] == label]
    return curve, *bands


def test_maps_have_the_errors_of_each_ics_and_lines_where_these_cross_levels(grid):
    chart = charts(grid)["errors"]
    assert (chart["slider"], chart["labels"]) == ("ICs", ["A", "B̂"])
    assert chart["labels"][chart["start"]] == "B̂"
    for variant, (nn, sn) in zip(("A", "Bhat"), chart["steps"], strict=True):
        expected = 100 * error(variant, FLANKS[:, None], RATIOS)
        require_map(values_of(sn), expected)
        require_map(values_of(nn), expected / 10)
        np.testing.assert_allclose(sn["traces"][0]["x"], FLANKS)
        assert (
            sn["traces"][0]["hovertemplate"]
            == "flank %{x:.4~g}, ratio %{y:.4~g}: %{customdata:.4~g} %<extra></extra>"
        )
    (line,) = curve_of(chart["steps"][0][1], "5 %")
    ends = dict(zip(line["y"], line["x"], strict=True))
    at = crossing("A", 0.05, RATIOS[0])
    assert ends[RATIOS[0]] == pytest.approx(at, rel=1e-4)  # four digits of a range


@pytest.mark.parametrize(("level", "step"), [(0.01, 0), (0.05, 2), (0.1, 3)])
def test_tolerance_decides_which_ics_are_good_enough(grid, level, step):
    chart = charts(grid)["within_errors"]
    assert chart["slider"] == "tolerance"
    assert chart["labels"][step] == f"{100 * level:g} %"
    _, sn = chart["steps"][step]
    within = {v: error(v, FLANKS[:, None], RATIOS) <= level for v in ("A", "Bhat")}
    expected = np.select([within["A"], within["Bhat"]], ["A, B̂", "B̂"], "none")
    np.testing.assert_array_equal(np.array(sn["traces"][0]["text"]).T, expected)


def test_rare_combinations_of_ics_have_one_colour(grid):
    rng = np.random.default_rng(0)
    many = grid.isel(variant=[0, 0, 0, 0, 1, 1, 1, 2]).assign_coords(variant=[*"ABDEFGH", "C"])
    many = many.assign(error=(many.error.dims, rng.uniform(0, 0.1, many.error.shape)))
    (field,) = find_fields(many)
    chart = within_chart(field, Plane.from_axes(read_axes(many), many.failure != ""))
    kinds = chart.cells[0].classes
    assert OTHERS in kinds
    assert len(kinds) <= len(BETWEEN) + 2
    for cell in chart.cells:
        assert np.isfinite(cell.values).all()


def test_failed_scenes_are_marked_and_unknown(grid):
    failing = (FLANKS[:, None] > 35) & (RATIOS < 1.3)
    page = charts(with_failures(grid, failing))
    for name in ("errors", "within_errors"):
        cell = page[name]["steps"][0][1]
        np.testing.assert_array_equal(np.isnan(values_of(cell)), failing)
        (marks,) = curve_of(cell, "failed")
        assert set(zip(marks["x"], marks["y"], strict=True)) == {
            (FLANKS[k], RATIOS[m]) for k, m in np.argwhere(failing)
        }


@pytest.mark.parametrize("third", [np.arange(6.0), np.array(["steel", "bronze"])])
def test_a_slider_moves_along_the_third_axis_and_begins_with_the_worst(grid, third):
    page = charts(on_three_axes(grid, third))
    closest, other = (page[f"errors_by_third_{k}"] for k in (0, 1))
    assert closest["labels"][0] == "the largest error"
    assert closest["start"] == 0
    factors = 1 + np.arange(len(third))
    for chart, variant in ((closest, "Bhat"), (other, "A")):
        of_first = 100 * error(variant, FLANKS[:, None], RATIOS)
        for factor, (_, sn) in zip([factors[-1], *factors], chart["steps"], strict=True):
            require_map(values_of(sn), factor * of_first)


def test_curves_have_the_errors_and_their_estimates(curve):
    gap = np.arange(7) == 3
    chart = charts(with_failures(curve, gap))["errors"]
    _, sn = chart["steps"][0]
    of_a, band = curve_of(sn, "A")
    known, expected = FLANKS[~gap], np.maximum(100 * error("A", FLANKS[~gap]), 100 * LOWEST)
    np.testing.assert_allclose(of_a["x"], known)
    np.testing.assert_allclose(of_a["y"], expected, rtol=1e-5)
    below = np.maximum(expected - 100 * ESTIMATE, 100 * LOWEST)
    np.testing.assert_allclose(band["y"], [*(expected + 100 * ESTIMATE), *below[::-1]], rtol=1e-4)
    assert [shape["y0"] for shape in sn["layout"]["shapes"]] == [1, 2, 5, 10]


def test_places_along_an_axis_of_text_are_named(curve):
    names = np.array(["steel", "bronze", "polyamide"])
    of_text = curve.isel(flank=slice(3)).assign_coords(flank=names)
    _, sn = charts(of_text)["errors"]["steps"][0]
    assert sn["layout"]["xaxis"]["ticktext"] == list(names)
    assert curve_of(sn, "A")[0]["mode"] == "markers"


def test_random_points_are_drawn_over_each_axis_by_component(samples):
    chart = charts(samples)["errors"]
    assert (chart["slider"], chart["labels"]) == ("component", ["nn", "sn"])
    (field,) = find_fields(samples)
    expected = 100 * np.maximum(field.values.sel({ROW: "Bhat", COLUMN: "sn"}), LOWEST)
    for cell, axis in zip(chart["steps"][1], ("flank", "ratio"), strict=True):
        (points,) = curve_of(cell, "B̂")
        assert points["mode"] == "markers"
        np.testing.assert_allclose(
            points["x"], samples[axis], atol=1e-4 * float(np.ptp(samples[axis].values))
        )
        np.testing.assert_allclose(points["y"], expected, rtol=1e-5)


def test_deviations_have_symmetric_colours_and_values_their_units(grid):
    p_max = 800 - FLANKS[:, None, None] + 0 * RATIOS[:, None] + np.array([80.0, -8.0, 0.0])
    values = {"p_max": (("flank", "ratio", "ics"), p_max, {"units": "MPa"})}
    page = charts(keeping(grid, "contact", values, ics=["A", "Bhat", "C"]))
    (of_a,), (of_bhat,) = page["contact"]["steps"]
    reference = p_max[..., 2]
    require_map(values_of(of_a), 8000 / reference)
    require_map(values_of(of_bhat), -800 / reference)
    for cell in (of_a, of_bhat):
        largest = pytest.approx(float(np.max(8000 / reference)))
        assert (-cell["traces"][0]["zmin"], cell["traces"][0]["zmax"]) == (largest, largest)
    ((with_c,),) = page["reference"]["steps"]
    require_map(values_of(with_c), reference)
    assert with_c["title"] == "p_max [MPa]"
    assert with_c["traces"][0]["hovertemplate"].endswith("%{z:.4~g} MPa<extra></extra>")


def test_a_number_that_is_not_known_anywhere_has_an_empty_map(grid):
    known = {"p_max": 3.0, "b": np.nan}
    values = {name: (("flank", "ratio", "ics"), np.full((7, 3, 2), value)) for name, value in known.items()}
    page = charts(keeping(grid, "contact", values, ics=["A", "C"]))
    for name in ("contact", "reference"):
        known, unknown = page[name]["steps"][0]
        assert np.isfinite(values_of(known)).all()
        assert np.isnan(values_of(unknown)).all()
