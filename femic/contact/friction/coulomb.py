"""Coulomb's law on a grid, with given bounds of tangential tractions: a semismooth Newton method.

The unknowns are tractions p with |p| <= g on each element; the slip s = L p + w + B c vanishes where |p| < g,
and is opposite to p elsewhere. The steps are

1. it is decided which elements stick, and which slip (`Law`);
2. their equations are made linear, with those of the forces that determine free amplitudes c;
3. they are solved by GMRES, preconditioned by the same equations of strips on half-spaces (`StripInverse`);
4. the step is halved until the residual falls.

Near the solution it is Newton's method (Hintermueller, Ito and Kunisch 2003, SIAM Journal on Optimization 13,
865-888). L need not be symmetric: in steady rolling it is not.

Prescribed forces are first checked against friction. With bounds g of tractions |p|, weighted sums W p reach
the forces f if and only if c f <= sum g |c W| for all c. The least of sum g |c W| with c f = 1 is the factor
by which all the forces may grow. It is found by least squares with weights g / |c W| (Weiszfeld 1937, Tohoku
Mathematical Journal 43, 355-386); each c on the way gives a factor that is not too small.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from femic.contact.friction.law import LOOSEST, Law, Strips, correction, inverse_of_amplitudes, stagnated
from femic.contact.friction.motion import LeadingEdge, Linear, Motion
from geometries.arrays import Array, Mask
from geometries.errors import Failure

# --- tractions by Newton steps ---

TOLERANCE = 1e-6  # of tractions, as a share of the largest bound
SCALES = 1.0, 3.0  # of r, tried in turn: any will do, but steps to and fro with one may end with another
MOST_STEPS = 60
MOST_IDLE_STEPS = 15  # in which the residual does not fall below the least one before
LEAST_STEP = 0.05  # of a full step
DECREASE = 0.1  # of the residual, as a share of the step
FULL_STICK_RESIDUAL = 1e-6  # relative residual of the linear equations of full stick, far from a first guess


@dataclass(frozen=True, eq=False)
class FreeAmplitudes:
    """Amplitudes c of slips `modes`, unknowns like the tractions, with equations `weights` . p = `targets`.

    Shapes (k, n_x, n_s, 2), (k, n_x, n_s, 2) and (k,); k may be 0.
    """

    modes: Array
    weights: Array
    targets: Array


@dataclass(frozen=True, eq=False)
class Coulomb:
    """The problem: slip L p = `compliance`(p), w = `rigid` (n_x, n_s, 2), g = `bound` (n_x, n_s).

    `strips` say how half-spaces slip. Tractions at a leading edge follow those of other elements. Friction
    opposes the slip at the centres of elements, which `motion` finds from s; it vanishes where s does.
    """

    compliance: Linear
    strips: Strips
    rigid: Array
    bound: Array
    edge: LeadingEdge
    motion: Motion
    free: FreeAmplitudes


@dataclass(frozen=True, eq=False)
class Tangential:
    """Tractions and slip (n_x, n_s, 2), which elements stick, amplitudes c (k,), and the convergence.

    `residuals` are largest errors of a traction as shares of the largest bound, before each step.
    """

    p: Array
    slip: Array
    stick: Mask
    amplitudes: Array
    residuals: Sequence[float] = ()


def tractions(
    problem: Coulomb,
    *,
    start: Array | None = None,
    amplitudes: Array | None = None,
    tolerance: float = TOLERANCE,
) -> Tangential:
    """Solve for the tractions; `start` and `amplitudes` are those to begin with.

    Raises Failure, with the residuals, where `MOST_STEPS` do not suffice, and where friction
    cannot supply the prescribed forces.
    """
    free, mask = problem.free, problem.edge.free
    if len(free.targets):
        factor = attainable_factor(free.weights, problem.bound, free.targets)
        if factor <= 1:
            raise ForcesBeyondFriction(
                "prescribed forces exceed what friction can supply: together they may be no more than "
                f"{factor:.4g} times as large; use smaller forces, a larger load, or more friction"
            )
    q = np.zeros((np.count_nonzero(mask), 2)) if start is None else start[mask]
    c = np.zeros(len(free.targets)) if amplitudes is None else amplitudes
    middle = tuple(n // 2 for n in problem.bound.shape)
    unit = np.zeros(problem.rigid.shape)
    unit[middle] = 1.0
    self_compliance = float(np.mean(problem.compliance(unit)[middle]))
    residuals: list[float] = []
    for scale in SCALES:
        newton = _Newton(problem, scale / self_compliance)
        for state in newton.starts(newton.state(q, c), tolerance):
            if solution := newton.solution(state, tolerance, residuals):
                return solution
    last = ", ".join(f"{value:.1e}" for value in residuals[-4:])
    raise Failure(
        f"tangential tractions: after {len(residuals)} steps their residual is {residuals[-1]:.1e} of the "
        f"largest bound, not {tolerance:.1e} ({last}); use smaller elements, or smaller creepages"
    )


@dataclass(frozen=True, eq=False)
class _State:
    """Amplitudes c, L p + B c (n_x, n_s, 2), and the law at tractions of the free elements."""

    c: Array
    linear: Array
    law: Law
    force_residuals: Array  # (k,), in units of tractions

    @property
    def q(self) -> Array:
        """Tractions of the free elements, shape (m, 2)."""
        return self.law.q

    @cached_property
    def residual(self) -> Array:
        """Residuals, in units of tractions, shape (2 m + k,)."""
        return np.concatenate([self.law.residual.ravel(), self.force_residuals])

    @cached_property
    def defect(self) -> float:
        """Norm of the law's defects and the residuals of forces, continuous where elements begin to slip."""
        return float(np.hypot(np.linalg.norm(self.law.defect), np.linalg.norm(self.force_residuals)))

    @property
    def largest(self) -> float:
        """Largest residual as a share of the largest bound."""
        return float(np.max(np.abs(self.residual), initial=0.0) / np.max(self.law.g, initial=1e-300))


@dataclass(frozen=True, eq=False)
class _Newton:
    problem: Coulomb
    scale: float  # r

    @cached_property
    def g(self) -> Array:
        """The bounds of free elements, shape (m, 1)."""
        return self.problem.bound[self.problem.edge.free][:, None]

    def starts(self, given: _State, tolerance: float) -> Iterator[_State]:
        """States to begin with: the given one, and, where forces are given, that of full stick.

        Where all elements slip in one direction, amplitudes do not change the forces, and no step leads on.
        """
        if not len(given.c) or np.any(given.law.stick) or given.largest <= LOOSEST:
            yield given
        if not len(given.c):
            return
        all_stick = replace(given, law=replace(given.law, sticking=True))
        dq, dc = self.step(all_stick, tolerance, FULL_STICK_RESIDUAL)
        q = given.q + dq
        size = np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-300)
        yield self.state(q * np.minimum(1.0, self.g / size), given.c + dc)

    def solution(self, state: _State, tolerance: float, residuals: list[float]) -> Tangential | None:
        """Return the tractions, None where steps do not lead to them; the residuals go to a list."""
        before = len(residuals)
        while len(residuals) - before <= MOST_STEPS and not stagnated(residuals[before:], MOST_IDLE_STEPS):
            residuals.append(state.largest)
            if state.largest <= tolerance:
                stick = self.problem.edge.with_followers(state.law.stick)
                return Tangential(self.spread(state.q), state.law.centred, stick, state.c, residuals)
            state = self.next(state, tolerance)
        return None

    def spread(self, q: Array) -> Array:
        """Return tractions of all elements (n_x, n_s, 2) from those of the free ones (m, 2)."""
        p = np.zeros(self.problem.rigid.shape)
        p[self.problem.edge.free] = q
        return self.problem.edge.spread(p)

    def slip(self, q: Array, c: Array) -> Array:
        """L p + B c, shape (n_x, n_s, 2)."""
        by_tractions = self.problem.compliance(self.spread(q))
        return np.asarray(by_tractions + np.tensordot(c, self.problem.free.modes, 1))

    def state(self, q: Array, c: Array, linear: Array | None = None) -> _State:
        """Return the state of tractions and amplitudes."""
        linear = self.slip(q, c) if linear is None else linear
        problem = self.problem
        law = Law(problem.motion, self.scale, problem.edge.free, q, self.g, linear + problem.rigid)
        return _State(c, linear, law, self.forces(q) - problem.free.targets / self.sums)

    def forces(self, q: Array) -> Array:
        """Weighted sums of tractions over those of the weights, shape (k,)."""
        return np.asarray(np.tensordot(self.problem.free.weights, self.spread(q), 3) / self.sums)

    @cached_property
    def sums(self) -> Array:
        """Sums of the weights in contact, shape (k,)."""
        return np.asarray(np.sum(np.abs(self.problem.free.weights)[:, self.problem.bound > 0], axis=(1, 2)))

    def next(self, state: _State, tolerance: float) -> _State:
        """Return the state after a step."""
        dq, dc = self.step(state, tolerance)
        change = self.slip(dq, dc)
        share = 1.0
        while True:
            candidate = self.state(state.q + share * dq, state.c + share * dc, state.linear + share * change)
            if candidate.defect <= (1 - DECREASE * share) * state.defect or share <= LEAST_STEP:
                return candidate
            share /= 2

    def step(self, state: _State, tolerance: float, loosest: float = LOOSEST) -> tuple[Array, Array]:
        """Return the solution of the linear equations."""
        problem, law, m = self.problem, state.law, len(state.q)
        strip_inverse, none = problem.strips.inverse(law, problem.edge), np.zeros_like(law.q)
        modes = problem.free.modes
        columns = np.reshape(  # tractions that undo the residuals of unit amplitudes
            [strip_inverse(law.derivative(none, mode)) for mode in modes], (len(modes), m, 2)
        )
        schur_inverse = inverse_of_amplitudes([self.forces(column) for column in columns])

        def derivative(v: Array) -> Array:
            q, c = v[: 2 * m].reshape(m, 2), v[2 * m :]
            return np.concatenate([law.derivative(q, self.slip(q, c)).ravel(), self.forces(q)])

        def inverse(v: Array) -> Array:
            q = strip_inverse(v[: 2 * m].reshape(m, 2))
            c = schur_inverse @ (v[2 * m :] - self.forces(q))
            return np.concatenate([(q - np.tensordot(c, columns, 1)).ravel(), c])

        reduction = tolerance / max(state.largest, 1e-300)
        enough = min(loosest, max(0.1 * reduction, min(LOOSEST, state.largest)))
        solution = correction(state.residual, derivative, inverse, enough)
        return solution[: 2 * m].reshape(m, 2), solution[2 * m :]


# --- whether friction can supply the forces ---

STEPS = 50
SMALLEST = 1e-9  # of |c W|, and of eigenvalues, as shares of the largest


class ForcesBeyondFriction(Failure):
    """Prescribed forces that no tractions within the bounds of friction supply."""


def attainable_factor(weights: Array, bound: Array, targets: Array) -> float:
    """Return the factor by which forces `targets` (k,) may grow within bounds (n_x, n_s) of tractions.

    The forces are the sums of weights (k, n_x, n_s, 2) times tractions. Infinite for none, 0 where there are
    no tractions.
    """
    loaded = bound > 0
    largest = np.sum(bound * np.linalg.norm(weights, axis=-1), axis=(1, 2))
    if not np.all(largest > 0):
        return 0.0
    if not np.any(targets):
        return np.inf
    contributions = np.moveaxis(weights[:, loaded], 0, -1) / largest  # (m, 2, k)
    shares, g = targets / largest, bound[loaded]  # forces as shares of their largest
    c, least = shares / (shares @ shares), np.inf
    for _ in range(STEPS):
        size = np.linalg.norm(contributions @ c, axis=1)
        least = min(least, float(g @ size))
        each = g / np.maximum(size, max(SMALLEST * float(np.max(size)), 1e-300))
        matrix = np.einsum("e,eik,eil->kl", each, contributions, contributions)
        matrix += SMALLEST * np.trace(matrix) * np.eye(len(c))
        c = np.linalg.solve(matrix, shares)
        c /= shares @ c
    return least
