import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from approx.halfspace import halfspace_ics
from approx.orientation import rotation
from approx.variants import VARIANTS, approximate
from geometries.contours import arc, ellipse, plane, through_points
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
BODIES = [one_body(STEEL, +1), one_body(BRASS, -1), both_bodies(STEEL, BRASS)]
Y = np.linspace(-8.0, 11.0, 21)
CONTOURS = {
    "arc": arc(10.0, 0.45, 1.1),
    "groove": arc(-7.0, 0.9, 0.4),
    "ellipse": ellipse(5.0, 9.0, 1.3, 0.8),
    "spline": through_points(Y, -(Y**2) / 25 + 0.1 * Y, 1.7),
}
PATCH = Patch(0.3, 0.17)
ROUNDING = 1e-10  # of the largest component: 8 eps r^2 / (a b) of the half-space at 16 mm, tenfold
quiet = settings(deadline=None, max_examples=40, database=None)
each_variant = pytest.mark.parametrize("name", VARIANTS)
each_contour = pytest.mark.parametrize("contour", CONTOURS.values(), ids=CONTOURS)
places = st.floats(-7, 7)
contours = st.sampled_from(list(CONTOURS.values())) | st.builds(
    arc, st.floats(1, 30) | st.floats(-30, -1), st.floats(0.1, 1.5), st.floats(0.1, 1.5)
)


def exchange_defect(name, constants, contour, *, x, s_I, s_J):
    """How far (I, J) is from the transpose of (J, I), relative to the largest component."""
    there = approximate(name, constants, contour, Patch(PATCH.a, PATCH.b, s_J), (x, s_I))
    back = approximate(name, constants, contour, Patch(PATCH.a, PATCH.b, s_I), (-x, s_J))
    return np.max(np.abs(there - back.T)) / np.max(np.abs(there))


def sign_defect(name, contour):
    """How far ns = -sn, nx = -xn, sx = xs are violated along a line off the axis."""
    a = approximate(name, BODIES[0], contour, PATCH, (1.6, np.linspace(-6.0, 7.0, 40)))
    off = np.stack([a[2, 1] + a[1, 2], a[2, 0] + a[0, 2], a[1, 0] - a[0, 1]])
    return np.max(np.abs(off)) / np.max(np.abs(a))


# --- reciprocity -----------------------------------------------------------------------------------


@each_variant
@each_contour
def test_reciprocal_flag_is_exact(name, contour):
    defect = sign_defect(name, contour)
    # sn + ns of B and B-bar is sin(alpha) (nn - ss) = -sin(alpha) nu I_ss / (2 pi G): some hundredths
    assert defect <= ROUNDING if VARIANTS[name].reciprocal else defect > 0.02


@each_variant
@pytest.mark.parametrize("constants", BODIES, ids=["upper", "lower", "both"])
def test_reciprocal_flag_is_what_an_exchange_of_load_and_observer_finds(name, constants):
    defect = exchange_defect(name, constants, CONTOURS["ellipse"], x=0.9, s_I=3.1, s_J=-1.7)
    # a turn of 1.3 rad beside the load: sin(alpha) (nn - ss) is more than a twentieth
    assert defect <= ROUNDING if VARIANTS[name].reciprocal else defect > 0.05


@quiet
@given(contour=contours, s_I=places, s_J=places, x=places)
def test_b_hat_is_reciprocal_on_any_contour(contour, s_I, s_J, x):
    for constants in BODIES:
        assert exchange_defect("Bhat", constants, contour, x=x, s_I=s_I, s_J=s_J) <= ROUNDING


@quiet
@given(radius=st.floats(1, 30) | st.floats(-30, -1), turn=st.floats(0.2, 1.4), x=st.floats(-2, 2))
def test_b_is_reciprocal_on_no_contour(radius, turn, x):
    contour = arc(radius, 0.3, 1.2)
    s_J = -0.1 * abs(radius)
    s_I = s_J + min(turn, 1.3) * abs(radius)
    defect = exchange_defect("B", BODIES[0], contour, x=x, s_I=s_I, s_J=s_J)
    assert defect > 0.02  # sin(alpha) (ss - nn) and the turned xs, xn: at least a tenth of sin(0.2)


@each_variant
def test_flat_contours_make_all_variants_reciprocal_and_equal(name):
    line = (1.6, np.linspace(-6.0, 7.0, 40))
    got = approximate(name, BODIES[2], plane(), PATCH, line)
    np.testing.assert_array_equal(got, halfspace_ics(BODIES[2], PATCH, *line))


# --- approximate -----------------------------------------------------------------------------------

BY_HAND = {
    "A": lambda a, _R, _half: a,
    "B": lambda a, R, _half: a @ R,
    "Bbar": lambda a, R, _half: R @ a,
    "Bhat": lambda a, _R, half: half @ a @ half,
}


@each_variant
@each_contour
def test_load_off_the_centre_turns_by_the_difference_of_inclinations(name, contour):
    patch, x, s = Patch(0.3, 0.17, s=-2.2), 0.7, 3.4
    alpha = contour.inclination(s) - contour.inclination(-2.2)
    a = halfspace_ics(BODIES[2], patch, x, s + 2.2)
    expected = BY_HAND[name](a, rotation(alpha), rotation(alpha / 2))
    got = approximate(name, BODIES[2], contour, patch, (x, s))
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-15 * np.max(a) * 8)


@each_variant
def test_arc_looks_the_same_from_each_of_its_points(name):
    contour, s = arc(10.0, 1.0, 1.3), np.linspace(-2.0, 3.0, 12)
    at_crown = approximate(name, BODIES[0], contour, PATCH, (0.9, s))
    aside = approximate(name, BODIES[0], contour, Patch(0.3, 0.17, s=4.0), (0.9, s + 4.0))
    np.testing.assert_allclose(aside, at_crown, rtol=0, atol=1e-13 * np.max(at_crown))  # s + 4 - 4


@each_variant
def test_on_a_straight_flank_every_variant_is_the_half_space(name):
    contour = arc(10.0, 0.45, 1.1)
    patch, s = Patch(0.3, 0.17, s=14.0), np.linspace(11.5, 30.0, 9)
    got = approximate(name, BODIES[1], contour, patch, (-0.4, s))
    np.testing.assert_array_equal(got, halfspace_ics(BODIES[1], patch, -0.4, s - 14.0))


@each_variant
def test_groove_of_the_lower_body_is_the_crown_of_the_upper_one(name):
    s, flip = np.linspace(-5.0, 6.0, 15), np.array([1, 1, -1])
    crown = approximate(name, one_body(STEEL, +1), arc(10.0, 0.45, 1.1), PATCH, (0.9, s))
    groove = approximate(name, one_body(STEEL, -1), arc(-10.0, 0.45, 1.1), PATCH, (0.9, s))
    signs = np.outer(flip, flip)[..., None]
    np.testing.assert_allclose(groove, signs * crown, rtol=0, atol=1e-14 * np.max(crown))


@each_variant
def test_both_bodies_on_one_contour_are_the_sum(name):
    line = (0.9, np.linspace(-5.0, 6.0, 15))
    upper, lower, both = (approximate(name, h, CONTOURS["arc"], PATCH, line) for h in BODIES)
    np.testing.assert_allclose(both, upper + lower, rtol=0, atol=1e-13 * np.max(both))


@each_variant
def test_points_broadcast(name):
    x, s = np.linspace(-1.0, 2.0, 4)[:, None], np.linspace(-3.0, 4.0, 5)
    got = approximate(name, BODIES[0], CONTOURS["groove"], PATCH, (x, s))
    assert got.shape == (3, 3, 4, 5)
    single = approximate(name, BODIES[0], CONTOURS["groove"], PATCH, (x[2, 0], s[3]))
    np.testing.assert_allclose(got[..., 2, 3], single, rtol=0, atol=1e-14 * np.max(single))


def test_registry_cannot_be_changed_and_symbols_differ():
    with pytest.raises(TypeError):
        VARIANTS["C"] = VARIANTS["A"]
    assert len({variant.symbol for variant in VARIANTS.values()}) == len(VARIANTS)
