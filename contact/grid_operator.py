"""An IC matrix as an operator from tractions to displacements on a grid, and its smallest eigenvalue.

The operator is a convolution along x (by FFT), because elements of a strip differ by their lag only, and a
dense matrix between strips.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, eigsh

from geometries.arrays import Array
from geometries.patches import X

Complex = NDArray[np.complex128] | NDArray[np.complex64]

X_SIGNS = np.where(np.arange(3) == X, -1.0, 1.0)
PARITY = np.outer(X_SIGNS, X_SIGNS)  # parity in x of the components (i, j): -1 odd
EIGENVALUE_ACCURACY = 0.03  # relative accuracy of the smallest eigenvalue


@dataclass(frozen=True, eq=False)
class GridOperator:
    """The transform along x of an IC matrix [mm/MPa], shape (frequency, 3 n_s, 3 n_s)."""

    transformed: Complex
    n_x: int

    @classmethod
    def of(cls, ics: Array) -> "GridOperator":
        """The operator of ICs (n_x, n_s, n_s, 3, 3) [mm/MPa] at lags >= 0; negative lags follow by parity."""
        n_x, n_s = ics.shape[:2]
        lags = np.zeros((2 * n_x, *ics.shape[1:]))
        lags[:n_x] = ics
        lags[n_x + 1 :] = PARITY * ics[:0:-1]
        rows = np.fft.rfft(lags, axis=0).transpose(0, 1, 3, 2, 4)
        return cls(rows.reshape(n_x + 1, 3 * n_s, 3 * n_s), n_x)

    def __call__(self, tractions: Array) -> Array:
        """Displacements [mm] due to tractions [MPa], (n_x, n_s, 3) each."""
        transformed_tractions = np.fft.rfft(tractions.reshape(self.n_x, -1), 2 * self.n_x, axis=0)
        transformed_tractions = transformed_tractions.astype(self.transformed.dtype)
        u = np.fft.irfft(np.matmul(self.transformed, transformed_tractions[..., None])[..., 0], axis=0)
        return u[: self.n_x].reshape(tractions.shape)

    @property
    def symmetric_part(self) -> "GridOperator":
        """The mean of the operator and its transpose."""
        sum_with_transpose = self.transformed + np.conj(np.swapaxes(self.transformed, 1, 2))
        return GridOperator(sum_with_transpose / 2, self.n_x)

    def smallest_eigenvalue(self) -> float:
        """Smallest eigenvalue of the symmetric part [mm/MPa], to 3 %.

        It is positive where all tractions do positive work.
        """
        symmetric, n_s = self.symmetric_part, self.transformed.shape[1] // 3
        symmetric = replace(symmetric, transformed=symmetric.transformed.astype(np.complex64))
        size = 3 * n_s * self.n_x
        operator = LinearOperator(
            (size, size),
            dtype=float,
            matvec=lambda tractions: symmetric(tractions.reshape(self.n_x, n_s, 3)).ravel(),
        )
        start = np.random.default_rng(0).standard_normal(size)
        return float(
            eigsh(operator, k=1, which="SA", tol=EIGENVALUE_ACCURACY, v0=start, return_eigenvectors=False)[0]
        )


def reciprocity_defect(ics: Array) -> float:
    """Largest |C(I, J) - C(J, I)^T| of ICs (n_x, n_s, n_s, 3, 3), over the largest |C_nn|.

    ICs of curved bodies that are observed at centres, and not averaged over elements, are not quite
    reciprocal.
    """
    return float(np.max(reciprocity_defects(ics)))


def reciprocity_defects(ics: Array) -> Array:
    """The defects of `reciprocity_defect` for each pair of strips, symmetric, shape (n_s, n_s)."""
    exchanged = PARITY * np.swapaxes(np.swapaxes(ics, 1, 2), 3, 4)
    return np.asarray(np.max(np.abs(ics - exchanged), axis=(0, 3, 4)) / np.max(np.abs(ics[..., 2, 2])))
