"""Bodies in Python are those of scene files, with the same limits."""

import numpy as np
import pytest

import femic
from femic.interface.options import make_scene
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
