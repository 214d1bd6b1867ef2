"""Contact of two coupled bodies: the linear problem of a given contact area, and this area by an active set.

With a given contact area, displacements, pressures and approach follow from

    K_l u_l + B_l^T p = 0,   K_u u_u - B_u^T p = 0,   B_l u_l - B_u u_u + c zeta = h,   c.p = N

on the vertices in contact. It is symmetric and indefinite: MINRES, with a block diagonal preconditioner of
one multigrid cycle per body; the inverse of the compliance of the surface, which is about the square root of
a Laplacian; and a stiffness for the approach. Source: Elman, Silvester and Wathen (2014), Finite Elements and
Fast Iterative Solvers, chapter 4.

Which vertices are in contact is found by a primal-dual active set, a semismooth Newton method. Source:
Hintermueller, Ito and Kunisch (2003), SIAM Journal on Optimization 13, 865-888. Each step solves a linear
problem; vertices with tension leave, vertices with penetration join. Problems are solved roughly as long as
many do.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, minres

from femic.cache.workers import one_blas_thread
from femic.contact.finite_elements.coupling import CoupledBodies
from femic.reference.job import NotConverged
from geometries.arrays import Array, Mask

# --- given contact area ---

MOST_ITERATIONS, MOST_AT_ONCE = 1000, 300
SCIPY_S = 1 / 30  # SciPy's measure of residuals over ours, about


@dataclass(frozen=True, eq=False)
class State:
    """Displacements of both bodies [mm], pressures (m,) [MPa] and approach [mm]."""

    u_lower: Array
    u_upper: Array
    p: Array
    approach: float


def solve(
    pair: CoupledBodies, active: Mask, load: float, start: State, tolerance: float
) -> tuple[State, int]:
    """Return the state in contact at `active` vertices under a load [N], and the number of iterations.

    `tolerance` bounds the residual over the right-hand side, both in the norm of the preconditioner, which
    is about that of energy. Raises NotConverged where it is not met in `MOST_ITERATIONS` iterations.
    """
    ends = np.cumsum([pair.lower.unknowns, pair.upper.unknowns, np.count_nonzero(active)])
    matrix, preconditioner = _operators(pair, active, ends)
    right_side = np.zeros(matrix.shape[0])
    right_side[-1 - np.count_nonzero(active) : -1] = pair.h[active]
    right_side[-1] = load
    vector = np.concatenate([start.u_lower, start.u_upper, start.p[active], [start.approach]])
    steps: list[None] = []
    with one_blas_thread():
        bound = tolerance * _size(preconditioner, right_side)
        residual = right_side - matrix.matvec(vector)
        while _size(preconditioner, residual) > bound:  # SciPy stops by another measure
            if len(steps) >= MOST_ITERATIONS:
                reached = _size(preconditioner, residual) / bound * tolerance
                raise NotConverged(
                    f"contact of meshed bodies: relative residual {reached:.1e} after {MOST_ITERATIONS} "
                    f"iterations, {tolerance:.0e} specified. Likely cause: a Poisson's ratio near 0.5, or "
                    "slender bodies. Try thicker bodies or another number of `cells`"
                )
            correction, _ = minres(
                matrix,
                residual,
                M=preconditioner,
                rtol=SCIPY_S * tolerance,
                maxiter=MOST_AT_ONCE,
                callback=lambda _: steps.append(None),
            )
            vector = vector + correction
            residual = right_side - matrix.matvec(vector)
    u_lower, u_upper, p_active, approach = np.split(vector, ends)
    p = np.zeros(len(active))
    p[active] = p_active
    return State(u_lower, u_upper, p, float(approach[0])), len(steps)


def _size(preconditioner: LinearOperator, residual: Array) -> float:
    """Return the norm of a residual."""
    return float(np.sqrt(residual @ preconditioner.matvec(residual)))


def _operators(pair: CoupledBodies, active: Mask, ends: Array) -> tuple[LinearOperator, LinearOperator]:
    """Return the matrix of the linear problem and its preconditioner, of unknowns in parts with `ends`."""
    lower, upper = pair.lower, pair.upper
    B_l, B_u, c = pair.B_lower[active], pair.B_upper[active], pair.c[active]
    B_l_T, B_u_T = B_l.T.tocsr(), B_u.T.tocsr()
    inverse = pair.roughness[np.ix_(active, active)]
    stiffness = float(c @ inverse @ c)
    n = ends[-1] + 1

    def multiplied(v: Array) -> Array:
        u_l, u_u, p, zeta = np.split(v, ends)
        return np.concatenate(
            [
                lower.matrix @ u_l + B_l_T @ p,
                upper.matrix @ u_u - B_u_T @ p,
                B_l @ u_l - B_u @ u_u + c * zeta,
                [c @ p],
            ]
        )

    def preconditioned(v: Array) -> Array:
        r_l, r_u, r_p, r_zeta = np.split(v, ends)
        return np.concatenate(
            [lower.preconditioner @ r_l, upper.preconditioner @ r_u, inverse @ r_p, r_zeta / stiffness]
        )

    matrix = LinearOperator((n, n), matvec=multiplied, dtype=float)
    return matrix, LinearOperator((n, n), matvec=preconditioned, dtype=float)


# --- active set ---

MOST_STEPS = 40
ROUGH, FINE = 1e-3, 1e-6  # relative residuals of linear problems
NEARLY = 0.03  # share of the vertices in contact that change, below which linear problems are solved finely
TENSION, PENETRATION = 1e-5, 1e-5  # that count as none: of the largest pressure, and of the approach


@dataclass(frozen=True, eq=False)
class ActiveSetSolution:
    """A contact whose area does not change any more."""

    state: State
    active: Mask  # (m,)
    steps: int
    iterations: int
    tension: float  # largest, as a share of the largest pressure
    penetration: float  # largest mean over a hat function, as a share of the approach


def solve_active_set(pair: CoupledBodies, load: float, active: Mask) -> ActiveSetSolution:
    """Return the contact under a load [N] on the model, from rest and a guess of the vertices in contact.

    Raises NotConverged where the area still changes after `MOST_STEPS` steps.
    """
    u_lower, u_upper = np.zeros(pair.lower.unknowns), np.zeros(pair.upper.unknowns)
    state, iterations, fine = State(u_lower, u_upper, np.zeros(len(active)), 0.0), 0, False
    for step in range(1, MOST_STEPS + 1):
        state, used = solve(pair, active, load, state, FINE if fine else ROUGH)
        iterations += used
        tension = np.where(active, -state.p / max(float(np.max(np.abs(state.p))), 1e-300), 0.0)
        gap = pair.gap(state.u_lower, state.u_upper, state.approach) / pair.area
        penetration = np.where(active, 0.0, -gap / max(abs(state.approach), 1e-300))
        leaving, joining = tension > TENSION, penetration > PENETRATION
        changes = int(np.count_nonzero(leaving | joining))
        if fine and not changes:
            largest = (max(0.0, float(violation.max())) for violation in (tension, penetration))
            return ActiveSetSolution(state, active, step, iterations, *largest)
        active = (active & ~leaving) | joining
        fine = bool(changes <= NEARLY * np.count_nonzero(active))
    raise NotConverged(
        f"contact of meshed bodies: {changes} of {np.count_nonzero(active)} vertices in contact still change "
        f"after {MOST_STEPS} steps (tension {tension.max():.1e} of the largest pressure, penetration "
        f"{penetration.max():.1e} of the approach). Try more `cells`, or begin with a smaller load"
    )
