"""Charts as data, as JSON for pages, and as pictures for paper."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from compare.report import interactive, static
from compare.report.charts import (
    MARKS,
    MOST_MARKERS,
    Chart,
    Contours,
    Curve,
    Map,
    Panel,
    Surface,
    make_curves,
    mark_points,
    simple_chart,
)
from compare.report.looks import FURTHER, INK, OWN, Look, drawing_order, ics_looks, ics_symbol, label_looks
from compare.report.static import lay_out
from tests.compare.pages import read_chart

X = np.linspace(0.0, 2.0, 5)
KNOWN = X[[0, 1, 3, 4]]
LOOKS = ics_looks(["A", "C"])


def curves(factor=1.0):
    return [
        Curve("C", X, factor * X, LOOKS["C"], band=0.1 * np.ones(5)),
        Curve("A", X, factor * X**2, LOOKS["A"]),
    ]


@pytest.fixture
def chart():
    steps = {f"{k} kN": [Panel("upper", "s [mm]", "p [MPa]", curves(k))] for k in (1, 2)}
    return Chart("pressures", steps, slider="load")


def traces(chart, step, cell=0):
    return read_chart(chart)["steps"][step][cell]["traces"]


def drawn_cell(cell):
    """A cell as JSON, and its axes on paper."""
    chart = simple_chart("one", [cell])
    (content,) = read_chart(chart)["steps"][0]
    return content, static.picture(chart).axes[0]


def test_values_on_the_page_are_those_of_the_curves(chart):
    for step, factor in enumerate((1, 2)):
        drawn = {trace["name"]: trace for trace in traces(chart, step) if "name" in trace}
        np.testing.assert_allclose(drawn["C"]["y"], factor * X, rtol=1e-5)
        np.testing.assert_allclose(drawn["A"]["y"], factor * X**2, rtol=1e-5)
        np.testing.assert_allclose(drawn["A"]["x"], X, rtol=1e-5)


@pytest.mark.parametrize(
    ("band", "x", "above", "below"),
    [
        (0.1 * np.ones(5), X, 0.1 + X, X - 0.1),
        (np.array([0.1 * np.ones(5), 0.3 * X]), X, 1.3 * X, X - 0.1),  # less far below than above
        (np.array([0.1, 0.1, np.nan, 0.1, 0.1]), KNOWN, KNOWN + 0.1, KNOWN - 0.1),
    ],
)
def test_a_band_goes_from_above_to_below_the_curve_where_it_is_known(band, x, above, below):
    content, axes = drawn_cell(Panel("", "", "", [Curve("C", X, X, LOOKS["C"], band)]))
    (drawn,) = (trace for trace in content["traces"] if trace.get("fill"))
    np.testing.assert_allclose(drawn["x"], [*x, *x[::-1]], rtol=1e-5)
    np.testing.assert_allclose(drawn["y"], [*above, *below[::-1]], rtol=1e-5)
    assert drawn["legendgroup"] == "C"
    (on_paper,) = axes.collections
    low, high = on_paper.get_datalim(axes.transData).intervaly
    assert (low, high) == pytest.approx((below[0], above[-1]))


def test_each_label_is_once_in_the_legend_and_the_slider_begins_with_the_last_step_or_the_one_named(chart):
    content = read_chart(chart)
    legend = [(entry["label"], entry["colour"]) for entry in content["legend"]]
    assert legend == [("C", INK), ("A", OWN["A"].colour)]
    assert content["start"] == 1
    assert Chart("", chart.steps, start="1 kN").first == 0


def test_curves_of_few_points_and_their_legend_have_markers():
    x = np.arange(MOST_MARKERS + 1)
    for points, marker in ((x[1:], LOOKS["A"].marker), (x, "")):
        chart = simple_chart("", [Panel("", "", "", [Curve("A", points, points, LOOKS["A"])])])
        assert chart.legend["A"].marker == marker


def test_pages_can_draw_every_marker_in_their_legends():
    script = (Path(interactive.__file__).parent / "templates" / "explore.js").read_text(encoding="utf-8")
    outlines = script.partition("const outlines = {")[2].partition("};")[0]
    looks = {look.marker.removesuffix("-open") for look in (*OWN.values(), *FURTHER)} - {""}
    assert set(re.findall(r'"([a-z-]+)": corners', outlines)) == looks | set(static.MARKERS) - {""}
    # no two alike
    assert len(re.findall(r"corners\([^)]*\)", outlines)) == len(
        set(re.findall(r"corners\([^)]*\)", outlines))
    )


@pytest.mark.parametrize(
    ("y", "apart"),
    [
        *(([1e-3, 10.0 ** (decades - 3)], apart) for decades, apart in ((2, 1), (8, 1), (9, 2), (17, 3))),
        ([1e-3, 0.2], 1),
        ([0.078, 0.089], None),
        ([0.02, 0.5], None),
    ],
)
def test_powers_of_ten_are_labelled_as_far_as_there_is_room_and_more(y, apart):
    """Not each of many decades; within a decade, also numbers between."""
    content, _ = drawn_cell(Panel("", "time [s]", "error [-]", [Curve("A", [1.0, 2.0], y)], log_y=True))
    assert content["layout"]["yaxis"].get("dtick") == apart


def test_nan_is_a_gap_and_the_json_can_stand_in_a_script_element():
    panel = Panel("</script>", "", "", [Curve("A", X, np.where(X > 1, np.nan, X))])
    text = interactive.as_json(simple_chart("gaps", [panel]))
    assert "</script>" not in text
    assert json.loads(text)["steps"][0][0]["traces"][0]["y"][-1] is None


@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_long_curves_are_as_close_as_a_tenth_of_a_pixel_also_far_from_zero(offset):
    """A panel has some 250 pixels; ordinates far from zero must not become steps."""
    x = np.linspace(0.0, 3.0, 401)
    content, _ = drawn_cell(Panel("", "", "", [Curve("A", x, offset + 0.01 * np.sin(x))]))
    y = np.array(content["traces"][0]["y"])
    assert np.max(np.abs(y - offset - 0.01 * np.sin(x))) < 0.1 * 0.01 / 250
    if not offset:
        assert max(len(str(v)) for v in y) <= len("0.0012345")


def test_arrays_that_occur_several_times_are_on_the_page_once(chart):
    content = json.loads(interactive.as_json(chart))
    assert content["arrays"] == [X.tolist(), [*X, *X[::-1]]][::-1]
    drawn = read_chart(chart)
    for step, cells in enumerate(interactive.content(chart)["steps"]):
        for cell, expected in zip(drawn["steps"][step], cells, strict=True):
            assert cell["traces"] == expected["traces"]


@pytest.mark.parametrize(("largest", "vanishes"), [(1e-12, True), (1e-3, False)])
def test_rounding_is_shown_as_zero(largest, vanishes):
    panel = Panel("", "", "", [Curve("A", X, largest * X / 2)], least=1e-9)
    content, axes = drawn_cell(panel)
    assert ("annotations" in content["layout"]) is vanishes
    assert (axes.get_ylim() == (-1e-9, 1e-9)) is vanishes


def test_maps_have_rows_along_y_and_kinds_have_names_and_perhaps_their_own_colours():
    values = np.arange(6.0).reshape(3, 2)
    content, _ = drawn_cell(Map("", "x [mm]", "s [mm]", np.arange(3.0), np.arange(2.0), values, "MPa"))
    (trace,) = content["traces"]
    np.testing.assert_array_equal(trace["z"], values.T)
    assert (trace["zmin"], trace["zmax"]) == (0.0, 5.0)
    colours = tuple(f"#0000{k}0" for k in range(6))
    kinds = {"classes": tuple("abcdef"), "colours": colours}
    content, axes = drawn_cell(Map("", "x", "s", np.arange(3.0), np.arange(2.0), values, "", **kinds))
    (trace,) = content["traces"]
    assert trace["kinds"] == list("abcdef")
    assert trace["z"] == [[0, 2, 4], [1, 3, 5]]
    assert [colour for _, colour in trace["colorscale"]] == list(np.repeat(colours, 2))
    (mesh,) = axes.collections
    np.testing.assert_allclose(mesh.cmap(mesh.norm(5.0))[:3], (0.0, 0.0, 0x50 / 255))


def test_a_positive_map_has_the_colours_of_logarithms_and_the_numbers_in_its_read_out():
    values = np.array([[0.0, 0.1], [1.0, 500.0]])
    drawn = Map("", "x", "s", np.arange(2.0), np.arange(2.0), values, "%", "positive", (0.1, 100.0))
    content, axes = drawn_cell(drawn)
    (trace,) = content["traces"]
    np.testing.assert_allclose(trace["z"], np.array([[-1.0, -1.0], [0.0, np.log10(500)]]).T, atol=1e-3)
    np.testing.assert_allclose(trace["customdata"], values.T)
    assert (trace["zmin"], trace["zmax"]) == (-1.0, 2.0)
    assert trace["colorbar"]["ticktext"] == ["0.1", "1", "10", "100"]
    (mesh,) = axes.collections
    assert mesh.norm(10**0.5) == pytest.approx(0.5)
    np.testing.assert_array_equal(mesh.to_rgba(mesh.get_array())[0, 0], mesh.cmap(0.0))  # of 0 %


def test_places_without_numbers_have_names():
    names = ("steel", "bronze")
    panel = Panel("", "material", "ICs", [Curve("", [0, 1], [1, 0])], names_x=names, names_y=("A", "B"))
    drawn = Map("", "material", "x", np.arange(2.0), X, np.ones((2, 5)), "%", names_x=names)
    for cell in (panel, drawn):
        content, axes = drawn_cell(cell)
        axis = content["layout"]["xaxis"]
        assert dict(zip(axis["tickvals"], axis["ticktext"], strict=True)) == dict(enumerate(names))
        assert [text.get_text() for text in axes.get_xticklabels()] == list(names)
    assert "material %{x}, x %{y:.4~g}" in content["traces"][0]["hovertemplate"]
    assert drawn_cell(panel)[0]["layout"]["yaxis"]["ticktext"] == ["A", "B"]


def test_levels_are_dotted_across():
    content, axes = drawn_cell(Panel("", "s", "p", curves(), marks=[0.5], levels=[2.0]))
    across, upwards = (
        {key: shape[key] for key in ("x0", "x1", "y0", "y1")} for shape in content["layout"]["shapes"]
    )
    assert across == {"x0": 0.5, "x1": 0.5, "y0": 0, "y1": 1}
    assert upwards == {"x0": 0, "x1": 1, "y0": 2.0, "y1": 2.0}
    assert list(axes.get_lines()[-1].get_ydata()) == [2.0, 2.0]


def test_cells_of_a_logarithmic_axis_end_half_way_by_ratio():
    powers = np.array([1.0, 100.0, 10000.0])
    content, axes = drawn_cell(Map("", "E", "x", powers, X, np.ones((3, 5)), "%", log_x=True))
    assert content["layout"]["xaxis"]["type"] == "log"
    assert "type" not in content["layout"]["yaxis"]
    corners = axes.collections[0].get_coordinates()  # (n_y + 1, n_x + 1, 2)
    np.testing.assert_allclose(corners[0, :, 0], [0.1, 10, 1000, 1e5])
    np.testing.assert_allclose(corners[:, 0, 1], [-0.25, 0.25, 0.75, 1.25, 1.75, 2.25])


def test_paper_shows_all_steps_side_by_side(chart):
    figure = static.picture(chart)
    assert [axes.get_title() for axes in figure.axes] == ["1 kN, upper", "2 kN, upper"]
    for axes, factor in zip(figure.axes, (1, 2), strict=True):
        np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), factor * X)


LONG = "nn, combined, between the lower and the upper body: minus C"


@pytest.mark.parametrize(
    ("entries", "log_y", "title", "size"),
    [
        (1, False, "the title", 1.234e-3),
        *((entries, log_y, LONG, 1.234e-7) for entries, log_y in ((12, False), (12, True), (1, True))),
    ],
)
def test_nothing_overlaps_around_panels_on_paper(entries, log_y, size, title):
    """Titles, numbers, names of axes and the legend; measured, as it is not where panels are drawn."""
    values = -size * np.linspace(0.1, 1.0, 5)
    ordinates = np.abs(values) if log_y else values
    drawn = [Curve(f"ICs {k}\nand more", values, (k + 1) * ordinates) for k in range(entries)]
    panel = Panel(title, "x [mm]", "pressure [MPa]", drawn, log_y=log_y)
    chart = Chart("curves", {"one": [panel] * 3, "two": [panel] * 3}, 3, heights=0.8)
    figure = static.picture(chart)
    lay_out(figure, chart)
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = [axes.get_tightbbox(renderer) for axes in figure.axes]
    boxes += [legend.get_window_extent(renderer) for legend in figure.legends]
    assert len(boxes) == 7
    for k, box in enumerate(boxes):
        assert np.all(figure.bbox.p0 <= box.p0)
        assert np.all(box.p1 <= figure.bbox.p1)
        assert not any(box.overlaps(other) for other in boxes[:k])
    for axes in figure.axes:
        scale = axes.yaxis.get_offset_text()
        assert bool(scale.get_text()) == (size < 1e-5 and not log_y)
        assert not scale.get_window_extent(renderer).overlaps(axes.title.get_window_extent(renderer))


@pytest.mark.parametrize("largest", [0.012, 3.7, 9.9, 51234.0])
def test_numbers_of_colours_do_not_overlap_on_paper(largest):
    values = np.linspace(-largest, largest, 25).reshape(5, 5)
    drawn = Map("", "x [mm]", "y [mm]", X, X, values, "C [mm/N]", "logarithmic")
    figure = static.picture(simple_chart("map", [drawn]))
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    bar = figure.axes[-1].yaxis
    boxes = [label.get_window_extent(renderer) for label in bar.get_ticklabels()]
    assert len(boxes) in (5, 7)  # 0, and two or three decades of each sign
    assert not any(box.overlaps(other) for k, box in enumerate(boxes) for other in boxes[:k])


def test_steps_of_several_rows_have_a_picture_each_on_paper_with_names_of_their_own(chart):
    assert list(static.pictures(chart)) == ["pressures"]
    tall = Chart("tall", {step: 2 * list(cells) for step, cells in chart.steps.items()}, columns=1)
    figures = static.pictures(tall)
    assert list(figures) == ["tall_1kN", "tall_2kN"]
    for figure, factor in zip(figures.values(), (1, 2), strict=True):
        np.testing.assert_allclose([a.get_lines()[0].get_ydata() for a in figure.axes], [factor * X] * 2)
    steps = {step: 2 * [Panel("", "x", "y", [])] for step in ("B", "B̂", "A")}  # a hat is no letter of a name
    assert list(static.pictures(Chart("ics", steps, columns=1))) == ["ics_B_1", "ics_B_2", "ics_A"]


def test_open_markers_are_drawn_open_on_paper():
    filled, hollow = (static.line_style(Look("#123456", "", marker)) for marker in ("square", "square-open"))
    assert filled["marker"] == hollow["marker"] == "s"
    assert "markerfacecolor" not in filled
    assert hollow["markerfacecolor"] == "white"


def test_looks_differ_and_those_listed_first_lie_on_top():
    names = ["A", "B", "Bhat", "mine", "C", "yours"]
    looks = ics_looks(names)
    assert len(set(looks.values())) == len(names)
    order = drawing_order(names)
    assert order.index("C") < order.index("Bhat") < order.index("A")
    assert set(order[-2:]) == {"mine", "yours"}


def test_labels_have_the_looks_of_their_ics_and_are_broken_where_more_is_said():
    assert label_looks(map(ics_symbol, OWN)) == {ics_symbol(name): look for name, look in OWN.items()}
    looks = label_looks(["B̂", "B̂, not revolved", "C before the discount", "p_max", "Bold"])
    for label, name, dash in (("B̂, not revolved", "Bhat", "dashdot"), ("C before the discount", "C", "dot")):
        assert (looks[label].colour, looks[label].dash) == (OWN[name].colour, dash)
    assert (looks["p_max"], looks["Bold"]) == FURTHER[:2]
    assert len(set(looks.values())) == len(looks)


def test_curves_by_labels_have_the_estimate_at_c_and_leave_out_what_was_not_computed():
    drawn = make_curves(X, {"A": X**2, "C": X, "B̂′": np.full(5, np.nan)}, 0.1 * X)
    assert {curve.label: curve.look for curve in drawn} == {name: OWN[name] for name in ("A", "C")}
    for curve, values, band in zip(drawn, (X**2, X), (None, 0.1 * X), strict=True):
        np.testing.assert_array_equal(curve.points, [X, values])
        np.testing.assert_array_equal(curve.band, band)


@pytest.mark.parametrize("band", [None, np.arange(100.0), np.arange(200.0).reshape(2, 100)])
def test_marks_without_a_line_are_few(band):
    x = np.arange(100.0)
    few = mark_points(Curve("FE", x, x**2, OWN["FE"], band))
    assert MARKS <= len(few.x) < 2 * MARKS
    np.testing.assert_array_equal(few.y, few.x**2)
    if band is not None:
        np.testing.assert_array_equal(few.band, band[..., few.x.astype(int)])
    for curve in (Curve("C", x, x, OWN["C"]), Curve("FE", X, X, OWN["FE"])):
        assert mark_points(curve) is curve


def test_colours_of_differences_are_symmetric_and_red_where_positive_on_pages_as_on_paper():
    """Plotly's scale and Matplotlib's have the same name, and opposite directions."""
    drawn = Map("", "x", "s", X, X, -np.outer(X, X), "MPa", "diverging")
    assert drawn.range == (-4.0, 4.0)
    (trace,) = drawn_cell(drawn)[0]["traces"]
    assert trace["colorscale"] == "RdBu"
    assert not trace.get("reversescale")
    red, _, blue, _ = static.mpl.colormaps[static.COLOURS["diverging"]](1.0)
    assert red > blue


def raised(title, factor):
    x, s = np.meshgrid(X, X, indexing="ij")
    body = np.array([x, s, 0 * x])
    return Surface(title, body, body + 0.1, np.where(x > 0, factor * x, np.nan), "MPa")


def test_surfaces_are_drawn_in_3d_on_paper_and_seen_from_further_if_long():
    figure = static.picture(simple_chart("rail", [raised("C", 2.0)]))
    assert [axes.name for axes in figure.axes if axes.get_title()] == ["3d"]
    eyes = []
    for length in (1.0, 16.0):
        surface = raised("C", 2.0)
        surface.body[0] *= length
        cell, _ = drawn_cell(surface)
        eyes.append(cell["layout"]["scene"]["camera"]["eye"]["x"])
    assert eyes[1] < eyes[0] < 0
    ticks = {name: cell["layout"]["scene"][f"{name}axis"]["nticks"] for name in "xyz"}
    assert ticks == {"x": 8, "y": 2, "z": 2}  # labels of short axes of a long body would overlap


def test_cells_to_choose_from_are_all_on_the_page_and_the_first_is_on_paper():
    steps = {f"{k} kN": [raised("C", k), raised("A", 2 * k)] for k in (1, 2)}
    chart = Chart("rail", steps, 1, "load", choice="ICs")
    content = read_chart(chart)
    assert content["choice"] == "ICs"
    assert [[cell["title"] for cell in cells] for cells in content["steps"]] == [["C", "A"]] * 2
    ((name, figure),) = static.pictures(chart).items()
    assert name == "rail"
    assert [axes.get_title() for axes in figure.axes if axes.get_title()] == ["1 kN, C", "2 kN, C"]


def test_points_have_bars_names_and_notes():
    """On the page and on paper; a band of bars is no area."""
    bars = np.array([0.1 * np.ones(2), 0.3 * np.ones(2)])
    points = Curve("C", X[:2], X[:2], LOOKS["C"], bars, bars=True, names=("a", "b"), notes=("one", "two"))
    content, axes = drawn_cell(Panel("", "", "", [points]))
    (trace,) = content["traces"]
    np.testing.assert_allclose([trace["error_y"][key] for key in ("arrayminus", "array")], bars)
    assert (trace["text"], trace["customdata"]) == (["a", "b"], ["one", "two"])
    assert "text" in trace["mode"]
    assert "%{customdata}" in trace["hovertemplate"]
    assert content["layout"]["hovermode"] == "closest"
    assert [text.get_text() for text in axes.texts] == ["a", "b"]
    heights = [np.ptp(line[:, 1]) for line in axes.collections[0].get_segments()]
    np.testing.assert_allclose(heights, 0.4)


# --- contours -------------------------------------------------------------------------------------------


def cone(n=41):
    """The distance from the middle of a square of size 2, on a lattice in polar coordinates with a hole."""
    radius, angle = np.meshgrid(np.linspace(0.2, 1.0, n), np.linspace(0.0, 2 * np.pi, 4 * n), indexing="ij")
    return radius * np.array([np.cos(angle), np.sin(angle)]), radius


def filled(trace):
    """The area of the polygons of a trace; those that run the other way are holes."""
    x, y = (np.array([np.nan if v is None else v for v in trace[axis]]) for axis in "xy")
    ends = np.flatnonzero(np.isnan(x))
    parts = [slice(first, last) for first, last in zip([0, *(ends[:-1] + 1)], ends, strict=True)]
    return abs(sum(np.sum(x[p][:-1] * y[p][1:] - x[p][1:] * y[p][:-1]) / 2 for p in parts))


def test_each_level_is_painted_where_values_exceed_it():
    contours = Contours("", "y [mm]", "z [mm]", [cone()], "MPa", limits=(0.0, 1.0))
    content, _ = drawn_cell(contours)
    *painted, readings = content["traces"]
    levels = contours.levels
    np.testing.assert_allclose(np.diff(levels), levels[1] - levels[0])
    inside = [max(level, 0.2) for level in levels[:-1]]
    expected = [np.pi * (1 - low**2) for low in inside]
    assert [filled(trace) for trace in painted] == pytest.approx(expected, rel=0.01)
    assert [trace["fillcolor"] for trace in painted] == contours.colours
    assert readings["marker"]["cmin"] == levels[0]
    assert readings["marker"]["cmax"] == levels[-1]


def test_what_is_read_are_the_values_at_the_points():
    (points, values) = cone(9)
    values = np.where(points[0] > 0.9, np.nan, values)
    content, axes = drawn_cell(Contours("", "y [mm]", "z [mm]", [(points, values)], "MPa", stride=4))
    readings, seen = content["traces"][-1], values[::4, ::4]
    assert readings["marker"]["color"] == pytest.approx(seen[np.isfinite(seen)], rel=1e-5)
    at = np.hypot(readings["x"], readings["y"])
    np.testing.assert_allclose(at, readings["marker"]["color"], atol=2e-3)
    assert axes.get_aspect() == 1.0


def test_differences_have_the_same_colours_on_both_sides():
    points, values = cone(9)
    contours = Contours("", "", "", [(points, values - 0.4)], "MPa", scale="diverging")
    np.testing.assert_allclose(contours.levels, -contours.levels[::-1], atol=1e-12)
    assert contours.levels[-1] >= 0.6
