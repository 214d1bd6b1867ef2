"""Outlines: what closes a section beyond its contact contour, as straight edges, part of them clamped.

Without an outline a section is closed by a far arc or a hub (`geometries.bodies`), which is a convention.
With one, it has the shape and the supports of a real body: a rail down to its foot, a wheel up to its hub.

`RAIL_SECTIONS` are standard rails below their heads, from the dimensions of the standards, clamped at the
foot. They are in the axes of profiles: y to the field side, z up, from the top of the head. A standard gives
a section more dimensions than are here; what the straight edges leave out is stated for each.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from geometries.arrays import Array, Mask
from geometries.contours import Contour
from geometries.errors import WrongInput

# --- outlines ---

SAME_PLACE = 1e-6  # of the size of an outline: points that are closer are the same
CONTOUR_PIECES = 400  # straight pieces that stand for the contour where crossings are sought
PARALLEL = 1e-9  # rad, between edges that count as parallel: they have no crossing


@dataclass(frozen=True)
class SectionOutline:
    """The boundary of a section beyond its contact contour: straight edges from point to point.

    The `points` (y, z) [mm], in the axes of the contour, go from its end at s > 0 round the far side to its
    end at s < 0. The contour goes on along its tangent to a first or last point that lies there; otherwise an
    edge joins the contour's end and the point. `clamped` are the numbers, counted from 1, of two points: the
    edges between them are clamped, and all others are free.
    """

    points: tuple[tuple[float, float], ...]
    clamped: tuple[int, int]

    def __post_init__(self) -> None:
        n, (first, last) = len(self.points), self.clamped
        if n < 2 or not np.all(np.isfinite(np.array(self.points, dtype=float))):
            raise WrongInput(f"outline.points: {n} points; at least 2 are needed, of finite numbers [mm]")
        if not 1 <= first < last <= n:
            raise WrongInput(
                f"outline.clamped = [{first}, {last}]: give the numbers of two of the {n} points, in "
                "order; the edges between them are clamped"
            )
        repeated = np.flatnonzero(self._lengths <= SAME_PLACE * self.size)
        if len(repeated):
            k = int(repeated[0]) + 1
            raise WrongInput(f"outline.points: points {k} and {k + 1} are identical; remove one")

    @classmethod
    def through(cls, points: Array, clamped: tuple[int, int]) -> "SectionOutline":
        """The outline through points (2, n) [mm]."""
        return cls(tuple((float(y), float(z)) for y, z in points.T), clamped)

    def at(self, points: Array) -> "SectionOutline":
        """The outline with its points (2, n) [mm] elsewhere."""
        return self.through(points, self.clamped)

    @property
    def corners(self) -> Array:
        """The points, shape (2, n) [mm]."""
        return np.array(self.points, dtype=float).T

    @property
    def size(self) -> float:
        """Largest distance of its points from the contact centre [mm]."""
        return float(np.max(np.hypot(*self.corners)))

    @property
    def _lengths(self) -> Array:
        """Lengths of the edges between the points [mm], (n - 1,)."""
        return np.asarray(np.hypot(*np.diff(self.corners)))

    @property
    def symmetric(self) -> bool:
        """Whether it is its own mirror image in y -> -y, supports included."""
        y, z = self.corners
        mirrored = np.stack([-y[::-1], z[::-1]])
        same = np.allclose(self.corners, mirrored, rtol=0, atol=SAME_PLACE * self.size)
        return bool(same and sum(self.clamped) == len(self.points) + 1)

    @property
    def support(self) -> Array:
        """The points from the first to the last clamped one, (2, n) [mm]."""
        first, last = self.clamped
        return self.corners[:, first - 1 : last]

    def on_clamped_edges(self, y: Array, z: Array) -> tuple[Mask, ...]:
        """For each clamped edge, whether points (y, z) [mm] lie on it, shape of y each."""
        return tuple(
            _distance(np.stack([y, z]), start, end) < SAME_PLACE * self.size
            for start, end in pairwise(self.support.T)
        )

    def contour_ends(self, contour: Contour) -> tuple[float, float]:
        """Arc lengths [mm] at which the contour meets the outline, on the left and on the right.

        Raises WrongInput for a plane that goes to neither of its points.
        """
        left, right = (
            self._end(contour, limit, point, direction)
            for limit, point, direction in zip(contour.limits, (-1, 0), (-1, +1), strict=True)
        )
        if not right - left > SAME_PLACE * self.size:
            raise WrongInput(
                "outline.points: a plane has no ends of its own: the first point must lie on it at y > 0, "
                "the last one at y < 0"
            )
        return left, right

    def _end(self, contour: Contour, limit: float, number: int, direction: int) -> float:
        """Arc length [mm] of the contour's end: a point of the outline on its tangent, or its limit."""
        y, z = self.corners[:, number] - contour.position(limit)
        cos, minus_sin = contour.tangent(limit)
        along, off = direction * (cos * y + minus_sin * z), abs(cos * z - minus_sin * y)
        on_tangent = along > 0 and off <= SAME_PLACE * self.size
        return float(limit + direction * along) if on_tangent else limit

    def beyond(self, contour: Contour) -> Array:
        """The points without those where the contour ends, (2, n) [mm]."""
        ends = contour.position(np.array(self.contour_ends(contour)))
        start, stop = (
            int(np.hypot(*(self.corners[:, number] - ends[:, end])) <= SAME_PLACE * self.size)
            for number, end in ((0, 1), (-1, 0))
        )
        return self.corners[:, start : len(self.points) - stop]

    def right_half_beyond(self, contour: Contour) -> Array:
        """The same of a symmetric outline at y >= 0, down to the plane of symmetry, (2, n) [mm]."""
        points = self.beyond(contour)
        n = points.shape[1]
        middle = np.array([[0.0], [np.mean(points[1, [(n - 1) // 2, n // 2]])]])
        return np.hstack([points[:, : n // 2], middle])

    def closed(self, contour: Contour) -> Array:
        """The whole boundary of the section: points of the contour, then of the outline, (2, n) [mm]."""
        s = np.linspace(*self.contour_ends(contour), CONTOUR_PIECES + 1)
        return np.hstack([contour.position(s), self.beyond(contour)])


@lru_cache(maxsize=64)
def check_outline(outline: SectionOutline, contour: Contour, side: int) -> None:
    """Raise WrongInput for an outline that crosses itself or the contour, or runs round the wrong side."""
    boundary = outline.closed(contour)
    crossing = _first_crossing(boundary)
    if crossing is not None:
        raise WrongInput(
            f"outline.points: the outline crosses itself or the contour at y = {crossing[0]:.4g}, z = "
            f"{crossing[1]:.4g} mm; give the points in order, from the right end of the contour (s > 0) "
            "around the body to its left end"
        )
    if np.sign(signed_area(boundary)) != side:
        below = "below" if side < 0 else "above"
        raise WrongInput(
            f"outline.points: the body would not lie {below} the contour; give the points from the right "
            "end of the contour (s > 0) around the body to its left end"
        )


def signed_area(boundary: Array) -> float:
    """Area [mm^2] inside a closed polygon (2, n) [mm], positive where it turns from y to z."""
    (y, z), (next_y, next_z) = boundary, np.roll(boundary, -1, axis=1)
    return float(np.sum(y * next_z - next_y * z) / 2)


def corner_turns(boundary: Array) -> Array:
    """Amounts by which a closed polygon (2, n) turns at its points [rad], shape (n,)."""
    after = np.roll(boundary, -1, axis=1) - boundary
    before = np.roll(after, 1, axis=1)
    return np.asarray(np.abs(np.arctan2(_cross(before, after), np.sum(before * after, axis=0))))


def widths(boundary: Array, spacing: float) -> tuple[Array, Array]:
    """Points on the boundary of a section, (2, n) [mm], and how wide the section is there, (n,) [mm].

    The boundary (2, m) is a closed polygon; points on its edges are at most `spacing` [mm] apart. The width
    is the distance to the opposite edge along the normal, infinite where that is a neighbour, at a corner.
    """
    along = np.roll(boundary, -1, axis=1) - boundary
    lengths = np.hypot(*along)
    pieces = np.ceil(lengths / spacing).astype(int)
    edges = np.repeat(np.arange(len(lengths)), pieces)
    shares = np.concatenate([(np.arange(n) + 0.5) / n for n in pieces])
    points = boundary[:, edges] + shares * along[:, edges]
    inward = np.sign(signed_area(boundary)) * np.stack([-along[1], along[0]]) / lengths
    nearest = [
        _width(boundary, along, point, inward[:, edge], edge)
        for point, edge in zip(points.T, edges.tolist(), strict=True)
    ]
    return points, np.array(nearest)


def _width(boundary: Array, along: Array, point: Array, inward: Array, edge: int) -> float:
    """The width [mm] at a point on an edge of the boundary, along a unit vector into the section."""
    across, apart = _cross(inward[:, None], along), boundary - point[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance, share = _cross(apart, along) / across, _cross(apart, inward[:, None]) / across
    distance[~((distance > 0) & (share >= 0) & (share <= 1))] = np.inf
    distance[edge] = np.inf
    opposite, n = int(np.argmin(distance)), boundary.shape[1]
    is_neighbour = (opposite - edge) % n in (1, n - 1)
    return np.inf if is_neighbour else float(distance[opposite])


def _cross(first: Array, second: Array) -> Array:
    """Cross product of vectors (2, ...)."""
    return np.asarray(first[0] * second[1] - first[1] * second[0])


def _distance(points: Array, start: Array, end: Array) -> Array:
    """Distances [mm] of points (2, ...) from a straight edge, shape of the points."""
    along, apart = end - start, np.moveaxis(points, 0, -1) - start
    share = np.clip(apart @ along / (along @ along), 0, 1)
    return np.asarray(np.linalg.norm(apart - share[..., None] * along, axis=-1))


def _first_crossing(boundary: Array) -> Array | None:
    """A point (y, z) [mm] where edges of a closed polygon (2, n) cross or touch, None where none do."""
    along = np.roll(boundary, -1, axis=1) - boundary
    n = boundary.shape[1]
    apart = boundary[:, None] - boundary[:, :, None]  # (2, n, n), of the second edge from the first
    across = _cross(along[:, :, None], along[:, None])
    lengths = np.hypot(*along)
    across[np.abs(across) < PARALLEL * lengths[:, None] * lengths] = 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        share = _cross(apart, along[:, None]) / across
        other_share = _cross(apart, along[:, :, None]) / across
    cross = (share >= 0) & (share <= 1) & (other_share >= 0) & (other_share <= 1)
    gap = np.abs(np.arange(n)[:, None] - np.arange(n))
    pairs = np.argwhere(cross & (np.minimum(gap, n - gap) > 1))
    if not len(pairs):
        return None
    first, second = pairs[0]
    return np.asarray(boundary[:, first] + share[first, second] * along[:, first])


# --- standard rails ---

STEEP, FLAT = 1 / 2.75, 1 / 14  # slopes of the fishing surfaces, and of the foot near its edge
SIDE_SLOPE = 1 / 20  # of the sides of rail heads, y by z
PIECES = 4  # straight edges that stand for a rounding


@dataclass(frozen=True)
class RailSection:
    """A symmetric rail below the sides of its head; lengths in mm.

    The fishing surfaces of head and foot meet the axis at `head` below the top and at `foot` above the base;
    (y, z) of `side` is a point of the side of the head. One radius `rounding` stands for the curved
    transitions between web and fishing surfaces. Other roundings are left out.
    """

    height: float
    width: float  # of the foot
    web: float  # least thickness
    head: float
    foot: float
    edge: float  # height of the edge of the foot
    side: tuple[float, float]
    rounding: float

    @property
    def outline(self) -> SectionOutline:
        """The outline, from the lower edge of the head on the field side to the one on the gauge side."""
        right = self._right
        points = np.hstack([right, right[:, ::-1] * [[-1], [1]]])
        n = right.shape[1]
        return SectionOutline.through(points, (n, n + 1))

    @property
    def _right(self) -> Array:
        """Points of the right half, (2, n) [mm]."""
        half_web, half_foot = self.web / 2, self.width / 2
        head_z, foot_z = -self.head, self.foot - self.height  # of the fishing surfaces at the axis
        y, z = self.side
        lower_y = (y + SIDE_SLOPE * (z - head_z)) / (1 + SIDE_SLOPE * STEEP)
        break_y = (foot_z - self.edge + self.height - FLAT * half_foot) / (STEEP - FLAT)
        corners = [
            (lower_y, head_z + STEEP * lower_y),
            (half_web, head_z + STEEP * half_web),
            (half_web, foot_z - STEEP * half_web),
            (break_y, foot_z - STEEP * break_y),
            (half_foot, self.edge - self.height),
            (half_foot, -self.height),
        ]
        top, bottom = (rounded(np.array(corners[k : k + 3]), radius=self.rounding) for k in (0, 1))
        return np.hstack([np.array(corners[:1]).T, top, bottom, np.array(corners[3:]).T])


def rounded(points: Array, *, radius: float) -> Array:
    """Points (2, PIECES + 1) [mm] of an arc that rounds the corner at the second of points (3, 2) [mm]."""
    before, corner, after = points
    to_before, to_after = ((point - corner) / np.hypot(*(point - corner)) for point in (before, after))
    half_angle = np.arccos(to_before @ to_after) / 2
    bisector = (to_before + to_after) / (2 * np.cos(half_angle))
    centre = corner + radius / np.sin(half_angle) * bisector
    across = np.array([-bisector[1], bisector[0]])
    turn = np.linspace(-1, 1, PIECES + 1) * (np.pi / 2 - half_angle) * np.sign(across @ to_after)
    return np.asarray(
        centre[:, None] - radius * (np.outer(bisector, np.cos(turn)) - np.outer(across, np.sin(turn)))
    )


RAIL_SECTIONS: Mapping[str, RailSection] = {
    # EN 13674-1, 60E1: height, foot, web, head and foot depths, slopes and edge of the foot. The web of the
    # standard is concave, of which only the least thickness is taken; with the rounding of 20 mm the area is
    # 76.3 (standard: 76.7) cm^2
    "60E1": RailSection(172.0, 150.0, 16.5, 51.0, 31.5, 11.5, (36.98, -34.0), 20.0),
}
