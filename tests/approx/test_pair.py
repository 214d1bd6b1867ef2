import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.forms import FORMS, rotation_about_x
from approx.halfspace import HalfSpace
from approx.pair import Pair, Solid
from approx.variants import VARIANTS
from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies
from geometries.patches import Patch
from geometries.surfaces import LOWER, UPPER, Surface

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
PATCH, LINE = Patch(0.3, 0.17, s=-1.0), (0.9, np.linspace(-5.0, 6.0, 15))
FADE = EffectiveProperties(mismatch_k=Transition(0.15, 15.0, 1.0, 2.0))
WHEEL, RAIL = Surface(UPPER, arc(10.3, 0.4, 1.0), 120.0), Surface(LOWER, arc(10.0, 0.45, 1.1))


def pair(effective=None, upper=None, lower=None):
    return Pair(Solid(STEEL, WHEEL, upper), Solid(BRASS, RAIL, lower), effective)


def bodies(of, variant):
    return [solid.approximate(variant, PATCH, LINE) for solid in (of.upper, of.lower)]


@pytest.mark.parametrize("variant", VARIANTS)
def test_combined_is_the_sum_each_body_with_its_own_rotations(variant):
    of = pair(upper=FADE, lower=FADE)
    upper, lower = bodies(of, variant)
    np.testing.assert_array_equal(of.approximate(variant, PATCH, LINE), upper + lower)


def test_combined_effective_properties_act_on_the_combined_constants_and_the_lower_surface():
    x, s = LINE
    half_space = HalfSpace(both_bodies(STEEL, BRASS), effective=FADE)
    alpha = RAIL.contour.inclination(s) - RAIL.contour.inclination(-1.0)  # no rotation about y: the rail's
    expected = FORMS["Bhat"].rotate(half_space.effective_ics(PATCH, x, s + 1.0), rotation_about_x(alpha))
    got = pair(FADE).approximate("Bhat_prime", PATCH, LINE)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-14 * np.max(expected))


def test_mix_takes_xn_and_nx_from_them_and_nothing_else():
    with_fit, without = (pair(fit).approximate("mix", PATCH, LINE) for fit in (FADE, None))
    b_hat_prime = pair(FADE).approximate("Bhat_prime", PATCH, LINE)
    for i in range(3):
        for j in range(3):
            expected = b_hat_prime if {i, j} == {0, 2} and i != j else without
            np.testing.assert_array_equal(with_fit[i, j], expected[i, j])


def test_b_hat_prime_is_known_where_its_properties_are():
    assert [pair(FADE).has_effective(name) for name in ("combined", "upper", "lower")] == [True, False, False]
    of_upper = pair(upper=FADE)
    assert [of_upper.has_effective(name) for name in ("combined", "upper", "lower")] == [False, True, False]
    assert pair(upper=FADE, lower=FADE).has_effective("combined")
    with pytest.raises(WrongInput, match="effective properties"):
        of_upper.approximate("Bhat_prime", PATCH, LINE)


def test_curvature_apart_with_the_half_space_s_properties_is_bhat():
    """Equal contours: combined constants on the lower prismatic surface and what curvature adds are B-hat."""
    contour = arc(10.0, 0.45, 1.1)
    wheel, roller = Surface(UPPER, contour, 120.0), Surface(LOWER, contour, 80.0)
    bodies = Solid(STEEL, wheel), Solid(BRASS, roller)
    k = Pair(*bodies).constants.mismatch_k
    nothing = EffectiveProperties(mismatch_k=Transition(k, 15.0, 1.0, 2.0))
    apart = Pair(*bodies, nothing, curvature_apart=True).approximate("Bhat_prime", PATCH, LINE)
    bhat = Pair(*bodies).approximate("Bhat", PATCH, LINE)
    np.testing.assert_allclose(apart, bhat, atol=1e-14 * np.max(np.abs(bhat)))
    contained = Pair(*bodies, nothing).approximate("Bhat_prime", PATCH, LINE)
    assert np.max(np.abs(contained - bhat)) > 1e-4 * np.max(np.abs(bhat))


def test_curvature_of_prismatic_bodies_adds_nothing():
    prismatic = Pair(Solid(STEEL, Surface(UPPER, WHEEL.contour)), Solid(BRASS, RAIL))
    np.testing.assert_array_equal(prismatic.curvature(PATCH, LINE), 0.0)
