"""Pressures and tangential tractions in turn: Coulomb's law, limits of friction, Cattaneo, invariance."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact import frictional, normal
from femic.contact.exact.friction import ShiftedPoint
from femic.contact.friction.motion import Creepages, Shift, SteadyRolling
from femic.contact.frictional import solve
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall, pressures
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid, N, S, X
from tests.femic.contact.friction_problems import (
    MIXED,
    POINT,
    by_matrix,
    groove,
    law_errors,
    movable,
    on_half_spaces,
    paraboloids,
    wheel_on,
)
from tests.femic.contact.problems import x_of

pytestmark = pytest.mark.usefixtures("for_any_grid")

LOAD = POINT.load
LOADING = Loading(LOAD)
FLAT = paraboloids(offset=(0.2, 0.3))
GROOVE, OF_BOTH = groove(), groove(materials=MIXED)
PROBLEMS = {"half-spaces": FLAT, "two materials": OF_BOTH}
each_problem = pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS)
FIRST_ORDER = pytest.param(1, marks=pytest.mark.slow)  # the second one contains it


def shifted(problem, along_x=0.0, along_s=0.0):
    """A shift by these [mm], and by what the approach adds on inclined places."""
    rigid = np.tile([along_x, along_s], (*problem.distance.shape, 1))
    return Shift(rigid, per_approach=np.sin(problem.inclination))


CREEPAGES = Creepages(-1e-3, 5e-4, 1e-4)


def rolls(problem, order=2, creepages=CREEPAGES):
    rigid = wheel_on(problem).rolling.rigid_slip(creepages)
    return SteadyRolling(rigid, dx=problem.grid.dx, order=order)


def same(there, here, scale=1.0, tolerance=1e-5):
    np.testing.assert_allclose(there.p, scale * here.p, atol=tolerance * scale * here.p.max())


# ---- the law


@each_problem
@pytest.mark.parametrize("friction", [pytest.param(0.1, marks=pytest.mark.slow), 0.6])
@pytest.mark.parametrize("order", [1, 2])
def test_coulombs_law_holds_on_each_element_in_rolling(problem, order, friction):
    problem = replace(problem, friction=friction)
    motion = rolls(problem, order)
    contact = solve(problem, motion, LOADING)
    assert np.all(law_errors(contact, motion.rigid, order=order, dx=motion.dx) < 3e-6)
    assert 0 < np.count_nonzero(contact.in_contact) < contact.in_contact.size / 2
    wrong = replace(contact, p=contact.p * [0.999, 0.999, 1.0])
    assert np.max(law_errors(wrong, motion.rigid, order=order, dx=motion.dx)) > 1e-4


@each_problem
def test_coulombs_law_holds_on_each_element_after_a_shift(problem):
    problem = replace(problem, friction=0.6 if np.any(problem.inclination) else 0.3)
    motion = shifted(problem, 2e-3, -1e-3)
    contact = solve(problem, motion, LOADING)
    rigid = motion.given_at(contact.approach)
    assert np.all(law_errors(contact, rigid) < 3e-6)
    assert 3 < np.count_nonzero(contact.stick) < np.count_nonzero(contact.in_contact) - 3
    assert np.max(law_errors(contact, rigid + 1e-5)) > 1e-4


@each_problem
@pytest.mark.parametrize("order", [1, 2, None])
def test_gaps_are_complementary_and_friction_takes_energy_wherever_elements_slip(problem, order):
    motion = shifted(problem, 3e-3, -1e-3) if order is None else rolls(problem, order)
    contact = solve(problem, motion, LOADING)
    bound, pressed = problem.friction * contact.p[..., N], contact.in_contact
    u = problem.operator(contact.p)
    np.testing.assert_allclose(contact.u, u, atol=1e-12)
    gap = u[..., N] + problem.distance - contact.approach * np.cos(problem.inclination)
    assert np.all(gap[~pressed] > 0)
    assert np.all(contact.p >= [-np.inf, -np.inf, 0])
    tolerance = 3e-6 * contact.approach
    assert np.max(np.abs(gap[pressed])) < tolerance
    np.testing.assert_allclose(contact.gap, np.where(pressed, 0.0, gap), atol=tolerance)
    assert contact.force[2] == pytest.approx(LOAD, rel=1e-6)
    assert contact.area == np.count_nonzero(bound) * problem.grid.area

    slips = pressed & ~contact.stick & (motion.depth == 0 or frictional.LeadingEdge.find(bound).free)
    assert np.count_nonzero(slips) > 3
    assert np.min(contact.dissipation[slips]) > 0
    assert np.all(contact.dissipation[~pressed] == 0)
    assert np.min(contact.dissipation) > -1e-6 * np.max(contact.dissipation)
    share = np.count_nonzero(pressed & ~contact.stick) / np.count_nonzero(pressed)
    assert contact.sliding_share == pytest.approx(share)


def test_the_work_of_friction_tends_to_that_of_the_rigid_slip():
    """ICs of half-spaces are even along x: rolling stores nothing. To the second order it tends faster."""
    lost = {}
    for order, n in ((1, 20), (2, 20), (1, 40), (2, 40)):
        problem = paraboloids(n, n, offset=(0.2, 0.3))
        motion = rolls(problem, order)
        contact = solve(problem, motion, LOADING)
        assert 0.1 < contact.sliding_share < 0.9
        lost[order, n] = 1 - np.sum(contact.dissipation) / -np.sum(contact.p[..., :2] * motion.rigid)
    assert 0 < lost[2, 40] < lost[2, 20] / 2 < lost[1, 20] / 2
    assert lost[1, 20] / 2.5 < lost[1, 40]


def test_loose_inner_tolerance_does_not_end_the_turns(monkeypatch):
    """Turns that change nothing because both problems were solved loosely go on to the last tolerance."""
    seen = []

    def watched(*arguments, tolerance, **others):
        seen.append(tolerance)
        return pressures(*arguments, tolerance=tolerance, **others)

    monkeypatch.setattr(frictional, "pressures", watched)
    monkeypatch.setattr(frictional, "AT_ONCE_AFTER", ())
    for tolerance in (1e-4, 1e-6):
        contact = solve(FLAT, rolls(FLAT), LOADING, tolerance=tolerance)
        assert seen[-1] == pytest.approx(tolerance * frictional.SHARPER)
        exact = normal.solve(FLAT.normal, load=LOAD, tolerance=1e-9)
        assert np.max(np.abs(contact.p[..., N] - exact.p)) < tolerance * exact.p.max()


# ---- limits of friction


@each_problem
def test_zero_friction_gives_the_frictionless_contact(problem):
    problem = replace(problem, friction=0.0)
    exact = normal.solve(problem.normal, load=LOAD, tolerance=1e-9)
    at_approach = Loading(approach=exact.approach)
    cases = (rolls(problem), at_approach), (rolls(problem, 1), LOADING), (shifted(problem, 1e-3), LOADING)
    for motion, loading in (*cases, (shifted(problem, 1e-3), at_approach)):
        contact = solve(problem, motion, loading)
        np.testing.assert_allclose(contact.p[..., N], exact.p, atol=2e-6 * exact.p.max())
        assert not np.any(contact.p[..., :N])
        assert contact.approach == pytest.approx(exact.approach, rel=1e-6)
        assert contact.sliding_share == 1.0


@each_problem
@pytest.mark.parametrize("friction", [pytest.param(30.0, marks=pytest.mark.slow), 1e3])
@pytest.mark.parametrize("order", [FIRST_ORDER, 2, None])
def test_large_friction_makes_almost_all_elements_stick(problem, order, friction):
    """But for elements at the edge with hardly a pressure."""
    problem = replace(problem, friction=friction)
    creepages = Creepages() if np.any(problem.inclination) else Creepages(1e-4, 1e-4)
    motion = shifted(problem, 1e-4, 1e-4) if order is None else rolls(problem, order, creepages)
    contact = solve(problem, motion, LOADING)
    assert contact.sliding_share <= (0.03 if friction == 1e3 else 0.15)
    rigid = motion.given_at(contact.approach) if order is None else motion.rigid
    errors = law_errors(contact, rigid, order=order, dx=problem.grid.dx)
    assert np.all(errors < 3e-6)


@pytest.mark.parametrize("order", [1, 2])
def test_without_creepages_equal_planes_have_no_tangential_tractions(order):
    contact = solve(FLAT, rolls(FLAT, order, Creepages()), LOADING)
    assert not np.any(contact.p[..., :N])
    assert np.all(contact.stick == contact.in_contact)
    unlike = paraboloids(materials=MIXED)
    other = solve(unlike, rolls(unlike, order, Creepages()), LOADING)
    assert np.max(np.abs(other.p[..., :N])) > 1e-3 * other.p.max()


# ---- Cattaneo


@pytest.mark.parametrize("direction", [X, S])
def test_shift_agrees_with_cattaneo(direction):
    exact = ShiftedPoint(POINT, 0.28, 0.3, 0.6 * 0.3 * LOAD, direction)
    problem = paraboloids(48, 44, offset=(0.2, 0.3))
    along = -exact.shift * np.eye(2)[direction]
    contact = solve(problem, shifted(problem, *along), LOADING)
    assert contact.force[direction] == pytest.approx(exact.force, rel=0.01)
    assert abs(contact.force[1 - direction]) < 0.003 * exact.force
    grid = problem.grid
    x, s = x_of(grid)[:, None] - 0.2 * grid.dx, grid.strips - 0.3 * grid.ds
    traction = exact.traction(x, s)
    assert np.mean(np.abs(contact.p[..., direction] - traction)) < 0.02 * np.mean(traction)
    area = np.pi * exact.stick_ratio**2 * POINT.a * POINT.b
    assert np.count_nonzero(contact.stick) * grid.area == pytest.approx(area, rel=0.06)


# ---- invariance


@pytest.mark.parametrize("order", [FIRST_ORDER, 2, None])
def test_si_units_give_the_same_contact(order):
    grid, flat = OF_BOTH.grid, OF_BOTH.flat
    scaled = [
        replace(linear, kernels={at: 1e-9 * kernel for at, kernel in linear.kernels.items()})
        for linear in (OF_BOTH.operator, flat)
    ]
    in_metres = Grid(grid.n_x, grid.n_s, 1e-3 * grid.dx, 1e-3 * grid.ds, 1e-3 * grid.s)
    there = FrictionalProblem(in_metres, *scaled, 1e-3 * OF_BOTH.distance, OF_BOTH.inclination, 0.3)
    if order is None:
        motions = shifted(OF_BOTH, 3e-3, 1e-3), shifted(there, 3e-6, 1e-6)
    else:
        motions = rolls(OF_BOTH, order), replace(rolls(OF_BOTH, order), dx=in_metres.dx)
    here, result = (
        solve(problem, motion, LOADING) for problem, motion in zip((OF_BOTH, there), motions, strict=False)
    )
    same(result, here, 1e6)
    assert result.force == pytest.approx(here.force, rel=1e-5)
    assert result.approach == pytest.approx(1e-3 * here.approach, rel=1e-6)


@pytest.mark.parametrize("decades", [-5, 5])
@pytest.mark.parametrize("order", [FIRST_ORDER, 2])
def test_ten_decades_of_load_are_similar(order, decades):
    """Sizes and creepages in proportion to load^(1/3): pressures are, too."""
    size = 10.0 ** (decades / 3)
    grid = FLAT.grid
    larger = Grid(grid.n_x, grid.n_s, size * grid.dx, size * grid.ds)
    problem = on_half_spaces(larger, size**2 * FLAT.distance)
    motion = rolls(FLAT, order)
    here = solve(FLAT, motion, LOADING)
    there = solve(problem, replace(motion, rigid=size * motion.rigid, dx=larger.dx), Loading(size**3 * LOAD))
    same(there, here, size)
    assert there.approach == pytest.approx(size**2 * here.approach, rel=1e-5)
    assert np.sum(there.p, axis=(0, 1)) == pytest.approx(
        size * np.sum(here.p, axis=(0, 1)), rel=1e-4, abs=1e-6 * size * np.sum(here.p)
    )


@pytest.mark.parametrize(
    ("motion", "moved"),
    [
        pytest.param(rolls(OF_BOTH, 1), ({"x": 1e-6}, {"z": 1e-6}), marks=pytest.mark.slow, id="order 1"),
        pytest.param(rolls(OF_BOTH), ({"x": 1e-6}, {"z": 1e-6}), id="order 2"),
        pytest.param(shifted(OF_BOTH), ({"z": 1e-6},), id="shift"),
    ],
)
def test_rigid_motions_of_the_bodies_change_the_approach_only(motion, moved):
    """Along z they move inclined places along s, too, as much on each element of a strip.

    In a shift the greater approach moves surfaces along s as much as the bodies give way.
    """
    here = solve(OF_BOTH, motion, LOADING)
    for by in moved:
        there = solve(movable(OF_BOTH, **by), motion, LOADING)
        same(there, here)
        further = by.get("z", 0.0) * LOAD
        assert there.approach - here.approach == pytest.approx(further, abs=1e-5 * here.approach)
    assert np.max(np.abs(here.p[..., S])) > 0.05 * here.p.max()


@pytest.mark.parametrize("order", [FIRST_ORDER, 2])
def test_ics_as_a_matrix_give_the_same_contact(order):
    problem = groove(14, 18)
    motion = rolls(problem, order)
    here, there = (solve(of, motion, Loading(2000.0)) for of in (problem, by_matrix(problem)))
    same(there, here)
    assert there.approach == pytest.approx(here.approach, rel=1e-5)
    assert np.max(here.p[..., X]) > 0.05 * here.p.max()  # it is no contact without friction


@each_problem
def test_load_and_its_approach_give_the_same_contact_from_any_start(problem):
    motion = rolls(problem)
    here = solve(problem, motion, LOADING)
    there = solve(problem, motion, Loading(approach=here.approach))
    same(there, here, tolerance=3e-5)
    other = solve(problem, motion, Loading(0.5 * LOAD))
    same(solve(problem, motion, LOADING, start=other), here)


def test_coarser_grids_come_first_and_give_a_similar_contact():
    """Their friction is the mean of two strips."""
    factor = np.linspace(0.2, 1.0, 32)
    problem = replace(paraboloids(64, 32), factor=factor)
    np.testing.assert_allclose(problem.coarsened.factor, (factor[::2] + factor[1::2]) / 2)
    contact = solve(problem, rolls(problem), LOADING)
    assert contact.coarser.p.shape == (32, 16, 3)
    assert contact.coarser.coarser is None
    assert contact.coarser.force == pytest.approx(contact.force, rel=0.05)
    start = solve(problem, rolls(problem), LOADING, start=contact)
    assert start.coarser is None
    same(start, contact)


# ---- small, twofold and no contacts


@pytest.mark.parametrize("order", [1, 2, None])
@pytest.mark.parametrize("elements", [1, 2, 3, 4, 5])
def test_few_elements_obey_the_law(elements, order):
    """In a row along x, or, the fourth and fifth, beside it."""
    grid, distance = Grid(9, 9, 0.5, 0.6), np.full((9, 9), np.inf)
    places = [(4, 4), (5, 4), (3, 4), (4, 5), (4, 3)][:elements]
    distance[tuple(zip(*places, strict=True))] = 1e-4 * np.arange(elements)
    problem = on_half_spaces(grid, distance, materials=MIXED)
    motion = shifted(problem, 1e-4, 2e-4) if order is None else rolls(problem, order)
    contact = solve(problem, motion, Loading(300.0))
    assert np.count_nonzero(contact.in_contact) == elements
    assert np.all(law_errors(contact, motion.rigid, order=order, dx=grid.dx) < 3e-6)
    assert contact.force[2] == pytest.approx(300.0)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("axis", [0, 1], ids=["one behind the other", "side by side"])
def test_distant_patches_are_independent_contacts(axis, order):
    """Each is that of a lone one under half of the load, but for the other's load far away."""
    size, solved = 0.16, []
    for apart, load in ((100, LOAD), (0, LOAD / 2)):
        grid = Grid(*((20 + apart, 20) if axis == 0 else (20, 20 + apart)), size, size)
        lateral = np.broadcast_arrays(x_of(grid)[:, None], grid.strips)
        along = np.abs(lateral[axis]) - apart * size / 2
        problem = on_half_spaces(grid, (along**2 + lateral[1 - axis] ** 2) / 60)
        solved.append(solve(problem, rolls(problem, order, Creepages(1e-3, -5e-4)), Loading(load)))
    two, one = solved
    assert len(two.patches) == 2
    assert np.count_nonzero(two.in_contact) == 2 * np.count_nonzero(one.in_contact)
    assert two.force == pytest.approx(2 * one.force, rel=0.02)
    largest = [np.sort(contact.p[..., X].ravel())[::-1] for contact in (two, one)]
    np.testing.assert_allclose(largest[0][:8:2], largest[1][:4], rtol=0.02)


@pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS)
def test_too_small_an_approach_gives_no_contact(problem):
    for motion in (rolls(problem), shifted(problem, 1e-3)):
        contact = solve(problem, motion, Loading(approach=-0.01))
        assert not np.any(contact.p)
        assert not np.any(contact.stick)
        assert not np.any(contact.slip)
        assert (contact.area, contact.sliding_share, contact.patches) == (0.0, 0.0, [])
        gap = problem.distance + 0.01 * np.cos(problem.inclination)
        np.testing.assert_allclose(contact.gap, gap, rtol=1e-12)


def test_contact_near_an_end_is_refused_with_the_end_named():
    problem = paraboloids(offset=(6.0, 0.0))
    with pytest.raises(PotentialAreaTooSmall, match="x > 0"):
        solve(problem, rolls(problem), LOADING)


def test_load_borne_by_friction_alone_is_refused(monkeypatch):
    """Where more is to be left to pressures than they carry."""
    monkeypatch.setattr(frictional, "LEAST_PRESSED", 1.2)
    monkeypatch.setattr(frictional, "MOST_TURNS", 20)
    with pytest.raises(Failure, match="carry almost the whole load and leave little pressure"):
        solve(GROOVE, rolls(GROOVE, 1), LOADING)


def test_rolling_on_a_slope_with_large_friction_obeys_the_law():
    """Tangential tractions carry most of the load, or press the bodies on each other."""
    problem = replace(GROOVE, friction=1e3)
    motion = rolls(problem, 1, Creepages(-1e-3, 2e-3, 1e-3))
    contact = solve(problem, motion, Loading(100.0))
    assert contact.force[2] == pytest.approx(100.0, rel=1e-4)
    by_pressures = np.sum(contact.p[..., N] * np.cos(problem.inclination)) * problem.grid.area
    assert abs(by_pressures / 100.0 - 1) > 0.1
    assert np.all(law_errors(contact, motion.rigid, order=1, dx=problem.grid.dx) < 1e-4)


def test_turns_without_end_are_refused(monkeypatch):
    monkeypatch.setattr(frictional, "MOST_TURNS", 2)
    monkeypatch.setattr(frictional, "AT_ONCE_AFTER", ())
    with pytest.raises(Failure, match=r"after 2 iterations, not 1.0e-06; use smaller steps"):
        solve(GROOVE, rolls(GROOVE), LOADING)


@pytest.mark.parametrize("friction", [-0.1, np.nan, np.inf])
def test_friction_must_be_zero_or_more(friction):
    with pytest.raises(WrongInput, match=f"friction = {friction}: must be zero or positive, and finite"):
        replace(FLAT, friction=friction)


def test_load_and_approach_exclude_each_other():
    for given in ({}, {"load": 1.0, "approach": 1.0}):
        with pytest.raises(WrongInput, match="give one of them"):
            Loading(**given)
    for load in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(WrongInput, match=r"load = .*: must be positive and finite \[N\]"):
            Loading(load)
    for approach in (np.nan, np.inf):
        with pytest.raises(WrongInput, match=r"approach = .*: must be finite \[mm\]"):
            Loading(approach=approach)
