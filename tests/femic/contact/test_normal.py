"""Frictionless contact against Hertz, by rates and estimates; load, energy and approach; units, symmetry."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.normal import NormalProblem, PotentialAreaTooSmall, pressures, solve
from femic.contact.patch import MARGIN
from geometries.errors import WrongInput
from geometries.patches import Grid
from tests.femic.contact.problems import (
    CIRCLE,
    ELLIPSE,
    ROOM,
    conformal,
    differences,
    half_spaces,
    hertzian,
    numbers,
    of_hertz,
    with_distance,
    x_of,
)

SOLVED = hertzian(ELLIPSE, 36, 26, offset=(0.2, 0.3))
GROOVE = conformal(Grid(20, 32, 1.2, 0.5, -1.5), shift=0.05)
each_hertz = pytest.mark.parametrize("hertz", [CIRCLE, ELLIPSE], ids=["circle", "ellipse"])


def over_offsets(hertz, n):
    """Root mean squares of the relative errors over 8 places of the grid."""
    offsets = np.random.default_rng(0).random((8, 2)) - 0.5
    solved = [solve(hertzian(hertz, n, n * 3 // 4, offset=offset), load=hertz.load) for offset in offsets]
    each = [numbers(contact) / of_hertz(hertz) - 1 for contact in solved]
    return np.sqrt(np.mean(np.square(each), axis=0))


@each_hertz
def test_approach_energy_and_largest_pressure_converge_to_hertz_with_order_two(hertz):
    errors = [over_offsets(hertz, n) for n in (24, 48, 96)]
    assert np.all(errors[-1][:3] < [2e-4, 1e-4, 5e-4])
    assert np.all(np.log2(errors[0] / errors[-1])[:3] / 2 > 1.6)
    assert np.log2(errors[0] / errors[-1])[3] / 2 > 0.9  # stiffness: that of whole elements in contact
    assert errors[-1][3] < 2e-3


@each_hertz
@pytest.mark.parametrize("n", [24, 48, 96])
def test_half_lengths_are_right_to_an_eighth_of_an_element(hertz, n):
    """Of the contact itself each is a whole number of elements; edges are read from the gaps."""
    elements = np.array([n / ROOM[0], n * 3 // 4 / ROOM[1]]) / 2  # in a half-length
    assert np.all(over_offsets(hertz, n)[4:] * elements < 0.125)


@each_hertz
def test_the_difference_to_the_coarser_contact_covers_the_error(hertz):
    """Of 30 grids that lie differently: 9 in 10 of the errors are below it, all below twice it."""
    random, ratios = np.random.default_rng(0), []
    for n in [36, 48] * 15:
        room, offset = (1.9, 2.1) + 0.1 * random.random(2), random.random(2) - 0.5
        contact = solve(hertzian(hertz, n, n - 12, room=room, offset=offset), load=hertz.load)
        ratios.append(np.abs(numbers(contact) / of_hertz(hertz) - 1) / differences(contact))
    assert np.all(np.quantile(ratios, 0.9, axis=0) < 1)
    assert np.max(ratios) < 2


def test_position_of_the_grid_changes_results_by_less_than_the_estimate():
    contacts = [
        solve(hertzian(ELLIPSE, 48, 36, offset=offset), load=2000.0)
        for offset in [(0.0, 0.0), (0.5, 0.0), (0.25, -0.35), (2.4, 1.7)]
    ]
    results = np.array([numbers(contact) for contact in contacts])
    spread = np.ptp(results, axis=0) / np.mean(results, axis=0)
    assert np.all(spread < 2 * np.max([differences(contact) for contact in contacts], axis=0))
    centres = [np.mean(contact.patches[0].x) - 23.5 for contact in contacts]
    assert centres == pytest.approx([0.0, 0.5, 0.25, 2.4], abs=0.1)


@pytest.mark.parametrize("problem", [SOLVED, GROOVE], ids=["Hertz", "groove"])
def test_load_is_the_derivative_of_energy_and_stiffness_that_of_load(problem):
    """By the vertical approach; exactly, because pressures do no work on their own change."""
    middle = solve(problem, load=2000.0, tolerance=1e-10)
    step = 1e-5 * middle.approach
    low, high = (
        solve(problem, approach=middle.approach + sign * step, start=middle.p, tolerance=1e-11)
        for sign in (-1, 1)
    )
    assert (high.energy - low.energy) / (2 * step) == pytest.approx(middle.load, rel=1e-6)
    assert (high.load - low.load) / (2 * step) == pytest.approx(middle.stiffness, rel=1e-4)
    assert middle.load == pytest.approx(2000.0, rel=1e-12)


@pytest.mark.parametrize("problem", [SOLVED, GROOVE], ids=["Hertz", "groove"])
def test_load_and_its_approach_give_the_same_contact_from_any_start(problem):
    here = solve(problem, load=2000.0, tolerance=1e-10)
    there = solve(problem, approach=here.approach, tolerance=1e-10)
    start = np.random.default_rng(0).random(here.p.shape)
    again = solve(problem, load=2000.0, start=start, tolerance=1e-10)
    for other in (there, again):
        np.testing.assert_allclose(other.p, here.p, atol=1e-8 * here.p.max())
    assert here.coarser.p.shape == tuple(n // 2 for n in here.p.shape)
    warm = solve(problem, load=2000.0, start=here.p, tolerance=1e-9)
    assert warm.solution.iterations < here.solution.iterations


@pytest.mark.parametrize(("problem", "accuracy"), [(SOLVED, 1e-6), (GROOVE, 2e-3)], ids=["Hertz", "groove"])
def test_the_coarser_contact_closes_the_mean_gaps_of_four_elements(problem, accuracy):
    """Of the same load; where directions turn, to second order in the width of strips."""
    coarser = solve(problem, load=2000.0).coarser
    assert coarser.load == pytest.approx(2000.0, rel=1e-3)
    assert coarser.problem.grid.strips == pytest.approx(problem.grid.strips.reshape(-1, 2).mean(axis=1))
    fine = coarser.p.repeat(2, axis=0).repeat(2, axis=1)
    assert np.sum(fine * problem.cosine) * problem.grid.area == pytest.approx(2000.0, rel=1e-3)
    gap = problem.operator(fine[..., None])[..., 0] + problem.distance - coarser.approach * problem.cosine
    mean = gap.reshape(problem.grid.n_x // 2, 2, -1, 2).mean(axis=(1, 3))
    assert np.max(np.abs(mean[coarser.in_contact])) < accuracy * coarser.approach
    assert np.min(mean) > -accuracy * coarser.approach


def iterations(contact):
    """On all its grids."""
    return 0 if contact is None else contact.solution.iterations + iterations(contact.coarser)


def test_contacts_on_coarse_grids_and_starts_save_iterations():
    contact = solve(GROOVE, load=2000.0)
    direct = pressures(GROOVE.bounded, load=2000.0 / GROOVE.grid.area)
    assert contact.solution.iterations < direct.iterations
    again = solve(GROOVE, load=2000.0, start=contact.p)
    assert iterations(again.coarser) < iterations(contact.coarser)


def test_gaps_and_pressures_are_complementary():
    contact = solve(GROOVE, load=2000.0)
    u = GROOVE.operator(contact.p[..., None])[..., 0]
    gap = u + GROOVE.distance - contact.approach * GROOVE.cosine
    assert 0 < np.count_nonzero(contact.in_contact) < gap.size / 2
    assert np.max(np.abs(gap[contact.in_contact])) < 1e-6 * contact.approach
    assert np.all(gap[~contact.in_contact] > 0)
    np.testing.assert_allclose(contact.gap, np.where(contact.in_contact, 0.0, gap), atol=1e-14)
    assert contact.area == pytest.approx(np.count_nonzero(contact.p) * 1.2 * 0.5)
    assert contact.load == pytest.approx(np.sum(contact.p * GROOVE.cosine) * 1.2 * 0.5)


def test_vertical_load_includes_inclined_pressures():
    """All pressures at an inclination of 30 degrees, where the surfaces part by approach cos."""
    inclined = replace(SOLVED, cosine=np.full(SOLVED.grid.n_s, np.cos(np.pi / 6)))
    level, tilted = solve(SOLVED, load=2000.0), solve(inclined, load=2000.0 * np.cos(np.pi / 6))
    np.testing.assert_allclose(tilted.p, level.p, atol=1e-6 * level.p.max())
    assert tilted.approach * np.cos(np.pi / 6) == pytest.approx(level.approach, rel=1e-7)
    assert tilted.stiffness == pytest.approx(level.stiffness * np.cos(np.pi / 6) ** 2, rel=1e-6)


def test_contact_is_symmetric_along_x():
    contact = solve(GROOVE, load=2000.0, tolerance=1e-10)
    np.testing.assert_allclose(contact.p, contact.p[::-1], atol=1e-8 * contact.p.max())
    assert np.max(np.abs(contact.p - contact.p[:, ::-1])) > 0.1 * contact.p.max()  # but not along s


def test_si_units_give_the_same_contact():
    grid, operator = SOLVED.grid, SOLVED.operator
    scaled = Grid(grid.n_x, grid.n_s, 1e-3 * grid.dx, 1e-3 * grid.ds)
    operator = replace(operator, kernels={at: 1e-9 * kernel for at, kernel in operator.kernels.items()})
    problem = NormalProblem(scaled, operator, operator, 1e-3 * SOLVED.distance, SOLVED.cosine)
    here, there = solve(SOLVED, load=2000.0), solve(problem, load=2000.0)
    np.testing.assert_allclose(there.p, 1e6 * here.p, rtol=1e-6, atol=1e-3 * here.p.max())
    assert there.approach == pytest.approx(1e-3 * here.approach, rel=1e-9)
    assert there.stiffness == pytest.approx(1e3 * here.stiffness, rel=1e-6)
    assert there.energy == pytest.approx(1e-3 * here.energy, rel=1e-9)
    assert there.patches[0].x == pytest.approx(here.patches[0].x, abs=1e-6)


def test_distant_bumps_are_two_hertzian_contacts():
    """Each feels the other's load as that of a point: approach = Hertz + load / (pi E* distance)."""
    grid = Grid(24, 240, 2 * CIRCLE.a / 12, 2 * CIRCLE.a / 12)
    apart = 200 * grid.ds
    s = np.abs(grid.strips) - apart / 2
    h = (x_of(grid)[:, None] ** 2 + s**2) / 20 / 2
    operator = half_spaces(grid)
    contact = solve(NormalProblem(grid, operator, operator, h, np.ones(240)), load=2 * CIRCLE.load)
    left, right = contact.patches
    assert np.mean(left.s) + np.mean(right.s) == pytest.approx(239, abs=1e-6)
    assert (right.s[1] - right.s[0]) * grid.ds / 2 == pytest.approx(CIRCLE.b, rel=0.02)
    influence = CIRCLE.load / (np.pi * CIRCLE.surfaces.modulus * apart)
    assert influence > 0.01 * CIRCLE.approach
    assert contact.approach == pytest.approx(CIRCLE.approach + influence, rel=0.003)


def test_contact_near_an_end_is_refused_with_the_end_named():

    for moved, ends in (
        ((0, 8), ("s > 0",)),
        ((0, -8), ("s < 0",)),
        ((11, 0), ("x > 0",)),
        ((-11, 8), ("x < 0", "s > 0")),
    ):
        problem = hertzian(ELLIPSE, 36, 26, offset=moved)
        for given in ({"load": 2000.0}, {"approach": ELLIPSE.approach}):
            with pytest.raises(
                PotentialAreaTooSmall, match=f"{MARGIN} elements.*{' and '.join(ends)};"
            ) as error:
                solve(problem, **given)
            assert error.value.ends == ends


def test_without_contact_there_is_no_load_and_no_error():
    contact = solve(SOLVED, approach=-0.01)
    assert (contact.load, contact.area, contact.energy, contact.stiffness) == (0.0, 0.0, 0.0, 0.0)
    assert contact.patches == []
    np.testing.assert_allclose(contact.gap, SOLVED.distance + 0.01)


def test_shapes_must_fit_and_distances_be_numbers():
    with pytest.raises(WrongInput, match=r"distance of shape \(26, 36\).*\(36, 26\) and \(26,\) are needed"):
        with_distance(SOLVED, SOLVED.distance.T)
    with pytest.raises(WrongInput, match=r"cosine of shape \(36,\)"):
        replace(SOLVED, cosine=np.ones(36))
    with pytest.raises(WrongInput, match="distance: some are not numbers"):
        with_distance(SOLVED, np.where(SOLVED.distance > 0.01, np.nan, SOLVED.distance))
    with pytest.raises(WrongInput, match="distance: infinite everywhere"):
        with_distance(SOLVED, np.full(SOLVED.distance.shape, np.inf))


def test_elements_that_may_touch_one_by_one_give_no_coarser_contact():
    """Elsewhere the distance is infinite: one of four has it, and so have all elements twice as large."""
    lone = np.zeros(SOLVED.distance.shape, dtype=bool)
    lone[8:28:2, 6:20:2] = True
    contact = solve(with_distance(SOLVED, np.where(lone, SOLVED.distance, np.inf)), load=2000.0)
    assert contact.coarser is None
    assert not np.any(contact.in_contact & ~lone)
    assert contact.load == pytest.approx(2000.0)


def test_numbers_of_elements_that_are_odd_or_small_give_no_coarser_contact():
    for n_x, n_s in ((37, 26), (36, 27)):
        assert solve(hertzian(ELLIPSE, n_x, n_s), load=2000.0).coarser is None
    assert not hertzian(ELLIPSE, 6, 26).has_coarser
    assert hertzian(ELLIPSE, 8, 26).has_coarser
    assert solve(hertzian(ELLIPSE, 16, 16), load=500.0).coarser.coarser.coarser is None
