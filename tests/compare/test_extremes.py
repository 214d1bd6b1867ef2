"""The harmonic engine at the ends of what scenes may ask for: it comes to the tolerance."""

import pytest

from compare.pipeline import compute, estimated_errors
from compare.scenes.load import load_scene
from femic.accuracy import component_of


def arc(flanks):
    return {"kind": "arc", "radius": 10.0, "flank_inclination_deg": flanks}


def lines(length):
    """Lines in proportion to a patch."""
    return [
        {"along": "x", "s": 0.8 * length, "reach": 5 * length, "points": 41},
        {"along": "x", "s": 0.0, "reach": 5 * length, "points": 41},
        {"along": "s", "x": 0.8 * length, "reach": 2.5 * length, "points": 41},
    ]


EXTREMES = {
    "a wedge of 10 degrees": {"lower": {"contour": arc(85.0)}, "upper": {"contour": arc(85.0)}},
    "unlike flanks": {"lower": {"contour": arc([85.0, 20.0])}, "upper": {"contour": arc([85.0, 20.0])}},
    "a small wheel": {"upper": {"rolling_radius": 20.0, "contour": arc(75.0)}},
    "a small roller": {"lower": {"rolling_radius": 20.0, "contour": arc(30.0)}, "lines": lines(1.6)},
    "a huge wheel": {"upper": {"rolling_radius": 1e6}},
    "nearly incompressible": {"lower": {"nu": 0.4999}, "upper": {"nu": 0.4999}},
    "a small element": {"patch": {"a": 0.01, "b": 0.01}, "lines": lines(0.08)},
    "a large element": {
        "patch": {"a": 5.0, "b": 5.0},
        "lines": lines(40.0),
        "engine": {"far_radius": 5000.0},
    },
    "a long patch": {"patch": {"a": 2.0, "b": 0.02}},
    "a wide patch": {"patch": {"a": 0.02, "b": 2.0}},
    "a load on the flank": {"patch": {"a": 0.2, "b": 0.2, "s": 8.0}},
    "unlike materials": {"lower": {"E": 0.21}},
}


@pytest.mark.slow
@pytest.mark.parametrize("case", EXTREMES)
def test_it_comes_to_the_tolerance_at_once(case):
    """Without a round of refinement; every result passed its estimate on the way."""
    changes = EXTREMES[case]
    engine = {"check": False} | changes.get("engine", {})
    results = compute(load_scene("geometry1", changes | {"engine": engine}))
    for errors in estimated_errors(results).values():
        assert max(component_of(errors, c) for c in results.scene.components) < 0.01
    assert {reference.level.cells for reference in results.references.values()} == {0}
