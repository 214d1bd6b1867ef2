"""Contact contours: curves in (y, z) by arc length s, continued by straight flanks.

s = 0 lies at the contact centre, which is the origin of (y, z); s grows with y. The inclination
delta(s) [rad] is positive where the contour falls as s grows, so the tangent is
(cos delta, -sin delta) and the normal (sin delta, cos delta). Both bodies use the same formulas.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import ArrayLike
from scipy.interpolate import PPoly

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.quadrature import on_panels

NEWTON_STEPS = 30  # largest number of steps
GAUSS_POINTS = 16  # per interval of a spline
NEAREST_SAMPLES = 4001  # number of arc lengths from the nearest of which Newton's method starts
LEAST_STRETCH = 0.1  # of distances along a parallel curve: nearly 0 at the centre of curvature
INVERSE_DEGREE = 8  # of polynomials of the parameter by the arc length
INVERSE_PARTS = (1, 2, 4, 8)  # of the intervals between knots
INVERSE_TESTED = np.array([0.07, 0.35, 0.6, 0.93])  # places in each part at which they are tested
INVERSE_ROUNDING = 1e-14  # of arc lengths by these polynomials, as a share of the length of the curve
LENGTH_ROUNDING = 1e-14  # tolerance of an arc length, as a share of the length of the curve


class Core(Protocol):
    """A curve by arc length with s = 0 at the origin of (y, z)."""

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""


@dataclass(frozen=True)
class Arc:
    """Circular arc about s = 0, delta = s / radius; negative where the contour is a groove."""

    radius: float

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape); the form that has the plane as its limit."""
        half = s / self.radius / 2
        return np.stack([s * np.sinc(2 * half / np.pi), -s * np.sin(half) * np.sinc(half / np.pi)])

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        return s / self.radius

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        return np.full_like(s, 1 / self.radius)


@dataclass(frozen=True)
class Ellipse:
    """Elliptic arc with its crown at s = 0; semi-axes lateral b_el and vertical d_el [mm]."""

    b_el: float
    d_el: float

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm], shape (2, *s.shape)."""
        phi = self.angle(s)
        return np.stack([self.b_el * np.sin(phi), self.d_el * (np.cos(phi) - 1)])

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        phi = self.angle(s)
        return np.arctan2(self.d_el * np.sin(phi), self.b_el * np.cos(phi))

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        return self.b_el * self.d_el / self._speed(self.angle(s)) ** 3

    def angle(self, s: Array) -> Array:
        """Eccentric angle from the crown at arc length s, shape of s."""
        inverse = self._inverse
        return self._inverted(s) if inverse is None else np.asarray(inverse(s))

    def _inverted(self, s: Array) -> Array:
        """The same by Newton's method."""
        phi = np.linspace(-np.pi, np.pi, 2049)
        return invert(self.arc_length, self._speed, s, (phi, self.arc_length(phi)))

    @cached_property
    def _inverse(self) -> PPoly | None:
        """The angle by the arc length, None where it is not exact."""
        return inverse_polynomials(self.arc_length, self._inverted, np.linspace(-np.pi, np.pi, 65))

    def arc_length(self, phi: Array) -> Array:
        """Arc length [mm] at eccentric angle phi, an incomplete elliptic integral; shape of phi."""
        return np.asarray(self.b_el * scipy.special.ellipeinc(phi, 1 - (self.d_el / self.b_el) ** 2))

    def _speed(self, phi: Array) -> Array:
        """Derivative of the arc length by the eccentric angle."""
        return np.hypot(self.b_el * np.cos(phi), self.d_el * np.sin(phi))


@dataclass(frozen=True, eq=False)
class Spline:
    """Spline (of polynomials (y, z) in pieces) by arc length; s = 0 at the parameter `t_centre`."""

    curve: PPoly
    t_centre: float
    to_knots: Array  # arc length [mm] from the first knot to each knot, (n_knots,)

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm] relative to the contact centre, shape (2, *s.shape)."""
        return np.moveaxis(self.curve(self.parameter(s)) - self.curve(self.t_centre), -1, 0)

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        dy, dz = np.moveaxis(self.curve(self.parameter(s), 1), -1, 0)
        return np.arctan2(-dz, dy)

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        t = self.parameter(s)
        (dy, dz), (ddy, ddz) = (np.moveaxis(self.curve(t, order), -1, 0) for order in (1, 2))
        return np.asarray((dz * ddy - dy * ddz) / np.hypot(dy, dz) ** 3)

    def parameter(self, s: Array) -> Array:
        """Spline parameter at arc length s, shape of s."""
        inverse = self._inverse
        return self._inverted(np.asarray(s)) if inverse is None else np.asarray(inverse(s))

    def _inverted(self, s: Array) -> Array:
        """Spline parameter at arc length s by Newton's method, shape of s."""
        return invert(self.arc_length, self._speed, s, (self.curve.x, self._lengths))

    @cached_property
    def _lengths(self) -> Array:
        """Arc length [mm] from the contact centre to each knot, (n_knots,)."""
        return np.asarray(self.to_knots - self._from_first(np.array(self.t_centre)))

    @cached_property
    def _inverse(self) -> PPoly | None:
        """The parameter by the arc length, None where it is not exact."""
        return inverse_polynomials(self.arc_length, self._inverted, self.curve.x)

    def arc_length(self, t: Array) -> Array:
        """Arc length [mm] from the contact centre to parameter t, shape of t."""
        return self._from_first(t) - self._from_first(np.array(self.t_centre))

    def _from_first(self, t: Array) -> Array:
        """Arc length [mm] from the first knot to parameter t."""
        knots = self.curve.x
        interval = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2)
        return np.asarray(self.to_knots[interval] + length_between(self.curve, knots[interval], t))

    def _speed(self, t: Array) -> Array:
        """Derivative of the arc length by the parameter."""
        return np.asarray(np.linalg.norm(self.curve(t, 1), axis=-1))


def length_between(curve: PPoly, start: Array, end: Array) -> Array:
    """Arc length [mm] of a spline between parameters of one of its intervals, by Gauss quadrature."""
    t, weights = on_panels(np.asarray(start), np.asarray(end), GAUSS_POINTS)
    return np.asarray(np.sum(weights * np.linalg.norm(curve(t, 1), axis=-1), axis=-1))


def invert(
    length: Callable[[Array], Array],
    speed: Callable[[Array], Array],
    s: Array,
    table: tuple[Array, Array],
) -> Array:
    """Parameters t with length(t) = s, shape of s: interpolation in a table, then Newton's method.

    `length` grows with t, and `speed` is its derivative; the `table` has values of t and their lengths.
    Raises Failure where Newton's method does not converge.
    """
    known, lengths = table
    tolerance = LENGTH_ROUNDING * float(lengths[-1] - lengths[0])
    t = np.interp(s, lengths, known)
    for _ in range(NEWTON_STEPS):
        defect = length(t) - s
        if np.max(np.abs(defect), initial=0.0) <= tolerance:
            return t
        t = t - defect / speed(t)
    raise Failure(f"arc length s = {s} mm: not found within {lengths[0]:g} ... {lengths[-1]:g} mm")


def inverse_polynomials(
    length: Callable[[Array], Array], parameter: Callable[[Array], Array], knots: Array
) -> PPoly | None:
    """Return piecewise polynomials that invert a length which grows smoothly between knots (n,).

    `parameter` inverts it more slowly. They have the small difference between the parameter and a linear
    function of the length, on parts of the intervals that are halved until all is exact to rounding; None
    where it does not become so.
    """
    for parts in INVERSE_PARTS:
        fractions = np.arange(parts) / parts
        starts = (knots[:-1, None] + np.diff(knots)[:, None] * fractions).ravel()
        inverse = _inverse_polynomials(length, parameter, np.append(starts, knots[-1]))
        between = (inverse.x[:-1] + np.diff(inverse.x) * INVERSE_TESTED[:, None]).ravel()
        defect = np.max(np.abs(length(inverse(between)) - between))
        if defect <= INVERSE_ROUNDING * (inverse.x[-1] - inverse.x[0]):
            return inverse
    return None


def _inverse_polynomials(
    length: Callable[[Array], Array], parameter: Callable[[Array], Array], knots: Array
) -> PPoly:
    """Return a polynomial of the parameter by the length between each two of some parameters (n,)."""
    lengths = length(knots)
    unit = (1 - np.cos(np.pi * np.arange(INVERSE_DEGREE + 1) / INVERSE_DEGREE)) / 2
    steps = np.diff(lengths)
    linear = knots[:-1] + unit[:, None] * np.diff(knots)
    found = parameter(lengths[:-1] + unit[:, None] * steps)
    powers = np.linalg.solve(np.vander(unit), found - linear)  # the highest first
    powers[-1] += knots[:-1]
    powers[-2] += np.diff(knots)
    return PPoly(powers / steps ** np.arange(INVERSE_DEGREE, -1, -1)[:, None], lengths)


@dataclass(frozen=True, eq=False)
class Contour:
    """A core curve on `limits`, continued by its tangents; loads and lines stay within `extent`.

    `jumps` are the arc lengths between the limits at which the curvature jumps.
    """

    core: Core
    limits: tuple[float, float]
    extent: tuple[float, float] = (-np.inf, np.inf)
    jumps: tuple[float, ...] = ()

    def position(self, s: ArrayLike) -> Array:
        """Points (y, z) [mm] at arc length s, shape (2, *s.shape)."""
        s = np.asarray(s, dtype=float)
        inner = np.clip(s, *self.limits)
        points, beyond = self.core.position(inner), s - inner
        return points + beyond * self.tangent(inner) if np.any(beyond) else points

    def inclination(self, s: ArrayLike) -> Array:
        """Inclination delta [rad] at arc length s, shape of s."""
        return self.core.inclination(np.clip(np.asarray(s, dtype=float), *self.limits))

    def curvature(self, s: ArrayLike) -> Array:
        """Derivative of the inclination by the arc length [1/mm], 0 on the flanks; shape of s."""
        s = np.asarray(s, dtype=float)
        inner = np.clip(s, *self.limits)
        return np.where(s == inner, self.core.curvature(inner), 0.0)

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangent (cos delta, -sin delta) in (y, z), shape (2, *s.shape)."""
        delta = self.inclination(s)
        return np.stack([np.cos(delta), -np.sin(delta)])

    def normal(self, s: ArrayLike) -> Array:
        """Unit normal (sin delta, cos delta) in (y, z), shape (2, *s.shape); into the upper body."""
        delta = self.inclination(s)
        return np.stack([np.sin(delta), np.cos(delta)])

    @property
    def joints(self) -> tuple[float, ...]:
        """Arc lengths at which the curvature jumps, also where the flanks begin. None on a plane."""
        left, right = self.limits
        return (left, *self.jumps, right) if left < right else ()

    @property
    def symmetric(self) -> bool:
        """Whether the contour is its own mirror image in y -> -y."""
        s = np.linspace(0, max(np.abs(self.limits)), 101)[1:]
        right, left = self.position(s), self.position(-s)
        mirrored = np.stack([-left[0], left[1]])
        pairs = np.array([self.extent, self.limits])
        ends_agree = np.allclose(-pairs[:, 0], pairs[:, 1], rtol=1e-9)
        return bool(ends_agree and np.allclose(right, mirrored, rtol=0, atol=1e-9 * s[-1]))

    def nearest(self, points: Array, s_range: tuple[float, float]) -> Array:
        """Arc lengths [mm] of the contour points nearest to `points` (2, n), shape (n,).

        From the nearest of many samples on by Newton's method, which stays between its neighbours: a point's
        distance may be larger than the radius of curvature.
        """
        samples, spacing = np.linspace(*s_range, NEAREST_SAMPLES, retstep=True)
        s = first = samples[scipy.spatial.cKDTree(self.position(samples).T).query(points.T)[1]]
        for _ in range(NEWTON_STEPS):
            apart, before = points - self.position(s), s
            along, off = (np.sum(apart * axis, axis=0) for axis in (self.tangent(s), self.normal(s)))
            stretch = np.maximum(1 + self.curvature(s) * off, LEAST_STRETCH)
            s = np.clip(s + along / stretch, first - spacing, first + spacing)
            if np.max(np.abs(s - before), initial=0.0) <= LENGTH_ROUNDING * np.ptp(s_range):
                break
        return s


def plane() -> Contour:
    """The straight line z = 0."""
    return Contour(Arc(np.inf), (0.0, 0.0))


def arc(radius: float, left: float, right: float) -> Contour:
    """Circular arc up to the flank inclinations `left`, `right` [rad, magnitudes], then tangents.

    A positive radius [mm] gives a crown (the contour falls on both sides), a negative one a groove.
    """
    _check_arc({"radius": abs(radius)}, left, right)
    return Contour(Arc(radius), (-left * abs(radius), right * abs(radius)))


def ellipse(b_el: float, d_el: float, left: float, right: float) -> Contour:
    """Elliptic arc, semi-axes lateral b_el, vertical d_el [mm], up to the flank inclinations [rad]."""
    _check_arc({"b_el": b_el, "d_el": d_el}, left, right)
    core = Ellipse(b_el, d_el)
    ends = np.arctan2(b_el * np.sin([-left, right]), d_el * np.cos([left, right]))
    s_left, s_right = core.arc_length(ends)
    return Contour(core, (float(s_left), float(s_right)))


def through_points(y: ArrayLike, z: ArrayLike, y_centre: float = 0.0) -> Contour:
    """Smooth curve through points (y, z) [mm] in order of growing y; s = 0 at y = y_centre.

    A cubic spline over the chord length. Loads and lines stay between the first and last point;
    the bodies continue beyond them along the end tangents.
    """
    points = np.column_stack([y, z]).astype(float)
    _check_points(points)
    chord = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    curve = scipy.interpolate.CubicSpline(chord, points)
    roots = scipy.interpolate.CubicSpline(chord, points[:, 0] - y_centre).roots(extrapolate=False)
    if len(roots) == 0:
        raise WrongInput(f"y_centre = {y_centre:g} mm: not between the first and last point")
    pieces = length_between(curve, chord[:-1], chord[1:])
    core = Spline(curve, float(roots[0]), np.concatenate([[0.0], np.cumsum(pieces)]))
    core_ends = core.arc_length(chord[[0, -1]])
    limits = (float(core_ends[0]), float(core_ends[1]))
    return Contour(core, limits, limits)


def _check_arc(lengths: Mapping[str, float], left: float, right: float) -> None:
    """Raise WrongInput for lengths and flank inclinations out of range."""
    for name, value in lengths.items():
        if not 0 < value < np.inf:
            raise WrongInput(f"{name} = {value!r}: must be a positive length [mm]")
    for name, flank in (("left", left), ("right", right)):
        if not 0 <= flank < np.pi / 2:
            raise WrongInput(f"{name} flank inclination = {flank!r}: must lie in 0 ... pi/2 [rad]")


def _check_points(points: Array) -> None:
    """Raise WrongInput for too few points, for infinite ones, and where y does not grow."""
    if len(points) < 4 or not np.all(np.isfinite(points)):
        raise WrongInput(f"{len(points)} points: at least 4 are needed, all of them finite numbers")
    not_growing = np.flatnonzero(np.diff(points[:, 0]) <= 0)
    if len(not_growing):
        k = int(not_growing[0]) + 1
        raise WrongInput(
            f"point {k + 1}: y = {points[k, 0]:g} after {points[k - 1, 0]:g}: y must increase; sort the "
            "points"
        )
