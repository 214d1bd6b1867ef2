"""The tables [patch], [[lines]] and [grid] of a scene file.

They are the loaded element, the lines of observers, and the elements of IC matrices.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from femic.key_types import Length, Place, Whole
from femic.scenes.engine import aspect_misfits, body_limit_misfits, ratio_misfits
from femic.scenes.scene import Scene
from femic.scenes.scene_table import SceneTable
from geometries.bodies import Body
from geometries.patches import Grid, OffsetLine, Patch, line_along_s, line_along_x

# --- [patch] and [[lines]] ------------------------------------------------------------------------------


CLEAR_OF_PATCH = 6  # least distance of displacements compared beside a moment load, in half-widths patch.b
PATCHES_IN_REACH = 100.0  # rotation_reach over the half-sides of a patch that is not given

Reach = Annotated[Length, Field(description="half-length of the line [mm]")]
PointCount = Annotated[Whole, Field(ge=2, le=5000, description="number of points")]


class PatchTable(SceneTable):
    """The loaded element, centred at x = 0."""

    a: Length = Field(description="half-side along x [mm]")
    b: Length = Field(description="half-side along s [mm]")
    s: Place = Field(0.0, description="arc length of its centre [mm]")

    @model_validator(mode="after")
    def _aspect(self) -> "PatchTable":
        if not 0.01 * (1 - 1e-9) <= self.a / self.b <= 100 * (1 + 1e-9):
            raise ValueError(f"a / b = {self.a / self.b:g} is outside 0.01 ... 100: bring a and b closer")
        return self


def patch_of(table: PatchTable | None, rotation_reach: float) -> Patch:
    """Return the loaded element; by default small beside `rotation_reach`, which is in mm."""
    if table is None:
        return Patch(rotation_reach / PATCHES_IN_REACH, rotation_reach / PATCHES_IN_REACH)
    return Patch(**table.model_dump())


class LineAlongX(SceneTable):
    """A line along x at a fixed arc length."""

    along: Literal["x"] = Field(description="direction of the line")
    s: Place = Field(description="arc length of the line [mm]")
    reach: Reach = 25.0
    points: PointCount = 401


class LineAlongS(SceneTable):
    """A line along s at a fixed longitudinal distance."""

    along: Literal["s"] = Field(description="direction of the line")
    x: Place = Field(description="longitudinal distance of the line [mm]")
    reach: Reach = 25.0
    points: PointCount = 401


Line = Annotated[LineAlongX | LineAlongS, Field(discriminator="along")]


def line_of(table: LineAlongX | LineAlongS, extent: tuple[float, float]) -> OffsetLine:
    """Return the line of a table; along s as far as contours of an extent [mm] go."""
    if isinstance(table, LineAlongX):
        return line_along_x(table.s, table.reach, table.points)
    s_range = max(-table.reach, extent[0]), min(table.reach, extent[1])
    return line_along_s(table.x, s_range, table.points)


def default_lines(s_patch: float) -> tuple[LineAlongX | LineAlongS, ...]:
    """Return the default lines: along x beside the patch and through it, along s in front of it."""
    return (
        LineAlongX.model_construct(along="x", s=s_patch + 1.6),
        LineAlongX.model_construct(along="x", s=s_patch),
        LineAlongS.model_construct(along="s", x=1.6),
    )


@dataclass(frozen=True)
class Room:
    """The room for loads and lines: half the size of the domain."""

    size: float  # of the domain [mm]
    name: str


def room_of(scene: Scene) -> Room:
    """Return the room in the first domain of a scene."""
    domain = scene.bodies["lower"].domain
    size = min(domain.far_radius, domain.half_length, scene.half_turn)
    or_half_length = ", engine.half_length" if np.isfinite(domain.half_length) else ""
    lengths = f"engine.far_radius{or_half_length} and half a turn"
    return Room(size, f"half of the least of {lengths} ({size / 2:g} mm)")


def single_load_misfits(scene: Scene) -> Iterator[str]:
    """Yield why ICs under a single load, on the patch, have no C on the lines of a scene."""
    room = room_of(scene)
    yield from body_limit_misfits(scene)
    yield from aspect_misfits(scene)
    yield from patch_misfits(scene, room)
    yield from line_misfits(scene, room)
    reaches = [(f"lines.{k} ({line.name})", reach_of(line, scene)) for k, line in enumerate(scene.lines)]
    reaches.append(("rotation_reach", scene.settings.rotation_reach))
    yield from ratio_misfits(half_sides(scene), reaches, scene)


def patch_misfits(scene: Scene, room: Room) -> Iterator[str]:
    """Yield the errors of the patch and the points of the discount."""
    patch, smallest = scene.patch, scene.first_cells.smallest
    ends = f"the contours go from s = {scene.extent[0]:g} to {scene.extent[1]:g} mm"
    if not scene.extent[0] <= patch.s - patch.b < patch.s + patch.b <= scene.extent[1]:
        yield f"patch.s = {patch.s:g}, patch.b = {patch.b:g}: the patch reaches beyond the contour; {ends}"
    if 10 * max(patch.a, patch.b) > room.size / 2:
        yield f"patch.a = {patch.a:g}, patch.b = {patch.b:g}: each at most a tenth of {room.name}"
    if 2 * abs(patch.s) > room.size:
        yield f"patch.s = {patch.s:g}: beyond {room.name}"
    largest_cell = scene.settings.engine.least_side(patch)
    if smallest > largest_cell:
        yield f"engine.smallest_cell = {smallest:g}: at most {largest_cell:g}, half a side of the patch"
    for name in ("rotation_reach", *(["moment_arm"] if patch.s else [])):
        reach = getattr(scene.settings, name)
        if not scene.extent[0] <= -reach < reach <= scene.extent[1]:
            yield f"{name} = {reach:g}: beyond the contour; {ends}: give a smaller one"
        if 2 * reach > room.size:
            yield f"{name} = {reach:g}: at most {room.name}"
    if patch.s:
        yield from _moment_misfits(scene, room)


def _moment_misfits(scene: Scene, room: Room) -> Iterator[str]:
    arm, reach, b = scene.settings.moment_arm, scene.settings.rotation_reach, scene.patch.b
    if 2 * (arm + reach) > room.size:
        yield f"moment_arm + rotation_reach = {arm + reach:g}: at most {room.name}"
    clearance = min(reach, scene.extent[1] - arm, -scene.extent[0] - arm)
    if clearance < CLEAR_OF_PATCH * b:
        yield (
            f"moment_arm = {arm:g}: displacements are compared {clearance:.3g} mm beside a load there, as "
            f"far as the contour goes; at least {CLEAR_OF_PATCH:g} patch.b = {CLEAR_OF_PATCH * b:g} mm are "
            "needed: give a smaller moment_arm, a longer contour or a smaller patch"
        )


def line_misfits(scene: Scene, room: Room) -> Iterator[str]:
    """Yield the errors of the lines of a scene."""
    for k, line in enumerate(scene.lines):
        yield from misfits_of_line(f"lines.{k} ({line.name})", line, scene.bodies, scene.extent)
        if 2 * max(np.max(np.abs(line.x)), np.max(np.abs(line.s))) > room.size:
            yield f"lines.{k} ({line.name}): reaches beyond {room.name}: shorten it or enlarge both"
    if len({line.name for line in scene.lines}) < len(scene.lines):
        yield "lines: two of them are the same line: remove one"


def misfits_of_line(
    label: str, line: OffsetLine, bodies: Mapping[str, Body], extent: tuple[float, float]
) -> Iterator[str]:
    """Yield whether a line leaves the contours, or lies too near to a hub."""
    if np.min(line.s) < extent[0] or np.max(line.s) > extent[1]:
        yield f"{label}: beyond the contour, s = {extent[0]:g} to {extent[1]:g} mm"
        return
    for name, body in bodies.items():
        if np.any(2 * body.side * body.contour.position(line.s)[1] > body.depth):
            yield (
                f"{label}: reaches beyond half the height of the hub of the {name} body "
                f"({body.depth / 2:g} mm): shorten it, or enlarge {name}.rolling_radius"
            )


def reach_of(line: OffsetLine, scene: Scene) -> float:
    """Return the distance of the furthest point of a line from the patch [mm]."""
    return float(np.max(np.hypot(line.x, line.s - scene.patch.s)))


def half_sides(scene: Scene) -> dict[str, float]:
    """Return the half-sides of the patch [mm] by their keys."""
    return {"patch.a": scene.patch.a, "patch.b": scene.patch.b}


# --- [grid] ---------------------------------------------------------------------------------------------


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
