"""Outlines of standard rails below their heads, from the dimensions of the standards, clamped at the foot.

They are in the axes of profiles: y to the field side, z up, from the top of the head. A standard gives a
section more dimensions than are here; what the straight edges leave out is stated for each.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array
from geometries.outlines import SectionOutline

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
        return SectionOutline.of(points, (n, n + 1))

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
