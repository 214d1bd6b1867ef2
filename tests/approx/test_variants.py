"""What each variant keeps, exchanges of components, and variants by hand."""

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from approx.effective import EffectiveProperties, Transition
from approx.forms import FORMS, rotation_about_x
from approx.halfspace import HalfSpace
from approx.variants import VARIANTS, Symmetry, approximate, exchanged_symbol, forms_of
from geometries.contours import Contour, arc, ellipse, plane, through_points
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch
from geometries.surfaces import Surface

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
FADE = EffectiveProperties(
    G=Transition(9e4, 12.0, 1.2, 2.0),
    nu=Transition(0.4, 8.0, 0.7, 1.5),
    mismatch_k=Transition(0.15, 15.0, 1.0, 2.0),
)
SOLIDS = {
    "upper": HalfSpace(one_body(STEEL, +1), effective=FADE),
    "lower": HalfSpace(one_body(BRASS, -1), "bilinear", FADE),
    "both": HalfSpace(both_bodies(STEEL, BRASS), effective=FADE),
}
Y = np.linspace(-8.0, 11.0, 21)
CONTOURS = {
    "arc": arc(10.0, 0.45, 1.1),
    "groove": arc(-7.0, 0.9, 0.4),
    "ellipse": ellipse(5.0, 9.0, 1.3, 0.8),
    "spline": through_points(Y, -(Y**2) / 25 + 0.1 * Y, 1.7),
}
PATCH = Patch(0.3, 0.17)
ROUNDING = 2e-14  # of the largest component: 5e-15 of the half-space, ten products
BROKEN = 0.01
quiet = settings(deadline=None, max_examples=40, database=None)
each_variant = pytest.mark.parametrize("name", VARIANTS)
each_contour = pytest.mark.parametrize("contour", CONTOURS.values(), ids=CONTOURS)
each_solid = pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)


def prismatic(contour):
    return Surface(-1, contour)


def worst(difference, of):
    return np.max(np.abs(difference)) / np.max(np.abs(of))


# --- what each variant keeps, and nothing else ---------------------------------------------------------


def reciprocity_defect(name, solid, surface):
    """How far (I, J) is from the transpose of (J, I)."""
    there = approximate(name, solid, surface, replace(PATCH, s=-1.7), (0.9, 3.1))
    back = approximate(name, solid, surface, replace(PATCH, s=3.1), (-0.9, -1.7))
    return worst(there - back.T, there)


def signs_defect(name, solid, surface):
    """How far sx = xs, nx = -xn, ns = -sn are violated along a line off the axis."""
    a = approximate(name, solid, prismatic(surface.contour), PATCH, (1.6, np.linspace(-6.0, 7.0, 40)))
    signs = np.array([1, 1, -1])
    return worst(a - np.outer(signs, signs)[..., None] * np.swapaxes(a, 0, 1), a)


def parity_defect(name, solid, surface):
    s = np.linspace(-6.0, 7.0, 40)
    a, mirrored = (approximate(name, solid, surface, PATCH, (x, s)) for x in (1.6, -1.6))
    return worst(mirrored - SIGNS_X * a, a)


def mirror_defect(name, solid, surface):
    s = np.linspace(-6.0, 7.0, 40)
    patch = replace(PATCH, s=-1.7)
    a = approximate(name, solid, surface, patch, (1.6, s))
    other = approximate(name, solid, mirrored(surface), replace(patch, s=1.7), (1.6, -s))
    return worst(other - SIGNS_S * a, a)


SIGNS_X, SIGNS_S = (np.outer(v, v)[..., None] for v in ([-1, 1, 1], [1, -1, 1]))
DEFECTS = {
    Symmetry.RECIPROCITY: reciprocity_defect,
    Symmetry.SIGNS: signs_defect,
    Symmetry.PARITY: parity_defect,
    Symmetry.MIRROR: mirror_defect,
}


class MirroredCore:
    def __init__(self, core):
        self.core = core

    def position(self, s):
        return self.core.position(-s) * np.array([-1.0, 1.0]).reshape(2, *[1] * np.ndim(s))

    def inclination(self, s):
        return -self.core.inclination(-s)


def mirrored(surface):
    contour = surface.contour
    limits = (-contour.limits[1], -contour.limits[0])
    return replace(surface, contour=Contour(MirroredCore(contour.core), limits))


@each_variant
@pytest.mark.parametrize("symmetry", Symmetry)
@each_contour
@each_solid
@pytest.mark.parametrize("radius", [np.inf, 90.0], ids=["prismatic", "revolution"])
def test_a_variant_keeps_exactly_what_it_says(name, symmetry, contour, solid, radius):
    defect = DEFECTS[symmetry](name, solid, Surface(+1, contour, radius))
    # a turn of some tenths lets sin(alpha) (nn - ss), a tenth of the largest component, stand out
    assert defect <= ROUNDING if symmetry in VARIANTS[name].keeps else defect > BROKEN


places = st.floats(-7, 7)
contours = st.sampled_from(list(CONTOURS.values())) | st.builds(
    arc, st.floats(1, 30) | st.floats(-30, -1), st.floats(0.1, 1.5), st.floats(0.1, 1.5)
)


@quiet
@given(contour=contours, s_I=places, s_J=places, x=places, radius=st.just(np.inf) | st.floats(40, 1e6))
def test_b_hat_and_the_mix_are_reciprocal_on_any_contour_and_wheel(contour, s_I, s_J, x, radius):
    surface = Surface(+1, contour, radius)
    for name in ("Bhat", "Bhat_prime", "mix"):
        for solid in (SOLIDS["upper"], SOLIDS["both"]):
            there = approximate(name, solid, surface, replace(PATCH, s=s_J), (x, s_I))
            back = approximate(name, solid, surface, replace(PATCH, s=s_I), (-x, s_J))
            assert worst(there - back.T, there) <= ROUNDING


@each_solid
def test_b_bar_is_b_with_load_and_observer_exchanged(solid):
    surface = Surface(+1, CONTOURS["ellipse"], 90.0)
    b = approximate("B", solid, surface, replace(PATCH, s=-1.7), (0.9, 3.1))
    b_bar = approximate("Bbar", solid, surface, replace(PATCH, s=3.1), (-0.9, -1.7))
    assert worst(b - b_bar.T, b) <= ROUNDING


@each_variant
@pytest.mark.parametrize("flat", [plane(), arc(10.0, 0.45, 1.1)], ids=["plane", "flank"])
def test_variants_equal_the_half_space_exactly_without_rotation(name, flat):
    solid, patch = SOLIDS["both"], replace(PATCH, s=14.0)
    x, s = -0.4, np.linspace(11.5, 30.0, 9)
    a, a_prime = solid.ics(patch, x, s - 14.0), solid.effective_ics(patch, x, s - 14.0)
    expected = a_prime if name == "Bhat_prime" else a
    if name == "mix":
        expected[[0, 2], [2, 0]] = a_prime[[0, 2], [2, 0]]
    np.testing.assert_array_equal(approximate(name, solid, prismatic(flat), patch, (x, s)), expected)


# --- approximate -----------------------------------------------------------------------------------


def mixed_by_hand(a, p, R, half):
    out = half @ a @ half
    out[1, 2], out[2, 1] = (a @ R)[1, 2], (R @ a)[2, 1]
    for at in ((0, 2), (2, 0)):
        out[at] = (half @ p @ half)[at]
    return out


BY_HAND = {
    "A": lambda a, _p, _R, _half: a,
    "B": lambda a, _p, R, _half: a @ R,
    "Bbar": lambda a, _p, R, _half: R @ a,
    "Bhat": lambda a, _p, _R, half: half @ a @ half,
    "Bhat_prime": lambda _a, p, _R, half: half @ p @ half,
    "mix": mixed_by_hand,
}


@each_contour
def test_an_exchange_takes_the_component_and_by_reciprocity_its_transpose(contour):
    of = partial(approximate, half_space=SOLIDS["both"], surface=Surface(+1, contour, 90.0), patch=PATCH)
    line = (0.9, np.linspace(-5.0, 6.0, 15))
    b_hat, b, b_bar, b_hat_prime = (of(name, points=line) for name in ("Bhat", "B", "Bbar", "Bhat_prime"))
    expected = b_hat.copy()
    expected[1, 2], expected[2, 1] = b[1, 2], b_bar[2, 1]
    expected[0, 2], expected[2, 0] = b_hat_prime[0, 2], b_hat_prime[2, 0]
    np.testing.assert_array_equal(of("Bhat+sn:B+xn:Bhat_prime", points=line), expected)
    np.testing.assert_array_equal(of("Bhat+ns:Bbar+xn:Bhat_prime", points=line), expected)
    np.testing.assert_array_equal(of("mix", points=line), expected)


@each_solid
@pytest.mark.parametrize("name", ["Bhat+sn:B", "Bhat+xs:A", "Bhat+ss:Bhat_prime", "mix+xn:Bbar"])
def test_exchange_keeps_reciprocity(name, solid):
    assert reciprocity_defect(name, solid, Surface(+1, CONTOURS["ellipse"], 90.0)) <= ROUNDING


def test_an_exchange_is_read_and_named():
    forms = forms_of("mix+nn:A")
    assert forms[2, 2] == FORMS["A"]
    assert forms[1, 1] == FORMS["Bhat"]
    assert forms[0, 2] == forms[2, 0] == FORMS["Bhat_prime_or_A"]
    assert (forms[1, 2], forms[2, 1]) == (FORMS["B"], FORMS["Bbar"])
    assert exchanged_symbol("Bhat+sn:B+xn:A") == "B̂ (sn B, xn A)"


@pytest.mark.parametrize(
    "name", ["Bhat+sn", "Bhat+sz:B", "Bhat+sn:mix", "Bhat+sn:C", "Bhat+mix", "+sn:B", "Bhut"]
)
def test_other_names_are_refused_with_the_known_ones(name):
    known = f"variant = '{re.escape(name)}': one of A, B, Bbar, Bhat, Bhat_prime, mix.*or one with exchanges"
    with pytest.raises(WrongInput, match=known):
        forms_of(name)


@each_variant
@each_contour
def test_load_off_the_centre_is_rotated_by_the_difference_of_inclinations(name, contour):
    patch, x, s = replace(PATCH, s=-2.2), 0.7, 3.4
    alpha = contour.inclination(s) - contour.inclination(-2.2)
    solid = SOLIDS["both"]
    a, p = solid.ics(patch, x, s + 2.2), solid.effective_ics(patch, x, s + 2.2)
    expected = BY_HAND[name](a, p, rotation_about_x(alpha).matrix, rotation_about_x(alpha / 2).matrix)
    got = approximate(name, solid, prismatic(contour), patch, (x, s))
    assert worst(got - expected, a) <= ROUNDING


def test_without_effective_properties_the_mix_takes_xn_from_a_and_b_hat_prime_is_refused():
    solid, line = HalfSpace(one_body(STEEL, +1)), (0.9, np.linspace(-5.0, 6.0, 15))
    surface = Surface(+1, CONTOURS["arc"], 90.0)
    mix, a = (approximate(name, solid, surface, PATCH, line) for name in ("mix", "A"))
    np.testing.assert_array_equal(mix[[0, 2], [2, 0]], a[[0, 2], [2, 0]])
    with pytest.raises(WrongInput, match="effective properties"):
        approximate("Bhat_prime", solid, surface, PATCH, line)


@each_variant
def test_arc_looks_the_same_from_each_of_its_points(name):
    surface, s = prismatic(arc(10.0, 1.0, 1.3)), np.linspace(-2.0, 3.0, 12)
    at_crown = approximate(name, SOLIDS["upper"], surface, PATCH, (0.9, s))
    aside = approximate(name, SOLIDS["upper"], surface, replace(PATCH, s=4.0), (0.9, s + 4.0))
    assert worst(aside - at_crown, at_crown) <= ROUNDING


@each_variant
@pytest.mark.parametrize("radius", [np.inf, 90.0])
def test_groove_of_the_lower_body_is_the_crown_of_the_upper_one(name, radius):
    """Turned upside down: n changes its sign."""
    s, flip = np.linspace(-5.0, 6.0, 15), np.array([1, 1, -1])
    opposite = replace(FADE, mismatch_k=replace(FADE.mismatch_k, far=-0.15))
    upper = HalfSpace(one_body(STEEL, +1), effective=FADE)
    lower = HalfSpace(one_body(STEEL, -1), effective=opposite)
    crown = approximate(name, upper, Surface(+1, arc(10.0, 0.45, 1.1), radius), PATCH, (0.9, s))
    groove = approximate(name, lower, Surface(-1, arc(-10.0, 0.45, 1.1), radius), PATCH, (0.9, s))
    assert worst(groove - np.outer(flip, flip)[..., None] * crown, crown) <= ROUNDING


@pytest.mark.parametrize("name", ["A", "B", "Bbar", "Bhat", "mix"])
def test_both_bodies_on_one_contour_are_the_sum(name):
    line, surface = (0.9, np.linspace(-5.0, 6.0, 15)), prismatic(CONTOURS["arc"])
    solids = [one_body(STEEL, +1), one_body(BRASS, -1), both_bodies(STEEL, BRASS)]
    upper, lower, both = (approximate(name, HalfSpace(c), surface, PATCH, line) for c in solids)
    assert worst(both - upper - lower, both) <= ROUNDING


@each_variant
def test_points_broadcast(name):
    x, s = np.linspace(-1.0, 2.0, 4)[:, None], np.linspace(-3.0, 4.0, 5)
    surface = Surface(+1, CONTOURS["groove"], 90.0)
    got = approximate(name, SOLIDS["upper"], surface, PATCH, (x, s))
    assert got.shape == (3, 3, 4, 5)
    single = approximate(name, SOLIDS["upper"], surface, PATCH, (x[2, 0], s[3]))
    assert worst(got[..., 2, 3] - single, single) <= ROUNDING


def test_symbols_differ():
    assert len({variant.symbol for variant in VARIANTS.values()}) == len(VARIANTS)
