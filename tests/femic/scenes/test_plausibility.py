"""Plausibility warnings: about which bodies and engines, and none for the built-in scenes."""

import pytest

from femic.scenes.load import builtin_names, load_scene, scene_from_table
from femic.scenes.plausibility import warnings

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
