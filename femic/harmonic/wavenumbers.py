"""Which wavenumbers are solved, and the responses between them.

Responses are smooth in t = asinh(k / scale): like ln k beyond the scale, even or odd in k below it. Between
the solved wavenumbers they are splines of fifth degree. An interval is halved until the spline meets the
response in its middle: how wrong it was there, and how far that reaches into the displacements, decides.
On a closed ring only k = m / R exists, m = 0, 1, 2, ...; m = 0 and 1, which may move the ring as a whole, are
solved and not interpolated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import make_interp_spline

from femic.accuracy import NotConverged
from geometries.arrays import Array, Mask

DEGREE = 5
FIRST = 1.2  # first spacing in t
FEWEST = 8  # orders of a ring that are solved in any case, m = 0, 1, ...; 3 of a large one
MOST = 1000  # wavenumbers
GAIN = 64  # the error of an interval falls by about this factor where it is halved


@dataclass(frozen=True)
class Axis:
    """Wavenumbers 0 ... k_max [1/mm] of an endless body, or the orders among them of a ring [mm]."""

    scale: float
    k_max: float
    radius: float = np.inf

    def first(self) -> Array:
        """Wavenumbers to begin with, both ends among them."""
        end = np.arcsinh(self.k_max / self.scale)
        k = self.scale * np.sinh(np.linspace(0, end, max(int(np.ceil(end / FIRST)), DEGREE) + 1))
        if np.isinf(self.radius):
            return np.asarray(k)
        last = np.floor(self.k_max * self.radius)
        fewest = 3 if self.radius * self.scale > 1 else FEWEST
        orders = np.append(np.round(k * self.radius), np.arange(fewest))
        return np.unique(np.minimum(orders, last)) / self.radius

    def between(self, low: float, high: float) -> float | None:
        """The wavenumber in the middle of two; None where a ring has none."""
        k = float(self.scale * np.sinh(np.mean(np.arcsinh(np.array([low, high]) / self.scale))))
        if np.isinf(self.radius):
            return k
        first, last = round(low * self.radius) + 1, round(high * self.radius) - 1
        return float(np.clip(round(k * self.radius), first, last)) / self.radius if first <= last else None

    def interpolation(self, nodes: Array, at: Array) -> tuple[Array, Array]:
        """Matrices (len(at), len(nodes)) from values at nodes to those at other k: of even, of odd ones."""
        if np.isinf(self.radius):
            return self._mirrored(nodes, at, +1), self._mirrored(nodes, at, -1)
        rigid = nodes < 1.5 / self.radius
        matrix = np.zeros((len(at), len(nodes)))
        for order in np.flatnonzero(rigid):
            matrix[np.round(at * self.radius) == order, order] = 1.0
        others = at * self.radius > 1.5
        elastic = nodes[~rigid]
        matrix[np.ix_(others, ~rigid)] = self._spline(elastic, np.eye(len(elastic)), at[others])
        return matrix, matrix

    def _mirrored(self, nodes: Array, at: Array, parity: int) -> Array:
        """Splines through the nodes and their mirror images."""
        identity = np.eye(len(nodes))
        both = np.append(-nodes[:0:-1], nodes)
        return self._spline(both, np.vstack([parity * identity[:0:-1], identity]), at)

    def _spline(self, nodes: Array, values: Array, at: Array) -> Array:
        spline = make_interp_spline(np.arcsinh(nodes / self.scale), values, k=DEGREE)
        return np.asarray(spline(np.arcsinh(at / self.scale)))


@dataclass(frozen=True, eq=False)
class Sampled:
    """Responses (n, ...) at the solved wavenumbers k (n,), and which of them came last in their interval."""

    axis: Axis
    k: Array
    responses: Array
    last: Mask

    @property
    def sparser(self) -> "Sampled":
        """Without those that came last."""
        k = self.k[~self.last]
        return Sampled(self.axis, k, self.responses[~self.last], np.zeros(len(k), dtype=bool))


def sampled(
    axis: Axis,
    solve: Callable[[Sequence[float]], Sequence[Array]],
    odd: Mask,
    a: float,
    accuracy: Array | float,
) -> Sampled:
    """Solve as many wavenumbers as the displacements need.

    `solve` gives responses to unit loads at some wavenumbers, `odd` says which of their entries are odd in
    k, `a` [mm] is the half-length of the loads. The error of each interval is brought below `accuracy`
    [mm/N], one or one each (it and `odd` broadcast with responses); they alternate. Raises NotConverged
    beyond MOST.
    """
    first = axis.first().tolist()
    found = dict(zip(first, solve(first), strict=True))
    open_intervals = list(pairwise(first))
    halved: dict[float, tuple[float, float]] = {}
    while open_intervals:
        halves = {k: ends for ends in open_intervals if (k := axis.between(*ends)) is not None}
        if len(found) + len(halves) > MOST:
            raise NotConverged(
                f"more than {MOST} wavenumbers would be needed for displacements within "
                f"{np.min(accuracy):.1e} mm/N: "
                "give a larger `tolerance`, or shorter lines"
            )
        expected = _interpolated(axis, found, odd, list(halves))
        new = dict(zip(halves, solve(list(halves)), strict=True))
        wrong = {k: np.max(np.abs(new[k] - guess) / accuracy) for k, guess in zip(new, expected, strict=True)}
        found |= new
        halved |= halves
        open_intervals = []
        for middle, (low, high) in halves.items():
            reach = (high - low) / np.pi * min(1.0, 1 / (middle * a))
            if wrong[middle] * reach / GAIN > 1:
                open_intervals += [(low, middle), (middle, high)]
    solved, inner = sorted(found), {end for ends in halved.values() for end in ends}
    last = np.array([k in halved and k not in inner for k in solved])
    return Sampled(axis, np.array(solved), np.stack([found[k] for k in solved]), last)


def _interpolated(axis: Axis, found: dict[float, Array], odd: Mask, at: list[float]) -> list[Array]:
    nodes = sorted(found)
    responses = np.stack([found[k] for k in nodes])
    even_matrix, odd_matrix = axis.interpolation(np.array(nodes), np.array(at))
    even_values, odd_values = (np.tensordot(m, responses, axes=1) for m in (even_matrix, odd_matrix))
    return list(np.where(odd, odd_values, even_values))
