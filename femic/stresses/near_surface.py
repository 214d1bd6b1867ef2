"""Points at which fields near the surface are sampled, and how values at the points follow from theirs.

Closer to the surface than about a cell, finite elements do not resolve the stresses of single elements of the
grid. What they add to the half-space's stresses is smooth (`Samples`). At the surface this rest has no
tractions, because the half-space has them all: its components along n are interpolated from there, the other
ones extrapolated.

Where elements still cause waves in a field, it is sampled below their centres and interpolated between these
(`CentreSamples`); where they no longer do, points are their own samples, as interpolation then errs more.
Between both depths one passes into the other.
"""

from dataclasses import dataclass

import numpy as np

from femic.stresses.points import InnerPoints
from geometries.arrays import Array, Indices, Mask
from geometries.patches import Grid

# --- continuation to the surface ---

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

    def extend(self, values: Array, zero: Mask) -> Array:
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


def sample_points(points: InnerPoints, trusted: float) -> Samples:
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


# --- centres of elements ---

# of the longer side of an element: from which depth on points count, too, and from which on they alone do;
# there waves are 0.02 and 0.001 of the steps from element to element
ROUGH_DEPTH, SMOOTH_DEPTH = 0.5, 1.0


@dataclass(frozen=True, eq=False)
class CentreSamples:
    """Sample points (m,), and their shares (n, 5) in the values at n points, `members` (n, 5) each.

    `on_lattice` (m,) marks those below centres of elements.
    """

    points: InnerPoints
    on_lattice: Mask
    members: Indices
    shares: Array
    shape: tuple[int, ...]

    @property
    def lattice_points(self) -> InnerPoints:
        """The sample points below centres."""
        points, chosen = self.points, self.on_lattice
        return InnerPoints(points.x[chosen], points.s[chosen], points.depth[chosen])

    def at_points(self, values: Array) -> Array:
        """Values (..., ) at the points from those at the sample points (m, ...)."""
        mean = np.einsum("nc,nc...->n...", self.shares, values[self.members])
        return np.asarray(mean.reshape(*self.shape, *values.shape[1:]))


def sample_centres(grid: Grid, points: InnerPoints, *, along_x: bool = True) -> CentreSamples:
    """Return the four nearest centres of elements, at the same depth, and the points themselves, by depth.

    The lattice of centres goes on beyond the grid. Without `along_x` samples have the x of the points.
    """
    x, s, depth = points.x.ravel(), points.s.ravel(), points.depth.ravel()
    # The share of the points themselves in their values grows with their depth; its slope is steady.
    ratio = depth / max(grid.dx if along_x else 0.0, grid.ds)
    t = np.clip((ratio - ROUGH_DEPTH) / (SMOOTH_DEPTH - ROUGH_DEPTH), 0.0, 1.0)
    own = t**2 * (3 - 2 * t)
    x_ends, x_shares = _neighbours(x, grid.dx, grid.dx * (grid.n_x - 1) / 2)
    if not along_x:
        x_ends, x_shares = np.repeat(x[:, None], 2, axis=1), np.tile([1.0, 0.0], (len(x), 1))
    s_ends, s_shares = _neighbours(s, grid.ds, float(grid.strips[0]))
    shape = (len(x), 2, 2)
    corners = [x_ends[:, :, None], s_ends[:, None, :], depth[:, None, None], np.ones((1, 1, 1))]
    below_centres = np.stack([np.broadcast_to(corner, shape) for corner in corners], axis=-1)
    # x, s, depth, on the lattice
    places = np.concatenate(
        [below_centres.reshape(len(x), 4, 4), np.stack([x, s, depth, 0 * x], axis=-1)[:, None]], axis=1
    )
    centre_shares = (x_shares[:, :, None] * s_shares[:, None, :]).reshape(len(x), 4)
    shares = np.append((1 - own)[:, None] * centre_shares, own[:, None], axis=1)
    most = np.argmax(shares, axis=1)[:, None, None]
    places = np.where(shares[..., None] > 0, places, np.take_along_axis(places, most, axis=1))
    distinct, members = np.unique(places.reshape(-1, 4).round(12), axis=0, return_inverse=True)
    samples = InnerPoints(*distinct[:, :3].T)
    return CentreSamples(samples, distinct[:, 3] > 0, members.reshape(len(x), 5), shares, points.shape)


def _neighbours(values: Array, spacing: float, origin: float) -> tuple[Array, Array]:
    """The two centres next to each of some values (n, 2) [mm], and their shares (n, 2)."""
    low = np.floor((values - origin) / spacing + 1e-9)
    share = np.clip((values - origin) / spacing - low, 0.0, 1.0)
    share = np.where(share > 1e-9, share, 0.0)
    return origin + spacing * np.stack([low, low + 1], axis=-1), np.stack([1 - share, share], axis=-1)
