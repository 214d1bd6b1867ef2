"""Contacts by compiled loops: products beside the operator's, contacts beside those of the other solvers.

These are independent in all but the method: own products, own linear algebra, own bookkeeping. Coulomb's law
is checked as a reader would (`friction_problems`).
"""

import gc
import pickle
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from weakref import ref

import numpy as np
import pytest

from femic.contact import compiled as at
from femic.contact import frictional, normal, small
from femic.contact.compiled import multiply
from femic.contact.friction import law, motion
from femic.contact.friction.coulomb import ForcesBeyondFriction
from femic.contact.friction.motion import Creepages, RollingStep, Shift, SteadyRolling
from femic.contact.loading import Loading
from femic.contact.operators.dense import GridOperator
from geometries.patches import N
from tests.femic.contact.friction_problems import MIXED, groove, law_errors, paraboloids, wheel_on

LOADING = Loading(4000.0)
SHARP = 1e-9  # tolerance of contacts that are compared
CREEPAGES = Creepages(-8e-4, 5e-4, 1e-4)


@contextmanager
def solvers_for_any_grid():
    """Nothing is left to compiled loops."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(small, "MOST_ELEMENTS", 0)
        yield


def found(problem, motion, loading=LOADING, start=None, tolerance=SHARP):
    """The contact in compiled loops, which must find it."""
    solution = frictional._Solution(problem, motion, loading, tolerance)
    contact = solution.in_compiled_loops(start)
    assert contact is not None
    return contact


def by_others(problem, motion, loading=LOADING):
    """The contact by the solvers for any grid."""
    with solvers_for_any_grid():
        return frictional.solve(problem, motion, loading, tolerance=SHARP)


def assert_equal(here, there):
    """Tractions, slip, stick, approach and amplitudes are equal, but for rounding that iterations amplify."""
    largest = there.pressures.max()
    np.testing.assert_allclose(here.p, there.p, atol=1e-7 * largest)
    np.testing.assert_array_equal(here.stick, there.stick)
    np.testing.assert_allclose(here.slip, there.slip, atol=1e-6 * np.max(np.abs(there.slip)) + 1e-300)
    np.testing.assert_allclose(here.u, there.u, atol=1e-7 * np.max(np.abs(there.u)))
    np.testing.assert_allclose(here.gap, there.gap, atol=1e-7 * np.max(np.abs(there.u)))
    assert here.approach == pytest.approx(there.approach, rel=1e-8)
    assert here.amplitudes == pytest.approx(there.amplitudes, rel=1e-6)


def steady(problem, order=2, creepages=CREEPAGES):
    rolling = wheel_on(problem, order=order).rolling
    return SteadyRolling(rolling.rigid_slip(creepages), dx=problem.grid.dx, order=order)


def rough(problem, size=2e-3):
    """A slip without any symmetry."""
    return size * np.random.default_rng(5).uniform(-1, 1, (*problem.distance.shape, 2)) + [size, 0.0]


# --- products ---


@pytest.fixture(params=[("exact", float, 1e-13), ("rough", np.float32, 2e-6)], ids=["double", "single"])
def products(request):
    """Name of products in `Work`, the type of their numbers, and the error of the largest."""
    return request.param


@pytest.mark.parametrize("n_x", [11, 12])
@pytest.mark.parametrize(("rows", "strips"), [((0, 12), (0, 9)), ((3, 8), (2, 7)), ((5, 6), (8, 9))])
def test_products_are_those_of_the_operator(n_x, rows, strips, products):
    """Also with an odd number of rows, and of some rows and strips only."""
    name, kind, error = products
    problem = groove(n_x, 9, materials=MIXED)
    tractions = np.zeros((n_x, 9, 3))
    place = slice(rows[0], min(rows[1], n_x)), slice(*strips)
    tractions[place] = np.random.default_rng(3).normal(size=tractions[place].shape)
    work = getattr(problem.small.bodies.work(0), name)
    loads, u = np.ascontiguousarray(np.moveaxis(tractions, -1, 0), kind), np.zeros((3, n_x, 9), kind)
    low = min(rows[0], n_x - min(rows[1], n_x))
    multiply(work, loads, u, (0, 3), (0, 3), (0, 3), (low, *strips), (0, 0, 9))
    expected = GridOperator.from_convolution(problem.operator)(tractions)
    np.testing.assert_allclose(np.moveaxis(u, 0, -1), expected, atol=error * np.max(np.abs(expected)))
    u[:] = np.nan
    multiply(work, loads, u, (0, 3), (0, 2), (0, 3), (low, *strips), (low, *strips))
    part = np.moveaxis(u, 0, -1)[low : n_x - low, slice(*strips)]
    here = GridOperator.from_convolution(problem.operator)(tractions * [1, 1, 0])
    np.testing.assert_allclose(part, here[low : n_x - low, slice(*strips)], atol=error * np.max(np.abs(here)))


def test_inverse_by_waves_is_that_of_half_spaces(products):
    name, kind, error = products
    problem = groove(10, 12)
    bodies = problem.small.bodies
    work, everywhere = getattr(bodies.work(0), name), (0, 0, 12)
    values = np.random.default_rng(4).normal(size=(10, 12, 3))
    loads, result = np.ascontiguousarray(np.moveaxis(values, -1, 0), kind), np.zeros((3, 10, 12), kind)
    ring = bodies.work(0).settings[at.RING] - N
    multiply(work, loads[N:], result[N:], (ring, 0), (N, N + 1), (N, N + 1), everywhere, everywhere)
    expected = problem.ring_inverse(values[..., N:])[..., 0]
    np.testing.assert_allclose(result[N], expected, atol=10 * error * np.max(np.abs(expected)))
    for t in range(2):
        one = t, t + 1
        multiply(work, loads[t:], result[t:], at.ALONE, one, one, everywhere, everywhere)
        alone = problem.flat.restricted((0, 1)).strips_alone(values[..., :N] * (np.arange(2) == t))[..., t]
        largest = np.max(np.abs(alone))  # parts that are odd on the ring are left out
        np.testing.assert_allclose(result[t], alone, atol=1e-3 * largest)


def test_constants_are_those_of_the_other_solvers():
    assert (at.MOST_VECTORS, at.SINGULAR) == (law.MOST_VECTORS, law.SINGULAR)
    assert at.LEAST_PER_DEPTH == motion.LEAST_PER_DEPTH


# --- pressures ---


@pytest.mark.parametrize("problem", [paraboloids(), groove(), groove(21, 17, materials=MIXED)], ids=str)
@pytest.mark.parametrize("loading", [Loading(4000.0), Loading(approach=0.02)], ids=str)
def test_pressures_are_those_of_the_other_solver(problem, loading):
    given = {"load": loading.load, "approach": loading.approach}
    with solvers_for_any_grid():
        there = normal.solve(problem.normal, **given, tolerance=1e-11)
    assert problem.normal.small is not None
    for start in (None, there.p[::-1], 0 * there.p):
        here = normal.solve(problem.normal, **given, start=start, tolerance=1e-11)
        assert here.begun_on is None
        np.testing.assert_allclose(here.p, there.p, atol=1e-9 * there.p.max())
        np.testing.assert_allclose(here.gap, there.gap, atol=1e-9 * there.gap.max())
        assert here.approach == pytest.approx(there.approach, rel=1e-9)
    if there.coarser is not None:
        np.testing.assert_allclose(here.coarser.p, there.coarser.p, atol=1e-9 * there.p.max())


def test_contact_where_it_is_not_possible_and_where_nothing_touches():
    problem = paraboloids()
    distance = problem.distance.copy()
    distance[:, 11:] = distance[0] = np.inf
    problem = replace(problem.normal, distance=distance)
    with solvers_for_any_grid():
        there = normal.solve(problem, load=500.0, tolerance=1e-10)
        above = normal.solve(problem, approach=-1.0)
    here = normal.solve(problem, load=500.0, tolerance=1e-10)
    np.testing.assert_allclose(here.p, there.p, atol=1e-8 * there.p.max())
    assert not normal.solve(problem, approach=-1.0).p.any()
    assert not above.p.any()


# --- tractions ---

PROBLEMS = {
    "half-spaces": paraboloids(),
    "two materials": paraboloids(18, 17, materials=MIXED, friction=0.5),
    "groove": groove(),
    "groove of two materials, odd": groove(21, 23, materials=MIXED, friction=0.4),
    "factors": replace(groove(), factor=np.linspace(0.0, 1.0, 24).round(1)),
}


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("kind", ["second order", "first order", "step", "shift", "pressed"])
def test_contacts_are_those_of_the_other_solvers(name, kind):
    problem = PROBLEMS[name]
    none = np.zeros((*problem.distance.shape, 2))
    rigid = wheel_on(problem).rolling.rigid_slip(CREEPAGES)
    given = {
        "second order": lambda: steady(problem),
        "first order": lambda: steady(problem, 1),
        "step": lambda: RollingStep(rigid, dx=problem.grid.dx, before=none + np.array([1e-3, -5e-4])),
        "shift": lambda: Shift(rough(problem), before=rough(problem, 1e-4)),
        "pressed": lambda: Shift(none, per_approach=np.sin(problem.inclination), approach_before=1e-3),
    }[kind]()
    there = by_others(problem, given)
    here = found(problem, given)
    assert_equal(here, there)
    assert_equal(found(problem, given, Loading(approach=there.approach)), there)
    assert_equal(found(problem, given, start=there), there)


@pytest.mark.parametrize("sizes", [(90, 14), (16, 88), (12, 180)])
def test_contacts_on_long_grids_are_those_of_the_other_solvers(sizes):
    problem = groove(*sizes, materials=MIXED, friction=0.4)
    assert problem.small is not None
    assert problem.normal.small is None  # FFT is quicker
    assert_equal(found(problem, steady(problem)), by_others(problem, steady(problem)))


@pytest.mark.parametrize("name", ["two materials", "groove"])
def test_creepages_from_forces_are_those_of_the_other_solvers(name):
    problem = PROBLEMS[name]
    there = wheel_on(problem).contact(CREEPAGES, LOADING, tolerance=SHARP).contact
    forces = {"longitudinal": 0.5 * there.force[0], "lateral": there.force[1]}
    rolling = wheel_on(problem)
    with solvers_for_any_grid():
        expected = rolling.contact(CREEPAGES, LOADING, forces=forces, tolerance=SHARP)
    here = rolling.contact(CREEPAGES, LOADING, forces=forces, tolerance=SHARP)
    assert here.contact.turns == 0
    assert_equal(here.contact, expected.contact)
    assert here.creepages.longitudinal == pytest.approx(expected.creepages.longitudinal, rel=1e-6)
    for start in (there, here.contact):  # also one with another number of forces
        again = rolling.contact(CREEPAGES, LOADING, forces=forces, start=start, tolerance=SHARP)
        assert_equal(again.contact, expected.contact)
    without = rolling.contact(CREEPAGES, LOADING, start=here.contact, tolerance=SHARP)
    assert_equal(without.contact, there)
    with pytest.raises(ForcesBeyondFriction):
        rolling.contact(CREEPAGES, LOADING, forces={"longitudinal": 0.6 * LOADING.load})


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", ["two materials", "groove of two materials, odd"])
def test_law_holds_as_a_reader_would_check_it(name, order):
    problem = PROBLEMS[name]
    given = steady(problem, order)
    contact = found(problem, given, tolerance=1e-7)
    rigid = wheel_on(problem, order=order).rolling.rigid_slip(CREEPAGES)
    assert max(law_errors(contact, rigid, order=order, dx=problem.grid.dx)) < 1e-5
    assert contact.stick.any()
    assert (contact.in_contact & ~contact.stick).any()


@pytest.mark.parametrize("share", [0.0, 1e-4, 30.0])
def test_contacts_without_slip_and_with_full_sliding(share):
    """No rigid slip: no tractions of equal bodies; much: all slides against it."""
    problem = PROBLEMS["half-spaces"]
    given = steady(problem, creepages=Creepages(-share * 1e-3, 0.0, 0.0))
    contact = found(problem, given)
    q = np.linalg.norm(contact.p[..., :N], axis=-1)
    if share == 0:
        assert np.max(q) <= 1e-9 * contact.pressures.max()
    elif share > 1:
        np.testing.assert_allclose(q, 0.3 * contact.pressures, atol=1e-8 * contact.pressures.max())
        assert contact.sliding_share == 1.0
        assert np.all(contact.p[..., 0][q > 0] < 0)  # the wheel is braked
    assert_equal(contact, by_others(problem, given))


def test_large_grids_and_unknown_operators_are_left_to_others():
    with solvers_for_any_grid():
        assert PROBLEMS["groove"].small is None
    problem = replace(PROBLEMS["groove"], operator=lambda p: p)
    assert problem.small is None


def test_bodies_are_made_once_for_an_operator():
    problem = groove()
    assert problem.small.bodies is replace(problem, friction=0.1).small.bodies
    flat = groove().flat
    assert replace(problem, flat=flat).small.bodies.flat() is flat


@pytest.mark.parametrize("name", PROBLEMS)
def test_bodies_go_with_their_operator(name):
    """A, too, whose operator is also that of half-spaces: many pairs in one process fill no memory."""
    problem = replace(PROBLEMS[name], operator=copy(PROBLEMS[name].operator))
    if PROBLEMS[name].operator is PROBLEMS[name].flat:
        problem = replace(problem, flat=problem.operator)
    found(problem, steady(problem), tolerance=1e-3)
    bodies = ref(problem.small.bodies)
    assert bodies() is not None
    del problem
    gc.collect()
    assert bodies() is None


def test_tractions_exceed_small_friction_by_a_small_part_of_it():
    problem = replace(PROBLEMS["half-spaces"], friction=0.01)
    contact = found(problem, steady(problem, creepages=Creepages(-2e-5, 1e-5, 1e-7)), tolerance=1e-6)
    assert 0.05 < contact.sliding_share < 0.95
    bound = 0.01 * contact.pressures
    assert np.max(np.linalg.norm(contact.p[..., :N], axis=-1) - bound) < 1e-7 * np.max(bound)


def test_half_a_file_of_machine_code_is_made_again(tmp_path):
    """Numba itself ends with an error of pickle, each time."""
    index, code = pickle.dumps("version") + pickle.dumps(list(range(99))), pickle.dumps(list(range(99)))
    for name, content in {"a.nbi": index, "b.nbc": code, "c.nbi": index[:-20], "d.nbc": code[:9]}.items():
        (tmp_path / f"compiled.{name}").write_bytes(content)
    (tmp_path / "others.e.nbc").write_bytes(code[:9])
    small.remove_damaged(tmp_path, "compiled")
    assert {path.name for path in tmp_path.iterdir()} == {"compiled.a.nbi", "compiled.b.nbc", "others.e.nbc"}
