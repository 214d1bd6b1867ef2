"""The last decimals of coordinates in a file: what their rounding does to curve and pressure of a contact.

Rounding to steps q leaves errors of rms sigma = q / sqrt(12). A cubic spline through points at the spacing h
makes of independent errors slopes of rms SLOPE sigma / h and curvatures of rms CURVATURE sigma / h^2, means
over its length; a smoothing spline of the smoothing length L slopes of rms sigma sqrt(h / (12 L^3)) and
curvatures of rms sigma sqrt(h / (18 L^5)), from (1/pi) int u^2 / (1 + u^6)^2 du = 1/12 and, with u^4, 1/18.

Undulations along s of the slope theta change the pressure by E*/2 theta (a half-plane under waves: K. L.
Johnson, Contact Mechanics, 13.2), and a patch of half width b under the relative curvature k has p_max =
E*/2 b k: both are E*/2 times a slope. So a contact feels errors of the slope as curvatures of theta / b, and
no more than the curvature at a point, where b is smaller than h. p_max is the largest of some 1 + 2 b / h
values that err independently, so it errs upwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
import scipy

from geometries.arrays import Array
from geometries.profiles.pieces import Outline
from geometries.profiles.smoothing import rms

if TYPE_CHECKING:
    from geometries.profiles.placement import Curve
    from geometries.profiles.preparation import Prepared


# --- steps of decimals ---

AROUND = 21  # coordinates among which the last decimal is sought
SHARE = 0.4  # of them that may have a finer one: nine of ten numbers do not end in 0
SAME_STEP = 1e-6  # of a step: rounding of the differences of decimal numbers


def steps_as_written(tokens: Sequence[str], values: Array) -> Array:
    """Steps of the last decimals of a column, in its unit, for each of its numbers, (n,).

    A number's own last decimal is that of its last digit; zeros at the end of its decimals are no digits,
    since many programs fill up with them. A few finer numbers among coarse ones change nothing, nor do zeros
    that a single number happens to end in; formats with a fixed number of digits are followed. Numbers that
    repeat their predecessor say nothing. A column that goes on by equal steps was not rounded but chosen: its
    step is 0.
    """
    places = np.array([last_place(token) for token in tokens], dtype=float)
    new = np.append(True, np.diff(values) != 0)
    around = scipy.ndimage.percentile_filter(places[new], 100 * SHARE, size=AROUND, mode="mirror")
    steps = 10.0 ** around[np.cumsum(new) - 1]
    return np.where(_regular(values), 0.0, steps)


def last_place(token: str) -> int:
    """Power of ten of the last digit of a number, zeros at the end of its decimals left out."""
    mantissa, _, exponent = token.lower().replace("d", "e").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2].rstrip("0"))


def _regular(values: Array) -> Array:
    """Whether all steps around each number of a column are equal and not 0, (n,)."""
    steps = np.diff(values)
    low, high = (
        each(steps, AROUND, mode="nearest")
        for each in (scipy.ndimage.minimum_filter1d, scipy.ndimage.maximum_filter1d)
    )
    equal = (low * high > 0) & (high - low <= SAME_STEP * np.abs(high))
    return np.append(equal, equal[-1:])


# --- what rounding does ---

ROUNDING = 1 / np.sqrt(12)  # rms error of rounding, as a share of the last decimal
SLOPE, CURVATURE = 1.573, 3.789  # of cubic splines: integrals over their response to white noise
SMOOTHED_SLOPE, SMOOTHED_CURVATURE = 1 / 12, 1 / 18
LOST = 1 / 3  # slope lost where the curvature jumps, over jump times L: (1/pi) int u^4 / (1 + u^6) du
STEPS = 4  # per smoothing length, at which jumps of the curvature are sought
HELD = 0.95  # share of contacts whose p_max errs by less than is stated
TREAD = (5.0, 300.0)  # mm: half width of a patch on a tread and radius of its relative curvature
ELEMENTS = 10  # across that half width
SAID = 0.05  # of p_max on a tread, from which on a tolerance is advised
REACHED = 0.9  # of the advised tolerance: nothing is left to advise
MORE = 3.0  # times the tolerance, where it smooths less than the points are apart


@dataclass(frozen=True)
class Noise:
    """Rms errors of slope [rad] and curvature [1/mm] of a part of a curve, independent `apart` [mm]."""

    slope: float
    curvature: float
    apart: float

    def over(self, half_width: float) -> float:
        """Rms error of the curvature [1/mm] that a patch of a half width [mm] feels."""
        return self.slope * self.curvature / np.hypot(self.slope, half_width * self.curvature or 1e-300)

    def peak(self, half_width: float) -> float:
        """Largest slope error [rad] on a patch of a half width [mm], in 95 of 100 cases at most."""
        values = 1 + 2 * half_width / self.apart
        quantile = float(scipy.stats.norm.ppf((1 + HELD ** (1 / values)) / 2))
        return quantile * half_width * self.over(half_width)


def curvature_noise(curve: "Curve", s: float, half_width: float, element: float = 0.0) -> float:
    """Return the rms error [1/mm] that rounding leaves in the curvature that a patch feels.

    The patch lies about the arc length s [mm]; `half_width` [mm] is along s, 0 for the curvature at a point.
    Elements wider than the points are apart see them at the spacing `element` [mm]. 0 for what was not read
    from decimal numbers.
    """
    return _noise(curve, s, half_width, element).over(half_width)


def peak_slope(curve: "Curve", s: float, half_width: float, element: float = 0.0) -> float:
    """Return the slope [rad] that rounding adds to the steepest one in a patch, in 95 of 100 cases at most.

    Times E*/2, 1/E* = (1 - nu^2)/E of both bodies, it is the error of p_max [MPa]. The arguments are those of
    `curvature_noise`, `half_width` positive. What smoothing takes away from the shape where the curvature
    changes within its length is part of it.
    """
    noise = _noise(curve, s, half_width, element)
    return float(np.hypot(noise.peak(half_width), _smoothing_loss(curve, s, half_width)))


def _noise(curve: "Curve", s: float, half_width: float, element: float) -> Noise:
    """Return the noise of a curve about an arc length."""
    if isinstance(curve, Outline):
        return Noise(0.0, 0.0, 1.0)
    prepared = cast("Prepared", curve)  # the other kind of curves
    near = _near(prepared, s, half_width)
    sigma, spacing = prepared.rounding[near], np.gradient(prepared.places)[near]
    length = prepared.smoothing.length
    if length:
        share = rms(sigma) * np.sqrt(np.mean(spacing) / length**3)
        slope, curvature = share * np.sqrt(SMOOTHED_SLOPE), share * np.sqrt(SMOOTHED_CURVATURE) / length
        return Noise(float(slope), float(curvature), np.pi * length)
    seen = np.maximum(spacing, element)
    return Noise(SLOPE * rms(sigma / seen), CURVATURE * rms(sigma / seen**2), float(np.median(seen)))


def _near(prepared: "Prepared", s: float, half_width: float) -> slice:
    """Return which points are on a patch, and its neighbours."""
    first, behind = np.searchsorted(prepared.places, [s - half_width, s + half_width])
    return slice(max(int(first) - 1, 0), int(behind) + 1)


def _smoothing_loss(curve: "Curve", s: float, half_width: float) -> float:
    """Return the slope [rad] that smoothing takes away at most where the curvature of a patch changes."""
    if isinstance(curve, Outline) or not (length := cast("Prepared", curve).smoothing.length):
        return 0.0
    ends = s - half_width - length, s + half_width + length
    at = np.arange(ends[0] - length, ends[1] + length, length / STEPS)
    curvature = curve.curvature(np.clip(at, 0, curve.length))
    near = curvature[3 * STEPS : -STEPS] - curvature[STEPS : -3 * STEPS]  # from s - L to s + L
    far = curvature[4 * STEPS :] - curvature[: -4 * STEPS]  # twice as far
    jumps = 2 * near - far  # where the curvature grows evenly, nothing is lost
    return float(LOST * length * np.max(np.abs(jumps)))


def advice(prepared: "Prepared") -> str:
    """Return what rounding does to a profile, and the tolerance to take; nothing where it hardly matters.

    It matters by what it does to p_max on a tread. A curve that has the tolerance, but a corner or a wrong
    point, is hardly smoothed elsewhere: it needs a larger one.
    """
    (half_width, radius), smoothing = TREAD, prepared.smoothing
    has_tolerance = smoothing.rms >= REACHED * rms(prepared.rounding)
    if has_tolerance and smoothing.length >= smoothing.spacing:
        return ""
    count = max(1, round(prepared.length / half_width))
    places = (np.arange(count) + 0.5) * prepared.length / count
    peaks = [_noise(prepared, s, half_width, half_width / ELEMENTS).peak(half_width) for s in places]
    worst = int(np.argmax(peaks))
    share = peaks[worst] / (half_width / radius)
    if share < SAID:
        return ""
    near = _near(prepared, places[worst], half_width)
    spacing = float(np.median(np.diff(prepared.places[near])))
    sigma, curvature = rms(prepared.rounding[near]), curvature_noise(prepared, places[worst], 0.0)
    tolerance = MORE * smoothing.rms if has_tolerance else sigma
    return (
        f"The points are written in steps of {_plain(sigma / ROUNDING)} mm, {spacing:.2g} mm apart (about "
        f"s = {places[worst]:.0f} mm): rounding makes a false curvature of about {curvature:.2g}/mm (radius "
        f"{1 / curvature:.2g} mm), and errors of p_max of up to {100 * share:.0f} % on a tread. Take a "
        f"tolerance of {_plain(tolerance)} mm."
    )


def _plain(length: float) -> str:
    """Return a length with one digit, without an exponent."""
    return np.format_float_positional(length, precision=1, fractional=False, trim="-")
