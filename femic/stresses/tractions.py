"""Tractions on the elements of a grid, as they act on the surface of one body."""

from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.grids import Grid


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
