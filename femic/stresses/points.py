"""Points inside a body, and the tractions on its surface.

A point lies below a point of the contact surface, by its depth along the normal there. Tractions are given on
the elements of a grid, as they act on the surface of one body.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import binary_dilation, binary_erosion

from geometries.arrays import Array, Mask
from geometries.bodies import Body
from geometries.errors import WrongInput
from geometries.patches import Grid

# --- points inside a body ---

ROUNDING = 1e-9  # of the far radius, by which points may lie beyond a boundary


@dataclass(frozen=True, eq=False)
class InnerPoints:
    """Points below the contact surface; x, s, depth [mm] have one shape (...).

    x is the arc length along the rolling circle of the surface at the arc length s of the body's contour,
    `depth` the distance from there along the inward normal.
    """

    x: Array
    s: Array
    depth: Array

    def __post_init__(self) -> None:
        x, s, depth = np.broadcast_arrays(
            *(np.asarray(values, dtype=float) for values in (self.x, self.s, self.depth))
        )
        for name, values in (("x", x), ("s", s), ("depth", depth)):
            object.__setattr__(self, name, values)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays."""
        return self.x.shape

    @property
    def flat(self) -> "InnerPoints":
        """The points in one row, shape (n,)."""
        return InnerPoints(self.x.ravel(), self.s.ravel(), self.depth.ravel())

    def in_section(self, body: Body) -> Array:
        """Coordinates y, z in the section of a body [mm], shape (2, ...)."""
        return body.contour.position(self.s) + body.side * self.depth * body.contour.normal(self.s)

    def in_chart(self, body: Body) -> Array:
        """Coordinate xi along the body [mm], shape (...)."""
        return body.surface.chart_x(self.x, self.s, self.s)


def points_at(body: Body, x: ArrayLike, y: ArrayLike, z: ArrayLike) -> InnerPoints:
    """Return points by global coordinates x, y, z [mm], which broadcast: below the nearest surface point.

    Raises WrongInput for points that are not inside the modelled body.
    """
    coordinates = np.broadcast_arrays(*(np.asarray(values, dtype=float) for values in (x, y, z)))
    xi, section_y, section_z = body.surface.to_chart(np.stack([values.ravel() for values in coordinates]))
    in_section = np.stack([section_y, section_z])
    s, depth = _foot(body, in_section)
    depth = np.where(np.abs(depth) <= ROUNDING * body.domain.far_radius, np.maximum(depth, 0.0), depth)
    x_along = xi / body.surface.chart_x(np.ones_like(s), s, s)
    shape = coordinates[0].shape
    points = InnerPoints(*(values.reshape(shape) for values in (x_along, s, depth)))
    missed = np.hypot(*(points.in_section(body).reshape(2, -1) - in_section))
    _require(
        missed <= ROUNDING * body.domain.far_radius,
        points,
        "the nearest point of the contour is its end, so this point lies below no point of the surface",
    )
    require_inside(body, points)
    return points


def require_inside(body: Body, points: InnerPoints) -> None:
    """Raise WrongInput, with the first such point, for points that are not inside the modelled body."""
    flat, low, high = points.flat, *body.s_range
    rounding = ROUNDING * body.domain.far_radius
    finite = np.isfinite(flat.x) & np.isfinite(flat.s) & np.isfinite(flat.depth)
    _require(finite, flat, "coordinates must be finite numbers [mm]")
    _require(flat.depth >= 0, flat, "above the surface; depth must be 0 or positive [mm]")
    on_contour = (flat.s >= low - rounding) & (flat.s <= high + rounding)
    _require(on_contour, flat, f"beyond the section's contour; s must lie in {low:.4g} ... {high:.4g} mm")
    length = np.pi * body.rolling_radius
    _require(
        np.abs(flat.in_chart(body)) <= length, flat, "more than half way round the body; give a smaller x"
    )
    in_section = flat.in_section(body)
    y, z = in_section
    own_depth = _foot(body, in_section)[1]
    if body.outline is None:
        hub = (
            f" and {body.rolling_radius - body.depth:g} mm from the axis (hub)" if body.depth < np.inf else ""
        )
        _require(
            (np.hypot(y, z) <= body.domain.far_radius + rounding) & (body.side * z <= body.depth + rounding),
            flat,
            f"beyond the modelled section, which ends {body.domain.far_radius:g} mm from the contact centre"
            f"{hub}; give a smaller depth or a larger far_radius",
        )
    else:
        within = _in_polygon(body.outline.closed(body.contour), in_section) | (own_depth < rounding)
        _require(within, flat, "outside the outline of the section; give a point inside it")
    left_again = "the normal leaves the body before this depth; give a smaller depth"
    _require(own_depth >= -rounding, flat, left_again)


def _foot(body: Body, in_section: Array) -> tuple[Array, Array]:
    """Arc lengths and depths [mm] of points (2, n) below the nearest point of the contour, (n,) each."""
    s = body.contour.nearest(in_section, body.s_range)
    apart = in_section - body.contour.position(s)
    return s, body.side * np.sum(apart * body.contour.normal(s), axis=0)


def _in_polygon(boundary: Array, points: Array) -> Mask:
    """Whether points (2, n) lie in a closed polygon (2, m): a ray along y crosses it oddly often."""
    (y, z), (next_y, next_z) = boundary[..., None], np.roll(boundary, -1, axis=1)[..., None]
    straddles = (z <= points[1]) != (next_z <= points[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = y + (points[1] - z) / (next_z - z) * (next_y - y)
    return np.asarray(np.sum(straddles & (points[0] < crossing), axis=0) % 2 == 1)


def _require(valid: Mask, points: InnerPoints, reason: str) -> None:
    """Raise WrongInput with the first point that is not valid (n,)."""
    if np.all(valid):
        return
    x, s, depth = (values.ravel()[int(np.argmin(valid))] for values in (points.x, points.s, points.depth))
    raise WrongInput(f"point x = {x:g}, s = {s:g}, depth = {depth:g} mm: {reason}")


# --- tractions on its surface ---

REACH = 2  # elements from the edge of the tractions, within which its root matters
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
        wide = np.pad(loaded, REACH)
        edge = binary_dilation(wide, BLOCK) & ~binary_erosion(wide, BLOCK)
        low_x, low_s = self.edges[0][0], self.edges[1][0]
        at = [
            np.floor((along - low) / side).astype(int) + REACH
            for along, low, side in ((x, low_x, grid.dx), (s, low_s, grid.ds))
        ]
        within = np.all([(k >= 0) & (k < n) for k, n in zip(at, edge.shape, strict=True)], axis=0)
        i, j = (np.where(within, k, 0) for k in at)
        return np.asarray(within & edge[i, j] & (depth < REACH * max(grid.dx, grid.ds)))


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
