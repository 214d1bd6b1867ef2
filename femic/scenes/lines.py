"""The tables [patch], [[lines]] and [grid] of a scene file.

They are the loaded element, the lines of observers, and the elements of IC matrices.
"""

from collections.abc import Iterator, Mapping
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

Reach = Annotated[Length, Field(description="the line reaches from -reach to +reach [mm]")]
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


class LineAlongX(SceneTable):
    """A line along x at a fixed arc length."""

    along: Literal["x"] = Field(description="direction of the line")
    s: Place = Field(description="arc length of the line [mm]")
    reach: Reach = 25.0
    points: PointCount = 401

    def line(self, _extent: tuple[float, float]) -> OffsetLine:
        """Return the line."""
        return line_along_x(self.s, self.reach, self.points)


class LineAlongS(SceneTable):
    """A line along s at a fixed longitudinal distance."""

    along: Literal["s"] = Field(description="direction of the line")
    x: Place = Field(description="longitudinal distance of the line [mm]")
    reach: Reach = 25.0
    points: PointCount = 401

    def line(self, extent: tuple[float, float]) -> OffsetLine:
        """Return the line, as far as contours of an extent [mm] go."""
        return line_along_s(self.x, (max(-self.reach, extent[0]), min(self.reach, extent[1])), self.points)


Line = Annotated[LineAlongX | LineAlongS, Field(discriminator="along")]


def default_lines(s_patch: float) -> tuple[LineAlongX | LineAlongS, ...]:
    """Return the default lines: along x beside the patch and through it, along s in front of it."""
    return (
        LineAlongX.model_construct(along="x", s=s_patch + 1.6),
        LineAlongX.model_construct(along="x", s=s_patch),
        LineAlongS.model_construct(along="s", x=1.6),
    )


def single_load_misfits(scene: Scene) -> Iterator[str]:
    """Yield why ICs under a single load, on the patch, have no C on the lines of a scene.

    Loads and lines have room in half of the first domain.
    """
    domain, patch, settings, (start, end) = (
        scene.bodies["lower"].domain,
        scene.patch,
        scene.settings,
        scene.extent,
    )
    size = min(domain.far_radius, domain.half_length, scene.half_turn)  # mm
    or_half_length = ", engine.half_length" if np.isfinite(domain.half_length) else ""
    lengths = f"engine.far_radius{or_half_length} and half a turn"
    room = f"half of the least of {lengths} ({size / 2:g} mm)"
    ends = f"the contours go from s = {start:g} to {end:g} mm"
    yield from body_limit_misfits(scene)
    yield from aspect_misfits(scene)
    if not start <= patch.s - patch.b < patch.s + patch.b <= end:
        yield f"patch.s = {patch.s:g}, patch.b = {patch.b:g}: the patch extends beyond the contour; {ends}"
    if 10 * max(patch.a, patch.b) > size / 2:
        yield f"patch.a = {patch.a:g}, patch.b = {patch.b:g}: each at most a tenth of {room}"
    if 2 * abs(patch.s) > size:
        yield f"patch.s = {patch.s:g}: beyond {room}"
    smallest, largest_cell = scene.first_cells.smallest, settings.engine.least_side(patch)
    if smallest > largest_cell:
        yield f"engine.smallest_cell = {smallest:g}: at most {largest_cell:g}, half a side of the patch"
    for name in ("rotation_reach", *(["moment_arm"] if patch.s else [])):
        reach = getattr(settings, name)
        if not start <= -reach < reach <= end:
            yield f"{name} = {reach:g}: beyond the contour; {ends}: give a smaller one"
        if 2 * reach > size:
            yield f"{name} = {reach:g}: at most {room}"
    if patch.s:
        arm, reach = settings.moment_arm, settings.rotation_reach
        if 2 * (arm + reach) > size:
            yield f"moment_arm + rotation_reach = {arm + reach:g}: at most {room}"
        clearance = min(reach, end - arm, -start - arm)
        if clearance < CLEAR_OF_PATCH * patch.b:
            yield (
                f"moment_arm = {arm:g}: displacements are compared {clearance:.3g} mm beside a load there, "
                f"as far as the contour extends; at least {CLEAR_OF_PATCH:g} patch.b = "
                f"{CLEAR_OF_PATCH * patch.b:g} mm are needed: give a smaller moment_arm, a longer contour "
                "or a smaller patch"
            )
    lines = {f"lines.{k} ({line.name})": line for k, line in enumerate(scene.lines)}
    for label, line in lines.items():
        yield from line_misfits(label, line, scene.bodies, scene.extent)
        if 2 * max(np.max(np.abs(line.x)), np.max(np.abs(line.s))) > size:
            yield f"{label}: reaches beyond {room}: shorten it or enlarge both"
    if len({line.name for line in scene.lines}) < len(lines):
        yield "lines: two lines are identical; remove one"
    yield from patch_ratio_misfits(lines, scene, {"rotation_reach": settings.rotation_reach})


def line_misfits(
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


def patch_ratio_misfits(
    lines: Mapping[str, OffsetLine], scene: Scene, others: Mapping[str, float] | None = None
) -> Iterator[str]:
    """Yield lines, and other reaches [mm], that are too long beside the patch."""
    patch = scene.patch
    reaches = {
        label: float(np.max(np.hypot(line.x, line.s - patch.s))) for label, line in lines.items()
    } | dict(others or {})
    yield from ratio_misfits({"patch.a": patch.a, "patch.b": patch.b}, reaches, scene)


# --- [grid] ---------------------------------------------------------------------------------------------


class GridTable(SceneTable):
    """The grid of elements whose IC matrix `femic matrix` computes."""

    n_x: Annotated[Whole, Field(ge=1, le=4096)] = Field(64, description="number of elements (lags) along x")
    n_s: Annotated[Whole, Field(ge=1, le=512)] = Field(32, description="number of strips")
    dx: Length | None = Field(None, description="length of an element [mm]; default: 2 x patch.a")
    ds: Length | None = Field(None, description="width of a strip [mm]; default: 2 x patch.b")
    s: Place = Field(0.0, description="arc length of the middle of the grid [mm]")
    check: Annotated[Whole, Field(ge=0, le=9)] = Field(
        0, description="number of strips that the solid engine computes as a check (minutes each)"
    )

    def grid(self, patch: Patch) -> Grid:
        """Return the grid; by default its elements are as large as the patch."""
        return Grid(self.n_x, self.n_s, self.dx or 2 * patch.a, self.ds or 2 * patch.b, self.s)


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
    yield from ratio_misfits(half_sides, {"rotation_reach": scene.settings.rotation_reach}, scene)
