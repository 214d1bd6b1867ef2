"""Rolling: forces and creepages, work, mirrors, Kalker's coefficients; from rest to steady rolling."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.exact.friction import ShiftedPoint
from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import ForcesBeyondFriction
from femic.contact.friction.motion import NAMES, Creepages, Shift
from femic.contact.frictional import _Solution, solve
from femic.contact.loading import Loading
from femic.contact.normal import solve as solve_normal
from femic.contact.rolling import RollingContact
from geometries.errors import Failure, WrongInput
from geometries.patches import N, S, X
from tests.femic.contact.friction_problems import MIXED, POINT, WHEEL, groove, paraboloids, wheel_on
from tests.femic.contact.problems import STEEL

pytestmark = pytest.mark.usefixtures("either_solver")

LOAD = POINT.load
LOADING = Loading(LOAD)
FLAT, GROOVE, OF_BOTH = paraboloids(offset=(0.2, 0.3)), groove(), groove(materials=MIXED)
CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)


def forces_on_elements(wheel, p):
    """(x, y, delta, height, F_x, F_y, F_z) of each element."""
    rolling, problem = wheel.rolling, wheel.problem
    for i, j in np.ndindex(*p.shape[:2]):
        p_x, p_s, p_n = p[i, j] * problem.grid.dx * problem.grid.ds
        delta, y = problem.inclination[j], rolling.contour.position(rolling.s[j])[0]
        sin, cos = np.sin(delta), np.cos(delta)
        yield rolling.x[i], y, delta, rolling.height[j], p_x, p_s * cos + p_n * sin, p_n * cos - p_s * sin


def torque(wheel, p):
    """Moment about z of the forces on all elements, one by one."""
    return float(sum(x * F_y - y * F_x for x, y, _, _, F_x, F_y, _ in forces_on_elements(wheel, p)))


def forces_of(wheel, contact):
    """By the names of creepages."""
    return dict(zip(NAMES, (*contact.force[:2], torque(wheel, contact.p)), strict=True))


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
        pressed = forces_of(wheel, wheel.contact(Creepages(), LOADING).contact)
        forces = {name: pressed[name] + 0.3 * forces[name] for name in names}
    result = wheel.contact(CREEPAGES, LOADING, forces=forces)
    has = forces_of(wheel, result.contact)
    for name in NAMES:
        if name in names:
            assert has[name] == pytest.approx(forces[name], abs=1e-4 * 0.3 * LOAD)
        else:
            assert getattr(result.creepages, name) == getattr(CREEPAGES, name)
    again = wheel.contact(result.creepages, LOADING)
    np.testing.assert_allclose(again.contact.p, result.contact.p, atol=2e-5 * result.contact.p.max())
    assert again.creepages == result.creepages


@pytest.mark.parametrize("guess", [Creepages(), Creepages(0.05), Creepages(-0.02, 0.03, 1e-3)], ids=str)
def test_solution_is_independent_of_the_guess_of_creepages(guess):
    wheel = wheel_on(FLAT)
    forces = {"longitudinal": -0.85 * 0.3 * LOAD, "lateral": 0.2 * 0.3 * LOAD}
    result = wheel.contact(guess, LOADING, forces=forces)
    exact = wheel.contact(Creepages(spin=guess.spin), LOADING, forces=forces)
    for name in NAMES:
        assert getattr(result.creepages, name) == pytest.approx(
            getattr(exact.creepages, name), rel=1e-3, abs=1e-7
        )
    warm = wheel.contact(guess, LOADING, forces=forces, start=result.contact)
    assert warm.creepages.longitudinal == pytest.approx(result.creepages.longitudinal, rel=1e-4)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("times", [1.01, 3.0, 1e3])
def test_forces_that_friction_does_not_bear_are_refused_at_once(times, order, monkeypatch):
    monkeypatch.setattr(coulomb, "MOST_STEPS", 0)
    most = 0.3 * LOAD * times
    for forces in ({"longitudinal": -most}, {"longitudinal": 0.8 * most, "lateral": 0.6 * most}):
        with pytest.raises(Failure, match="prescribed forces exceed what friction can supply"):
            wheel_on(FLAT, order=order).contact(Creepages(), LOADING, forces=forces)


@pytest.mark.usefixtures("for_any_grid")
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
        wheel_on(coarsest).contact(Creepages(), LOADING)
    assert depths == tried


@pytest.mark.usefixtures("for_any_grid")
def test_contact_solved_in_a_simpler_form_is_marked(monkeypatch):
    wheel, end = wheel_on(paraboloids(14, 12)), _Solution.in_turns

    def simpler_only(solution, *of):
        if solution.motion.depth > 1:
            raise Failure("no")
        return end(solution, *of)

    assert not wheel.contact(Creepages(1e-3), LOADING).simplified
    first_order = replace(wheel, order=1)
    assert not first_order.contact(Creepages(1e-3), LOADING).simplified
    monkeypatch.setattr(_Solution, "in_turns", simpler_only)
    assert wheel.contact(Creepages(1e-3), LOADING).simplified


def test_forces_without_friction_or_contact_and_unknown_ones_are_refused():
    for problem, pressing in ((replace(FLAT, friction=0.0), LOADING), (FLAT, Loading(approach=-0.1))):
        with pytest.raises(Failure, match="prescribed forces exceed what friction can supply"):
            wheel_on(problem).contact(Creepages(), pressing, forces={"longitudinal": 0.0})
    with pytest.raises(WrongInput, match="forces of radial: creepages are longitudinal, lateral, spin"):
        wheel_on(FLAT).contact(Creepages(), LOADING, forces={"radial": 1.0})


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
    rolling = wheel.contact(creepages, LOADING)
    taken = np.sum(rolling.contact.dissipation) * wheel.problem.grid.area
    power, climbing = wheel.power(rolling), wheel.climbing(rolling)
    return taken / (power - (climbing if climbs else 0.0)) - 1, climbing / power


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
    here = wheel_on(OF_BOTH, order=order).contact(CREEPAGES, LOADING).contact
    mirrored = wheel_on(groove(materials=MIXED, mirrored=True), order=order, mirrored=True)
    creepages = Creepages(CREEPAGES.longitudinal, -CREEPAGES.lateral, -CREEPAGES.spin)
    there = mirrored.contact(creepages, LOADING).contact
    np.testing.assert_allclose(there.p[:, ::-1] * [1, -1, 1], here.p, atol=2e-5 * here.p.max())
    np.testing.assert_array_equal(there.stick[:, ::-1], here.stick)
    assert there.force == pytest.approx(here.force * [1, -1, 1], abs=2e-5 * LOAD)
    assert np.max(np.abs(there.p[:, ::-1] - here.p)) > 0.1 * here.p.max()


def test_opposite_creepages_on_a_plane_reverse_tractions():
    """Of longitudinal and lateral ones: half-spaces have no sides of their own."""
    wheel = wheel_on(FLAT)
    here, there = (wheel.contact(Creepages(sign * 1e-3, sign * 5e-4), LOADING).contact for sign in (1, -1))
    np.testing.assert_allclose(there.p, here.p * [-1, -1, 1], atol=1e-5 * here.p.max())
    assert here.force[0] > 0 > here.force[1]  # a driven wheel is pushed on, lateral slip is resisted


# ---- Kalker

COEFFICIENTS = cache(lambda: creepage_coefficients(POINT.a, POINT.b, STEEL.nu))


@pytest.mark.parametrize("name", NAMES)
def test_small_creepages_give_kalkers_forces(name):
    """Where friction is large, on each strip another; the contact is that of the grid, of Hertz to 0.3 %."""
    problem = paraboloids(40, 36, friction=3.0, room=(1.3, 1.3))
    problem = replace(problem, factor=np.linspace(0.8, 3.0, 36))
    size = 1e-5 if name != "spin" else 1e-5 / np.sqrt(POINT.a * POINT.b)
    wheel = wheel_on(problem)
    contact = wheel.contact(Creepages(**{name: size}), LOADING).contact
    assert contact.sliding_share < 0.02
    G = STEEL.E / 2 / (1 + STEEL.nu)  # combined: of two equal bodies that of one
    creepages = [size * (name == other) for other in NAMES]
    F_x, F_s, M_n = COEFFICIENTS().forces(G, *creepages)
    c = np.sqrt(POINT.a * POINT.b)
    result = np.array([*contact.force[:2], torque(wheel, contact.p) / c])
    exact = np.array([F_x, F_s, M_n / c])
    largest = np.max(np.abs(exact))
    np.testing.assert_allclose(result, exact, atol=0.012 * largest)
    assert largest > 1.0


# ---- forces and work that a rolling problem reads from contacts, by loops

WHEEL_ON_RAIL = wheel_on(groove(6, 8))
SHAPE = WHEEL_ON_RAIL.problem.distance.shape


def tractions(seed):
    return np.random.default_rng(seed).normal(size=(*SHAPE, 3))


def test_weights_give_the_forces_and_the_moment_about_z():
    for seed in range(3):
        p = tractions(seed)
        forces = {name: np.sum(weights * p) for name, weights in WHEEL_ON_RAIL.weights.items()}
        each = list(forces_on_elements(WHEEL_ON_RAIL, p))
        assert forces["longitudinal"] == pytest.approx(sum(f[4] for f in each))
        assert forces["lateral"] == pytest.approx(sum(f[5] for f in each))
        assert forces["spin"] == pytest.approx(torque(WHEEL_ON_RAIL, p))


@pytest.mark.parametrize("creepages", [CREEPAGES, Creepages(0.3, -0.2, 0.05), Creepages()], ids=str)
def test_power_is_that_of_the_torque_about_the_axle_less_that_of_the_forces(creepages):
    """For any tractions."""
    p, drives, gives = tractions(4), 0.0, 0.0
    for x, y, _, height, F_x, F_y, F_z in forces_on_elements(WHEEL_ON_RAIL, p):
        drives += ((WHEEL - height) * F_x + x * F_z) * (1 + creepages.longitudinal) / WHEEL
        gives += F_x + creepages.lateral * F_y + creepages.spin * (x * F_y - y * F_x)
    power = WHEEL_ON_RAIL.power(RollingContact(SimpleNamespace(p=p), creepages))
    assert power == pytest.approx(drives - gives, rel=1e-9)


def test_pressures_climb_where_lateral_velocity_and_spin_move_along_normals():
    p, climbing = tractions(5), 0.0
    p_n = np.zeros_like(p)
    p_n[..., N] = p[..., N]
    for x, _, delta, _, _, F_y, F_z in forces_on_elements(WHEEL_ON_RAIL, p_n):
        F_n = F_y * np.sin(delta) + F_z * np.cos(delta)
        climbing -= F_n * (CREEPAGES.lateral + CREEPAGES.spin * x) * np.sin(delta)
    assert WHEEL_ON_RAIL.climbing(RollingContact(SimpleNamespace(p=p), CREEPAGES)) == pytest.approx(climbing)


# ---- transient rolling: from rest over full stick to steady rolling

FRICTION = 0.3
SMALL = [paraboloids(14, 12), groove(14, 18, materials=MIXED)]
OTHERS = (SMALL[0], 2), (SMALL[1], 1)
BOTH = pytest.mark.parametrize("problem", SMALL, ids=["flat", "groove"])


def rolled(wheel, creepages, steps):
    """The contact at rest and after each step."""
    return [rolling.contact for rolling in wheel.transient(creepages, LOADING, steps)]


# ---- rest


@BOTH
def test_contact_at_rest_has_frictionless_pressures_and_no_sliding(problem):
    """Though pressures move the surfaces over each other, on flanks and by K."""
    rest = wheel_on(problem).at_rest(LOADING)
    np.testing.assert_allclose(rest.p[..., :N], 0.0, atol=1e-5 * rest.p.max())
    assert rest.sliding_share == 0.0
    pressed = solve_normal(problem.normal, load=LOAD)
    np.testing.assert_allclose(rest.p[..., N], pressed.p, atol=1e-5 * rest.p.max())


# ---- full stick


@BOTH
def test_first_step_is_a_shift_by_rigid_slip_and_rotation_of_the_surface(problem):
    """Particles come from the next element ahead, with the displacements by pressures there."""
    wheel, dx = wheel_on(problem, order=1), problem.grid.dx
    rest, first = rolled(wheel, CREEPAGES, 1)
    before = np.concatenate([rest.u[1:, :, :2], rest.u[-1:, :, :2]])
    shift = Shift(dx * wheel.rolling.rigid_slip(CREEPAGES), before=before)
    expected = solve(problem, shift, LOADING, start=rest)
    np.testing.assert_allclose(first.p, expected.p, atol=2e-5 * expected.p.max())
    assert np.max(np.abs(first.p[..., :N])) > 0.01 * first.p.max()


@pytest.mark.parametrize(("direction", "creepages"), [(X, Creepages(1e-4)), (S, Creepages(0.0, -1e-4))])
def test_forces_grow_at_first_with_mindlins_stiffness_and_full_stick(direction, creepages):
    """With so much friction that nothing slips; to the error of these elements."""
    wheel = wheel_on(paraboloids(32, 30, friction=1e3), order=1)
    _, first = rolled(wheel, creepages, 1)
    exact = ShiftedPoint(POINT, STEEL.nu, FRICTION, 1e-9 * POINT.load, direction)
    assert first.sliding_share == 0.0
    grown = first.force[direction] / (1e-4 * wheel.problem.grid.dx)
    assert grown == pytest.approx(exact.stiffness, rel=0.01)


def test_forces_grow_with_the_rolled_distance_up_to_friction():
    forces = [contact.force[0] for contact in rolled(wheel_on(paraboloids()), Creepages(6e-3), 12)]
    assert all(after > before for before, after in pairwise(forces[:6]))
    assert forces[0] == pytest.approx(0.0, abs=1e-5 * LOAD)
    assert max(forces) <= FRICTION * POINT.load * (1 + 1e-5)
    assert forces[-1] == pytest.approx(FRICTION * POINT.load, rel=0.02)


# ---- the end


@pytest.mark.parametrize(
    ("problem", "order"),
    [(SMALL[0], 1), (SMALL[1], 2), *(pytest.param(*case, marks=pytest.mark.slow) for case in OTHERS)],
    ids=["flat-1", "groove-2", "flat-2", "groove-1"],
)
def test_transient_rolling_tends_to_steady_rolling(problem, order):
    """Elements are not square."""
    wheel = wheel_on(problem, order=order)
    steady = wheel.contact(CREEPAGES, LOADING).contact
    across = int(np.ptp(np.nonzero(steady.in_contact)[0])) + 1
    errors = [
        np.max(np.abs(contact.p - steady.p)) / steady.p.max()
        for contact in rolled(wheel, CREEPAGES, 5 * across)
    ]
    assert errors[0] > 0.02
    assert errors[-1] < 1e-4
    assert errors[2 * across] < errors[across // 2] / 10


# ---- energy


def imbalance(n):
    """What friction takes over the work on the rigid motion less the growth of elastic energy, less 1."""
    wheel = wheel_on(paraboloids(n, n - 2))
    creepages, area, dx = Creepages(-3e-3, 1e-3), wheel.problem.grid.area, wheel.problem.grid.dx
    rest, *steps = rolled(wheel, creepages, 3 * n // 4)
    rigid = wheel.rolling.rigid_slip(creepages)
    lost, given = (
        sum(float(np.sum(part(contact))) for contact in steps) * area * dx
        for part in (lambda contact: contact.dissipation, lambda contact: -contact.p[..., :2] * rigid)
    )
    energy = [float(np.sum(contact.p * contact.u)) * area / 2 for contact in (rest, steps[-1])]
    assert energy[1] - energy[0] > 0.3 * given
    return lost / (given - (energy[1] - energy[0])) - 1


def test_the_work_on_the_rigid_motion_is_stored_or_lost_to_friction():
    """Of half-spaces, over a distance in which a third is stored: to the first order of the steps."""
    coarse, fine = (abs(imbalance(n)) for n in (16, 32))
    assert fine < 0.1
    assert coarse / fine > 1.9
