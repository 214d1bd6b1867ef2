"""Compression with friction: history, limits of friction, full stick of dissimilar bodies, rigid motions."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact import normal
from femic.contact.exact.friction import StickingPoint
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import Shift
from femic.contact.frictional import solve
from femic.contact.loading import Loading
from femic.contact.rolling import compressed
from geometries.errors import WrongInput
from geometries.materials import Material, both_bodies
from geometries.patches import Grid, N, S
from tests.femic.contact.friction_problems import (
    MIXED,
    groove,
    law_errors,
    movable,
    on_half_spaces,
    paraboloids,
)
from tests.femic.contact.problems import x_of

pytestmark = pytest.mark.usefixtures("either_solver")

OF_BOTH = groove(materials=MIXED)
STEPS = [Loading(load) for load in (500.0, 1500.0, 4000.0)]


def last(problem, steps):
    return list(compressed(problem, steps))[-1]


def test_each_step_obeys_coulombs_law_from_the_previous_displacements():
    before, approach = 0.0, 0.0
    sines = np.sin(OF_BOTH.inclination)[:, None] * [0.0, 1.0]
    problem = replace(OF_BOTH, friction=0.8)
    for contact, step in zip(compressed(problem, STEPS), STEPS, strict=True):
        shift = (contact.approach - approach) * np.broadcast_to(sines, (*OF_BOTH.distance.shape, 2))
        assert np.all(law_errors(contact, shift, before=before) < 3e-6)
        assert contact.force[2] == pytest.approx(step.load, rel=1e-6)
        np.testing.assert_array_equal(contact.motion.rigid, np.zeros_like(shift), strict=True)
        assert np.min(contact.dissipation) > -1e-6 * np.max(contact.dissipation)
        assert 0 < np.count_nonzero(contact.stick) < np.count_nonzero(contact.in_contact)
        before, approach = contact.u[..., :2], contact.approach
    assert np.max(law_errors(contact, shift)) > 1e-3  # not without the history


def test_inclined_places_of_equal_bodies_are_pushed_along_s():
    """The wheel comes down on a slope that falls to larger s: it slips to larger s, against the traction."""
    assert not np.any(last(paraboloids(friction=0.5), STEPS).p[..., :N])  # on level places they are not
    contact = last(groove(), STEPS)
    assert np.all(contact.p[contact.in_contact][:, S] < 0)
    mirrored = last(groove(mirrored=True), STEPS)
    np.testing.assert_allclose(mirrored.p[:, ::-1] * [1, -1, 1], contact.p, atol=1e-5 * contact.p.max())
    np.testing.assert_allclose(contact.p[::-1] * [-1, 1, 1], contact.p, atol=1e-5 * contact.p.max())


def test_loads_and_their_approaches_give_the_same_history():
    by_load = list(compressed(OF_BOTH, STEPS))
    steps = [Loading(approach=contact.approach) for contact in by_load]
    for contact, other in zip(by_load, compressed(OF_BOTH, steps), strict=True):
        np.testing.assert_allclose(other.p, contact.p, atol=5e-5 * contact.p.max())


def test_a_rigid_motion_along_z_adds_to_the_approach_only():
    moved = compressed(movable(OF_BOTH, z=1e-6), STEPS)
    for here, there in zip(compressed(OF_BOTH, STEPS), moved, strict=True):
        np.testing.assert_allclose(there.p, here.p, atol=2e-5 * here.p.max())
        assert there.approach - here.approach == pytest.approx(1e-6 * here.force[2], rel=1e-3)


def test_repeated_step_changes_nothing_and_a_step_back_leaves_tractions():
    there, again, back = compressed(OF_BOTH, [Loading(4000.0), Loading(4000.0), Loading(1500.0)])
    np.testing.assert_allclose(again.p, there.p, atol=1e-5 * there.p.max())
    assert np.max(np.abs(again.slip)) < 1e-5 * np.max(np.abs(there.slip))
    only = last(OF_BOTH, [Loading(1500.0)])
    assert np.max(np.abs(back.p - only.p)) > 0.05 * only.p.max()


def test_step_without_contact_does_nothing():
    none, contact = compressed(OF_BOTH, [Loading(approach=-0.001), Loading(1500.0)])
    assert not np.any(none.p)
    first = last(OF_BOTH, [Loading(1500.0)])
    assert contact.approach == pytest.approx(first.approach, rel=0.02)


def test_steps_of_the_load_converge():
    """To first order in the steps: halving them halves the change, at least nearly."""
    forces, problem = [], groove(14, 18, materials=MIXED)
    for n in (2, 4, 8):
        contact = last(problem, [Loading(4000.0 * (k + 1) / n) for k in range(n)])
        forces.append([contact.force[1], np.sum(np.abs(contact.p[..., S]))])
    changes = np.linalg.norm(np.diff(forces, axis=0), axis=1)
    assert 0 < changes[1] < 0.75 * changes[0]


# ---- full stick of dissimilar bodies

SOFT, STIFF = Material(100e3, 0.0), Material(100e7, 0.0)
CONSTANTS = both_bodies(SOFT, STIFF)
BETA = abs(CONSTANTS.mismatch_k) / (1 - CONSTANTS.nu)


def on_a_sphere(n, largest, friction):
    """Soft half-space and stiff sphere, on a grid that the contact of an approach `largest` fills."""
    a = np.sqrt(largest * 50.0)
    grid = Grid(n, n, 2.6 * a / n, 2.6 * a / n)
    distance = (x_of(grid)[:, None] ** 2 + grid.strips**2) / 2 / 50
    return on_half_spaces(grid, distance, friction=friction, materials=(STIFF, SOFT))


def test_dissimilar_bodies_that_stick_are_stiffer():
    """By 4 % here at the same approach, from one step to more and more of them, as the closed form has it."""
    exact = StickingPoint(1 / 50, combined_modulus(SOFT, STIFF), BETA)
    hertz = PointContact(1 / 50, 1 / 50, combined_modulus(SOFT, STIFF))
    assert BETA > 0.49
    largest = 0.01
    load = hertz.at_approach(largest).load
    load *= (largest / exact.approach(load)) ** 1.5
    assert load > 1.03 * hertz.at_approach(largest).load
    problem = on_a_sphere(24, largest, 1e3)
    errors = []
    for steps in (8, 16):
        approaches = [Loading(approach=largest * ((k + 1) / steps) ** 2) for k in range(steps)]
        contact = last(problem, approaches)
        errors.append(contact.force[2] / load - 1)
    frictionless = normal.solve(problem.normal, approach=largest).load / load - 1
    assert errors[1] == pytest.approx(errors[0] / 2, abs=0.003)
    assert abs(2 * errors[1] - errors[0]) < min(0.005, abs(frictionless) / 5)


def test_one_step_is_a_shift_by_the_approach_and_no_step_is_refused():
    with pytest.raises(WrongInput, match="steps of the load: give one at least"):
        next(compressed(OF_BOTH, []))
    contact = last(OF_BOTH, [Loading(1500.0)])
    rigid = np.zeros((*OF_BOTH.distance.shape, 2))
    rigid[..., S] = contact.approach * np.sin(OF_BOTH.inclination)
    other = solve(OF_BOTH, Shift(rigid), Loading(1500.0))
    np.testing.assert_allclose(other.p, contact.p, atol=2e-5 * contact.p.max())
