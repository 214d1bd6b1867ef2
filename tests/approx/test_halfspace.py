from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec

from approx.halfspace import ELEMENTS, HalfSpace
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
PATCH = Patch(a=0.5, b=0.2)
quiet = settings(deadline=None, max_examples=60, database=None)
SIDES = pytest.mark.parametrize("side", [+1, -1])

OFF_AXIS = [(1.1, 0.4), (-0.7, 0.9), (-1.3, -0.35), (0.6, -2.2), (0.21, 0.55), (7.0, -3.0)]
ON_AXES = [(1.4, 0.0), (-0.9, 0.0), (0.0, 0.6), (0.0, -3.1)]
EDGE_LINES = [(0.5, 0.7), (-0.5, 1.9), (0.5, -0.8), (-1.2, 0.2), (-3.0, -0.2), (1.2, 0.2), (1.2, -0.2)]
CORNERS = [(0.5, 0.2), (-0.5, 0.2), (0.5, -0.2), (-0.5, -0.2)]
ON_PATCH = [(0.0, 0.0), (0.13, -0.07), (-0.44, 0.19), (0.5, 0.04), (0.31, -0.2), (0.0, 0.11), (-0.2, 0.0)]
EVERYWHERE = OFF_AXIS + ON_AXES + EDGE_LINES + CORNERS + ON_PATCH

# --- the second route ------------------------------------------------------------------------------


def kernels(X, S):
    """1/R, X^2/R^3, S^2/R^3, XS/R^3, X/R^2, S/R^2 of Boussinesq and Cerruti."""
    R = np.hypot(X, S)
    return np.array([1 / R, X**2 / R**3, S**2 / R**3, X * S / R**3, X / R**2, S / R**2])


def chord(patch, x, s, theta):
    """Length of the ray from the observer in direction -theta that lies within the patch."""
    c, d = np.cos(theta), np.sin(theta)
    ends_x = np.sort([(x - patch.a) / c, (x + patch.a) / c])
    ends_s = np.sort([(s - patch.b) / d, (s + patch.b) / d])
    return max(0.0, min(ends_x[1], ends_s[1]) - max(ends_x[0], ends_s[0], 0.0))


def integrals_by_rays(patch, x, s):
    """The kernels fall off as 1/R, so over each ray of directions they weigh with its length."""
    corners = [np.arctan2(s + i * patch.b, x + j * patch.a) for i in (-1, 1) for j in (-1, 1)]
    breaks = np.unique([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi, *corners])
    return sum(
        quad_vec(lambda t: kernels(np.cos(t), np.sin(t)) * chord(patch, x, s, t), lo, hi, epsrel=1e-12)[0]
        for lo, hi in pairwise(breaks)
    )


def table(integrals, material, side):
    """One body: the table of docs/theory/ics.md, written out."""
    I_0, I_xx, I_ss, I_xs, J_x, J_s = integrals
    G, nu = material.E / (2 * (1 + material.nu)), material.nu
    xx, ss = ((1 - nu) * I_0 + nu * part for part in (I_xx, I_ss))
    xs, nn = nu * I_xs, (1 - nu) * I_0
    xn, sn = (-side * (1 - 2 * nu) / 2 * J for J in (J_x, J_s))
    return np.array([[xx, xs, xn], [xs, ss, sn], [-xn, -sn, nn]]) / (2 * np.pi * G)


def ics(x, s, patch=PATCH, material=STEEL, side=+1):
    return HalfSpace(one_body(material, side)).ics(patch, x, s)


def normal_coupling(a):
    return a[[0, 1, 2, 2], [2, 2, 0, 1]]  # xn, sn, nx, ns


def assert_close(actual, expected, tolerance):
    """Per observer, relative to the largest component there."""
    scale = np.max(np.abs(expected), axis=(0, 1))
    assert np.max(np.abs(actual - expected) / scale) <= tolerance


# --- against the second route ------------------------------------------------------------------------


@SIDES
@pytest.mark.parametrize("at", EVERYWHERE)
def test_nine_components_are_the_integral_over_rays_also_on_the_patch(at, side):
    expected = table(integrals_by_rays(PATCH, *at), STEEL, side)
    assert_close(ics(*at, side=side), expected, 1e-10)  # epsrel of each of the at most eight sectors


def test_both_bodies_are_upper_plus_lower():
    x, s = np.array(EVERYWHERE).T
    both = HalfSpace(both_bodies(STEEL, BRASS)).ics(PATCH, x, s)
    total = ics(x, s, side=+1) + ics(x, s, material=BRASS, side=-1)
    assert_close(both, total, 1e-14)


def test_centre_of_the_patch_moves_as_love_says():
    a, b, G = PATCH.a, PATCH.b, STEEL.G
    love = (1 - STEEL.nu) / (2 * np.pi * G) * 4 * (a * np.arcsinh(b / a) + b * np.arcsinh(a / b))
    assert ics(0.0, 0.0)[2, 2] == pytest.approx(love, rel=1e-14)


def test_pressed_surface_moves_into_the_body_and_towards_the_load():
    for side in (+1, -1):
        pressing = side * ics(0.9, 0.6, side=side)[:, 2]  # +n presses the upper body, -n the lower
        assert side * pressing[2] > 0
        assert pressing[0] < 0
        assert pressing[1] < 0


def test_shape_is_the_broadcast_one_and_scalars_are_allowed():
    assert ics(0.3, 0.1).shape == (3, 3)
    assert ics(np.zeros((4, 1)), np.ones(5)).shape == (3, 3, 4, 5)


# --- symmetry --------------------------------------------------------------------------------------

coordinate = st.floats(-20, 20)
patches = st.builds(Patch, st.floats(0.05, 2), st.floats(0.05, 2))
ROUNDING = 1e-14  # of twice twenty operations
MIRROR_X, MIRROR_S = np.diag([-1.0, 1.0, 1.0]), np.diag([1.0, -1.0, 1.0])
SWAP = np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]])


@quiet
@given(patch=patches, x=coordinate, s=coordinate)
def test_mirror_images_a_quarter_turn_and_an_exchange_of_load_and_observer(patch, x, s):
    a = ics(x, s, patch)
    assert_close(ics(-x, s, patch), MIRROR_X @ a @ MIRROR_X, ROUNDING)
    assert_close(ics(x, -s, patch), MIRROR_S @ a @ MIRROR_S, ROUNDING)
    assert_close(ics(s, x, Patch(patch.b, patch.a)), SWAP @ a @ SWAP, ROUNDING)
    assert_close(ics(-x, -s, patch), a.T, ROUNDING)


def test_signs_of_reciprocity_and_of_the_other_side_are_exact():
    upper, lower = (ics(*np.array(EVERYWHERE).T, side=side) for side in (+1, -1))
    np.testing.assert_array_equal(upper[0, 1], upper[1, 0])
    np.testing.assert_array_equal(upper[2, :2], -upper[:2, 2])
    turned = np.array([[1, 1, -1], [1, 1, -1], [-1, -1, 1]])[..., None]
    np.testing.assert_array_equal(lower, turned * upper)


@pytest.mark.parametrize("patch", [PATCH, Patch(0.25, 1.0), Patch(1.1, 1.9), Patch(1.9, 0.3)])
def test_components_that_vanish_on_an_axis_are_zeros(patch):
    line = np.linspace(-20.0, 25.0, 3000)
    along_x, along_s = ics(line, 0.0, patch), ics(0.0, line, patch)
    np.testing.assert_array_equal(along_x[[0, 1, 1, 2], [1, 0, 2, 1]], 0.0)  # xs, sx, sn, ns
    np.testing.assert_array_equal(along_s[[0, 1, 0, 2], [1, 0, 2, 0]], 0.0)  # xs, sx, xn, nx


def test_vanishing_coupling_is_a_zero():
    x, s = np.array(EVERYWHERE).T
    rubber, cork = ics(x, s, material=Material(9.0, 0.5)), ics(x, s, material=Material(9.0, 0.0))
    equal = HalfSpace(both_bodies(STEEL, STEEL)).ics(PATCH, x, s)
    np.testing.assert_array_equal(normal_coupling(rubber), 0.0)  # incompressible
    np.testing.assert_array_equal(normal_coupling(equal), 0.0)
    assert not np.any(cork[0, 1])
    np.testing.assert_array_equal(cork[0, 0], cork[2, 2])


# --- elements, lags, wrong input ---------------------------------------------------------------------


@pytest.mark.parametrize("element", ELEMENTS)
def test_lags_are_the_ics_at_the_points_of_a_grid(element):
    half_space = HalfSpace(both_bodies(STEEL, BRASS), element)
    for n_x, n_s in ((4, 6), (1, 1), (3, 1), (1, 4)):
        x, s = np.meshgrid(1.0 * np.arange(n_x), 0.4 * np.arange(n_s), indexing="ij")
        assert_close(half_space.lags(PATCH, n_x, n_s), half_space.ics(PATCH, x, s), 1e-14)


def test_a_bilinear_element_carries_what_a_uniform_one_does():
    x, s = np.array([[40.0, -3.0], [7.0, 60.0]])
    uniform, bilinear = (HalfSpace(one_body(STEEL, +1), element).ics(PATCH, x, s) for element in ELEMENTS)
    assert_close(bilinear, uniform, 1e-4)  # (a / r)^2
    peak = HalfSpace(one_body(STEEL, +1), "bilinear").ics(PATCH, 0.0, 0.0)[2, 2]
    assert 0.5 < peak / ics(0.0, 0.0)[2, 2] < 1  # the same force, spread over four elements


UPPER = HalfSpace(one_body(STEEL, +1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: UPPER.ics(PATCH, [0.0, np.nan], 1.0), "x = nan at 1 of 2"),
        (lambda: UPPER.ics(PATCH, 0.0, np.inf), "s = inf"),
        (lambda: UPPER.ics(PATCH, np.zeros(3), np.zeros(4)), "broadcast"),
        (lambda: UPPER.ics(PATCH, "here", 0.0), "numbers"),
        (lambda: HalfSpace(one_body(STEEL, +1), "cubic"), "element = 'cubic': one of uniform, bilinear"),
        (lambda: UPPER.lags(PATCH, 0, 3), "n_x = 0.*at least one lag each"),
        (lambda: UPPER.lags(PATCH, 3, 0), "at least one lag each"),
        # lengths to 1e70 mm: no element is larger, the fourth one ends beyond
        (lambda: UPPER.lags(Patch(0.2e70, 0.2), 4, 1), r"1\.6e\+70 mm: only"),
        (lambda: UPPER.lags(Patch(0.5, 0.2e70), 1, 4), r"1\.6e\+70 mm: only"),
        (lambda: UPPER.effective_ics(PATCH, 1.0, 1.0), "effective properties"),
    ],
)
def test_wrong_input_is_refused_at_once(make, message):
    with pytest.raises(WrongInput, match=message):
        make()


# --- sums, scales and limits -------------------------------------------------------------------------


def test_four_quarters_add_up_to_the_patch():
    x, s = np.array(EVERYWHERE).T
    quarter = Patch(PATCH.a / 2, PATCH.b / 2)
    centres = [(i * quarter.a, j * quarter.b) for i in (-1, 1) for j in (-1, 1)]
    total = sum(ics(x - at_x, s - at_s, quarter) for at_x, at_s in centres)
    assert_close(total, ics(x, s), 2e-14)  # centres at x - a / 2 are rounded


@pytest.mark.parametrize("factor", [1e-3, 7.0, 1e4])
def test_displacement_per_pressure_is_a_length_over_a_modulus(factor):
    x, s = np.array(EVERYWHERE).T
    larger = ics(factor * x, factor * s, Patch(factor * PATCH.a, factor * PATCH.b))
    assert_close(larger, factor * ics(x, s), 1e-14)
    stiffer = ics(x, s, material=Material(factor * STEEL.E, STEEL.nu))
    np.testing.assert_allclose(stiffer, ics(x, s) / factor, rtol=1e-14)


@SIDES
@pytest.mark.parametrize("angle", [0.4, 2.0, 3.7, 5.9])
def test_far_away_the_patch_is_a_point_load_with_an_error_of_second_order(angle, side):
    r = np.array([10.0, 20.0, 40.0, 80.0])
    x, s = r * np.cos(angle), r * np.sin(angle)
    point = table(PATCH.area * kernels(x, s), STEEL, side)
    defect = np.abs(ics(x, s, side=side) / point - 1)  # (3, 3, r)
    rates = -np.polyfit(np.log(r), np.log(defect).reshape(9, -1).T, 1)[0]
    # the next term is of fourth order: (0.5 / 10)^2 of the defect
    np.testing.assert_allclose(rates, 2, rtol=0, atol=0.02)


# --- line loads ------------------------------------------------------------------------------------

NEAR, FAR = 2.0, 5.0
LINE = 1e-4  # half-width: (LINE / NEAR)^2 is nothing


def difference_of_two(half_length):
    near, far = (ics(0.0, s, Patch(half_length, LINE)) for s in (NEAR, FAR))
    return (near - far) / (2 * LINE)


def flamant():
    log = np.log(FAR / NEAR) / (np.pi * STEEL.G)
    return np.diag([log, (1 - STEEL.nu) * log, (1 - STEEL.nu) * log])  # xx: antiplane shear


def test_long_patch_becomes_the_line_load_of_flamant_at_second_order():
    lengths = np.array([50.0, 100.0, 200.0])
    differences = [difference_of_two(a) for a in lengths]
    assert all(np.max(np.abs(one[[0, 1], [1, 0]])) <= 1e-9 * one[2, 2] for one in differences)
    defects = [np.diag(one) / np.diag(flamant()) - 1 for one in differences]
    rates = -np.polyfit(np.log(lengths), np.log(np.abs(defects)), 1)[0]
    # next term (5 / 50)^2; what is left of the width is below 1e-8 of defects above 1e-4
    np.testing.assert_allclose(rates, 2, rtol=0, atol=0.02)


@SIDES
def test_line_load_shifts_the_surface_by_a_constant_to_either_side(side):
    patch = Patch(1e5, 1e-3)
    for s in (-4.0, 0.3, 2.0):
        shift = ics(0.0, s, patch, side=side)[1, 2] / (2 * patch.b)
        flamant_sn = -side * np.sign(s) * (1 - 2 * STEEL.nu) / (4 * STEEL.G)
        assert shift == pytest.approx(flamant_sn, rel=1e-4)  # 2 s / (pi a), (b / s)^2
