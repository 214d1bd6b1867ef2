"""The choice of the wavenumbers that are solved, and the interpolation of the responses between them.

Responses are smooth in t = asinh(k / scale), which is like ln k beyond the scale; below it they are even or
odd in k. Between the solved wavenumbers they are interpolated by splines of fifth degree. An interval is
halved as long as the error of the spline in the middle of the interval changes the displacements too much.
On a closed ring only k = m / R exists, m = 0, 1, 2, ... The orders m = 0 and 1, which may move the ring as a
whole, are solved and not interpolated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from femic.reference.job import NotConverged
from geometries.arrays import Array, Mask

SPLINE_DEGREE = 5
FIRST_SPACING = 1.2  # spacing in t of the first wavenumbers
FEWEST_ORDERS = 8  # number of orders m = 0, 1, ... of a ring that are always solved; 3 for a large ring
MOST_WAVENUMBERS = 1000  # largest number of wavenumbers
HALVING_GAIN = 64  # approximate factor by which the error of an interval falls when it is halved


@dataclass(frozen=True)
class Axis:
    """The wavenumbers 0 ... k_max [1/mm] of an infinitely long body, or k = m / radius of a ring [mm].

    `scale` [1/mm] is the scale in t = asinh(k / scale).
    """

    scale: float
    k_max: float
    radius: float = np.inf

    def first(self) -> Array:
        """Wavenumbers [1/mm] to begin with, in growing order and with both ends, shape (n,)."""
        t_end = np.arcsinh(self.k_max / self.scale)
        k = self.scale * np.sinh(
            np.linspace(0, t_end, max(int(np.ceil(t_end / FIRST_SPACING)), SPLINE_DEGREE) + 1)
        )
        if np.isinf(self.radius):
            return np.asarray(k)
        last_order = np.floor(self.k_max * self.radius)
        fewest_orders = 3 if self.radius * self.scale > 1 else FEWEST_ORDERS
        orders = np.append(np.round(k * self.radius), np.arange(fewest_orders))
        return np.unique(np.minimum(orders, last_order)) / self.radius

    def between(self, low: float, high: float) -> float | None:
        """The wavenumber [1/mm] in the middle of two, or None where the ring has no order between them."""
        k = float(self.scale * np.sinh(np.mean(np.arcsinh(np.array([low, high]) / self.scale))))
        if np.isinf(self.radius):
            return k
        first_order, last_order = round(low * self.radius) + 1, round(high * self.radius) - 1
        if first_order > last_order:
            return None
        return float(np.clip(round(k * self.radius), first_order, last_order)) / self.radius

    def interpolation(self, nodes: Array, targets: Array) -> tuple[Array, Array]:
        """Return matrices that interpolate functions of k: the first even functions, the second odd ones.

        Each has shape (len(targets), len(nodes)) and maps values at the wavenumbers `nodes` to values at the
        wavenumbers `targets` [1/mm].
        """
        if np.isinf(self.radius):
            return self._mirrored(nodes, targets, +1), self._mirrored(nodes, targets, -1)
        rigid = nodes < 1.5 / self.radius
        matrix = np.zeros((len(targets), len(nodes)))
        for order in np.flatnonzero(rigid):
            matrix[np.round(targets * self.radius) == order, order] = 1.0
        elastic_targets = targets * self.radius > 1.5
        elastic_nodes = nodes[~rigid]
        matrix[np.ix_(elastic_targets, ~rigid)] = self._spline(
            elastic_nodes, np.eye(len(elastic_nodes)), targets[elastic_targets]
        )
        return matrix, matrix

    def _mirrored(self, nodes: Array, targets: Array, parity: int) -> Array:
        """The matrix of the spline through the nodes and their mirror images at -k, even (+1) or odd (-1)."""
        identity = np.eye(len(nodes))
        mirrored_nodes = np.append(-nodes[:0:-1], nodes)
        return self._spline(mirrored_nodes, np.vstack([parity * identity[:0:-1], identity]), targets)

    def _spline(self, nodes: Array, values: Array, targets: Array) -> Array:
        """Values at other wavenumbers by the spline in t through values at nodes."""
        spline = scipy.interpolate.make_interp_spline(np.arcsinh(nodes / self.scale), values, k=SPLINE_DEGREE)
        return np.asarray(spline(np.arcsinh(targets / self.scale)))


@dataclass(frozen=True, eq=False)
class Samples:
    """Responses (n, ...) at the solved wavenumbers k (n,) [1/mm].

    `last` (n,) marks the wavenumbers that were solved last in their interval.
    """

    axis: Axis
    k: Array
    responses: Array
    last: Mask

    @property
    def sparser(self) -> "Samples":
        """The samples without those that were solved last in their interval."""
        k = self.k[~self.last]
        return Samples(self.axis, k, self.responses[~self.last], np.zeros(len(k), dtype=bool))

    def changed(self, at_sparser: Array, odd: Mask) -> "Samples":
        """The samples changed to `at_sparser` (n_sparser, ...) at the wavenumbers of `sparser`.

        Between these the change is interpolated: where it is small, so is the error of that. `odd` marks the
        entries of a response that are odd in k.
        """
        sparser = self.sparser
        change = interpolated(self.axis, sparser.k, at_sparser - sparser.responses, odd, self.k)
        return replace(self, responses=self.responses + change)


def sample(
    axis: Axis,
    solve: Callable[[Sequence[float]], Sequence[Array]],
    odd: Mask,
    a: float,
    accuracy: Array | float,
) -> Samples:
    """Solve as many wavenumbers as the displacements need.

    `solve` returns the responses to unit loads at given wavenumbers. `odd` marks the entries of a response
    that are odd in k. `a` [mm] is the half-length of the loads. Intervals are halved until the error that
    each leaves in the displacements is below `accuracy` [mm/N], a number or an array; `odd` and `accuracy`
    broadcast with a response. Errors of neighbouring intervals alternate in sign. Raises NotConverged where
    more than `MOST_WAVENUMBERS` would be needed.
    """
    first_wavenumbers = axis.first().tolist()
    responses_at = dict(zip(first_wavenumbers, solve(first_wavenumbers), strict=True))
    open_intervals = list(pairwise(first_wavenumbers))
    all_middles: dict[float, tuple[float, float]] = {}
    while open_intervals:
        middles = {k: ends for ends in open_intervals if (k := axis.between(*ends)) is not None}
        if len(responses_at) + len(middles) > MOST_WAVENUMBERS:
            raise NotConverged(
                f"more than {MOST_WAVENUMBERS} wavenumbers would be needed for displacements within "
                f"{np.min(accuracy):.1e} mm/N: "
                "give a larger `tolerance`, or shorter lines"
            )
        nodes = sorted(responses_at)
        known = np.stack([responses_at[k] for k in nodes])
        expected = interpolated(axis, np.array(nodes), known, odd, np.array(list(middles)))
        solved_at = dict(zip(middles, solve(list(middles)), strict=True))
        errors = {
            k: np.max(np.abs(solved_at[k] - interpolation) / accuracy)
            for k, interpolation in zip(solved_at, expected, strict=True)
        }
        responses_at |= solved_at
        all_middles |= middles
        open_intervals = []
        for middle, (low, high) in middles.items():
            reach = (high - low) / np.pi * min(1.0, 1 / (middle * a))
            if errors[middle] * reach / HALVING_GAIN > 1:
                open_intervals += [(low, middle), (middle, high)]
    wavenumbers, interval_ends = sorted(responses_at), {end for ends in all_middles.values() for end in ends}
    last = np.array([k in all_middles and k not in interval_ends for k in wavenumbers])
    return Samples(axis, np.array(wavenumbers), np.stack([responses_at[k] for k in wavenumbers]), last)


def interpolated(axis: Axis, nodes: Array, values: Array, odd: Mask, targets: Array) -> Array:
    """Values (len(targets), ...) at other wavenumbers, interpolated between those at `nodes` [1/mm]."""
    even_values, odd_values = (
        np.tensordot(matrix, values, axes=1) for matrix in axis.interpolation(nodes, targets)
    )
    return np.where(odd, odd_values, even_values)
