"""Points inside a body: below a point of the contact surface, by their depth along its normal."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import WrongInput


@dataclass(frozen=True, eq=False)
class InnerPoints:
    """Points below the contact surface; x, s, depth [mm] have one shape (...).

    x is the arc length along the rolling circle of the surface at the arc length s of the body's contour,
    `depth` the distance from there along the inward normal.
    """

    x: Array
    s: Array
    depth: Array

    def __post_init__(self) -> None:
        x, s, depth = np.broadcast_arrays(
            *(np.asarray(values, dtype=float) for values in (self.x, self.s, self.depth))
        )
        for name, values in (("x", x), ("s", s), ("depth", depth)):
            object.__setattr__(self, name, values)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the arrays."""
        return self.x.shape


def line_into_depth(x: float, s: float, depth: ArrayLike) -> InnerPoints:
    """Return the points below one point of the surface at some depths [mm], shape (n,)."""
    return InnerPoints(np.asarray(x), np.asarray(s), np.asarray(depth))


def section_points(s: ArrayLike, depth: ArrayLike, x: float = 0.0) -> InnerPoints:
    """Return points of the section at x, shape (len(s), len(depth))."""
    return InnerPoints(np.asarray(x), np.asarray(s)[:, None], np.asarray(depth)[None])


def lengthwise_points(x: ArrayLike, depth: ArrayLike, s: float = 0.0) -> InnerPoints:
    """Return points below the line along x at one arc length s, shape (len(x), len(depth))."""
    return InnerPoints(np.asarray(x)[:, None], np.asarray(s), np.asarray(depth)[None])


def points_at(body: Body, x: ArrayLike, y: ArrayLike, z: ArrayLike) -> InnerPoints:
    """Return points by global coordinates x, y, z [mm], which broadcast.

    Raises WrongInput for points that are not inside the body.
    """
    raise NotImplementedError


def require_inside(body: Body, points: InnerPoints) -> None:
    """Raise WrongInput, with the first such point, for points that are not inside the modelled body."""
    if np.any(points.depth < 0):
        raise WrongInput("depth < 0: above the surface")
