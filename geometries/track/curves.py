"""Curves of profiles in their places: for the search of touching points, as samples, and as functions z(y).

A search asks for one point after the other. Curves by arc length are slow at that (each point inverts an
integral), so their places carry `Quintics`: polynomials with the curve's own points, tangents and curvatures
at close arc lengths.

`Graph` is a part of a sampled curve that is a function z(y): of a rail seen from above, of a wheel seen from
below.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.profiles.placement import Curve
from geometries.profiles.preparation import Prepared

# --- places ---

PIECE = 0.05  # mm of arc length: the longest polynomial; an arc of the radius R is missed by 3e-13 mm^6 / R^5
LEAST_PIECE = 1e-3  # mm: shorter ones would carry the rounding of points into tangents
INSIDE = 1e-9  # mm from a joint, where a piece is evaluated: its own side counts


class Place(NamedTuple):
    """A point of a curve: y, z [mm], the unit tangent, and the curvature, positive on a crown [1/mm]."""

    y: float
    z: float
    t_y: float
    t_z: float
    curvature: float


@dataclass(frozen=True, eq=False)
class Quintics:
    """A curve by arc length as polynomials of fifth degree: its length, their starts [mm], and coefficients.

    The pieces end at the joints of outlines and the knots of splines, between which curves are smooth, so
    the error falls with the sixth power of their length (Hermite interpolation).
    """

    length: float
    starts: list[float]
    coefficients: list[list[float]]  # six of y, then six of z, by rising powers from the start of a piece

    def at(self, t: float) -> tuple[float, float, float, float, float, float]:
        """Position, first and second derivatives by the arc length: (y, z, y', z', y'', z'')."""
        t = 0.0 if t < 0.0 else min(t, self.length)
        k = max(bisect_right(self.starts, t) - 1, 0)
        u = t - self.starts[k]
        a0, a1, a2, a3, a4, a5, b0, b1, b2, b3, b4, b5 = self.coefficients[k]
        return (
            a0 + u * (a1 + u * (a2 + u * (a3 + u * (a4 + u * a5)))),
            b0 + u * (b1 + u * (b2 + u * (b3 + u * (b4 + u * b5)))),
            a1 + u * (2 * a2 + u * (3 * a3 + u * (4 * a4 + u * 5 * a5))),
            b1 + u * (2 * b2 + u * (3 * b3 + u * (4 * b4 + u * 5 * b5))),
            2 * a2 + u * (6 * a3 + u * (12 * a4 + u * 20 * a5)),
            2 * b2 + u * (6 * b3 + u * (12 * b4 + u * 20 * b5)),
        )


def quintics(curve: Curve) -> Quintics:
    """Return the polynomials of a curve."""
    joints = curve.spline.to_knots if isinstance(curve, Prepared) else np.array(curve.jumps)
    inner = joints[(joints > LEAST_PIECE) & (joints < curve.length - LEAST_PIECE)]
    smooth = [0.0]
    smooth += [float(joint) for joint in inner if joint - smooth[-1] >= LEAST_PIECE]
    ends = np.append(smooth, curve.length)
    counts = np.ceil(np.diff(ends) / PIECE).astype(int)
    steps = np.repeat(np.diff(ends) / counts, counts)
    within = np.concatenate([np.arange(count) for count in counts])
    first = np.repeat(ends[:-1], counts) + within * steps + INSIDE
    h = steps - 2 * INSIDE
    (p, d, a), (q, e, b) = (_derivatives(curve, t) for t in (first, first + h))  # (2, n) each
    d, e, a, b = d * h, e * h, a * h**2, b * h**2
    rise = q - p - d - a / 2  # what the powers 3 to 5 add to value, slope and bend at the end
    slope, bend = e - d - a, b - a
    third = 10 * rise - 4 * slope + bend / 2
    fourth = -15 * rise + 7 * slope - bend
    fifth = 6 * rise - 3 * slope + bend / 2
    powers = np.stack([p, d / h, a / 2 / h**2, third / h**3, fourth / h**4, fifth / h**5])  # (6, 2, n)
    by_piece = np.moveaxis(powers, 2, 0).swapaxes(1, 2).reshape(len(h), 12)
    return Quintics(float(curve.length), first.tolist(), by_piece.tolist())


def _derivatives(curve: Curve, t: Array) -> tuple[Array, Array, Array]:
    """Points, unit tangents and their derivatives by the arc length, (2, n) each."""
    delta, curvature = curve.inclination(t), curve.curvature(t)
    tangents = np.stack([np.cos(delta), -np.sin(delta)])
    return curve.position(t), tangents, curvature * np.stack([-np.sin(delta), -np.cos(delta)])


@dataclass(frozen=True, eq=False)
class Moved:
    """A curve turned by `angle` [rad, from y to z] about its origin, then moved by `offset` (y, z) [mm].

    t is the arc length [mm] of the curve, from the gauge side to the field side; beyond its ends they stand.
    """

    curve: Curve
    angle: float
    offset: tuple[float, float]
    pieces: Quintics = field(default=None, repr=False)  # type: ignore[assignment]  # those of the curve

    def __post_init__(self) -> None:
        if self.pieces is None:
            object.__setattr__(self, "pieces", quintics(self.curve))

    @property
    def limits(self) -> tuple[float, float]:
        """First and last arc length [mm]."""
        return 0.0, self.pieces.length

    def at(self, t: float) -> Place:
        """The point at one arc length, to rounding that of `position`, `tangent` and `curvature`."""
        y, z, dy, dz, ddy, ddz = self.pieces.at(t)
        speed = math.hypot(dy, dz)
        c, s = math.cos(self.angle), math.sin(self.angle)
        return Place(
            c * y - s * z + self.offset[0],
            s * y + c * z + self.offset[1],
            (c * dy - s * dz) / speed,
            (s * dy + c * dz) / speed,
            (dz * ddy - dy * ddz) / speed**3,
        )

    def position(self, t: ArrayLike) -> Array:
        """Points (y, z) [mm], shape (2, *t.shape)."""
        y, z = turned(self.curve.position(self._within(t)), self.angle)
        return np.array([y + self.offset[0], z + self.offset[1]])

    def tangent(self, t: ArrayLike) -> Array:
        """Unit tangents in (y, z), shape (2, *t.shape)."""
        delta = self.curve.inclination(self._within(t)) - self.angle
        return np.stack([np.cos(delta), -np.sin(delta)])

    def curvature(self, t: ArrayLike) -> Array:
        """Curvature [1/mm], positive on a crown, negative in a groove; shape of t."""
        return self.curve.curvature(self._within(t))

    def unmoved(self, place: Place) -> Array:
        """A point in the axes of the curve, shape (2,)."""
        return turned(np.array([place.y - self.offset[0], place.z - self.offset[1]]), -self.angle)

    def _within(self, t: ArrayLike) -> Array:
        """Arc lengths between the ends."""
        return np.clip(np.asarray(t, dtype=float), 0.0, self.pieces.length)


# --- samples ---


@dataclass(frozen=True, eq=False)
class Samples:
    """Arc lengths (n,), points and unit tangents (2, n) of a curve."""

    t: Array
    points: Array
    tangents: Array


def turned(vectors: Array, angle: float) -> Array:
    """Vectors (y, z), shape (2, ...), turned by `angle` [rad] from y to z."""
    y, z = vectors
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * y - s * z, s * y + c * z])


def sampled(curve: Moved, spacing: float) -> Samples:
    """Evenly spaced samples of a curve, `spacing` [mm] apart at most."""
    first, last = curve.limits
    t = np.linspace(first, last, int(np.ceil((last - first) / spacing)) + 1)
    return Samples(t, curve.position(t), curve.tangent(t))


# --- graphs ---

STEEPEST = np.radians(85)  # steeper parts are no part of a graph, and may be a flange back


@dataclass(frozen=True, eq=False)
class Graph:
    """A part of a curve that is a function z(y): arc lengths, y, z and slopes dz/dy, shape (n,) each."""

    t: Array
    y: Array
    z: Array
    slope: Array

    def heights(self, y: Array) -> Array:
        """Heights z at y within the graph, by cubic Hermite interpolation; shape of y."""
        k = np.clip(np.searchsorted(self.y, y) - 1, 0, len(self.y) - 2)
        step = self.y[k + 1] - self.y[k]
        u = (y - self.y[k]) / step
        rise = self.z[k + 1] - self.z[k]
        bend_0, bend_1 = self.slope[k] * step - rise, rise - self.slope[k + 1] * step
        return np.asarray(self.z[k] + u * rise + u * (1 - u) * ((1 - u) * bend_0 + u * bend_1))


def graphs(samples: Samples) -> list[Graph]:
    """The parts of a curve that rise to larger y and are less steep than 85 degrees."""
    y_rate = samples.tangents[0]
    usable = np.concatenate([[False], y_rate > np.cos(STEEPEST), [False]])
    starts, ends = (np.flatnonzero(np.diff(usable.astype(int)) == sign) for sign in (1, -1))
    return [
        Graph(
            samples.t[a:b],
            samples.points[0, a:b],
            samples.points[1, a:b],
            samples.tangents[1, a:b] / y_rate[a:b],
        )
        for a, b in zip(starts, ends, strict=True)
        if b - a > 2
    ]
