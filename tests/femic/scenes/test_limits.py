"""How far the parts of a scene may go together: allowed at each limit, refused beyond it with its numbers."""

import numpy as np
import pytest

from femic.scenes import engine as engine_table
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene
from tests.femic.scenes.changes import SHORT, arc, both, engine, line, patch, straight

SMALL_DOMAIN = engine(far_radius=100.0)
HALF_OF_IT = r"half of the least of engine\.far_radius and half a turn \(50 mm\)"
SHORT_SOLID = engine(kind="solid", far_radius=100.0, half_length=80.0)
MEASURED = {"lower": straight(-8.0, 8.0), **SHORT}
LONG_LEFT, LONG_RIGHT = ({"lower": straight(*ends), **SHORT} for ends in ((-9.0, 8.0), (-8.0, 9.0)))
ROLLER = {"lower": arc(30.0) | {"rolling_radius": 20.0}, "rotation_reach": 5.0}
NO_FLANK = 10 * np.radians(30.0)  # arc length of the joint of the roller's contour
HUB_AT = NO_FLANK + (8 - 10 * (1 - np.cos(np.radians(30)))) / np.sin(np.radians(30))  # 8 mm below the crown
SMALL_WHEEL = {"upper": {"rolling_radius": 20.0}}  # half a turn: 62.83 mm


SMALL = patch(0.004, 0.0025) | {"rotation_reach": 20.0, "moment_arm": 5.0}
WIDE_GRID = patch(0.3, 0.3) | {"moment_arm": 5.0, "grid": {"n_x": 4, "n_s": 3, "dx": 0.005, "ds": 0.008}}


def fit(**keys):
    return {"calibration": {"points": 8, **keys}}


LIMITS = {  # changes of the scene `flat` that are allowed, that are not, the message
    "patch on the right": (
        MEASURED | patch(0.5, 0.5, 7.49),
        MEASURED | patch(0.5, 0.5, 7.51),
        r"patch\.s = 7\.51, patch\.b = 0\.5: the patch reaches beyond the contour; the contours go from "
        r"s = -8 to 8 mm",
    ),
    "patch on the left": (
        MEASURED | patch(0.5, 0.5, -7.49),
        MEASURED | patch(0.5, 0.5, -7.51),
        r"patch\.s = -7\.51, patch\.b = 0\.5: the patch reaches beyond",
    ),
    "patch along x in the domain": (
        SMALL_DOMAIN | SHORT | patch(5.0, 1.0),
        SMALL_DOMAIN | SHORT | patch(5.01, 1.0),
        rf"patch\.a = 5\.01, patch\.b = 1: each at most a tenth of {HALF_OF_IT}",
    ),
    "patch along s in the domain": (
        SMALL_DOMAIN | SHORT | patch(1.0, 5.0),
        SMALL_DOMAIN | SHORT | patch(1.0, 5.01),
        r"patch\.a = 1, patch\.b = 5\.01: each at most",
    ),
    "patch far out": (
        SMALL_DOMAIN | SHORT | patch(0.2, 0.3, 50.0),
        SMALL_DOMAIN | SHORT | patch(0.2, 0.3, 50.1),
        rf"patch\.s = 50\.1: beyond {HALF_OF_IT}",
    ),
    "patch far out on the left": (
        SMALL_DOMAIN | SHORT | patch(0.2, 0.3, -50.0),
        SMALL_DOMAIN | SHORT | patch(0.2, 0.3, -50.1),
        r"patch\.s = -50\.1: beyond",
    ),
    "first cells": (
        engine(smallest_cell=0.3),
        engine(smallest_cell=0.301),
        r"engine\.smallest_cell = 0\.301: at most 0\.3, half a side of the patch",
    ),
    "first cells of the solid engine": (
        engine(kind="solid", smallest_cell=0.2),
        engine(kind="solid", smallest_cell=0.201),
        r"engine\.smallest_cell = 0\.201: at most 0\.2",
    ),
    "rotation on the right": (
        LONG_LEFT | {"rotation_reach": 7.99},
        LONG_LEFT | {"rotation_reach": 8.01},
        r"rotation_reach = 8\.01: beyond the contour; .* s = -9 to 8 mm: give a smaller one",
    ),
    "rotation on the left": (
        LONG_RIGHT | {"rotation_reach": 7.99},
        LONG_RIGHT | {"rotation_reach": 8.01},
        r"rotation_reach = 8\.01: beyond the contour; .* s = -8 to 9 mm",
    ),
    "rotation in the domain": (
        SMALL_DOMAIN | {"rotation_reach": 50.0},
        SMALL_DOMAIN | {"rotation_reach": 50.1},
        rf"rotation_reach = 50\.1: at most {HALF_OF_IT}",
    ),
    "rotation in a domain with ends": (
        SHORT_SOLID | {"rotation_reach": 40.0},
        SHORT_SOLID | {"rotation_reach": 40.1},
        r"rotation_reach = 40\.1: .* engine\.far_radius, engine\.half_length and half a turn \(40 mm\)",
    ),
    "rotation and arm": (
        SMALL_DOMAIN | patch(0.2, 0.3, 1.0) | {"rotation_reach": 30.0, "moment_arm": 20.0},
        SMALL_DOMAIN | patch(0.2, 0.3, 1.0) | {"rotation_reach": 30.0, "moment_arm": 20.1},
        rf"moment_arm \+ rotation_reach = 50\.1: at most {HALF_OF_IT}",
    ),
    "arm and the right end": (
        LONG_LEFT | patch(0.2, 0.2, 1.0) | {"rotation_reach": 7.0, "moment_arm": 6.79},
        LONG_LEFT | patch(0.2, 0.2, 1.0) | {"rotation_reach": 7.0, "moment_arm": 6.81},
        r"moment_arm = 6\.81: displacements are compared 1\.19 mm beside .* 6 patch\.b = 1\.2 mm",
    ),
    "arm and the left end": (
        LONG_RIGHT | patch(0.2, 0.2, 1.0) | {"rotation_reach": 7.0, "moment_arm": 6.79},
        LONG_RIGHT | patch(0.2, 0.2, 1.0) | {"rotation_reach": 7.0, "moment_arm": 6.81},
        r"moment_arm = 6\.81: displacements are compared 1\.19 mm",
    ),
    "arm and rotation": (
        patch(0.2, 0.2, 1.0) | {"rotation_reach": 1.21},
        patch(0.2, 0.2, 1.0) | {"rotation_reach": 1.19},
        r"moment_arm = 5: displacements are compared 1\.19 mm",
    ),
    "line along x": (
        SMALL_DOMAIN | line("x", 0.0, 50.0),
        SMALL_DOMAIN | line("x", 0.0, 50.1),
        rf"lines\.0 \(s = 0 mm\): reaches beyond {HALF_OF_IT}",
    ),
    "line at the side": (
        SMALL_DOMAIN | line("x", -50.0, 3.0),
        SMALL_DOMAIN | line("x", -50.1, 3.0),
        r"lines\.0 \(s = -50\.1 mm\): reaches beyond",
    ),
    "line far along x": (
        SMALL_DOMAIN | line("s", -50.0, 3.0),
        SMALL_DOMAIN | line("s", -50.1, 3.0),
        r"lines\.0 \(x = -50\.1 mm\): reaches beyond",
    ),
    "line round a wheel": (
        SMALL_WHEEL | line("x", 0.0, 31.4),
        SMALL_WHEEL | line("x", 0.0, 31.5),
        r"reaches beyond half .* \(31\.4159 mm\)",
    ),
    "line and the right end": (
        LONG_LEFT | line("x", 7.99, 3.0),
        LONG_LEFT | line("x", 8.01, 3.0),
        r"lines\.0 \(s = 8\.01 mm\): beyond the contour, s = -9 to 8 mm",
    ),
    "line and the left end": (
        LONG_RIGHT | line("x", -7.99, 3.0),
        LONG_RIGHT | line("x", -8.01, 3.0),
        r"lines\.0 \(s = -8\.01 mm\): beyond the contour, s = -8 to 9 mm",
    ),
    "line and a hub": (
        ROLLER | line("x", HUB_AT - 0.01, 3.0),
        ROLLER | line("x", HUB_AT + 0.01, 3.0),
        r"reaches beyond half the height of the hub of the lower body \(8 mm\): shorten it, or enlarge "
        r"lower\.rolling_radius",
    ),
    "Poisson's ratio": (
        engine(kind="solid") | both({"nu": 0.49}),
        engine(kind="solid") | {"upper": {"nu": 0.4901}},
        r"upper\.nu = 0\.4901: use engine\.kind = 'harmonic' \(without check\) above 0\.49",
    ),
    "wheel": (
        engine(kind="solid") | {"upper": {"rolling_radius": 50.0}},
        engine(kind="solid") | {"upper": {"rolling_radius": 49.9}},
        r"upper\.rolling_radius = 49\.9: use engine\.kind = 'harmonic' \(without check\) below 50",
    ),
    "long patch": (
        engine(kind="solid") | patch(2.0, 0.2),
        engine(kind="solid") | patch(2.01, 0.2),
        r"patch\.a / patch\.b = 10\.05: use engine\.kind = 'harmonic' .* outside 0\.1 \.\.\. 10,",
    ),
    "wide patch": (
        engine(kind="solid") | patch(0.2, 2.0),
        engine(kind="solid") | patch(0.2, 2.01),
        r"patch\.a / patch\.b = 0\.0995025: use",
    ),
    "flank": (
        engine(kind="solid") | {"upper": arc(75.0)},
        engine(kind="solid") | {"upper": arc(75.1)},
        r"upper\.contour: inclined up to 75\.1 degrees; at most 75: cut it there",
    ),
    "flank on the left": (
        engine(kind="solid") | {"upper": arc([75.0, 20.0])},
        engine(kind="solid") | {"upper": arc([75.1, 20.0])},
        r"upper\.contour: inclined up to 75\.1 degrees",
    ),
    "grid on a contour": (
        MEASURED | {"grid": {"n_s": 16, "ds": 1.0}},
        MEASURED | {"grid": {"n_s": 16, "ds": 1.01}},
        r"grid: 16 strips of 1\.01 mm go from s = -8\.08 to 8\.08 mm, the contours from -8 to 8 mm",
    ),
    "grid beside the end": (
        MEASURED | {"grid": {"n_s": 4, "ds": 1.0, "s": 5.99}},
        MEASURED | {"grid": {"n_s": 4, "ds": 1.0, "s": 6.01}},
        r"grid: 4 strips of 1 mm go from s = 4\.01 to 8\.01 mm",
    ),
    "grid beside the other end": (
        MEASURED | {"grid": {"n_s": 4, "ds": 1.0, "s": -5.99}},
        MEASURED | {"grid": {"n_s": 4, "ds": 1.0, "s": -6.01}},
        r"grid: 4 strips of 1 mm go from s = -8\.01 to -4\.01 mm",
    ),
    "long elements": (
        {"grid": {"n_x": 1, "dx": 10.0, "ds": 0.1}},
        {"grid": {"n_x": 1, "dx": 10.1, "ds": 0.1}},
        r"grid\.dx / grid\.ds = 101 is outside 0\.01 \.\.\. 100",
    ),
    "wide elements": (
        {"grid": {"n_s": 1, "dx": 0.1, "ds": 10.0}},
        {"grid": {"n_s": 1, "dx": 0.1, "ds": 10.1}},
        r"grid\.dx / grid\.ds = 0\.00990\d+ is outside",
    ),
    "grid round a wheel": (  # of a length of 31 and of 32 mm
        SMALL_WHEEL | SHORT | {"grid": {"n_x": 32, "dx": 1.0, "n_s": 2, "ds": 1.0}},
        SMALL_WHEEL | SHORT | {"grid": {"n_x": 33, "dx": 1.0, "n_s": 2, "ds": 1.0}},
        r"grid: 33 elements of 1 mm are more than half of half a turn \(62\.8319 mm\)",
    ),
    "a line of many elements": (
        SMALL | line("x", 0.0, 25.0),
        SMALL | line("x", 0.0, 25.3),
        r"lines\.0 \(s = 0 mm\): reaches 25\.3 mm, 1\.01e\+04 times patch\.b = 0\.0025, .*at most 10000 "
        r"times by engine\.kind = 'harmonic': shorten it to 25 mm",
    ),
    "a line beside many elements": (
        SMALL | line("x", 20.0, 15.0),
        SMALL | line("x", 20.0, 15.4),
        r"lines\.0 .* reaches 25\.\d+ mm",
    ),
    "what M is fitted to": (
        SMALL | SHORT | {"rotation_reach": 25.0},
        SMALL | SHORT | {"rotation_reach": 25.3},
        r"rotation_reach: reaches 25\.3 mm, 1\.01e\+04 times patch\.b",
    ),
    "the far arc": (
        SMALL | SHORT | engine(far_radius=12500.0),
        SMALL | SHORT | engine(far_radius=12500.5),
        r"engine\.far_radius = 12500\.5: 5e\+06 times patch\.b = 0\.0025, .*at most 5e\+06 times",
    ),
    "the elements of a grid": (
        WIDE_GRID | SHORT | {"rotation_reach": 25.0},
        WIDE_GRID | SHORT | {"rotation_reach": 25.3},
        r"rotation_reach: reaches 25\.3 mm, 1\.01e\+04 times grid\.dx / 2 = 0\.0025",
    ),
    "a line of the calibration": (
        SMALL | SHORT | {"calibration": {"x_max": 25.0, "s": [0.0]}},
        SMALL | SHORT | {"calibration": {"x_max": 25.3, "s": [0.0]}},
        r"calibration \(fit s = 0 mm\): reaches 25\.3 mm",
    ),
    "a line of the solid engine": (
        patch(0.025, 0.05) | engine(kind="solid") | line("x", 0.0, 25.0),
        patch(0.025, 0.05) | engine(kind="solid") | line("x", 0.0, 25.3),
        r"lines\.0 .* 1\.01e\+03 times patch\.a = 0\.025, .*at most 1000 times by engine\.kind = 'solid'",
    ),
    "nearest points of a fit": (
        fit(x_min=4.99, x_max=5.0),
        fit(x_min=5.0, x_max=5.0),
        r"calibration\.x_min, x_max: the furthest points must be further than the nearest",
    ),
    "line of a fit along s": (
        fit(x=[1.01], x_min=1.0, s=[]),
        fit(x=[1.0], x_min=1.0, s=[]),
        r"calibration\.x \(fit x = 1 mm\): not beyond x_min = 1 mm",
    ),
    "line of a fit beside the end": (
        MEASURED | fit(s=[7.99]),
        MEASURED | fit(s=[8.01]),
        r"calibration \(fit s = 8\.01 mm\): beyond the contour, s = -8 to 8 mm",
    ),
    "fit in the domain": (
        SMALL_DOMAIN | fit(s=[30.0], x_max=40.0),
        SMALL_DOMAIN | fit(s=[30.0], x_max=40.1),
        r"calibration\.x_max: points 50\.08 mm away, more than half of 100 mm: reduce it",
    ),
    "fit round a wheel": (
        SMALL_WHEEL | SHORT | fit(s=[0.0], x_max=31.4),
        SMALL_WHEEL | SHORT | fit(s=[0.0], x_max=31.5),
        r"calibration\.x_max: points 31\.5 mm away, more than half of 62\.83\d* mm",
    ),
    "curvature apart": (
        fit(bodies=["combined"], curvature="apart"),
        fit(bodies=["upper"], curvature="apart"),
        r"calibration\.curvature = 'apart': only of the combined bodies",
    ),
    "lines of a fit": (
        fit(s=[0.0, 1.0], x=[2.0, 3.0]),
        fit(s=[1.0, 1.0]),
        r"calibration\.s, calibration\.x: two of the lines are the same",
    ),
    "bodies of a fit": (
        {"bodies": ["upper"]} | fit(bodies=["upper"]),
        {"bodies": ["upper"]} | fit(bodies=["lower", "upper"]),
        r"calibration\.bodies: lower not in bodies = upper: add it",
    ),
}


@pytest.mark.parametrize("case", LIMITS)
def test_scene_is_refused_from_its_limit_on(case):
    allowed, refused, expected = LIMITS[case]
    load_scene("flat", allowed)
    with pytest.raises(BadScene, match=expected) as caught:
        load_scene("flat", refused)
    assert str(caught.value).startswith("flat: 1 error(s)")  # and no other


def test_scene_in_tiny_lengths_is_valid():
    """All lengths a millionth: no length is too small, ratios are."""
    tiny = patch(2e-7, 3e-7) | engine(far_radius=1.28e-3) | {"rotation_reach": 20e-6, "moment_arm": 5e-6}
    assert load_scene("flat", tiny | line("x", 0.0, 25e-6)).patch.a == 2e-7


def test_default_lines_of_a_distant_patch_add_no_error():
    with pytest.raises(BadScene, match=r"patch\.s = 1e\+12: beyond half"):
        load_scene("flat", patch(0.2, 0.3, 1e12))


EFFECTIVE = {"effective": {"upper": {"nu": {"far": 0.3, "r_inf": 9.0, "m": 1.0, "n": 2.0}}}}


@pytest.mark.parametrize("needing", [{"variants": ["Bhat_prime"]}, {"ics": "Bhat_prime"}])
@pytest.mark.parametrize(
    ("bodies", "enough"), [(["upper"], True), (["lower", "upper"], True), (["lower"], False)]
)
def test_bhat_prime_needs_effective_properties_of_a_compared_body(needing, bodies, enough):
    changes = needing | EFFECTIVE | {"bodies": bodies}
    if enough:
        assert load_scene("flat", changes).pair.has_effective("upper")
    else:
        with pytest.raises(BadScene, match=r"Bhat_prime.* effective properties"):
            load_scene("flat", changes)


@pytest.mark.parametrize("installed", [True, False])
def test_the_direct_solver_is_refused_where_it_is_not_installed(installed, monkeypatch):
    monkeypatch.setattr(engine_table, "direct_available", lambda: installed)
    if installed:
        assert load_scene("flat", engine(solver="direct")).settings.solver == "direct"
    else:
        with pytest.raises(BadScene, match=r"engine\.solver = 'direct': not installed; run .*pip install"):
            load_scene("flat", engine(solver="direct"))
    assert load_scene("flat").settings.solver == "auto"
