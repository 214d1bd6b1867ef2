"""Conjugate gradients for contact pressures: a quadratic energy with bounds, for given approach or load.

Wanted are pressures p >= 0 with gaps g = S p + h - zeta c >= 0 and p g = 0: the minimum of p S p / 2 + h p
where the load, the sum of c p, is given (zeta is its multiplier), or of p S p / 2 + (h - zeta c) p. The
method is that of Polonsky and Keer (1999), Wear 231, 206-219, preconditioned as by Vollebregt (2014), Journal
of Computational Physics 257, 333-351. Elements with overlap join at once, with the next direction, and where
the load is given, directions do not change it.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array, Mask
from geometries.errors import Failure

TOLERANCE = 1e-7  # of pressures, as a share of the largest
MOST_ITERATIONS = 500

Linear = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Bounded:
    """The problem: S and its approximate inverse on the whole grid, h and c, shape (n_x, n_s) each.

    h is infinite where no contact is possible.
    """

    compliance: Linear
    inverse: Linear
    h: Array
    c: Array


@dataclass(frozen=True, eq=False)
class PressureSolution:
    """Pressures and gaps, shape (n_x, n_s), the approach, and how they were found.

    `error` is the largest estimated error of a pressure as a share of the largest pressure.
    """

    p: Array
    gap: Array
    approach: float
    iterations: int
    products: int
    error: float


def pressures(
    problem: Bounded,
    *,
    load: float | None = None,
    approach: float | None = None,
    start: Array | None = None,
    tolerance: float = TOLERANCE,
) -> PressureSolution:
    """Solve for a given load, the sum of c p [MPa], or for a given approach [mm].

    `start` are pressures to begin with. Raises Failure where S is not positive for the pressures in question,
    and where `MOST_ITERATIONS` do not suffice. A load must be positive, and h finite somewhere.
    """
    if (load is None) == (approach is None):
        raise ValueError("give either load or approach")
    state = _State.first(problem, load, approach, start)
    direction = np.zeros_like(problem.h)
    last_z, last_residual, last_active = direction, direction, np.zeros(direction.shape, bool)
    for iteration in range(MOST_ITERATIONS + 1):
        gap = state.gap
        active = state.possible & ((state.p > 0) | (gap < 0))
        residual = np.where(active, gap, 0.0)
        z = state.inverted(residual, active)
        error = _share(z, state.p)
        if error <= tolerance:
            return PressureSolution(state.p, gap, state.approach, iteration, state.products, error)
        beta = 0.0
        if np.array_equal(active, last_active):
            beta = max(0.0, _dot(z, residual - last_residual) / _dot(last_z, last_residual))
        direction = z + beta * direction
        state = state.moved(direction, _dot(residual, direction))
        last_z, last_residual, last_active = z, residual, active
    raise Failure(
        f"pressures: after {MOST_ITERATIONS} iterations their error is estimated at {error:.1e} of the "
        f"largest, not {tolerance:.1e}; use smaller elements or a smaller potential contact area"
    )


@dataclass(frozen=True, eq=False)
class _State:
    """Pressures and their displacements S p."""

    problem: Bounded
    load: float | None
    fixed_approach: float | None
    p: Array
    u: Array
    products: int

    @classmethod
    def first(
        cls, problem: Bounded, load: float | None, approach: float | None, start: Array | None
    ) -> "_State":
        """Return the first state: `start`, or, if it has no pressures, those that overlaps ask for."""
        possible = np.isfinite(problem.h)
        p = np.zeros(problem.h.shape) if start is None else np.where(possible, np.maximum(start, 0), 0.0)
        if not np.any(p) and approach is not None:
            overlap = np.where(possible, np.maximum(approach * problem.c - problem.h, 0), 0.0)
            p = np.where(possible, np.maximum(problem.inverse(overlap), 0), 0.0)
        elif not np.any(p):
            p = np.where(possible, 1.0, 0.0)
        return cls(problem, load, approach, p, p, 0)._with(p)

    @property
    def possible(self) -> Mask:
        """Where contact is possible."""
        return np.isfinite(self.problem.h)

    @property
    def approach(self) -> float:
        """The approach: given, or that with which the gaps in contact have no component along c."""
        if self.fixed_approach is not None:
            return self.fixed_approach
        c = np.where(self.p > 0, self.problem.c, 0.0)
        h = np.where(self.p > 0, self.problem.h, 0.0)
        return float(np.vdot(c, self.u + h) / np.vdot(c, c))

    @property
    def gap(self) -> Array:
        """Gaps with the approach."""
        return np.asarray(self.u + self.problem.h - self.approach * self.problem.c)

    def inverted(self, residual: Array, active: Mask) -> Array:
        """Return the preconditioned residual in contact, which does not change a load that is given."""
        z = np.where(active, self.problem.inverse(residual), 0.0)
        if self.load is None:
            return z
        c = np.where(active, self.problem.c, 0.0)
        of_c = np.where(active, self.problem.inverse(c), 0.0)
        return np.asarray(z - of_c * (np.vdot(c, z) / np.vdot(c, of_c)))

    def moved(self, direction: Array, slope: float) -> "_State":
        """Return the state of least energy along a direction, without negative pressures."""
        v = self.problem.compliance(direction)
        curvature = float(np.vdot(direction, v))
        if not curvature > 0:
            raise Failure(
                "pressures: the ICs are not positive for pressures that the contact needs "
                f"(p S p = {curvature:.2e} mm MPa); check their eigenvalues"
            )
        p = self.p - slope / curvature * direction
        if np.any(p < 0):
            return self._with(np.maximum(p, 0), products=self.products + 1)
        u = self.u - slope / curvature * v
        return _State(self.problem, self.load, self.fixed_approach, p, u, self.products + 1)

    def _with(self, p: Array, products: int = 0) -> "_State":
        """Return the state of other pressures, scaled to the load."""
        if self.load is not None:
            p = p * (self.load / np.vdot(self.problem.c, p))
        u = self.problem.compliance(p)
        return _State(self.problem, self.load, self.fixed_approach, p, u, products + 1)


def _dot(left: Array, right: Array) -> float:
    return float(np.vdot(left, right))


def _share(z: Array, p: Array) -> float:
    """Return largest |z| over the largest pressure; infinite where pressures are still to come."""
    largest, pressure = float(np.max(np.abs(z))), float(np.max(p))
    if largest == 0:
        return 0.0
    return largest / pressure if pressure > 0 else np.inf
