"""The inverse of a convolution on a ring in x and s: a preconditioner for contact on any ICs.

Source: Vollebregt (2014), Journal of Computational Physics 257, 333-351. Beyond the lags of the grid
the kernel keeps its value at the longest one: with zeros there some values of the spectrum would not be
positive.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from geometries.arrays import Array, Indices

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class RingInverse:
    """The inverse of a spectrum (frequencies along x, along s, m, m) on a ring of `padded` elements."""

    inverse: Complex
    padded: tuple[int, int]

    @classmethod
    def of(
        cls,
        kernels: Array,
        padded: tuple[int, int],
        along_x: Callable[[Array], Array | Complex] = np.ones_like,
    ) -> "RingInverse":
        """Return the inverse of a convolution with kernels (2 n_x - 1, 2 n_s - 1, m, m) [mm/MPa] at all lags.

        Displacements are multiplied by `along_x` of the phase [rad] of a wave between neighbours along x.
        """
        places = [_lags(size, (lags + 1) // 2) for size, lags in zip(padded, kernels.shape, strict=False)]
        spectrum = fft.rfft2(kernels[np.ix_(*places)], axes=(0, 1))
        symbol = along_x(2 * np.pi * fft.fftfreq(padded[0]))
        inverse = np.linalg.inv(symbol[:, None, None, None] * spectrum)
        return cls(np.asarray(inverse, complex), padded)

    def __call__(self, values: Array) -> Array:
        """Return tractions [MPa] that cause the displacements `values` [mm], shape (n_x, n_s, m) each."""
        n_x, n_s, _ = values.shape
        spectrum = fft.rfft2(values, self.padded, axes=(0, 1))
        inverted = np.einsum("xsij,xsj->xsi", self.inverse, spectrum)
        return np.asarray(fft.irfft2(inverted, self.padded, axes=(0, 1))[:n_x, :n_s])


def _lags(size: int, n: int) -> Indices:
    """Places, among lags from -(n - 1) to n - 1, of the lags around a ring of `size` elements."""
    lags = np.arange(size)
    lags = np.where(lags > size // 2, lags - size, lags)
    return np.asarray(n - 1 + np.clip(lags, 1 - n, n - 1))
