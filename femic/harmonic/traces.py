"""Responses of observers to loads at a wavenumber, without the fields between them.

Of the amplitudes K^-1 F under forces F only G K^-1 F is wanted, at the observers. The bordered matrix
M = [[K, F], [G, D]] is factored with its border last. The last block of the product of its factors is then
D - G K^-1 F, the Schur complement of K in M. Nothing is solved but one system that proves the factors.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, eye_array, vstack
from scipy.sparse.linalg import SuperLU

from femic.harmonic.equations import FreeSystem, Stiffness, column_weights, factors_of, require_small
from geometries.arrays import Array, Indices

FEW_LOADS = 12  # number of loads up to which it is faster to solve for their fields
BORDER = 1e3  # entries of D over the natural compliance: with it pivots are far from 0, and 3 digits are lost


@dataclass(frozen=True, eq=False)
class Traces:
    """The way from loads to observers.

    It has forces (unknowns, n), and a matrix (m, unknowns) that takes amplitudes to observers.
    """

    system: FreeSystem
    forces: Array
    observers: csr_matrix
    bordered: "Bordered | None"  # None for a few loads

    @classmethod
    def of(cls, system: FreeSystem, forces: Array, observers: csr_matrix, compliance: float) -> "Traces":
        """Prepare for all wavenumbers; the responses are of the size of `compliance` [mm^2/N]."""
        few = forces.shape[1] <= FEW_LOADS
        free_forces, free_observers = forces[system.free], csr_matrix(observers[:, system.free])
        bordered = (
            None if few else Bordered.of(system.stiffness, free_forces, free_observers, BORDER * compliance)
        )
        return cls(system, forces, observers, bordered)

    def responses(self, k: float) -> tuple[Array, float]:
        """Responses (m, n) [mm^2/N] at a wavenumber [1/mm], and the residual of the solved equations.

        Raises NotConverged as `FreeSystem.solved`.
        """
        by_border = self.bordered.responses(k) if self.bordered else None
        if by_border is not None:
            return by_border
        amplitudes, residual = self.system.solved(k, self.forces)
        return self.observers @ amplitudes, residual


@dataclass(frozen=True, eq=False)
class Bordered:
    """The bordered matrix, whose border has the size of the larger of F and G; the rest of it is D."""

    stiffness: Stiffness
    border: csc_matrix  # M with zeros in the place of K's entries
    from_k: Indices  # numbers of K's entries among those of M
    d: float  # D is this times the identity [mm^2/N]
    forces: Array  # (free amplitudes, n)
    observers: csr_matrix  # (m, free amplitudes)

    @classmethod
    def of(cls, stiffness: Stiffness, forces: Array, observers: csr_matrix, d: float) -> "Bordered":
        """Find the pattern of M: below each column of K stands one of G, and at its right F over D."""
        k, n, size = stiffness.pattern, stiffness.size, max(forces.shape[1], observers.shape[0])
        f, below = csc_matrix(forces), csc_matrix(observers)
        f.resize(n, size)
        below.resize(size, n)
        right = csc_matrix(vstack([f, d * eye_array(size)]))
        from_k = np.arange(k.nnz) + np.repeat(below.indptr[:-1], np.diff(k.indptr))
        from_below = np.arange(below.nnz) + np.repeat(k.indptr[1:], np.diff(below.indptr))
        left = k.nnz + below.nnz
        indices, data = np.empty(left + right.nnz, dtype=k.indices.dtype), np.zeros(left + right.nnz)
        indices[from_k], indices[from_below], indices[left:] = k.indices, n + below.indices, right.indices
        data[from_below], data[left:] = below.data, right.data
        starts = np.append(k.indptr + below.indptr, left + right.indptr[1:])
        border = csc_matrix((data, indices, starts), shape=(n + size, n + size))
        return cls(stiffness, border, from_k, d, forces, observers)

    def at(self, k: float) -> csc_matrix:
        """The bordered matrix at a wavenumber [1/mm]."""
        data = self.border.data.copy()
        data[self.from_k] = self.stiffness.data(k)
        return csc_matrix((data, self.border.indices, self.border.indptr), shape=self.border.shape)

    def responses(self, k: float) -> tuple[Array, float] | None:
        """Responses (m, n) [mm^2/N] at a wavenumber [1/mm], and the residual that proves them.

        None where SuperLU has moved the border, so that it is not the last block.
        """
        matrix = self.at(k)
        factors = factors_of(matrix, k)
        size = self.border.shape[0] - self.stiffness.size
        block = _last_block(factors, size)
        if block is None:
            return None
        whole = self.d * np.eye(size) - block
        residual = self._residual(matrix, factors, whole)
        require_small(residual, k, self.stiffness.size)
        return whole[: self.observers.shape[0], : self.forces.shape[1]], residual

    def _residual(self, matrix: csc_matrix, factors: SuperLU, responses: Array) -> float:
        """Residual of a system with the whole matrix, or of its block, whichever is larger.

        Its solution (u, v) under forces F w is K^-1 F (w - v), so that `responses` takes w - v to -D v.
        """
        n = self.forces.shape[0]
        w = np.zeros(len(responses))
        w[: self.forces.shape[1]] = column_weights(self.forces)
        right_hand_side = np.concatenate([self.forces @ w[: self.forces.shape[1]], np.zeros(len(w))])
        solution = factors.solve(right_hand_side)
        v = solution[n:]
        of_forces = np.linalg.norm((matrix @ solution - right_hand_side)[:n])
        seen = self.observers @ solution[:n]
        expected = (responses @ (w - v))[: len(seen)]
        size = np.max([np.linalg.norm(seen), np.linalg.norm(expected)])
        return float(np.max([of_forces, np.linalg.norm(expected - seen) / size]))


def _last_block(factors: SuperLU, size: int) -> Array | None:
    """The last block (size, size) of the product of LU factors; None where others were moved there."""
    n = factors.shape[0]
    last = np.arange(n - size, n)
    if not (np.array_equal(factors.perm_r[last], last) and np.array_equal(factors.perm_c[last], last)):
        return None
    lower, upper = factors.L[:, -size:][-size:], factors.U[:, -size:][-size:]
    return np.asarray((lower @ upper).toarray())
