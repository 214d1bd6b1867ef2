import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import sqrtm
from scipy.spatial.transform import Rotation as ScipyRotation

from approx.forms import Shares, matmul, rotation_about_x, rotation_between
from approx.halfspace import HalfSpace
from geometries.contours import arc, ellipse, plane
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch
from geometries.surfaces import Surface

PATCH = Patch(0.3, 0.17)
X, S = np.array([0.4, 1.9, -3.0, 0.0, 0.8]), np.array([1.2, -0.6, 2.5, 0.9, 0.0])
ALPHA = np.array([0.9, -0.31, 2.4, 0.05, -1.2])
SOFT_BELOW = both_bodies(Material(210e3, 0.28), Material(97e3, 0.36))
A = HalfSpace(SOFT_BELOW).ics(PATCH, X, S)  # (3, 3, 5), all couplings present
ROUNDING = {"rtol": 0, "atol": 8 * np.finfo(float).eps * np.max(np.abs(A))}
ROTATION = rotation_about_x(ALPHA)
load_rotated, observer_rotated, both_rotated = Shares(0, 1), Shares(1, 0), Shares(1 / 2, 1 / 2)
quiet = settings(deadline=None, max_examples=60, database=None)
EACH = pytest.mark.parametrize(
    "rotated", [load_rotated, observer_rotated, both_rotated, Shares(2 / 3, 1 / 3)]
)


def matrix(alpha):
    return rotation_about_x(alpha).matrix


def per_point(a):
    return np.moveaxis(a, -1, 0)


# --- rotations -------------------------------------------------------------------------------------


def test_rotation_about_x_follows_the_right_hand_rule():
    expected = ScipyRotation.from_rotvec(np.outer(ALPHA, [1, 0, 0])).as_matrix()
    np.testing.assert_allclose(per_point(matrix(ALPHA)), expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(matrix(np.array(np.pi / 2)) @ [0, 1, 0], [0, 0, 1], atol=1e-15)


@quiet
@given(st.floats(-10, 10), st.floats(-10, 10))
def test_rotations_are_orthogonal_and_add_up(alpha, beta):
    R, T = matrix(np.array(alpha)), matrix(np.array(beta))
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=2e-15)
    assert np.linalg.det(R) == pytest.approx(1, rel=2e-15)
    np.testing.assert_allclose(R @ T, matrix(np.array(alpha + beta)), atol=4e-15)  # eps of 20 rad
    np.testing.assert_array_equal(matrix(np.array(-alpha)), R.T)


SURFACES = {
    "wheel": Surface(+1, arc(10.0, 0.7, 1.1), 120.0),
    "roller": Surface(-1, ellipse(5.0, 9.0, 1.3, 0.8), 40.0),
    "rail": Surface(-1, arc(10.0, 0.7, 1.1)),
}
each_surface = pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
OBSERVERS = np.array([3.0, -30.0, 80.0, 0.0, 1e-9]), np.array([6.0, -2.0, 1.0, 4.0, -3.5])
S_LOAD = -3.5


def rotations_of_the_axes(surface):
    """Q_I^T Q_J from the local directions in space."""
    x, s = OBSERVERS
    at_observers = surface.axes(surface.chart_x(x, s, S_LOAD), s)  # (direction, component, point)
    at_load = surface.axes(0.0, S_LOAD)
    return np.einsum("icp,jc->ijp", at_observers, at_load.reshape(3, 3))


@each_surface
def test_rotation_is_from_the_axes_of_the_load_to_those_of_the_observer(surface):
    rotation = rotation_between(surface, OBSERVERS, S_LOAD)
    np.testing.assert_allclose(rotation.matrix, rotations_of_the_axes(surface), atol=2e-15)


@each_surface
@pytest.mark.parametrize("exponent", [0.0, 1 / 3, 0.5, 0.7, 1.0, -1.0, -0.4])
def test_powers_of_a_rotation_are_those_of_scipy(surface, exponent):
    rotation = rotation_between(surface, OBSERVERS, S_LOAD)
    expected = ScipyRotation.from_matrix(per_point(rotation.matrix)) ** exponent
    np.testing.assert_allclose(per_point(rotation.power(exponent).matrix), expected.as_matrix(), atol=2e-15)


@each_surface
def test_inverse_and_angle(surface):
    rotation = rotation_between(surface, OBSERVERS, S_LOAD)
    np.testing.assert_array_equal(rotation.inverse.matrix, np.swapaxes(rotation.matrix, 0, 1))
    expected = ScipyRotation.from_matrix(per_point(rotation.matrix)).magnitude()
    np.testing.assert_allclose(rotation.angle, expected, rtol=1e-14)


def test_curvature_along_x_rotates_xn_by_half_the_sum_of_xx_and_nn():
    """At alpha = 0: B-hat_xn = A_xn cos(a_x) - (A_xx + A_nn) sin(a_x) / 2, a_x = -x / R (upper body)."""
    x, s, wheel = np.array([3.0, -8.0]), np.zeros(2), SURFACES["wheel"]
    a = HalfSpace(one_body(Material(210e3, 0.28), +1)).ics(PATCH, x, s)
    got = both_rotated(a, rotation_between(wheel, (x, s), 0.0))[0, 2]
    alpha_x = -x / 120.0
    expected = a[0, 2] * np.cos(alpha_x) - (a[0, 0] + a[2, 2]) * np.sin(alpha_x) / 2
    np.testing.assert_allclose(got, expected, rtol=1e-13)


def test_a_plane_does_not_rotate_and_a_huge_wheel_hardly():
    still = rotation_between(Surface(+1, plane()), OBSERVERS, S_LOAD)
    np.testing.assert_array_equal(still.matrix, np.eye(3)[..., None] + np.zeros(5))
    rail, wheel = (
        rotation_between(Surface(+1, arc(10.0, 0.7, 1.1), radius), OBSERVERS, S_LOAD)
        for radius in (np.inf, 1e12)
    )
    np.testing.assert_allclose(wheel.matrix, rail.matrix, atol=80.0 / 1e12)


def test_matmul_is_the_matrix_product_of_each_point():
    B = A[::-1] + 2 * A
    expected = per_point(A) @ per_point(B)
    np.testing.assert_allclose(per_point(matmul(A, B)), expected, rtol=1e-14, atol=1e-30)


# --- the products, written out ---------------------------------------------------------------------


@EACH
def test_no_rotation_leaves_the_half_space_exactly(rotated):
    np.testing.assert_array_equal(rotated(A, rotation_about_x(np.zeros(5))), A)


def test_b_has_the_rotated_columns():
    (xx, xs, xn), (sx, ss, sn), (nx, ns, nn) = A
    c, d = np.cos(ALPHA), np.sin(ALPHA)
    expected = [
        [xx, xs * c + xn * d, xn * c - xs * d],
        [sx, ss * c + sn * d, sn * c - ss * d],
        [nx, ns * c + nn * d, nn * c - ns * d],
    ]
    np.testing.assert_allclose(load_rotated(A, ROTATION), expected, **ROUNDING)


def test_b_bar_has_the_rotated_rows_with_the_corrected_entries():
    (xx, xs, xn), (sx, ss, sn), (nx, ns, nn) = A
    c, d = np.cos(ALPHA), np.sin(ALPHA)
    expected = [
        [xx, xs, xn],
        [sx * c - nx * d, ss * c - ns * d, sn * c - nn * d],  # [BVSV] prints xx for sx here
        [sx * d + nx * c, ss * d + ns * c, sn * d + nn * c],
    ]
    np.testing.assert_allclose(observer_rotated(A, ROTATION), expected, **ROUNDING)


def test_b_hat_is_half_the_rotation_of_rows_and_columns():
    (xx, xs, xn), (sx, ss, sn), (nx, ns, nn) = A
    c, d = np.cos(ALPHA / 2), np.sin(ALPHA / 2)
    expected = [
        [xx, xs * c + xn * d, xn * c - xs * d],
        [sx * c - nx * d, ss * c**2 - nn * d**2 + (sn - ns) * c * d, 0],
        [sx * d + nx * c, 0, nn * c**2 - ss * d**2 + (sn - ns) * c * d],
    ]
    sum_of_diagonal = (ss + nn) * np.sin(ALPHA) / 2
    expected[1][2] = sn * c**2 + ns * d**2 - sum_of_diagonal
    expected[2][1] = ns * c**2 + sn * d**2 + sum_of_diagonal
    np.testing.assert_allclose(both_rotated(A, ROTATION), np.array(expected), **ROUNDING)


def test_b_hat_takes_the_square_root_of_the_rotation():
    roots = np.stack([np.real(sqrtm(R)) for R in per_point(matrix(ALPHA))])
    expected = roots @ per_point(A) @ roots
    got = per_point(both_rotated(A, ROTATION))
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-14 * A.max())


@EACH
@pytest.mark.parametrize("beta", [np.full(5, 0.7), -ALPHA], ids=["on", "back"])
def test_two_rotations_are_one_rotation_by_the_sum(rotated, beta):
    twice = rotated(rotated(A, ROTATION), rotation_about_x(beta))
    np.testing.assert_allclose(twice, rotated(A, rotation_about_x(ALPHA + beta)), **ROUNDING)
