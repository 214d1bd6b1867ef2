"""New forms of ICs at points and in matrices, and what reciprocity makes of any form."""

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.forms import FORMS, Form, Shares, matmul, rotation_about_x, rotation_between
from approx.halfspace import HalfSpace
from approx.pair import Pair, Solid, matrix
from approx.variants import approximate, exchanged_symbol, forms_of, needs_effective
from geometries.contours import arc, ellipse
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Grid, Patch
from geometries.surfaces import LOWER, UPPER, Surface
from tests.approx.new_forms import faded, register, unlike_in_x

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
PATCH, RAIL = Patch(0.3, 0.17, s=-1.0), arc(10.0, 0.7, 1.1)
POINTS = 0.9, np.linspace(-5.0, 6.0, 15)
FADE = EffectiveProperties(G=Transition(9e4, 12.0, 1.2, 2.0), mismatch_k=Transition(0.15, 15.0, 1.0, 2.0))
WHEEL = Solid(STEEL, Surface(UPPER, ellipse(9.0, 12.0, 0.8, 0.9), 90.0))


@pytest.fixture(autouse=True)
def new_forms(monkeypatch):
    register(monkeypatch)


def by_hand(a, alpha):
    """Two thirds of the rotation at the observer, a third at the load."""
    return matmul(matmul(rotation_about_x(2 * alpha / 3).matrix, a), rotation_about_x(alpha / 3).matrix)


@pytest.mark.parametrize(("variant", "prime"), [("Btilde", False), ("Btilde_prime", True)])
def test_a_new_form_is_computed_at_points(variant, prime):
    half_space = HalfSpace(both_bodies(STEEL, BRASS), effective=FADE)
    x, s = POINTS
    a = (half_space.effective_ics if prime else half_space.ics)(PATCH, x, s - PATCH.s)
    expected = by_hand(a, RAIL.inclination(s) - RAIL.inclination(PATCH.s))
    ics = approximate(variant, half_space, Surface(LOWER, RAIL), PATCH, POINTS)
    np.testing.assert_allclose(ics, expected, rtol=0, atol=1e-14 * np.max(expected))


def test_a_new_form_is_computed_on_a_grid_of_both_bodies():
    pair, grid = Pair(WHEEL, Solid(BRASS, Surface(LOWER, RAIL))), Grid(3, 4, 0.4, 0.9, 0.5)
    for variant in ("Btilde", "Bfaded"):
        ics = matrix(variant, pair, grid)
        for strip in range(grid.n_s):
            column = pair.approximate(variant, grid.patch(strip), (grid.lags[:, None], grid.strips))
            np.testing.assert_array_equal(ics[:, :, strip], np.moveaxis(column, (0, 1), (2, 3)))


def test_a_pair_takes_new_effective_forms_as_b_hat_prime():
    """Of combined constants on the lower contour; what the wheel's curvature adds is the form's own."""
    lower = Solid(BRASS, Surface(LOWER, RAIL))
    x, s = POINTS
    a_prime = HalfSpace(both_bodies(STEEL, BRASS), effective=FADE).effective_ics(PATCH, x, s - PATCH.s)
    expected = by_hand(a_prime, RAIL.inclination(s) - RAIL.inclination(PATCH.s))
    contained, apart = (
        Pair(WHEEL, lower, FADE, curvature_apart=apart).approximate("Btilde_prime", PATCH, POINTS)
        for apart in (False, True)
    )
    np.testing.assert_allclose(contained, expected, rtol=0, atol=1e-14 * np.max(expected))
    prismatic = Solid(STEEL, WHEEL.surface.prismatic)
    curvature = WHEEL.approximate("Btilde", PATCH, POINTS) - prismatic.approximate("Btilde", PATCH, POINTS)
    np.testing.assert_allclose(apart - contained, curvature, rtol=0, atol=1e-14 * np.max(expected))


def test_an_exchange_takes_a_new_form_and_its_reciprocal():
    forms = forms_of("Bhat+sn:Btilde")
    assert (forms[1, 2], forms[2, 1]) == (FORMS["Btilde"], Form(Shares(observer=1 / 3, load=2 / 3)))
    assert forms[0, 0] == FORMS["Bhat"]
    assert exchanged_symbol("Bhat+sn:Btilde") == "B̂ (sn symbol of Btilde)"


@pytest.mark.parametrize("rotate", [Shares(2 / 3, 1 / 3), Shares(0, 1), faded, unlike_in_x])
def test_the_reciprocal_of_any_form_is_that_form_with_load_and_observer_exchanged(rotate):
    """On a wheel. Twice exchanged is the form itself."""
    half_space, form = HalfSpace(one_body(STEEL, UPPER)), Form(rotate)
    (x, s), s_load = (0.9, 3.1), -1.7
    a, back = (half_space.ics(Patch(0.3, 0.17), sign * x, sign * (s - s_load)) for sign in (1, -1))
    rotation = rotation_between(WHEEL.surface, (np.array(x), np.array(s)), s_load)
    rotation_back = rotation_between(WHEEL.surface, (np.array(-x), np.array(s_load)), s)
    there = form.reciprocal.rotate(a, rotation)
    tolerance = {"rtol": 0, "atol": 1e-14 * np.max(a)}
    np.testing.assert_allclose(there, form.rotate(back, rotation_back).T, **tolerance)
    twice = form.reciprocal.reciprocal.rotate(a, rotation)
    np.testing.assert_allclose(twice, form.rotate(a, rotation), **tolerance)


def test_a_form_without_effective_properties_falls_back_or_is_refused():
    plain, effective = (HalfSpace(one_body(STEEL, UPPER), effective=fade) for fade in (None, FADE))
    either = Form(Shares(0, 1), effective=True, fallback=Form(Shares(1, 0)))
    assert either.on(plain) == Form(Shares(1, 0))
    assert either.on(effective) == either
    assert either.reciprocal.on(plain) == Form(Shares(0, 1))
    assert needs_effective("A", "Btilde_prime")
    assert not needs_effective("A", "mix", "Btilde")
    with pytest.raises(WrongInput, match="effective properties"):
        approximate("Btilde_prime", plain, WHEEL.surface, PATCH, POINTS)
