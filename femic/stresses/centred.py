"""Points below the centres of elements instead of those at small depths, and interpolation between them."""

from dataclasses import dataclass

import numpy as np

from femic.stresses.points import InnerPoints
from geometries.arrays import Array, Indices, Mask
from geometries.grids import Grid

SMOOTH_DEPTH = 1.0  # of the longer side of an element: below it fields are smooth in x and s


@dataclass(frozen=True, eq=False)
class Centred:
    """Sample points (m,), and their shares (n, 4) in the values at n points, `members` (n, 4) each.

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


def centred(grid: Grid, points: InnerPoints, *, along_x: bool = True) -> Centred:
    """Return the four nearest centres of elements, at the same depth, for points of small depth.

    Other points are their own samples. The lattice of centres goes on beyond the grid. Without `along_x`
    samples have the x of the points.
    """
    x, s, depth = points.x.ravel(), points.s.ravel(), points.depth.ravel()
    shallow = _shallow(grid, depth, along_x)
    x_ends, x_shares = _neighbours(x, grid.dx, grid.dx * (grid.n_x - 1) / 2, shallow & along_x)
    s_ends, s_shares = _neighbours(s, grid.ds, float(grid.strips[0]), shallow)
    shape = (len(x), 2, 2)
    corners = [x_ends[:, :, None], s_ends[:, None, :], depth[:, None, None]]
    places = np.stack([np.broadcast_to(corner, shape) for corner in corners], axis=-1).reshape(-1, 3)
    distinct, members = np.unique(places.round(12), axis=0, return_inverse=True)
    shares = (x_shares[:, :, None] * s_shares[:, None, :]).reshape(len(x), 4)
    samples = InnerPoints(*distinct.T)
    return Centred(
        samples, _shallow(grid, samples.depth, along_x), members.reshape(len(x), 4), shares, points.shape
    )


def _shallow(grid: Grid, depth: Array, along_x: bool) -> Mask:
    """Whether depths are less than an element, whose sides along x may not matter."""
    return np.asarray(depth < SMOOTH_DEPTH * max(grid.dx if along_x else 0.0, grid.ds))


def _neighbours(values: Array, spacing: float, origin: float, shallow: Mask) -> tuple[Array, Array]:
    """The two centres next to each of some values (n, 2) [mm], and their shares (n, 2)."""
    low = np.floor((values - origin) / spacing + 1e-9)
    share = np.clip((values - origin) / spacing - low, 0.0, 1.0)
    ends = origin + spacing * np.stack([low, low + (share > 1e-9)], axis=-1)
    shares = np.stack([1 - share, share], axis=-1)
    alone, own = np.array([1.0, 0.0]), np.repeat(values[:, None], 2, axis=1)
    return np.where(shallow[:, None], ends, own), np.where(shallow[:, None], shares, alone)
