"""The scale of refinement, of which a tolerance is a share.

The error of a component on a line is max |error of C|, divided by the larger of max |C_ij| and 0.05 max
|C_nn| on that line, body by body. The floor keeps components that vanish, or nearly do, from asking for
endless cells. The scale does not measure approximations: their errors are shares of C itself, however small C
is, see `compare.ics.error_measure`. Theory: docs/theory/errors.md.
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
    """A result is not as accurate as it must be; the message has the numbers and what to try."""


def line_scale(c_line: Array, nn_line: Array) -> Array:
    """Scale of refinement [mm/N] on a line, shape (3, 3), of ICs (3, 3, n) there; nn_line (n,) is C_nn."""
    return np.maximum(np.max(np.abs(c_line), axis=-1), FLOOR * np.max(np.abs(nn_line)))


def line_errors(difference: Array, c_line: Array, nn_line: Array) -> Array:
    """Largest error per component on a line as a share of its scale, shape (3, 3); errors: (3, 3, n)."""
    return np.asarray(np.max(np.abs(difference), axis=-1) / line_scale(c_line, nn_line))


def component_of(values: NDArray[Any], component: str) -> float:
    """The entry of (3, 3) values that a component names: "xn" is displacement x, traction n."""
    return float(values[indices(component)])


@dataclass(frozen=True)
class Shares:
    """Largest estimated errors on the scale of refinement: of the parts, and of their sum."""

    mesh: float
    truncation: float
    waves: float
    total: float
    component: str  # the component whose sum is worst
    line: str  # the line on which it is
