"""The rule for finite strains, and the plane-strain elements that it is measured with."""

import sys
from pathlib import Path

import numpy as np
import pytest
from skfem.helpers import eye

sys.path.append(str(Path(__file__).parents[3] / "benchmarks"))
import finite_strain as elements

from femic.contact.finite_strain import finite_strain_shares
from geometries.errors import WrongInput

LAWS = (elements.SMALL, elements.KIRCHHOFF, elements.NEO_HOOKE)


def gradients(size, n=5):
    """Deformation gradients near unity, (2, 2, n, 1)."""
    return np.eye(2)[..., None, None] + size * np.random.default_rng(7).uniform(-1, 1, (2, 2, n, 1))


@pytest.mark.parametrize("law", LAWS)
def test_tangents_are_derivatives_of_stresses(law):
    F, H, step = gradients(0.1), gradients(1.0) - np.eye(2)[..., None, None], 1e-6
    expected = (elements.stress(F + step * H, law) - elements.stress(F - step * H, law)) / (2 * step)
    np.testing.assert_allclose(elements.tangent(F, H, law), expected, atol=1e-4 * elements.E)


@pytest.mark.parametrize("law", LAWS[1:])
def test_finite_strain_laws_are_linear_elasticity_for_small_strains_and_turn_with_the_body(law):
    small = gradients(1e-6)
    expected = elements.stress(small, elements.SMALL)
    np.testing.assert_allclose(elements.stress(small, law), expected, atol=1e-4 * np.max(np.abs(expected)))
    cos, sin = np.cos(0.4), np.sin(0.4)
    turn = np.array([[cos, -sin], [sin, cos]])
    F = gradients(0.1)
    turned = np.einsum("ij,jk...->ik...", turn, F)
    expected = np.einsum("ij,jk...->ik...", turn, elements.stress(F, law))
    np.testing.assert_allclose(elements.stress(turned, law), expected, atol=1e-9 * elements.E)
    assert np.max(np.abs(elements.stress(eye(np.ones((1, 1)), 2), law))) < 1e-9 * elements.E


def test_small_strains_give_hertz_under_a_plane():
    """A roller of 10 mm at b = 0.2 mm: p_max to 0.5 %, with ten cells along the half-width."""
    solid, approach = elements.expected(elements.Solid(10.0, 2.0, np.inf, 1.0), 0.01)
    found = elements.Ring(solid).solve(approach, elements.SMALL)
    hertz = np.sqrt(found.load * elements.MODULUS / (np.pi * 10.0))
    assert found.p_max == pytest.approx(hertz, rel=5e-3)


@pytest.mark.parametrize("name", ["roller 10 mm in a groove of 10.5 mm", "pin 9.5 mm in a hole of 10 mm"])
def test_the_rule_holds_for_both_laws_and_is_not_ten_times_too_wide(name):
    """At 0.5 % of E in conforming contact; at least one law uses a tenth of the share."""
    found = list(elements.changes(elements.SHAPES[name], 0.005))
    assert {law for law, *_ in found} == set(LAWS[1:])
    for given, part in ((True, "p_max_at_load"), (False, "p_max")):
        share = finite_strain_shares(1.0, 1.0, load_given=given)[0]
        changes = [abs(getattr(change, part)) for *_, change in found]
        assert max(changes) <= share
        assert max(changes) > share / 10
    assert max(abs(change.load) for *_, change in found) <= finite_strain_shares(1, 1, load_given=False)[1]


@pytest.mark.slow
def test_the_change_is_in_proportion_to_the_strain():
    """Of a roller under a plane: over the strain it is the same to a tenth from 0.25 % to 0.5 %."""
    factors = [
        [
            change.p_max_at_load
            for *_, change in elements.changes(elements.SHAPES["roller 10 mm under a plane"], strain)
        ]
        for strain in (0.0025, 0.005)
    ]
    np.testing.assert_allclose(factors[0], factors[1], rtol=0.1)


def test_shares_grow_with_the_strain_and_a_given_load_is_given():
    one, two = (finite_strain_shares(p_max, 210e3) for p_max in (500.0, 1000.0))
    assert two == pytest.approx((2 * one[0], 0))
    assert finite_strain_shares(500.0, 210e3, load_given=False)[1] > 0
    with pytest.raises(WrongInput, match="E = 0"):
        finite_strain_shares(500.0, 0.0)
