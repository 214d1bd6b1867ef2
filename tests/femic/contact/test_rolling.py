"""Steady rolling: forces and creepages, mirrors, Kalker's coefficients."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import ForcesBeyondFriction
from femic.contact.friction.motion import NAMES, Creepages
from femic.contact.frictional import _Solution
from femic.contact.loading import Loading
from geometries.errors import Failure, WrongInput
from geometries.patches import N
from tests.femic.contact.friction_problems import MIXED, POINT, groove, paraboloids, wheel_on
from tests.femic.contact.problems import STEEL, x_of

LOAD = POINT.load
FLAT, GROOVE, OF_BOTH = paraboloids(offset=(0.2, 0.3)), groove(), groove(materials=MIXED)
CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)


def torque(contact, rolling):
    """Moment about z of the forces on all elements, one by one."""
    problem, total = contact.problem, 0.0
    for i, j in np.ndindex(*contact.in_contact.shape):
        p_x, p_s, p_n = contact.p[i, j] * problem.grid.area
        delta, y = problem.inclination[j], rolling.contour.position(rolling.s[j])[0]
        total += rolling.x[i] * (p_s * np.cos(delta) + p_n * np.sin(delta)) - y * p_x
    return float(total)


# ---- forces

PRESCRIBED = {"longitudinal": 300.0, "lateral": 150.0, "spin": -200.0}


@pytest.mark.parametrize("order", [pytest.param(1, marks=pytest.mark.slow), 2])
@pytest.mark.parametrize(
    "names",
    [NAMES[:1], NAMES, *(pytest.param(names, marks=pytest.mark.slow) for names in (NAMES[1:2], NAMES[:2]))],
    ids=str,
)
@pytest.mark.parametrize("problem", [FLAT, OF_BOTH], ids=["half-spaces", "two materials"])
def test_solved_creepages_reproduce_forces_and_tractions(problem, names, order):
    wheel = wheel_on(problem, order=order)
    forces = {name: PRESCRIBED[name] for name in names}
    if problem is OF_BOTH:  # pressures have a lateral force and a moment of their own
        own = wheel.contact(Creepages(), Loading(LOAD)).contact
        pressed = dict(zip(NAMES, (*own.force[:2], torque(own, wheel.rolling)), strict=True))
        forces = {name: pressed[name] + 0.3 * forces[name] for name in names}
    result = wheel.contact(CREEPAGES, Loading(LOAD), forces=forces)
    has = dict(zip(NAMES, (*result.contact.force[:2], torque(result.contact, wheel.rolling)), strict=True))
    for name in NAMES:
        if name in names:
            assert has[name] == pytest.approx(forces[name], abs=1e-4 * 0.3 * LOAD)
        else:
            assert getattr(result.creepages, name) == getattr(CREEPAGES, name)
    again = wheel.contact(result.creepages, Loading(LOAD))
    np.testing.assert_allclose(again.contact.p, result.contact.p, atol=2e-5 * result.contact.p.max())
    assert again.creepages == result.creepages


@pytest.mark.parametrize("guess", [Creepages(), Creepages(0.05), Creepages(-0.02, 0.03, 1e-3)], ids=str)
def test_solution_is_independent_of_the_guess_of_creepages(guess):
    wheel = wheel_on(FLAT)
    forces = {"longitudinal": -0.85 * 0.3 * LOAD, "lateral": 0.2 * 0.3 * LOAD}
    result = wheel.contact(guess, Loading(LOAD), forces=forces)
    exact = wheel.contact(Creepages(spin=guess.spin), Loading(LOAD), forces=forces)
    for name in NAMES:
        assert getattr(result.creepages, name) == pytest.approx(
            getattr(exact.creepages, name), rel=1e-3, abs=1e-7
        )
    warm = wheel.contact(guess, Loading(LOAD), forces=forces, start=result.contact)
    assert warm.creepages.longitudinal == pytest.approx(result.creepages.longitudinal, rel=1e-4)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("times", [1.01, 3.0, 1e3])
def test_forces_that_friction_does_not_bear_are_refused_at_once(times, order, monkeypatch):
    monkeypatch.setattr(coulomb, "MOST_STEPS", 0)
    most = 0.3 * LOAD * times
    for forces in ({"longitudinal": -most}, {"longitudinal": 0.8 * most, "lateral": 0.6 * most}):
        with pytest.raises(Failure, match="prescribed forces exceed what friction can supply"):
            wheel_on(FLAT, order=order).contact(Creepages(), Loading(LOAD), forces=forces)


@pytest.mark.parametrize(
    ("failure", "tried"), [(ForcesBeyondFriction, [2]), (Failure, [2, 1, 0])], ids=["not borne", "not found"]
)
def test_simpler_forms_are_tried_only_after_a_failure(failure, tried, monkeypatch):
    depths = []

    def failing(solution, *_):
        depths.append(solution.motion.depth)
        raise failure("no")

    monkeypatch.setattr(_Solution, "in_turns", failing)
    coarsest = paraboloids(14, 12)
    with pytest.raises(failure):
        wheel_on(coarsest).contact(Creepages(), Loading(LOAD))
    assert depths == tried


def test_contact_solved_in_a_simpler_form_is_marked(monkeypatch):
    wheel, end = wheel_on(paraboloids(14, 12)), _Solution.in_turns

    def simpler_only(solution, *of):
        if solution.motion.depth > 1:
            raise Failure("no")
        return end(solution, *of)

    assert not wheel.contact(Creepages(1e-3), Loading(LOAD)).simplified
    first_order = replace(wheel, order=1)
    assert not first_order.contact(Creepages(1e-3), Loading(LOAD)).simplified
    monkeypatch.setattr(_Solution, "in_turns", simpler_only)
    assert wheel.contact(Creepages(1e-3), Loading(LOAD)).simplified


def test_forces_without_friction_or_contact_are_refused():
    for problem, pressing in ((replace(FLAT, friction=0.0), Loading(LOAD)), (FLAT, Loading(approach=-0.1))):
        with pytest.raises(Failure, match="prescribed forces exceed what friction can supply"):
            wheel_on(problem).contact(Creepages(), pressing, forces={"longitudinal": 0.0})


def test_unknown_names_of_forces_are_refused():
    with pytest.raises(WrongInput, match="forces of radial: creepages are longitudinal, lateral, spin"):
        wheel_on(FLAT).contact(Creepages(), Loading(LOAD), forces={"radial": 1.0})


# ---- energy

SIZES = 16, 32  # elements along x; on 64 it goes on as fast


def moved_as_it_rolls(wheel, creepages):
    """The same, its distance changing along x by minus the rigid velocity along n, so by a yaw, too.

    That velocity is linear in x.
    """
    problem, x = wheel.problem, wheel.rolling.x[:, None]
    along_n = wheel.rolling.rigid_velocity(creepages)[..., N]
    at_middle = (along_n + along_n[::-1]) / 2
    distance = problem.distance[problem.grid.n_x // 2] - x * (along_n + at_middle) / 2
    return wheel_on(replace(problem, distance=distance))


def lost_of(wheel, creepages, *, climbs):
    """What friction takes over the work on the rigid motion, less 1, and the share of this that climbs."""
    rolling = wheel.contact(creepages, Loading(LOAD))
    taken = np.sum(rolling.contact.dissipation) * wheel.problem.grid.area
    climbing = wheel.climbing(rolling) if climbs else 0.0
    return taken / (wheel.power(rolling) - climbing) - 1, wheel.climbing(rolling) / wheel.power(rolling)


@pytest.mark.parametrize("yawed", [True, False], ids=["as it moves", "at zero yaw"])
def test_friction_takes_the_work_on_the_rigid_motion(yawed):
    """Of a wheel moved aside, with all creepages, both ways through K, to nearly the second order.

    What a zero yaw leaves out of the distance is `climbing`: 40 % of the work here. Tangential tractions
    alone would be off by 9 % on any grid.
    """
    creepages, lost = Creepages(-3e-4, -4e-4, 5e-5), []
    for n in SIZES:
        wheel = wheel_on(groove(n, n + 4, materials=MIXED))
        if yawed:
            wheel = moved_as_it_rolls(wheel, creepages)
        off, climbs = lost_of(wheel, creepages, climbs=not yawed)
        lost.append(abs(off))
        assert abs(climbs) > 0.2
    assert lost[1] < 0.02
    assert lost[0] / lost[1] > 3


# ---- mirrors


@pytest.mark.parametrize("order", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_mirror_in_s_mirrors_the_contact(order):
    """Also what a mirror in x does, with the rolling turned round by a half turn about z."""
    here = wheel_on(OF_BOTH, order=order).contact(CREEPAGES, Loading(LOAD)).contact
    mirrored = wheel_on(groove(materials=MIXED, mirrored=True), order=order, mirrored=True)
    creepages = Creepages(CREEPAGES.longitudinal, -CREEPAGES.lateral, -CREEPAGES.spin)
    there = mirrored.contact(creepages, Loading(LOAD)).contact
    np.testing.assert_allclose(there.p[:, ::-1] * [1, -1, 1], here.p, atol=2e-5 * here.p.max())
    np.testing.assert_array_equal(there.stick[:, ::-1], here.stick)
    assert there.force == pytest.approx(here.force * [1, -1, 1], abs=2e-5 * LOAD)
    assert np.max(np.abs(there.p[:, ::-1] - here.p)) > 0.1 * here.p.max()


def test_opposite_creepages_on_a_plane_reverse_tractions():
    """Of longitudinal and lateral ones: half-spaces have no sides of their own."""
    wheel = wheel_on(FLAT)
    here, there = (
        wheel.contact(Creepages(sign * 1e-3, sign * 5e-4), Loading(LOAD)).contact for sign in (1, -1)
    )
    np.testing.assert_allclose(there.p, here.p * [-1, -1, 1], atol=1e-5 * here.p.max())
    assert here.force[0] > 0 > here.force[1]  # a driven wheel is pushed on, lateral slip is resisted


# ---- Kalker


COEFFICIENTS = cache(lambda: creepage_coefficients(POINT.a, POINT.b, STEEL.nu))


@pytest.mark.parametrize("name", NAMES)
def test_small_creepages_give_kalkers_forces(name):
    """Where friction is large, to the second order; the contact is that of the grid, of Hertz to 0.3 %."""
    n_x, n_s = 40, 36
    problem = paraboloids(n_x, n_s, friction=3.0, room=(1.3, 1.3))
    size = 1e-5 if name != "spin" else 1e-5 / np.sqrt(POINT.a * POINT.b)
    wheel = wheel_on(problem)
    contact = wheel.contact(Creepages(**{name: size}), Loading(LOAD)).contact
    assert contact.sliding_share < 0.02
    G = STEEL.E / 2 / (1 + STEEL.nu)  # combined: of two equal bodies that of one
    creepages = [size * (name == other) for other in NAMES]
    F_x, F_s, M_n = COEFFICIENTS().forces(G, *creepages)
    c = np.sqrt(POINT.a * POINT.b)
    result = np.array([*contact.force[:2], torque(contact, wheel.rolling) / c])
    exact = np.array([F_x, F_s, M_n / c])
    largest = np.max(np.abs(exact))
    np.testing.assert_allclose(result, exact, atol=0.012 * largest)
    assert largest > 1.0


def test_forces_grow_with_friction_and_creepage_to_all_that_friction_bears():
    wheel = wheel_on(FLAT)
    forces = [
        wheel.contact(Creepages(creepage), Loading(LOAD)).contact.force[0] for creepage in (1e-4, 1e-3, 1e-2)
    ]
    assert 0 < forces[0] < forces[1] < forces[2]
    assert forces[2] == pytest.approx(0.3 * LOAD, rel=1e-3)
    np.testing.assert_allclose(x_of(FLAT.grid), wheel.rolling.x)
