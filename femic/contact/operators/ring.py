"""The inverse of a convolution on a ring in x and s: a preconditioner for contact on any ICs.

Source: Vollebregt (2014), Journal of Computational Physics 257, 333-351. Lags beyond those of the grid are
taken as the longest ones: with nothing there some values of the spectrum would not be positive.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from geometries.arrays import Array, Indices

if TYPE_CHECKING:
    from femic.contact.operators.convolution import Convolution

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class RingInverse:
    """The inverse of a spectrum (frequencies along x, along s, m, m) on a ring of `padded` elements."""

    inverse: Complex
    padded: tuple[int, int]

    @classmethod
    def of(
        cls, convolution: "Convolution", along_x: Callable[[Array], Array | Complex] = np.ones_like
    ) -> "RingInverse":
        """The inverse of a convolution without factors, such as A of half-spaces.

        Displacements are multiplied by `along_x` of the angle by which a wave turns from one element to the
        next along x.
        """
        places = [_lags(size, n) for size, n in zip(convolution.padded, convolution.shape, strict=True)]
        directions, (size_x, size_s) = convolution.directions, convolution.padded
        spectrum = np.zeros((size_x, size_s // 2 + 1, len(directions), len(directions)), complex)
        for (m, i), (n, j) in product(enumerate(directions), repeat=2):
            for ((of_u, _), (of_p, _)), kernel in convolution.kernels.items():
                if (of_u, of_p) == (i, j):
                    spectrum[..., m, n] += fft.rfft2(kernel[np.ix_(*places)])
        turns = 2 * np.pi * fft.fftfreq(size_x)
        spectrum = spectrum * along_x(turns)[:, None, None, None]
        return cls(np.asarray(np.linalg.inv(spectrum), complex), convolution.padded)

    def __call__(self, values: Array) -> Array:
        """Tractions [MPa] that cause values, shape (n_x, n_s, m) each."""
        n_x, n_s, _ = values.shape
        spectrum = fft.rfft2(values, self.padded, axes=(0, 1))
        inverted = np.einsum("xsij,xsj->xsi", self.inverse, spectrum)
        return np.asarray(fft.irfft2(inverted, self.padded, axes=(0, 1))[:n_x, :n_s])


def _lags(size: int, n: int) -> Indices:
    """Places, among lags from -(n - 1) to n - 1, of those round a ring of `size` elements."""
    lags = np.arange(size)
    lags = np.where(lags > size // 2, lags - size, lags)
    return np.asarray(n - 1 + np.clip(lags, 1 - n, n - 1))
