from dataclasses import replace

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.halfspace import HalfSpace
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
PATCH = Patch(0.3, 0.17)
X, S = np.array([0.0, 0.7, -3.0, 4.0, 30.0]), np.array([0.0, -1.2, 4.0, 3.0, 1.0])  # r = 5 twice
FADE = Transition(far=0.2, r_inf=9.0, m=1.3, n=2.6)


def test_transition_is_the_printed_formula():
    """From the half-space's value at r = 0 to the far one at r_inf, and no further."""
    r = np.append(np.linspace(0, 20, 41), 1e9)
    rho = np.minimum(1, r / 9.0)
    share = (1 - rho) * rho**1.3 + rho * (1 - (1 - rho) ** 2.6)
    found = FADE.at(r, 0.05)
    np.testing.assert_allclose(found, 0.05 + (0.2 - 0.05) * share, rtol=1e-15)
    assert (found[0], found[-1]) == (0.05, pytest.approx(0.2, rel=1e-15))
    np.testing.assert_array_equal(FADE.at(r, 0.2), 0.2)


def test_exponents_rule_the_beginning_and_the_end():
    """Near the load f - f0 goes like rho^m where m < 1; near r_inf the rest goes like (1 - rho)^min(1, n)."""
    rho = np.array([1e-6, 1e-5])
    steep = Transition(1.0, 1.0, 0.5, 3.0).at(rho, 0.0)
    assert np.log10(steep[1] / steep[0]) == pytest.approx(0.5, abs=0.01)  # next term: rho^1 (1 + n)
    rest = 1 - Transition(1.0, 1.0, 2.0, 0.5).at(1 - rho, 0.0)
    assert np.log10(rest[1] / rest[0]) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("constants", [both_bodies(STEEL, BRASS), one_body(STEEL, +1)], ids=["both", "upper"])
@pytest.mark.parametrize(
    ("name", "far"), [("G", 0.2), ("nu", 0.2), ("nu", 0.0), ("nu", 0.5), ("mismatch_k", 0.2)]
)
def test_one_property_varies_and_only_it(name, far, constants):
    varying = replace(FADE, far=far)
    got = HalfSpace(constants, effective=EffectiveProperties(**{name: varying})).effective_ics(PATCH, X, S)
    for k, (x, s) in enumerate(zip(X, S, strict=True)):
        value = float(varying.at(np.hypot(x, s), getattr(constants, name)))
        expected = HalfSpace(replace(constants, **{name: value})).ics(PATCH, x, s)
        np.testing.assert_allclose(got[..., k], expected, rtol=1e-14, atol=1e-15 * expected[2, 2])


def test_k_of_equal_materials_couples_only_through_what_is_given():
    effective = EffectiveProperties(mismatch_k=FADE)
    half_space = HalfSpace(both_bodies(STEEL, STEEL), effective=effective)
    a, a_prime = half_space.ics(PATCH, X, S), half_space.effective_ics(PATCH, X, S)
    np.testing.assert_array_equal(a_prime[:2, :2], a[:2, :2])
    assert not np.any(a[:2, 2])
    assert np.all(a_prime[:2, 2, 1:] != 0)
    np.testing.assert_array_equal(a_prime[2, :2], -a_prime[:2, 2])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Transition(np.nan, 9.0, 1.0, 1.0), "far = nan"),
        (lambda: Transition(0.1, 0.0, 1.0, 1.0), "r_inf = 0.0"),
        (lambda: Transition(0.1, 9.0, -1.0, 1.0), "m = -1.0"),
        (lambda: Transition(0.1, 9.0, 1.0, np.inf), "n = inf"),
        (lambda: EffectiveProperties(nu=Transition(0.6, 9.0, 1.0, 1.0)), "nu far away = 0.6"),
        (lambda: EffectiveProperties(G=Transition(0.0, 9.0, 1.0, 1.0)), "G at r_inf and beyond = 0.0"),
    ],
)
def test_impossible_properties_are_refused(make, message):
    with pytest.raises(WrongInput, match=message):
        make()
