"""The undeformed distance of two surfaces: along the normals of the lower one, or of a tangent plane.

The lower surface is prismatic, the upper one prismatic or of revolution. The upper one is moved along y,
comes down along z until both touch, and by the approach zeta [mm] beyond that. `Undeformed` has the distance
along the normals of the lower surface. Source: [BVSV]; docs/theory/contact.md.

`TangentPlane` sees the surfaces as programs for planar contact do: they lay all elements into the plane that
is tangent to both where they touch, with one contact angle delta_0. Both sections are heights along the
normal of the plane over the coordinate in it, and the undeformed distance is their difference,

    h(x, s) = eta_upper(x, s) - eta_lower(s),

here without an approximation: that of a surface of revolution in each plane of constant x, at all x. Where a
section turns beyond the normal of the plane it is no function of s, and the distance ends: it is infinite
there, so that no contact is possible.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from geometries.arrays import Array
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.surfaces import LOWER, Surface

# --- along the normals of the lower surface ---

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
        above = _arc_length_at(self.upper.contour, start[0])
        given = np.broadcast_arrays(x, *start, *normal, above)
        x, y, z, sin, cos, t = (part.flatten() for part in given)
        tolerance = ROUNDING * max(float(np.max(np.abs(t))), float(np.ptp(self.s_range)))
        across, sought = np.empty_like(t), np.arange(t.size)
        for _ in range(NEWTON_STEPS):  # a few normals meet nothing: the others need not wait for them
            (point_y, point_z), (dy, dz) = self.upper_section(x[sought], t[sought])
            across[sought] = dy * cos[sought] - dz * sin[sought]
            off = (point_y - y[sought]) * cos[sought] - (point_z - z[sought]) * sin[sought]
            step = off / np.maximum(across[sought], 0.1 * dy)
            t[sought] -= step
            sought = sought[np.abs(step) > 16 * tolerance]
            if not sought.size:
                break
        moved = np.zeros(t.shape, bool)
        moved[sought] = True
        low, high = self.upper.contour.extent
        beside_wheel = np.abs(x) >= self.upper.circle_radius(t)
        missed = moved | (across <= 0) | (t < low) | (t > high) | beside_wheel
        return t.reshape(given[0].shape), missed.reshape(given[0].shape)

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
    inner, laterals, slopes = _samples_of(contour)
    left = min(0.0, -reach - laterals[0])  # beyond the ends, along tangents
    right = max(0.0, reach - laterals[-1])
    between = np.concatenate([[laterals[0] + left], laterals, [laterals[-1] + right]])
    left, right = inner[0] + left / slopes[0], inner[-1] + right / slopes[1]
    t = np.interp(y, between, np.concatenate([[left], inner, [right]]))
    for _ in range(NEWTON_STEPS):
        step = (contour.position(t)[0] - y) / contour.tangent(t)[0]
        t = t - step
        if np.max(np.abs(step), initial=0.0) <= ROUNDING * max(abs(left), abs(right)):
            break
    return np.asarray(t)


@lru_cache(maxsize=16)  # for the same bodies again and again
def _samples_of(contour: Contour) -> tuple[Array, Array, Array]:
    """Arc lengths of samples between the limits of a contour, y [mm] there, and slopes dy/ds at both ends."""
    s = np.unique(np.linspace(*contour.limits, SAMPLES))
    return s, contour.position(s)[0], contour.tangent(s[[0, -1]])[0]


# --- over a tangent plane ---

Points = Array | tuple[Array, Array]  # (y, z) [mm]
FAR_SAMPLES = 101  # on each flank beyond
LEAST_ALONG = 1e-3  # along the plane per arc length, in steps of Newton's method


@dataclass(frozen=True)
class Line:
    """A straight line through `origin` (y, z) [mm], its inclination [rad]."""

    origin: tuple[float, float]
    delta: float

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""
        (y, z), s = self.origin, np.asarray(s)
        return np.stack([y + s * np.cos(self.delta), z - s * np.sin(self.delta)])

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        return np.full(np.shape(s), self.delta)

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm]: 0, shape of s."""
        return np.zeros(np.shape(s))

    def along(self, points: Points) -> Array:
        """Coordinate on the line [mm] of points (y, z)."""
        (y, z), (y_0, z_0) = points, self.origin
        return np.asarray((y - y_0) * np.cos(self.delta) - (z - z_0) * np.sin(self.delta))

    def height(self, points: Points) -> Array:
        """Height over the line [mm] of points (y, z)."""
        (y, z), (y_0, z_0) = points, self.origin
        return np.asarray((y - y_0) * np.sin(self.delta) + (z - z_0) * np.cos(self.delta))


@dataclass(frozen=True)
class TangentPlane:
    """The tangent plane of two bodies at arc length `at` [mm] of the lower contour, None: where they touch.

    A given `inclination` [rad] is that of a plane through this point which need not be tangent.
    It takes the place of `Undeformed` in a contact: `lower` is the plane, and s [mm] the coordinate in it,
    from this point. Raises WrongInput where the bodies are not opposite at `at`.
    """

    bodies: Undeformed
    at: float | None = None
    inclination: float | None = None

    def __post_init__(self) -> None:
        if not np.isfinite(self.distance(0.0, 0.0)):
            raise WrongInput(
                f"tangent plane at s = {self.place:g} mm: the bodies are not opposite there; give another "
                "place, or none for that of first touch"
            )

    @property
    def place(self) -> float:
        """Arc length [mm] of the lower contour at which the plane is tangent."""
        return self.bodies.touching[0] if self.at is None else self.at

    @cached_property
    def line(self) -> Line:
        """The section of the plane."""
        contour = self.bodies.lower.contour
        y, z = contour.position(self.place)
        own = float(contour.inclination(self.place))
        return Line((float(y), float(z)), own if self.inclination is None else self.inclination)

    @property
    def angle(self) -> float:
        """The contact angle [rad]: the inclination of the plane."""
        return self.line.delta

    @cached_property
    def lower(self) -> Surface:
        """The plane, as a surface whose arc length is the coordinate in it."""
        return Surface(LOWER, Contour(self.line, (0.0, 0.0)))

    @property
    def upper(self) -> Surface:
        """The upper surface."""
        return self.bodies.upper

    @property
    def shift(self) -> float:
        """The upper body is moved by this along y [mm]."""
        return self.bodies.shift

    @property
    def touching(self) -> tuple[float, float]:
        """Coordinate of the touching point, 0 by definition, and how far the upper body is raised [mm]."""
        return 0.0, self.bodies.touching[1]

    @property
    def upper_offset(self) -> float:
        """Arc length of the upper body where both touch less that of the lower one: 0 in the plane."""
        return 0.0

    @cached_property
    def s_range(self) -> tuple[float, float]:
        """Coordinates [mm] between which the lower section is a function of the coordinate."""
        _, along = self._lower_table
        return float(along[0]), float(along[-1])

    def moved_to(self, shift: float) -> "TangentPlane":
        """Return the plane where the bodies touch with the upper one at another position along y [mm]."""
        return TangentPlane(self.bodies.moved_to(shift))

    def upper_height(self, s: ArrayLike) -> Array:
        """Height [mm] over the origin of the upper body: that of the plane, (shape of s)."""
        return np.asarray(self.lower.contour.position(s)[1] - self.touching[1])

    def distance(self, x: ArrayLike, s: ArrayLike, approach: float = 0.0, lateral: float = 0.0) -> Array:
        """Return distance [mm] along the normal of the plane at (x, s) [mm], shape broadcast(x, s).

        The upper body has come down by `approach` and moved by `lateral` [mm] along y since both touched.
        Infinite where one of the sections does not lie over the plane.
        """
        x, s = np.asarray(x, dtype=float), np.asarray(s, dtype=float)
        t = self.lower_arc_length(s)
        points = self.bodies.lower.contour.position(np.where(np.isnan(t), self.place, t))
        lower = np.where(np.isnan(t), np.nan, self.line.height(points))
        upper = self._upper_heights(x, s, (approach, lateral))
        beside = np.isnan(upper) | np.isnan(lower)
        return np.where(beside, np.inf, np.where(beside, 0.0, upper) - np.where(beside, 0.0, lower))

    def lower_arc_length(self, s: ArrayLike) -> Array:
        """Arc length [mm] of the lower contour opposite coordinates s [mm]; NaN where there is none."""
        s, table = np.asarray(s, dtype=float), self._lower_table
        over = (s >= table[1][0]) & (s <= table[1][-1])
        inside = np.where(over, s, 0.0)
        t = _solved(self._lower_along, inside, np.interp(inside, table[1], table[0]), table[0])
        return np.where(over, t, np.nan)

    def _upper_heights(self, x: Array, s: Array, moved: tuple[float, float]) -> Array:
        """Heights of the upper surface over the plane [mm], shape broadcast(x, s); NaN beside it."""
        x, s = np.broadcast_arrays(x, s)
        t = self._upper_guesses(x, s, moved)
        over = np.isfinite(t)
        at_x, samples = x[over], self._upper_samples
        t[over] = _solved(lambda at: self._upper_along(at_x, at, moved), s[over], t[over], samples)
        return self.line.height(self._raised(self.bodies.upper_section(x, t)[0], moved))

    def _upper_guesses(self, x: Array, s: Array, moved: tuple[float, float]) -> Array:
        """Arc lengths of the upper contour opposite (x, s) [mm], nearly; NaN where there are none."""
        t, guesses = self._upper_samples, np.full(x.shape, np.nan)
        rows, row = np.unique(x, return_inverse=True)
        along, rises = self._upper_along(rows[:, None], t[None], moved)
        inside_wheel = np.abs(rows[:, None]) < self.upper.circle_radius(t)
        along, rises = np.broadcast_arrays(along, np.where(inside_wheel, rises, 0.0))
        start = int(np.argmin(np.abs(t - self._opposite)))
        for k in range(len(rows)):
            first, last = _increasing(rises[k] > 0, start)
            over = (row.reshape(x.shape) == k) & (s >= along[k, first]) & (s <= along[k, last])
            guesses[over] = np.interp(s[over], along[k, first : last + 1], t[first : last + 1])
        return guesses

    def _upper_along(self, x: Array, t: Array, moved: tuple[float, float]) -> tuple[Array, Array]:
        """Coordinates in the plane of points of the upper section, and their derivatives by t."""
        points, (dy, dz) = self.bodies.upper_section(x, t)
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return self.line.along(self._raised(points, moved)), np.asarray(dy * cos - dz * sin)

    def _lower_along(self, t: Array) -> tuple[Array, Array]:
        """Coordinates in the plane of points of the lower section, and their derivatives by t."""
        contour = self.bodies.lower.contour
        return self.line.along(contour.position(t)), np.cos(contour.inclination(t) - self.angle)

    def _raised(self, points: Points, moved: tuple[float, float]) -> tuple[Array, Array]:
        """Return points of the upper section (y, z), moved down and aside, in the axes of the lower body."""
        (y, z), (down, aside) = points, moved
        return y + self.shift + aside, z + self.touching[1] - down

    @cached_property
    def _lower_table(self) -> tuple[Array, Array]:
        """Arc lengths of the lower contour in the range of the bodies, and their growing coordinates."""
        s = np.unique(np.append(_samples(self.bodies.lower.contour, self.bodies.s_range), self.place))
        along, rises = self._lower_along(s)
        first, last = _increasing(rises > 0, int(np.argmin(np.abs(s - self.place))))
        return s[first : last + 1], along[first : last + 1]

    @cached_property
    def _opposite(self) -> float:
        """Arc length of the upper contour above the place of the plane [mm]."""
        return float(self.bodies.opposite(self.place))

    @cached_property
    def _upper_samples(self) -> Array:
        """Arc lengths of the upper contour as far as the lower one goes, and half as far again."""
        middle, half = self._opposite, 1.5 * float(np.ptp(self.bodies.s_range))
        low, high = self.upper.contour.extent
        return _samples(self.upper.contour, (max(low, middle - half), min(high, middle + half)))


def _samples(contour: Contour, ends: tuple[float, float]) -> Array:
    """Return arc lengths between two ends: many between the limits of a contour, fewer on flanks, (n,)."""
    left, right = np.clip(contour.limits, *ends)
    parts = (
        np.linspace(ends[0], left, FAR_SAMPLES),
        np.linspace(left, right, SAMPLES),
        np.linspace(right, ends[1], FAR_SAMPLES),
    )
    return np.unique(np.concatenate(parts))


def _increasing(rises: NDArray[np.bool_], start: int) -> tuple[int, int]:
    """Return the first and the last of neighbouring samples around one of them that all rise."""
    falls = np.flatnonzero(~rises)
    before, behind = falls[falls <= start], falls[falls >= start]
    first = int(before[-1]) + 1 if len(before) else 0
    last = int(behind[0]) - 1 if len(behind) else len(rises) - 1
    return min(first, start), max(last, start)


def _solved(along: Callable[[Array], tuple[Array, Array]], s: Array, guess: Array, samples: Array) -> Array:
    """Return arc lengths at coordinates s by Newton's method, from a guess between neighbouring samples.

    NaN where it does not converge, as beside a place where the section turns beyond the normal.
    """
    t, most = guess, float(np.max(np.diff(samples)))
    tolerance = 16 * ROUNDING * float(np.max(np.abs(samples)))
    for _ in range(NEWTON_STEPS):
        found, rises = along(t)
        step = np.clip((found - s) / np.maximum(rises, LEAST_ALONG), -most, most)
        t, moved = t - step, np.abs(step) > tolerance
        if not np.any(moved):
            break
    return np.where(moved, np.nan, t)
