"""Contours of contact from curves of profiles: s = 0 at a place on them, turned if wanted.

A contour has its own axes: the origin at the contact centre, y and z as in the profile or turned with it.
Inclinations are limited (85 degrees by the harmonic engine): where a curve is steeper, the contour ends, and
the body continues along its tangent there.

`spline_contour` makes splines of all curves, exact pieces included: models are known by their numbers.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

import numpy as np
import scipy

from geometries.arrays import Array
from geometries.contours import Contour, Core, Spline, length_between
from geometries.errors import WrongInput
from geometries.profiles.pieces import Outline, Piece
from geometries.profiles.preparation import Prepared

if TYPE_CHECKING:
    from scipy.interpolate import PPoly


# --- contours ---

STEEPEST = float(np.radians(85.0))  # [rad], of the harmonic engine
SAMPLES_PER_MM = 50  # of arc length, among which ends and crossings are sought


class Curve(Core, Protocol):
    """A curve of a profile by arc length from 0 to `length` [mm]; its curvature jumps at `jumps` [mm]."""

    @property
    def length(self) -> float:
        """Length [mm]."""

    @property
    def jumps(self) -> tuple[float, ...]:
        """Arc lengths [mm] at which the curvature jumps."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A curve seen from its point at arc length `centre` [mm], turned by `turn` [rad] from y to z."""

    curve: Curve
    centre: float
    turn: float = 0.0

    def position(self, s: Array) -> Array:
        """Points (y, z) [mm] relative to the contact centre, shape (2, *s.shape)."""
        cos, sin = np.cos(self.turn), np.sin(self.turn)
        points = self.curve.position(self._along(s))
        y, z = points[0] - self._origin[0], points[1] - self._origin[1]
        return np.stack([cos * y - sin * z, sin * y + cos * z])

    def inclination(self, s: Array) -> Array:
        """Inclination delta [rad], shape of s."""
        return self.curve.inclination(self._along(s)) - self.turn

    def curvature(self, s: Array) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        return self.curve.curvature(self._along(s))

    @cached_property
    def _origin(self) -> Array:
        """The contact centre (y, z) [mm] on the curve, (2,)."""
        return self.curve.position(np.array(self.centre))

    def _along(self, s: Array) -> Array:
        """Arc length [mm] on the curve, from its first end."""
        return np.clip(self.centre + s, 0, self.curve.length)


def contour_at(curve: Curve, centre: float, *, turn: float = 0.0, steepest: float = STEEPEST) -> Contour:
    """Return the contour whose s = 0 lies at arc length `centre` [mm] of a curve.

    It is turned by `turn` [rad]: the inclination at s = 0 is that of the curve minus `turn`; with the
    inclination itself the tangent at the contact centre becomes the y axis. A body of revolution must not be
    turned: its axis is parallel to y. The contour ends where it is steeper than `steepest` [rad] or the curve
    ends, and is continued by its tangents. Raises WrongInput.
    """
    if not 0 < centre < curve.length:
        raise WrongInput(
            f"centre = {centre:g} mm: must lie between 0 and the profile's length, {curve.length:g}"
        )
    placed = Placed(curve, centre, turn)
    here = float(placed.inclination(np.array(0.0)))
    if not abs(here) < steepest:
        raise WrongInput(
            f"centre = {centre:g} mm: the inclination there is {np.degrees(here):.1f} degrees, more than "
            f"{np.degrees(steepest):.1f}; turn the contour (turn)"
        )
    left, right = (_end(placed, side, steepest) for side in (-1, +1))
    jumps = tuple(jump - centre for jump in curve.jumps if left < jump - centre < right)
    return Contour(placed, (left, right), (left, right), jumps)


def arc_length_at(curve: Curve, y: float) -> float:
    """Return the arc length [mm] of the only point of a curve at the lateral position y [mm].

    Raises WrongInput where there is none, or where there are several (an undercut face).
    """
    s = _samples(0.0, curve.length)
    above = curve.position(s)[0] >= y
    crossings = np.flatnonzero(above[1:] != above[:-1])
    if len(crossings) != 1:
        found = ", ".join(f"{s[k]:.4g}" for k in crossings) or "none"
        raise WrongInput(
            f"y = {y:g} mm: the profile must have exactly one point there; arc lengths of its points: "
            f"{found} mm; give the arc length of the contact centre"
        )
    k = int(crossings[0])

    def excess(at: float) -> float:
        return float(curve.position(np.array(at))[0]) - y

    return float(scipy.optimize.brentq(excess, s[k], s[k + 1], xtol=1e-12))


def _end(placed: Placed, side: int, steepest: float) -> float:
    """Return the arc length [mm] at which the contour ends on a side, from the contact centre."""
    last = placed.curve.length - placed.centre if side > 0 else -placed.centre
    s = _samples(0.0, last)
    steep = np.flatnonzero(np.abs(placed.inclination(s)) > steepest)
    if not len(steep):
        return float(last)
    k = int(steep[0])

    def excess(at: float) -> float:
        return abs(float(placed.inclination(np.array(at)))) - steepest

    return float(scipy.optimize.brentq(excess, s[k - 1], s[k], xtol=1e-12))


def _samples(start: float, end: float) -> Array:
    """Return arc lengths from one to the other [mm], both included, (n,)."""
    return np.linspace(start, end, int(np.ceil(SAMPLES_PER_MM * abs(end - start))) + 2)


# --- contours as splines ---

SPACING = 0.5  # mm: the error of an arc of 13 mm is 1e-12 mm, that of its curvature 1e-10 of it


def spline_contour(
    curve: Prepared | Outline, centre: float, *, turn: float = 0.0, steepest: float = STEEPEST
) -> Contour:
    """Return `contour_at` of a curve, whose core is a spline whatever the curve is made of.

    Raises WrongInput.
    """
    contour = contour_at(curve, centre, turn=turn, steepest=steepest)
    spline = curve.spline if isinstance(curve, Prepared) else to_spline(curve)
    core = Spline(turned(spline.curve, turn), float(spline.parameter(np.array(centre))), spline.to_knots)
    return Contour(core, contour.limits, contour.extent, contour.jumps)


def to_spline(outline: Outline) -> Spline:
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
