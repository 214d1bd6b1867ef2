"""Keys of a scene file: the range of each, and the message beyond it."""

import re
from copy import deepcopy
from pathlib import Path

import pytest

from compare.scenes.errors import BadScene
from compare.scenes.load import parse
from tests.compare.scenes.changes import PROPERTY, arc, ellipse

INF, NAN = float("inf"), float("nan")
POSITIVE, FINITE = ((1e-300, 1e300), (0.0, -1.0, INF, NAN)), ((-1e300, 1e300), (INF, -INF, NAN))
RANGES = {  # key: (values allowed, values refused)
    "lower.E": POSITIVE,
    "upper.nu": ((0.0, 0.4999), (-1e-9, 0.49991, NAN)),
    "lower.rolling_radius": ((20.0, INF), (19.99, -50.0, NAN)),
    "upper.hub_radius": POSITIVE,
    "lower.contour.radius": ((1e-3, 1e6, -10.0), (0.0, -0.0, INF, NAN)),
    "lower.contour.flank_inclination_deg": ((0.0, 85.0), (-0.1, 85.1, NAN)),
    "upper.contour.b_el": POSITIVE,
    "upper.contour.d_el": POSITIVE,
    "upper.contour.flank_inclination_deg": ((0.0, 85.0), (-0.1, 85.1)),
    "patch.s": FINITE,
    "lines.0.s": FINITE,
    "lines.1.x": FINITE,
    "lines.0.reach": POSITIVE,
    "lines.1.reach": POSITIVE,
    "lines.0.points": ((2, 5000), (1, 5001)),
    "lines.1.points": ((2, 5000), (1, 5001)),
    "grid.n_x": ((1, 4096), (0, 4097)),
    "grid.n_s": ((1, 512), (0, 513)),
    "grid.dx": POSITIVE,
    "grid.ds": POSITIVE,
    "grid.s": FINITE,
    "grid.check": ((0, 9), (-1, 10)),
    "effective.lower.nu.far": FINITE,
    "effective.lower.nu.r_inf": POSITIVE,
    "effective.lower.nu.m": POSITIVE,
    "effective.lower.nu.n": POSITIVE,
    "calibration.x_min": POSITIVE,
    "calibration.x_max": POSITIVE,
    "calibration.points": ((8, 5000), (7, 5001)),
    "engine.tolerance": ((1e-4, 1.0), (0.99e-4, 1.01, NAN)),
    "engine.most_unknowns": ((1000,), (999,)),
    "engine.smallest_cell": POSITIVE,
    "engine.growth": ((0.02, 0.5), (0.0199, 0.501)),
    "engine.line_growth": ((0.02, 0.5), (0.0199, 0.501)),
    "engine.far_radius": POSITIVE,
    "engine.half_length": POSITIVE,
    "reference_length": POSITIVE,
    "rotation_reach": POSITIVE,
    "moment_arm": POSITIVE,
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


@pytest.mark.parametrize("key", RANGES)
def test_each_number_has_its_range_and_a_message_with_field_and_value(key):
    allowed, refused = RANGES[key]
    for value in allowed:
        parse(with_value(key, value), Path("mine.toml"))
    for value in refused:
        with pytest.raises(BadScene) as caught:
            parse(with_value(key, value), Path("mine.toml"))
        assert f"{key} = {value!r}: " in str(caught.value)


@pytest.mark.parametrize("key", RANGES)
def test_texts_and_truths_are_no_numbers(key):
    allowed, _ = RANGES[key]
    for value in (str(allowed[0]), True, False):
        with pytest.raises(BadScene) as caught:
            parse(with_value(key, value), Path("mine.toml"))
        assert f"{key} = {value!r}: " in str(caught.value)


@pytest.mark.parametrize("key", ["contact.flanks", "contact.supports", "engine.check", "fields"])
def test_numbers_and_texts_are_neither_true_nor_false(key):
    for value in (0, 1, 1.0, "true", "yes"):
        with pytest.raises(BadScene, match=rf"{key} = {value!r}: Input should be true or false"):
            parse(with_value(key, value), Path("mine.toml"))


def test_numbers_that_are_whole_count_elements_however_they_are_written():
    """Values of campaigns are multiples of others."""
    assert parse(with_value("grid.n_x", 16.0), Path("mine.toml")).grid.n_x == 16
    with pytest.raises(BadScene, match=r"grid\.n_x = 16\.5: "):
        parse(with_value("grid.n_x", 16.5), Path("mine.toml"))


@pytest.mark.parametrize(("a", "b", "allowed"), [(1, 100, 1), (100, 1, 1), (0.99, 100, 0), (100.1, 1, 0)])
def test_the_aspect_of_a_patch_has_its_range(a, b, allowed):
    table = WHOLE | {"patch": {"a": a, "b": b}}
    if allowed:
        assert parse(table, Path("mine.toml")).patch.a == a
    else:
        with pytest.raises(BadScene, match=rf"a / b = {a / b:g} is outside 0\.01 \.\.\. 100"):
            parse(table, Path("mine.toml"))


@pytest.mark.parametrize(("flanks", "field"), [([20, 95], ".1 = 95"), ("steep", " = 'steep'")])
def test_of_a_value_of_several_types_only_errors_of_its_own_type_are_listed(flanks, field):
    """Flanks are a number or two."""
    told = rf"1 error\(s\)\n  lower\.contour\.flank_inclination_deg{re.escape(field)}: "
    with pytest.raises(BadScene, match=told):
        parse(with_value("lower.contour.flank_inclination_deg", flanks), Path("mine.toml"))


def test_a_missing_key_says_add_it_and_a_missing_file_where_it_is_looked_for():
    without = deepcopy(WHOLE)
    del without["lower"]["E"]
    with pytest.raises(BadScene, match=r"  lower\.E: .*required; add the key"):
        parse(without, Path("mine.toml"))
    nowhere = with_value("lower.contour", {"kind": "points", "file": "no.txt"})
    with pytest.raises(BadScene, match=r"lower\.contour\.file = 'folder/no\.txt': .*; give a path"):
        parse(nowhere, Path("folder/mine.toml"))


def test_long_values_are_cut_in_messages():
    with pytest.raises(BadScene) as caught:
        parse(with_value("title", list(range(1000))), Path("mine.toml"))
    shown = str(caught.value).split("title = ")[1].split(": ")[0]
    assert shown == repr(list(range(1000)))[:80]
