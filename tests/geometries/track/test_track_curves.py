import numpy as np
import pytest
from track_sections import rail_through

from geometries.profiles.files import read_profile
from geometries.profiles.pieces import ArcPiece, Outline
from geometries.profiles.preparation import prepare
from geometries.profiles.standards import NAMED, standard
from geometries.track import curves
from geometries.track.curves import Moved, quintics, sampled
from geometries.track.touching import refined

R = 13.0


def circle(n=200, start=-0.4, end=np.pi + 0.3):
    """Points from an undercut to another one, over the top."""
    angle = np.linspace(end, start, n)
    return R * np.stack([np.cos(angle), np.sin(angle)])


def test_a_moved_curve_is_turned_and_offset():
    groove = rail_through(circle() * [[1.0], [-1.0]])
    moved = Moved(groove, 0.3, (5.0, -2.0))
    t = np.linspace(5.0, 30.0, 11)
    assert np.all(groove.curvature(t) < -0.9 / R)
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(moved.position(t), turn @ groove.position(t) + [[5.0], [-2.0]], atol=1e-13)
    step = 1e-4
    derivative = (moved.position(t + step) - moved.position(t - step)) / (2 * step)
    np.testing.assert_allclose(moved.tangent(t), derivative, rtol=0, atol=1e-8)
    np.testing.assert_array_equal(moved.curvature(t), groove.curvature(t))


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


def test_shapes_of_the_arguments_are_those_of_the_results():
    for curve in (rail_through(circle()), standard("60E1").outline):
        moved = Moved(curve, 0.1, (1.0, 2.0))
        for shape in ((), (3,), (2, 3)):
            t = np.full(shape, 11.0)
            assert moved.position(t).shape == moved.tangent(t).shape == (2, *shape)
            assert np.shape(moved.curvature(t)) == shape
        grid = np.linspace(1, 9, 6).reshape(2, 3)
        np.testing.assert_allclose(moved.position(grid)[:, 1, 2], moved.position(grid[1, 2]), rtol=1e-14)


def test_beyond_its_ends_the_ends_of_a_curve_stand():
    moved = Moved(rail_through(circle()), 0.1, (1.0, 2.0))
    first, last = moved.limits
    beyond, ends = [first - 3, last + 3], [first, last]
    np.testing.assert_array_equal(moved.position(beyond), moved.position(ends))
    np.testing.assert_array_equal(moved.tangent(beyond), moved.tangent(ends))


def test_samples_are_no_farther_apart_than_their_spacing():
    samples = sampled(Moved(rail_through(circle()), 0.0, (0.0, 0.0)), 0.3)
    assert np.max(np.diff(samples.t)) <= 0.3
    assert samples.points.shape == samples.tangents.shape == (2, len(samples.t))


def test_a_touching_point_on_a_joint_that_does_not_meet_exactly_is_found():
    """The flange face of S1002 and the arc beside it differ by 4e-6 rad at their joint."""
    outline = standard("S1002").outline
    k = int(np.argmax(np.abs(outline.gaps[1])))
    joint, turn = outline.jumps[k], outline.gaps[1][k]
    assert abs(turn) > 1e-6
    before, after = (float(outline.inclination(joint + step)) for step in (-1e-9, 0.0))
    wheel, y_z = Moved(outline, 0.0, (0.0, 0.0)), outline.position(joint)
    # a rail of radius 6 mm whose normal at the contact passes through the joint, half way between both angles
    angle = -(before + after) / 2
    circle_points = 6.0 * np.stack(
        [-np.cos(np.linspace(-0.4, np.pi + 0.4, 400)), np.sin(np.linspace(-0.4, np.pi + 0.4, 400))]
    )
    centre = y_z - 6.0 * np.array([-np.sin(angle), np.cos(angle)])
    rail = Moved(rail_through(circle_points), 0.0, (float(centre[0]), float(centre[1])))
    nearest = np.linspace(*rail.limits, 4001)
    apart = np.hypot(*(rail.position(nearest) - y_z[:, None]))
    t = float(nearest[np.argmin(apart)])
    minimum = refined(rail, wheel, (t - 0.05, t + 0.05), joint)
    assert minimum is not None
    np.testing.assert_allclose(minimum.t_wheel, joint, rtol=0, atol=1e-3)
