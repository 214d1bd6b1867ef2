"""How the Newton method goes: its equations against loops and differences, its steps, starts and ends."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import Coulomb, FreeAmplitudes
from femic.contact.friction.law import stagnated
from femic.contact.friction.motion import LeadingEdge, Shift, SteadyRolling
from tests.femic.contact.friction.laws import (
    GRID,
    MOTIONS,
    bounds,
    law,
    no_forces,
    on_half_spaces,
    with_forces,
)

TIGHT = 1e-12


# ---- independent springs: slip is a p + w, and p the projection of -w / a onto the disc of radius g

SHAPE = 4, 3
LENGTHS = np.array([[0.3, 0.0, 0.8], [0.1, 1.4, 0.4], [0.0, 0.2, 0.9], [2.0, 0.7, 0.05]])
RIGID = np.random.default_rng(3).normal(size=(*SHAPE, 2))
WAYS = np.zeros((2, *SHAPE, 2))
WAYS[0, ..., 0] = WAYS[1, ..., 1] = 1.0


class AsGiven:
    """An approximate inverse for the slip where elements stick, given as a function of slips."""

    def __init__(self, of_slip):
        self.of_slip = of_slip

    def inverse(self, law, _):
        def tractions(residual):
            slip = np.zeros(law.slip.shape)
            slip[law.free] = np.where(law.stick[:, None], residual, 0.0)
            sticking = self.of_slip(slip)[law.free] / law.scale
            return np.where(law.stick[:, None], sticking, residual)

        return tractions


def springs(bound=LENGTHS, rigid=RIGID, compliance=0.25, free=None):
    """Elements that do not move each other; `compliance` may be different along x and s, and in places."""
    own = np.broadcast_to(compliance, rigid.shape)
    return Coulomb(
        lambda p: own * p,
        AsGiven(lambda slip: slip / own),
        rigid,
        bound,
        LeadingEdge.find(bound, 0),
        Shift(rigid),
        no_forces(bound) if free is None else free,
    )


def projected(p, bound):
    size = np.linalg.norm(p, axis=-1, keepdims=True)
    return p * np.where(size > bound[..., None], bound[..., None] / np.maximum(size, TIGHT), 1.0)


@pytest.mark.parametrize("seed", range(4))
def test_springs_take_one_step_from_any_start(seed):
    """With r = 1 / a, p - r s = -w / a does not depend on p: the first step ends at the solution."""
    start = np.random.default_rng(seed).normal(size=(*SHAPE, 2))
    result = coulomb.tractions(springs(), start=start, tolerance=TIGHT)
    exact = projected(-RIGID / 0.25, LENGTHS)
    np.testing.assert_allclose(result.p, exact, atol=1e-12)
    assert len(result.residuals) == 2
    np.testing.assert_array_equal(result.stick, (np.linalg.norm(RIGID / 0.25, axis=-1) <= LENGTHS))
    again = coulomb.tractions(springs(), start=exact, tolerance=TIGHT)
    assert len(again.residuals) == 1


def test_trial_slip_is_scaled_by_the_mean_compliance_of_the_element_in_the_middle():
    compliance = np.full((9, 8, 2), 1e3)
    compliance[4, 4] = 2.0, 3.0
    problem = springs(np.ones((9, 8)), np.zeros((9, 8, 2)), compliance)
    assert coulomb._Newton.prepare(problem, 3.0).scale == pytest.approx(3.0 / 2.5)


def test_an_exact_solution_meets_a_tolerance_of_zero():
    none = springs(rigid=np.zeros((*SHAPE, 2)))
    for problem in (none, springs(bound=0 * LENGTHS)):
        result = coulomb.tractions(problem, tolerance=0.0)
        assert result.residuals == [0.0]
        assert not np.any(result.p)


def test_without_free_elements_there_is_no_residual():
    problem = springs(bound=0 * LENGTHS)
    newton = coulomb._Newton.prepare(problem, 1.0)
    state = newton.state(*newton.first(None, None))
    assert (state.largest, state.defect) == (0.0, 0.0)
    assert state.bound > 0


def test_steps_begin_without_tractions_or_with_those_of_free_elements():
    newton, _ = of_random_numbers()
    start, amplitudes = np.random.default_rng(0).normal(size=(*AREA, 2)), np.array([3.0, 4.0])
    q, c = newton.first(None, None)
    np.testing.assert_array_equal(q, np.zeros((np.count_nonzero(newton.problem.edge.free), 2)), strict=True)
    np.testing.assert_array_equal(c, np.zeros(2), strict=True)
    q, c = newton.first(start, amplitudes)
    np.testing.assert_array_equal(q, start[newton.problem.edge.free])
    np.testing.assert_array_equal(c, amplitudes)


def test_an_element_without_traction_and_slip_sticks():
    newton = coulomb._Newton.prepare(springs(rigid=np.zeros((*SHAPE, 2))), 1.0)
    state = newton.state(*newton.first(None, None))
    assert np.all(state.law.stick)
    np.testing.assert_array_equal(state.law.direction, 0.0)
    assert np.all(np.isfinite(state.law.share))


def test_an_element_at_its_bound_without_slip_sticks():
    newton = coulomb._Newton.prepare(springs(np.ones(SHAPE), np.zeros((*SHAPE, 2)), 0.0 * RIGID + 0.25), 1.0)
    q = np.tile([1.0, 0.0], (12, 1))
    assert np.all(newton.state(q, np.zeros(0), np.zeros((*SHAPE, 2))).law.stick)


# ---- a problem of random numbers, with followers at a leading edge and free amplitudes


RANDOM = np.random.default_rng(5)
AREA = 9, 3
BOUND = RANDOM.uniform(0.2, 0.7, AREA)
BOUND[:2, 0] = BOUND[8, 2] = BOUND[4, 1] = 0.0


def of_random_numbers(scale=0.8):
    """A state of the problem, near the limit of stick, with its Newton method."""
    random = np.random.default_rng(7)
    size = 2 * BOUND.size
    L = np.eye(size) + 0.1 * random.normal(size=(size, size))
    K = np.eye(size) + 0.1 * random.normal(size=(size, size))
    rigid, (modes, weights) = random.normal(size=(*AREA, 2)), random.normal(size=(2, 2, *AREA, 2))
    problem = Coulomb(
        lambda p: (L @ p.ravel()).reshape(p.shape),
        AsGiven(lambda slip: (K @ slip.ravel()).reshape(slip.shape)),
        rigid,
        BOUND,
        LeadingEdge.find(BOUND, 2),
        SteadyRolling(rigid, dx=1.0),
        FreeAmplitudes(modes, weights, np.array([0.3, -0.2])),
    )
    newton = coulomb._Newton.prepare(problem, scale)
    q = 0.3 * random.normal(size=(len(newton.g), 2))
    c = np.array([0.4, -0.7])
    linear = 0.4 * newton.slip(q, c) - 0.8 * rigid  # as if it were L p + B c: small slip, so that some stick
    return newton, newton.state(q, c, linear)


def spread(newton, q):
    """Tractions of all elements by a loop."""
    edge, p, row = newton.problem.edge, np.zeros((*AREA, 2)), 0
    for at in np.ndindex(*AREA):
        if edge.free[at]:
            p[at], row = q[row], row + 1
    for i, j in np.ndindex(*AREA):
        k = edge.followed[i, j]
        if BOUND[i, j] and k != i:
            p[i, j] = p[k, j] * BOUND[i, j] / BOUND[k, j]
    return p


def test_linear_part_of_slip_is_that_of_tractions_and_amplitudes():
    newton, state = of_random_numbers()
    free, p = newton.problem.free, spread(newton, state.q)
    assert np.count_nonzero(newton.problem.edge.free) < np.count_nonzero(BOUND)
    np.testing.assert_allclose(newton.spread(state.q), p)
    expected = newton.problem.compliance(p) + state.c[0] * free.modes[0] + state.c[1] * free.modes[1]
    np.testing.assert_allclose(newton.slip(state.q, state.c), expected)
    np.testing.assert_allclose(newton.state(state.q, state.c).linear, expected)


def test_forces_are_shares_of_the_weights_in_contact():
    newton, state = of_random_numbers()
    p, free = spread(newton, state.q), newton.problem.free
    for force, weights in zip(newton.forces(state.q), free.weights, strict=True):
        whole = sum(np.abs(weights[at]).sum() for at in np.ndindex(*AREA) if BOUND[at])
        assert force == pytest.approx(sum(weights[at] @ p[at] for at in np.ndindex(*AREA)) / whole)


def test_residual_is_that_of_the_law_on_each_element_and_of_the_forces():
    newton, state = of_random_numbers()
    problem, law, residuals, defects = newton.problem, state.law, [], []
    slip = state.linear + problem.rigid
    centred = problem.motion.at_elements(slip)
    assert 3 < np.count_nonzero(law.stick) < len(law.stick) - 3
    for row, at in enumerate(zip(*np.nonzero(problem.edge.free), strict=True)):
        trial, g = state.q[row] - newton.scale * centred[at], BOUND[at]
        length = np.linalg.norm(trial)
        assert law.stick[row] == (length <= g)
        np.testing.assert_allclose(law.direction[row], trial / length)
        np.testing.assert_allclose(law.share[row], min(g / length, 1.0))
        nearest = trial if length <= g else g * trial / length
        residuals += list(newton.scale * slip[at] if length <= g else state.q[row] - nearest)
        defects += list(state.q[row] - nearest)
    whole = np.sum(np.abs(problem.free.weights)[:, BOUND > 0], axis=(1, 2))
    of_forces = list(newton.forces(state.q) - problem.free.targets / whole)
    np.testing.assert_allclose(law.slip, slip)
    np.testing.assert_allclose(law.centred, centred)
    np.testing.assert_allclose(state.residual, residuals + of_forces)
    assert state.defect == pytest.approx(np.linalg.norm(defects + of_forces))
    largest_bound = max(BOUND[problem.edge.free])
    assert state.largest == pytest.approx(max(np.abs(residuals + of_forces)) / largest_bound)
    np.testing.assert_array_equal(problem.edge.with_followers(law.stick), sticking(newton, state))


def sticking(newton, state):
    """Elements with bounds that stick or follow one that does."""
    edge, stick = newton.problem.edge, np.zeros(AREA, bool)
    stick[edge.free] = state.law.stick
    return np.array(
        [[BOUND[i, j] > 0 and stick[edge.followed[i, j], j] for j in range(AREA[1])] for i in range(AREA[0])]
    )


def equations(monkeypatch, newton, state, *arguments):
    """What a step gives to GMRES: matrix, right-hand side, relative residual, preconditioner."""
    given = []

    def watched(matrix, right, *, rtol, M, **_):
        given.append((matrix, right, rtol, M))
        return np.zeros(len(right)), 0

    with monkeypatch.context() as patch:
        patch.setattr("femic.contact.friction.law.gmres", watched)
        newton.step(state, *arguments)
    return given[0]


def dense(operator):
    return np.stack([operator.matvec(unit) for unit in np.eye(operator.shape[0])], axis=1)


def test_linear_equations_have_the_derivative_of_the_residual(monkeypatch):
    newton, state = of_random_numbers()
    matrix, right, _, _ = equations(monkeypatch, newton, state, TIGHT)
    np.testing.assert_array_equal(right, -state.residual)
    m, h = len(state.q), 1e-6
    for unit, column in zip(np.eye(len(right)), dense(matrix).T, strict=True):
        dq, dc = unit[: 2 * m].reshape(m, 2), unit[2 * m :]
        ahead, behind = (
            newton.state(
                state.q + sign * h * dq,
                state.c + sign * h * dc,
                state.linear + sign * h * newton.slip(dq, dc),
            )
            for sign in (1, -1)
        )
        np.testing.assert_array_equal(ahead.law.stick, behind.law.stick)
        np.testing.assert_allclose(column, (ahead.residual - behind.residual) / (2 * h), atol=1e-7)


def test_preconditioner_is_the_inverse_of_the_equations_with_an_approximation_for_tractions(monkeypatch):
    """Where elements stick, the approximate inverse over r, elsewhere one: bordered with the amplitudes."""
    newton, state = of_random_numbers()
    matrix, _, _, preconditioner = equations(monkeypatch, newton, state, TIGHT)
    m, K = len(state.q), np.zeros((2 * len(state.q),) * 2)
    sticks = np.repeat(state.law.stick, 2)
    for column in range(2 * m):
        slip = np.zeros((*AREA, 2))
        slip[newton.mask] = np.eye(2 * m)[column].reshape(m, 2)
        tractions = newton.problem.strips.of_slip(slip)[newton.mask].ravel() / newton.scale
        K[:, column] = np.where(sticks, tractions, 0.0) if sticks[column] else np.eye(2 * m)[column]
    bordered = dense(matrix)
    bordered[: 2 * m, : 2 * m] = np.linalg.inv(K)
    np.testing.assert_allclose(dense(preconditioner), np.linalg.inv(bordered), atol=1e-9)


def test_amplitudes_that_do_the_same_share_what_one_would_do(monkeypatch):
    """Their equations are singular; the least amplitudes are taken."""
    newton, state = of_random_numbers()
    free = newton.problem.free
    twice = replace(newton.problem, free=replace(free, modes=free.modes[[0, 0]]))
    newton = replace(newton, problem=twice)
    _, _, _, preconditioner = equations(monkeypatch, newton, state, TIGHT)
    size = preconditioner.shape[0]
    for v in np.random.default_rng(0).normal(size=(3, size)):
        first, second = preconditioner.matvec(v)[-2:]
        assert first == pytest.approx(second, rel=1e-6)
        assert 0 < abs(first) < 100


def with_values(of, **values):
    """The same, with values of cached properties."""
    of = replace(of)
    vars(of).update(values)
    return of


@pytest.mark.parametrize(
    ("largest", "tolerance", "expected"),
    [
        (3.0, 1e-6, 0.1),  # far from the solution one digit is enough
        (0.1, 1e-6, 0.1),
        (1e-3, 1e-9, 1e-3),  # near to it Newton's method doubles the digits
        (1e-3, 1e-5, 1e-3),
        (1e-4, 1e-5, 1e-2),  # but not beyond a tenth of the tolerance
        (1e-4, 1e-4, 0.1),
        (1e-4, 1e-2, 0.1),
    ],
)
def test_linear_equations_are_solved_as_exactly_as_the_next_residual_needs(
    largest, tolerance, expected, monkeypatch
):
    newton, state = of_random_numbers()
    residual = np.full(len(state.residual), 1e-9)
    residual[3] = -largest * state.bound
    state = with_values(state, residual=residual)
    _, _, rtol, _ = equations(monkeypatch, newton, state, tolerance)
    assert rtol == pytest.approx(expected)
    _, _, rtol, _ = equations(monkeypatch, newton, state, tolerance, 1e-7)
    assert rtol == pytest.approx(1e-7)


# ---- the length of steps


def candidates(defect_of_share):
    """The shares of a step that are tried, whose defects are these shares of the one before it."""
    newton, state = of_random_numbers()
    shares, before = [], 7.0

    class Newton(coulomb._Newton):
        def step(self, *_):
            return np.ones_like(state.q), np.full_like(state.c, 2.0)

        def state(self, q, c, linear):
            shares.append(float(q[0, 0] - state.q[0, 0]))
            assert len(shares) < 9
            return SimpleNamespace(q=q, c=c, linear=linear, defect=before * defect_of_share(shares[-1]))

    begin = with_values(replace(state, linear=newton.slip(state.q, state.c)), defect=before)
    end = Newton(newton.problem, newton.mask, newton.g, newton.scale).next(begin, TIGHT)
    np.testing.assert_allclose(end.linear, newton.slip(end.q, end.c), atol=1e-12)
    np.testing.assert_allclose(end.c - state.c, 2.0 * shares[-1])
    return pytest.approx(shares)


def test_steps_are_halved_until_the_defect_falls():
    """By a share of the step's share."""
    part = coulomb.DECREASE
    assert 0 < part < 1
    assert candidates(lambda share: 1 - share) == [1.0]
    assert candidates(lambda share: 1 - part * share) == [1.0]
    assert candidates(lambda share: 1.05 if share > 0.9 else 1 - share) == [1.0, 0.5]
    assert candidates(lambda share: 2.0 if share > 0.3 else 1 - 1.1 * part * share) == [1.0, 0.5, 0.25]
    assert candidates(lambda share: 0.999 if share > 0.2 else 1 - 1.1 * part * share) == [
        1.0,
        0.5,
        0.25,
        0.125,
    ]


def test_a_least_step_is_taken_where_the_defect_does_not_fall():
    (*_, before, least) = candidates(lambda _: 2.0).expected
    assert least <= coulomb.LEAST_STEP < before
    assert least == pytest.approx(before / 2)


# ---- starts

TARGETS = np.array([-0.9, 0.6])


def with_targets(bound, **others):
    return springs(bound, free=FreeAmplitudes(WAYS, WAYS, TARGETS), **others)


def full_stick(rigid):
    """Tractions and amplitudes of springs at which nothing slips and forces are met."""
    c = -(0.25 * TARGETS + rigid.sum(axis=(0, 1))) / (rigid.size / 2)
    return -(rigid + c) / 0.25, c


def starts(problem, q=None, c=None, scale=1.7, change=lambda state: state):
    newton = coulomb._Newton.prepare(problem, scale)
    q, c = newton.first(q, c)
    given = change(newton.state(q, c))
    return given, list(newton.starts(given, TIGHT))


@pytest.mark.parametrize("seed", range(3))
def test_full_stick_moves_nothing_and_meets_the_forces(seed):
    random = np.random.default_rng(seed)
    rigid = random.normal(size=RIGID.shape)
    rigid[1, 2] = rigid[2, 0] = rigid.mean(axis=(0, 1))
    problem = with_targets(np.full(SHAPE, 100.0), rigid=rigid)
    *_, state = starts(problem, random.normal(size=rigid.shape), random.normal(size=2))[1]
    p, c = full_stick(rigid)
    np.testing.assert_allclose(state.c, c, atol=1e-9)
    np.testing.assert_allclose(state.q, p.reshape(-1, 2), atol=1e-9)
    assert state.largest < 1e-9


def test_full_stick_beyond_bounds_is_cut_to_them():
    rigid = 0.1 * RIGID
    p, c = full_stick(rigid)
    bound = np.random.default_rng(0).uniform(0.2, 1.3, SHAPE)
    *_, state = starts(with_targets(bound, rigid=rigid))[1]
    np.testing.assert_allclose(state.q, projected(p, bound).reshape(-1, 2), atol=1e-9)
    np.testing.assert_allclose(state.c, c, atol=1e-9)
    beyond = np.linalg.norm(p, axis=-1) > bound
    assert 2 < np.count_nonzero(beyond) < 10
    assert np.any(np.linalg.norm(p[beyond], axis=-1) < 1)


def test_full_stick_without_tractions_has_none():
    rigid = np.zeros((*SHAPE, 2))
    problem = springs(np.ones(SHAPE), rigid, free=FreeAmplitudes(WAYS, WAYS, np.zeros(2)))
    *_, state = starts(problem, c=np.ones(2))[1]
    np.testing.assert_allclose(state.q, 0.0, atol=1e-12)
    np.testing.assert_allclose(state.c, 0.0, atol=1e-12)


def of_largest(largest, stick):
    """The same state with another residual and stick."""

    def changed(state):
        residual = np.zeros_like(state.residual)
        residual[1] = largest * state.bound
        law = with_values(state.law, stick=np.arange(len(state.q)) < stick)
        return with_values(replace(state, law=law), residual=residual)

    return changed


@pytest.mark.parametrize(
    ("largest", "stick", "is_a_start"),
    [(5.0, 0, False), (0.3, 0, False), (0.1, 0, True), (0.05, 0, True), (5.0, 1, True), (5.0, 12, True)],
)
def test_a_guess_by_which_all_slips_is_no_start_unless_it_nearly_solves_the_problem(
    largest, stick, is_a_start
):
    given, states = starts(with_targets(np.ones(SHAPE)), change=of_largest(largest, stick))
    assert [state is given for state in states] == ([True] if is_a_start else []) + [False]


def test_without_free_amplitudes_the_guess_is_the_only_start():
    given, states = starts(springs(), change=of_largest(5.0, 0))
    assert states == [given]


def counted(problem):
    """The problem, with a list that grows with each product."""
    products = []

    def compliance(p):
        products.append(p)
        return problem.compliance(p)

    return replace(problem, compliance=compliance), products


def test_full_stick_on_half_spaces_is_solved_to_a_small_share_of_the_slip_and_no_further():
    problem, products = counted(with_forces([30.0, -20.0], 1e6 * bounds()))
    newton = coulomb._Newton.prepare(problem, 1.0)
    start = 1e8 * np.random.default_rng(0).normal(size=problem.rigid.shape)
    given = newton.state(*newton.first(start, np.array([3e-3, -1e-3])))
    assert given.largest > 1
    effort = {}
    for loosest in (1e-3, 1e-5, 1e-7):
        products.clear()
        newton.step(replace(given, law=replace(given.law, sticking=True)), TIGHT, loosest)
        effort[loosest] = len(products)
    products.clear()
    *_, state = newton.starts(given, TIGHT)
    assert effort[1e-5] <= len(products) - 1 <= effort[1e-7]
    before, after = (np.max(np.abs(one.law.slip[newton.mask])) for one in (given, state))
    assert after < 1e-5 * before


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_steps_are_solved_no_better_than_needed(motion):
    problem, products = counted(law(on_half_spaces(GRID), motion, bounds()))
    newton = coulomb._Newton.prepare(problem, 1.0)
    state = newton.state(*newton.first(None, None))
    effort = []
    for loosest in ((), (1e-4,)):
        products.clear()
        newton.step(state, TIGHT, *loosest)
        effort.append(len(products))
    assert 0 < effort[0] < effort[1] < 2 * len(newton.g)


# ---- ends


@pytest.mark.parametrize(
    ("residuals", "idle"),
    [
        ([], False),
        ([1.0], False),
        ([1.0] + [2.0] * 14, False),  # not enough steps to say so
        ([1.0] + [2.0] * 15, True),
        ([1.0] + [1.0] * 15, False),
        ([1.0] + [2.0] * 14 + [0.9], False),
        ([1.0] + [2.0] * 3 + [0.9] + [2.0] * 11, False),
        ([5.0, 1.0, 5.0] + [2.0] * 15, True),
        ([5.0, 3.0, 5.0] + [2.0] * 15, False),
        ([5.0] * 20 + [1.0] + [2.0] * 15, True),
        ([5.0] * 20 + [1.0] + [2.0] * 14, False),
        ([1.0] + [2.0, 3.0] * 20, True),
        ([1.0 / n for n in range(1, 60)], False),
    ],
)
def test_steps_are_idle_when_the_last_fifteen_do_not_fall_below_one_before(residuals, idle):
    assert coulomb.MOST_IDLE_STEPS == 15
    assert stagnated(residuals, coulomb.MOST_IDLE_STEPS) is idle


class Wandering(coulomb._Newton):
    """Steps after each of which the residual is 1 % larger."""

    def next(self, state, _):
        return with_values(state, residual=1.01 * state.residual)


def test_idle_steps_end():
    newton = Wandering(*vars(coulomb._Newton.prepare(springs(), 1.0)).values())
    residuals = [1e-5] * 30  # of an earlier start
    state = newton.state(*newton.first(None, None))
    assert newton.solution(state, TIGHT, residuals) is None
    assert len(residuals) == 30 + 1 + coulomb.MOST_IDLE_STEPS
    assert residuals[30] == state.largest
