"""Plausibility warnings: about which bodies and engines, and none for the built-in scenes."""

import re

import numpy as np
import pytest

from femic.scenes.load import builtin_names, load_scene, scene_from_table
from femic.scenes.plausibility import warnings
from tests.compare.conftest import scene_text

SLENDER = ("tall", "wide")  # elliptic sections that go on as steep flanks, for want of a body behind them


@pytest.mark.parametrize("name", [name for name in builtin_names() if name not in SLENDER])
def test_builtin_scenes_have_no_warnings(name):
    assert warnings(load_scene(name)) == []


@pytest.mark.parametrize("name", SLENDER)
def test_builtin_scenes_of_slender_bodies_are_warned_about(name):
    assert any("30 degrees of material" in text for text in warnings(load_scene(name)))


ARC = {"kind": "arc", "radius": 10.0, "flank_inclination_deg": 25.5}
TABLE = {
    "lower": {"E": 210e3, "nu": 0.28, "contour": ARC},
    "upper": {"E": 210e3, "nu": 0.28, "contour": ARC},
    "patch": {"a": 0.2, "b": 0.2},
    "lines": [{"along": "x", "s": 1.6}],
}


def changed(table, changes):
    merged = dict(table)
    for key, value in changes.items():
        merged[key] = table.get(key, {}) | value if isinstance(value, dict) else value
    return merged


@pytest.mark.parametrize(
    "changes",
    [
        {"lines": [{"along": "x", "s": 1.6, "reach": 80.0}]},
        {"patch": {"a": 2.0}, "lines": [{"along": "x", "s": 0.0}]},
    ],
)
def test_harmonic_engine_has_no_warnings_of_the_solid_engine(changes):
    table = changed(TABLE, changes)
    assert warnings(scene_from_table(table, "harmonic")) == []
    assert warnings(scene_from_table(table | {"engine": {"kind": "solid"}}, "solid")) != []


def test_patch_near_the_end_of_a_measured_contour_is_warned_about(tmp_path, write_scene):
    y = np.linspace(-12, 12, 41)
    np.savetxt(tmp_path / "rail.txt", np.column_stack([y, -(y**2) / 60]))
    path, arc = write_scene(), '"arc", radius = 10.0, flank_inclination_deg = 25.0'
    text = scene_text().replace(arc, '"points", file = "rail.txt"').replace("a = 0.3", "a = 0.3\ns = 11.5")
    path.write_text(text, encoding="utf-8")
    (warning,) = [text for text in warnings(load_scene(str(path))) if "from the end of lower.contour" in text]
    slope = 12 / 30
    arc_length = 15 * (slope * np.hypot(1, slope) + np.arcsinh(slope))  # of the parabola, to y = 12
    number = re.match(r"patch\.s = 11\.5: (\S+) mm from the end", warning)[1]
    assert float(number) == pytest.approx(arc_length - 11.5 - 0.2, abs=2e-3)


UNLIKELY = {
    "E": 210e3,
    "nu": 0.48,
    "contour": {"kind": "arc", "radius": 1.0, "flank_inclination_deg": 75.0},
    "rolling_radius": 60.0,
}
REASONS = ("radius 1 mm", "30 degrees of material", "nearly incompressible", "the hub", "turned")


@pytest.mark.parametrize(
    ("bodies", "n"), [(["upper"], 0), (["lower"], 5), (["combined"], 5), (["lower", "upper"], 5)]
)
def test_only_bodies_that_the_scene_compares_are_warned_about(bodies, n):
    lines = [{"along": "x", "s": 1.0, "reach": 10.0}]
    table = TABLE | {"bodies": bodies, "lower": UNLIKELY, "lines": lines}
    texts = [text for text in warnings(scene_from_table(table, "unlikely")) if text.startswith("lower.")]
    assert len(texts) == n, texts
    assert all(any(reason in text for text in texts) for reason in REASONS[:n])


@pytest.mark.parametrize(("far_radius", "expected"), [(150.0, False), (170.0, True)])
def test_a_hub_is_warned_about_only_if_the_model_reaches_it(far_radius, expected):
    changes = {"upper": {"rolling_radius": 200.0}, "lines": [{"along": "x", "s": 1.6, "reach": 10.0}]}
    table = changed(TABLE, changes) | {"engine": {"far_radius": far_radius}}
    assert any("the hub" in text for text in warnings(scene_from_table(table, "wheel"))) == expected
