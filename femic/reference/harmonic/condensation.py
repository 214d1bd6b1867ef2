"""Responses of observers to loads at a wavenumber, for several supports at once.

Only the amplitudes G K^-1 F at the observers are needed, not all amplitudes K^-1 F under forces F. Amplitudes
that some supports hold and others leave free are retained: they come last in K. The bordered matrix
M = [[K, F], [G, D]] is factored once. The last block of the product of its factors is the Schur complement T
of all other amplitudes: the condensed equations of the retained amplitudes, with the effect of the loads on
them and their effect on the observers. For each support the free retained amplitudes are eliminated from T,
which leaves D - G K^-1 F. One system per support is solved to verify factors, T and the responses.

Where observers are many and loads few, forces take the place of observers, F^T that of G, and the amplitudes
under all loads are solved for. A field takes as long as `ROWS_PER_FIELD` observers in the border.

Springs on the retained amplitudes are added to K and subtracted from T: without its plane of symmetry, half
of a slender section is far more flexible in bending than with any of the supports.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, eye_array, vstack
from scipy.sparse.linalg import SuperLU

from femic.reference.harmonic.equations import (
    Stiffness,
    column_weights,
    factors_of,
    not_solved,
    require_small,
)
from geometries.arrays import Array, Indices, Mask

SPRING = 0.1  # stiffness of the springs over the median of the diagonal of K0
ROWS_PER_FIELD = 10  # rows of the border that take as long as one field (measured with 39,000 unknowns)
BORDER = 1e4  # entries of D times this median: more than responses are, but close to nu = 1/2; 3 digits lost


@dataclass(frozen=True, eq=False)
class Condensation:
    """The bordered matrix at any wavenumber; its border has the size of the larger of F and G."""

    stiffness: Stiffness
    retained: int  # number of amplitudes that are retained: the last ones of K
    bordered: csc_matrix  # M with springs, and else zeros, in the place of K's entries
    from_k: Indices  # numbers of K's entries among those of M
    spring: float  # [N/mm^2]
    d: float  # D is this times the identity [mm^2/N]
    forces: csc_matrix  # F (amplitudes, n)
    observers: csr_matrix  # G (m, amplitudes)
    in_border: csr_matrix  # G, or F^T where amplitudes are solved for

    @classmethod
    def of(
        cls,
        stiffness: Stiffness,
        retained: int,
        forces: csc_matrix,
        observers: csr_matrix,
        supports: int,
    ) -> "Condensation":
        """Find the pattern of M: below each column of K stands one of G, and at its right F over D.

        Responses are computed with a number of `supports`.
        """
        few_loads = ROWS_PER_FIELD * supports * forces.shape[1] < observers.shape[0]
        in_border = csr_matrix(forces.T) if few_loads else observers
        k, n, size = stiffness.pattern, stiffness.size, max(forces.shape[1], in_border.shape[0])
        column = np.repeat(np.arange(n), np.diff(k.indptr))
        diagonal = k.indices == column
        compliance = 1 / float(np.median(stiffness.parts[0][diagonal]))
        spring, d = SPRING / compliance, BORDER * compliance
        f, below = csc_matrix(forces), csc_matrix(in_border)
        f.resize(n, size)
        below.resize(size, n)
        right = csc_matrix(vstack([f, d * eye_array(size)]))
        from_k = np.arange(k.nnz) + np.repeat(below.indptr[:-1], np.diff(k.indptr))
        from_below = np.arange(below.nnz) + np.repeat(k.indptr[1:], np.diff(below.indptr))
        left = k.nnz + below.nnz
        indices, data = np.empty(left + right.nnz, dtype=k.indices.dtype), np.zeros(left + right.nnz)
        indices[from_k], indices[from_below], indices[left:] = k.indices, n + below.indices, right.indices
        data[from_below], data[left:] = below.data, right.data
        data[from_k[diagonal & (column >= n - retained)]] = spring
        starts = np.append(k.indptr + below.indptr, left + right.indptr[1:])
        bordered = csc_matrix((data, indices, starts), shape=(n + size, n + size))
        return cls(stiffness, retained, bordered, from_k, spring, d, forces, observers, in_border)

    def at(self, k: float) -> "Condensed":
        """The condensed equations at a wavenumber [1/mm]; raises NotConverged where M has no factors."""
        data = self.bordered.data.copy()
        data[self.from_k] += self.stiffness.data(k)
        matrix = csc_matrix((data, self.bordered.indices, self.bordered.indptr), shape=self.bordered.shape)
        factors = factors_of(matrix, k)
        border = self.bordered.shape[0] - self.stiffness.size
        block = last_block(factors, self.retained + border)
        if block is None:
            raise not_solved(k, self.stiffness.size, "SuperLU has exchanged rows or columns")
        block[: self.retained, : self.retained] -= self.spring * np.eye(self.retained)
        return Condensed(self, k, factors, block)


@dataclass(frozen=True, eq=False)
class Condensed:
    """The equations of retained amplitudes, loads and observers at a wavenumber k [1/mm]."""

    condensation: Condensation
    k: float
    factors: SuperLU  # of M
    block: Array  # T, retained amplitudes before the border

    def responses(self, free: Mask) -> tuple[Array, float]:
        """Responses (m, n) [mm^2/N] and the residual that proves them, `free` marking the retained that are.

        Raises NotConverged where the residual is too large.
        """
        prepared = self.condensation
        moved, seen = self._eliminated(free)
        weights = column_weights(prepared.forces)
        by_fields = prepared.in_border is not prepared.observers
        combined = np.eye(len(weights)) if by_fields else weights[:, None]
        fields = self._fields(free, moved @ combined, seen @ combined, combined)
        proved = fields @ weights if by_fields else fields[:, 0]
        residual = self._residual(free, proved, seen @ weights, prepared.forces @ weights)
        require_small(residual, self.k, prepared.stiffness.size)
        return (prepared.observers @ fields if by_fields else seen), residual

    def _eliminated(self, free: Mask) -> tuple[Array, Array]:
        """Retained amplitudes (retained, n), and what the border's observers see, under the loads."""
        prepared, retained = self.condensation, self.condensation.retained
        n_seen, n_loads = prepared.in_border.shape[0], prepared.forces.shape[1]
        retained_columns, load_columns = np.split(
            self.block[: retained + n_seen, : retained + n_loads], [retained], 1
        )
        moved = np.zeros((retained, n_loads))
        try:
            moved[free] = np.linalg.solve(
                retained_columns[:retained][free][:, free], load_columns[:retained][free]
            )
        except np.linalg.LinAlgError as error:
            raise not_solved(self.k, prepared.stiffness.size, str(error)) from error
        directly = prepared.d * np.eye(n_seen, n_loads) - load_columns[retained:]
        return moved, directly + retained_columns[retained:] @ moved

    def _fields(self, free: Mask, moved: Array, seen: Array, combined: Array) -> Array:
        """Amplitudes (amplitudes, c) under combinations (n, c) of the loads.

        The right-hand side of M consists of the forces, the reactions (including the springs), and the
        amplitudes at the observers of the border. With it the solution is (u, 0), and held amplitudes are 0.
        """
        prepared, retained = self.condensation, self.condensation.retained
        n = prepared.stiffness.size
        reactions = self.block[:retained, :retained] @ moved
        reactions -= self.block[:retained, retained : retained + len(combined)] @ combined
        reactions[free] = 0.0
        right_hand_side = np.zeros((self.factors.shape[0], combined.shape[1]))
        right_hand_side[:n] = prepared.forces @ combined
        right_hand_side[n - retained : n] += reactions + prepared.spring * moved
        right_hand_side[n : n + len(seen)] = seen
        fields = np.asarray(self.factors.solve(right_hand_side)[:n])
        fields[n - retained :][~free] = 0.0
        return fields

    def _residual(self, free: Mask, u: Array, seen: Array, forces: Array) -> float:
        """Return the larger residual: of the equations of free amplitudes, or of the observed amplitudes.

        The latter is a share of the amplitudes at the loads, if they move more than the observers.
        """
        prepared = self.condensation
        is_free = np.append(np.ones(len(u) - len(free), dtype=bool), free)
        unbalanced = np.linalg.norm((prepared.stiffness.at(self.k) @ u - forces)[is_free])
        seen_of_u = prepared.in_border @ u
        size = np.max([np.linalg.norm(values) for values in (seen, seen_of_u, prepared.forces.T @ u)])
        return float(np.max([unbalanced, np.linalg.norm(seen - seen_of_u) / size]))


def last_block(factors: SuperLU, size: int) -> Array | None:
    """The last block (size, size) of the product of LU factors; None where others were moved there."""
    n = factors.shape[0]
    last = np.arange(n - size, n)
    if not (np.array_equal(factors.perm_r[last], last) and np.array_equal(factors.perm_c[last], last)):
        return None
    lower, upper = (part[:, -size:][-size:].toarray() for part in (factors.L, factors.U))
    return np.asarray(lower @ upper)
