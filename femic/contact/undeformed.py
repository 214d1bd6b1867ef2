"""The undeformed distance of two surfaces, along the normals of the lower one.

The lower surface is prismatic, the upper one prismatic or of revolution. The upper one is moved along y,
comes down along z until both touch, and by the approach zeta [mm] beyond that. Source: [BVSV];
docs/theory/contact.md.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from geometries.arrays import Array
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.surfaces import Surface

SAMPLES = 2001  # arc lengths among which the first touching point and first guesses are sought
NEWTON_STEPS = 40  # largest number
NEAR_AXIS = 1e-9  # least radius of a circle over the rolling radius: flanks may rise beyond the axle
ROUNDING = 1e-14  # tolerance of an arc length, as a share of the largest one


@dataclass(frozen=True)
class Undeformed:
    """Two surfaces above each other, the upper one moved by `shift` [mm] along y.

    `s_range` [mm] are the arc lengths of the lower contour at which they may touch. Raises WrongInput for a
    lower surface of revolution, and where no part of the upper contour lies above this range.
    """

    upper: Surface
    lower: Surface
    s_range: tuple[float, float]
    shift: float = 0.0

    def __post_init__(self) -> None:
        if np.isfinite(self.lower.rolling_radius):
            raise WrongInput(
                f"rolling_radius = {self.lower.rolling_radius:g} of the lower body: it must be prismatic"
            )
        if not (self.s_range[0] < self.s_range[1] and np.all(np.isfinite(self.s_range))):
            raise WrongInput(f"s_range = {self.s_range!r}: two finite arc lengths, the smaller one first")
        if not np.isfinite(self._clearance(np.linspace(*self.s_range, SAMPLES))).any():
            raise WrongInput(f"shift = {self.shift:g} mm: no part of the upper contour lies above the lower")

    @cached_property
    def touching(self) -> tuple[float, float]:
        """Arc length [mm] of the lower contour where both touch first; how far the upper one is raised [mm].

        It is sought in the plane x = 0, where each rolling circle is lowest.
        """
        s = np.linspace(*self.s_range, SAMPLES)
        clearances = self._clearance(s)
        least = int(np.argmin(clearances))
        around = slice(max(least - 1, 0), least + 2)
        beside = s[around][np.isfinite(clearances[around])]  # an end of the upper contour may be near
        between = minimize_scalar(
            lambda at: float(self._clearance(np.array(at))),
            bounds=(beside[0], beside[-1]),
            method="bounded",
            options={"xatol": 1e-9 * (s[-1] - s[0])},
        )
        closest = min((clearances[least], s[least]), (between.fun, between.x))
        return float(closest[1]), float(-closest[0])

    @property
    def upper_offset(self) -> float:
        """Arc length [mm] of the upper contour where both touch first, less that of the lower one."""
        s = self.touching[0]
        return float(self.opposite(s) - s)

    def opposite(self, s: ArrayLike) -> Array:
        """Arc length [mm] of the upper contour vertically above arc lengths of the lower one, shape of s."""
        return _arc_length_at(self.upper.contour, self.lower.contour.position(s)[0] - self.shift)

    def moved_to(self, shift: float) -> "Undeformed":
        """Return the surfaces with the upper one at another position along y [mm]."""
        return replace(self, shift=shift)

    def upper_height(self, s: ArrayLike) -> Array:
        """Height [mm] of the upper surface over its own origin where it is opposite s at x = 0, shape of s.

        Opposite is along the normal of the lower surface, or there where that does not meet the upper one.
        """
        s = np.asarray(s, dtype=float)
        distance = self.distance(0.0, s)
        apart = np.where(np.isfinite(distance), distance, 0.0) * self.lower.contour.normal(s)[1]
        return np.asarray(self.lower.contour.position(s)[1] - self.touching[1] + apart)

    def distance(self, x: ArrayLike, s: ArrayLike, approach: float = 0.0, lateral: float = 0.0) -> Array:
        """Return distance [mm] along the normal of the lower surface at (x, s) [mm], shape broadcast(x, s).

        The upper surface has come down by `approach` and moved by `lateral` [mm] along y since both touched.
        Negative where the surfaces overlap; infinite where the normal does not meet the upper surface.
        """
        x, s = np.asarray(x, dtype=float), np.asarray(s, dtype=float)
        y, z = self.lower.contour.position(s)
        sin, cos = self.lower.contour.normal(s)
        y, z = y - self.shift - lateral, z - self.touching[1] + approach  # in axes of the upper surface
        t, missed = self._met(x, (y, z), (sin, cos))
        point_y, point_z = self.upper_section(x, t)[0]
        distance = (point_y - y) * sin + (point_z - z) * cos
        return np.asarray(np.where(missed, np.inf, distance))

    def vertical_distance(self, s: ArrayLike, approach: float = 0.0, lateral: float = 0.0) -> Array:
        """Return the vertical distance [mm] of both sections at x = 0 above s [mm], shape of s.

        The upper body has come down by `approach` and moved by `lateral` [mm] along y since both touched.
        """
        return self._clearance(np.asarray(s, dtype=float), lateral) + self.touching[1] - approach

    def _clearance(self, s: Array, lateral: float = 0.0) -> Array:
        """Vertical distance [mm] of both contours, in their own axes; infinite beside the upper one."""
        y, z = self.lower.contour.position(s)
        t = _arc_length_at(self.upper.contour, y - self.shift - lateral)
        low, high = self.upper.contour.extent
        z_upper = self.upper.contour.position(t)[1]
        return np.asarray(np.where((t >= low) & (t <= high), z_upper - z, np.inf))

    def _met(
        self, x: Array, start: tuple[Array, Array], normal: tuple[Array, Array]
    ) -> tuple[Array, np.ndarray]:
        """Arc lengths of the upper contour where normals meet the upper surface; which of them do not."""
        (y, z), (sin, cos) = start, normal
        t = np.broadcast_to(_arc_length_at(self.upper.contour, y), np.broadcast_shapes(x.shape, y.shape))
        tolerance = ROUNDING * max(float(np.max(np.abs(t))), float(np.ptp(self.s_range)))
        for _ in range(NEWTON_STEPS):
            (point_y, point_z), (dy, dz) = self.upper_section(x, t)
            across = dy * cos - dz * sin
            step = ((point_y - y) * cos - (point_z - z) * sin) / np.maximum(across, 0.1 * dy)
            t = t - step
            moved = np.abs(step) > 16 * tolerance
            if not moved.any():
                break
        low, high = self.upper.contour.extent
        beside_wheel = np.abs(x) >= self.upper.circle_radius(t)
        return t, moved | (across <= 0) | (t < low) | (t > high) | beside_wheel

    def upper_section(self, x: Array, t: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Return points (y, z) of the upper surface in the plane at x, and their derivatives by t."""
        (y, z), (dy, dz) = self.upper.contour.position(t), self.upper.contour.tangent(t)
        if np.isinf(self.upper.rolling_radius):
            return (y, z), (dy, dz)
        radius = np.maximum(self.upper.rolling_radius - z, NEAR_AXIS * self.upper.rolling_radius)
        height = np.sqrt(np.maximum(radius**2 - x**2, 0))
        return (y, z + x**2 / (radius + height)), (dy, dz * radius / np.maximum(height, 1e-9 * radius))


def _arc_length_at(contour: Contour, y: Array) -> Array:
    """Arc length [mm] at lateral coordinate y [mm]: y grows with it, because no contour overhangs."""
    reach = float(np.max(np.abs(y))) + 1.0
    inner = np.linspace(*contour.limits, SAMPLES)
    ends = contour.position(inner[[0, -1]])[0], contour.tangent(inner[[0, -1]])[0]
    left = inner[0] - max(0.0, ends[0][0] + reach) / ends[1][0]
    right = inner[-1] + max(0.0, reach - ends[0][1]) / ends[1][1]
    table = np.unique(np.concatenate([[left], inner, [right]]))
    t = np.interp(y, contour.position(table)[0], table)
    for _ in range(NEWTON_STEPS):
        step = (contour.position(t)[0] - y) / contour.tangent(t)[0]
        t = t - step
        if np.max(np.abs(step), initial=0.0) <= ROUNDING * max(abs(left), abs(right)):
            break
    return np.asarray(t)
