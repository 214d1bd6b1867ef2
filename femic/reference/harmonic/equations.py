"""The equations of a section at a wavenumber: their matrix, its factors, and what proves a solution."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, norm, splu

from femic.reference.accuracy import NotConverged
from geometries.arrays import Array, Mask

# A tenth of the tightest tolerance. The relative error of the displacements is a quarter of the residual or
# less (measured by a step of iterative refinement). Rounding leaves residuals of 1e-14 at large k, and of
# 5e-12 at k = 0 and nu = 0.28. They grow in proportion to 1 / (1 - 2 nu): 3e-9 at nu = 0.4999, and there 1e-7
# under a patch of aspect 0.01 (144 000 unknowns).
LARGEST_RESIDUAL = 1e-5


@dataclass(frozen=True, eq=False)
class Stiffness:
    """A matrix K(k) = K0 + k K1 + k^2 K2, whose parts have the same sparsity pattern."""

    pattern: csc_matrix
    parts: tuple[Array, Array, Array]  # data of K0, K1, K2 in this pattern

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.pattern.shape[0])

    def restricted(self, chosen: Mask) -> "Stiffness":
        """The rows and columns that are chosen."""
        rows, starts = self.pattern.indices, self.pattern.indptr
        entries = np.flatnonzero(chosen[rows] & np.repeat(chosen, np.diff(starts)))
        numbers = (np.cumsum(chosen) - 1).astype(rows.dtype)
        new_starts = np.append(0, np.searchsorted(entries, starts[1:])[chosen])
        k0, k1, k2 = (part[entries] for part in self.parts)
        n = len(new_starts) - 1
        pattern = csc_matrix((np.ones(len(entries)), numbers[rows[entries]], new_starts), shape=(n, n))
        return Stiffness(pattern, (k0, k1, k2))

    def data(self, k: float) -> Array:
        """The data of the matrix at a wavenumber [1/mm] in its pattern."""
        return self.parts[0] + k * (self.parts[1] + k * self.parts[2])

    def at(self, k: float) -> csc_matrix:
        """The matrix at a wavenumber [1/mm]."""
        return csc_matrix((self.data(k), self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)


def factors_of(matrix: csc_matrix, k: float) -> SuperLU:
    """The LU factors of a matrix at a wavenumber [1/mm], in its own order.

    Raises NotConverged where SuperLU finds none.
    """
    try:
        return splu(
            matrix, permc_spec="NATURAL", panel_size=1, diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError as error:  # SuperLU met a pivot that is 0
        raise not_solved(k, matrix.shape[0], str(error)) from error


def column_weights(forces: csc_matrix) -> Array:
    """Weights of the columns of forces (unknowns, n) in a sum that proves all their solutions, shape (n,).

    Each column is divided by its norm, which keeps large columns from hiding small ones, and multiplied by a
    repeatable random number of size 1 to 2 and either sign, which keeps two columns from cancelling.
    """
    generator = np.random.default_rng(0)
    n = forces.shape[1]
    factors = generator.uniform(1.0, 2.0, n) * generator.choice([-1.0, 1.0], n)
    return np.asarray(factors / norm(forces, axis=0))


def require_small(residual: float, k: float, unknowns: int) -> None:
    """Raise NotConverged where the residual at a wavenumber [1/mm] is too large, or no number."""
    if not residual <= LARGEST_RESIDUAL:
        raise not_solved(
            k, unknowns, f"the residual is {residual:.1e} of the forces, {LARGEST_RESIDUAL:.0e} allowed"
        )


def not_solved(k: float, unknowns: int, reason: str) -> NotConverged:
    """The error at a wavenumber [1/mm]."""
    return NotConverged(
        f"section at the wavenumber k = {k:.4g} 1/mm, {unknowns:,} unknowns: not solved: {reason}. Likely "
        "cause: a Poisson's ratio too close to 0.5, cells that are strongly distorted or of very different "
        "sizes, or moduli or lengths beyond what numbers can hold. Try a smaller nu, a smaller "
        "`growth`, or lengths and moduli of usual size"
    )
