"""The size of grids: as large as the contact with B-hat, and fine enough for the smallest patch."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeVar

import numpy as np

from femic.contact.edges import ENDS, MARGIN
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.contact_size import (
    MOST_STRIPS,
    MOST_TRIES,
    SIZING,
    Range,
    Size,
    contact_size,
    no_grid,
    require_room,
)
from femic.contact.pairs.pair_on_grid import NEARLY, PairOnGrid
from femic.contact.pairs.quantities import lacking
from geometries.grids import Grid

ROOM = 0.12  # room beside the largest patch, as a share of its length, for patches by other ICs
STEP = 8  # numbers of elements are multiples of it, for the sake of coarser grids
MOST_ELEMENTS = 60_000  # of a grid that is made finer
MOST_ALONG_X = 256  # elements of a grid; loads that need more have grids of their own

Outcome = TypeVar("Outcome")


@dataclass(frozen=True)
class Sizing:
    """Two bodies, on any grid, whose grids are sized, with `elements` across the smallest patch of each.

    Beside `ROOM` there are `margin` elements beside the largest patch.
    """

    bodies: PairOnGrid
    elements: int
    margin: int = MARGIN + 1

    @property
    def extent(self) -> Range:
        """Arc lengths [mm] between which the bodies may touch."""
        return self.bodies.undeformed.s_range

    def grids(self, loadings: Sequence[Loading]) -> list[tuple[Grid, list[Loading]]]:
        """Grids, each with the loadings that are solved on it, in the order of their size.

        Loadings share a grid and so C, as long as it does not have more than `MOST_STRIPS` strips.
        """
        sizes = {loading: contact_size(self.bodies, loading) for loading in loadings}
        groups: list[list[Loading]] = []
        for loading in sorted(loadings, key=lambda loading: sizes[loading].x[1]):
            if groups and _fits(self.grid([sizes[other] for other in [*groups[-1], loading]])):
                groups[-1].append(loading)
            else:
                groups.append([loading])
        return [(self.grid([sizes[loading] for loading in group]), group) for group in groups]

    def grid(self, sizes: Sequence[Size]) -> Grid:
        """Return a grid for some sizes of contacts."""
        dx, ds = (float(min(size.patch[axis] for size in sizes)) / self.elements for axis in (0, 1))
        x = max(high for _, high in (size.x for size in sizes))
        low, high = min(size.s[0] for size in sizes), max(size.s[1] for size in sizes)
        room_x, room_s = 2 * ROOM * x + self.margin * dx, ROOM * (high - low) + self.margin * ds
        n_x, n_s = _rounded((2 * x + 2 * room_x) / dx), _rounded((high - low + 2 * room_s) / ds)
        middle = (low + high) / 2
        return self._within(Grid(n_x, n_s, dx, ds, 0.0 if abs(middle) < NEARLY * ds else float(middle)))

    def large_enough(self, grid: Grid, loadings: Sequence[Loading], variants: Sequence[str]) -> Grid:
        """Return the grid, made longer where the contact with another approximation needs it."""
        for variant, loading in product(variants, loadings):

            def grid_of(on_grid: PairOnGrid, variant: str = variant, loading: Loading = loading) -> Grid:
                on_grid.solve(on_grid.operator(variant), loading)
                return on_grid.grid

            grid = self.on_long_enough_grid(grid, grid_of)
        return grid

    def resolved(self, grid: Grid, loadings: Sequence[Loading], most_strips: int) -> Grid:
        """Return the grid with strips halved until they resolve the distance, or are more than `most_strips`.

        What p_max lacks otherwise is part of its estimate (`quantities.lacking`).
        """
        while 2 * grid.n_s <= most_strips and 2 * grid.n_x * grid.n_s <= MOST_ELEMENTS:
            on_grid = replace(self.bodies, grid=grid)
            operator = on_grid.operator(SIZING)
            if not any(lacking(on_grid, on_grid.solve(operator, loading).normal) for loading in loadings):
                break
            grid = replace(grid, n_s=2 * grid.n_s, ds=grid.ds / 2)
        return grid

    def on_long_enough_grid(self, grid: Grid, solve: Callable[[PairOnGrid], Outcome]) -> Outcome:
        """Return the solution of `solve` on a grid, which is made longer while a contact reaches its ends.

        Raises Failure where a contour ends there, and as `solve`.
        """
        for _ in range(MOST_TRIES):
            try:
                return solve(replace(self.bodies, grid=grid))
            except PotentialAreaTooSmall as short:
                grid, loading = self.longer(grid, short), short.loading
        raise no_grid(loading)

    def longer(self, grid: Grid, short: PotentialAreaTooSmall) -> Grid:
        """Return the grid with `STEP` more elements at the ends at which it is too short.

        Raises Failure where a contour ends there.
        """
        require_room(self.bodies, short, grid.extent)
        ends = short.ends
        along_x = 2 * STEP if ENDS[0] in ends or ENDS[1] in ends else 0
        before, after = (STEP * (end in ends) for end in ENDS[2:])
        middle = grid.s + (after - before) * grid.ds / 2
        longer = Grid(grid.n_x + along_x, grid.n_s + before + after, grid.dx, grid.ds, middle)
        return self._within(longer)

    def _within(self, grid: Grid) -> Grid:
        """Return the grid, moved or with narrower strips so that it stays on the contours."""
        (low, high), (start, end) = self.extent, grid.extent
        if end - start > high - low:
            return Grid(grid.n_x, grid.n_s, grid.dx, (high - low) / grid.n_s, (low + high) / 2)
        return Grid(grid.n_x, grid.n_s, grid.dx, grid.ds, grid.s + max(0, low - start) - max(0, end - high))


def _rounded(n: float) -> int:
    """Return the next multiple of `STEP`."""
    return STEP * int(np.ceil(n / STEP))


def _fits(grid: Grid) -> bool:
    return grid.n_s <= MOST_STRIPS and grid.n_x <= MOST_ALONG_X
