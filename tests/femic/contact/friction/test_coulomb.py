"""Coulomb's law for given bounds: small problems in full, least energy, Carter, rates, mirrors, forces."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from femic.contact.estimates import SlipState, floors
from femic.contact.exact.friction import TractiveRolling
from femic.contact.exact.hertz import LineContact
from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import attainable_factor
from femic.contact.friction.motion import Shift, SteadyRolling
from femic.contact.operators.convolution import Convolution
from geometries.errors import Failure
from geometries.patches import Grid, S, X
from tests.femic.contact.friction.laws import (
    GRID,
    MOTIONS,
    bounds,
    law,
    no_forces,
    on_half_spaces,
    swirl,
    with_forces,
)
from tests.femic.contact.friction_problems import coulomb_errors
from tests.femic.contact.problems import dense, x_of

# ---- small problems, in full

LINE = Grid(7, 1, 0.4, 3.0)
ON_LINE = np.array([0.0, 90.0, 150.0, 170.0, 130.0, 60.0, 0.0])[:, None]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rolls", [False, True], ids=["shift", "rolling"])
def test_row_solution_is_unique_among_all_states_of_its_elements(rolls, seed):
    """Of 3^5 states (stick, slip forwards or backwards) of tractions along x."""
    operator, random = on_half_spaces(LINE), np.random.default_rng(seed)
    rigid = np.zeros((7, 1, 2))
    rigid[..., 0] = 1e-3 * random.normal(size=(7, 1)) * (1.0 if rolls else 0.4)
    motion = SteadyRolling(rigid, dx=LINE.dx, order=1) if rolls else Shift(rigid)
    problem = law(operator, motion, ON_LINE)
    inner = np.arange(1, 6)
    L = dense(problem.compliance, (7, 1, 2))[np.ix_(2 * inner, 2 * inner)]
    w, g, exact = motion.given[inner, 0, 0], ON_LINE[inner, 0], []
    for states in product((-1, 0, 1), repeat=5):
        p, stick = np.array(states) * g, np.array(states) == 0
        p[stick] = np.linalg.solve(L[np.ix_(stick, stick)], -(w + L @ p)[stick])
        slip = L @ p + w
        if np.all(np.abs(p) <= g) and np.all(slip[~stick] * p[~stick] < 0):
            exact.append((p, stick))
    ((p, stick),) = exact
    result = coulomb.tractions(problem, tolerance=1e-10)
    np.testing.assert_allclose(result.p[inner, 0, 0], p, atol=1e-7 * g.max())
    assert np.max(np.abs(result.p[..., 1])) < 1e-7 * g.max()
    np.testing.assert_array_equal(result.stick[inner, 0], stick)


def of_least_energy(L, w, g, steps=6000):
    """Tractions of least p L p / 2 + p w within discs, by accelerated projected gradients."""
    step = 1 / np.linalg.eigvalsh(L)[-1]
    p = q = np.zeros(w.size)
    t = 1.0
    for _ in range(steps):
        moved = (q - step * (L @ q + w)).reshape(-1, 2)
        size = np.maximum(np.linalg.norm(moved, axis=1), 1e-300)
        new = (moved * np.minimum(1.0, g / size)[:, None]).ravel()
        t, before = (1 + np.sqrt(1 + 4 * t**2)) / 2, t
        if (q - new) @ (new - p) > 0:
            t = 1.0  # start again where the energy would grow
        p, q = new, new + (before - 1) / t * (new - p)
    return p


@pytest.mark.parametrize("seed", range(3))
def test_a_shift_has_the_least_energy(seed):
    """Where L is symmetric; by another method, on the elements with bounds."""
    g = bounds(seed)
    problem = law(on_half_spaces(GRID), Shift(swirl(4e-3)), g)
    rubs = np.repeat((g > 0).ravel(), 2)
    L = dense(problem.compliance, (8, 7, 2))[np.ix_(rubs, rubs)]
    np.testing.assert_allclose(L, L.T, atol=1e-12 * L.max())
    least = of_least_energy(L, problem.rigid.ravel()[rubs], g[g > 0])
    result = coulomb.tractions(problem, tolerance=1e-9)
    assert 2 < np.count_nonzero(result.stick) < np.count_nonzero(g) - 2
    np.testing.assert_allclose(result.p.ravel()[rubs], least, atol=1e-6 * g.max())
    assert np.all(result.p[g == 0] == 0)


each_motion = pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)


@each_motion
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
def test_the_law_holds_on_each_element(motion, tolerance):
    operator = on_half_spaces(GRID)
    problem = law(operator, motion, bounds())
    result = coulomb.tractions(problem, tolerance=tolerance)

    def error(p):
        of_motion = {name: vars(motion)[name] for name in ("order", "dx") if name in vars(motion)}
        return max(coulomb_errors(operator, p, problem.bound, result.stick, motion.rigid, **of_motion))

    assert 2 < np.count_nonzero(result.stick) < np.count_nonzero(problem.bound) - 2
    assert error(result.p) < 20 * tolerance
    assert error(result.p + 1e3 * tolerance * problem.bound[..., None] * [0.7, 0.7]) > 50 * tolerance
    assert result.residuals[-1] <= tolerance < result.residuals[0]


@each_motion
def test_start_saves_steps_without_changing_the_solution(motion):
    problem = law(on_half_spaces(GRID), motion, bounds())
    cold = coulomb.tractions(problem, tolerance=1e-10)
    start = np.random.default_rng(0).normal(size=cold.p.shape) * problem.bound[..., None]
    other = coulomb.tractions(problem, start=start, tolerance=1e-10)
    np.testing.assert_allclose(other.p, cold.p, atol=1e-7 * problem.bound.max())
    again = coulomb.tractions(problem, start=cold.p, tolerance=1e-9)
    assert len(again.residuals) == 1 < len(cold.residuals)


@each_motion
def test_zero_bounds_give_no_tractions_and_large_bounds_full_stick(motion):
    operator = on_half_spaces(GRID)
    none = coulomb.tractions(law(operator, motion, np.zeros((8, 7))))
    assert not np.any(none.p)
    assert not np.any(none.stick)
    np.testing.assert_allclose(none.slip, motion.at_elements(motion.given))
    problem = law(operator, motion, 1e6 * bounds())
    result = coulomb.tractions(problem, tolerance=1e-12)
    np.testing.assert_array_equal(result.stick, problem.bound > 0)
    free = np.repeat(problem.edge.free.ravel(), 2)
    if motion.depth == 0:  # then it is a system of linear equations
        L = dense(problem.compliance, (8, 7, 2))[np.ix_(free, free)]
        exact = np.linalg.solve(L, -problem.rigid.ravel()[free])
        np.testing.assert_allclose(result.p.ravel()[free], exact, atol=1e-5 * np.max(np.abs(exact)))
    slip = (problem.compliance(result.p) + problem.rigid).ravel()[free]
    assert np.max(np.abs(slip)) < 1e-4 * np.max(np.abs(problem.rigid))


def test_mirrored_reversed_rolling_is_mirrored():
    """In x: the problem of rolling towards -x is built here, with the neighbour at smaller x."""
    w, g = swirl(4e-3), bounds()
    operator = on_half_spaces(GRID)
    here = coulomb.tractions(law(operator, MOTIONS["first"], g), tolerance=1e-9)

    class Backwards(Shift):
        def elastic_slip(self, u):
            return (u - np.concatenate([u[:1], u[:-1]])) / GRID.dx

    sign, mirror = np.array([-1.0, 1.0]), slice(None, None, -1)
    there = coulomb.tractions(law(operator, Backwards(sign * w[mirror]), g[mirror]), tolerance=1e-9)
    np.testing.assert_allclose(there.p[mirror] * sign, here.p, atol=1e-6 * g.max())
    np.testing.assert_array_equal(there.stick[mirror], here.stick)
    forwards = coulomb.tractions(law(operator, replace(MOTIONS["first"], rigid=sign * w[mirror]), g[mirror]))
    assert np.max(np.abs(forwards.p[mirror] * sign - here.p)) > 0.1 * g.max()  # not without turning round


# ---- forces


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7, 0.95])
@pytest.mark.parametrize("guess", [(0.0, 0.0), (1.0, 0.0), (-3e-3, 5e-3)])
def test_prescribed_forces_are_met_from_any_guess_of_the_amplitudes(share, guess):
    """From one by which all slips in one direction, too, where amplitudes change nothing."""
    targets = share * bounds().sum() * np.array([0.8, -0.6])
    result = coulomb.tractions(with_forces(targets), amplitudes=np.array(guess), tolerance=1e-8)
    np.testing.assert_allclose(result.p.sum(axis=(0, 1)), targets, atol=1e-6 * bounds().sum())
    problem = with_forces(targets)
    rigid = problem.rigid + np.tensordot(result.amplitudes, problem.free.modes, 1)
    given = coulomb.tractions(replace(problem, free=no_forces(problem.bound), rigid=rigid), tolerance=1e-8)
    np.testing.assert_allclose(given.p, result.p, atol=1e-5 * bounds().max())
    np.testing.assert_allclose(given.slip, result.slip, atol=1e-7)


@pytest.mark.parametrize("share", [1.0001, 1.5, 1e4])
def test_forces_that_friction_does_not_bear_are_refused_at_once(share, monkeypatch):
    monkeypatch.setattr(coulomb, "MOST_STEPS", 0)
    targets = share * bounds().sum() * np.array([0.8, -0.6])
    with pytest.raises(Failure, match=f"exceed what friction can supply.*no more than {1 / share:.4g}"):
        coulomb.tractions(with_forces(targets))
    with pytest.raises(Failure, match="exceed what friction can supply"):
        coulomb.tractions(with_forces([0.0, 0.0], 0 * bounds()))


def test_too_few_steps_fail_with_the_last_residuals(monkeypatch):
    monkeypatch.setattr(coulomb, "MOST_STEPS", 2)
    number = r"\d\.\de[-+]\d\d"
    message = (
        rf"after 6 steps their residual is ({number}) .* not 1.0e-06 \(({number}, ){{3}}\1\); use smaller el"
    )
    with pytest.raises(Failure, match=message):
        coulomb.tractions(law(on_half_spaces(GRID), MOTIONS["second"], bounds()))


# ---- Carter: rolling cylinders, in two dimensions

CYLINDERS, LOAD, FRICTION = LineContact(1 / 50, 1e5), 1000.0, 0.3
WIDTH = CYLINDERS.half_width(LOAD)


def of_line_loads(n, dx):
    """ICs in plane strain along and across, -2 ln|x| / (pi E*), of strips of width dx."""
    x = dx * np.arange(1 - n, n)

    def integral(t):
        return t * np.log(np.abs(t) / (40 * WIDTH)) - t

    kernel = -2 / (np.pi * CYLINDERS.modulus) * (integral(x + dx / 2) - integral(x - dx / 2))
    return Convolution((X, S), {"1": np.ones(1)}, {((i, "1"), (i, "1")): kernel[:, None] for i in (X, S)})


def mean_pressures(x, dx):
    """Exact means over elements."""
    t = np.clip(np.stack([x - dx / 2, x + dx / 2]) / WIDTH, -1, 1)
    low, high = (t * np.sqrt(1 - t**2) + np.arcsin(t)) / 2
    return np.maximum(high - low, 0) * CYLINDERS.p_max(LOAD) * WIDTH / dx


def carter(n, offset, order, share):
    """Tractions, where they are and what Carter has: n elements across, a share of his largest creepage."""
    creepage = share * TractiveRolling(CYLINDERS, LOAD, FRICTION, 0.0).largest_creepage
    exact = TractiveRolling(CYLINDERS, LOAD, FRICTION, creepage)
    dx = 2 * WIDTH / n
    x = dx * (np.arange(n + 8) - (n + 7) / 2 - offset)
    g = FRICTION * mean_pressures(x, dx)
    rigid = np.zeros((n + 8, 1, 2))
    rigid[..., 0] = -creepage
    motion = SteadyRolling(rigid, dx=dx, order=order)
    operator = of_line_loads(n + 8, dx)
    result = coulomb.tractions(law(operator, motion, np.where(g > 1e-9 * g.max(), g, 0)[:, None]))
    return result, x, dx, exact


@pytest.mark.parametrize("share", [0.96, 0.97, 0.99, 0.999])
def test_the_sliding_share_is_known_where_less_than_an_element_sticks(share):
    """Carter's contact sticks over 1 - share of its width: less than one of twenty elements."""
    for offset in (0.0, 0.25, 0.5, -0.3):
        result, x, dx, exact = carter(20, offset, 2, share)
        pressures = mean_pressures(x, dx)[:, None, None]
        state = SlipState(np.concatenate([result.p, pressures], axis=-1), result.stick, result.slip, FRICTION)
        sliding = np.count_nonzero(state.slides) / np.count_nonzero(state.in_contact)
        known = 1 - exact.stick_half_width / exact.half_width
        assert abs(sliding - known) <= floors(state)["sliding"]


def errors_of_carter(order, share):
    """Root mean squares of the errors of the force, over places of the grid, for 20, 40 and 80 elements."""
    errors = []
    for n in (20, 40, 80):
        places = [carter(n, offset, order, share) for offset in (0.0, 0.25, 0.5, -0.3, 0.13)]
        each = [result.p[..., 0].sum() * dx / exact.force - 1 for result, _, dx, exact in places]
        errors.append(np.sqrt(np.mean(np.square(each))))
    return np.array(errors)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.6])
def test_forces_converge_to_carter_with_their_order(share):
    first, second = errors_of_carter(1, share), errors_of_carter(2, share)
    assert np.log2(first[0] / first[2]) / 2 == pytest.approx(1, abs=0.1)
    assert np.log2(second[0] / second[2]) / 2 == pytest.approx(1.9, abs=0.15)
    assert np.all(first / second > [2, 4, 8])
    assert second[2] < 1e-3


@pytest.mark.parametrize("order", [1, 2])
def test_tractions_and_slip_agree_with_carter(order):
    result, x, dx, exact = carter(160, 0.2, order, 0.5)
    p, inner = result.p[:, 0, 0], np.abs(x) < 0.95 * WIDTH
    assert np.max(np.abs(p - exact.traction(x))[inner]) < (0.03, 0.015)[order - 1] * p.max()
    behind = inner & (x < exact.stick_start - 4 * dx)
    slip = exact.slip(x)
    assert np.max(np.abs(result.slip[:, 0, 0] - slip)[behind]) < (0.05, 0.02)[order - 1] * np.nanmax(
        np.abs(slip)
    )
    sticks = x[result.stick[:, 0]]
    assert sticks.min() == pytest.approx(exact.stick_start, abs=2 * dx)
    assert sticks.max() > WIDTH - 1.2 * dx
    assert np.max(np.abs(result.p[..., 1])) == 0


# ---- an ellipse with all creepages

A, B, F_N = 5.0, 4.0, 80e3


def of_ellipse(n_x, n_s, order):
    """Forces and moment over friction times load; bounds are means of Hertz's pressures over elements."""
    dx, ds, more = 2 * A / n_x, 2 * B / n_s, 6
    grid = Grid(n_x + more, n_s + more, dx, ds)
    edges = (x_of(grid)[:, None] + [-dx / 2, dx / 2]) / A
    fine = (np.arange(16) + 0.5) / 16 - 0.5
    s = (grid.strips[:, None] + ds * fine) / B
    half = np.sqrt(np.maximum(1 - s**2, 1e-30))
    t = np.clip(edges[:, :, None, None] / half, -1, 1)
    low, high = np.moveaxis((t * np.sqrt(1 - t**2) + np.arcsin(t)) / 2, 1, 0)
    pressures = 1.5 * F_N / (np.pi * A * B) * np.mean((high - low) * half**2, axis=-1) * A / dx
    assert np.sum(pressures) * grid.area == pytest.approx(F_N, rel=1e-3)
    rigid = np.zeros((*pressures.shape, 2))
    rigid[..., 0] = -8e-4 - 2e-4 * grid.strips
    rigid[..., 1] = 4e-4 + 2e-4 * x_of(grid)[:, None]
    motion = SteadyRolling(rigid, dx=dx, order=order)
    bound = 0.3 * np.where(pressures > 1e-9 * pressures.max(), pressures, 0)
    p = coulomb.tractions(law(on_half_spaces(grid), motion, bound)).p * grid.area / (0.3 * F_N)
    moment = np.sum(x_of(grid)[:, None] * p[..., 1] - grid.strips * p[..., 0]) / np.sqrt(A * B)
    return np.array([*p.sum(axis=(0, 1)), moment])


def test_forces_on_an_ellipse_converge_with_their_order_to_the_same_limit():
    grids = [(20, 16), (40, 32), (80, 64)]
    first, second = (np.array([of_ellipse(*grid, order) for grid in grids]) for order in (1, 2))
    limit = (4 * second[2] - second[1]) / 3
    errors = np.linalg.norm(first - limit, axis=1)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 1, atol=0.2)
    changes = np.linalg.norm(np.diff(second, axis=0), axis=1)
    assert np.log2(changes[0] / changes[1]) > 1.6
    assert np.all(errors > [3, 5, 8] * np.linalg.norm(second - limit, axis=1))
    assert 0.25 < np.linalg.norm(limit[:2]) < 0.95


# ---- forces that friction can supply, against closed forms and by brute force over directions of amplitudes

BOUND = np.random.default_rng(0).uniform(0.0, 2.0, (9, 8)) - 0.4
BOUND[BOUND < 0] = 0.0
X_AT, Y_AT = np.meshgrid(np.linspace(-4.0, 4.0, 9), np.linspace(-3.0, 3.0, 8), indexing="ij")
ONE, ZERO = np.ones_like(X_AT), np.zeros_like(X_AT)
ALONG, ACROSS, TURNING = (np.stack(pair, axis=-1) for pair in ((ONE, ZERO), (ZERO, ONE), (-Y_AT, X_AT)))


TURN = np.sum(BOUND * np.hypot(X_AT, Y_AT))


@pytest.mark.parametrize(
    ("ways", "bound", "targets", "expected"),
    [
        *(([ALONG], BOUND, [BOUND.sum() / factor], abs(factor)) for factor in (4.0, -0.5)),
        *(([TURNING], BOUND, [TURN / factor], abs(factor)) for factor in (4.0, -0.5)),
        *(
            ([ALONG, ACROSS], BOUND, 0.5 * BOUND.sum() * np.array([np.cos(angle), np.sin(angle)]), 2.0)
            for angle in (0.0, 0.7, 2.0, -1.1)
        ),
        ([ALONG], BOUND, [0.0], np.inf),
        ([ALONG], 0 * BOUND, [0.0], 0.0),
        ([ALONG, ACROSS], 0 * BOUND, [1.0, 0.0], 0.0),
        ([ALONG, 0 * ALONG], BOUND, [1.0, 1.0], 0.0),
        ([ALONG, ALONG], BOUND, [1.0, -1.0], 0.0),
        ([ALONG, ALONG], BOUND, [0.25 * BOUND.sum()] * 2, 4.0),
    ],
)
def test_limit_of_one_force_of_two_in_any_direction_of_none_and_of_dependent_ones(
    ways, bound, targets, expected
):
    factor = attainable_factor(np.array(ways), bound, np.array(targets))
    assert factor == pytest.approx(expected, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_three_forces_are_within_what_all_directions_allow(seed):
    """The least of sum g |c W| over c f = 1, c by steps of 0.03 rad: at most that of the grid, not below."""
    weights = np.array([ALONG, ACROSS, TURNING])
    targets = BOUND.sum() * np.random.default_rng(seed).normal(size=3) * [1.0, 1.0, 3.0]
    t, u = np.meshgrid(np.linspace(0, np.pi, 106), np.linspace(0, 2 * np.pi, 210))
    c = np.stack([np.sin(t) * np.cos(u), np.sin(t) * np.sin(u), np.cos(t) / 3], axis=-1).reshape(-1, 3)
    work = np.linalg.norm(np.tensordot(c, weights, 1), axis=-1).reshape(len(c), -1) @ BOUND.ravel()
    power = c @ targets
    least = np.min(work[power > 0] / power[power > 0])
    assert least * (1 - 3e-3) < attainable_factor(weights, BOUND, targets) <= least * (1 + 1e-9)


def test_limit_is_independent_of_units_and_scales_with_forces():
    weights, targets = np.array([ALONG, ACROSS, TURNING]), np.array([20.0, -5.0, 40.0])
    here = attainable_factor(weights, BOUND, targets)
    scales = np.array([1.0, 1.0, 1e-3])
    for unit in (1e6, 1e-9):
        there = attainable_factor(
            weights * scales[:, None, None, None], unit * BOUND, unit * targets * scales
        )
        assert there == pytest.approx(here, rel=1e-6)
    assert attainable_factor(weights, BOUND, 3 * targets) == pytest.approx(here / 3)


def test_limit_is_found_from_amplitudes_that_leave_an_element_without_slip():
    """Elements at y = 0, 2, 4 with bounds 13/4, 3/2, 13/4: the first amplitudes turn about the second one.

    The limit is reached with all friction of the first two: F = p0 + p2 + p4 and M = 2 p2 + 4 p4 = -2 F.
    """
    y, g = np.array([0.0, 2.0, 4.0]), np.array([3.25, 1.5, 3.25])[:, None]
    weights = np.zeros((2, 3, 1, 2))
    weights[0, :, 0, 0], weights[1, :, 0, 0] = 1.0, y
    p = np.array([3.25, 1.5, -(3.25 + 2 * 1.5) / 3])
    force, moment = p.sum(), y @ p
    assert moment == pytest.approx(-2 * force)
    assert attainable_factor(weights, g, np.array([8.0, -16.0])) == pytest.approx(force / 8.0, rel=1e-4)


def test_one_element_bears_no_moment_of_its_own():
    """Its force and its moment go together: the moment is x times the lateral force."""
    lone = np.zeros_like(BOUND)
    lone[6, 3] = 2.0
    lateral, lever = 1.0, X_AT[6, 3]
    together = np.array([0.0, lateral, lateral * lever])
    weights = np.array([ALONG, ACROSS, TURNING])
    assert Y_AT[6, 3] != 0
    assert attainable_factor(weights, lone, together) == pytest.approx(2.0, rel=1e-3)
    assert attainable_factor(weights, lone, together * [1, 1, -1]) < 1e-3
