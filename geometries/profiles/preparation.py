"""Preparation of profiles: from points of a section to a smooth curve by arc length.

A curve goes through the points (tolerance 0: a cubic spline over the chord length, so y may fall), or near
them (a smoothing spline, see `geometries.profiles.smoothing`). What was done is recorded in `notes`. Both
commute with motions, mirror images and the direction in which the points run.

`first_crossing` finds out whether points cross or touch themselves.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array, Indices, Mask
from geometries.contours import Spline, length_between
from geometries.errors import WrongInput
from geometries.profiles.profile import Kind, Profile
from geometries.profiles.smoothing import (
    Smoothing,
    along_normal,
    by_cross_validation,
    chord_lengths,
    rms,
    smooth,
    with_rms,
)

# --- curves ---

CROSS_VALIDATION = "cross-validation"
LEAST_POINTS = 8
UM = 1e3  # per mm
ROUNDING_RMS = 1 / np.sqrt(12)  # rms error of rounding, as a share of the last decimal


@dataclass(frozen=True, eq=False)
class Prepared:
    """A profile as a smooth curve by arc length s [mm], 0 at the gauge side.

    `points` (2, n) [mm] are those of the profile without repeated ones, `places` (n,) the arc lengths [mm] of
    the feet of their normals, and `residual` (n,) their distances [mm] from the curve, positive on its upper
    side. `rounding` (n,) are the rms errors of their last decimals along the normal [mm], 0 where none are
    known.
    """

    kind: Kind
    name: str
    spline: Spline
    points: Array
    places: Array
    residual: Array
    rounding: Array
    smoothing: Smoothing
    notes: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Length of the curve [mm]."""
        return float(self.spline.to_knots[-1])

    @property
    def jumps(self) -> tuple[float, ...]:
        """Arc lengths [mm] at which the curvature jumps: none."""
        return ()

    def position(self, s: ArrayLike) -> Array:
        """Points (y, z) [mm] in the axes of the profile, shape (2, *s.shape)."""
        at = self.spline.parameter(self._within(s))
        return np.moveaxis(self.spline.curve(at), -1, 0)

    def inclination(self, s: ArrayLike) -> Array:
        """Inclination delta [rad], shape of s."""
        return self.spline.inclination(self._within(s))

    def curvature(self, s: ArrayLike) -> Array:
        """Derivative of the inclination by the arc length [1/mm], shape of s."""
        return self.spline.curvature(self._within(s))

    def _within(self, s: ArrayLike) -> Array:
        """Return arc lengths as an array; raise WrongInput for those beyond the ends."""
        at = np.asarray(s, dtype=float)
        beyond = (at < -1e-9) | (at > self.length + 1e-9)
        if np.any(beyond):
            raise WrongInput(
                f"s = {at[beyond][0]:g} mm: must lie in 0 ... {self.length:g} mm, on the profile"
            )
        return np.clip(at, 0, self.length)


def prepare(profile: Profile, tolerance: float | Literal["cross-validation"] = 0.0) -> Prepared:
    """Return a smooth curve through or near the points of a profile.

    With a `tolerance` [mm] the rms distance of the points from the curve, along its normal, is that: give the
    rms error of the points, which smooths somewhat more than is best. 0 gives a curve through all points.
    With "cross-validation" the smoothing has the least estimated error, if the errors of neighbouring points
    are independent. Raises WrongInput and, where no smooth curve is as near as the tolerance, Failure.
    """
    _check_tolerance(tolerance)
    points, new, notes = _distinct(profile)
    if tolerance == 0:
        spline, places, smoothing = _through(points)
    else:
        rule = by_cross_validation if tolerance == CROSS_VALIDATION else with_rms(float(tolerance))
        name = (
            CROSS_VALIDATION if tolerance == CROSS_VALIDATION else f"tolerance {UM * float(tolerance):g} µm"
        )
        curve, t, smoothing = smooth(points, rule, name)
        spline = _spline(curve)
        places = spline.arc_length(np.clip(t, curve.x[0], curve.x[-1]))
    residual = along_normal(spline.curve, spline.parameter(places), points)[1]
    steps = np.zeros_like(points) if profile.steps is None else profile.steps[:, new]
    delta = spline.inclination(places)
    rounding = np.hypot(*(steps * np.stack([np.sin(delta), np.cos(delta)]))) * ROUNDING_RMS
    notes = (*profile.notes, *notes, _describe(smoothing, residual))
    return Prepared(profile.kind, profile.name, spline, points, places, residual, rounding, smoothing, notes)


def sampled(prepared: Prepared, spacing: float) -> Profile:
    """Return points of a prepared curve at equal arc lengths, at most `spacing` [mm] apart, as a profile.

    Raises WrongInput.
    """
    if not 0 < spacing < np.inf:
        raise WrongInput(f"spacing = {spacing!r}: must be a positive length [mm]")
    s = equal_steps(prepared.length, spacing)
    note = f"{len(s)} points at equal arc lengths, {s[1]:.4g} mm apart."
    return Profile(prepared.kind, prepared.position(s), prepared.name, (*prepared.notes, note))


def equal_steps(length: float, spacing: float) -> Array:
    """Return arc lengths from 0 to `length` in equal steps of at most `spacing` [mm], (n,)."""
    return np.linspace(0, length, int(np.ceil(length / spacing * (1 - 1e-9))) + 1)


def _check_tolerance(tolerance: float | str) -> None:
    """Raise WrongInput unless it is a length or the name of the rule."""
    if tolerance == CROSS_VALIDATION:
        return
    if isinstance(tolerance, str) or not 0 <= tolerance < np.inf:
        raise WrongInput(
            f'tolerance = {tolerance!r}: must be a length [mm], 0 or more, or "{CROSS_VALIDATION}"'
        )


def _distinct(profile: Profile) -> tuple[Array, Mask, tuple[str, ...]]:
    """Return the points without those that repeat their predecessor, (2, n), which, and a note if any."""
    points = np.asarray(profile.points, dtype=float)
    if points.ndim != 2 or points.shape[0] != 2 or not np.all(np.isfinite(points)):
        raise WrongInput(f"points of shape {points.shape}: must be finite numbers (y, z), shape (2, n)")
    new = np.append(True, np.any(np.diff(points, axis=1) != 0, axis=0))
    if np.count_nonzero(new) < LEAST_POINTS:
        raise WrongInput(f"{np.count_nonzero(new)} points: at least {LEAST_POINTS} different ones are needed")
    repeated = int(np.count_nonzero(~new))
    notes = (f"{repeated} repeated points were left out.",) if repeated else ()
    return points[:, new], new, notes


def _through(points: Array) -> tuple[Spline, Array, Smoothing]:
    """Return the cubic spline through points (2, n), their arc lengths (n,), and that nothing is smoothed."""
    chord = chord_lengths(points)
    spline = _spline(scipy.interpolate.CubicSpline(chord, points.T))
    spacing = float(chord[-1] / len(chord))
    return spline, spline.to_knots, Smoothing("through all points", 0.0, 0.0, points.shape[1], spacing)


def _spline(curve: "scipy.interpolate.PPoly") -> Spline:
    """Return a curve by its arc length, 0 at its first end."""
    pieces = length_between(curve, curve.x[:-1], curve.x[1:])
    return Spline(curve, float(curve.x[0]), np.concatenate([[0.0], np.cumsum(pieces)]))


def _describe(smoothing: Smoothing, residual: Array) -> str:
    """Return a sentence about the smoothing."""
    if not smoothing.length:
        return (
            f"A cubic spline through all {len(residual)} points, so the errors of the points remain in "
            "the curve."
        )
    return (
        f"Smoothed by {smoothing.rule}: rms distance of {len(residual)} points from the curve "
        f"{UM * rms(residual):.3g} µm, largest {UM * np.max(np.abs(residual)):.3g} µm; waves shorter than "
        f"about {2 * np.pi * smoothing.length:.2g} mm are removed (smoothing length {smoothing.length:.3g} "
        "mm)."
    )


# --- crossings ---

PAIRS_PER_SEGMENT = 8  # of boxes that overlap on one level; a contour has about 3
PAIRS_LOOKED_AT = 20_000  # where there are more


class SelfIntersection(Exception):
    """More boxes overlap than can be looked at, and no crossing was found among the first of them."""


def first_crossing(points: Array) -> tuple[int, int] | None:
    """Numbers of two segments of a polyline (2, n) that meet without being neighbours, or None.

    Segment k joins the points k and k + 1. The polyline is in a binary tree of bounding boxes; pairs
    of boxes that overlap are halved until single segments are left. For a contour without crossings this
    takes O(n log n). Raises SelfIntersection where too many boxes overlap.
    """
    boxes = _tree(points)
    most = PAIRS_PER_SEGMENT * points.shape[1] + 1000
    complete = True
    a, b = np.array([0]), np.array([0])
    for level in boxes[1:]:
        a, b = _halve(a, b, level)
        if len(a) > most:
            complete = False
            a, b = a[:PAIRS_LOOKED_AT], b[:PAIRS_LOOKED_AT]
    apart = b - a > 1
    a, b = a[apart], b[apart]
    meeting = np.flatnonzero(_meet(points, a, b))
    if len(meeting):
        k = meeting[np.lexsort([b[meeting], a[meeting]])[0]]
        return int(a[k]), int(b[k])
    if not complete:
        raise SelfIntersection
    return None


def _tree(points: Array) -> list[Array]:
    """Boxes (least y, least z, largest y, largest z) of runs of segments, root first, each (4, m)."""
    low = np.minimum(points[:, :-1], points[:, 1:])
    high = np.maximum(points[:, :-1], points[:, 1:])
    levels = [np.concatenate([low, high])]
    while levels[-1].shape[1] > 1:
        boxes = levels[-1]
        if boxes.shape[1] % 2:
            boxes = np.concatenate([boxes, boxes[:, -1:]], axis=1)
            # a copy of the last box keeps the tree whole; _halve leaves it out
        low = np.minimum(boxes[:2, ::2], boxes[:2, 1::2])
        high = np.maximum(boxes[2:, ::2], boxes[2:, 1::2])
        levels.append(np.concatenate([low, high]))
    return levels[::-1]


def _halve(a: Indices, b: Indices, boxes: Array) -> tuple[Indices, Indices]:
    """Pairs a <= b of overlapping boxes of the next level, out of pairs of this one."""
    a, b = (
        np.concatenate([2 * a, 2 * a, 2 * a + 1, 2 * a + 1]),
        np.concatenate([2 * b, 2 * b + 1, 2 * b, 2 * b + 1]),
    )
    valid = (a <= b) & (b < boxes.shape[1])
    a, b = a[valid], b[valid]
    overlap = np.all((boxes[:2, a] <= boxes[2:, b]) & (boxes[:2, b] <= boxes[2:, a]), axis=0)
    return a[overlap], b[overlap]


def _meet(points: Array, a: Indices, b: Indices) -> Mask:
    """Whether segments a and b, whose boxes overlap, have a point in common, (m,)."""
    p, q, r, s = points[:, a], points[:, a + 1], points[:, b], points[:, b + 1]
    across = _side(p, q, r) * _side(p, q, s) <= 0
    return across & (_side(r, s, p) * _side(r, s, q) <= 0)


def _side(p: Array, q: Array, r: Array) -> Array:
    """Sign of the side of the line from p to q on which r lies, (m,)."""
    return np.sign((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))
