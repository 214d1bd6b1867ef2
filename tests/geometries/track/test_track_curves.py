import numpy as np
import pytest

from geometries.contours import length_between
from geometries.errors import WrongInput
from geometries.track.curves import Moved, curve_through, sampled

R = 13.0


def circle(n=200, start=-0.4, end=np.pi + 0.3):
    """Points from an undercut to another one, over the top."""
    angle = np.linspace(end, start, n)
    return R * np.stack([np.cos(angle), np.sin(angle)]), angle


def test_a_curve_through_points_of_a_circle_is_the_circle():
    """Cubic splines: fourth order in the step for points, second for curvature."""
    points, angle = circle()
    curve = curve_through(points)
    t = np.linspace(*curve.limits, 777)
    step = R * (angle[0] - angle[1])
    along = angle[0] - t / R
    np.testing.assert_allclose(curve.limits, [0, R * (angle[0] - angle[-1])], rtol=0, atol=1e-7)
    np.testing.assert_allclose(curve.position(t), R * np.array([np.cos(along), np.sin(along)]), atol=1e-6)
    np.testing.assert_allclose(curve.tangent(t), [np.sin(along), -np.cos(along)], rtol=0, atol=1e-5)
    inside = (t > 10 * step) & (t < t[-1] - 10 * step)
    np.testing.assert_allclose(curve.curvature(t)[inside], 1 / R, rtol=(step / R) ** 2)


@pytest.mark.parametrize("n", [60, 120])
def test_t_is_the_arc_length_at_points_and_nearly_between_them(n):
    y = np.linspace(-30.0, 22.0, n) + 0.3 * np.sin(np.arange(n))  # unequal steps
    points = np.stack([y, 9 * np.tanh(y / 7) + 0.01 * y**2])
    curve = curve_through(points)
    t = np.linspace(*curve.limits, 200 * n)
    lengths = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(curve.position(t))))])
    np.testing.assert_allclose(lengths, t - t[0], rtol=0, atol=2e-3 * (60 / n) ** 4)
    pieces = length_between(curve.spline, curve.spline.x[:-1], curve.spline.x[1:])
    np.testing.assert_allclose(pieces, np.diff(curve.spline.x), rtol=0, atol=1e-9 * (60 / n) ** 2)


def test_a_groove_has_negative_curvature_and_a_moved_curve_the_same():
    points, _ = circle()
    groove = curve_through(points * [[1.0], [-1.0]])
    moved = Moved(groove, 0.3, (5.0, -2.0))
    t = np.linspace(5.0, 30.0, 11)
    assert np.all(groove.curvature(t) < -0.9 / R)
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, -s], [s, c]])
    np.testing.assert_allclose(moved.position(t), turn @ groove.position(t) + [[5.0], [-2.0]], atol=1e-13)
    np.testing.assert_allclose(moved.tangent(t), turn @ groove.tangent(t), atol=1e-15)
    np.testing.assert_array_equal(moved.curvature(t), groove.curvature(t))


def test_shapes_of_the_arguments_are_those_of_the_results():
    curve = Moved(curve_through(circle()[0]), 0.1, (1.0, 2.0))
    for shape in ((), (3,), (2, 3)):
        t = np.full(shape, 11.0)
        assert curve.position(t).shape == curve.tangent(t).shape == (2, *shape)
        assert np.shape(curve.curvature(t)) == shape
    grid = np.linspace(1, 9, 6).reshape(2, 3)
    np.testing.assert_array_equal(curve.position(grid)[:, 1, 2], curve.position(grid[1, 2]))


def test_points_nearer_than_the_least_spacing_are_left_out_but_not_the_ends():
    points, _ = circle()
    crowded = np.insert(points, [50], points[:, 49:50] + 1e-5, axis=1)
    close = np.append(crowded, crowded[:, -1:] + 1e-6, axis=1)
    curve = curve_through(close, least_spacing=0.01)
    assert len(curve.spline.x) == points.shape[1]
    np.testing.assert_allclose(curve.position(curve.limits[1]), close[:, -1], rtol=0, atol=1e-12)


def test_repeated_few_and_infinite_points_are_refused():
    points, _ = circle()
    with pytest.raises(WrongInput, match="point 8: the same"):
        curve_through(np.insert(points, 7, points[:, 6], axis=1))
    with pytest.raises(WrongInput, match="4 are needed"):
        curve_through(points, least_spacing=30.0)
    with pytest.raises(WrongInput, match="finite"):
        curve_through(np.where(points > 12.9, np.nan, points))
    with pytest.raises(WrongInput, match=r"\(2, n\)"):
        curve_through(points.T)


def test_samples_are_no_farther_apart_than_their_spacing():
    samples = sampled(curve_through(circle()[0]), 0.3)
    assert np.max(np.diff(samples.t)) <= 0.3
    assert samples.points.shape == samples.tangents.shape == (2, len(samples.t))
