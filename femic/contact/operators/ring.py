"""Waves on a ring in x and s: preconditioners for contact on any ICs.

Source: Vollebregt (2014), Journal of Computational Physics 257, 333-351. Beyond the lags of the grid
the kernel keeps its value at the longest one: with zeros there some values of the spectrum would not be
positive.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from geometries.arrays import Array, Indices

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Waves:
    """A linear map of fields: it multiplies waves on a ring of `padded` elements by matrices.

    `factors` are these, by the frequencies along x and along s, shape (..., ..., m, m).
    """

    factors: Complex
    padded: tuple[int, int]

    @classmethod
    def inverse(cls, kernels: Array, padded: tuple[int, int]) -> "Waves":
        """Return the inverse of a convolution with kernels (2 n_x - 1, 2 n_s - 1, m, m) at all lags."""
        spectrum = fft.rfft2(_on_ring(kernels, padded), axes=(0, 1))
        return cls(np.asarray(np.linalg.inv(spectrum), complex), padded)

    @classmethod
    def strips_alone(cls, kernels: Array, padded: tuple[int, int]) -> "Waves":
        """Return what changes results of a convolution to those in which each strip has its own part only."""
        ring = _on_ring(kernels, padded)
        of_strip = fft.fft(ring[:, 0], axis=0)[:, None]
        return cls(of_strip @ np.linalg.inv(fft.rfft2(ring, axes=(0, 1))), padded)

    def __call__(self, values: Array) -> Array:
        """Return the result for values of shape (n_x, n_s, m), of the same shape."""
        n_x, n_s, _ = values.shape
        spectrum = fft.rfft2(values, self.padded, axes=(0, 1))
        multiplied = np.einsum("xsij,xsj->xsi", self.factors, spectrum)
        return np.asarray(fft.irfft2(multiplied, self.padded, axes=(0, 1))[:n_x, :n_s])


def _on_ring(kernels: Array, padded: tuple[int, int]) -> Array:
    """Kernels at the lags around a ring, shape (*padded, m, m)."""
    places = [_lags(size, (lags + 1) // 2) for size, lags in zip(padded, kernels.shape, strict=False)]
    return kernels[np.ix_(*places)]


def _lags(size: int, n: int) -> Indices:
    """Places, among lags from -(n - 1) to n - 1, of the lags around a ring of `size` elements."""
    lags = np.arange(size)
    lags = np.where(lags > size // 2, lags - size, lags)
    return np.asarray(n - 1 + np.clip(lags, 1 - n, n - 1))
