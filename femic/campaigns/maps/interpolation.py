"""Interpolation between the nodes of a grid with several axes, and its error at nodes that are left out.

Along each axis a polynomial goes through the nearest four nodes (cubic), so that a place needs few nodes of
a large map. The error is measured where it can be: each inner one of these nodes is left out, and predicted
from the others of its line. There the nodes are twice as far apart, so that a smooth function is predicted
about seven times worse than half way between nodes. A function with a kink is not: with one half way between
two nodes the polynomial errs by 3/8 there, and by 1/6 at each of the two when it is left out (slopes -1 and
1, nodes at distance 1). So the largest error of all these nodes counts `KINK` times.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import WrongInput

NEAREST = 4  # nodes along an axis through which a polynomial goes
KINK = (3 / 8) / (1 / 6)  # error at a kink half way between nodes over that on left-out nodes beside it
SPACINGS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"linear": np.asarray, "logarithmic": np.log, "inverse": lambda values: -1 / values}
)
FEWEST = 3  # nodes of an axis: fewer tell nothing about the error


@dataclass(frozen=True, eq=False)
class Stencil:
    """Numbers (k,) of nodes along an axis, and their weights (k,), whose sum is 1."""

    nodes: Indices
    weights: Array


@dataclass(frozen=True)
class AxisNodes:
    """The increasing values of an axis, and how distances between them are measured: `SPACINGS`.

    Raises WrongInput where there are fewer than `FEWEST`, they do not increase, or are not positive where
    they have to be.
    """

    name: str
    values: tuple[float, ...]
    spacing: str = "linear"

    def __post_init__(self) -> None:
        increasing = all(a < b for a, b in pairwise(self.values))
        positive = self.spacing == "linear" or self.values[0] > 0
        if len(self.values) < FEWEST or not increasing or not positive:
            raise WrongInput(
                f"axis {self.name}, {len(self.values)} values: a map needs {FEWEST} or more that increase"
                f"{'' if positive else ', all positive'}"
            )

    @property
    def places(self) -> Array:
        """The places of the nodes on the scale of `spacing`, (n,)."""
        return self._places(np.array(self.values))

    def at(self, value: float) -> Stencil:
        """Return the stencil of a value; raise WrongInput outside the axis."""
        low, high = self.values[0], self.values[-1]
        if not low <= value <= high:
            raise WrongInput(f"{self.name} = {value:g}: outside the map, {low:g} ... {high:g}")
        if value in self.values:
            return Stencil(np.array([self.values.index(value)]), np.ones(1))
        return self._through(np.arange(len(self.values)), float(self._places(np.array(value))))

    def left_out(self, value: float) -> list[tuple[int, Stencil]]:
        """Return the inner nodes among the nearest to a value, each with the stencil that predicts it."""
        everywhere, place = np.arange(len(self.values)), float(self._places(np.array(value)))
        nearest = self._through(everywhere, place).nodes
        return [(int(node), self.without(int(node))) for node in nearest if 0 < node < len(everywhere) - 1]

    def neighbours(self, value: float) -> list[Stencil]:
        """Return the stencils of the nodes on both sides of a value."""
        place = float(self._places(np.array(value)))
        below = int(np.searchsorted(self.places, place, "right")) - 1
        low = min(max(below, 0), len(self.values) - 2)
        return [self.single(node) for node in (low, low + 1)]

    def single(self, node: int) -> Stencil:
        """Return the stencil of a single node."""
        return Stencil(np.array([node]), np.ones(1))

    def without(self, node: int) -> Stencil:
        """Return the stencil of the other nodes that predicts an inner node."""
        everywhere = np.arange(len(self.values))
        return self._through(everywhere[everywhere != node], float(self.places[node]))

    def _places(self, values: Array) -> Array:
        return SPACINGS[self.spacing](values)

    def _through(self, allowed: Indices, place: float) -> Stencil:
        """Return the polynomial through the nearest of some nodes at a place."""
        nearest = np.argsort(np.abs(self.places[allowed] - place), kind="stable")[:NEAREST]
        chosen = np.sort(allowed[nearest])
        at = self.places[chosen]
        weights = [np.prod([(place - b) / (a - b) for b in at if b != a]) for a in at]
        return Stencil(chosen, np.array(weights))


def interpolate(values: Array, stencils: list[Stencil]) -> Array:
    """Return the sum of values (k_1, ..., k_m, ...) at the nodes of stencils, times their weights."""
    for stencil in stencils:
        values = np.tensordot(stencil.weights, values, axes=(0, 0))
    return np.asarray(values)
