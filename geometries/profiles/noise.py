"""Noise of profiles: what rounding of the last decimals does to the curve and to the pressure of a contact.

Rounding to steps q leaves errors of rms sigma = q / sqrt(12). A cubic spline through points at the spacing h
makes of independent errors slopes of rms SLOPE sigma / h and curvatures of rms CURVATURE sigma / h^2, means
over its length; a smoothing spline of the smoothing length L slopes of rms sigma sqrt(h / (12 L^3)) and
curvatures of rms sigma sqrt(h / (18 L^5)), from (1/pi) int u^2 / (1 + u^6)^2 du = 1/12 and, with u^4, 1/18.

Undulations along s of the slope theta change the pressure by E*/2 theta (a half-plane under waves: K. L.
Johnson, Contact Mechanics, 13.2), and a patch of half width b under the relative curvature k has p_max =
E*/2 b k: both are E*/2 times a slope. So a contact feels errors of the slope as curvatures of theta / b, and
no more than the curvature at a point, where b is smaller than h. p_max is the largest of some 1 + 2 b / h
values that err independently, so it errs upwards.

`noise` says what looks like noise in a profile: last decimals that bend the curve, radii far below real ones.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from geometries.arrays import Array
from geometries.profiles.placement import Curve
from geometries.profiles.preparation import ROUNDING_RMS, Prepared, equal_steps
from geometries.profiles.smoothing import rms

# --- what rounding does ---

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


def curvature_noise(curve: Curve, s: float, half_width: float, element: float = 0.0) -> float:
    """Return the rms error [1/mm] that rounding leaves in the curvature that a patch feels.

    The patch lies about the arc length s [mm]; `half_width` [mm] is along s, 0 for the curvature at a point.
    Elements wider than the points are apart see them at the spacing `element` [mm]. 0 for what was not read
    from decimal numbers.
    """
    return _noise(curve, s, half_width, element).over(half_width)


def peak_slope(curve: Curve, s: float, half_width: float, element: float = 0.0) -> float:
    """Return the slope [rad] that rounding adds to the steepest one in a patch, in 95 of 100 cases at most.

    Times E*/2, 1/E* = (1 - nu^2)/E of both bodies, it is the error of p_max [MPa]. The arguments are those of
    `curvature_noise`, `half_width` positive. What smoothing takes away from the shape where the curvature
    changes within its length is part of it.
    """
    noise = _noise(curve, s, half_width, element)
    return float(np.hypot(noise.peak(half_width), _smoothing_loss(curve, s, half_width)))


def _noise(curve: Curve, s: float, half_width: float, element: float) -> Noise:
    """Return the noise of a curve about an arc length; none of curves that are not from points."""
    if not isinstance(curve, Prepared):
        return Noise(0.0, 0.0, 1.0)
    near = _near(curve, s, half_width)
    sigma, spacing = curve.rounding[near], np.gradient(curve.places)[near]
    length = curve.smoothing.length
    if length:
        share = rms(sigma) * np.sqrt(np.mean(spacing) / length**3)
        slope, curvature = share * np.sqrt(SMOOTHED_SLOPE), share * np.sqrt(SMOOTHED_CURVATURE) / length
        return Noise(float(slope), float(curvature), np.pi * length)
    seen = np.maximum(spacing, element)
    return Noise(SLOPE * rms(sigma / seen), CURVATURE * rms(sigma / seen**2), float(np.median(seen)))


def _near(prepared: Prepared, s: float, half_width: float) -> slice:
    """Return which points are on a patch, and its neighbours."""
    first, behind = np.searchsorted(prepared.places, [s - half_width, s + half_width])
    return slice(max(int(first) - 1, 0), int(behind) + 1)


def _smoothing_loss(curve: Curve, s: float, half_width: float) -> float:
    """Return the slope [rad] that smoothing takes away at most where the curvature of a patch changes."""
    if not isinstance(curve, Prepared) or not (length := curve.smoothing.length):
        return 0.0
    ends = s - half_width - length, s + half_width + length
    at = np.arange(ends[0] - length, ends[1] + length, length / STEPS)
    curvature = curve.curvature(np.clip(at, 0, curve.length))
    near = curvature[3 * STEPS : -STEPS] - curvature[STEPS : -3 * STEPS]  # from s - L to s + L
    far = curvature[4 * STEPS :] - curvature[: -4 * STEPS]  # twice as far
    jumps = 2 * near - far  # where the curvature grows evenly, nothing is lost
    return float(LOST * length * np.max(np.abs(jumps)))


def advice(prepared: Prepared) -> str:
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
        f"The points are written in steps of {_plain(sigma / ROUNDING_RMS)} mm, {spacing:.2g} mm apart "
        f"(about s = {places[worst]:.0f} mm). This rounding causes a false curvature of about "
        f"{curvature:.2g}/mm (radius {1 / curvature:.2g} mm) and errors of p_max of up to "
        f"{100 * share:.0f} % on a tread. Use a tolerance of {_plain(tolerance)} mm."
    )


def _plain(length: float) -> str:
    """Return a length with one digit, without an exponent."""
    return np.format_float_positional(length, precision=1, fractional=False, trim="-")


# --- figures and noise ---


@dataclass(frozen=True, eq=False)
class ProfileFigure:
    """All that a figure needs to show how a profile was understood; see `profile_figure`."""

    name: str
    points: Array  # (y, z) [mm] as given, (2, n)
    places: Array  # arc lengths [mm] of the points, (n,)
    residual: Array  # distances [mm] of the points from the curve, positive on its upper side, (n,)
    s: Array  # arc lengths [mm], (m,)
    curve: Array  # (y, z) [mm] at s, (2, m)
    inclination: Array  # [rad] at s, (m,)
    curvature: Array  # [1/mm] at s, (m,)
    curvature_noise: float  # rms error of the curvature [1/mm] if the residual is noise; inf: unknown
    rounding: str  # what the last decimals do to the curve, and a tolerance to take; or nothing
    notes: tuple[str, ...]  # sentences


def profile_figure(prepared: Prepared, spacing: float = 0.1) -> ProfileFigure:
    """Return raw points, smoothed curve, residual, inclination and curvature over the arc length.

    The curve is given at steps of at most `spacing` [mm].
    """
    s = equal_steps(prepared.length, spacing)
    noise = prepared.smoothing.curvature_noise(prepared.smoothing.rms)
    curve, inclination, curvature = prepared.position(s), prepared.inclination(s), prepared.curvature(s)
    measured = prepared.points, prepared.places, prepared.residual
    return ProfileFigure(
        prepared.name,
        *measured,
        s,
        curve,
        inclination,
        curvature,
        noise,
        advice(prepared),
        prepared.notes,
    )


LEAST_RADIUS = 2.0  # mm: the package has 11 mm and more, edges below railheads 2.6 mm; less looks like noise
USUAL = 0.01  # mm: a tolerance for measured points


def noise(figure: ProfileFigure) -> str:
    """Return what looks like noise in a profile, and a tolerance to take; nothing where nothing does.

    That is what the last decimals of its file do, or a radius far below those of profiles.
    """
    if figure.rounding:
        return figure.rounding
    at = int(np.argmax(np.abs(figure.curvature)))
    if LEAST_RADIUS * abs(figure.curvature[at]) <= 1:
        return ""
    rms = float(np.sqrt(np.mean(figure.residual**2)))
    remedy = f"a tolerance of {USUAL:g} mm" if rms < 0.9 * USUAL else "a larger tolerance"
    return (
        f"The least radius is {radius_text(figure, at)} mm (at s = {figure.s[at]:.1f} mm), below "
        f"{LEAST_RADIUS:g} mm: standard profiles have 12 mm or more, so this is probably noise or a burr. "
        f"Try {remedy}."
    )


def radius_text(figure: ProfileFigure, at: int) -> str:
    """Return the radius of curvature [mm] at a place of a figure."""
    return f"{1 / abs(figure.curvature[at]):.3g}"
