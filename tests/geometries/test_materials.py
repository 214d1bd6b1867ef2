import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometries.materials import Material, both_bodies, one_body

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
quiet = settings(deadline=None, max_examples=60, database=None)
materials = st.builds(Material, st.floats(1e-3, 1e9), st.floats(0, 0.499))


def strength(h):
    """What the half-space ICs are proportional to: those of nn, of the part with nu, of xn and sn."""
    return h.factor / h.G * np.array([1 - h.nu, h.nu, h.mismatch_k])


# --- one material ----------------------------------------------------------------------------------


@quiet
@given(materials)
def test_lame_parameters_give_back_the_engineering_constants(m):
    # 1 - 2 nu loses up to 1 / 0.002 of the digits, and the way back as many
    assert m.G * (3 * m.lame + 2 * m.G) / (m.lame + m.G) == pytest.approx(m.E, rel=1e-12)
    assert m.lame / (2 * (m.lame + m.G)) == pytest.approx(m.nu, rel=1e-12, abs=1e-15)
    assert m.lame + 2 * m.G / 3 == pytest.approx(m.E / (3 * (1 - 2 * m.nu)), rel=1e-12)  # the bulk modulus


def test_limits_of_poisson_ratio():
    cork, rubber = Material(90.0, 0.0), Material(90.0, 0.5)
    assert (cork.G, cork.lame) == (45.0, 0.0)
    assert (rubber.G, rubber.lame) == (30.0, np.inf)


@pytest.mark.parametrize(
    ("E", "nu", "message"),
    [
        *((E, 0.3, rf"E = {E!r}.*positive") for E in (0.0, -210e3, np.nan, np.inf)),
        *((210e3, nu, rf"nu = {nu!r}.*0 \.\.\. 0\.5") for nu in (-0.01, 0.51, np.nan)),
    ],
)
def test_bad_constants_are_named(E, nu, message):
    with pytest.raises(ValueError, match=message):
        Material(E, nu)


# --- two bodies ------------------------------------------------------------------------------------


@quiet
@given(upper=materials, lower=materials)
def test_both_bodies_are_the_sum_of_upper_and_lower(upper, lower):
    """Exchanged, their mismatch changes its sign."""
    total = strength(one_body(upper, +1)) + strength(one_body(lower, -1))
    rounding = {"rtol": 0, "atol": 1e-14 * total[0]}
    np.testing.assert_allclose(strength(both_bodies(upper, lower)), total, **rounding)
    np.testing.assert_allclose(strength(both_bodies(lower, upper)), total * [1, 1, -1], **rounding)


@quiet
@given(materials)
def test_equal_materials_have_no_mismatch_at_all_and_keep_their_constants(m):
    both = both_bodies(m, m)
    assert both.mismatch_k == 0.0
    assert (both.G, both.nu) == pytest.approx((m.G, m.nu), rel=1e-14)


def test_one_body_has_the_mismatch_of_its_side():
    assert one_body(STEEL, +1).mismatch_k == pytest.approx((1 - 2 * 0.28) / 2, rel=1e-15)
    assert one_body(STEEL, -1).mismatch_k == -one_body(STEEL, +1).mismatch_k
    assert one_body(Material(9.0, 0.5), +1).mismatch_k == 0.0  # incompressible: uncoupled


@pytest.mark.parametrize("ratio", [1e2, 1e4, 1e6])
def test_rigid_counterpart_leaves_the_soft_body_alone(ratio):
    both, soft = both_bodies(Material(97e3 * ratio, 0.2), BRASS), one_body(BRASS, -1)
    np.testing.assert_allclose(strength(both), strength(soft), rtol=3 / ratio)  # what the stiff one adds
