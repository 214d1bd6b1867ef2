"""Where each plausibility warning begins: none on one side of its limit, its numbers on the other."""

import re

import numpy as np
import pytest

from femic.scenes.load import load_scene
from femic.scenes.plausibility import warnings
from tests.femic.scenes.changes import SHORT, arc, both, engine, line, patch, straight

MEASURED = straight(-8.0, 8.0)
MOST_MEASURED = {"lower": MEASURED, **SHORT}
SOLID = engine(kind="solid")
DOMAIN = engine(kind="solid", far_radius=300.0, half_length=320.0)
SHORT_DOMAIN = engine(kind="solid", far_radius=320.0, half_length=300.0)
SLENDER = SHORT | SOLID
JOINT = 10.0 * np.radians(25.5)  # 4.4506 mm
LIMITS = {  # scene, changes within the limit, beyond it, the warning there
    "radius of the arc": (
        "geometry1",
        patch(0.2, 0.99),
        patch(0.2, 1.01),
        r"\w+\.contour: radius 10 mm at the patch, 9\.9 times patch\.b = 1\.01",
    ),
    "end on the right": (  # b + 6 a
        "flat",
        MOST_MEASURED | patch(0.4, 0.2, 5.39),
        MOST_MEASURED | patch(0.4, 0.2, 5.41),
        r"patch\.s = 5\.41: 2\.39 mm from the end of lower\.contour",
    ),
    "end on the left": (  # 7 b
        "flat",
        MOST_MEASURED | patch(0.2, 0.4, -5.19),
        MOST_MEASURED | patch(0.2, 0.4, -5.21),
        r"patch\.s = -5\.21: 2\.39 mm from the end of lower\.contour",
    ),
    "joint at its outer side": (
        "geometry1",
        patch(0.2, 0.2, JOINT + 0.201),
        patch(0.2, 0.2, JOINT + 0.199),
        r"patch\.s = 4\.64959: the patch lies on the joint of arc and flank of \w+\.contour \(s = 4\.451",
    ),
    "joint at its inner side": (
        "geometry1",
        patch(0.2, 0.2, -JOINT + 0.201),
        patch(0.2, 0.2, -JOINT + 0.199),
        r"the patch lies on the joint of arc and flank of \w+\.contour \(s = -4\.451",
    ),
    "wedge": (
        "geometry1",
        both(arc(69.9)),
        both(arc(70.6)),
        r"lower\.contour: 39 degrees of material between the flanks",
    ),
    "wedge of unlike flanks": (
        "geometry1",
        both(arc([74.0, 65.9])),
        both(arc([74.0, 66.6])),
        r"lower\.contour: 39 degrees of material between the flanks",
    ),
    "hub": (
        "flat",
        SHORT | {"upper": {"rolling_radius": 301.0}},
        SHORT | {"upper": {"rolling_radius": 299.0, "hub_radius": 100.0}},
        r"upper\.rolling_radius = 299: below 300 mm the hub \(radius 100 mm, clamped\)",
    ),
    "hub that the model reaches": (
        "flat",
        SHORT | {"upper": {"rolling_radius": 200.0}} | engine(far_radius=150.0),
        SHORT | {"upper": {"rolling_radius": 200.0}} | engine(far_radius=170.0),
        r"upper\.rolling_radius = 200: below 300 mm the hub",
    ),
    "line of the solid engine": (
        "flat",
        line("x", 1.6, 80.0),
        line("x", 1.6, 80.0) | SOLID,
        r"line s = 1\.6 mm: reaches 80 mm",
    ),
    "patch of the solid engine": (
        "flat",
        SHORT | patch(2.0, 0.2),
        SHORT | patch(2.0, 0.2) | SOLID,
        r"patch of aspect 10: on the line s = 0 mm",
    ),
    "turned surface": (
        "flat",
        line("x", 0.0, 25.0) | {"upper": {"rolling_radius": 501.0}},
        line("x", 0.0, 25.0) | {"upper": {"rolling_radius": 400.0}},
        r"upper\.rolling_radius = 400: 16 times .* \(25 mm\): .* turned by 3\.6 degrees",
    ),
    "turned surface, nearest": (
        "flat",
        line("x", 0.0, 25.0) | {"upper": {"rolling_radius": 500.0}},
        line("x", 0.0, 25.0) | {"upper": {"rolling_radius": 499.0}},
        r"longest line along x \(25 mm\)",
    ),
    "turned surface, longest line": (
        "flat",
        {"lines": [*SHORT["lines"], *line("s", 1.6, 25.0)["lines"]], "upper": {"rolling_radius": 400.0}},
        {"lines": [*SHORT["lines"], *line("x", 1.6, 25.0)["lines"]], "upper": {"rolling_radius": 400.0}},
        r"upper\.rolling_radius = 400: 16 times",
    ),
    "incompressible": (
        "flat",
        both({"nu": 0.45}),
        both({"nu": 0.4501}),
        r"\w+\.nu = 0\.4501: nearly incompressible",
    ),
    "line along x in the domain": (
        "flat",
        line("x", 0.0, 50.0) | DOMAIN,
        line("x", 0.0, 50.1) | DOMAIN,
        r"line s = 0 mm: reaches 50\.1 mm, 17% of the domain \(300 mm\)",
    ),
    "line at the side in the domain": (
        "flat",
        line("x", -50.0, 3.0) | DOMAIN,
        line("x", -50.1, 3.0) | DOMAIN,
        r"line s = -50\.1 mm: reaches 50\.1 mm, 17% of the domain",
    ),
    "line along s in the domain": (
        "flat",
        line("s", 1.6, 50.0) | SHORT_DOMAIN,
        line("s", 1.6, 60.0) | SHORT_DOMAIN,
        r"line x = 1\.6 mm: reaches 60 mm, 20% of the domain \(300 mm\)",
    ),
    "patch along x": (
        "flat",
        SLENDER | patch(0.8, 0.2),
        SLENDER | patch(0.82, 0.2),
        r"patch of aspect 4\.1: on the line s = 0 mm",
    ),
    "patch along s": (
        "flat",
        SLENDER | patch(0.2, 0.8),
        SLENDER | patch(0.2, 0.82),
        r"patch of aspect 4\.1: on the line s = 0 mm",
    ),
    "line beside a slender patch": (
        "flat",
        patch(1.0, 0.2) | SOLID | line("x", -0.21, 3.0),
        patch(1.0, 0.2) | SOLID | line("x", -0.19, 3.0),
        r"patch of aspect 5: on the line s = -0\.19 mm",
    ),
    "line across a slender patch": (
        "flat",
        patch(1.0, 0.2) | SOLID | line("s", 0.0, 3.0),
        patch(1.0, 0.2, 2.0) | SOLID | line("x", 1.9, 3.0),
        r"patch of aspect 5: on the line s = 1\.9 mm",
    ),
    "stiff upper body": (
        "flat",
        {"lower": {"E": 1e3}, "upper": {"E": 999e3}},
        {"lower": {"E": 1e3}, "upper": {"E": 1000.5e3}},
        r"upper\.E / lower\.E = 1e\+03: the combined ICs are the ICs of the lower body",
    ),
    "modulus in pascal": (
        "flat",
        {"lower": {"E": 2e6}, "upper": {"E": 2e6}},
        {"lower": {"E": 2.1e6}, "upper": {"E": 2.1e6}},
        r"(lower|upper)\.E = 2\.1e\+06: no material is so stiff .* 210e3 for steel, not 210e9",
    ),
    "stiff lower body": (
        "flat",
        {"upper": {"E": 210e3 / 999}},
        {"upper": {"E": 210e3 / 1010}},
        r"upper\.E / lower\.E = 0\.00099: the combined ICs are the ICs of the upper body",
    ),
    "contours apart": (
        "flat",
        {"lower": arc(9.9), **line("s", 1.6, 5.0)},
        {"lower": arc(10.1), **line("s", 1.6, 5.0)},
        r"the contours differ by 10\.1 degrees at s = -5 mm",
    ),
    "contours apart on one side": (
        "flat",
        {"lower": arc([5.0, 20.0]), **line("x", 1.7, 5.0)},
        {"lower": arc([5.0, 20.0]), **line("x", 1.8, 5.0)},
        r"the contours differ by 10\.3 degrees at s = 1\.8 mm",
    ),
}


@pytest.mark.parametrize("case", LIMITS)
def test_warning_begins_at_its_limit(case):
    name, within, beyond, expected = LIMITS[case]
    assert warnings(load_scene(name, within)) == []
    texts = warnings(load_scene(name, beyond))
    assert texts
    assert all(re.search(expected, text) for text in texts), texts  # and no other warning
