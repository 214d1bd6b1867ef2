"""Contours of contact from profiles as splines, exact pieces included: models are known by their numbers."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import scipy

from geometries.arrays import Array
from geometries.contours import Contour, Spline, length_between
from geometries.profiles.pieces import Outline, Piece
from geometries.profiles.placement import STEEPEST, contour_at
from geometries.profiles.preparation import Prepared

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

SPACING = 0.5  # mm: the error of an arc of 13 mm is 1e-12 mm, that of its curvature 1e-10 of it


def spline_contour(
    curve: Prepared | Outline, centre: float, *, turn: float = 0.0, steepest: float = STEEPEST
) -> Contour:
    """Return `contour_at` of a curve, whose core is a spline whatever the curve is made of.

    Raises WrongInput.
    """
    contour = contour_at(curve, centre, turn=turn, steepest=steepest)
    spline = curve.spline if isinstance(curve, Prepared) else spline_of(curve)
    core = Spline(turned(spline.curve, turn), float(spline.parameter(np.array(centre))), spline.to_knots)
    return Contour(core, contour.limits, contour.extent, contour.jumps)


def spline_of(outline: Outline) -> Spline:
    """Return exact pieces as polynomials of degree 5, by arc length from the start of the first.

    They have the points, tangents and curvatures of the pieces at knots at most `SPACING` apart; each joint
    is a knot, at which the curvature may jump.
    """
    ends = list(pairwise(outline.joints))
    parts = [_polynomials(piece, start) for piece, (start, _) in zip(outline.pieces, ends, strict=True)]
    knots = np.concatenate([[0.0], *(part.x[1:] for part in parts)])
    curve = scipy.interpolate.PPoly(np.concatenate([part.c for part in parts], axis=1), knots)
    pieces = length_between(curve, knots[:-1], knots[1:])
    return Spline(curve, 0.0, np.concatenate([[0.0], np.cumsum(pieces)]))


def turned(curve: "PPoly", angle: float) -> "PPoly":
    """Return polynomials (y, z), turned by an angle [rad] from y to z."""
    cos, sin = np.cos(angle), np.sin(angle)
    return scipy.interpolate.PPoly(curve.c @ np.array([[cos, sin], [-sin, cos]]), curve.x)


def _polynomials(piece: Piece, start: float) -> "PPoly":
    """Return the polynomials of a piece that begins at an arc length [mm]."""
    s = np.linspace(0, piece.length, int(np.ceil(piece.length / SPACING)) + 1)
    derivatives = np.stack([piece.position(s), *_derivatives(piece, s)])  # (3, 2, n)
    through = scipy.interpolate.BPoly.from_derivatives(s + start, np.moveaxis(derivatives, (0, 2), (1, 0)))
    return scipy.interpolate.PPoly.from_bernstein_basis(through)


def _derivatives(piece: Piece, s: Array) -> tuple[Array, Array]:
    """Return the unit tangent and its derivative by the arc length [1/mm], (2, n) each."""
    cos, sin = np.cos(piece.inclination(s)), np.sin(piece.inclination(s))
    return np.stack([cos, -sin]), piece.curvature(s) * np.stack([-sin, -cos])
