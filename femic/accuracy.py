"""The scale of refinement: what a tolerance is a share of.

max |error of C| over a line, divided by the larger of max |C_ij| and 0.05 max |C_nn| on that line, body by
body. The floor is against 0/0: without it components that vanish, or nearly do, would ask for endless
cells. It is no measure of approximations: what they lack of a small C is a share of C itself, see
`compare.results.measure`. Design section 2.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import DIRECTIONS

FLOOR = 0.05


class NotConverged(Failure):
    """A result is not as accurate as it must be; the message has the numbers and what to try."""


def line_scale(c_line: Array, nn_line: Array) -> Array:
    """Scale of refinement, (3, 3), of ICs (3, 3, n) on a line; nn_line (n,) is C_nn there."""
    return np.maximum(np.max(np.abs(c_line), axis=-1), FLOOR * np.max(np.abs(nn_line)))


def line_errors(difference: Array, c_line: Array, nn_line: Array) -> Array:
    """Largest share of it per component on a line, shape (3, 3), of an error of C (3, 3, n)."""
    return np.asarray(np.max(np.abs(difference), axis=-1) / line_scale(c_line, nn_line))


def component_of(values: NDArray[Any], component: str) -> float:
    """The entry of (3, 3) values that a component names: "xn" is displacement x, traction n."""
    i, j = (DIRECTIONS.index(letter) for letter in component)
    return float(values[i, j])


@dataclass(frozen=True)
class Shares:
    """How large an estimated error is at worst, on the scale of refinement: parts and their sum."""

    mesh: float
    truncation: float
    waves: float
    total: float
    component: str  # where the sum is worst
    line: str
