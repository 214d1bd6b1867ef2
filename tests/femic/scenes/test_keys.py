"""Keys of a scene file: the range of each, and the message beyond it."""

from copy import deepcopy
from pathlib import Path

import pytest

from femic.scenes.errors import BadScene
from femic.scenes.load import parse
from tests.femic.scenes.changes import PROPERTY, arc, ellipse, patch

INF, NAN = float("inf"), float("nan")
LENGTH = (1e-12, 1e12), (0.0, -1.0, 0.99e-12, 1.01e12, INF, NAN)
PLACE = (-1e12, 0.0, 1e12), (-1.01e12, 1.01e12, INF, -INF, NAN)
AMOUNT = (1e-15, 1e15), (0.0, -1.0, 0.99e-15, 1.01e15, INF, NAN)
SIGNED = (-1e15, 0.0, 1e15), (-1.01e15, 1.01e15, INF, -INF, NAN)
EXPONENT = (1e-3, 1000.0), (0.0, -1.0, 1001.0, INF, NAN)
RANGES = {  # key: (values allowed, values refused)
    "lower.E": AMOUNT,
    "upper.nu": ((0.0, 0.4999), (-1e-9, 0.49991, NAN)),
    "lower.rolling_radius": ((1e-12, 1e12, INF), (0.0, -50.0, 1.01e12, NAN)),
    "upper.hub_radius": LENGTH,
    "lower.contour.radius": ((1e-12, 1e12, -1e-12, -1e12), (0.0, 0.99e-12, -1.01e12, INF, NAN)),
    "lower.contour.flank_inclination_deg": ((0.0, 85.0), (-0.1, 85.1, NAN)),
    "upper.contour.b_el": LENGTH,
    "upper.contour.d_el": LENGTH,
    "upper.contour.flank_inclination_deg": ((0.0, 85.0), (-0.1, 85.1)),
    "patch.s": PLACE,
    "lines.0.s": PLACE,
    "lines.1.x": PLACE,
    "lines.0.reach": LENGTH,
    "lines.1.reach": LENGTH,
    "lines.0.points": ((2, 5000), (1, 5001)),
    "lines.1.points": ((2, 5000), (1, 5001)),
    "grid.n_x": ((1, 4096), (0, 4097)),
    "grid.n_s": ((1, 512), (0, 513)),
    "grid.dx": LENGTH,
    "grid.ds": LENGTH,
    "grid.s": PLACE,
    "grid.check": ((0, 9), (-1, 10)),
    "effective.lower.nu.far": SIGNED,
    "effective.lower.nu.r_inf": LENGTH,
    "effective.lower.nu.m": EXPONENT,
    "effective.lower.nu.n": EXPONENT,
    "calibration.x_min": LENGTH,
    "calibration.x_max": LENGTH,
    "calibration.points": ((8, 5000), (7, 5001)),
    "engine.tolerance": ((1e-4, 1.0), (0.99e-4, 1.01, NAN)),
    "engine.most_unknowns": ((1000,), (999,)),
    "engine.smallest_cell": LENGTH,
    "engine.growth": ((0.02, 0.5), (0.0199, 0.501)),
    "engine.line_growth": ((0.02, 0.5), (0.0199, 0.501)),
    "engine.far_radius": LENGTH,
    "engine.half_length": LENGTH,
    "reference_length": LENGTH,
    "contact.shift": PLACE,
    "contact.lateral_force": SIGNED,
    "contact.shape_load": AMOUNT,
    "stresses.friction": ((1e-3, 1000.0), (0.0, -0.3, 1001.0, INF, NAN)),
    "stresses.force": ((-0.99, 0.0, 0.99), (-1.0, 1.0, 1.5, NAN)),
    "stresses.fineness": ((0.1, 10.0), (0.099, 10.1, -1.0, NAN)),
    "damage.yield_stress": AMOUNT,
    "damage.hardness": AMOUNT,
    "damage.speed": AMOUNT,
    "damage.energy.mild": AMOUNT,
    "damage.energy.transition": AMOUNT,
    "damage.twin_disc.catastrophic": AMOUNT,
    "damage.archard.pressure_share": AMOUNT,
    "damage.dang_van.hydrostatic": ((0.0, 1.0), (-0.1, INF, NAN)),
    "damage.dang_van.compression": ((0.0, 1.0), (-0.1, 1.1, NAN)),
    "rotation_reach": LENGTH,
    "moment_arm": LENGTH,
    "ics_tolerance": ((1e-12, 1.0), (0.0, 1.01)),
}
WHOLE = {
    "lower": {"E": 210e3, "nu": 0.3} | arc(30.0),
    "upper": {"E": 70e3, "nu": 0.2} | ellipse(9.0, 7.0),
    "patch": {"a": 0.2, "b": 0.3},
    "lines": [{"along": "x", "s": 0.0}, {"along": "s", "x": 1.0}],
    **PROPERTY,
}


def with_value(key, value):
    """A whole scene in which one key has a value."""
    table = deepcopy(WHOLE)
    *path, last = (int(part) if part.isdigit() else part for part in key.split("."))
    at = table
    for part in path:
        at = at[part] if isinstance(at, list) else at.setdefault(part, {})
    at[last] = value
    return table


def read(table):
    return parse(table, Path("mine.toml"))


@pytest.mark.parametrize("key", RANGES)
def test_numbers_out_of_range_strings_and_booleans_are_refused_with_field_and_value(key):
    allowed, refused = RANGES[key]
    for value in allowed:
        read(with_value(key, value))
    for value in (*refused, str(allowed[0]), True, False):
        with pytest.raises(BadScene) as caught:
            read(with_value(key, value))
        assert f"{key} = {value!r}: " in str(caught.value)


@pytest.mark.parametrize(
    "key", ["contact.flanks", "contact.supports", "engine.check", "fields", "stresses.estimated"]
)
def test_numbers_and_strings_are_refused_as_booleans(key):
    for value in (0, 1, 1.0, "true", "yes"):
        with pytest.raises(BadScene, match=rf"{key} = {value!r}: Input should be true or false"):
            read(with_value(key, value))


def test_whole_floats_are_accepted_as_integers():
    """Values of campaigns are multiples of others."""
    assert read(with_value("grid.n_x", 16.0)).grid.n_x == 16
    with pytest.raises(BadScene, match=r"grid\.n_x = 16\.5: "):
        read(with_value("grid.n_x", 16.5))


def test_aspect_of_a_patch_is_limited():
    for a, b in ((1, 100), (100, 1)):
        assert read(WHOLE | patch(a, b)).patch.a == a
    for a, b in ((0.99, 100), (100.1, 1)):
        with pytest.raises(BadScene, match=rf"a / b = {a / b:g} is outside 0\.01 \.\.\. 100"):
            read(WHOLE | patch(a, b))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("lower.contour.flank_inclination_deg", [20, 95], r"lower\.contour\.flank_inclination_deg\.1 = 95: "),
        (
            "lower.contour.flank_inclination_deg",
            "steep",
            r"lower\.contour\.flank_inclination_deg = 'steep': ",
        ),
        ("lines", [{"along": "x", "s": 0.0, "reach": -1.0}], r"lines\.0\.reach = -1\.0: "),
        ("lines", [], r"lines = \[\]: "),
    ],
)
def test_a_value_of_several_types_has_the_error_of_its_own_alone(key, value, message):
    """Flanks are a number or two; a list with wrong entries is not said to be short."""
    with pytest.raises(BadScene, match=rf"1 error\(s\)\n  {message}"):
        read(with_value(key, value))


def test_missing_keys_and_files_are_reported_with_a_remedy():
    without = deepcopy(WHOLE)
    del without["lower"]["E"]
    with pytest.raises(BadScene, match=r"  lower\.E: .*required; add the key"):
        read(without)
    with pytest.raises(BadScene, match=r"lower\.contour\.file = 'no\.txt': .*; give a path"):
        read(with_value("lower.contour", {"kind": "points", "file": "no.txt"}))


def test_long_values_are_shortened_in_messages():
    with pytest.raises(BadScene) as caught:
        read(with_value("title", list(range(1000))))
    shown = str(caught.value).split("title = ")[1].split(": ")[0]
    assert shown == repr(list(range(1000)))[:80]
