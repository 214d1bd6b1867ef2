"""Smooth curves of sections: what the search for touching points needs, through points, moved, sampled."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.contours import length_between
from geometries.errors import WrongInput

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

FITS = 4  # times that a spline is fitted over its own arc lengths: these then change by rounding only


class Curve(Protocol):
    """A curve of class C2 by arc length t [mm], from the gauge side to the field side.

    `geometries.contours.Contour` is one; `PointCurve` another.
    """

    @property
    def limits(self) -> tuple[float, float]:
        """First and last arc length [mm] of the part that may be touched."""

    def position(self, t: ArrayLike) -> Array:
        """Points (y, z) [mm], shape (2, *t.shape)."""

    def tangent(self, t: ArrayLike) -> Array:
        """Unit tangents in (y, z), shape (2, *t.shape)."""

    def curvature(self, t: ArrayLike) -> Array:
        """Curvature [1/mm], positive on a crown, negative in a groove; shape of t."""


@dataclass(frozen=True, eq=False)
class PointCurve:
    """Cubic spline through points, over the arc lengths of the points along this spline.

    At the points t is the arc length; between them it differs by the fourth power of their distance.
    """

    spline: "CubicSpline"

    @property
    def limits(self) -> tuple[float, float]:
        """First and last arc length [mm]."""
        return float(self.spline.x[0]), float(self.spline.x[-1])

    def position(self, t: ArrayLike) -> Array:
        """Points (y, z) [mm], shape (2, *t.shape)."""
        return _rows(self.spline(t))

    def tangent(self, t: ArrayLike) -> Array:
        """Unit tangents in (y, z), shape (2, *t.shape)."""
        derivative = _rows(self.spline(t, 1))
        return np.asarray(derivative / np.hypot(*derivative))

    def curvature(self, t: ArrayLike) -> Array:
        """Curvature [1/mm], positive on a crown; shape of t."""
        (dy, dz), (ddy, ddz) = (_rows(self.spline(t, order)) for order in (1, 2))
        return np.asarray((dz * ddy - dy * ddz) / np.hypot(dy, dz) ** 3)


@dataclass(frozen=True, eq=False)
class Moved:
    """A curve turned by `angle` [rad, from y to z] about its origin, then moved by `offset` (y, z) [mm]."""

    curve: Curve
    angle: float
    offset: tuple[float, float]

    @property
    def limits(self) -> tuple[float, float]:
        """First and last arc length [mm]."""
        return self.curve.limits

    def position(self, t: ArrayLike) -> Array:
        """Points (y, z) [mm], shape (2, *t.shape)."""
        y, z = turned(self.curve.position(t), self.angle)
        return np.array([y + self.offset[0], z + self.offset[1]])

    def tangent(self, t: ArrayLike) -> Array:
        """Unit tangents in (y, z), shape (2, *t.shape)."""
        return turned(self.curve.tangent(t), self.angle)

    def curvature(self, t: ArrayLike) -> Array:
        """Curvature [1/mm], shape of t."""
        return self.curve.curvature(t)


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


def curve_through(points: Array, least_spacing: float = 0.0) -> PointCurve:
    """Cubic spline through points (2, n) [mm] in their order, which may turn back in y.

    Points nearer than `least_spacing` [mm] to the one before are left out: a rounding error e of points at
    the spacing h makes curvature errors of about 4 e / h^2.
    """
    points = _thinned(np.asarray(points, dtype=float), least_spacing)
    lengths = _from_first(np.hypot(*np.diff(points)))
    for _ in range(FITS):
        spline = scipy.interpolate.CubicSpline(lengths, points.T)
        lengths = _from_first(length_between(spline, lengths[:-1], lengths[1:]))
    return PointCurve(scipy.interpolate.CubicSpline(lengths, points.T))


def sampled(curve: Curve, spacing: float) -> Samples:
    """Evenly spaced samples of a curve, `spacing` [mm] apart at most."""
    first, last = curve.limits
    t = np.linspace(first, last, int(np.ceil((last - first) / spacing)) + 1)
    return Samples(t, curve.position(t), curve.tangent(t))


def _rows(values: Array) -> Array:
    """The last axis of values first."""
    return values.T if values.ndim <= 2 else np.moveaxis(values, -1, 0)  # .T takes a tenth of the time


def _from_first(lengths: Array) -> Array:
    """Sums of lengths of pieces, from 0 on."""
    return np.concatenate([[0.0], np.cumsum(lengths)])


def _thinned(points: Array, least_spacing: float) -> Array:
    """Points (2, n) without those nearer than `least_spacing` to the one before them; the last one stays."""
    if points.ndim != 2 or len(points) != 2 or not np.all(np.isfinite(points)):
        raise WrongInput(f"points of shape {points.shape}: must be (2, n) finite numbers, rows y and z [mm]")
    kept = [0]
    for k in range(1, points.shape[1]):
        if np.hypot(*(points[:, k] - points[:, kept[-1]])) >= least_spacing:
            kept.append(k)
    if kept[-1] != points.shape[1] - 1:
        kept[-1] = points.shape[1] - 1
    thin = points[:, kept]
    if len(kept) < 4:
        raise WrongInput(
            f"{points.shape[1]} points, {len(kept)} of them at least {least_spacing:g} mm apart: 4 are needed"
        )
    repeated = np.flatnonzero(np.hypot(*np.diff(thin)) == 0)
    if len(repeated):
        raise WrongInput(f"point {repeated[0] + 2}: the same as the one before; give a least_spacing > 0")
    return thin
