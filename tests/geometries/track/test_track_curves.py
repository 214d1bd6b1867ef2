import numpy as np
import pytest
from track_sections import rail_through

from geometries.profiles.files import read_profile
from geometries.profiles.pieces import ArcPiece, Outline
from geometries.profiles.preparation import prepare
from geometries.profiles.standards import NAMED, standard
from geometries.track import curves
from geometries.track.curves import Moved, quintics, sampled

R = 13.0


def circle(n=200, start=-0.4, end=np.pi + 0.3):
    """Points from an undercut to another one, over the top."""
    angle = np.linspace(end, start, n)
    return R * np.stack([np.cos(angle), np.sin(angle)])


def test_a_moved_curve_is_turned_and_offset():
    groove = rail_through(circle() * [[1.0], [-1.0]])
    moved = Moved(groove, 0.3, (5.0, -2.0))
    t = np.linspace(5.0, 30.0, 12)
    assert np.all(groove.curvature(t) < -0.9 / R)
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(moved.position(t), turn @ groove.position(t) + [[5.0], [-2.0]], atol=1e-13)
    step = 1e-4
    derivative = (moved.position(t + step) - moved.position(t - step)) / (2 * step)
    np.testing.assert_allclose(moved.tangent(t), derivative, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(moved.curvature(t), groove.curvature(t))
    grid = t.reshape(3, 4)
    np.testing.assert_array_equal(moved.position(grid), moved.position(t).reshape(2, 3, 4))
    np.testing.assert_array_equal(moved.tangent(grid), moved.tangent(t).reshape(2, 3, 4))
    assert np.max(np.diff(sampled(moved, 0.3).t)) <= 0.3


@pytest.mark.parametrize(
    ("curve", "sharpest"),
    [
        (standard("60E1").outline, 13.0),
        (standard("S1002").outline, 12.0),
        (rail_through(circle()), R),
        (prepare(read_profile(NAMED["S1002-worn"].path), 0.004), 9.0),
    ],
    ids=["60E1", "S1002", "circle", "smoothed"],
)
def test_a_point_at_once_is_that_of_the_curve(curve, sharpest):
    """On both sides of all joints and knots, and between: rounding of points, and that over 0.05 mm."""
    moved = Moved(curve, 0.3, (5.0, -2.0))
    joints = np.array(curve.jumps) if curve.jumps else np.linspace(1.0, curve.length - 1, 57)
    t = np.concatenate([np.linspace(0, curve.length, 997), joints - 1e-7, joints + 1e-7, [-1.0]])
    points = np.array([moved.at(float(each)) for each in t]).T
    np.testing.assert_allclose(points[:2], moved.position(t), rtol=0, atol=5e-13)
    np.testing.assert_allclose(points[2:4], moved.tangent(t), rtol=0, atol=2e-11)
    np.testing.assert_allclose(points[4], moved.curvature(t), rtol=0, atol=1e-8 / sharpest)
    own = moved.unmoved(moved.at(3.0))
    np.testing.assert_allclose(own, curve.position(3.0), rtol=0, atol=1e-13)


def test_the_error_of_quintics_falls_with_the_sixth_power_of_their_length(monkeypatch):
    """An arc of the radius R: h^6 / 46080 / R^5 in the middle of a piece, across it (Hermite's remainder)."""
    arc, errors = ArcPiece((0.0, 0.0), 0.0, 1 / R, 20.0), []
    for length in (5.0, 2.5):
        monkeypatch.setattr(curves, "PIECE", length)
        middle = np.array(length / 2)
        y, z, *_ = quintics(Outline((arc,))).at(float(middle))
        errors.append(np.hypot(*(np.array([y, z]) - arc.position(middle))))
        assert errors[-1] == pytest.approx(length**6 / 46080 / R**5, rel=0.1)
    assert errors[0] / errors[1] == pytest.approx(64, rel=0.1)


def test_beyond_its_ends_the_ends_of_a_curve_stand():
    moved = Moved(rail_through(circle()), 0.1, (1.0, 2.0))
    first, last = moved.limits
    beyond, ends = [first - 3, last + 3], [first, last]
    np.testing.assert_array_equal(moved.position(beyond), moved.position(ends))
    np.testing.assert_array_equal(moved.tangent(beyond), moved.tangent(ends))
