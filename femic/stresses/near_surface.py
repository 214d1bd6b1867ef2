"""Points below which a smooth field is sampled, and its continuation to the surface.

Closer to the surface than about a cell, finite elements do not resolve the stresses of single elements of the
grid. What they add to the half-space's stresses is smooth. At the surface this rest has no tractions, because
the half-space has them all: its components along n are interpolated from there, the other ones extrapolated.
"""

from dataclasses import dataclass

import numpy as np

from femic.stresses.points import InnerPoints
from geometries.arrays import Array, Indices, Mask

SAMPLE_DEPTHS = np.array([1.0, 2.0, 4.0])  # of the depth from which on the section is trusted


@dataclass(frozen=True, eq=False)
class Samples:
    """Sample points (m,); points that are deep enough are their own samples, others have three of them.

    `members` (n, 3) are the numbers of the samples of each point, `relative` (n,) its depth over `trusted`.
    """

    points: InnerPoints
    members: Indices
    relative: Array
    shape: tuple[int, ...]

    def continued(self, values: Array, zero: Mask) -> Array:
        """Values (..., *c) at the points from those at the samples (m, *c).

        `zero` (*c) marks components that vanish at the surface.
        """
        extrapolated, interpolated = _shares(self.relative, np.array([])), _shares(self.relative, np.zeros(1))
        shallow = (self.relative < 1).reshape(-1, *(1,) * zero.ndim)
        at_samples = values[self.members]  # (n, 3, *c)
        free, vanishing = (
            np.einsum("nm,nm...->n...", shares, at_samples) for shares in (extrapolated, interpolated)
        )
        result = np.where(shallow, np.where(zero, vanishing, free), at_samples[:, 0])
        return np.asarray(result.reshape(*self.shape, *zero.shape))


def samples_of(points: InnerPoints, trusted: float) -> Samples:
    """Return the samples of points; the section is trusted from the depth `trusted` [mm] on."""
    x, s, depth = points.x.ravel(), points.s.ravel(), points.depth.ravel()
    depths = np.where((depth < trusted)[:, None], trusted * SAMPLE_DEPTHS, depth[:, None])
    places = np.stack(np.broadcast_arrays(x[:, None], s[:, None], depths), axis=-1).reshape(-1, 3)
    distinct, members = np.unique(places, axis=0, return_inverse=True)
    return Samples(InnerPoints(*distinct.T), members.reshape(-1, 3), depth / trusted, points.shape)


def _shares(depth: Array, zeros: Array) -> Array:
    """Lagrange's shares (n, 3) of the sample depths at `depth` (n,), for values that vanish at `zeros`."""
    nodes = np.append(SAMPLE_DEPTHS, zeros)
    shares = [
        np.prod([(depth - other) / (node - other) for other in nodes if other != node], axis=0)
        for node in SAMPLE_DEPTHS
    ]
    return np.stack(shares, axis=-1)
