"""Bodies in Python are those of scene files; nouns and scenes are the same after pickling."""

import pickle
import subprocess
import sys
from itertools import product

import numpy as np
import pytest
import xarray as xr

import femic
from femic.interface.options import make_scene
from femic.results.contact import compute_contact
from femic.results.ics import approximation, scene_points
from femic.scenes.load import builtin_names, load_scene

STEEL = femic.Material(E=210e3, nu=0.3)


def geometry(body):
    """What the solvers see of a body."""
    s = np.linspace(-15, 15, 61)
    return np.concatenate([*body.contour.position(s), body.contour.inclination(s)])


@pytest.mark.parametrize("name", builtin_names())
def test_loaded_pair_equals_the_pair_of_its_scene(name):
    scene, pair = load_scene(name), femic.load_pair(name)
    again = make_scene(pair, femic.Options())
    assert again.pair.effective == scene.pair.effective
    for body in ("upper", "lower"):
        ours, theirs = again.bodies[body], scene.bodies[body]
        np.testing.assert_array_equal(geometry(ours), geometry(theirs))
        assert (ours.material, ours.surface.side) == (theirs.material, theirs.surface.side)
        assert (ours.rolling_radius, ours.hub_radius) == (theirs.rolling_radius, theirs.hub_radius)


def test_bodies_of_python_equal_those_of_a_file():
    """Of the scene `rolling`, whose contours are an ellipse and an arc."""
    wheel = femic.Body(femic.ellipse(10.15, 10.25, 60.0), STEEL, rolling_radius=500.0)
    file = femic.load_pair("rolling")
    assert femic.Pair(wheel, femic.Body(femic.arc(10.0, 65.0), STEEL)) == femic.Pair(file.upper, file.lower)


def test_contours_are_those_that_their_arguments_say():
    """Flanks may differ, grooves have negative radii, a curve goes through its points, a plane is flat."""
    groove = femic.arc(-20.0, (10.0, 40.0)).contour()
    np.testing.assert_allclose(np.degrees(groove.inclination([-99, 99])), [10, -40], rtol=1e-12)
    y = np.linspace(-8, 8, 41)
    curve = femic.through_points(y, -(y**2) / 20, y_centre=1.0).contour()
    np.testing.assert_allclose(curve.position(0.0), [0, 0], atol=1e-12)
    assert np.tan(curve.inclination(0.0)) == pytest.approx(0.1, rel=1e-3)
    assert np.all(femic.plane().contour().inclination(np.linspace(-5, 5, 7)) == 0)


def test_a_modulus_in_pascal_is_said_and_a_rigid_body_is_solved():
    with pytest.warns(UserWarning, match=r"E = 2\.1e\+11: .* E is in MPa: 210e3 for steel") as told:
        femic.Body(femic.plane(), femic.Material(210e9, 0.3))
    assert [each.filename for each in told] == [__file__]
    femic.Body(femic.plane(), femic.Material(1.2e6, 0.1))  # diamond, without a word


def test_numpy_numbers_are_accepted():
    steel = femic.Material(np.float64(210e3), np.float64(0.3))
    flanks = np.array([20.0, 30.0])
    ours = femic.Body(femic.arc(np.float64(10.0), flanks), steel, np.int64(500))
    assert ours == femic.Body(femic.arc(10.0, (20.0, 30.0)), STEEL, 500.0)
    assert femic.line_along_s(np.float64(1.6), points=np.int64(5)) == femic.line_along_s(1.6, points=5)
    assert hash(ours) == hash(femic.Body(femic.arc(10.0, (20.0, 30.0)), STEEL, 500.0))


# --- pickling ------------------------------------------------------------------------------------------


RAIL = femic.Profile(standard="60E1")
PAIR = femic.Pair(
    femic.Body(femic.ellipse(20.0, 30.0, 40.0), STEEL, rolling_radius=300.0, hub_radius=100.0),
    femic.Body(femic.through_points([-9.0, -4.0, 1.0, 8.0], [1.0, 0.2, 0.0, 0.9]), STEEL),
)
GRID = femic.Grid(n_x=4, n_s=3, dx=0.2, ds=0.3)
NOUNS = (
    *(STEEL, GRID, PAIR, femic.load_pair("geometry2"), femic.Patch(0.3, 0.2, s=1.0)),
    *(femic.plane(), femic.arc(-20.0, 30.0), RAIL, RAIL.at(y_centre=-8.0, rail_inclination=0.025)),
    *(femic.line_along_x(0.3), femic.line_along_s(1.0), femic.Options(store="out/store", report=print)),
    *(femic.Frictionless([1e3, 2e3]), femic.Rolling(1e3, 0.3), femic.TransientRolling(1e3, 0.3)),
    *(femic.Compression([1e3], [0.2, 0.3]), femic.FittedPair(PAIR, xr.Dataset({"value": 1.0}))),
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
    for noun in (setup, femic.points([0.0, 1.0], [2.0, 3.0])):
        for name, value in vars(noun).items():
            np.testing.assert_array_equal(getattr(pickled(noun), name), value)
    for error in (femic.WrongInput("a = 1"), femic.Failure("no solution")):
        assert (type(pickled(error)), str(pickled(error))) == (type(error), str(error))


@pytest.mark.parametrize("keys", [{"standard": "S1002"}, {"standard": "60E1-worn"}, {"tolerance": 0.01}])
def test_profiles_are_understood_and_written_alike_after_pickling(keys, tmp_path):
    if "standard" not in keys:
        femic.write_profile(RAIL, tmp_path / "rail.prr")
        keys |= {"file": tmp_path / "rail.prr"}
    profile, ending = femic.Profile(**keys), "prw" if keys.get("standard") == "S1002" else "prr"
    xr.testing.assert_identical(pickled(profile).data, profile.data)
    files = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    for file, each in zip(files, (profile, pickled(profile)), strict=True):
        femic.write_profile(each, file)
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.parametrize("name", builtin_names())
def test_scenes_give_the_same_ics_by_the_same_engine_after_pickling(name):
    scene = femic.load_scene(name)
    other, (points, _) = pickled(scene), scene_points(scene)
    for variant, body in product(("A", "Bhat"), scene.compared):
        ours, theirs = (approximation(each, variant, body, points) for each in (scene, other))
        np.testing.assert_array_equal(ours, theirs)
    assert other.settings.engine is scene.settings.engine


def test_a_pickled_scene_has_the_same_contact_and_is_taken_by_a_process_that_imported_nothing(tmp_path):
    scene = femic.load_scene("s1002-on-60e1", {"contact": {"loads": [9e4], "ics": ["A"], "elements": 8}})
    ours, theirs = (compute_contact(each).drop_vars("seconds") for each in (scene, pickled(scene)))
    xr.testing.assert_equal(ours, theirs)
    (tmp_path / "scene").write_bytes(pickle.dumps(scene))
    code = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).settings.engine.name)"
    command = [sys.executable, "-c", code, str(tmp_path / "scene")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "harmonic\n"
