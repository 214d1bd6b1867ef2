"""The table [grid] of a scene file: the elements of IC matrices."""

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from femic.key_types import Length, Place, Whole
from femic.scenes.engine import ratio_misfits
from femic.scenes.scene import Scene
from femic.scenes.scene_table import SceneTable
from geometries.grids import Grid
from geometries.patches import Patch


class GridTable(SceneTable):
    """The grid of elements whose IC matrix `femic matrix` computes."""

    n_x: Annotated[Whole, Field(ge=1, le=4096)] = Field(64, description="number of elements along x: lags")
    n_s: Annotated[Whole, Field(ge=1, le=512)] = Field(32, description="number of strips")
    dx: Length | None = Field(None, description="length of an element [mm]; default: 2 x patch.a")
    ds: Length | None = Field(None, description="width of a strip [mm]; default: 2 x patch.b")
    s: Place = Field(0.0, description="arc length of its middle [mm]")
    check: Annotated[Whole, Field(ge=0, le=9)] = Field(
        0, description="strips whose columns the solid engine computes as a check (minutes each)"
    )


def figure_grid(table: GridTable, patch: Patch) -> Grid:
    """Return the grid; by default its elements are as large as the patch."""
    return Grid(table.n_x, table.n_s, table.dx or 2 * patch.a, table.ds or 2 * patch.b, table.s)


def grid_misfits(scene: Scene) -> Iterator[str]:
    """Yield the errors of the grid of the IC matrix."""
    grid = scene.grid
    low, high = scene.extent
    if not low <= grid.extent[0] < grid.extent[1] <= high:
        start, end = grid.extent
        yield (
            f"grid: {grid.n_s} strips of {grid.ds:g} mm go from s = {start:g} to {end:g} mm, the contours "
            f"from {low:g} to {high:g} mm: give fewer (n_s) or narrower ones (ds)"
        )
    if not 0.01 <= grid.dx / grid.ds <= 100:
        yield f"grid.dx / grid.ds = {grid.dx / grid.ds:g} is outside 0.01 ... 100: bring them closer"
    if 2 * grid.lags[-1] > (half_turn := scene.half_turn):
        yield (
            f"grid: {grid.n_x} elements of {grid.dx:g} mm are more than half of half a turn "
            f"({half_turn:g} mm)"
        )
    half_sides = {"grid.dx / 2": grid.dx / 2, "grid.ds / 2": grid.ds / 2}
    yield from ratio_misfits(half_sides, [("rotation_reach", scene.settings.rotation_reach)], scene)
