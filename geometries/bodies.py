"""Bodies: a contact contour, extruded along x or revolved about an axis parallel to y, and a material.

On a body of revolution x is arc length along the rolling circles. Points of its surface have the
chart (xi, s): s is arc length along the contour, xi = R_roll theta, theta the angle about the axis.
At s = 0 xi is x; for R_roll = infinity, the prismatic body, it is x everywhere.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.materials import Material

Array = NDArray[np.float64]

UPPER, LOWER = +1, -1
HUB = 0.2  # default hub radius, and the smallest one, as a share of the rolling radius
END_SAMPLES = 4001
SEAM = 1e-9  # rad, where a model that goes all the way round ends


@dataclass(frozen=True)
class Domain:
    """How much of a body is modelled: clamped at the far arc, at both ends and at the hub, free elsewhere.

    far_radius [mm] is the radius of the far arc about the contact centre, half_length [mm] the
    extent along +x and along -x, on a body of revolution along the rolling circle of s = 0.
    """

    far_radius: float
    half_length: float

    def __post_init__(self) -> None:
        if not (self.far_radius > 0 and self.half_length > 0):
            raise WrongInput(
                f"far_radius = {self.far_radius!r}, half_length = {self.half_length!r}: must be positive [mm]"
            )

    def scaled(self, factor: float) -> "Domain":
        """The same domain, `factor` times as large."""
        return Domain(factor * self.far_radius, factor * self.half_length)


@dataclass(frozen=True)
class Body:
    """A prismatic body, or one of revolution about y = any, z = side * rolling_radius.

    side +1: upper, fills n > 0; -1: lower. rolling_radius [mm] is that of the circle through the
    contact centre, infinite on a prismatic body. hub_radius [mm]: the section ends there, clamped.
    """

    side: int
    contour: Contour
    material: Material
    domain: Domain
    rolling_radius: float = np.inf
    hub_radius: float | None = None

    def __post_init__(self) -> None:
        if not self.rolling_radius > 0:
            raise WrongInput(f"rolling_radius = {self.rolling_radius!r}: must be positive [mm]")
        if self.hub_radius is not None and np.isinf(self.rolling_radius):
            raise WrongInput(
                f"hub_radius = {self.hub_radius!r}: a prismatic body has none; give rolling_radius"
            )
        if self.hub_radius is not None and not HUB * self.rolling_radius <= self.hub_radius:
            raise WrongInput(
                f"hub_radius = {self.hub_radius!r}: at least {HUB:g} rolling_radius "
                f"({HUB * self.rolling_radius:g} mm)"
            )
        if not self.depth > 0:
            raise WrongInput(f"hub_radius = {self.hub_radius!r}: must be smaller than rolling_radius")

    @property
    def depth(self) -> float:
        """Height [mm] between contact centre and hub; infinite on a prismatic body."""
        if np.isinf(self.rolling_radius):
            return np.inf
        return self.rolling_radius - (self.hub_radius or HUB * self.rolling_radius)

    @property
    def reaches_hub(self) -> bool:
        """Whether the modelled section goes as far as the hub."""
        return self.depth < self.domain.far_radius

    @property
    def closed(self) -> bool:
        """Whether the model goes all the way round."""
        return self.domain.half_length >= np.pi * self.rolling_radius

    @property
    def xi_end(self) -> float:
        """Chart coordinate [mm] at which the model ends."""
        return min(self.domain.half_length, np.pi * self.rolling_radius)

    @property
    def s_range(self) -> tuple[float, float]:
        """Arc lengths at which the contour meets the far arc or the hub."""
        return section_end(self, -1), section_end(self, +1)

    def circle_radius(self, s: ArrayLike) -> Array:
        """Radius R(s) [mm] of the rolling circle at arc length s."""
        return np.asarray(self.rolling_radius - self.side * self.contour.position(s)[1])

    def chart_x(self, x: ArrayLike, s: ArrayLike, s_load: ArrayLike) -> Array:
        """Chart coordinate xi [mm] of an element at distance x from one at arc length s_load.

        The angle between them is x over the mean radius of their circles.
        """
        z = (self.contour.position(s)[1] + self.contour.position(s_load)[1]) / 2
        return np.asarray(x / (1 - self.side * z / self.rolling_radius))

    def surface(self, xi: ArrayLike, s: ArrayLike) -> Array:
        """Points of the contact surface in global axes [mm], shape (3, n)."""
        xi, s = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(s, dtype=float))
        return self.turned(np.stack([xi, *self.contour.position(s)]))

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
        xi, s = np.broadcast_arrays(np.asarray(xi, dtype=float), np.asarray(s, dtype=float))
        theta = xi / self.rolling_radius
        cos, sin, zero = np.cos(theta), self.side * np.sin(theta), np.zeros_like(theta)

        def turned(v: Array) -> list[Array]:
            return [-sin * v[1], v[0], cos * v[1]]

        tangent, normal = self.contour.tangent(s), self.contour.normal(s)
        return np.array([[cos, zero, sin], turned(tangent), turned(normal)])


@lru_cache(maxsize=64)
def section_end(body: Body, direction: int) -> float:
    """Arc length [mm] at which the contour meets the far arc or the hub, growing s for direction +1."""
    far, contour = body.domain.far_radius, body.contour
    joint = contour.limits[1 if direction > 0 else 0]

    def beyond(s: ArrayLike) -> Array:
        y, z = contour.position(s)
        return np.asarray(np.maximum(np.hypot(y, z) - far, body.side * z - body.depth))

    samples = np.linspace(0, joint + direction * 2 * far, END_SAMPLES)
    first = int(np.argmax(beyond(samples) > 0))
    return float(brentq(lambda s: float(beyond(s)), samples[first - 1], samples[first], xtol=1e-12))
