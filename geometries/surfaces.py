"""Contact surfaces: a contour, extruded along x or revolved about an axis parallel to y.

On a surface of revolution x is the arc length along the rolling circles. Points have the coordinates (xi, s),
the chart: s is the arc length along the contour, xi = R_roll theta, theta the angle about the axis. At s = 0
xi equals x; on a prismatic surface, where R_roll is infinite, it does so everywhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.contours import Contour
from geometries.errors import WrongInput

UPPER, LOWER = +1, -1
SEAM = 1e-9  # rad, width of the seam where a closed model of a body of revolution meets itself


@dataclass(frozen=True)
class Surface:
    """A prismatic surface, or one of revolution about the line x = 0, z = side * rolling_radius.

    The side is +1 for the upper body, which fills n > 0, and -1 for the lower one. rolling_radius [mm] is
    the radius of the circle through the contact centre, infinite on a prismatic surface.
    """

    side: int
    contour: Contour
    rolling_radius: float = np.inf

    def __post_init__(self) -> None:
        if self.side not in (UPPER, LOWER):
            raise WrongInput(f"side = {self.side!r}: give +1 for the upper body or -1 for the lower")
        if not self.rolling_radius > 0:
            raise WrongInput(f"rolling_radius = {self.rolling_radius!r}: must be positive [mm]")

    @property
    def prismatic(self) -> "Surface":
        """The same contour, extruded along x."""
        return Surface(self.side, self.contour)

    def circle_radius(self, s: ArrayLike) -> Array:
        """Radius R(s) [mm] of the rolling circle at arc length s, shape of s."""
        return np.asarray(self.rolling_radius - self.side * self.contour.position(s)[1])

    def chart_x(self, x: ArrayLike, s: ArrayLike, s_load: ArrayLike) -> Array:
        """Chart coordinate xi [mm] of an element at distance x from one at arc length s_load.

        The angle between them is x over the mean radius of their circles.
        """
        z = (self.contour.position(s)[1] + self.contour.position(s_load)[1]) / 2
        return np.asarray(x / (1 - self.side * z / self.rolling_radius))

    def position(self, xi: ArrayLike, s: ArrayLike) -> Array:
        """Points of the contact surface in global axes [mm], shape (3, n)."""
        return self.to_global(np.stack(np.broadcast_arrays(xi, *self.contour.position(s))))

    def to_global(self, section_points: Array) -> Array:
        """Global positions (3, n) of points (xi, y, z): section coordinates (y, z), rotated to xi."""
        xi, y, z = section_points
        theta = xi / self.rolling_radius
        x = xi * np.sinc(theta / np.pi) - self.side * z * np.sin(theta)
        sagitta = xi * np.sin(theta / 2) * np.sinc(theta / 2 / np.pi)
        return np.stack([x, y, self.side * sagitta + z * np.cos(theta)])

    def to_chart(self, points: Array) -> Array:
        """Coordinates (xi, y, z) of points in global axes, (3, n): inverse of `to_global`, |xi| <= pi R."""
        if np.isinf(self.rolling_radius):
            return points
        x, y, z = points
        R, height = self.rolling_radius, self.side * points[2]
        radius = np.hypot(x, R - height)
        depth = (2 * R * height - z**2 - x**2) / (R + radius)
        theta = np.arctan2(x, R - height)
        on_seam = np.pi - np.abs(theta) < SEAM  # x is 0 but for rounding, of either sign
        return np.stack([R * np.where(on_seam, np.abs(theta), theta), y, self.side * depth])

    def axes(self, xi: ArrayLike, s: ArrayLike) -> Array:
        """Local directions x, s, n in global axes, shape (3 directions, 3 components, n)."""
        theta = np.asarray(xi, dtype=float) / self.rolling_radius
        cos, sin = np.cos(theta), self.side * np.sin(theta)

        def rotated(v: Array) -> list[Array]:
            return [-sin * v[1], v[0], cos * v[1]]

        along_x = [cos, np.zeros_like(cos), sin]
        components = along_x + rotated(self.contour.tangent(s)) + rotated(self.contour.normal(s))
        stacked = np.stack(np.broadcast_arrays(*components))
        return stacked.reshape(3, 3, *stacked.shape[1:])
