"""Contact surfaces: a contour, extruded along x or revolved about an axis parallel to y.

On a surface of revolution x is arc length along the rolling circles. Points have the chart (xi, s):
s is arc length along the contour, xi = R_roll theta, theta the angle about the axis. At s = 0 xi is
x; for R_roll = infinity, the prismatic surface, it is x everywhere.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.contours import Contour
from geometries.errors import WrongInput

UPPER, LOWER = +1, -1
SEAM = 1e-9  # rad, width of the seam at which a model that goes all the way round ends


@dataclass(frozen=True)
class Surface:
    """A prismatic surface, or one of revolution about y = any, z = side * rolling_radius.

    side +1: its body is the upper one and fills n > 0; -1: the lower one. rolling_radius [mm] is that
    of the circle through the contact centre, infinite on a prismatic surface.
    """

    side: int
    contour: Contour
    rolling_radius: float = np.inf

    def __post_init__(self) -> None:
        if self.side not in (UPPER, LOWER):
            raise WrongInput(f"side = {self.side!r}: +1 for the upper body, -1 for the lower")
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
        return self.turned(np.stack(np.broadcast_arrays(xi, *self.contour.position(s))))

    def turned(self, section_points: Array) -> Array:
        """Global positions of points (xi, y, z): section coordinates (y, z), turned to xi; (3, n)."""
        xi, y, z = section_points
        theta = xi / self.rolling_radius
        x = xi * np.sinc(theta / np.pi) - self.side * z * np.sin(theta)
        sagitta = xi * np.sin(theta / 2) * np.sinc(theta / 2 / np.pi)
        return np.stack([x, y, self.side * sagitta + z * np.cos(theta)])

    def turned_back(self, points: Array) -> Array:
        """(xi, y, z) of points in global axes: the inverse of `turned`, -pi R < xi <= pi R; shape (3, n)."""
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

        def turned(v: Array) -> list[Array]:
            return [-sin * v[1], v[0], cos * v[1]]

        along_x = [cos, np.zeros_like(cos), sin]
        components = along_x + turned(self.contour.tangent(s)) + turned(self.contour.normal(s))
        stacked = np.stack(np.broadcast_arrays(*components))
        return stacked.reshape(3, 3, *stacked.shape[1:])
