"""How far the parts of a scene may go together: allowed at each limit, refused beyond it with its numbers."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from femic.scenes import engine as engine_table
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene
from tests.femic.scenes.changes import PROPERTY, SHORT, arc, both, engine, line, patch, straight

SMALL_DOMAIN = engine(far_radius=100.0)
HALF_OF_IT = r"half of the least of engine\.far_radius and half a turn \(50 mm\)"
SHORT_SOLID = engine(kind="solid", far_radius=100.0, half_length=80.0)
SOLID = engine(kind="solid")
NOT_SOLID = r"use engine\.kind = 'harmonic' \(without check\)"
MEASURED = {"lower": straight(-8.0, 8.0), **SHORT}
LEFT, RIGHT = ({"lower": straight(*ends), **SHORT} for ends in ((-9.0, 8.0), (-8.0, 9.0)))  # the longer side
ROLLER = {"lower": arc(30.0) | {"rolling_radius": 20.0}, "rotation_reach": 5.0}
NO_FLANK = 10 * np.radians(30.0)  # arc length of the joint of the roller's contour
HUB_AT = NO_FLANK + (8 - 10 * (1 - np.cos(np.radians(30)))) / np.sin(np.radians(30))  # 8 mm below the crown
SMALL_WHEEL = {"upper": {"rolling_radius": 20.0}}  # half a turn: 62.83 mm
SMALL = patch(0.004, 0.0025) | {"rotation_reach": 20.0, "moment_arm": 5.0}
ARM, NEAR = patch(0.2, 0.2, 1.0), {"rotation_reach": 7.0}


def upper(**keys):
    return {"upper": keys}


def grid(**keys):
    return {"grid": keys}


def fit(**keys):
    return {"calibration": {"points": 8, **keys}}


FINE = patch(0.3, 0.3) | {"moment_arm": 5.0} | SHORT | grid(n_x=4, n_s=3, dx=0.005, ds=0.008)


class Limit(NamedTuple):
    changes: Callable  # of the scene `flat` by a value
    allowed: object  # the last value that is
    refused: object


LIMITS = {  # by the message beyond them
    r"patch\.s = 7\.51, patch\.b = 0\.5: .* beyond the contour; the contours go from s = -8 to 8 mm": Limit(
        lambda s: MEASURED | patch(0.5, 0.5, s), 7.49, 7.51
    ),
    r"patch\.s = -7\.51, patch\.b = 0\.5: the patch extends beyond": Limit(
        lambda s: MEASURED | patch(0.5, 0.5, s), -7.49, -7.51
    ),
    rf"patch\.a = 5\.01, patch\.b = 1: each at most a tenth of {HALF_OF_IT}": Limit(
        lambda a: SMALL_DOMAIN | SHORT | patch(a, 1.0), 5.0, 5.01
    ),
    r"patch\.a = 1, patch\.b = 5\.01: each at most": Limit(
        lambda b: SMALL_DOMAIN | SHORT | patch(1.0, b), 5.0, 5.01
    ),
    rf"patch\.s = 50\.1: beyond {HALF_OF_IT}": Limit(
        lambda s: SMALL_DOMAIN | SHORT | patch(0.2, 0.3, s), 50.0, 50.1
    ),
    r"patch\.s = -50\.1: beyond": Limit(lambda s: SMALL_DOMAIN | SHORT | patch(0.2, 0.3, s), -50.0, -50.1),
    r"engine\.smallest_cell = 0\.301: at most 0\.3, half a side of the patch": Limit(
        lambda h: engine(smallest_cell=h), 0.3, 0.301
    ),
    r"engine\.smallest_cell = 0\.201: at most 0\.2": Limit(
        lambda h: engine(kind="solid", smallest_cell=h), 0.2, 0.201
    ),
    r"rotation_reach = 8\.01: beyond the contour; .* s = -9 to 8 mm: give a smaller one": Limit(
        lambda y: LEFT | {"rotation_reach": y}, 7.99, 8.01
    ),
    r"rotation_reach = 8\.01: beyond the contour; .* s = -8 to 9 mm": Limit(
        lambda y: RIGHT | {"rotation_reach": y}, 7.99, 8.01
    ),
    rf"rotation_reach = 50\.1: at most {HALF_OF_IT}": Limit(
        lambda y: SMALL_DOMAIN | {"rotation_reach": y}, 50.0, 50.1
    ),
    r"rotation_reach = 40\.1: .* engine\.far_radius, engine\.half_length and half a turn \(40 mm\)": Limit(
        lambda y: SHORT_SOLID | {"rotation_reach": y}, 40.0, 40.1
    ),
    rf"moment_arm \+ rotation_reach = 50\.1: at most {HALF_OF_IT}": Limit(
        lambda y: SMALL_DOMAIN | patch(0.2, 0.3, 1.0) | {"rotation_reach": 30.0, "moment_arm": y}, 20, 20.1
    ),
    r"moment_arm = 6\.81: displacements are compared 1\.19 mm beside .* 6 patch\.b = 1\.2 mm": Limit(
        lambda y: LEFT | ARM | NEAR | {"moment_arm": y}, 6.79, 6.81
    ),
    r"moment_arm = 6\.81: displacements are compared 1\.19 mm": Limit(
        lambda y: RIGHT | ARM | NEAR | {"moment_arm": y}, 6.79, 6.81
    ),
    r"moment_arm = 5: displacements are compared 1\.19 mm": Limit(
        lambda y: ARM | {"rotation_reach": y}, 1.21, 1.19
    ),
    rf"lines\.0 \(s = 0 mm\): reaches beyond {HALF_OF_IT}": Limit(
        lambda reach: SMALL_DOMAIN | line("x", 0.0, reach), 50.0, 50.1
    ),
    r"lines\.0 \(s = -50\.1 mm\): reaches beyond": Limit(
        lambda s: SMALL_DOMAIN | line("x", s, 3.0), -50.0, -50.1
    ),
    r"lines\.0 \(x = -50\.1 mm\): reaches beyond": Limit(
        lambda x: SMALL_DOMAIN | line("s", x, 3.0), -50.0, -50.1
    ),
    r"reaches beyond half .* \(31\.4159 mm\)": Limit(
        lambda reach: SMALL_WHEEL | line("x", 0.0, reach), 31.4, 31.5
    ),
    r"lines\.0 \(s = 8\.01 mm\): beyond the contour, s = -9 to 8 mm": Limit(
        lambda s: LEFT | line("x", s, 3.0), 7.99, 8.01
    ),
    r"lines\.0 \(s = -8\.01 mm\): beyond the contour, s = -8 to 9 mm": Limit(
        lambda s: RIGHT | line("x", s, 3.0), -7.99, -8.01
    ),
    r"reaches beyond half the height of the hub of the lower body.* enlarge lower\.rolling_radius": Limit(
        lambda s: ROLLER | line("x", s, 3.0), HUB_AT - 0.01, HUB_AT + 0.01
    ),
    rf"upper\.nu = 0\.4901: {NOT_SOLID} above 0\.49": Limit(
        lambda nu: SOLID | both({"nu": 0.49}) | upper(nu=nu), 0.49, 0.4901
    ),
    rf"upper\.rolling_radius = 49\.9: {NOT_SOLID} below 50": Limit(
        lambda radius: SOLID | upper(rolling_radius=radius), 50.0, 49.9
    ),
    r"patch\.a / patch\.b = 10\.05: use engine\.kind = 'harmonic' .* outside 0\.1 \.\.\. 10,": Limit(
        lambda a: SOLID | patch(a, 0.2), 2.0, 2.01
    ),
    r"patch\.a / patch\.b = 0\.0995025: use": Limit(lambda b: SOLID | patch(0.2, b), 2.0, 2.01),
    r"upper\.contour: inclined up to 75\.1 degrees; at most 75: cut it there": Limit(
        lambda angle: SOLID | {"upper": arc(angle)}, 75.0, 75.1
    ),
    r"upper\.contour: inclined up to 75\.1 degrees": Limit(
        lambda angle: SOLID | {"upper": arc([angle, 20.0])}, 75.0, 75.1
    ),
    r"grid: 16 strips of 1\.01 mm go from s = -8\.08 to 8\.08 mm, the contours from -8 to 8 mm": Limit(
        lambda ds: MEASURED | grid(n_s=16, ds=ds), 1.0, 1.01
    ),
    r"grid: 4 strips of 1 mm go from s = 4\.01 to 8\.01 mm": Limit(
        lambda s: MEASURED | grid(n_s=4, ds=1.0, s=s), 5.99, 6.01
    ),
    r"grid: 4 strips of 1 mm go from s = -8\.01 to -4\.01 mm": Limit(
        lambda s: MEASURED | grid(n_s=4, ds=1.0, s=s), -5.99, -6.01
    ),
    r"grid\.dx / grid\.ds = 101 is outside 0\.01 \.\.\. 100": Limit(
        lambda dx: grid(n_x=1, dx=dx, ds=0.1), 10.0, 10.1
    ),
    r"grid\.dx / grid\.ds = 0\.00990\d+ is outside": Limit(lambda ds: grid(n_s=1, dx=0.1, ds=ds), 10.0, 10.1),
    r"grid: 33 elements of 1 mm are more than half of half a turn \(62\.8319 mm\)": Limit(
        lambda n: SMALL_WHEEL | SHORT | grid(n_x=n, dx=1.0, n_s=2, ds=1.0), 32, 33
    ),
    r"lines\.0 \(s = 0 mm\): reaches 25\.3 mm, 1\.01e\+04 times .* most 10000 .* shorten it to 25 mm": Limit(
        lambda reach: SMALL | line("x", 0.0, reach), 25.0, 25.3
    ),
    r"lines\.0 .* reaches 25\.\d+ mm": Limit(lambda reach: SMALL | line("x", 20.0, reach), 15.0, 15.4),
    r"rotation_reach: reaches 25\.3 mm, 1\.01e\+04 times patch\.b": Limit(
        lambda y: SMALL | SHORT | {"rotation_reach": y}, 25.0, 25.3
    ),
    r"engine\.far_radius = 12500\.5: 5e\+06 times patch\.b = 0\.0025, .*at most 5e\+06 times": Limit(
        lambda radius: SMALL | SHORT | engine(far_radius=radius), 12500.0, 12500.5
    ),
    r"rotation_reach: reaches 25\.3 mm, 1\.01e\+04 times grid\.dx / 2 = 0\.0025": Limit(
        lambda y: FINE | {"rotation_reach": y}, 25.0, 25.3
    ),
    r"calibration \(fit s = 0 mm\): reaches 25\.3 mm": Limit(
        lambda x: SMALL | SHORT | {"calibration": {"x_max": x, "s": [0.0]}}, 25.0, 25.3
    ),
    r"lines\.0 .* 1\.01e\+03 times patch\.a = 0\.025, .*at most 1000 times by engine\.kind = 'solid'": Limit(
        lambda reach: patch(0.025, 0.05) | SOLID | line("x", 0.0, reach), 25.0, 25.3
    ),
    r"calibration\.x_min, x_max: x_max must be larger than x_min": Limit(
        lambda x: fit(x_min=x, x_max=5.0), 4.99, 5.0
    ),
    r"calibration\.x \(fit x = 1 mm\): not beyond x_min = 1 mm": Limit(
        lambda x: fit(x=[x], x_min=1.0, s=[]), 1.01, 1.0
    ),
    r"calibration \(fit s = 8\.01 mm\): beyond the contour, s = -8 to 8 mm": Limit(
        lambda s: MEASURED | fit(s=[s]), 7.99, 8.01
    ),
    r"calibration\.x_max: points 50\.08 mm away, more than half of 100 mm: reduce it": Limit(
        lambda x: SMALL_DOMAIN | fit(s=[30.0], x_max=x), 40.0, 40.1
    ),
    r"calibration\.x_max: points 31\.5 mm away, more than half of 62\.83\d* mm": Limit(
        lambda x: SMALL_WHEEL | SHORT | fit(s=[0.0], x_max=x), 31.4, 31.5
    ),
    r"calibration\.curvature = 'apart': only of the combined bodies": Limit(
        lambda body: fit(bodies=[body], curvature="apart"), "combined", "upper"
    ),
    r"calibration\.s, calibration\.x: two of the lines are the same": Limit(
        lambda s: fit(s=[s, 1.0], x=[2.0, 3.0]), 0.0, 1.0
    ),
    r"calibration\.bodies: lower not in bodies = upper: add it": Limit(
        lambda bodies: {"bodies": ["upper"]} | fit(bodies=bodies), ["upper"], ["lower", "upper"]
    ),
}


@pytest.mark.parametrize(("message", "limit"), LIMITS.items())
def test_scene_is_refused_from_its_limit_on(message, limit):
    load_scene("flat", limit.changes(limit.allowed))
    with pytest.raises(BadScene, match=message) as caught:
        load_scene("flat", limit.changes(limit.refused))
    assert str(caught.value).startswith("flat: 1 error(s)")  # and no other


def test_scene_in_tiny_lengths_is_valid():
    """All lengths a millionth: no length is too small, ratios are."""
    tiny = patch(2e-7, 3e-7) | engine(far_radius=1.28e-3) | {"rotation_reach": 20e-6, "moment_arm": 5e-6}
    assert load_scene("flat", tiny | line("x", 0.0, 25e-6)).patch.a == 2e-7


def test_default_lines_of_a_distant_patch_add_no_error():
    with pytest.raises(BadScene, match=r"patch\.s = 1e\+12: beyond half"):
        load_scene("flat", patch(0.2, 0.3, 1e12))


@pytest.mark.parametrize("needing", [{"variants": ["Bhat_prime"]}, {"ics": "Bhat_prime"}])
def test_bhat_prime_needs_effective_properties_of_a_compared_body(needing):
    for bodies in (["lower"], ["lower", "upper"]):
        assert load_scene("flat", needing | PROPERTY | {"bodies": bodies}).pair.has_effective("lower")
    with pytest.raises(BadScene, match=r"Bhat_prime.* effective properties"):
        load_scene("flat", needing | PROPERTY | {"bodies": ["upper"]})


def test_the_direct_solver_is_refused_where_it_is_not_installed(monkeypatch):
    monkeypatch.setattr(engine_table, "direct_available", lambda: True)
    assert load_scene("flat", engine(solver="direct")).settings.solver == "direct"
    monkeypatch.setattr(engine_table, "direct_available", lambda: False)
    with pytest.raises(BadScene, match=r"engine\.solver = 'direct': not installed; run .*pip install"):
        load_scene("flat", engine(solver="direct"))
    assert load_scene("flat").settings.solver == "auto"
