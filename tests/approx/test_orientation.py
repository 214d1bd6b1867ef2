import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import sqrtm
from scipy.spatial.transform import Rotation

from approx.halfspace import halfspace_ics
from approx.orientation import load_rotated, matmul, observer_rotated, rotation, split_rotation
from geometries.contours import arc
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch

PATCH = Patch(0.3, 0.17)
X, S = np.array([0.4, 1.9, -3.0, 0.0, 0.8]), np.array([1.2, -0.6, 2.5, 0.9, 0.0])
ALPHA = np.array([0.9, -0.31, 2.4, 0.05, -1.2])
SOFT_BELOW = both_bodies(Material(210e3, 0.28), Material(97e3, 0.36))
A = halfspace_ics(SOFT_BELOW, PATCH, X, S)  # (3, 3, 5), all couplings present
ROUNDING = {"rtol": 0, "atol": 8 * np.finfo(float).eps * np.max(np.abs(A))}
quiet = settings(deadline=None, max_examples=60, database=None)
TURNED = pytest.mark.parametrize("turned", [load_rotated, observer_rotated, split_rotation])


def per_point(a):
    return np.moveaxis(a, -1, 0)


# --- rotations -------------------------------------------------------------------------------------


def test_rotation_turns_about_x_by_the_right_hand_rule():
    expected = Rotation.from_rotvec(np.outer(ALPHA, [1, 0, 0])).as_matrix()
    np.testing.assert_allclose(per_point(rotation(ALPHA)), expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(rotation(np.array(np.pi / 2)) @ [0, 1, 0], [0, 0, 1], atol=1e-15)


@quiet
@given(st.floats(-10, 10), st.floats(-10, 10))
def test_rotations_are_orthogonal_and_add_up(alpha, beta):
    R, T = rotation(np.array(alpha)), rotation(np.array(beta))
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(R) == pytest.approx(1, rel=1e-15)
    np.testing.assert_allclose(R @ T, rotation(np.array(alpha + beta)), atol=4e-15)  # eps of 20 rad
    np.testing.assert_array_equal(rotation(np.array(-alpha)), R.T)


def test_rotation_is_the_turn_from_the_axes_of_the_load_to_those_of_the_observer():
    contour = arc(10.0, 0.7, 1.1)
    s_I, s_J = 6.0, -3.5
    axes = [np.eye(3), np.eye(3)]  # columns: x, s, n in global axes
    for Q, s in zip(axes, (s_I, s_J), strict=True):
        Q[1:, 1], Q[1:, 2] = contour.tangent(s), contour.normal(s)
    alpha = contour.inclination(s_I) - contour.inclination(s_J)
    np.testing.assert_allclose(axes[0].T @ axes[1], rotation(alpha), atol=1e-15)


def test_matmul_is_the_matrix_product_of_each_point():
    B = A[::-1] + 2 * A
    expected = per_point(A) @ per_point(B)
    np.testing.assert_allclose(per_point(matmul(A, B)), expected, rtol=1e-14, atol=1e-30)


# --- the products, written out ---------------------------------------------------------------------


@TURNED
def test_no_turn_leaves_the_half_space_exactly(turned):
    np.testing.assert_array_equal(turned(A, np.zeros(5)), A)


def test_b_has_the_turned_columns():
    (xx, xs, xn), (sx, ss, sn), (nx, ns, nn) = A
    c, d = np.cos(ALPHA), np.sin(ALPHA)
    expected = [
        [xx, xs * c + xn * d, xn * c - xs * d],
        [sx, ss * c + sn * d, sn * c - ss * d],
        [nx, ns * c + nn * d, nn * c - ns * d],
    ]
    np.testing.assert_allclose(load_rotated(A, ALPHA), expected, **ROUNDING)


def test_b_bar_has_the_turned_rows_with_the_corrected_entries():
    (xx, xs, xn), (sx, ss, sn), (nx, ns, nn) = A
    c, d = np.cos(ALPHA), np.sin(ALPHA)
    expected = [
        [xx, xs, xn],
        [sx * c - nx * d, ss * c - ns * d, sn * c - nn * d],  # [BVSV] prints xx for sx here
        [sx * d + nx * c, ss * d + ns * c, sn * d + nn * c],
    ]
    np.testing.assert_allclose(observer_rotated(A, ALPHA), expected, **ROUNDING)


def test_b_hat_is_the_half_turn_of_rows_and_columns():
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
    np.testing.assert_allclose(split_rotation(A, ALPHA), np.array(expected), **ROUNDING)


def test_b_hat_takes_the_square_root_of_the_turn():
    roots = np.stack([np.real(sqrtm(R)) for R in per_point(rotation(ALPHA))])
    expected = roots @ per_point(A) @ roots
    np.testing.assert_allclose(per_point(split_rotation(A, ALPHA)), expected, rtol=0, atol=1e-14 * A.max())


# --- relations -------------------------------------------------------------------------------------


@TURNED
def test_turning_back_gives_the_half_space(turned):
    np.testing.assert_allclose(turned(turned(A, ALPHA), -ALPHA), A, **ROUNDING)


@TURNED
def test_two_turns_are_one_turn_by_the_sum(turned):
    once = turned(A, ALPHA + 0.7)
    np.testing.assert_allclose(turned(turned(A, ALPHA), np.full(5, 0.7)), once, **ROUNDING)


def test_b_hat_lies_half_a_turn_from_b_and_b_bar():
    hat = split_rotation(A, ALPHA)
    from_b = matmul(matmul(rotation(ALPHA / 2), load_rotated(A, ALPHA)), rotation(-ALPHA / 2))
    from_b_bar = matmul(matmul(rotation(-ALPHA / 2), observer_rotated(A, ALPHA)), rotation(ALPHA / 2))
    np.testing.assert_allclose(from_b, hat, **ROUNDING)
    np.testing.assert_allclose(from_b_bar, hat, **ROUNDING)


def test_mirrored_scene_turns_the_other_way():
    mirror = np.array([1, -1, 1])
    signs = np.outer(mirror, mirror)[..., None]
    other = halfspace_ics(SOFT_BELOW, PATCH, X, -S)
    for turned in (load_rotated, observer_rotated, split_rotation):
        np.testing.assert_allclose(turned(other, -ALPHA), signs * turned(A, ALPHA), **ROUNDING)


def test_exchanging_load_and_observer_makes_b_of_b_bar_and_keeps_b_hat():
    back = halfspace_ics(SOFT_BELOW, PATCH, -X, -S)
    transposed = np.swapaxes(load_rotated(back, -ALPHA), 0, 1)
    np.testing.assert_allclose(transposed, observer_rotated(A, ALPHA), **ROUNDING)
    hat = np.swapaxes(split_rotation(back, -ALPHA), 0, 1)
    np.testing.assert_allclose(hat, split_rotation(A, ALPHA), **ROUNDING)


@TURNED
def test_turning_keeps_the_length_of_what_it_turns(turned):
    norm = np.linalg.norm(A, axis=(0, 1))
    np.testing.assert_allclose(np.linalg.norm(turned(A, ALPHA), axis=(0, 1)), norm, rtol=1e-14)


def test_half_a_turn_exchanges_pressing_and_pulling():
    a = halfspace_ics(one_body(Material(210e3, 0.28), +1), PATCH, X, S)
    facing = np.full(5, np.pi)
    np.testing.assert_allclose(load_rotated(a, facing)[:, 1:], -a[:, 1:], **ROUNDING)
    np.testing.assert_allclose(observer_rotated(a, facing)[1:], -a[1:], **ROUNDING)
