"""Factors of friction by contact angle: the law itself, and contacts with it."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.friction.motion import Creepages, friction_factors, in_words, largest_factor
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.contact.rolling import compressed
from geometries.errors import WrongInput
from geometries.patches import N
from tests.femic.contact.friction_problems import (
    MIXED,
    POINT,
    groove,
    law_errors,
    paraboloids,
    wheel_on,
)
from tests.femic.contact.problems import STEEL

LOAD = POINT.load
FLANGE = [(5.0, 1.2), (20.0, 0.4)]
CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)
GROOVE = groove(materials=MIXED)


def with_law(problem, pairs=FLANGE):
    return replace(problem, factor=friction_factors(pairs, problem.inclination))


def rolled(problem, creepages=CREEPAGES):
    return wheel_on(problem).contact(creepages, Loading(LOAD)).contact


def tangential(contact):
    return np.linalg.norm(contact.p[..., :N], axis=-1)


# ---- the law


def test_factors_are_linear_between_angles_constant_beyond_and_the_same_on_both_sides():
    angles = np.array([0.0, 5.0, 10.0, 12.5, 20.0, 70.0])
    expected = np.array([1.2, 1.2, 1.2 - 0.8 / 3, 0.8, 0.4, 0.4])
    for sign in (1, -1):
        np.testing.assert_allclose(friction_factors(FLANGE, sign * np.radians(angles)), expected, rtol=1e-12)
    np.testing.assert_array_equal(friction_factors([], np.radians(angles)), np.ones(6))
    np.testing.assert_array_equal(friction_factors([(30.0, 0.7)], np.radians(angles)), np.full(6, 0.7))


def test_the_law_is_said_in_words_and_has_a_largest_factor():
    assert in_words(FLANGE).endswith(
        "depends on the contact angle: 1.2 at 5°, 0.4 at 20°, linear between, constant beyond."
    )
    assert in_words([]) == ""
    assert largest_factor(FLANGE) == 1.2
    assert largest_factor([]) == 1.0


def test_factors_that_do_not_fit_the_strips_are_refused():
    n_s = GROOVE.grid.n_s
    with pytest.raises(WrongInput, match=rf"factor of friction, shape \(3,\): one per strip, .*\({n_s},\)"):
        replace(GROOVE, factor=np.ones(3))
    for wrong in (-0.1, np.nan, np.inf):
        factor = np.ones(n_s)
        factor[2] = wrong
        with pytest.raises(WrongInput, match=r"at strip 2: must be zero or positive, and finite"):
            replace(GROOVE, factor=factor)


# ---- contacts


def test_a_factor_of_1_is_no_factor_and_that_of_a_half_is_half_of_the_coefficient():
    whole = replace(GROOVE, friction=0.8)
    here, ones, half, there = (
        rolled(of)
        for of in (
            whole,
            with_law(whole, [(0, 1)]),
            with_law(whole, [(9, 0.5)]),
            replace(whole, friction=0.4),
        )
    )
    np.testing.assert_array_equal(ones.p, here.p)
    np.testing.assert_allclose(half.p, there.p, atol=1e-5 * here.p.max())
    assert half.largest_work == pytest.approx(there.largest_work, rel=1e-5)
    assert np.any(there.stick)
    np.testing.assert_array_equal(half.slip_state.open, there.slip_state.open)
    np.testing.assert_allclose(half.slip_state.friction, there.slip_state.friction)
    assert np.max(np.abs(half.p - here.p)) > 0.02 * here.p.max()


@pytest.mark.parametrize("order", [1, 2])
def test_coulombs_law_holds_with_the_coefficient_of_each_strip(order):
    problem = with_law(replace(GROOVE, friction=0.8))
    wheel = wheel_on(problem, order=order)
    contact = wheel.contact(CREEPAGES, Loading(LOAD)).contact
    errors = law_errors(contact, contact.motion.rigid, order=order, dx=problem.grid.dx)
    assert np.all(errors < 3e-6)
    pressed = contact.p[..., N].max(axis=0) > 0
    assert np.ptp(problem.factor[pressed]) > 0.5
    assert 0.1 < contact.sliding_share < 0.9


def test_where_all_slides_along_x_each_strip_bears_its_own_friction():
    """Rigid slip along s is below 1/40 of that along x: forces along x lack 3e-4 at most."""
    problem = with_law(GROOVE)
    contact = rolled(problem, Creepages(0.5))
    assert contact.sliding_share == 1.0
    strips = contact.p[..., N].sum(axis=0) * problem.grid.area  # N, by strip
    borne = problem.friction * np.sum(friction_factors(FLANGE, problem.inclination) * strips)
    assert contact.force[0] == pytest.approx(borne, rel=1e-3)
    assert borne < 0.9 * problem.friction * np.sum(strips)


def test_mirrored_bodies_have_mirrored_tractions():
    """The law is that of both sides: the contact of the mirrored groove lies on the other one."""
    here = rolled(with_law(GROOVE))
    mirrored = wheel_on(with_law(groove(materials=MIXED, mirrored=True)), mirrored=True)
    creepages = Creepages(CREEPAGES.longitudinal, -CREEPAGES.lateral, -CREEPAGES.spin)
    there = mirrored.contact(creepages, Loading(LOAD)).contact
    np.testing.assert_allclose(there.p[:, ::-1] * [1, -1, 1], here.p, atol=2e-5 * here.p.max())


def test_small_creepages_give_kalkers_force_whatever_the_factors():
    """Friction is large on every strip; without slip its coefficient does not matter."""
    problem = paraboloids(40, 36, friction=3.0, room=(1.3, 1.3))
    problem = replace(problem, factor=np.linspace(0.8, 3.0, 36))
    contact = rolled(problem, Creepages(1e-5))
    G = STEEL.E / 2 / (1 + STEEL.nu)
    exact, _, _ = creepage_coefficients(POINT.a, POINT.b, STEEL.nu).forces(G, 1e-5, 0.0, 0.0)
    assert contact.force[0] == pytest.approx(exact, rel=0.012)


def test_strips_without_friction_bear_none():
    factor = np.where(np.arange(GROOVE.grid.n_s) % 3 == 0, 0.0, 1.0)
    contact = rolled(replace(GROOVE, factor=factor))
    assert not np.any(tangential(contact)[:, ::3])
    assert np.any(tangential(contact)[:, 1::3])
    assert contact.force[2] == pytest.approx(LOAD, rel=1e-6)


def test_elements_twice_as_large_have_the_mean_of_two_strips():
    factor = np.linspace(0.2, 1.0, 32)
    problem = replace(paraboloids(64, 32), factor=factor)
    np.testing.assert_allclose(problem.coarsened.factor, (factor[::2] + factor[1::2]) / 2)
    motion = wheel_on(problem).contact(CREEPAGES, Loading(LOAD)).contact.motion
    contact = solve(problem, motion, Loading(LOAD))
    assert contact.coarser.force == pytest.approx(contact.force, rel=0.05)


def test_compression_and_rolling_from_rest_have_the_friction_of_each_strip():
    problem = with_law(replace(GROOVE, friction=0.6))
    *_, pressed = compressed(problem, [Loading(LOAD / 2), Loading(LOAD)])
    *_, moved = wheel_on(problem).transient(CREEPAGES, Loading(LOAD), 3)
    for contact in (pressed, moved.contact):
        bound = 0.6 * problem.factor * contact.p[..., N]
        slides = contact.in_contact & ~contact.stick
        assert np.count_nonzero(slides) > 5
        np.testing.assert_allclose(tangential(contact)[slides], bound[slides], rtol=1e-5)
        assert np.all(tangential(contact) <= bound + 1e-6 * bound.max())
