"""An approximate inverse of the law of friction made linear: exact within strips, by waves between them.

In a strip slip depends on where rolling begins and on which elements stick, so that an inverse for the whole
plane is a bad approximation there. So the equations of each strip are solved directly, as on half-spaces
without other strips. These are accounted for before: slip where elements stick is changed, wave by wave on a
ring, to that which the same tractions cause with each strip alone. What couples x with s is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import toeplitz
from scipy.linalg.lapack import sgetrf, sgetrs

from femic.contact.friction.law import Law
from femic.contact.friction.leading_edge import LeadingEdge
from femic.contact.friction.motion import Motion
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.ring import Waves
from geometries.arrays import Array, Indices

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
    def of(cls, flat: Convolution, motion: Motion) -> "Strips":
        """Return those of half-spaces, whose ICs are `flat` in the directions x and s, in a motion."""
        kernels, n_x = flat.own_strip, flat.shape[0]
        u = [toeplitz(kernels[n_x - 1 :, i, i], kernels[n_x - 1 :: -1, i, i]) for i in range(2)]
        slip = np.moveaxis(motion.slip_of(np.stack(u, axis=-1)), -1, 0).astype(np.float32)
        slip[:, -1, -1] = slip[:, 0, 0]  # as if there were another element ahead of the last one
        behind = np.concatenate([np.zeros_like(slip[:, :1]), slip[:, :-1]], axis=1)
        return cls(slip, behind, flat.strips_alone)

    def inverse(self, law: Law, edge: LeadingEdge) -> "StripInverse":
        """Return the approximate inverse of the derivative of the law by tractions of free elements."""
        return StripInverse(self, law, edge)


@dataclass(frozen=True, eq=False)
class StripInverse:
    """The inverse of the derivative of a law by tractions, with slip that follows from these."""

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
            of_strip = [part[places].T[..., None].astype(np.float32) for part in coefficients]
            matrices = self.matrices(columns[places[0]], rows[places], *of_strip)
            factors.append([sgetrf(matrix)[:2] for matrix in matrices])
        return factors

    def matrices(
        self, strip: int, rows: Indices, of_traction: Single, of_slip: Single, of_slip_behind: Single
    ) -> Single:
        """Return the equations of a strip with k free elements in `rows`, (2, k, k), from coefficients."""
        span = slice(rows[0], rows[-1] + 1)
        places = span if rows[-1] - rows[0] < len(rows) else rows  # without holes: no copies
        here, behind = (slip[:, places] for slip in (self.strips.slip, self.strips.behind))
        matrices = of_slip * here[:, :, places]
        if np.any(of_slip_behind):
            matrices += of_slip_behind * behind[:, :, places]
        k = np.arange(len(rows))
        matrices[:, k, k] += of_traction[..., 0]
        followed, ratio = self.edge.followed[:, strip], self.edge.ratio[:, strip]
        for row in np.flatnonzero((followed != np.arange(len(followed))) & (ratio > 0)):
            of_row = of_slip[..., 0] * here[:, :, row] + of_slip_behind[..., 0] * behind[:, :, row]
            matrices[:, :, np.searchsorted(rows, followed[row])] += ratio[row].astype(np.float32) * of_row
        return matrices
