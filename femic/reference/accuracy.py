"""The scale of refinement, of which a tolerance is a share.

The error of a component on a line is max |error of C|, divided by the larger of max |C_ij| and 0.05 max
|C_nn| on that line, body by body. Without the floor, components that vanish or nearly vanish would be refined
without end. Errors of approximations are not measured on this scale but as shares of C itself, however small
C is, see `femic.ic_errors.error_measure`. Theory: docs/theory/errors.md.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import indices

FLOOR = 0.05  # least scale as a share of max |C_nn| on the line


class NotConverged(Failure):
    """A result does not reach its accuracy; the message has the numbers and the remedies."""


def line_scale(c_line: Array, nn_line: Array) -> Array:
    """Return the scale of refinement [mm/N] on a line, (3, 3), from the ICs (3, 3, n) and C_nn (n,) there."""
    return np.maximum(np.max(np.abs(c_line), axis=-1), FLOOR * np.max(np.abs(nn_line)))


def line_errors(difference: Array, c_line: Array, nn_line: Array) -> Array:
    """Return the largest error of each component on a line as a share of its scale, (3, 3)."""
    return np.asarray(np.max(np.abs(difference), axis=-1) / line_scale(c_line, nn_line))


def component_of(values: NDArray[Any], component: str) -> float:
    """Return the entry of (3, 3) values for a component: "xn" is displacement x due to traction n."""
    return float(values[indices(component)])


@dataclass(frozen=True)
class Shares:
    """Largest estimated errors on the scale of refinement: each part, and their sum."""

    mesh: float
    truncation: float
    waves: float
    total: float
    component: str  # the component whose sum is worst
    line: str  # its line
