"""Pressures and tangential tractions at once: equations against differences, contacts against turns."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from femic.contact import coupled, frictional
from femic.contact.coupled import Coupled, State
from femic.contact.friction.motion import Creepages, RollingStep, Shift, SteadyRolling
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.contact.patch import Box
from femic.contact.small import Guess
from tests.femic.contact.friction_problems import MIXED, groove, law_errors, movable, paraboloids, wheel_on

pytestmark = pytest.mark.usefixtures("for_any_grid")

LOAD, LESS = Loading(4000.0), Loading(3000.0)
GROOVE = replace(groove(materials=MIXED), friction=0.6)
WHEEL = wheel_on(GROOVE)
RIGID = WHEEL.rolling.rigid_slip(Creepages(-1e-3, 5e-4, 1e-4))
SINES = np.sin(GROOVE.inclination)
BEFORE = 1e-3 * np.random.default_rng(0).normal(size=RIGID.shape)
MOTIONS = {
    "shift": Shift(RIGID, per_approach=SINES),
    "first order": SteadyRolling(RIGID, dx=GROOVE.grid.dx, order=1),
    "second order": SteadyRolling(RIGID, dx=GROOVE.grid.dx),
    "step": RollingStep(RIGID, dx=GROOVE.grid.dx, before=BEFORE),
}


@cache
def motion_of(name):
    """One of `MOTIONS`, or rolling with forces that determine two creepages."""
    if name in MOTIONS:
        return MOTIONS[name]
    given = {"longitudinal": 500.0} if name == "one force" else {"longitudinal": 500.0, "lateral": -300.0}
    return WHEEL.contact(Creepages(), LOAD, forces=given).contact.motion


@cache
def in_groove(name, loading):
    """The contact of a motion."""
    return solve(GROOVE, motion_of(name), loading)


names = pytest.mark.parametrize("name", [*MOTIONS, "forces"])


def near(name, size=0.03):
    """A guess near the contact, and the contact."""
    contact = in_groove(name, LOAD)
    p = contact.p * (1 + size * np.random.default_rng(1).normal(size=contact.p.shape))
    return Guess(p, contact.amplitudes * (1 + size), contact.approach * (1 + size / 10)), contact


def state_near(name):
    return State.from_guess(Coupled(GROOVE, motion_of(name), LOAD), near(name)[0])


# ---- equations


@names
@pytest.mark.parametrize("loading", ["load", "approach"])
def test_equations_have_the_derivative_of_the_residual(name, loading):
    """With elements in contact and at the leading edge as they are; bounds change, tractions with them."""
    guess, contact = near(name)
    system = Coupled(
        GROOVE, motion_of(name), LOAD if loading == "load" else Loading(approach=contact.approach)
    )
    state = State.from_guess(system, replace(guess, approach=0.95 * guess.approach))  # nothing joins
    stick = np.count_nonzero(state.law.stick)
    assert 0 < stick < len(state.law.stick)
    random = np.random.default_rng(2)
    for _ in range(6):
        v = random.normal(size=len(state.residual))
        pressures, q, others = state.parts(v)
        pressures *= state.p[state.contact][:, 2]
        amplitudes, approach = system.split(others)
        h, ends = 1e-7, []
        for sign in (1, -1):
            p = state.p + sign * h * state.tractions(pressures, q)[0]
            given = Guess(p, state.c + sign * h * amplitudes, state.approach + sign * h * approach)
            moved = State._in_contact(system, given, p[..., 2])
            np.testing.assert_array_equal(moved.law.stick, state.law.stick)
            ends.append(moved.residual)
        expected = (ends[0] - ends[1]) / (2 * h)
        np.testing.assert_allclose(state.derivative(v), expected, atol=1e-4 * np.max(np.abs(expected)))


@names
def test_preconditioner_meets_forces_and_load(name):
    """Whatever it makes of gaps and friction: no component of the residual of forces is left."""
    state = state_near(name)
    k = len(state.coupled.targets)
    assert k == (3 if name == "forces" else 1)
    v = np.random.default_rng(3).normal(size=len(state.residual))
    np.testing.assert_allclose(state.derivative(state.inverse(v))[-k:], v[-k:], atol=1e-9 * np.max(np.abs(v)))


def test_residuals_are_gaps_law_forces_and_load():
    state = state_near("second order")
    gaps, of_law, (of_load,) = state.parts(state.residual)
    own_gap, own_slip = state.coupled.self_compliance
    u = GROOVE.operator(state.p)
    expected = u[..., 2] + GROOVE.distance - state.approach * np.cos(GROOVE.inclination)
    np.testing.assert_allclose(gaps * own_gap, expected[state.contact], atol=1e-12)
    np.testing.assert_allclose(of_law, state.law.residual)
    assert state.law.scale == pytest.approx(1 / own_slip)
    vertical = state.p[..., 2] * np.cos(GROOVE.inclination) - state.p[..., 1] * np.sin(GROOVE.inclination)
    load = np.sum(vertical) * GROOVE.grid.area
    assert of_load * state.unit_forces[-1] == pytest.approx(load - LOAD.load)


# ---- states


def test_a_state_has_no_negative_pressures_and_followers_at_their_bounds():
    guess, contact = near("second order")
    p = guess.p.copy()
    pressed = tuple(np.argwhere(contact.in_contact)[5])
    p[pressed] = 3.0, 4.0, -1.0
    system = Coupled(GROOVE, MOTIONS["second order"], LOAD)
    state = State.from_guess(system, replace(guess, p=p, approach=0.5 * guess.approach))
    np.testing.assert_array_equal(state.p[pressed], 0.0)
    assert np.min(state.p[..., 2]) == 0
    np.testing.assert_allclose(state.u, GROOVE.operator(state.p), atol=1e-15)
    np.testing.assert_allclose(state.p[..., :2], state.edge.spread(state.p[..., :2]), rtol=1e-12)


def test_elements_with_overlap_join():
    contact = in_groove("shift", LOAD)
    further = Guess(contact.p, contact.amplitudes, 1.3 * contact.approach)
    state = State.from_guess(Coupled(GROOVE, MOTIONS["shift"], LOAD), further)
    gap = contact.u[..., 2] + GROOVE.distance - 1.3 * contact.approach * np.cos(GROOVE.inclination)
    np.testing.assert_array_equal(state.contact, contact.in_contact | (gap < 0))
    assert np.count_nonzero(state.contact) > np.count_nonzero(contact.in_contact)


# ---- contacts


@names
def test_contacts_at_once_are_those_in_turns(name, monkeypatch):
    motion, before = motion_of(name), in_groove(name, LESS)
    at_once = solve(GROOVE, motion, LOAD, start=before)
    assert at_once.turns == 0
    monkeypatch.setattr(coupled, "solve", lambda *_: None)
    in_turns = solve(GROOVE, motion, LOAD, start=before)
    assert in_turns.turns > 3
    np.testing.assert_allclose(at_once.p, in_turns.p, atol=1e-5 * in_turns.p.max())
    np.testing.assert_allclose(at_once.amplitudes, in_turns.amplitudes, rtol=1e-4)
    np.testing.assert_array_equal(at_once.stick, in_turns.stick)
    np.testing.assert_allclose(at_once.gap, in_turns.gap, atol=1e-5 * in_turns.approach)
    np.testing.assert_allclose(at_once.slip, in_turns.slip, atol=1e-4 * np.max(np.abs(in_turns.slip)))
    assert at_once.approach == pytest.approx(in_turns.approach, rel=1e-5)
    assert at_once.force[2] == pytest.approx(LOAD.load, rel=1e-6)
    if name.endswith("order"):
        assert np.all(law_errors(at_once, motion.rigid, order=motion.order, dx=motion.dx) < 3e-6)


def test_friction_that_differs_by_strip_bounds_each_strip(monkeypatch):
    """Three times as large on one side, and in a box of the grid's strips."""
    factor = np.linspace(0.5, 1.5, GROOVE.grid.n_s)
    problem, motion = replace(GROOVE, factor=factor), MOTIONS["second order"]
    before = solve(problem, motion, LESS)
    at_once = solve(problem, motion, LOAD, start=before)
    assert at_once.turns == 0
    assert np.all(law_errors(at_once, motion.rigid, order=2, dx=motion.dx) < 3e-6)
    other = solve(replace(problem, factor=factor[::-1]), motion, LOAD)
    assert np.max(np.abs(other.p - at_once.p)) > 0.05 * at_once.p.max()
    monkeypatch.setattr(coupled, "solve", lambda *_: None)
    in_turns = solve(problem, motion, LOAD, start=before)
    np.testing.assert_allclose(at_once.p, in_turns.p, atol=1e-5 * in_turns.p.max())
    np.testing.assert_array_equal(at_once.stick, in_turns.stick)


def test_from_nothing_both_are_sought_after_some_turns(monkeypatch):
    first, *_ = frictional.AT_ONCE_AFTER
    there = in_groove("shift", LOAD)
    assert there.turns == first
    monkeypatch.setattr(frictional, "AT_ONCE_AFTER", ())
    here = solve(GROOVE, MOTIONS["shift"], LOAD)
    assert here.turns > first
    np.testing.assert_allclose(there.p, here.p, atol=1e-5 * here.p.max())


def test_a_given_approach_is_kept():
    less = in_groove("shift", LESS)
    given = 1.05 * less.approach
    contact = solve(GROOVE, MOTIONS["shift"], Loading(approach=given), start=less)
    assert (contact.turns, contact.approach) == (0, given)
    assert contact.force[2] > 1.01 * less.force[2]


def test_the_contact_is_its_own_guess(monkeypatch):
    motion = MOTIONS["second order"]
    contact = solve(GROOVE, motion, LOAD, start=in_groove("second order", LESS))
    monkeypatch.setattr(State, "newton_update", lambda *_: pytest.fail("a step is taken"))
    again = solve(GROOVE, motion, LOAD, start=contact)
    np.testing.assert_allclose(again.p, contact.p, atol=1e-12 * contact.p.max())


def test_forces_that_are_not_met_are_no_solution():
    """Far from them all slips one way, and tractions do not change with creepages."""
    motion, contact = motion_of("one force"), in_groove("one force", LOAD)
    for amplitude in (1.0, -1e3, 1e7):
        guess = Guess(contact.p, np.array([amplitude]), contact.approach)
        state = coupled.solve(Coupled(GROOVE, motion, LOAD), guess, 1e-6)
        assert state is None or state.c[0] == pytest.approx(contact.amplitudes[0], rel=1e-3)


def test_no_contact_is_found_from_none():
    system = Coupled(GROOVE, MOTIONS["shift"], LOAD)
    assert coupled.solve(system, Guess(np.zeros((*RIGID.shape[:2], 3)), np.zeros(0), -1.0), 1e-6) is None


# ---- in a box


def boxes(monkeypatch):
    """The boxes in which contacts are sought."""
    seen, within = [], frictional.FrictionalProblem.within

    def watched(problem, box):
        seen.append(box)
        return within(problem, box)

    monkeypatch.setattr(frictional.FrictionalProblem, "within", watched)
    return seen


WIDE = paraboloids(64, 48, room=(4.0, 4.0), materials=MIXED)
ROLLS = SteadyRolling(wheel_on(WIDE).rolling.rigid_slip(Creepages(-1e-3, 5e-4, 1e-4)), dx=WIDE.grid.dx)


def test_a_contact_that_is_confined_is_the_one_on_the_whole_grid(monkeypatch):
    start = solve(WIDE, ROLLS, LESS)
    seen = boxes(monkeypatch)
    here = solve(WIDE, ROLLS, LOAD, start=start)
    whole = Box.whole(WIDE.distance.shape)
    assert {box == whole for box in seen} == {False}
    monkeypatch.setattr(Box, "around", lambda _: whole)
    there = solve(WIDE, ROLLS, LOAD, start=start)
    np.testing.assert_allclose(here.p, there.p, atol=1e-6 * there.p.max())
    np.testing.assert_allclose(here.u, WIDE.operator(here.p), atol=1e-12)
    np.testing.assert_allclose(here.gap, there.gap, atol=1e-6 * there.approach)
    assert np.min(here.gap) == 0


def test_a_contact_that_outgrows_its_box_is_sought_on_the_whole_grid(monkeypatch):
    problem = paraboloids(40, 36, materials=MIXED)
    motion = SteadyRolling(wheel_on(problem).rolling.rigid_slip(Creepages(-1e-3)), dx=problem.grid.dx)
    start = solve(problem, motion, Loading(20.0))
    seen = boxes(monkeypatch)
    contact = solve(problem, motion, LOAD, start=start)
    assert seen[0] != Box.whole(problem.distance.shape) == seen[-1]
    assert np.min(contact.gap) == 0
    same = solve(problem, motion, LOAD)
    np.testing.assert_allclose(contact.p, same.p, atol=1e-5 * same.p.max())


def test_overlap_elsewhere_is_found(monkeypatch):
    """Another place comes into contact, far from the first one, which hardly grows."""
    distance, first = WIDE.distance.copy(), solve(WIDE, ROLLS, LESS)
    distance[48:, 38:] -= distance[48:, 38:].min() - 0.95 * first.approach
    problem = replace(WIDE, distance=distance)
    start = solve(problem, ROLLS, LESS)
    assert not np.any(start.p[48:, 38:])
    seen = boxes(monkeypatch)
    contact = solve(problem, ROLLS, LOAD, start=start)
    assert seen[0] != Box.whole(distance.shape) == seen[-1]
    assert np.any(contact.p[48:, 38:, 2] > 0)
    u = problem.operator(contact.p)[..., 2]
    assert np.min((u + distance - contact.approach)[contact.p[..., 2] == 0]) > -1e-9


def test_a_contact_at_the_end_of_its_box_is_sought_on_the_whole_grid(monkeypatch):
    """Slip there would lack its neighbour ahead."""
    start = solve(WIDE, ROLLS, LESS)
    there = solve(WIDE, ROLLS, LOAD, start=start)
    rows, strips = (np.flatnonzero(there.in_contact.any(axis=axis)) for axis in (1, 0))
    tight = Box((int(rows[0]), int(rows[-1]) + 1), (int(strips[0]), int(strips[-1]) + 1))
    monkeypatch.setattr(Box, "around", lambda _: tight)
    here = solve(WIDE, ROLLS, LOAD, start=start)
    np.testing.assert_allclose(here.p, there.p, atol=1e-6 * there.p.max())


def test_operators_of_which_only_products_are_known_will_do():
    problem = movable(WIDE, z=1e-6)
    here, there = (solve(of, ROLLS, LOAD, start=solve(of, ROLLS, LESS)) for of in (WIDE, problem))
    np.testing.assert_allclose(there.p, here.p, atol=1e-5 * here.p.max())
    assert there.turns == 0
    assert there.approach - here.approach == pytest.approx(4e-3, rel=1e-3)
