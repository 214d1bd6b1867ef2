"""Pressures and tangential tractions together: a semismooth Newton method for a contact with friction.

The unknowns are pressures, tangential tractions, amplitudes of free slips and, where a load is given, the
approach. Each step decides which elements are in contact (those with pressure or overlap) and which of these
stick (`femic.contact.friction.law`), makes gaps, law, forces and load linear there, and solves all of them by
GMRES. Its preconditioner takes pressures from gaps (on a ring of half-spaces), then tangential tractions from
the law (`StripInverse`) at the bounds of these pressures. It is the method of Alart and Curnier (1991),
Computer Methods in Applied Mechanics and Engineering 92, 353-375; for the contact area see Hintermueller, Ito
and Kunisch (2003), SIAM Journal on Optimization 13, 865-888. Steps are full ones, so it should begin near the
contact, and may not find it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from femic.contact.compiled import LEAST_PRESSURE, SHARPER, TINY
from femic.contact.friction.law import (
    LOOSEST,
    Law,
    StripInverse,
    correction,
    inverse_of_amplitudes,
    stagnated,
)
from femic.contact.friction.motion import LeadingEdge, Linear, Motion
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.small import Guess
from geometries.arrays import Array, Mask
from geometries.patches import N

MOST_STEPS = 20
MOST_IDLE_STEPS = 5  # in which the error does not fall below the least one before


@dataclass(frozen=True, eq=False)
class Coupled:
    """A contact with friction after a motion, under a load or at an approach."""

    problem: FrictionalProblem
    motion: Motion
    loading: Loading

    @cached_property
    def self_compliance(self) -> tuple[float, float]:
        """Gap [mm] and slip of an element due to its own pressure and tangential traction, per MPa."""
        middle = tuple(n // 2 for n in self.problem.distance.shape)
        unit = np.zeros((*self.problem.distance.shape, 3))
        unit[middle] = 1.0
        pressed, sheared = (self.problem.operator(unit * part) for part in ([0, 0, 1.0], [1.0, 1.0, 0]))
        return float(pressed[middle][N]), float(np.mean(self.motion.elastic_slip(sheared[..., :N])[middle]))

    @cached_property
    def cosine(self) -> Array:
        """Gap that a vertical approach closes, shape (n_x, n_s)."""
        return np.broadcast_to(np.cos(self.problem.inclination), self.problem.distance.shape)

    @cached_property
    def modes(self) -> Array:
        """Slips (k, n_x, n_s, 2) per unit of what is unknown besides tractions.

        These are the amplitudes, and the approach in units of pressure where a load is given.
        """
        if self.loading.load is None:
            return self.motion.free_slips
        per_approach = self.motion.given_at(1.0) - self.motion.given_at(0.0)
        return np.concatenate([self.motion.free_slips, self.self_compliance[0] * per_approach[None]])

    @cached_property
    def weights(self) -> Array:
        """What tractions contribute to the forces in question, the load last, (k, n_x, n_s, 3) [mm^2]."""
        weights = [free.weights for free in self.motion.free]
        if self.loading.load is not None:
            sine = np.broadcast_to(np.sin(self.problem.inclination), self.cosine.shape)
            weights.append(self.problem.grid.area * np.stack([0 * sine, -sine, self.cosine], axis=-1))
        return np.reshape(weights, (len(weights), *self.cosine.shape, 3))

    @cached_property
    def targets(self) -> Array:
        """The forces that are given, shape (k,) [N]."""
        load = [] if self.loading.load is None else [self.loading.load]
        return np.array([*(free.force for free in self.motion.free), *load])

    def split(self, unknowns: Array) -> tuple[Array, float]:
        """Return amplitudes and approach [mm] from all unknowns besides tractions."""
        if self.loading.load is None:
            return unknowns, 0.0
        return unknowns[:-1], float(unknowns[-1]) * self.self_compliance[0]


@dataclass(frozen=True, eq=False)
class State:
    """Tractions p and displacements u (n_x, n_s, 3), amplitudes c, approach, and the linear equations there.

    `bound` (n_x, n_s) [MPa] is that of tangential tractions, `edge` the leading edge. Unknowns are changes of
    pressures, free tractions and all else: one vector, of sizes a for elements in contact, 2 m for free ones,
    and k. Residuals have the same order, and the unit of tractions.
    """

    coupled: Coupled
    p: Array
    u: Array
    c: Array
    approach: float
    bound: Array
    edge: LeadingEdge

    @classmethod
    def from_guess(cls, coupled: Coupled, guess: Guess) -> "State":
        """Return the state of a guess, without negative pressures and tractions outside contact.

        Elements with overlap join, with little pressure; those of a leading edge follow others.
        """
        pressures = np.maximum(guess.p[..., N], 0.0)
        state = cls._in_contact(
            coupled, guess, np.where(np.isfinite(coupled.problem.distance), pressures, 0.0)
        )
        overlaps = ~state.contact & (state.gap < 0)
        if not np.any(overlaps):
            return state
        joined = np.where(overlaps, LEAST_PRESSURE * np.max(pressures), state.p[..., N])
        return cls._in_contact(coupled, guess, joined)

    @classmethod
    def _in_contact(cls, coupled: Coupled, guess: Guess, pressures: Array) -> "State":
        bound = coupled.problem.bound(pressures)
        edge = LeadingEdge.find(bound, coupled.motion.depth)
        p = np.concatenate([edge.spread(guess.p[..., :N]), pressures[..., None]], axis=-1)
        u, given = coupled.problem.operator(p), coupled.loading.approach
        approach = guess.approach if given is None else given
        return cls(coupled, p, u, guess.amplitudes, approach, bound, edge)

    @cached_property
    def contact(self) -> Mask:
        """The elements in contact, shape (n_x, n_s)."""
        return np.asarray(self.p[..., N] > 0)

    @cached_property
    def gap(self) -> Array:
        """Gaps [mm], shape (n_x, n_s)."""
        coupled = self.coupled
        return np.asarray(self.u[..., N] + coupled.problem.distance - self.approach * coupled.cosine)

    @cached_property
    def law(self) -> Law:
        """The law of friction."""
        motion, free = self.coupled.motion, self.edge.free
        slip = motion.elastic_slip(self.u[..., :N]) + motion.given_at(self.approach)
        slip = slip + np.tensordot(self.c, motion.free_slips, 1)
        q, g = self.p[free][:, :N], self.bound[free][:, None]
        return Law(motion, 1 / self.coupled.self_compliance[1], free, q, g, slip)

    @cached_property
    def residual(self) -> Array:
        """What a step should remove."""
        gaps = self.gap[self.contact] / self.coupled.self_compliance[0]
        missing = self.sums(self.p) - self.coupled.targets / self.unit_forces
        return np.concatenate([gaps, self.law.residual.ravel(), missing])

    @cached_property
    def unit_forces(self) -> Array:
        """Forces (k,) of tractions of 1 MPa."""
        return np.sum(np.abs(self.coupled.weights[:, self.contact]), axis=(1, 2))

    def sums(self, p: Array) -> Array:
        """Return the forces of tractions (n_x, n_s, 3), shape (k,), in units of tractions."""
        return np.asarray(np.tensordot(self.coupled.weights, p, 3) / self.unit_forces)

    def parts(self, v: Array) -> tuple[Array, Array, Array]:
        """Return the parts of a vector: (a,), (m, 2) and (k,)."""
        a, k = np.count_nonzero(self.contact), len(self.coupled.targets)
        return v[:a], v[a : len(v) - k].reshape(-1, 2), v[len(v) - k :]

    def tractions(self, pressures: Array, q: Array) -> tuple[Array, Array]:
        """Return changes of all tractions (n_x, n_s, 3), and of bounds (n_x, n_s), from (a,) and (m, 2)."""
        p, edge = np.zeros((*self.contact.shape, 3)), self.edge
        p[self.contact, N] = pressures
        p[edge.free, :N] = q
        bound = self.coupled.problem.bound(p[..., N])
        followers = bound - edge.ratio * np.take_along_axis(bound, edge.followed, axis=0)
        p[..., :N] = edge.spread(p[..., :N]) + self.bound_shares * followers[..., None]
        return p, bound

    @cached_property
    def bound_shares(self) -> Array:
        """Tangential tractions as shares of bounds, (n_x, n_s, 2), 0 where there are none."""
        tangential, bound = self.p[..., :N], self.bound[..., None]
        return np.divide(tangential, bound, out=np.zeros_like(tangential), where=bound > 0)

    def derivative(self, v: Array) -> Array:
        """Return the change of residuals."""
        pressures, q, others = self.parts(v)
        coupled, law = self.coupled, self.law
        p, bound = self.tractions(pressures, q)
        u = coupled.problem.operator(p)
        slip = coupled.motion.elastic_slip(u[..., :N]) + np.tensordot(others, coupled.modes, 1)
        gaps = u[..., N] - coupled.split(others)[1] * coupled.cosine
        law_change = law.derivative(q, slip, bound[law.free][:, None])
        return np.concatenate(
            [gaps[self.contact] / coupled.self_compliance[0], law_change.ravel(), self.sums(p)]
        )

    def inverse(self, v: Array) -> Array:
        """Return approximately the unknowns that change the residuals by a vector."""
        gap_residuals, law_residuals, force_residuals = self.parts(v)
        pressures, q = self.inner(gap_residuals, law_residuals)
        others = self.schur_inverse @ (force_residuals - self.sums(self.tractions(pressures, q)[0]))
        for amount, (column_pressures, column_q) in zip(others, self.columns, strict=True):
            pressures, q = pressures - amount * column_pressures, q - amount * column_q
        return np.concatenate([pressures, q.ravel(), others])

    def inner(self, gap_residuals: Array, law_residuals: Array) -> tuple[Array, Array]:
        """Return pressures (a,) and tractions (m, 2) for residuals of gaps and of the law."""
        gaps = np.zeros((*self.contact.shape, 1))
        gaps[self.contact, 0] = gap_residuals * self.coupled.self_compliance[0]
        pressures = self.coupled.problem.ring_inverse(gaps)[..., 0]
        law = self.law
        bound = self.coupled.problem.bound(pressures)[law.free][:, None]
        slides = np.where(law.stick[:, None], 0.0, bound * law.direction)
        return pressures[self.contact], self.law_preconditioner(law_residuals + slides)

    @cached_property
    def law_preconditioner(self) -> Linear:
        """The approximate inverse of the law."""
        strips = self.coupled.problem.strips(self.coupled.motion)
        return StripInverse(strips, self.law, self.edge)

    @cached_property
    def columns(self) -> list[tuple[Array, Array]]:
        """Tractions that undo the residuals of unit values of all else."""
        coupled, law = self.coupled, self.law
        columns = []
        for mode, unit in zip(coupled.modes, np.eye(len(coupled.modes)), strict=True):
            gaps = -coupled.split(unit)[1] * coupled.cosine[self.contact] / coupled.self_compliance[0]
            columns.append(self.inner(gaps, law.derivative(np.zeros_like(law.q), mode)))
        return columns

    @cached_property
    def schur_inverse(self) -> Array:
        """The inverse of how all else changes forces, (k, k), where it does."""
        return inverse_of_amplitudes([self.sums(self.tractions(*column)[0]) for column in self.columns])

    @cached_property
    def error(self) -> float:
        """Largest estimated error of pressures and load over the largest pressure, or of others over limits.

        Tangential tractions, and forces that they balance, are compared with the largest friction bound, if
        this is less. Forces are in units of tractions.
        """
        pressures, q, _ = self.parts(self.inverse(self.residual))
        missing = self.parts(self.residual)[-1]
        free, (peak, limit) = len(self.c), self.coupled.problem.scales(self.p[..., N])
        scaled = ((pressures, peak), (missing[free:], peak), (q, limit), (missing[:free], limit))
        return max(float(np.max(np.abs(part), initial=0.0)) / max(scale, TINY) for part, scale in scaled)

    def newton_update(self, tolerance: float) -> Guess:
        """Return what the solution of the equations leads to."""
        reduction = max(SHARPER * tolerance / self.error, self.error)
        solution = correction(self.residual, self.derivative, self.inverse, min(LOOSEST, reduction))
        pressures, q, others = self.parts(solution)
        amplitudes, approach = self.coupled.split(others)
        p = self.p + self.tractions(pressures, q)[0]
        return Guess(p, self.c + amplitudes, self.approach + approach)


def solve(coupled: Coupled, guess: Guess, tolerance: float) -> State | None:
    """Return the contact, its `State.error` at most `SHARPER` times a tolerance, or None if not found."""
    errors: list[float] = []
    while len(errors) <= MOST_STEPS and not stagnated(errors, MOST_IDLE_STEPS):
        state = State.from_guess(coupled, guess)
        if not np.any(state.contact):
            return None
        errors.append(state.error)
        if state.error <= SHARPER * tolerance:
            return state
        guess = state.newton_update(tolerance)
    return None
