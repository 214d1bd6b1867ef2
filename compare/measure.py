"""The measure of errors: what a percentage means wherever femic shows or judges an error of ICs.

Error of a component: max |v - C| over a line as a share of the component itself, that is of max |C_ij|
over all lines. Where C_ij vanishes, v is tested as a zero: its error is a share of 0.05 max |C_nn| over
all lines. Beside it the weight, the same difference as a share of max |C_nn| on the line, says what it
can do to displacements. Refinement has a scale of its own: `femic.accuracy`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from femic.accuracy import FLOOR
from femic.reference import Estimated

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
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


@dataclass(frozen=True, eq=False)
class Measure:
    """What errors of the ICs of one body, or of both together, are shares of."""

    c: Array  # (3, 3, n) [mm/N], NaN where nothing was computed
    estimate: Array  # of its error, likewise
    nn: Array  # (n,) C_nn, or A_nn where C_nn was not computed
    lines: Mapping[str, slice]  # which of the n points belong to which line

    @classmethod
    def of(cls, c: Estimated, a_nn: Array, lines: Mapping[str, slice]) -> "Measure":
        """The measure of C; A_nn, (n,), takes the place of C_nn where that was not computed."""
        nn = a_nn if np.any(np.isnan(c.ic[2, 2])) else c.ic[2, 2]
        return cls(c.ic, c.estimate, nn, lines)

    @property
    def zero(self) -> Mask:
        """Which components vanish by symmetry, (3, 3)."""
        return by_symmetry(self._largest(self.c), self._nn)

    @property
    def vanishing(self) -> Mask:
        """Which components vanish, (3, 3): by symmetry, or below ten times their estimates."""
        return vanishes(self._largest(self.c), self._largest(self.estimate), self._nn)

    @property
    def scale(self) -> Array:
        """What errors are shares of [mm/N], (3, 3)."""
        return scale(self._largest(self.c), self.vanishing, self._nn)

    def shares(self, off: Array) -> OfLines:
        """Errors of a deviation (3, 3, n) from C per line."""
        scale = self.scale
        return {line: _largest(off[..., part]) / scale for line, part in self.lines.items()}

    def rms(self, off: Array) -> OfLines:
        """Roots of the mean squares of a deviation (3, 3, n) per line, shares of the same."""
        scale = self.scale
        return {
            line: np.sqrt(np.mean(off[..., part] ** 2, axis=-1)) / scale for line, part in self.lines.items()
        }

    def weights(self, off: Array) -> OfLines:
        """A deviation (3, 3, n) per line as a share of max |C_nn| there."""
        return {
            line: _largest(off[..., part]) / np.max(np.abs(self.nn[part]))
            for line, part in self.lines.items()
        }

    @property
    def _nn(self) -> float:
        return float(np.max(self._largest(self.nn)))

    def _largest(self, values: Array) -> Array:
        """The largest of all lines."""
        return np.max([_largest(values[..., part]) for part in self.lines.values()], axis=0)


def _largest(values: Array) -> Array:
    return np.asarray(np.max(np.abs(values), axis=-1))
