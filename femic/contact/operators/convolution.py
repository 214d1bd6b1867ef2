"""Operators that are sums of 2D convolutions between factors that vary with s, and waves that invert them.

Waves on a ring in x and s are preconditioners for contact on any ICs. Source: Vollebregt (2014), Journal of
Computational Physics 257, 333-351. Beyond the lags of the grid the kernel keeps its value at the longest one:
with zeros there some values of the spectrum would not be positive.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from geometries.arrays import Array

# --- waves on a ring ---

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Waves:
    """A linear map of fields: it multiplies waves on a ring of `padded` elements by matrices.

    `factors` are these, by the frequencies along x and along s, shape (..., ..., m, m).
    """

    factors: Complex
    padded: tuple[int, int]

    def __call__(self, values: Array) -> Array:
        """Return the result for values of shape (n_x, n_s, m), of the same shape."""
        n_x, n_s, _ = values.shape
        spectrum = fft.rfft2(values, self.padded, axes=(0, 1))
        multiplied = np.einsum("xsij,xsj->xsi", self.factors, spectrum)
        return np.asarray(fft.irfft2(multiplied, self.padded, axes=(0, 1))[:n_x, :n_s])


# --- sums of convolutions ---

Factor = str  # name of a factor
Place = tuple[int, Factor]  # a direction and the factor by which its displacement or traction is multiplied


@dataclass(frozen=True, eq=False)
class Convolution:
    """Displacements [mm] due to tractions [MPa] on a grid: sums of factor * (kernel * (factor tractions)).

    `kernels` [mm/MPa], by the places of displacement and traction, have values at all lags from -(n - 1) to
    n - 1 along x and s, shape (2 n_x - 1, 2 n_s - 1) each; `factors`, by name, have the shape (n_s,).
    `directions` gives the order of the directions in tractions and displacements.
    """

    directions: tuple[int, ...]
    factors: Mapping[Factor, Array]
    kernels: Mapping[tuple[Place, Place], Array]

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of elements along x and s."""
        lags_x, lags_s = next(iter(self.kernels.values())).shape
        return (lags_x + 1) // 2, (lags_s + 1) // 2

    def __call__(self, tractions: Array) -> Array:
        """Return displacements [mm] due to tractions [MPa], shape (n_x, n_s, directions) each."""
        n_x, n_s = self.shape
        spectra = {
            (j, b): fft.rfft2(tractions[..., self.directions.index(j)] * self.factors[b], self.padded)
            for j, b in {load for _, load in self.kernels}
        }
        sums: dict[Place, Complex] = {}
        for (observer, load), kernel in self._transformed.items():
            product = kernel * spectra[load]
            sums[observer] = sums[observer] + product if observer in sums else product
        u = np.zeros(tractions.shape)
        for (i, a), total in sums.items():
            back = fft.irfft2(total, self.padded, overwrite_x=True)[:n_x, :n_s]
            u[..., self.directions.index(i)] += self.factors[a] * back
        return u

    def coarsened(self) -> "Convolution":
        """Return the operator on elements twice as large: mean displacements due to equal tractions on four.

        Factors are averaged. Both numbers of elements must be even.
        """
        return Convolution(
            self.directions,
            {name: factor.reshape(-1, 2).mean(axis=1) for name, factor in self.factors.items()},
            {places: merged(merged(kernel, 0), 1) for places, kernel in self.kernels.items()},
        )

    def part(self, n_x: int, strips: slice) -> "Convolution":
        """Return the operator on `n_x` elements along x of some strips."""
        factors = {name: factor[strips] for name, factor in self.factors.items()}
        n_s = strips.stop - strips.start
        places = tuple(slice(n - m, n + m - 1) for n, m in zip(self.shape, (n_x, n_s), strict=True))
        kernels = {between: kernel[places] for between, kernel in self.kernels.items()}
        return Convolution(self.directions, factors, kernels)

    def restricted(self, directions: tuple[int, ...]) -> "Convolution":
        """Return the operator from tractions in some directions to displacements in these directions."""
        return Convolution(
            directions,
            self.factors,
            {
                (observer, load): kernel
                for (observer, load), kernel in self.kernels.items()
                if observer[0] in directions and load[0] in directions
            },
        )

    @cached_property
    def ring_inverse(self) -> Waves:
        """The approximate inverse of an operator without factors, such as A of half-spaces."""
        spectrum = fft.rfft2(self._on_ring, axes=(0, 1))
        return Waves(np.asarray(np.linalg.inv(spectrum), complex), self.padded)

    @cached_property
    def strips_alone(self) -> Waves:
        """What changes displacements to those by tractions on the same strip, for one without factors."""
        ring = self._on_ring
        strip = fft.fft(ring[:, 0], axis=0)[:, None]
        return Waves(strip @ np.linalg.inv(fft.rfft2(ring, axes=(0, 1))), self.padded)

    @property
    def own_strip(self) -> Array:
        """Kernels at all lags along x within a strip, (2 n_x - 1, m, m), of one without factors."""
        return self._without_factors[:, self.shape[1] - 1]

    @property
    def _without_factors(self) -> Array:
        """The kernels at all lags, shape (2 n_x - 1, 2 n_s - 1, m, m)."""
        m = len(self.directions)
        kernels = np.zeros((*(2 * n - 1 for n in self.shape), m, m))
        for ((i, _), (j, _)), kernel in self.kernels.items():
            kernels[..., self.directions.index(i), self.directions.index(j)] += kernel
        return kernels

    @property
    def _on_ring(self) -> Array:
        """The same kernels at the lags around a ring, shape (*padded, m, m)."""
        places = []
        for size, n in zip(self.padded, self.shape, strict=True):
            lags = np.arange(size)
            lags = np.where(lags > size // 2, lags - size, lags)
            places.append(n - 1 + np.clip(lags, 1 - n, n - 1))
        return self._without_factors[np.ix_(*places)]

    @property
    def padded(self) -> tuple[int, int]:
        """Numbers of elements along x and s in the transforms."""
        lags_x, lags_s = (2 * n - 1 for n in self.shape)
        return fft.next_fast_len(lags_x, real=True), fft.next_fast_len(lags_s, real=True)

    @cached_property
    def _transformed(self) -> dict[tuple[Place, Place], Complex]:
        """The transforms of the kernels."""
        n_x, n_s = self.shape
        transformed = {}
        for places, kernel in self.kernels.items():
            wrapped = np.zeros(self.padded)
            wrapped[: 2 * n_x - 1, : 2 * n_s - 1] = kernel
            transformed[places] = fft.rfft2(np.roll(wrapped, (1 - n_x, 1 - n_s), axis=(0, 1)))
        return transformed


def merged(kernel: Array, axis: int) -> Array:
    """Return a kernel between pairs of elements: mean displacements due to equal tractions on a pair.

    Lags run from -(n - 1) to n - 1 along `axis`; lags of pairs are even lags of elements.
    """
    kernel = np.moveaxis(kernel, axis, 0)
    n = (len(kernel) + 1) // 2
    centre = n - 1
    lags = centre + 2 * np.arange(1 - n // 2, n // 2)
    pairs = (kernel[lags - 1] + 2 * kernel[lags] + kernel[lags + 1]) / 2
    return np.asarray(np.moveaxis(pairs, 0, axis))
