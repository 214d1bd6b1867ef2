"""Tables and rankings of an overlay, on hand-made errors of two scenes."""

import numpy as np
import pytest
import xarray as xr

from compare.pages.overlay import WITHIN_ACCURACY, _ranking, _rows, answer_table, decisive_components
from compare.pages.overlay_sources import Content, Overlay, SceneResults

LINES, VARIANTS, COMPONENTS = ("near", "far"), ("A", "Bhat"), ("nn", "xn", "sn")
COMMON = Content(("lower",), COMPONENTS, VARIANTS, LINES)


def scene(name, vanishing=(), **errors):
    """Errors of A by component on both lines, weights a hundredth of them, C known to 0.1 %."""
    over = {"body": ["lower"], "variant": [*VARIANTS, "C"], "line": list(LINES), "i": list("xsn")}
    coords = over | {"j": list("xsn")}
    error = xr.DataArray(np.full((1, 3, 2, 3, 3), 0.001), coords, tuple(coords))
    for component, of_lines in errors.items():
        error.loc[{"variant": "A", "i": component[0], "j": component[1]}] = np.array([of_lines])
    gone = xr.DataArray(np.zeros((1, 3, 3), dtype=bool), {k: coords[k] for k in ["body", "i", "j"]})
    for component in vanishing:
        gone.loc[{"i": component[0], "j": component[1]}] = True
    return SceneResults(
        name, xr.Dataset(), xr.Dataset({"error": error, "weight": error / 100, "vanishes": gone})
    )


@pytest.fixture
def overlay():
    """C_sn vanishes in b: A's 30 % are of 0.05 C_nn there."""
    a = scene("a", nn=(0.02, 0.01), xn=(1.0, 0.5), sn=(0.1, 0.0))
    b = scene("b", ["sn"], nn=(0.01, 0.05), xn=(0.9995, 1.0), sn=(0.3, 0.2))
    return Overlay(COMMON, (a, b))


def test_component_that_vanishes_in_a_scene_is_not_ranked(overlay):
    """A's nn: 2 and 5 % at worst; its xn is 100 % wrong in both."""
    assert (
        _ranking(overlay, "lower", "A") == f"more in b: nn 2.50 ×; {WITHIN_ACCURACY}: xn; vanishing in b: sn"
    )


def test_tables_mark_vanishing_components_and_show_weights(overlay):
    rows = [(row.name, *row.cells) for row in _rows(overlay, "lower", VARIANTS)]
    shown = {(name, scene): [(cell.text, cell.below) for cell in cells] for name, scene, *cells in rows}
    assert shown["A", "a"] == [("2.00 %", "0.02 %"), ("100.0 %", "1.00 %"), ("10.0 %", "0.10 %")]
    assert shown["", "b"][2] == ("vanishes", "< 0.01 %")  # the last of them is that of C
    of_b = [cells for _, scene, *cells in rows if scene == "b"]
    assert of_b[0][2].text == "30.0 % †"
    assert of_b[0][0].text == "5.00 %"  # the worst line


def test_answer_has_the_components_that_decide_in_every_scene():
    """C_xn is off by most; b has the largest weight in it."""
    scenes = [scene(name, nn=(0.02, 0.01), xn=(k, 0.5), sn=(0.1, 0.0)) for k, name in enumerate("abcde")]
    overlay = Overlay(COMMON, tuple(scenes))
    assert decisive_components(overlay) == ["nn", "xn"]
    table = answer_table(overlay, "lower")
    assert [(row.name, row.filled[0].text) for row in table.rows[::5]] == [("nn", "a"), ("xn", "a")]
    assert [row.filled[0].text for row in table.rows] == [*"abcde", *"abcde"]
    assert table.rows[9].filled[1].text == "400.0 %"  # of A in xn of the last scene


def test_answer_of_a_single_component_is_about_that(overlay):
    one = Overlay(Content(("lower",), ("sn",), VARIANTS, LINES), overlay.results)
    assert decisive_components(one) == ["sn"]


def test_answer_without_approximations_has_c_alone(overlay):
    bare = Overlay(Content(("lower",), COMPONENTS, (), LINES), overlay.results)
    assert decisive_components(bare) == ["nn"]
    assert [column.head for column in answer_table(bare, "lower").heads] == ["scene", "C ±"]
