"""Deviations of approximate IC matrices from C: of entries, and of displacements under tractions."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from femic.ic_errors.error_measure import scale, vanishes
from femic.reference.result import EstimatedICs
from geometries.arrays import Array, Mask
from geometries.patches import N


@dataclass(frozen=True, eq=False)
class ReferenceColumn:
    """C due to unit loads on a strip, and which elements are far from that strip."""

    c: EstimatedICs  # arrays (3, 3, n_x, n_s) [mm/N]
    far: Mask  # (n_x, n_s): at least `femic.reference.matrix.reference.NEAR_ELEMENTS` elements from the load
    a_nn: Array  # (n_x, n_s) [mm/N]

    @cached_property
    def _known(self) -> tuple[Array, Array, Array, Array]:
        """Largest |C| and largest estimate far from the load, (3, 3), and sums of both, (3, 3, n_s)."""
        magnitude, estimate = np.abs(self.c.ic), self.c.estimate
        return (
            self._find_largest(magnitude),
            self._find_largest(estimate),
            self._add_lags(magnitude),
            self._add_lags(estimate),
        )

    def deviation(self, difference: Array) -> "Deviation":
        """Return the deviation of this loaded strip; difference from C (3, 3, n_x, n_s) [mm/N]."""
        magnitude = np.abs(difference)
        near = np.max(magnitude[..., ~self.far] / self.a_nn[~self.far], axis=-1)
        return Deviation(self._find_largest(magnitude), near, self._add_lags(magnitude), *self._known)

    def _find_largest(self, magnitude: Array) -> Array:
        return np.asarray(np.max(magnitude * self.far, axis=(2, 3)))

    @staticmethod
    def _add_lags(magnitude: Array) -> Array:
        """Sums (3, 3, n_s) over lags of both signs."""
        return np.asarray(2 * np.sum(magnitude, axis=2) - magnitude[:, :, 0])


@dataclass(frozen=True, eq=False)
class Deviation:
    """Largest values and sums over the entries of an approximation V of C, accumulated over loaded strips.

    For C itself, V - C is its estimated error. Largest values are (3, 3). Sums, (3, 3, n_s) by observing
    strip, are over loaded strips and lags of both signs: displacements under tractions of 1 on all elements,
    with the worst signs.
    """

    far_difference: Array  # largest |V - C| far from the load [mm/N]
    near: Array  # largest |V - C| / A_nn nearer to the load
    difference_sums: Array  # sums of |V - C| [mm/N]
    far_c: Array  # largest |C| far from the load [mm/N]
    far_estimate: Array  # largest estimate of C's error there [mm/N]
    c_sums: Array  # sums of |C| [mm/N]
    estimate_sums: Array  # sums of the estimate of C's error [mm/N]

    def merge(self, other: "Deviation") -> "Deviation":
        """Return the deviation of the loaded strips of both."""
        parts = {}
        for name in (field.name for field in fields(self)):
            accumulate = np.add if name.endswith("sums") else np.maximum
            parts[name] = accumulate(getattr(self, name), getattr(other, name))
        return Deviation(**parts)

    @property
    def worst(self) -> Array:
        """Largest error of an entry far from the load, (3, 3): share of the component's largest entry there.

        It is a share of 0.05 max |C_nn| where the component vanishes, and NaN where no entry is far.
        """
        if not np.any(self.far_c):  # no element of the grid is far from the load
            return np.full((3, 3), np.nan)
        return self.far_difference / scale(self.far_c, self.vanishing, self.far_c[N, N])

    @property
    def vanishing(self) -> Mask:
        """Which components of C vanish far from the load, (3, 3)."""
        return vanishes(self.far_c, self.far_estimate, self.far_c[N, N])

    @property
    def displacement_error(self) -> Array:
        """Largest error of displacements under tractions up to 1, (3, 3).

        It is a share of the largest normal displacement that normal tractions up to 1 cause.
        """
        return _worst_strip(self.difference_sums) / _worst_strip(self.c_sums)[N, N]

    @property
    def own_displacement_error(self) -> Array:
        """The same errors, (3, 3), as shares of the displacements that the component itself can cause."""
        c = _worst_strip(self.c_sums)
        return _worst_strip(self.difference_sums) / scale(c, self.negligible, c[N, N])

    @property
    def negligible(self) -> Mask:
        """Which components, (3, 3), cause displacements that vanish or are below ten times their estimate."""
        c = _worst_strip(self.c_sums)
        return vanishes(c, _worst_strip(self.estimate_sums), c[N, N])


def _worst_strip(sums: Array) -> Array:
    """Return the largest displacement on any observing strip, (3, 3), from sums (3, 3, n_s)."""
    return np.asarray(np.max(sums, axis=2))
