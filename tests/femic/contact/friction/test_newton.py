"""How the Newton methods go: their equations against loops and differences, starts, ends, inverses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, gmres

from femic.contact import coupled
from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import Coulomb, FreeAmplitudes
from femic.contact.friction.law import Law, StripInverse, Strips, correction, inverse_of_amplitudes, stagnated
from femic.contact.friction.motion import LeadingEdge, RollingStep, Shift, SteadyRolling
from geometries.patches import Grid
from tests.femic.contact.friction.laws import no_forces, on_half_spaces

TIGHT = 1e-12


class Exact:
    """The same in double precision: tractions where elements stick are slip over the compliance."""

    def inverse(self, law, _):
        return lambda residual: residual / np.where(law.stick[:, None], COMPLIANCE * law.scale, 1.0)


# ---- independent springs: slip is a p + w, and p the projection of -w / a onto the disc of radius g

SHAPE, COMPLIANCE = (4, 3), 0.25
LENGTHS = np.array([[0.3, 0.0, 0.8], [0.1, 1.4, 0.4], [0.0, 0.2, 0.9], [2.0, 0.7, 0.05]])
RIGID = np.random.default_rng(3).normal(size=(*SHAPE, 2))
WAYS = np.zeros((2, *SHAPE, 2))
WAYS[0, ..., 0] = WAYS[1, ..., 1] = 1.0
TARGETS = np.array([-0.9, 0.6])


def springs(bound=LENGTHS, rigid=RIGID, free=None):
    return Coulomb(
        lambda p: COMPLIANCE * p,
        Exact(),
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
    exact = projected(-RIGID / COMPLIANCE, LENGTHS)
    np.testing.assert_allclose(result.p, exact, atol=1e-12)
    assert len(result.residuals) == 2
    np.testing.assert_array_equal(result.stick, np.linalg.norm(RIGID / COMPLIANCE, axis=-1) <= LENGTHS)
    assert len(coulomb.tractions(springs(), start=exact, tolerance=TIGHT).residuals) == 1


def test_an_exact_solution_meets_a_tolerance_of_zero():
    for problem in (springs(rigid=np.zeros((*SHAPE, 2))), springs(bound=0 * LENGTHS)):
        result = coulomb.tractions(problem, tolerance=0.0)
        assert result.residuals == [0.0]
        assert not np.any(result.p)


@pytest.mark.parametrize("largest", [100.0, 1.3])
def test_full_stick_moves_nothing_and_meets_the_forces_but_for_bounds(largest):
    random = np.random.default_rng(0)
    bound, rigid = random.uniform(0.2, 1.0, SHAPE) * largest, 0.1 * RIGID
    newton = coulomb._Newton(springs(bound, rigid, FreeAmplitudes(WAYS, WAYS, TARGETS)), 1.7)
    given = newton.state(random.normal(size=(rigid.size // 2, 2)), random.normal(size=2))
    *_, state = newton.starts(given, TIGHT)
    c = -(COMPLIANCE * TARGETS + rigid.sum(axis=(0, 1))) / (rigid.size / 2)
    np.testing.assert_allclose(state.c, c, atol=1e-9)
    expected = projected(-(rigid + c) / COMPLIANCE, bound)
    np.testing.assert_allclose(state.q, expected.reshape(-1, 2), atol=1e-9)
    assert (state.largest < 1e-9) == (largest == 100.0)


# ---- a problem of random numbers, with followers at a leading edge and free amplitudes

AREA = 9, 3
BOUND = np.random.default_rng(5).uniform(0.2, 0.7, AREA)
BOUND[:2, 0] = BOUND[8, 2] = BOUND[4, 1] = 0.0


def random_numbers(scale=0.8):
    """The problem's Newton method, and a state near the limit of stick."""
    random = np.random.default_rng(7)
    own = np.stack([np.eye(len(BOUND), dtype=np.float32)] * 2)  # strips do not move each other
    L = np.eye(2 * BOUND.size) + 0.1 * random.normal(size=(2 * BOUND.size,) * 2)
    rigid, (modes, weights) = random.normal(size=(*AREA, 2)), random.normal(size=(2, 2, *AREA, 2))
    problem = Coulomb(
        lambda p: (L @ p.ravel()).reshape(p.shape),
        Strips(own, np.zeros_like(own), lambda slip: slip),
        rigid,
        BOUND,
        LeadingEdge.find(BOUND, 2),
        SteadyRolling(rigid, dx=1.0),
        FreeAmplitudes(modes, weights, np.array([0.3, -0.2])),
    )
    newton = coulomb._Newton(problem, scale)
    q, c = 0.3 * random.normal(size=(len(newton.g), 2)), np.array([0.4, -0.7])
    linear = 0.4 * newton.slip(q, c) - 0.8 * rigid  # as if it were L p + B c: small slip, so that some stick
    return newton, newton.state(q, c, linear)


def test_slip_is_that_of_all_tractions_and_amplitudes():
    """Tractions of followers are in proportion to bounds."""
    newton, state = random_numbers()
    edge, free, p = newton.problem.edge, newton.problem.free, np.zeros((*AREA, 2))
    assert np.count_nonzero(edge.free) < np.count_nonzero(BOUND)
    p[edge.free] = state.q
    for i, j in np.ndindex(*AREA):
        k = edge.followed[i, j]
        if BOUND[i, j] and k != i:
            p[i, j] = p[k, j] * BOUND[i, j] / BOUND[k, j]
    np.testing.assert_allclose(newton.spread(state.q), p)
    expected = newton.problem.compliance(p) + state.c[0] * free.modes[0] + state.c[1] * free.modes[1]
    np.testing.assert_allclose(newton.state(state.q, state.c).linear, expected)
    for force, weights in zip(newton.forces(state.q), free.weights, strict=True):
        whole = sum(np.abs(weights[at]).sum() for at in np.ndindex(*AREA) if BOUND[at])
        assert force == pytest.approx(sum(weights[at] @ p[at] for at in np.ndindex(*AREA)) / whole)


def test_residual_is_that_of_the_law_on_each_element_and_of_the_forces():
    newton, state = random_numbers()
    problem, law, residuals, defects = newton.problem, state.law, [], []
    slip = state.linear + problem.rigid
    centred = problem.motion.at_elements(slip)
    assert 3 < np.count_nonzero(law.stick) < len(law.stick) - 3
    for row, at in enumerate(zip(*np.nonzero(problem.edge.free), strict=True)):
        trial, g = state.q[row] - newton.scale * centred[at], BOUND[at]
        length = np.linalg.norm(trial)
        nearest = trial if length <= g else g * trial / length
        residuals += list(newton.scale * slip[at] if length <= g else state.q[row] - nearest)
        defects += list(state.q[row] - nearest)
    whole = np.sum(np.abs(problem.free.weights)[:, BOUND > 0], axis=(1, 2))
    of_forces = list(newton.forces(state.q) - problem.free.targets / whole)
    np.testing.assert_allclose(state.residual, residuals + of_forces)
    assert state.defect == pytest.approx(np.linalg.norm(defects + of_forces))
    assert state.largest == pytest.approx(max(np.abs(residuals + of_forces)) / max(BOUND[problem.edge.free]))


def equations(monkeypatch, newton, state):
    """What a step gives to GMRES: matrix, right-hand side, preconditioner, both dense."""
    given = []

    def watched(matrix, right, *, M, **_):
        given.extend([matrix, right, M])
        return np.zeros(len(right)), 0

    monkeypatch.setattr("femic.contact.friction.law.gmres", watched)
    newton.step(state, TIGHT)
    matrix, right, inverse = given
    units = np.eye(len(right))
    dense = (np.stack([linear.matvec(unit) for unit in units], axis=1) for linear in (matrix, inverse))
    return right, *dense


def test_linear_equations_have_the_derivative_of_the_residual_and_their_preconditioner_meets_forces(
    monkeypatch,
):
    newton, state = random_numbers()
    right, matrix, inverse = equations(monkeypatch, newton, state)
    np.testing.assert_array_equal(right, -state.residual)
    np.testing.assert_allclose((matrix @ inverse)[-2:], np.eye(len(matrix))[-2:], atol=1e-9)
    m, h = len(state.q), 1e-6
    for unit, column in zip(np.eye(len(right)), matrix.T, strict=True):
        dq, dc = h * unit[: 2 * m].reshape(m, 2), h * unit[2 * m :]
        change = newton.slip(dq, dc)
        ahead, behind = (
            newton.state(state.q + sign * dq, state.c + sign * dc, state.linear + sign * change)
            for sign in (1, -1)
        )
        np.testing.assert_array_equal(ahead.law.stick, behind.law.stick)
        np.testing.assert_allclose(column, (ahead.residual - behind.residual) / (2 * h), atol=1e-7)


# ---- what both Newton methods share


def test_the_correction_takes_the_residual_away():
    random = np.random.default_rng(1)
    matrix, residual = np.eye(20) + 0.1 * random.normal(size=(20, 20)), random.normal(size=20)
    change = correction(residual, lambda v: matrix @ v, lambda v: v, 1e-10)
    np.testing.assert_allclose(matrix @ change, -residual, atol=1e-9 * np.linalg.norm(residual))


def test_amplitudes_undo_forces_that_they_change_and_others_stay_zero():
    forces = np.array([[2.0, 0.5, 0.0], [0.3, -1.0, 0.0], [0.0, 0.0, 1e-12]])  # row: of an amplitude
    inverse = inverse_of_amplitudes(list(forces))
    amplitudes = inverse @ np.array([0.7, -0.2, 0.0])
    np.testing.assert_allclose(-amplitudes @ forces, [0.7, -0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(inverse @ np.array([0.0, 0.0, 1.0]), 0.0, atol=1e-12)
    assert inverse_of_amplitudes([]).shape == (0, 0)


@pytest.mark.parametrize("steps", [coulomb.MOST_IDLE_STEPS, coupled.MOST_IDLE_STEPS])
def test_steps_stagnate_when_none_of_the_last_falls_below_one_before(steps):
    idle = [2.0] * steps
    assert not stagnated([], steps)
    assert not stagnated([1.0, *idle[1:]], steps)  # not enough steps to say so
    assert stagnated([1.0, *idle], steps)
    assert stagnated([5.0, 1.0, 5.0, *idle], steps)
    assert not stagnated([5.0, 3.0, 5.0, *idle], steps)
    assert not stagnated([1.0, *idle[1:], 0.9], steps)
    assert not stagnated([1.0 / n for n in range(1, 60)], steps)


# ---- edges of stick, accuracy and length of steps, starts and ends


def no_tractions(newton):
    return np.zeros((len(newton.g), 2)), np.zeros(len(newton.problem.free.targets))


@pytest.mark.parametrize("q", [0.0, 1.0], ids=["without traction", "at its bound"])
def test_an_element_without_slip_sticks(q):
    newton = coulomb._Newton(springs(np.ones(SHAPE), np.zeros((*SHAPE, 2))), 1.0)
    state = newton.state(np.tile([q, 0.0], (12, 1)), np.zeros(0), np.zeros((*SHAPE, 2)))
    assert np.all(state.law.stick)
    assert np.all(np.isfinite(state.law.share))
    np.testing.assert_array_equal(state.law.direction, np.tile([q, 0.0], (12, 1)))


def test_trial_slip_is_scaled_by_the_mean_compliance_of_the_element_in_the_middle(monkeypatch):
    compliance, scales = np.full((9, 8, 2), 1e3), []
    compliance[4, 4] = 2.0, 3.0
    problem = replace(springs(np.ones((9, 8)), np.ones((9, 8, 2))), compliance=lambda p: compliance * p)
    monkeypatch.setattr(coulomb._Newton, "starts", lambda newton, *_: scales.append(newton.scale) or ())
    with pytest.raises(IndexError):  # no start, no residual
        coulomb.tractions(problem)
    np.testing.assert_allclose(scales, np.array(coulomb.SCALES) / 2.5)


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
    newton, state = random_numbers()
    residual = np.full(len(state.residual), 1e-9)
    residual[3] = -largest * np.max(newton.g)
    state, asked = with_values(state, residual=residual), []
    monkeypatch.setattr(coulomb, "correction", lambda right, *given: asked.append(given[-1]) or right)
    newton.step(state, tolerance)
    newton.step(state, tolerance, 1e-7)
    assert asked == pytest.approx([expected, 1e-7])


def tried_shares(defect_of_share):
    """The shares of a step that are tried, whose defects are these shares of the one before it."""
    newton, state = random_numbers()
    shares, before = [], 7.0

    class Newton(coulomb._Newton):
        def step(self, *_):
            return np.ones_like(state.q), np.full_like(state.c, 2.0)

        def state(self, q, c, linear):
            shares.append(float(q[0, 0] - state.q[0, 0]))
            assert len(shares) < 9
            return SimpleNamespace(q=q, c=c, linear=linear, defect=before * defect_of_share(shares[-1]))

    begin = with_values(replace(state, linear=newton.slip(state.q, state.c)), defect=before)
    end = Newton(newton.problem, newton.scale).next(begin, TIGHT)
    np.testing.assert_allclose(end.linear, newton.slip(end.q, end.c), atol=1e-12)
    np.testing.assert_allclose(end.c - state.c, 2.0 * shares[-1])
    return shares


def test_steps_are_halved_until_the_defect_falls_by_a_share_of_the_step():
    part = coulomb.DECREASE
    assert 0 < part < 1
    assert tried_shares(lambda share: 1 - share) == pytest.approx([1.0])
    assert tried_shares(lambda share: 1 - part * share) == pytest.approx([1.0])
    assert tried_shares(lambda share: 1.05 if share > 0.9 else 1 - share) == pytest.approx([1.0, 0.5])
    slow = tried_shares(lambda share: 0.999 if share > 0.2 else 1 - 1.1 * part * share)
    assert slow == pytest.approx([1.0, 0.5, 0.25, 0.125])


def test_a_least_step_is_taken_where_the_defect_does_not_fall():
    *_, before, least = tried_shares(lambda _: 2.0)
    assert least <= coulomb.LEAST_STEP < before
    assert least == pytest.approx(before / 2)


@pytest.mark.parametrize(
    ("largest", "stick", "is_a_start"),
    [(5.0, 0, False), (0.3, 0, False), (0.1, 0, True), (0.05, 0, True), (5.0, 1, True), (5.0, 12, True)],
)
def test_a_guess_by_which_all_slips_is_a_start_where_it_nearly_solves_the_problem(largest, stick, is_a_start):
    """Amplitudes then do not change the forces; without any the guess is the only start."""
    newton = coulomb._Newton(springs(np.ones(SHAPE), free=FreeAmplitudes(WAYS, WAYS, TARGETS)), 1.7)
    state = newton.state(*no_tractions(newton))
    residual = np.zeros_like(state.residual)
    residual[1] = largest
    law = with_values(state.law, stick=np.arange(len(state.q)) < stick)
    given = with_values(replace(state, law=law), residual=residual)
    states = [one is given for one in newton.starts(given, TIGHT)]
    assert states == ([True] if is_a_start else []) + [False]
    without = coulomb._Newton(springs(), 1.7)
    given = without.state(*no_tractions(without))
    assert list(without.starts(given, TIGHT)) == [given]


class Wandering(coulomb._Newton):
    """Steps after each of which the residual is 1 % larger."""

    def next(self, state, _):
        return with_values(state, residual=1.01 * state.residual)


def test_idle_steps_end():
    newton = Wandering(springs(), 1.0)
    residuals = [1e-5] * 30  # of an earlier start
    state = newton.state(*no_tractions(newton))
    assert newton.solution(state, TIGHT, residuals) is None
    assert len(residuals) == 30 + 1 + coulomb.MOST_IDLE_STEPS
    assert residuals[30] == state.largest


# ---- the approximate inverse of the law: exact on a single strip, and on half-spaces but for its edges

MOTIONS = {"shift": Shift, "first": SteadyRolling, "second": SteadyRolling, "step": RollingStep}


def motion_of(name, grid):
    rigid = np.zeros((grid.n_x, grid.n_s, 2))
    if name == "shift":
        return Shift(rigid)
    order = 1 if name == "first" else 2
    return MOTIONS[name](rigid, dx=grid.dx, order=order)


def law_at_random(name, grid, holes=(), *, sticking=False):
    """The law at random tractions and slip, in all but the outermost elements, and its equations."""
    random, motion, operator = np.random.default_rng(0), motion_of(name, grid), on_half_spaces(grid)
    bound = np.zeros((grid.n_x, grid.n_s))
    bound[1:-1] = random.uniform(50.0, 150.0, (grid.n_x - 2, grid.n_s))
    for hole in holes:
        bound[hole] = 0.0
    edge = LeadingEdge.find(bound, motion.depth)
    own = operator(np.ones((grid.n_x, grid.n_s, 2)) * (np.arange(grid.n_x) == 3)[:, None, None])[3, 0, 0]
    scale = 1 / own * (1 if name == "shift" else grid.dx)
    q = random.normal(size=(np.count_nonzero(edge.free), 2)) * 60
    slip = random.normal(size=(grid.n_x, grid.n_s, 2)) * 60 / scale
    slip[: grid.n_x // 2] *= 0.02  # there most elements stick
    law = Law(motion, scale, edge.free, q, bound[edge.free][:, None], slip, sticking=sticking)
    assert sticking or 2 < np.count_nonzero(law.stick) < len(law.stick) - 2

    def derivative(v):
        p = np.zeros((grid.n_x, grid.n_s, 2))
        p[edge.free] = v.reshape(-1, 2)
        return law.derivative(v.reshape(-1, 2), motion.elastic_slip(operator(edge.spread(p)))).ravel()

    return law, edge, operator, derivative


@pytest.mark.parametrize("holes", [(), ((4, 0),)], ids=["whole", "with a hole"])
@pytest.mark.parametrize("name", MOTIONS)
def test_on_one_strip_it_is_the_inverse_but_for_what_couples_x_with_s(name, holes):
    law, edge, operator, derivative = law_at_random(name, Grid(14, 1, 0.4, 0.5), holes)
    matrix = np.stack([derivative(unit) for unit in np.eye(2 * len(law.q))], axis=1)
    for i in range(2):
        matrix[i::2, 1 - i :: 2] = 0.0
    inverse = StripInverse(Strips.on_half_spaces(operator, law.motion), law, edge)
    for v in np.random.default_rng(1).normal(size=(3, 2 * len(law.q))):
        expected = np.linalg.solve(matrix, v)
        result = inverse(v.reshape(-1, 2)).ravel()
        np.testing.assert_allclose(result, expected, atol=1e-4 * np.max(np.abs(expected)))  # single precision


@pytest.mark.parametrize("name", MOTIONS)
def test_waves_over_all_strips_are_accounted_for(name):
    """Where all stick: far fewer products are needed than with each strip alone."""
    law, edge, operator, derivative = law_at_random(name, Grid(16, 12, 0.4, 0.4), sticking=True)
    size, strips = 2 * len(law.q), Strips.on_half_spaces(operator, law.motion)
    b = np.random.default_rng(2).normal(size=size)

    def products(inverse):
        count = []
        counted, approximate = (
            LinearOperator((size, size), matvec=matvec, dtype=float)
            for matvec in (
                lambda v: count.append(1) or derivative(v),
                lambda v: inverse(v.reshape(-1, 2)).ravel(),
            )
        )
        x, failed = gmres(counted, b, M=approximate, rtol=1e-5, restart=size)
        assert not failed
        np.testing.assert_allclose(derivative(x), b, atol=1e-3 * np.max(np.abs(b)))
        return len(count)

    both, alone = strips, replace(strips, alone=lambda slip: slip)
    assert products(StripInverse(both, law, edge)) < 0.75 * products(StripInverse(alone, law, edge))


@pytest.mark.parametrize("name", MOTIONS)
def test_a_contact_at_the_ends_of_the_grid_has_finite_tractions(name):
    """In steady rolling the last element has no slip of its own there."""
    grid = Grid(8, 3, 0.4, 0.5)
    motion, operator, bound = motion_of(name, grid), on_half_spaces(grid), np.full((8, 3), 100.0)
    edge = LeadingEdge.find(bound, 0)
    q, slip = np.zeros((24, 2)), np.ones((8, 3, 2))
    law = Law(motion, 1.0, edge.free, q, bound[edge.free][:, None], slip, sticking=True)
    result = StripInverse(Strips.on_half_spaces(operator, motion), law, edge)(np.ones((24, 2)))
    assert np.all(np.isfinite(result))
    assert np.max(np.abs(result)) > 0


def test_without_free_elements_there_is_nothing_to_invert():
    grid = Grid(4, 3, 0.4, 0.5)
    motion, bound = motion_of("shift", grid), np.zeros((4, 3))
    edge = LeadingEdge.find(bound, 0)
    law = Law(motion, 1.0, edge.free, np.zeros((0, 2)), np.zeros((0, 1)), np.zeros((4, 3, 2)))
    inverse = StripInverse(Strips.on_half_spaces(on_half_spaces(grid), motion), law, edge)
    assert inverse(np.zeros((0, 2))).shape == (0, 2)
