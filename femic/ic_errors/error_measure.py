"""The measure of errors of ICs: the meaning of every percentage that femic shows or decides by.

The error of a component of ICs v is max |v - C| over a line as a share of the component itself: of
max |C_ij| over the points of all lines that are `NEAR_ELEMENTS` or more from the load. At points nearer to
the load it is a share of max |C_ij| over all points. (With one scale for both, the peak under the load would
make all errors away from it look small, in all scenes that have a line through the load, and in no others.)
Where C_ij vanishes, v is tested as a zero: its error is a share of 0.05 max |C_nn| over the same points. The
weight of an error is the same difference as a share of max |C_nn| on the line; it says what the error can do
to displacements. Refinement has a scale of its own: `femic.reference.job`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from femic.reference.job import FLOOR
from femic.reference.matrix.reference import NEAR_ELEMENTS
from femic.reference.result import EstimatedICs
from geometries.arrays import Array, Mask
from geometries.patches import Patch

ByLine = dict[str, Array]  # (3, 3) by line

ROUNDING = 1e-9  # share of max |C_nn|: a smaller component vanishes by symmetry
SIGNIFICANT = 10.0  # times its estimate: a smaller component cannot be distinguished from zero


def vanish_by_symmetry(size: Array, largest_nn: float) -> Mask:
    """Return which components vanish by symmetry, (3, 3): their largest values `size` are rounding."""
    return np.asarray(size < ROUNDING * largest_nn)


def vanishes(size: Array, estimate: Array, largest_nn: float) -> Mask:
    """Return which components vanish, (3, 3): by symmetry, or below `SIGNIFICANT` times their estimate.

    `size`: largest values (3, 3) of the components; `estimate`: of their errors; `largest_nn`: max |C_nn|.
    """
    return vanish_by_symmetry(size, largest_nn) | (size < SIGNIFICANT * estimate)


def scale(size: Array, vanishing: Mask, largest_nn: float) -> Array:
    """Return the scale of errors of components, (3, 3): their size, or 0.05 max |C_nn| where they vanish."""
    return np.where(vanishing, FLOOR * largest_nn, size)


def far_from(patch: Patch, x: Array, s: Array) -> Mask:
    """Return which points (n,) [mm] lie at least `NEAR_ELEMENTS` elements of a patch's size from it, (n,)."""
    elements = np.hypot(x / (2 * patch.a), (s - patch.s) / (2 * patch.b))
    return np.asarray(elements > (1 - ROUNDING) * NEAR_ELEMENTS)


@dataclass(frozen=True, eq=False)
class Measure:
    """The measure of errors of the ICs of one body, or of both together."""

    c: Array  # (3, 3, n) [mm/N], NaN where nothing was computed
    estimate: Array  # of its error, (3, 3, n) [mm/N], likewise
    nn: Array  # (n,) [mm/N] C_nn, or A_nn where C_nn was not computed
    lines: Mapping[str, slice]  # which of the n points belong to which line
    far: Mask  # (n,) which points lie far from the load

    @classmethod
    def against(cls, c: EstimatedICs, a_nn: Array, lines: Mapping[str, slice], far: Mask) -> "Measure":
        """Return the measure of ICs C; A_nn, (n,) [mm/N], replaces C_nn where C_nn was not computed."""
        nn = a_nn if np.any(np.isnan(c.ic[2, 2])) else c.ic[2, 2]
        return cls(c.ic, c.estimate, nn, lines, far)

    @property
    def zero_by_symmetry(self) -> Mask:
        """Which components vanish by symmetry, (3, 3)."""
        return vanish_by_symmetry(_largest(self.c[..., self._far]), self._nn(self._far))

    @property
    def vanishing(self) -> Mask:
        """Which components vanish, (3, 3): by symmetry, or below ten times their estimates."""
        size, estimate = (_largest(values[..., self._far]) for values in (self.c, self.estimate))
        return vanishes(size, estimate, self._nn(self._far))

    @property
    def scale(self) -> Array:
        """The scale of errors at each point [mm/N], (3, 3, n)."""
        far_scale, near_scale = (
            scale(_largest(self.c[..., points]), self.vanishing, self._nn(points))[..., None]
            for points in (self._far, self._on_lines)
        )
        return np.where(self.far, far_scale, near_scale)

    def shares(self, deviation: Array) -> ByLine:
        """Return errors of the components, (3, 3) per line, due to a deviation from C, (3, 3, n) [mm/N]."""
        shares = deviation / self.scale
        return {line: _largest(shares[..., part]) for line, part in self.lines.items()}

    def rms(self, deviation: Array) -> ByLine:
        """Return root mean squares, (3, 3) per line, of a deviation (3, 3, n) [mm/N], on the same scale."""
        shares = deviation / self.scale
        return {line: np.sqrt(np.mean(shares[..., part] ** 2, axis=-1)) for line, part in self.lines.items()}

    def weights(self, deviation: Array) -> ByLine:
        """Return weights, (3, 3) per line, of a deviation (3, 3, n) [mm/N], over max |C_nn| on the line."""
        return {
            line: _largest(deviation[..., part]) / np.max(np.abs(self.nn[part]))
            for line, part in self.lines.items()
        }

    @cached_property
    def _on_lines(self) -> Mask:
        """The points of all lines, (n,)."""
        on_lines = np.zeros(len(self.nn), dtype=bool)
        for part in self.lines.values():
            on_lines[part] = True
        return on_lines

    @cached_property
    def _far(self) -> Mask:
        """The points of all lines that lie far from the load, (n,); all points of lines if none does."""
        far = self._on_lines & self.far
        return far if np.any(far) else self._on_lines

    def _nn(self, points: Mask) -> float:
        """Return max |C_nn| over some points [mm/N]."""
        return float(np.max(np.abs(self.nn[points])))


def _largest(values: Array) -> Array:
    """Return largest absolute values over the points, (3, 3), of values (3, 3, n)."""
    return np.asarray(np.max(np.abs(values), axis=-1))
