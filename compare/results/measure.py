"""The measure of errors: what a percentage means wherever femic shows or judges an error of ICs.

Error of a component: max |v - C| over a line as a share of the component itself. That is max |C_ij| over
the points of all lines that are `NEAR_ELEMENTS` from the load and further; an error nearer is a share of
max |C_ij| over all points. (With one scale for both, the peak under the load would make little of all errors
away from it, in all scenes that have a line through the load, and in no others.) Where C_ij vanishes, v is
tested as a zero: its error is a share of 0.05 max |C_nn| over the same points. Beside it the weight, the same
difference as a share of max |C_nn| on the line, says what it can do to displacements. Refinement has a
scale of its own: `femic.accuracy`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from femic.accuracy import FLOOR
from femic.estimate import Estimated
from femic.matrix.columns import NEAR_ELEMENTS
from geometries.arrays import Array, Mask
from geometries.patches import Patch

OfLines = dict[str, Array]  # (3, 3) by line

ROUNDING = 1e-9  # share of max |C_nn|: what is smaller vanishes by symmetry
KNOWN = 10.0  # times its estimate: a component that is smaller cannot be told from zero


def by_symmetry(size: Array, of_nn: float) -> Mask:
    """Whether components (3, 3) of the largest value `size` are nothing but rounding beside C_nn."""
    return np.asarray(size < ROUNDING * of_nn)


def vanishes(size: Array, estimate: Array, of_nn: float) -> Mask:
    """Whether they are zeros: by symmetry, or as far as can be told of what is known to `estimate`."""
    return by_symmetry(size, of_nn) | (size < KNOWN * estimate)


def scale(size: Array, vanishing: Mask, of_nn: float) -> Array:
    """What errors of components (3, 3) are shares of: themselves, or 0.05 max |C_nn|."""
    return np.where(vanishing, FLOOR * of_nn, size)


def far_from(patch: Patch, x: Array, s: Array) -> Mask:
    """Which of some points (n,) [mm] lie `NEAR_ELEMENTS`, of the size of a patch, from it and further."""
    elements = np.hypot(x / (2 * patch.a), (s - patch.s) / (2 * patch.b))
    return np.asarray(elements > (1 - ROUNDING) * NEAR_ELEMENTS)


@dataclass(frozen=True, eq=False)
class Measure:
    """What errors of the ICs of one body, or of both together, are shares of."""

    c: Array  # (3, 3, n) [mm/N], NaN where nothing was computed
    estimate: Array  # of its error, likewise
    nn: Array  # (n,) C_nn, or A_nn where C_nn was not computed
    lines: Mapping[str, slice]  # which of the n points belong to which line
    far: Mask  # (n,) which lie far from the load

    @classmethod
    def of(cls, c: Estimated, a_nn: Array, lines: Mapping[str, slice], far: Mask) -> "Measure":
        """The measure of C; A_nn, (n,), takes the place of C_nn where that was not computed."""
        nn = a_nn if np.any(np.isnan(c.ic[2, 2])) else c.ic[2, 2]
        return cls(c.ic, c.estimate, nn, lines, far)

    @property
    def zero(self) -> Mask:
        """Which components vanish by symmetry, (3, 3)."""
        return by_symmetry(_largest(self.c[..., self._far]), self._nn(self._far))

    @property
    def vanishing(self) -> Mask:
        """Which components vanish, (3, 3): by symmetry, or below ten times their estimates."""
        size, estimate = (_largest(values[..., self._far]) for values in (self.c, self.estimate))
        return vanishes(size, estimate, self._nn(self._far))

    @property
    def scale(self) -> Array:
        """What errors at each point are shares of [mm/N], (3, 3, n)."""
        away, near = (
            scale(_largest(self.c[..., points]), self.vanishing, self._nn(points))[..., None]
            for points in (self._far, self._on_lines)
        )
        return np.where(self.far, away, near)

    def shares(self, off: Array) -> OfLines:
        """Errors of a deviation (3, 3, n) from C per line."""
        shares = off / self.scale
        return {line: _largest(shares[..., part]) for line, part in self.lines.items()}

    def rms(self, off: Array) -> OfLines:
        """Roots of the mean squares of a deviation (3, 3, n) per line, shares of the same."""
        shares = off / self.scale
        return {line: np.sqrt(np.mean(shares[..., part] ** 2, axis=-1)) for line, part in self.lines.items()}

    def weights(self, off: Array) -> OfLines:
        """A deviation (3, 3, n) per line as a share of max |C_nn| there."""
        return {
            line: _largest(off[..., part]) / np.max(np.abs(self.nn[part]))
            for line, part in self.lines.items()
        }

    @property
    def _on_lines(self) -> Mask:
        """The points of all lines, (n,)."""
        on = np.zeros(len(self.nn), dtype=bool)
        for part in self.lines.values():
            on[part] = True
        return on

    @property
    def _far(self) -> Mask:
        """Those far from the load; all of them where none is."""
        on = self._on_lines
        return on & self.far if np.any(on & self.far) else on

    def _nn(self, points: Mask) -> float:
        return float(np.max(np.abs(self.nn[points])))


def _largest(values: Array) -> Array:
    return np.asarray(np.max(np.abs(values), axis=-1))
