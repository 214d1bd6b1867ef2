"""Parts of a sampled curve that are functions z(y): a rail seen from above, a wheel seen from below."""

from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array
from geometries.track.curves import Samples

STEEPEST = np.radians(85)  # steeper parts are no part of a graph, and may be a flange back


@dataclass(frozen=True, eq=False)
class Graph:
    """A part of a curve that is a function z(y): arc lengths, y, z and slopes dz/dy, shape (n,) each."""

    t: Array
    y: Array
    z: Array
    slope: Array

    def heights(self, y: Array) -> Array:
        """Heights z at y within the graph, by cubic Hermite interpolation; shape of y."""
        k = np.clip(np.searchsorted(self.y, y) - 1, 0, len(self.y) - 2)
        step = self.y[k + 1] - self.y[k]
        u = (y - self.y[k]) / step
        rise = self.z[k + 1] - self.z[k]
        bend_0, bend_1 = self.slope[k] * step - rise, rise - self.slope[k + 1] * step
        return np.asarray(self.z[k] + u * rise + u * (1 - u) * ((1 - u) * bend_0 + u * bend_1))


def graphs(samples: Samples) -> list[Graph]:
    """The parts of a curve that rise to larger y and are less steep than 85 degrees."""
    y_rate = samples.tangents[0]
    usable = np.concatenate([[False], y_rate > np.cos(STEEPEST), [False]])
    starts, ends = (np.flatnonzero(np.diff(usable.astype(int)) == sign) for sign in (1, -1))
    return [
        Graph(
            samples.t[a:b],
            samples.points[0, a:b],
            samples.points[1, a:b],
            samples.tangents[1, a:b] / y_rate[a:b],
        )
        for a, b in zip(starts, ends, strict=True)
        if b - a > 2
    ]
