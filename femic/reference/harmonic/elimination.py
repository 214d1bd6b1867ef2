"""Elimination of amplitudes from the equations of a section, at several wavenumbers at once.

The bordered matrix is M = [[K, F], [G, 0]], with K(k) = K0 + k K1 + k^2 K2, forces F of loads and rows G of
observers. All amplitudes but the retained ones are eliminated: what is left of M are the condensed equations
of the retained amplitudes, with the effect of the loads on them and their effect on the observers. The method
is multifrontal (I. S. Duff, J. K. Reid, ACM Trans. Math. Softw. 9, 1983, 302-325): dense matrices, the
`fronts`, are the same for all wavenumbers. Pivots need no exchange between fronts: where the retained
amplitudes and those of other parts are held, K is positive definite.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from femic.reference.harmonic.fronts import Equations, Front, Half, Order
from geometries.arrays import Array, Indices

MOST_NUMBERS = 48_000_000  # of factors and fronts, up to which wavenumbers are eliminated together
MOST_TOGETHER = 8  # wavenumbers: more are not faster


@dataclass(frozen=True, eq=False)
class Elimination:
    """The elimination of the amplitudes of a section, at any wavenumbers.

    `amplitudes` are the numbers 3 n + c of the free amplitudes, the retained ones last; forces F
    (amplitudes, n) are in this order.
    """

    fronts: list[Front]
    amplitudes: Indices
    retained: int
    forces: csr_matrix
    seen: csr_matrix  # G^T (amplitudes, m)

    @classmethod
    def of(cls, equations: Equations) -> "Elimination":
        """Prepare the elimination for the equations of a section."""
        order = Order.of(equations)
        return cls(order.fronts(), order.amplitudes, order.retained, order.forces, order.seen)

    @property
    def together(self) -> int:
        """For how many wavenumbers at once memory is used, at most."""
        numbers = sum(front.eliminated * front.shape[1] for front in self.fronts)
        numbers += 2 * max(front.shape[0] * front.shape[1] for front in self.fronts)
        return int(np.clip(MOST_NUMBERS // numbers, 1, MOST_TOGETHER))

    def at(self, k: Sequence[float], forces: Array | None = None) -> "Eliminated":
        """Eliminate at wavenumbers [1/mm]; raises LinAlgError where a pivot is 0.

        `forces` (k, n) are the entries of F where it differs from wavenumber to wavenumber.
        """
        powers = np.vander(k, 3, increasing=True)
        forces = self.forces.data if forces is None else forces
        factors: list[Array] = []
        left: dict[int, Array] = {}
        for number, front in enumerate(self.fronts):
            matrix, m = self._front(front, powers, forces, left), front.eliminated
            factor = np.asarray(np.linalg.solve(matrix[:, :m, :m], matrix[:, :m, m:]), dtype=float)
            left[number] = matrix[:, m:, m:] - matrix[:, m:, :m] @ factor if m else matrix
            factors.append(factor)
        return Eliminated(self, np.array(k), factors, left[len(self.fronts) - 1])

    def _front(self, front: Front, powers: Array, forces: Array, left: dict[int, Array]) -> Array:
        """The matrix (k, rows, columns) of a front: of cells or of what halves left, and the border."""
        matrix = np.zeros((len(powers), *front.shape))
        if front.stiffness is not None:
            n = len(front.amplitudes)
            matrix[:, :n, :n] = (powers[:, None] @ front.stiffness.reshape(3, n * n)).reshape(
                len(powers), n, n
            )
        for half in front.halves:
            _add(matrix, left.pop(half.number), half)
        row, load, entries = front.forces
        matrix[:, row, load] += forces[..., entries]
        row, observer, entries = front.seen
        matrix[:, observer, row] += self.seen.data[entries]
        return matrix


def _add(matrix: Array, left: Array, half: Half) -> None:
    """Add what is left of a half to a front."""
    for rows, columns, at, beside in half.blocks:
        matrix[:, at, beside] += left[:, rows, columns]
    if not half.blocks:
        matrix[:, half.rows[:, None], half.columns] += left


def in_parts(k: Sequence[float], together: int, workers: int) -> list[list[float]]:
    """Wavenumbers in parts of at most `together`, about as many for each of the workers."""
    size = min(together, -(-len(k) // workers)) or 1
    number = workers * -(-len(k) // (workers * size))
    return [part.tolist() for part in np.array_split(k, number or 1) if len(part)]


@dataclass(frozen=True, eq=False)
class Eliminated:
    """What is left of M at wavenumbers k [1/mm], and the factors by which amplitudes follow from the others.

    `left` (k, retained + m, retained + n) has the rows of retained amplitudes and observers, the columns of
    retained amplitudes and loads.
    """

    elimination: Elimination
    k: Array
    factors: list[Array]
    left: Array

    def fields(self, retained: Array, loads: Array) -> Array:
        """Amplitudes (k, amplitudes, c) where the retained ones are (k, retained, c), under loads (n, c)."""
        u = np.zeros((len(self.k), len(self.elimination.amplitudes), retained.shape[-1]))
        u[:, u.shape[1] - self.elimination.retained :] = retained
        under = np.broadcast_to(-loads, (len(self.k), *loads.shape))
        for front, factor in zip(self.elimination.fronts[::-1], self.factors[::-1], strict=True):
            known = np.concatenate([u[:, front.kept], under[:, front.loads]], axis=1)
            u[:, front.first : front.first + front.eliminated] = -(factor @ known)
        return u

    def forces(self, u: Array) -> Array:
        """K u (k, amplitudes, c) of amplitudes u of this shape, from the matrices of the cells."""
        k = self.k[:, None, None]
        total = np.zeros_like(u)
        for front in self.elimination.fronts:
            if front.stiffness is not None:
                part = u[:, front.amplitudes]
                k0, k1, k2 = front.stiffness
                total[:, front.amplitudes] += k0 @ part + k * (k1 @ part + k * (k2 @ part))
        return total
