"""Pressures with bounds: complementarity, small problems against all sets of elements in contact, units."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.optimize import nnls

from approx.pair import Pair, Solid
from femic.contact import normal as bound_constrained
from femic.contact.normal import NormalProblem, pressures
from femic.contact.operators.approximations import approximate_operator
from geometries.contours import arc
from geometries.errors import Failure
from geometries.patches import Grid, N
from geometries.surfaces import LOWER, UPPER, Surface
from tests.femic.contact.problems import BRASS, STEEL, dense, half_spaces


def problem(n_x, n_s, h, *, variant="Bhat"):
    """Bodies on both sides of an arc; the grid covers 3 mm along x and 4 mm along s, mostly left of it."""
    contour = arc(3.0, 1.3, 0.6)
    grid = Grid(n_x, n_s, 3.0 / n_x, 4.0 / n_s, -0.9)
    bodies = Pair(Solid(BRASS, Surface(UPPER, contour)), Solid(STEEL, Surface(LOWER, contour)))
    cosine = np.cos(contour.inclination(grid.strips))
    return NormalProblem(
        grid, approximate_operator(variant, bodies, grid, (N,)), half_spaces(grid), h, cosine
    ).bounded


def smooth_gap(n_x, n_s):
    """Of a body that is not symmetric."""
    x, s = np.linspace(-1, 1, n_x)[:, None], np.linspace(-1, 1, n_s)
    return 0.02 * (x - 0.2) ** 2 + 0.05 * (s + 0.1) ** 2 + 0.01 * x * s + 0.01 * s**3


def rough_gap(n_x, n_s, seed=0):
    return smooth_gap(n_x, n_s) + 0.01 * np.random.default_rng(seed).random((n_x, n_s))


def assert_complementary(of, solution, tolerance=1e-7):
    """p >= 0 and no gap where p > 0; gaps are measured by the displacement of the largest pressure."""
    unit = np.max(solution.p) * np.max(of.compliance(np.eye(1, of.h.size).reshape(of.h.shape)))
    gap = of.compliance(solution.p) + of.h - solution.approach * of.c
    assert np.min(solution.p) == 0
    assert np.max(np.abs(gap[solution.p > 0])) < 3 * tolerance * unit
    assert np.min(gap) > -3 * tolerance * unit
    finite = np.isfinite(gap)
    np.testing.assert_allclose(solution.gap[finite], gap[finite], atol=1e-12 * unit)


SIZES = [(12, 17), (30, 23), (1, 40), (40, 1)]


@pytest.mark.parametrize("variant", ["A", "B", "Bhat"])
@pytest.mark.parametrize("gap", [smooth_gap, rough_gap])
@pytest.mark.parametrize("sizes", SIZES)
def test_gaps_and_pressures_are_complementary(sizes, gap, variant):
    of = problem(*sizes, gap(*sizes), variant=variant)
    load = 150.0 * of.h.size
    solution = pressures(of, load=load)
    assert np.vdot(of.c, solution.p) == pytest.approx(load, rel=1e-12)
    assert 0 < np.count_nonzero(solution.p) < solution.p.size
    assert solution.error <= bound_constrained.TOLERANCE
    assert_complementary(of, solution)


@pytest.mark.parametrize("seed", range(4))
def test_small_problems_agree_with_enumeration_of_all_contact_sets(seed):
    """Of 2^9 sets the only one with p >= 0 on it and gaps beside it."""
    of = problem(3, 3, rough_gap(3, 3, seed))
    S, h, c, zeta = dense(of.compliance, of.h.shape), of.h.ravel(), of.c.ravel(), 0.03
    result = []
    for elements in product([False, True], repeat=9):
        mask, p = np.array(elements), np.zeros(9)
        p[mask] = np.linalg.solve(S[np.ix_(mask, mask)], (zeta * c - h)[mask])
        if np.all(p[mask] > 0) and np.all((S @ p + h - zeta * c)[~mask] >= 0):
            result.append(p)
    (exact,) = result
    assert 0 < np.count_nonzero(exact) < 9
    solution = pressures(of, approach=zeta, tolerance=1e-12)
    np.testing.assert_allclose(solution.p.ravel(), exact, atol=1e-9 * np.max(exact))


@pytest.mark.parametrize("seed", range(3))
def test_large_problems_agree_with_nonnegative_least_squares(seed):
    """With S = L L^T the energy is |L^T p - L^-1 (zeta c - h)|^2 / 2, but for a constant."""
    of = problem(8, 11, rough_gap(8, 11, seed))
    S, zeta = dense(of.compliance, of.h.shape), 0.05
    lower = np.linalg.cholesky((S + S.T) / 2)
    exact, _ = nnls(lower.T, np.linalg.solve(lower, (zeta * of.c - of.h).ravel()))
    solution = pressures(of, approach=zeta, tolerance=1e-12)
    np.testing.assert_allclose(solution.p.ravel(), exact, atol=1e-9 * np.max(exact))


def test_at_an_approach_that_closes_no_gap_nothing_presses():
    of = problem(12, 17, smooth_gap(12, 17))
    solution = pressures(of, approach=-1e-3)
    assert not solution.p.any()
    assert solution.error == 0.0
    np.testing.assert_array_equal(solution.gap, of.h + 1e-3 * of.c)


@pytest.mark.parametrize("given", [{"load": 3e4}, {"approach": 0.04}])
def test_start_saves_iterations_without_changing_the_solution(given):
    """One without pressures, as of an approach at which nothing touches, is none."""
    of = problem(20, 27, rough_gap(20, 27))
    cold = pressures(of, **given, tolerance=1e-10)
    corner = np.zeros(of.h.shape)
    corner[-1, -1] = 1.0  # not in contact
    for start in (corner, np.random.default_rng(0).random(of.h.shape), 2 * corner - 1.0):
        other = pressures(of, **given, start=start, tolerance=1e-10)
        np.testing.assert_allclose(other.p, cold.p, atol=1e-8 * np.max(cold.p))
    for start in (0 * corner, corner - 1.0):
        np.testing.assert_array_equal(pressures(of, **given, start=start, tolerance=1e-10).p, cold.p)
    again = pressures(of, **given, start=cold.p, tolerance=1e-10)
    assert again.iterations <= 1 < cold.iterations


@pytest.mark.parametrize("given", [{"load": 3e5}, {"approach": 1.0}])
def test_search_directions_are_conjugate_with_all_elements_in_contact(given):
    """Conjugate gradients then end after as many steps as there are unknowns, whatever the preconditioner."""
    of = replace(problem(2, 3, smooth_gap(2, 3)), inverse=lambda u: 1e5 * u)
    solution = pressures(of, **given, tolerance=1e-12)
    assert np.all(solution.p > 0)
    assert 2 < solution.iterations <= 6


def test_solver_stops_at_the_tolerance_with_an_error_of_its_size():
    of = problem(20, 27, rough_gap(20, 27))
    exact = pressures(of, load=3e4, tolerance=1e-13).p
    errors = []
    for tolerance in (1e-2, 1e-4, 1e-6, 1e-8):
        solution = pressures(of, load=3e4, tolerance=tolerance)
        errors.append(np.max(np.abs(solution.p - exact)) / np.max(exact))
        assert solution.error <= tolerance
        assert errors[-1] < 10 * tolerance
    assert np.all(np.diff(errors) < 0)


def test_iterations_and_products_are_counted(monkeypatch):
    of = problem(20, 27, smooth_gap(20, 27))
    calls = []
    counted = replace(of, compliance=lambda p: calls.append(1) or of.compliance(p))
    solution = pressures(counted, load=3e4)
    assert solution.products == len(calls)
    assert solution.iterations <= solution.products
    monkeypatch.setattr(bound_constrained, "MOST_ITERATIONS", solution.iterations - 1)
    with pytest.raises(Failure, match=r"after \d+ iterations their error is estimated at .*, not 1\.0e-07"):
        pressures(of, load=3e4)


def test_pressures_are_zero_where_elements_cannot_touch():
    """h is infinite on some elements, which then leave the problem."""
    h = rough_gap(9, 11)
    free = pressures(problem(9, 11, h), approach=0.05)
    excluded = np.zeros(h.shape, dtype=bool)
    excluded[3:6, 4:7] = excluded[:, -1] = True
    assert np.any(free.p[excluded] > 0)
    of = problem(9, 11, np.where(excluded, np.inf, h))
    S, mask = dense(of.compliance, of.h.shape), ~excluded.ravel()
    lower = np.linalg.cholesky(((S + S.T) / 2)[np.ix_(mask, mask)])
    exact = np.zeros(h.size)
    exact[mask], _ = nnls(lower.T, np.linalg.solve(lower, (0.05 * of.c - h).ravel()[mask]))
    for given in ({"approach": 0.05}, {"load": float(exact @ of.c.ravel())}):
        solution = pressures(of, **given, tolerance=1e-11)
        np.testing.assert_allclose(solution.p.ravel(), exact, atol=1e-9 * np.max(exact))
    assert solution.approach == pytest.approx(0.05, rel=1e-9)


@pytest.mark.parametrize("given", [{"load": 3e4}, {"approach": 0.05}])
def test_ics_that_are_not_positive_are_refused(given):
    """Without the ICs of elements on themselves: pressures of changing sign do negative work."""
    of = problem(9, 11, smooth_gap(9, 11))
    own = np.diagonal(dense(of.compliance, of.h.shape)).reshape(of.h.shape)
    indefinite = replace(of, compliance=lambda p: of.compliance(p) - own * p)
    with pytest.raises(Failure, match=r"not positive for pressures .*\(p S p = -.*check their eigenvalues"):
        pressures(indefinite, **given)


def test_negative_rigid_compliance_without_effect_on_contact_is_accepted():
    """Where the load is given, m c c^T does no work on directions; only the approach changes, by m load."""
    of = problem(12, 9, rough_gap(12, 9))
    m = np.max(np.linalg.eigvalsh(dense(of.compliance, of.h.shape)))  # S - m c c^T is far from positive
    discounted = replace(of, compliance=lambda p: of.compliance(p) - m * of.c * np.vdot(of.c, p))
    here, there = (pressures(each, load=3e4, tolerance=1e-11) for each in (of, discounted))
    np.testing.assert_allclose(there.p, here.p, atol=1e-8 * np.max(here.p))
    assert there.approach == pytest.approx(here.approach - m * 3e4, rel=1e-9)


@pytest.mark.parametrize("given", [{}, {"load": 1.0, "approach": 1.0}])
def test_load_and_approach_exclude_each_other(given):
    with pytest.raises(ValueError, match="either load or approach"):
        pressures(problem(3, 4, smooth_gap(3, 4)), **given)
