"""What a rolling problem gives to the solver and reads from contacts: forces, work and steps, by loops."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.friction.motion import NAMES, Creepages, RollingStep, Shift, SteadyRolling
from femic.contact.frictional import TOLERANCE
from femic.contact.loading import Loading
from femic.contact.rolling import RollingContact, RollingProblem
from geometries.patches import N
from tests.femic.contact.friction_problems import WHEEL, groove, wheel_on

LOAD, CREEPAGES = Loading(3000.0), Creepages(-2e-3, 7e-4, 3e-4)
WHEEL_ON_RAIL = wheel_on(groove(6, 8))
SHAPE = WHEEL_ON_RAIL.problem.distance.shape


def tractions(seed):
    return np.random.default_rng(seed).normal(size=(*SHAPE, 3))


def forces_on_elements(p):
    """(x, y, delta, height, F_x, F_y, F_z) of each element."""
    rolling, problem = WHEEL_ON_RAIL.rolling, WHEEL_ON_RAIL.problem
    for i, j in np.ndindex(*SHAPE):
        p_x, p_s, p_n = p[i, j] * problem.grid.dx * problem.grid.ds
        delta, y = problem.inclination[j], rolling.contour.position(rolling.s[j])[0]
        sin, cos = np.sin(delta), np.cos(delta)
        yield rolling.x[i], y, delta, rolling.height[j], p_x, p_s * cos + p_n * sin, p_n * cos - p_s * sin


def test_weights_give_the_forces_and_the_moment_about_z():
    for seed in range(3):
        p = tractions(seed)
        each = list(forces_on_elements(p))
        assert np.sum(WHEEL_ON_RAIL.weights["longitudinal"] * p) == pytest.approx(sum(f[4] for f in each))
        assert np.sum(WHEEL_ON_RAIL.weights["lateral"] * p) == pytest.approx(sum(f[5] for f in each))
        moment = sum(x * F_y - y * F_x for x, y, _, _, F_x, F_y, _ in each)
        assert np.sum(WHEEL_ON_RAIL.weights["spin"] * p) == pytest.approx(moment)


@pytest.mark.parametrize("creepages", [CREEPAGES, Creepages(0.3, -0.2, 0.05), Creepages()], ids=str)
def test_power_is_that_of_the_torque_about_the_axle_less_that_of_the_forces(creepages):
    """For any tractions."""
    p, drives, gives = tractions(4), 0.0, 0.0
    for x, y, _, height, F_x, F_y, F_z in forces_on_elements(p):
        drives += ((WHEEL - height) * F_x + x * F_z) * (1 + creepages.longitudinal) / WHEEL
        gives += F_x + creepages.lateral * F_y + creepages.spin * (x * F_y - y * F_x)
    power = WHEEL_ON_RAIL.power(RollingContact(SimpleNamespace(p=p), creepages))
    assert power == pytest.approx(drives - gives, rel=1e-9)


def test_pressures_climb_where_lateral_velocity_and_spin_move_along_normals():
    p, climbing = tractions(5), 0.0
    p_n = np.zeros_like(p)
    p_n[..., N] = p[..., N]
    for x, _, delta, _, _, F_y, F_z in forces_on_elements(p_n):
        F_n = F_y * np.sin(delta) + F_z * np.cos(delta)
        climbing -= F_n * (CREEPAGES.lateral + CREEPAGES.spin * x) * np.sin(delta)
    assert WHEEL_ON_RAIL.climbing(RollingContact(SimpleNamespace(p=p), CREEPAGES)) == pytest.approx(climbing)


# ---- with a solver that solves nothing


@pytest.fixture
def solved(monkeypatch):
    """What is given to the solver, call by call; contacts have displacements of their own, and amplitudes."""
    calls = []

    def solve(problem, motion, loading, *, start=None, tolerance=TOLERANCE):
        u, k = tractions(len(calls)), len(motion.free)
        contact = SimpleNamespace(u=u, amplitudes=1e-3 * np.arange(1, k + 1), motion=motion)
        calls.append(SimpleNamespace(**locals()))
        return contact

    monkeypatch.setattr("femic.contact.rolling.solve", solve)
    return calls


@pytest.mark.parametrize("order", [1, 2])
def test_steady_rolling_has_the_rigid_slip_and_free_slips_of_its_creepages(solved, order):
    wheel, start = wheel_on(WHEEL_ON_RAIL.problem, order=order), object()
    forces = {"spin": -5.0, "longitudinal": 20.0}
    result = wheel.contact(CREEPAGES, LOAD, forces=forces, start=start, tolerance=1e-4)
    (call,) = solved
    assert (call.problem, call.loading, call.start, call.tolerance) == (wheel.problem, LOAD, start, 1e-4)
    motion = call.motion
    assert isinstance(motion, SteadyRolling)
    assert (motion.dx, motion.order) == (wheel.problem.grid.dx, order)
    np.testing.assert_array_equal(motion.rigid, wheel.rolling.rigid_slip(CREEPAGES))
    for free, (name, force) in zip(motion.free, forces.items(), strict=True):
        assert free.force == force
        np.testing.assert_array_equal(free.slip, wheel.rolling.per_creepage(name))
        np.testing.assert_array_equal(free.weights, wheel.weights[name])
    assert result.contact is call.contact
    expected = Creepages(CREEPAGES.longitudinal + 2e-3, CREEPAGES.lateral, CREEPAGES.spin + 1e-3)
    assert [getattr(result.creepages, name) for name in NAMES] == pytest.approx(
        [getattr(expected, name) for name in NAMES]
    )
    assert result.simplified is False


def test_rolling_is_of_second_order_by_default(solved):
    RollingProblem(WHEEL_ON_RAIL.problem, WHEEL_ON_RAIL.rolling).contact(CREEPAGES, LOAD)
    assert solved[0].motion.order == SteadyRolling(np.zeros((*SHAPE, 2)), dx=1.0).order == 2


def test_rest_is_a_shift_from_displacements_without_friction(solved):
    rest = WHEEL_ON_RAIL.at_rest(LOAD)
    pressed, released = solved
    assert pressed.problem.friction == 0.0
    assert pressed.problem.operator is WHEEL_ON_RAIL.problem.operator
    assert pressed.problem.distance is WHEEL_ON_RAIL.problem.distance
    assert released.problem is WHEEL_ON_RAIL.problem
    for call in solved:
        assert call.loading is LOAD
        assert isinstance(call.motion, Shift)
        np.testing.assert_array_equal(call.motion.rigid, np.zeros((*SHAPE, 2)))
    assert pressed.motion.before is None
    np.testing.assert_array_equal(released.motion.before, pressed.u[..., :2])
    assert released.start is pressed.contact
    assert rest is released.contact


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_each_step_of_transient_rolling_begins_where_the_last_one_ended(solved, steps):
    contacts = [rolling.contact for rolling in WHEEL_ON_RAIL.transient(CREEPAGES, LOAD, steps)]
    _, rest, *others = solved
    assert contacts == [call.contact for call in (rest, *others)]
    assert len(others) == steps
    for before, step in zip([rest, *others][:-1], others, strict=True):
        motion = step.motion
        assert isinstance(motion, RollingStep)
        assert (motion.dx, motion.order) == (WHEEL_ON_RAIL.problem.grid.dx, WHEEL_ON_RAIL.order)
        np.testing.assert_array_equal(motion.rigid, WHEEL_ON_RAIL.rolling.rigid_slip(CREEPAGES))
        np.testing.assert_array_equal(motion.before, before.u[..., :2])
        assert (step.start, step.loading, step.problem) == (before.contact, LOAD, WHEEL_ON_RAIL.problem)


def test_rolling_is_marked_where_fewer_elements_follow_than_specified(solved, monkeypatch):
    """Contacts at rest are not."""
    for followers, simplified in ((2, False), (1, True), (0, True)):
        wheel = WHEEL_ON_RAIL
        contact = SimpleNamespace(
            u=tractions(0), amplitudes=np.zeros(0), motion=SimpleNamespace(depth=followers)
        )
        monkeypatch.setattr("femic.contact.rolling.solve", lambda *_, contact=contact, **__: contact)
        assert wheel.contact(CREEPAGES, LOAD).simplified is simplified
        marks = [rolling.simplified for rolling in wheel.transient(CREEPAGES, LOAD, 2)]
        assert marks == [False, simplified, simplified]
    assert not solved
