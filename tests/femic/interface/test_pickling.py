"""Public nouns and scenes go to other processes: they are pickled, and give the same results after."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import femic
from femic.results.contact import compute_contact
from femic.results.ics import approximation, scene_points
from femic.scenes.load import builtin_names

STEEL = femic.Material(E=210e3, nu=0.28)
RAIL = femic.Profile(standard="60E1")
PAIR = femic.Pair(
    femic.Body(femic.ellipse(20.0, 30.0, 40.0), STEEL, rolling_radius=300.0, hub_radius=100.0),
    femic.Body(femic.through_points([-9.0, -4.0, 1.0, 8.0], [1.0, 0.2, 0.0, 0.9]), STEEL),
)
GRID = femic.Grid(n_x=4, n_s=3, dx=0.2, ds=0.3)
NOUNS = (
    *(
        STEEL,
        GRID,
        PAIR,
        femic.load_pair("geometry2"),
        femic.Patch(0.3, 0.2, s=1.0),
        femic.plane(),
        femic.arc(-20.0, 30.0),
    ),
    *(femic.line_along_x(0.3), femic.line_along_s(1.0), femic.Options(store="out/store", report=print)),
    *(RAIL, RAIL.at(y_centre=-8.0, rail_inclination=0.025)),
    *(femic.Frictionless([1e3, 2e3]), femic.Rolling(1e3, 0.3), femic.TransientRolling(1e3, 0.3)),
    femic.Compression([1e3], [0.2, 0.3]),
    femic.FittedPair(PAIR, xr.Dataset({"value": 1.0})),
)


def pickled(value):
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("noun", NOUNS, ids=lambda noun: type(noun).__name__)
def test_public_nouns_are_the_same_after_pickling(noun):
    assert repr(pickled(noun)) == repr(noun)
    if not isinstance(noun, femic.FittedPair):
        assert pickled(noun) == noun


def test_setups_lines_and_errors_have_the_same_content_after_pickling():
    setup = femic.ContactSetup(elements=9, grid=GRID, extra_gap=[[0.0, 0.1], [1.0, 0.2]])
    line = femic.points([0.0, 1.0], [2.0, 3.0])
    for noun in (setup, line):
        for name, value in vars(noun).items():
            np.testing.assert_array_equal(getattr(pickled(noun), name), value)
    for error in (femic.WrongInput("a = 1"), femic.Failure("no solution")):
        assert (type(pickled(error)), str(pickled(error))) == (type(error), str(error))


@pytest.mark.parametrize("keys", [{"standard": "S1002"}, {"standard": "60E1-worn"}, {"tolerance": 0.01}])
def test_profiles_are_understood_and_written_alike_after_pickling(keys, tmp_path):
    if "standard" not in keys:
        femic.write_profile(RAIL, tmp_path / "rail.prr")
        keys |= {"file": tmp_path / "rail.prr"}
    profile = femic.Profile(**keys)
    xr.testing.assert_identical(pickled(profile).data, profile.data)
    files = [tmp_path / f"{name}.{'prw' if keys.get('standard') == 'S1002' else 'prr'}" for name in "ab"]
    for file, each in zip(files, (profile, pickled(profile)), strict=True):
        femic.write_profile(each, file)
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.parametrize("name", builtin_names())
def test_scenes_give_the_same_ics_by_the_same_engine_after_pickling(name):
    scene = femic.load_scene(name)
    other, (points, _) = pickled(scene), scene_points(scene)
    for variant in ("A", "Bhat"):
        for body in scene.compared:
            np.testing.assert_array_equal(
                *(approximation(each, variant, body, points) for each in (scene, other))
            )
    assert other.settings.engine is scene.settings.engine


def test_a_pickled_scene_has_the_same_contact():
    changes = {"contact": {"loads": [9e4], "ics": ["A"], "elements": 8}}
    scene = femic.load_scene("s1002-on-60e1", changes)
    ours, theirs = (compute_contact(each).drop_vars("seconds") for each in (scene, pickled(scene)))
    xr.testing.assert_equal(ours, theirs)


def test_another_process_that_has_imported_nothing_takes_a_scene(tmp_path):
    (tmp_path / "scene").write_bytes(pickle.dumps(femic.load_scene("s1002-on-60e1")))
    code = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).settings.engine.name)"
    command = [sys.executable, "-c", code, str(tmp_path / "scene")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "harmonic\n"
