"""How far approximations of an IC matrix are from C: entry by entry, and under tractions on all elements."""

from dataclasses import dataclass

import numpy as np

from compare.results.measure import scale, vanishes
from femic.estimate import Estimated
from geometries.arrays import Array, Mask
from geometries.patches import N


@dataclass(frozen=True, eq=False)
class Column:
    """C due to unit loads on a strip, arrays (3, 3, n_x, n_s), and what is far from that strip."""

    c: Estimated
    far: Mask  # (n_x, n_s): `femic.matrix.columns.NEAR_ELEMENTS` from the load and further
    a_nn: Array  # (n_x, n_s) [mm/N]


@dataclass(frozen=True, eq=False)
class Deviation:
    """What is wrong with an approximation, strip by strip; of C itself: what its estimate says.

    Far from the load the largest values, (3, 3); nearer shares of A_nn; sums over loaded strips and lags of
    both signs, (3, 3, n_s), which is what tractions of 1 everywhere, of the worst signs, make of them.
    """

    far_off: Array  # of |V - C|
    far_c: Array
    far_known: Array  # of the estimate of C
    near: Array  # of |V - C| / A_nn
    off: Array  # sums of |V - C|
    c: Array
    known: Array

    @classmethod
    def none(cls, n_s: int) -> "Deviation":
        """Before the first strip."""
        return cls(*(np.zeros((3, 3)) for _ in range(4)), *(np.zeros((3, 3, n_s)) for _ in range(3)))

    def with_column(self, difference: Array, column: Column) -> "Deviation":
        """With the column of one more loaded strip, difference (3, 3, n_x, n_s)."""
        c, far = column.c, column.far
        largest = (
            np.maximum(so_far, np.max(np.abs(values), axis=(2, 3)))
            for so_far, values in (
                (self.far_off, difference * far),
                (self.far_c, c.ic * far),
                (self.far_known, c.estimate * far),
                (self.near, difference * ~far / column.a_nn),
            )
        )
        both_sides = np.where(np.arange(c.ic.shape[2]) == 0, 1.0, 2.0)[:, None]
        sums = (
            so_far + np.sum(both_sides * np.abs(values), axis=2)
            for so_far, values in ((self.off, difference), (self.c, c.ic), (self.known, c.estimate))
        )
        return Deviation(*largest, *sums)

    @property
    def worst(self) -> Array:
        """Largest error of an entry far from the load, share of the largest one of the same component."""
        if not np.any(self.far_c):  # a grid that has nothing far from the load
            return np.full((3, 3), np.nan)
        return self.far_off / scale(self.far_c, self.vanishing, self.far_c[N, N])

    @property
    def vanishing(self) -> Mask:
        """Which components of C vanish far from the load, (3, 3)."""
        return vanishes(self.far_c, self.far_known, self.far_c[N, N])

    @property
    def under_tractions(self) -> Array:
        """Largest error of displacements that tractions up to 1 can cause, over the largest under p_n."""
        return self._caused(self.off) / self._caused(self.c)[N, N]

    @property
    def under_tractions_of_itself(self) -> Array:
        """The same over what the component itself can cause."""
        c = self._caused(self.c)
        return self._caused(self.off) / scale(c, self.causes_nothing, c[N, N])

    @property
    def causes_nothing(self) -> Mask:
        """Which components of C cannot cause anything that C knows."""
        c = self._caused(self.c)
        return vanishes(c, self._caused(self.known), c[N, N])

    @staticmethod
    def _caused(sums: Array) -> Array:
        """The largest of all observing strips."""
        return np.asarray(np.max(sums, axis=2))
