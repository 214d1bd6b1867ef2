"""Interpolation between the nodes of a grid with several axes, and its error on nodes that are left out.

Along each axis a polynomial goes through the nearest four nodes (cubic), so that a place needs few nodes of
a large map. The error is measured where it can be: a node next to the place is left out, and predicted from
the others of its line. There the nodes are twice as far apart, so that a smooth function is predicted about
seven times worse than half way between nodes.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometries.arrays import Array, Indices
from geometries.errors import WrongInput

NEAREST = 4  # nodes along an axis through which a polynomial goes
FEWEST = 3  # nodes of an axis: fewer tell nothing about the error


@dataclass(frozen=True, eq=False)
class Stencil:
    """Numbers (k,) of nodes along an axis, and their weights (k,), whose sum is 1."""

    nodes: Indices
    weights: Array


@dataclass(frozen=True)
class Nodes:
    """The values of an axis, growing; distances are those of logarithms where `logarithmic`.

    Raises WrongInput where there are fewer than `FEWEST`, or they do not grow.
    """

    name: str
    values: tuple[float, ...]
    logarithmic: bool = False

    def __post_init__(self) -> None:
        growing = all(a < b for a, b in pairwise(self.values))
        if len(self.values) < FEWEST or not growing or (self.logarithmic and self.values[0] <= 0):
            raise WrongInput(
                f"axis {self.name}, {len(self.values)} values: a map needs {FEWEST} or more that grow"
                f"{', all positive' if self.logarithmic else ''}"
            )

    @property
    def places(self) -> Array:
        """Where the nodes are, (n,)."""
        return self._places(np.array(self.values))

    def at(self, value: float) -> Stencil:
        """The nodes that make up a value; raises WrongInput outside the axis."""
        low, high = self.values[0], self.values[-1]
        if not low <= value <= high:
            raise WrongInput(f"{self.name} = {value:g}: outside the map, {low:g} ... {high:g}")
        if value in self.values:
            return Stencil(np.array([self.values.index(value)]), np.ones(1))
        return self._through(np.arange(len(self.values)), float(self._places(np.array(value))))

    def left_out(self, value: float) -> list[tuple[int, Stencil]]:
        """The inner nodes next to a value, each with the others that predict it."""
        places = self.places
        below = int(np.searchsorted(places, float(self._places(np.array(value))), "right")) - 1
        inner = {min(max(node, 1), len(places) - 2) for node in (below, below + 1)}
        everywhere = np.arange(len(places))
        return [
            (node, self._through(everywhere[everywhere != node], float(places[node])))
            for node in sorted(inner)
        ]

    def _places(self, values: Array) -> Array:
        return np.log(values) if self.logarithmic else values

    def _through(self, allowed: Indices, place: float) -> Stencil:
        """The polynomial through the nearest of some nodes at a place."""
        nearest = np.argsort(np.abs(self.places[allowed] - place), kind="stable")[:NEAREST]
        chosen = np.sort(allowed[nearest])
        at = self.places[chosen]
        weights = [np.prod([(place - b) / (a - b) for b in at if b != a]) for a in at]
        return Stencil(chosen, np.array(weights))


def combined(values: Array, stencils: list[Stencil]) -> Array:
    """Sum of the values (k_1, ..., k_m, ...) at the nodes of stencils, times their weights."""
    for stencil in stencils:
        values = np.tensordot(stencil.weights, values, axes=(0, 0))
    return np.asarray(values)
