"""Pages in a real browser: charts that are explored, nothing that overflows, paper."""

import json

import numpy as np
import pytest

from compare.report.charts import Chart, Curve, Map, Panel, Surface
from compare.report.looks import ics_looks
from compare.report.parts import Folded, Page, Section, write_page
from compare.report.tables import Cell, Row, Table, numbers

pytestmark = pytest.mark.slow
HARMLESS = ("willReadFrequently", "GPU stall")  # what a browser says about its own speed
X = np.linspace(0.0, 3.0, 7)
LOOKS = ics_looks(["A", "C"])


@pytest.fixture
def opened(browser, page_file):
    """The page at 1280 px, and what the browser's console says."""
    tab, messages = browser.new_page(viewport={"width": 1280, "height": 900}), []
    tab.on("console", lambda said: messages.append(said.text) if said.type in ("error", "warning") else None)
    tab.on("pageerror", lambda error: messages.append(str(error)))
    tab.goto(page_file.as_uri())
    tab.wait_for_selector("html[data-explore=ready]")
    yield tab, messages
    tab.close()


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    """A page with all kinds of charts, and a table that is wider than any screen."""
    folder = tmp_path_factory.mktemp("page")
    steps = {}
    for load in (1, 2, 3):
        curves = [Curve("C", X, load * X, LOOKS["C"], band=0.1), Curve("A", X, load * X**2, LOOKS["A"])]
        pressures = Map("", "x [mm]", "s [mm]", X, X, load * np.outer(X, X), "MPa", to_scale=True)
        steps[f"{load} kN"] = [Panel("upper", "s [mm]", "p [MPa]", curves), pressures]
    x, s = np.meshgrid(X, X, indexing="ij")
    rail = np.array([x, s, -(s**2)])
    (folder / "rail.png").write_bytes(PIXEL)
    surface = Surface("rail", rail, rail + 0.1, x, "MPa", folder / "rail.png")
    other = Surface("other", rail, rail + 0.1, 2 * x, "MPa")
    charts = [
        Chart("curves", steps, 2, "load", alt="curves of two kinds"),
        Chart("again", steps, 2, "load"),
        Chart("rail", {"": [surface, other]}, 1, choice="ICs"),
    ]
    folded = Chart("folded", steps, 2)
    wide = Table("wide", numbers(*(f"a number {k}" for k in range(30))), [Row("", [Cell(1.0, ".6f")] * 30)])
    return write_page(
        Page("All kinds", "A sentence.", [Section("Charts", [*charts, wide]), Folded("more", [folded])]),
        folder / "all.html",
    )


PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de0000000c4944415408d763f8ffff3f0005fe02fe"
    "dccc59e70000000049454e44ae426082"
)


def drawn(tab, chart, cell=0):
    """The traces that Plotly has in a cell of a chart, once it is in view."""
    tab.locator(f"#chart-{chart}").scroll_into_view_if_needed()
    place = f"#chart-{chart} .cells > div:nth-child({cell + 1}) .js-plotly-plot"
    tab.wait_for_selector(place)
    return tab.evaluate(f"document.querySelector({json.dumps(place)}).data")


def test_the_console_says_nothing(opened):
    tab, messages = opened
    for chart in ("curves", "again", "rail"):
        assert drawn(tab, chart)
    assert not [text for text in messages if not any(word in text for word in HARMLESS)]


def test_values_in_the_browser_are_those_given(opened):
    tab, _ = opened
    curves = {trace.get("name"): trace for trace in drawn(tab, "curves")}
    np.testing.assert_allclose(curves["A"]["y"], 3 * X**2, rtol=1e-5)


def test_a_label_is_hidden_and_shown_on_the_whole_page(opened):
    tab, _ = opened
    button = tab.locator("#chart-curves .legend button", has_text="A")
    for pressed, visible in (("false", False), ("true", True)):
        button.focus()
        tab.keyboard.press("Enter")
        assert button.get_attribute("aria-pressed") == pressed
        for chart in ("curves", "again"):
            (curve,) = (trace for trace in drawn(tab, chart) if trace.get("name") == "A")
            assert (curve.get("visible", True) is not False) is visible


def test_sliders_of_one_name_move_together_and_by_keys(opened):
    tab, _ = opened
    tab.locator("#chart-curves input[type=range]").press("ArrowLeft")
    for chart in ("curves", "again"):
        assert tab.locator(f"#chart-{chart} output").inner_text() == "2 kN"
        (curve,) = (trace for trace in drawn(tab, chart) if trace.get("name") == "A")
        np.testing.assert_allclose(curve["y"], 2 * X**2, rtol=1e-5)


def test_one_cell_is_chosen_by_its_title(opened):
    tab, _ = opened
    assert np.max(drawn(tab, "rail")[1]["surfacecolor"]) == 3.0
    tab.locator("#chart-rail select").select_option("other")
    assert tab.locator("#chart-rail .title").all_inner_texts() == ["other"]
    assert np.max(drawn(tab, "rail")[1]["surfacecolor"]) == 6.0


@pytest.mark.parametrize("width", [1280, 800, 400])
def test_nothing_is_wider_than_the_window(opened, width):
    """A wide table scrolls in its own box, which keys reach; narrow windows have one column of charts."""
    tab, _ = opened
    tab.set_viewport_size({"width": width, "height": 900})
    for chart in ("curves", "rail"):
        drawn(tab, chart)
    tab.wait_for_timeout(300)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    box = tab.locator(".wide", has_text="a number 29")
    assert box.get_attribute("role") == "region"
    box.focus()
    tab.keyboard.press("ArrowRight")
    tab.wait_for_function("[...document.querySelectorAll('.wide')].some(box => box.scrollLeft > 0)")
    lefts = tab.eval_on_selector_all("#chart-curves .cells > div", "e => e.map(one => one.offsetLeft)")
    assert len(set(lefts)) == (1 if width == 400 else 2)


def test_paper_has_all_charts_as_wide_as_the_sheet_and_light_and_the_screen_has_its_own_again(opened):
    """Also those not yet in view and those in folded parts; printing does not wait."""
    tab, _ = opened
    tab.emulate_media(color_scheme="dark")
    tab.wait_for_timeout(500)  # the bundle for curves and maps is unpacked
    assert tab.pdf(format="A4", prefer_css_page_size=True).startswith(b"%PDF")
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    sizes = tab.eval_on_selector_all(
        "#chart-curves .main-svg, #chart-folded .main-svg", "e => e.map(one => one.clientWidth)"
    )
    assert len(sizes) >= 4
    assert 0 < max(sizes) <= 182 / 25.4 * 96  # between the margins of A4
    ink = "e => e.map(l => l.style.stroke)"
    assert "rgb(27, 30, 35)" in tab.eval_on_selector_all("#chart-folded .scatterlayer .js-line", ink)
    tab.evaluate("dispatchEvent(new Event('afterprint'))")
    assert not tab.locator("#chart-folded").is_visible()
    assert "rgb(232, 234, 237)" in tab.eval_on_selector_all("#chart-curves .scatterlayer .js-line", ink)


def test_whatever_one_uses_or_sees_has_a_name(opened):
    """Charts, legends, sliders, choices and the buttons of Plotly, as a screen reader finds them."""
    tab, _ = opened
    for chart in ("curves", "rail"):
        drawn(tab, chart)
    used = tab.locator(".chart :is(button, input, select, [role=button]), .chart [role=img], [role=figure]")
    assert used.count() > 10
    for one in used.all():
        name = one.evaluate("e => e.ariaLabel || e.labels?.[0]?.textContent || e.textContent")
        assert name.strip(), one.evaluate("e => e.outerHTML.slice(0, 200)")
    figure = tab.get_by_role("figure", name="curves of two kinds")
    assert figure.get_by_role("img").first.get_attribute("aria-label") == (
        "curves of two kinds, 3 kN, upper, p [MPa] over s [mm]"
    )


def test_without_javascript_the_page_says_so(browser, page_file):
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(page_file.as_uri())
    assert tab.locator("noscript p").is_visible()
    assert "need JavaScript" in tab.locator("noscript p").inner_text()
    assert not tab.locator(".chart").first.is_visible()
    context.close()


@pytest.mark.parametrize(("scheme", "ink"), [("light", "rgb(27, 30, 35)"), ("dark", "rgb(232, 234, 237)")])
def test_curves_of_c_have_the_colour_of_the_text(opened, scheme, ink):
    tab, _ = opened
    tab.emulate_media(color_scheme=scheme)
    drawn(tab, "curves")
    tab.wait_for_timeout(500)
    strokes = tab.eval_on_selector_all(
        "#chart-curves .scatterlayer .js-line", "e => e.map(l => l.style.stroke)"
    )
    assert ink in strokes
