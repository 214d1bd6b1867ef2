"""The drawer of curves: what it draws of a panel, in which order, and how what is new looks."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from approx.variants import VARIANTS
from compare.report import panels, styles
from compare.report.panels import CHECK_MARKS, Panel, draw, finish, panel_figure, styles_of
from compare.report.styles import COLOURS, DASHES, MARKERS, STYLES, SYMBOLS, with_further

AT = np.linspace(0.0, 2.0, 101)
CURVES = {"A": 1 - AT, "C": np.exp(-AT), "B̂": 2 * np.exp(-AT)}


def axes_of(panel):
    axes = Figure().subplots()
    draw(axes, panel, styles_of([panel]))
    return axes


def lines(axes):
    return {line.get_label(): line for line in axes.get_lines()}


def test_each_curve_is_drawn_over_the_abscissas_in_the_style_of_its_variant():
    drawn_lines = lines(axes_of(Panel("", "", AT, "", CURVES)))
    assert set(drawn_lines) == set(CURVES)
    for symbol, name in (("A", "A"), ("C", "C"), ("B̂", "Bhat")):
        np.testing.assert_array_equal(drawn_lines[symbol].get_xdata(), AT)
        np.testing.assert_array_equal(drawn_lines[symbol].get_ydata(), CURVES[symbol])
        assert drawn_lines[symbol].get_color() == STYLES[name]["color"]


def test_the_estimate_is_a_band_of_its_size_around_c():
    estimate = 0.1 * AT
    (band,) = axes_of(Panel("", "", AT, "", CURVES, estimate)).collections
    (path,) = band.get_paths()
    corners = path.vertices
    for k in (20, 70):
        at_k = corners[np.isclose(corners[:, 0], AT[k]), 1]
        assert np.min(at_k) == pytest.approx(CURVES["C"][k] - estimate[k])
        assert np.max(at_k) == pytest.approx(CURVES["C"][k] + estimate[k])


def test_curves_of_nan_are_not_drawn():
    assert set(lines(axes_of(Panel("", "", AT, "", CURVES | {"B̂′": np.full_like(AT, np.nan)})))) == set(
        CURVES
    )


@pytest.mark.parametrize("known", [None, 0.2 + 0 * AT])
def test_c_of_the_other_engine_is_marks_with_bars_of_its_estimate(known):
    other = SYMBOLS["C_solid"]
    axes = axes_of(Panel("", "", AT, "", {other: AT**2}, check_estimate=known))
    marks = axes.get_lines()[0]
    assert marks.get_linestyle() == "None"
    assert CHECK_MARKS <= len(marks.get_xdata()) < 2 * CHECK_MARKS
    np.testing.assert_allclose(marks.get_ydata(), marks.get_xdata() ** 2)
    bars = [segment for bar in axes.collections for segment in bar.get_segments()]
    assert all(np.ptp(segment[:, 1]) == pytest.approx(0.4) for segment in bars)
    assert bool(bars) == (known is not None)


def test_part_of_a_panel_selects_the_same_points_of_all_curves():
    panel = Panel("", "", AT, "", CURVES, 0.1 * AT, 0.2 * AT).beyond(1.0)
    assert panel.at[0] == 1.0
    for values in (*panel.curves.values(), panel.estimate, panel.check_estimate):
        assert len(values) == len(panel.at) == 51
    np.testing.assert_array_equal(panel.curves["A"], 1 - panel.at)


def test_curves_of_rounding_errors_are_shown_as_zero():
    panel = Panel("", "", AT, "", {"C": 1e-17 * np.sin(AT)})
    axes = axes_of(panel)
    finish(axes, panel)
    assert axes.get_ylim() == (-1e-3, 1e-3)
    small = Panel("", "", AT, "", {"C": 1e-6 * np.sin(AT)})
    axes = axes_of(small)
    finish(axes, small)
    assert axes.get_ylim()[1] < 1e-5


def test_joints_are_marked_and_axes_have_the_labels_of_the_panel():
    panel = Panel("a title", "s / L  [-]", AT, "sn  [-]", CURVES, marks=(0.5, 1.5))
    axes = axes_of(panel)
    finish(axes, panel)
    assert [line.get_xdata()[0] for line in axes.get_lines() if line.get_label() == "_joint"] == [0.5, 1.5]
    assert (axes.get_title(), axes.get_xlabel(), axes.get_ylabel()) == ("a title", "s / L  [-]", "sn  [-]")


def test_figure_has_axes_for_each_panel_and_one_legend():
    of_panels = [Panel(f"{k}", "", AT, "", {name: CURVES[name]}) for k, name in enumerate("CAC")]
    figure = panel_figure(of_panels, columns=2)
    assert [axes.get_title() for axes in figure.axes] == ["0", "1", "2"]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["C", "A"]


def test_further_curves_have_different_styles():
    names = [f"a curve {k}" for k in range(len(panels.FURTHER))]
    given = styles_of([Panel("", "", AT, "", dict.fromkeys(names, AT))])
    assert len({str(given[name]) for name in names}) == len(names)


# --- looks ------------------------------------------------------------------------------------------------


def test_each_variant_has_a_unique_symbol_style_and_marker():
    for name in (*VARIANTS, "C", "C_solid"):
        assert SYMBOLS[name]
        assert mpl.colors.is_color_like(STYLES[name]["color"])
    assert len(set(MARKERS.values())) == len(MARKERS)
    assert len({str(style) for style in STYLES.values()}) == len(STYLES)
    assert list(STYLES)[-1] == "C"  # behind all others


def test_new_variants_have_unique_looks():
    looks = with_further([*VARIANTS, "Btilde", "Bcheck"])
    markers, of_lines = zip(*looks.values(), strict=True)
    assert len(set(markers)) == len(markers)
    assert len({str(style) for style in of_lines}) == len(of_lines)
    assert {"Btilde", "Bcheck", *VARIANTS} <= set(looks)


def test_overlays_have_a_colour_for_each_line_style():
    assert len(set(map(str, DASHES))) == len(DASHES) == len(COLOURS)


def test_a_saved_figure_is_a_picture(tmp_path):
    path = styles.save(panel_figure([Panel("", "", AT, "", CURVES)], 1), tmp_path / "one.png")
    assert path.read_bytes().startswith(b"\x89PNG")
