"""Coulomb's law on free elements as equations, their linear form, and its approximate inverse.

Tractions q with |q| <= g are the projection of q - r s onto the disc of radius g, for any r > 0, s the slip:
elements stick where |q - r s| <= g, with r s = 0, and slip elsewhere, with q = g (q - r s) / |q - r s| (Alart
and Curnier 1991, Computer Methods in Applied Mechanics and Engineering 92, 353-375).

The inverse of the linear form is exact within strips, and by waves between them. In a strip slip depends on
where rolling begins and on which elements stick, so that an inverse for the whole plane is a bad
approximation there. So the equations of each strip are solved directly, as on half-spaces without other
strips. These are accounted for before: slip where elements stick is changed, wave by wave on a ring, to that
which the same tractions cause with each strip alone. What couples x with s is left out.

Both Newton methods take their steps from here: that for pressures and tractions together
(`femic.contact.coupled`) and that for tractions (`femic.contact.friction.coulomb`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import toeplitz
from scipy.linalg.lapack import sgetrf, sgetrs
from scipy.sparse.linalg import LinearOperator, gmres

from femic.contact.friction.motion import LeadingEdge, Linear, Motion
from femic.contact.operators.convolution import Convolution, Waves
from geometries.arrays import Array, Indices, Mask

# --- the law and its linear form ---

TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Law:
    """The law at tractions `q` (m, 2) and bounds `g` (m, 1) of the elements in `free` (n_x, n_s).

    `slip` (n_x, n_s, 2) vanishes where elements stick; friction opposes the slip at their centres, which
    `motion` finds from it. `scale` is r. Elements in `sticking` stick whatever their bounds.
    """

    motion: Motion
    scale: float
    free: Mask
    q: Array
    g: Array
    slip: Array
    sticking: bool = False

    @cached_property
    def centred(self) -> Array:
        """Slip at the centres of elements, shape (n_x, n_s, 2)."""
        return self.motion.at_elements(self.slip)

    @cached_property
    def trial(self) -> Array:
        """Q - r s, shape (m, 2)."""
        return np.asarray(self.q - self.scale * self.centred[self.free])

    @cached_property
    def length(self) -> Array:
        """Length of it, shape (m, 1)."""
        return np.maximum(np.linalg.norm(self.trial, axis=1, keepdims=True), TINY)

    @cached_property
    def stick(self) -> Mask:
        """Which elements stick, shape (m,)."""
        return np.full(len(self.q), True) if self.sticking else np.ravel(self.length <= self.g)

    @cached_property
    def direction(self) -> Array:
        """Q - r s over its length, shape (m, 2)."""
        return self.trial / self.length

    @cached_property
    def share(self) -> Array:
        """G / |q - r s|, at most 1, shape (m, 1)."""
        return np.minimum(self.g / self.length, 1.0)

    @property
    def residual(self) -> Array:
        """What vanishes at a solution, in units of tractions, shape (m, 2)."""
        sticks = self.scale * self.slip[self.free]
        return np.where(self.stick[:, None], sticks, self.q - self.g * self.direction)

    @property
    def defect(self) -> Array:
        """Q less the projection of q - r s, continuous where elements begin to slip, shape (m, 2)."""
        return np.asarray(self.q - self.share * self.trial)

    @cached_property
    def at_elements(self) -> Linear:
        """The derivative of slip at centres by slip."""
        return self.motion.derivative_at_elements(self.slip)

    def derivative(self, q: Array, slip: Array, g: Array | float = 0.0) -> Array:
        """Return changes of the residual (m, 2) by those of q (m, 2), slip (n_x, n_s, 2) and g (m, 1)."""
        across = self.across(q - self.scale * self.at_elements(slip)[self.free])
        slides = q - self.share * across - g * self.direction
        return np.where(self.stick[:, None], self.scale * slip[self.free], slides)

    def across(self, values: Array) -> Array:
        """Return the part of values (m, 2) across the direction of tractions."""
        return np.asarray(values - self.direction * np.sum(self.direction * values, axis=1, keepdims=True))

    @property
    def coefficients(self) -> tuple[Array, Array, Array]:
        """Derivatives of both residuals of an element by its traction in the same direction, (m, 2) each.

        By the traction itself, by slip at the element, and by slip at the one behind it.
        """
        stick, across = self.stick[:, None], self.share * (1 - self.direction**2)
        even = (np.arange(len(self.slip)) % 2 == 0)[:, None, None]
        own, behind = np.zeros_like(self.q), np.zeros_like(self.q)  # parts of centred slip across tractions
        for i, unit in enumerate(np.eye(2)):
            by_even, by_odd = (
                self.at_elements(np.broadcast_to(mask * unit, self.slip.shape)) for mask in (even, ~even)
            )
            own[:, i] = self.across(np.where(even, by_even, by_odd)[self.free])[:, i]
            behind[:, i] = self.across(np.where(even, by_odd, by_even)[self.free])[:, i]
        return (
            np.where(stick, 0.0, 1 - across),
            self.scale * np.where(stick, 1.0, self.share * own),
            self.scale * np.where(stick, 0.0, self.share * behind),
        )


# --- approximate inverse by strips ---

Single = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Strips:
    """Slip (2, n_x, n_x) of elements of a strip due to unit tractions on others of it, along x and s.

    `behind` is that of the elements behind them, 0 for the first; `alone` changes slip of all strips to that
    with each of them alone. Single precision is enough.
    """

    slip: Single
    behind: Single
    alone: Waves

    @classmethod
    def on_half_spaces(cls, flat: Convolution, motion: Motion) -> "Strips":
        """Return those of half-spaces, whose ICs are `flat` in the directions x and s, in a motion."""
        kernels, n_x = flat.own_strip, flat.shape[0]
        u = [toeplitz(kernels[n_x - 1 :, i, i], kernels[n_x - 1 :: -1, i, i]) for i in range(2)]
        slip = np.moveaxis(motion.elastic_slip(np.stack(u, axis=-1)), -1, 0).astype(np.float32)
        slip[:, -1, -1] = slip[:, 0, 0]  # as if there were another element ahead of the last one
        behind = np.concatenate([np.zeros_like(slip[:, :1]), slip[:, :-1]], axis=1)
        return cls(slip, behind, flat.strips_alone)

    def inverse(self, law: Law, edge: LeadingEdge) -> "StripInverse":
        """Return the approximate inverse of the derivative of a law by tractions of free elements."""
        return StripInverse(self, law, edge)


@dataclass(frozen=True, eq=False)
class StripInverse:
    """The approximate inverse of the derivative of a law by tractions of free elements."""

    strips: Strips
    law: Law
    edge: LeadingEdge

    def __call__(self, residual: Array) -> Array:
        """Return tractions (m, 2) of free elements that cause a residual (m, 2)."""
        free, stick = self.law.free, self.law.stick[:, None]
        slip = np.zeros(self.law.slip.shape)
        slip[free] = np.where(stick, residual, 0.0)
        alone = np.where(stick, self.strips.alone(slip)[free], residual).astype(np.float32)
        result = np.empty_like(residual)
        for places, both in zip(self.places, self.factors, strict=True):
            for i, (factors, pivots) in enumerate(both):
                result[places, i], _ = sgetrs(factors, pivots, alone[places, i])
        return result

    @cached_property
    def places(self) -> Sequence[Indices]:
        """The free elements of each strip that has some, among all of them."""
        strip = np.nonzero(self.law.free)[1]
        order = np.argsort(strip, kind="stable")
        return np.split(order, np.flatnonzero(np.diff(strip[order])) + 1) if len(order) else []

    @cached_property
    def factors(self) -> Sequence[Sequence[tuple[Single, Indices]]]:
        """LU factors and pivots of the equations of each strip along x and s."""
        rows, columns = np.nonzero(self.law.free)
        coefficients = self.law.coefficients
        factors = []
        for places in self.places:
            own = [part[places].T[..., None].astype(np.float32) for part in coefficients]
            matrices = self.matrices(columns[places[0]], rows[places], *own)
            factors.append([sgetrf(matrix)[:2] for matrix in matrices])
        return factors

    def matrices(
        self, strip: int, rows: Indices, by_traction: Single, by_slip: Single, by_slip_behind: Single
    ) -> Single:
        """Return the equations of a strip with k free elements in `rows`, (2, k, k), from coefficients."""
        span = slice(rows[0], rows[-1] + 1)
        places = span if rows[-1] - rows[0] < len(rows) else rows  # without holes: no copies
        here, behind = (slip[:, places] for slip in (self.strips.slip, self.strips.behind))
        matrices = by_slip * here[:, :, places]
        if np.any(by_slip_behind):
            matrices += by_slip_behind * behind[:, :, places]
        k = np.arange(len(rows))
        matrices[:, k, k] += by_traction[..., 0]
        followed, ratio = self.edge.followed[:, strip], self.edge.ratio[:, strip]
        for row in np.flatnonzero((followed != np.arange(len(followed))) & (ratio > 0)):
            following = by_slip[..., 0] * here[:, :, row] + by_slip_behind[..., 0] * behind[:, :, row]
            matrices[:, :, np.searchsorted(rows, followed[row])] += ratio[row].astype(np.float32) * following
        return matrices


# --- steps of Newton's method ---

LOOSEST = 0.1  # relative residual of the linear equations
MOST_VECTORS = 80  # of GMRES
SINGULAR = 1e-8  # share of the largest singular value below which amplitudes change no force


def correction(
    residual: Array,
    derivative: Callable[[Array], Array],
    inverse: Callable[[Array], Array],
    relative_residual: float,
) -> Array:
    """Return the change (n,) of the unknowns that takes a residual (n,) away, by preconditioned GMRES.

    `derivative` returns the change of residuals, `inverse` approximately the change of unknowns.
    """
    size = (len(residual),) * 2
    solution, _ = gmres(
        LinearOperator(size, matvec=derivative, dtype=float),
        -residual,
        rtol=relative_residual,
        restart=MOST_VECTORS,
        maxiter=1,
        M=LinearOperator(size, matvec=inverse, dtype=float),
    )
    return np.asarray(solution, dtype=float)


def inverse_of_amplitudes(forces: Sequence[Array]) -> Array:
    """Return the inverse (k, k) of how amplitudes change forces, where they do.

    `forces` (k,) are those of the tractions that undo the residuals of a unit amplitude, amplitude by
    amplitude.
    """
    k = len(forces)
    return np.asarray(np.linalg.pinv(-np.reshape(forces, (k, k)).T, rcond=SINGULAR), dtype=float)


def stagnated(errors: Sequence[float], steps: int) -> bool:
    """Return whether the last errors, as many as `steps`, are all larger than one before."""
    before, last = errors[:-steps], errors[-steps:]
    return bool(before) and min(last) > min(before)
