"""Transient rolling: from rest over full stick to steady rolling, its mirrors and its energy."""

from itertools import pairwise

import numpy as np
import pytest

from femic.contact.exact.friction import ShiftedPoint
from femic.contact.friction.motion import Creepages, Shift
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.contact.normal import solve as solve_normal
from femic.contact.rolling import RollingProblem
from geometries.patches import N, S, X
from tests.femic.contact.friction_problems import MIXED, POINT, groove, paraboloids, wheel_on
from tests.femic.contact.problems import STEEL

LOAD, FRICTION = Loading(POINT.load), 0.3
CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)
SMALL = [paraboloids(14, 12), groove(14, 18, materials=MIXED)]
OTHERS = (SMALL[0], 2), (SMALL[1], 1)
BOTH = pytest.mark.parametrize("problem", SMALL, ids=["flat", "groove"])


def rolled(wheel, creepages, steps):
    """The contact at rest and after each step."""
    return [rolling.contact for rolling in wheel.transient(creepages, LOAD, steps)]


# ---- rest


@BOTH
def test_contact_at_rest_has_frictionless_pressures_and_no_sliding(problem):
    """Though pressures move the surfaces over each other, on flanks and by K."""
    rest = wheel_on(problem).at_rest(LOAD)
    np.testing.assert_allclose(rest.p[..., :N], 0.0, atol=1e-5 * rest.p.max())
    assert rest.sliding_share == 0.0
    pressed = solve_normal(problem.normal, load=POINT.load)
    np.testing.assert_allclose(rest.p[..., N], pressed.p, atol=1e-5 * rest.p.max())


# ---- full stick


@BOTH
def test_first_step_is_a_shift_by_rigid_slip_and_rotation_of_the_surface(problem):
    """Particles come from the next element ahead, with the displacements by pressures there."""
    wheel, dx = wheel_on(problem, order=1), problem.grid.dx
    rest, first = rolled(wheel, CREEPAGES, 1)
    before = np.concatenate([rest.u[1:, :, :2], rest.u[-1:, :, :2]])
    shift = Shift(dx * wheel.rolling.rigid_slip(CREEPAGES), before=before)
    expected = solve(problem, shift, LOAD, start=rest)
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
    assert forces[0] == pytest.approx(0.0, abs=1e-5 * POINT.load)
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
    steady = wheel.contact(CREEPAGES, LOAD).contact
    across = int(np.ptp(np.nonzero(steady.in_contact)[0])) + 1
    errors = [
        np.max(np.abs(contact.p - steady.p)) / steady.p.max()
        for contact in rolled(wheel, CREEPAGES, 5 * across)
    ]
    assert errors[0] > 0.02
    assert errors[-1] < 1e-4
    assert errors[2 * across] < errors[across // 2] / 10


# ---- mirrors


def test_mirror_in_s_mirrors_the_contact():
    here = rolled(wheel_on(groove(14, 18, materials=MIXED)), CREEPAGES, 3)[-1]
    mirrored = wheel_on(groove(14, 18, materials=MIXED, mirrored=True), mirrored=True)
    there = rolled(mirrored, Creepages(-1e-3, -5e-4, -1e-4), 3)[-1]
    np.testing.assert_allclose(there.p[:, ::-1] * [1, -1, 1], here.p, atol=2e-5 * here.p.max())
    assert np.max(np.abs(there.p[:, ::-1] - here.p)) > 0.05 * here.p.max()


# ---- energy


def imbalance(n: int) -> float:
    """What friction takes over the work on the rigid motion less the growth of elastic energy, less 1."""
    wheel: RollingProblem = wheel_on(paraboloids(n, n - 2))
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
