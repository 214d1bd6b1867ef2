"""Plausibility warnings: where each begins, about which bodies, and none for the built-in scenes."""

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from femic.scenes.load import builtin_names, load_scene
from femic.scenes.plausibility import pair_warnings, warnings
from tests.femic.scenes.changes import SHORT, arc, both, engine, line, patch, straight

STRAIGHT = {"lower": straight(-8.0, 8.0), **SHORT}
SOLID = engine(kind="solid")
LONG_LINE, SHORT_LINE = line("x", 0.0, 25.0), line("x", 0.0, 3.0)
DOMAIN = engine(kind="solid", far_radius=300.0, half_length=320.0)
SHORT_DOMAIN = engine(kind="solid", far_radius=320.0, half_length=300.0)
JOINT = 10.0 * np.radians(25.5)  # 4.4506 mm


def wheel(radius, **keys):
    return {"upper": {"rolling_radius": radius, **keys}}


def across_and(along):
    """A short line along x, and a longer one along x or s, under a small wheel."""
    return {"lines": [*SHORT["lines"], *line(along, 1.6, 25.0)["lines"]]} | wheel(400.0)


class Limit(NamedTuple):
    changes: Callable  # of a scene by a value
    within: object  # the last value without a warning
    beyond: object
    scene: str = "flat"


LIMITS = {  # by the warning beyond them
    r"\w+\.contour: radius 10 mm at the patch, 9\.9 times patch\.b = 1\.01": Limit(
        lambda b: patch(0.2, b), 0.99, 1.01, "geometry1"
    ),
    r"patch\.s = 5\.41: 2\.39 mm from the end of lower\.contour": Limit(  # b + 6 a
        lambda s: STRAIGHT | patch(0.4, 0.2, s), 5.39, 5.41
    ),
    r"patch\.s = -5\.21: 2\.39 mm from the end of lower\.contour": Limit(  # 7 b
        lambda s: STRAIGHT | patch(0.2, 0.4, s), -5.19, -5.21
    ),
    r"patch\.s = 4\.64959: the patch lies on the joint of arc and flank of \w+\.contour \(s = 4\.451": Limit(
        lambda beside: patch(0.2, 0.2, JOINT + beside), 0.201, 0.199, "geometry1"
    ),
    r"the patch lies on the joint of arc and flank of \w+\.contour \(s = -4\.451": Limit(
        lambda beside: patch(0.2, 0.2, -JOINT + beside), 0.201, 0.199, "geometry1"
    ),
    r"lower\.contour: 39 degrees of material between the flanks": Limit(
        lambda angle: both(arc(angle)), 69.9, 70.6, "geometry1"
    ),
    r"\w+\.contour: 39 degrees of material between the flanks": Limit(
        lambda angle: both(arc([74.0, angle])), 65.9, 66.6, "geometry1"
    ),
    r"upper\.rolling_radius = 299: below 300 mm the hub \(radius 100 mm, clamped\)": Limit(
        lambda radius: SHORT | wheel(radius, hub_radius=100.0), 301.0, 299.0
    ),
    r"upper\.rolling_radius = 200: below 300 mm the hub": Limit(
        lambda radius: SHORT | wheel(200.0) | engine(far_radius=radius), 150.0, 170.0
    ),
    r"line s = 1\.6 mm: reaches 80 mm": Limit(
        lambda kind: line("x", 1.6, 80.0) | engine(kind=kind), "harmonic", "solid"
    ),
    r"patch of aspect 10: on the line s = 0 mm": Limit(
        lambda kind: SHORT | patch(2.0, 0.2) | engine(kind=kind), "harmonic", "solid"
    ),
    r"upper\.rolling_radius = 400: 16 times .* \(25 mm\): .* turned by 3\.6 degrees": Limit(
        lambda radius: LONG_LINE | wheel(radius), 501.0, 400.0
    ),
    r"longest line along x \(25 mm\)": Limit(lambda radius: LONG_LINE | wheel(radius), 500.0, 499.0),
    r"upper\.rolling_radius = 400: 16 times": Limit(across_and, "s", "x"),
    r"\w+\.nu = 0\.4501: nearly incompressible": Limit(lambda nu: both({"nu": nu}), 0.45, 0.4501),
    r"line s = 0 mm: reaches 50\.1 mm, 17% of the domain \(300 mm\)": Limit(
        lambda reach: line("x", 0.0, reach) | DOMAIN, 50.0, 50.1
    ),
    r"line s = -50\.1 mm: reaches 50\.1 mm, 17% of the domain": Limit(
        lambda s: line("x", s, 3.0) | DOMAIN, -50.0, -50.1
    ),
    r"line x = 1\.6 mm: reaches 60 mm, 20% of the domain \(300 mm\)": Limit(
        lambda reach: line("s", 1.6, reach) | SHORT_DOMAIN, 50.0, 60.0
    ),
    r"patch of aspect 4\.1: on the line s = 0 mm": Limit(lambda a: SHORT | SOLID | patch(a, 0.2), 0.8, 0.82),
    r"patch of aspect 4\.1: on the line s": Limit(lambda b: SHORT | SOLID | patch(0.2, b), 0.8, 0.82),
    r"patch of aspect 5: on the line s = -0\.19 mm": Limit(
        lambda s: patch(1.0, 0.2) | SOLID | line("x", s, 3.0), -0.21, -0.19
    ),
    r"patch of aspect 5: on the line s = 1\.9 mm": Limit(
        lambda at: patch(1.0, 0.2, 2.0) | SOLID | line(*at, 3.0), ("s", 2.0), ("x", 1.9)
    ),
    r"upper\.E / lower\.E = 1e\+03: the combined ICs are practically those of the lower body": Limit(
        lambda E: {"lower": {"E": 1e3}, "upper": {"E": E}}, 999e3, 1000.5e3
    ),
    r"(lower|upper)\.E = 2\.1e\+06: no material is this stiff .* 210e3 for steel, not 210e9": Limit(
        lambda E: both({"E": E}), 2e6, 2.1e6
    ),
    r"upper\.E / lower\.E = 0\.00099: the combined ICs are practically those of the upper body": Limit(
        lambda ratio: {"upper": {"E": 210e3 / ratio}}, 999, 1010
    ),
    r"the contours differ by 10\.1 degrees at s = -5 mm": Limit(
        lambda angle: {"lower": arc(angle), **line("s", 1.6, 5.0)}, 9.9, 10.1
    ),
    r"the contours differ by 10\.3 degrees at s = 1\.8 mm": Limit(
        lambda s: {"lower": arc([5.0, 20.0]), **line("x", s, 5.0)}, 1.7, 1.8
    ),
}


@pytest.mark.parametrize(("message", "limit"), LIMITS.items())
def test_a_warning_begins_at_its_limit(message, limit):
    assert warnings(load_scene(limit.scene, limit.changes(limit.within))) == []
    texts = warnings(load_scene(limit.scene, limit.changes(limit.beyond)))
    assert texts
    assert all(re.search(message, text) for text in texts), texts  # and no other warning


SLENDER = ("tall", "wide")  # elliptic sections that go on as steep flanks, for want of a body behind them


@pytest.mark.parametrize("name", builtin_names())
def test_builtin_scenes_have_no_warnings_but_those_of_slender_bodies(name):
    texts = warnings(load_scene(name))
    assert any("30 degrees of material" in text for text in texts) if name in SLENDER else texts == []


REASONS = ("radius 1 mm", "30 degrees of material", "nearly incompressible", "the hub", "turned")


@pytest.mark.parametrize(
    ("bodies", "n"), [(["upper"], 0), (["lower"], 5), (["combined"], 5), (["lower", "upper"], 5)]
)
def test_only_bodies_that_the_scene_compares_are_warned_about(bodies, n):
    unlikely = {"nu": 0.48, "rolling_radius": 60.0} | arc(75.0, 1.0)
    changes = {"bodies": bodies, "lower": unlikely, **patch(0.2, 0.2), **line("x", 1.0, 10.0)}
    texts = [text for text in warnings(load_scene("geometry1", changes)) if text.startswith("lower.")]
    assert len(texts) == n, texts
    assert all(any(reason in text for text in texts) for reason in REASONS[:n])


def test_contacts_and_matrices_are_not_warned_of_patch_and_lines():
    """They use neither; what holds of the bodies is said in both."""
    scene = load_scene("geometry1", across_and("x") | patch(0.2, 1.01) | {"lower": {"nu": 0.46}})
    of_lines, of_pair = warnings(scene), pair_warnings(scene)
    assert any("longest line along x" in text for text in of_lines)
    assert any("patch.b" in text for text in of_lines)
    assert [text for text in of_lines if "nearly incompressible" in text] == of_pair != []
