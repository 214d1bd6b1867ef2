"""Tractions on the elements of a grid, as they act on the surface of one body."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation, binary_erosion

from geometries.arrays import Array, Mask
from geometries.errors import WrongInput
from geometries.grids import Grid

REACH = 2  # elements from the edge of the tractions, within which its root matters
AROUND = REACH + 1  # elements without tractions around the grid
BLOCK = np.ones((2 * REACH + 1, 2 * REACH + 1), dtype=bool)


@dataclass(frozen=True, eq=False)
class SurfaceTractions:
    """Uniform tractions on elements; strips lie at the arc lengths of `grid` on the body's own contour.

    `p` [MPa], shape (n_x, n_s, 3), is positive along x, s, n on the upper body, and the lower body gets the
    opposite. The elements of a strip lie evenly about x = 0.
    """

    grid: Grid
    p: Array

    def __post_init__(self) -> None:
        shape = (self.grid.n_x, self.grid.n_s, 3)
        if self.p.shape != shape:
            raise WrongInput(
                f"tractions of shape {self.p.shape}: must be (n_x, n_s, 3) = {shape}, along x, s, n"
            )
        if not np.all(np.isfinite(self.p)):
            raise WrongInput("tractions: must be finite [MPa]; give 0 where elements are not in contact")

    @property
    def x(self) -> Array:
        """Centres of the elements along x [mm], shape (n_x,)."""
        n_x = self.grid.n_x
        return np.asarray(self.grid.dx * (np.arange(n_x) - (n_x - 1) / 2))

    @property
    def edges(self) -> tuple[Array, Array]:
        """Edges of the elements along x (n_x + 1,) and along s (n_s + 1,) [mm]."""
        grid = self.grid
        half = grid.n_x * grid.dx / 2
        return np.linspace(-half, half, grid.n_x + 1), np.linspace(*grid.extent, grid.n_s + 1)

    def beside_edge(self, x: Array, s: Array, depth: Array) -> Mask:
        """Return which points (...) are within two elements, and as deep, of where tractions end."""
        grid, loaded = self.grid, np.any(self.p != 0, axis=-1)
        wide = np.pad(loaded, AROUND)
        of_edge = binary_dilation(wide, BLOCK) & ~binary_erosion(wide, BLOCK)
        low_x, low_s = self.edges[0][0], self.edges[1][0]
        at = [
            np.floor((along - low) / side).astype(int) + AROUND
            for along, low, side in ((x, low_x, grid.dx), (s, low_s, grid.ds))
        ]
        within = np.all([(k >= 0) & (k < n) for k, n in zip(at, of_edge.shape, strict=True)], axis=0)
        i, j = (np.where(within, k, 0) for k in at)
        return np.asarray(within & of_edge[i, j] & (depth < REACH * max(grid.dx, grid.ds)))


def merged(tractions: SurfaceTractions) -> SurfaceTractions:
    """Return the mean tractions of blocks of 2 x 2 elements, which show what the size of elements does."""
    grid, p = tractions.grid, tractions.p
    odd_x, odd = grid.n_x % 2, grid.n_s % 2
    halves = np.pad(np.repeat(p, 2, axis=0), ((odd_x, odd_x), (0, 0), (0, 0)))  # evenly about x = 0
    p = _means(halves, 4)
    p = np.swapaxes(_means(np.swapaxes(np.pad(p, ((0, 0), (0, odd), (0, 0))), 0, 1), 2), 0, 1)
    s = grid.s + odd * grid.ds / 2
    return SurfaceTractions(Grid(p.shape[0], p.shape[1], 2 * grid.dx, 2 * grid.ds, s), p)


def _means(values: Array, n: int) -> Array:
    """Means of n neighbours each along the first axis, shape (m / n, ...)."""
    return np.asarray(values.reshape(-1, n, *values.shape[1:]).mean(axis=1))
