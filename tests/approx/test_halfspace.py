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
OUTSIDE = OFF_AXIS + ON_AXES + EDGE_LINES
EVERYWHERE = OUTSIDE + CORNERS + ON_PATCH

# --- second routes ---------------------------------------------------------------------------------


def kernels(X, S):
    """1/R, X^2/R^3, S^2/R^3, XS/R^3, X/R^2, S/R^2 of Boussinesq and Cerruti."""
    R = np.hypot(X, S)
    return np.array([1 / R, X**2 / R**3, S**2 / R**3, X * S / R**3, X / R**2, S / R**2])


def integrals_by_tensor_gauss(patch, x, s):
    nodes, weights = np.polynomial.legendre.leggauss(80)
    at = kernels(x - patch.a * nodes[:, None], s - patch.b * nodes)
    return patch.a * patch.b * np.einsum("kij,i,j->k", at, weights, weights)


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


# --- against the second routes -----------------------------------------------------------------------


@SIDES
@pytest.mark.parametrize("at", OUTSIDE)
def test_nine_components_are_the_quadrature_of_the_kernels(at, side):
    expected = table(integrals_by_tensor_gauss(PATCH, *at), STEEL, side)
    # 80 nodes see the singularity 0.4 half-sides away at least: converged
    assert_close(ics(*at, side=side), expected, 1e-13)


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


def test_equal_bodies_are_uncoupled_and_twice_as_soft():
    x, s = np.array(EVERYWHERE).T
    both = HalfSpace(both_bodies(STEEL, STEEL)).ics(PATCH, x, s)
    np.testing.assert_array_equal(normal_coupling(both), 0.0)
    np.testing.assert_allclose(both[:2, :2], 2 * ics(x, s)[:2, :2], rtol=1e-14)
    np.testing.assert_allclose(both[2, 2], 2 * ics(x, s)[2, 2], rtol=1e-14)


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


# --- no singular points ------------------------------------------------------------------------------


def test_every_line_through_an_edge_an_axis_or_a_corner_is_finite():
    lines = np.array([-3.0, -0.5, -0.2, 0.0, 0.2, 0.5, 3.0])
    assert np.all(np.isfinite(ics(*np.meshgrid(lines, lines))))


@pytest.mark.parametrize("at", EDGE_LINES + CORNERS + ON_PATCH)
def test_displacements_are_continuous_across_edge_lines_and_corners(at):
    step = 1e-9 * np.array([[1.0, -1.0, 0.0, 0.7], [0.6, 0.0, -1.0, -1.0]])
    x, s = np.array(at)[:, None] + step
    # the derivative grows as ln(1e-9) at an edge: 1e-9 * 21 of about 0.2 mm
    assert_close(ics(x, s), ics(*at)[..., None] + 0 * x, 3e-7)


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
def test_mirroring_the_observer_mirrors_the_matrix(patch, x, s):
    a = ics(x, s, patch, side=-1)
    assert_close(ics(-x, s, patch, side=-1), MIRROR_X @ a @ MIRROR_X, ROUNDING)
    assert_close(ics(x, -s, patch, side=-1), MIRROR_S @ a @ MIRROR_S, ROUNDING)


@quiet
@given(patch=patches, x=coordinate, s=coordinate)
def test_swapping_x_and_s_with_the_sides_swaps_the_components(patch, x, s):
    swapped = ics(s, x, Patch(patch.b, patch.a))
    assert_close(swapped, SWAP @ ics(x, s, patch) @ SWAP, ROUNDING)


@quiet
@given(patch=patches, x=coordinate, s=coordinate)
def test_exchanging_load_and_observer_transposes(patch, x, s):
    assert_close(ics(-x, -s, patch), ics(x, s, patch).T, ROUNDING)


def test_reciprocity_signs_are_exact():
    a = ics(*np.array(EVERYWHERE).T)
    np.testing.assert_array_equal(a[0, 1], a[1, 0])
    np.testing.assert_array_equal(a[2, :2], -a[:2, 2])


def test_other_side_changes_only_the_sign_of_the_normal_coupling():
    upper, lower = (ics(*np.array(EVERYWHERE).T, side=side) for side in (+1, -1))
    turned = np.array([[1, 1, -1], [1, 1, -1], [-1, -1, 1]])[..., None]
    np.testing.assert_array_equal(lower, turned * upper)


@pytest.mark.parametrize("patch", [PATCH, Patch(0.25, 1.0)])
def test_components_that_vanish_on_the_longitudinal_axis_are_zeros(patch):
    a = ics(np.linspace(-20.0, 25.0, 300), 0.0, patch)
    zeros = a[[0, 1, 1, 2], [1, 0, 2, 1]]  # xs, sx, sn, ns
    np.testing.assert_array_equal(zeros, 0.0)


@pytest.mark.parametrize("patch", [Patch(1.1, 1.9), Patch(1.9, 0.3)])
def test_components_that_vanish_on_the_lateral_axis_are_zeros(patch):
    a = ics(0.0, np.linspace(-20.0, 25.0, 3000), patch)
    zeros = a[[0, 1, 0, 2], [1, 0, 2, 0]]  # xs, sx, xn, nx
    np.testing.assert_array_equal(zeros, 0.0)


def test_vanishing_coupling_is_a_zero():
    x, s = np.array(EVERYWHERE).T
    rubber, cork = ics(x, s, material=Material(9.0, 0.5)), ics(x, s, material=Material(9.0, 0.0))
    np.testing.assert_array_equal(normal_coupling(rubber), 0.0)  # incompressible
    assert not np.any(cork[0, 1])
    np.testing.assert_array_equal(cork[0, 0], cork[2, 2])


# --- elements, lags, wrong input ---------------------------------------------------------------------

ELEMENTS_BY_NAME = pytest.mark.parametrize("element", ELEMENTS)


@ELEMENTS_BY_NAME
def test_lags_are_the_ics_at_the_points_of_a_grid(element):
    half_space = HalfSpace(both_bodies(STEEL, BRASS), element)
    x, s = np.meshgrid(1.0 * np.arange(4), 0.4 * np.arange(6), indexing="ij")
    assert_close(half_space.lags(PATCH, 4, 6), half_space.ics(PATCH, x, s), 1e-14)


def test_a_bilinear_element_carries_what_a_uniform_one_does():
    x, s = np.array([[40.0, -3.0], [7.0, 60.0]])
    uniform, bilinear = (HalfSpace(one_body(STEEL, +1), element).ics(PATCH, x, s) for element in ELEMENTS)
    assert_close(bilinear, uniform, 1e-4)  # (a / r)^2
    peak = HalfSpace(one_body(STEEL, +1), "bilinear").ics(PATCH, 0.0, 0.0)[2, 2]
    assert 0.5 < peak / ics(0.0, 0.0)[2, 2] < 1  # the same force, spread over four elements


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (([0.0, np.nan], 1.0), "x = nan at 1 of 2"),
        ((0.0, np.inf), "s = inf"),
        ((np.zeros(3), np.zeros(4)), "broadcast"),
        (("here", 0.0), "numbers"),
    ],
)
def test_wrong_points_are_refused(points, message):
    with pytest.raises(WrongInput, match=message):
        HalfSpace(one_body(STEEL, +1)).ics(PATCH, *points)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Patch(0.0, 1.0), "a = 0.0"),
        (lambda: Patch(1.0, np.nan), "b = nan"),
        (lambda: Patch(np.inf, 1.0), "a = inf"),
        (lambda: Patch(1.0, 1.0, np.nan), "s = nan"),
        (lambda: Material(np.inf, 0.3), "E = inf"),
        (lambda: Material(1.0, 0.51), "nu = 0.51"),
        (lambda: Material(1.0, np.nan), "nu = nan"),
        (lambda: HalfSpace(one_body(STEEL, +1), "cubic"), "element = 'cubic': one of uniform, bilinear"),
        (lambda: HalfSpace(one_body(STEEL, +1)).lags(PATCH, 0, 3), "n_x = 0"),
        (lambda: HalfSpace(one_body(STEEL, +1)).effective_ics(PATCH, 1.0, 1.0), "effective properties"),
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


@pytest.mark.parametrize("r", [1e6, 1e10])
def test_ten_decades_away_the_patch_is_a_point(r):
    x, s = 0.8 * r, -0.6 * r
    point = table(PATCH.area * kernels(x, s), STEEL, +1)
    np.testing.assert_allclose(ics(x, s), point, rtol=4e-13 if r == 1e6 else 1e-14)  # (a / r)^2


# --- line loads ------------------------------------------------------------------------------------

NEAR, FAR = 2.0, 5.0
LINE = 1e-4  # half-width: (LINE / NEAR)^2 is nothing


def difference_of_two(half_length):
    near, far = (ics(0.0, s, Patch(half_length, LINE)) for s in (NEAR, FAR))
    return (near - far) / (2 * LINE)


def flamant():
    log = np.log(FAR / NEAR) / (np.pi * STEEL.G)
    return np.diag([log, (1 - STEEL.nu) * log, (1 - STEEL.nu) * log])  # xx: antiplane shear


def test_long_patch_becomes_a_line_load_at_second_order():
    lengths = np.array([50.0, 100.0, 200.0])
    defects = [np.diag(difference_of_two(a) / np.diag(flamant())) - 1 for a in lengths]
    rates = -np.polyfit(np.log(lengths), np.log(np.abs(defects)), 1)[0]
    # next term (5 / 50)^2; what is left of the width is below 1e-8 of defects above 1e-4
    np.testing.assert_allclose(rates, 2, rtol=0, atol=0.02)


def test_very_long_patch_gives_the_line_load_of_flamant():
    got = difference_of_two(1e4)
    np.testing.assert_allclose(np.diag(got), np.diag(flamant()), rtol=1e-6)  # (5 / 1e4)^2, (LINE / 2)^2
    np.testing.assert_allclose(got[[0, 1], [1, 0]], 0, atol=1e-9 * got[2, 2])


@SIDES
def test_line_load_shifts_the_surface_by_a_constant_to_either_side(side):
    patch = Patch(1e5, 1e-3)
    for s in (-4.0, 0.3, 2.0):
        shift = ics(0.0, s, patch, side=side)[1, 2] / (2 * patch.b)
        flamant_sn = -side * np.sign(s) * (1 - 2 * STEEL.nu) / (4 * STEEL.G)
        assert shift == pytest.approx(flamant_sn, rel=1e-4)  # 2 s / (pi a), (b / s)^2


def test_a_grid_may_be_a_single_strip_or_a_single_lag():
    """Of one element in a direction: what the points say."""
    half_space = HalfSpace(one_body(STEEL, +1))
    for n_x, n_s in ((1, 1), (3, 1), (1, 4)):
        x, s = 2 * PATCH.a * np.arange(n_x)[:, None], 2 * PATCH.b * np.arange(n_s)
        np.testing.assert_allclose(
            half_space.lags(PATCH, n_x, n_s), half_space.ics(PATCH, x, s), rtol=1e-12, atol=1e-25
        )
    for n_x, n_s in ((0, 4), (3, 0)):
        with pytest.raises(WrongInput, match="at least one lag each"):
            half_space.lags(PATCH, n_x, n_s)


@pytest.mark.parametrize("along", ["x", "s"])
def test_grid_beyond_the_range_of_lengths_is_refused(along):
    """Lengths to 1e70 mm: no element is larger, the fourth one ends beyond."""
    long = 0.2e70
    patch = Patch(long, 0.2) if along == "x" else Patch(0.5, long)
    n = {"n_x": 4, "n_s": 1} if along == "x" else {"n_x": 1, "n_s": 4}
    with pytest.raises(WrongInput, match=r"1\.6e\+70 mm: only"):
        HalfSpace(one_body(STEEL, +1)).lags(patch, **n)
