"""Curves of profiles in their places: what the search for touching points needs, and samples."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.profiles.placement import Curve


@dataclass(frozen=True, eq=False)
class Moved:
    """A curve turned by `angle` [rad, from y to z] about its origin, then moved by `offset` (y, z) [mm].

    t is the arc length [mm] of the curve, from the gauge side to the field side; beyond its ends they stand.
    """

    curve: Curve
    angle: float
    offset: tuple[float, float]

    @property
    def limits(self) -> tuple[float, float]:
        """First and last arc length [mm]."""
        return 0.0, self.curve.length

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

    def _within(self, t: ArrayLike) -> Array:
        """Arc lengths between the ends."""
        return np.clip(np.asarray(t, dtype=float), 0.0, self.curve.length)


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
