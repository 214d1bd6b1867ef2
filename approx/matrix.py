"""Approximations on a grid: ICs of all pairs of elements, sorted by lag along x and by strips."""

from collections.abc import Sequence

import numpy as np

from approx.pair import Pair, Solid
from geometries.arrays import Array
from geometries.grids import Grid


def column(variant: str, solid: Solid | Pair, grid: Grid, strip: int) -> Array:
    """ICs per unit traction on one strip [mm/MPa] at all lags and strips, shape (3, 3, n_x, n_s)."""
    return columns([variant], solid, grid, strip)[variant]


def columns(variants: Sequence[str], solid: Solid | Pair, grid: Grid, strip: int) -> dict[str, Array]:
    """Return the columns of several variants; what they have in common is computed once."""
    return solid.approximations(variants, grid.patch(strip), (grid.lags[:, None], grid.strips))


def matrix(variant: str, solid: Solid | Pair, grid: Grid) -> Array:
    """Return the IC matrix [mm/MPa], (n_x, n_s, n_s, 3, 3): lag, observing and loaded strip, directions."""
    by_strip = [column(variant, solid, grid, strip) for strip in range(grid.n_s)]
    return np.moveaxis(np.stack(by_strip), (0, 1, 2, 3, 4), (2, 3, 4, 0, 1))
