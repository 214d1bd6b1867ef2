"""Smallest enclosing spheres: known sets, a certificate of random ones, invariance."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import nnls

from femic.damage.dang_van import smallest_hypersphere
from geometries.errors import WrongInput

RANDOM = np.random.default_rng(41)


def certify(points, sphere):
    """All points are inside, and the centre is a convex combination of points on the sphere."""
    centre, radius = sphere
    distances = np.linalg.norm(points - centre, axis=1)
    size = max(float(np.ptp(points, axis=0).max()), 1e-300)
    assert distances.max() <= radius * (1 + 1e-9) + 1e-12 * size
    on = points[distances >= radius - 1e-9 * size]
    system = np.vstack([(on - centre).T / size, np.ones(len(on))])
    assert nnls(system, np.append(np.zeros(points.shape[1]), 1.0))[1] < 1e-7


@pytest.mark.parametrize("d", [1, 2, 3, 5, 8])
def test_regular_simplices(d):
    points = np.eye(d + 1) * 3.0 / np.sqrt(2)  # edges of 3, in a hyperplane
    assert smallest_hypersphere(points)[1] == pytest.approx(3 * np.sqrt(d / (2 * (d + 1))), rel=1e-12)


def test_two_points_a_cube_and_an_obtuse_triangle():
    centre, radius = smallest_hypersphere(np.array([[1.0, 2.0, 0.0], [4.0, -2.0, 0.0]]))
    assert radius == pytest.approx(2.5)
    np.testing.assert_allclose(centre, [2.5, 0, 0])
    corners = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 5), axis=-1).reshape(-1, 5)
    centre, radius = smallest_hypersphere(corners + 7)
    assert radius == pytest.approx(np.sqrt(5))
    np.testing.assert_allclose(centre, 7)
    obtuse = np.array([[-2.0, 0.0], [2.0, 0.0], [0.3, 0.5]])
    assert smallest_hypersphere(obtuse)[1] == pytest.approx(2.0)


@pytest.mark.parametrize("d", [1, 2, 5])
@pytest.mark.parametrize("n", [1, 2, 4, 30, 200])
def test_random_sets_are_certified(n, d):
    for _ in range(5):
        points = RANDOM.normal(size=(n, d)) * 10.0 ** RANDOM.uniform(-6, 6) + RANDOM.normal(size=d)
        certify(points, smallest_hypersphere(points))


@pytest.mark.parametrize("number", [1, 2])
def test_the_path_of_a_passage_is_certified(number):
    """Its neighbours are so nearly dependent that products of edges make them dependent to rounding."""
    path = np.loadtxt(Path(__file__).with_name(f"passage_{number}.txt"))
    sphere = smallest_hypersphere(path)
    certify(path, sphere)
    assert sphere[1] == pytest.approx(smallest_hypersphere(path[::-1])[1], rel=1e-8)


def test_degenerate_sets_are_certified():
    """Repeated points, points on a line and on a sphere, and a path that comes back to its start."""
    line = np.outer(RANDOM.normal(size=40), RANDOM.normal(size=5))
    on_sphere = RANDOM.normal(size=(60, 5))
    on_sphere /= np.linalg.norm(on_sphere, axis=1)[:, None]
    angle = np.linspace(0, 2 * np.pi, 25)
    circle = np.outer(np.cos(angle), np.eye(5)[0]) + np.outer(np.sin(angle), np.eye(5)[3])
    for points in (
        line,
        on_sphere,
        circle,
        np.repeat(on_sphere, 2, axis=0),
        np.zeros((4, 5)),
        np.ones((3, 5)),
    ):
        certify(points, smallest_hypersphere(points))
    assert smallest_hypersphere(circle)[1] == pytest.approx(1.0, rel=1e-12)


def test_rotated_and_moved_sets_have_moved_spheres():
    points = RANDOM.normal(size=(40, 5))
    turn, _ = np.linalg.qr(RANDOM.normal(size=(5, 5)))
    (here, radius), (there, other) = map(smallest_hypersphere, (points, 3 * points @ turn + 5))
    np.testing.assert_allclose(there, 3 * here @ turn + 5, atol=1e-10)
    assert other == pytest.approx(3 * radius, rel=1e-12)


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.zeros(4), np.full((2, 2), np.nan)])
def test_no_points_are_refused(points):
    with pytest.raises(WrongInput, match=r"points of shape .*: one or more finite points"):
        smallest_hypersphere(points)
