r"""Smoothing splines through points of a section, by arc length.

The curve c(t) of degree 5 has equal intervals and minimises, over all its coefficients,

    sum_i |p_i - c(t_i)|^2 + weight * integral |D^3 c + k^2 D c|^2 dt,  D = d/dt,

the integral as a sum over differences of the coefficients (P-splines: Eilers and Marx (1996), Statistical
Science 11, 89-121). With t the arc length and k the curvature, D^3 c + k^2 D c is the derivative of the
curvature, along the normal. So lines and arcs stay what they are, up to their ends; a penalty on second
derivatives would draw the curvature at the ends to 0. k is that of the curve before (see below).

With n points at the spacing h, weight * h = length^6: shorter waves than about 2 pi * `length` are smoothed
away. Independent errors of the points, rms sigma along the normal, leave errors of the curvature of rms
sigma sqrt(h / (18 length^5)) away from the ends, from (1/pi) int u^4 / (1 + u^6)^2 du = 1/18.

Parameters t are fitted, too, in turns: each point is moved along the curve to the foot of its normal, and t
is turned into the arc length. So only errors along the normal count.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.contours import length_between
from geometries.errors import Failure

if TYPE_CHECKING:
    from scipy.interpolate import PPoly
    from scipy.sparse import csr_array

DEGREE = 5
PENALISED = 3  # order of the derivative
ROUNDING = 1e-12  # of distances [mm] and of shares of 1
TURNS = 12  # at most
SETTLED = 1e-6  # of the largest curvature: changes that end the turns
DIFFERENCES = np.array([[-1.0, 3.0, -3.0, 1.0], [0.0, -1.0, 1.0, 0.0]])  # of coefficients: third and first
MOST_INTERVALS = 2000
PER_LENGTH = 4  # intervals per smoothing length, or up to twice as many: the curve has no shorter waves
LENGTH_RANGE = (0.3, 30.0)  # of smoothing lengths, in intervals: beyond, no effect or rounding
LARGEST_SHARE = 0.5  # of the curve's length that the smoothing length may be
LONGEST = 1.1  # largest length of a curve over that of the polygon of its points
TRIALS = 15  # smoothing lengths among which the best one is sought first
NOISE_SHARE = 1 / 18  # of sigma^2 h / length^5 in the mean square error of the curvature


@dataclass(frozen=True)
class Smoothing:
    """How points were smoothed: by which rule, how far they lie from the curve, what that does to curvature.

    `length` [mm] is the smoothing length, 0 for an interpolating spline; `rms` [mm] the root mean square
    distance of the points from the curve; `freedom` the effective number of parameters of the curve.
    """

    rule: str
    length: float
    rms: float
    freedom: float
    spacing: float  # mean spacing of the points [mm]

    def curvature_noise(self, sigma: float) -> float:
        """Return the rms error of the curvature [1/mm] under independent errors of rms sigma [mm]."""
        return float(sigma * np.sqrt(NOISE_SHARE * self.spacing / self.length**5)) if self.length else np.inf


Rule = Callable[["Fit"], float]
Curvature = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Fit:
    """Least squares at given parameters t, for any smoothing length."""

    points: Array  # (2, n) [mm]
    t: Array  # parameters of the points from 0 on [mm], (n,)
    knots: Array  # equally spaced, DEGREE more of them on both sides of the curve
    values: "csr_array"  # of the B-splines at t, (n, n_coefficients)
    penalty: "csr_array"  # (n_coefficients, n_coefficients)

    @classmethod
    def prepare(cls, points: Array, t: Array, intervals: int, bent: Curvature = np.zeros_like) -> "Fit":
        """Prepare the fit of a curve with so many equal intervals between the first and the last t.

        `bent` gives the curvature [1/mm] at arc lengths, roughly.
        """
        width = float(np.max(t)) / intervals
        knots = width * np.arange(-DEGREE, intervals + DEGREE + 1.0)
        inside = np.clip(t, 0, knots[-DEGREE - 1])
        values = scipy.interpolate.BSpline.design_matrix(inside, knots, DEGREE)
        size = intervals + DEGREE
        middles = width * np.arange(-0.5, size - PENALISED - 1)  # of the four coefficients of a difference
        angle = width * bent(middles)
        third, first = (
            scipy.sparse.diags_array(stencil, offsets=[0, 1, 2, 3], shape=(size - PENALISED, size))
            for stencil in DIFFERENCES
        )
        turning = scipy.sparse.diags_array((2 * np.sin(angle / 2)) ** 2)
        change = third + turning @ first  # of coefficients on an arc: 0, exactly
        penalty = change.T @ change / width ** (2 * PENALISED - 1)
        return cls(points, t, knots, scipy.sparse.csr_array(values), scipy.sparse.csr_array(penalty))

    @property
    def width(self) -> float:
        """Length of an interval [mm]."""
        return float(self.knots[1] - self.knots[0])

    @property
    def length(self) -> float:
        """Length of the curve in its parameter [mm]."""
        return float(self.knots[-DEGREE - 1])

    @property
    def spacing(self) -> float:
        """Mean spacing of the points [mm]."""
        return self.length / len(self.t)

    @property
    def lengths(self) -> tuple[float, float]:
        """Smallest and largest smoothing length [mm]."""
        low, high = (share * self.width for share in LENGTH_RANGE)
        return low, max(2 * low, min(high, LARGEST_SHARE * self.length))

    def curve(self, length: float) -> "PPoly":
        """Return the curve at a smoothing length [mm]."""
        middle = np.mean(self.points, axis=1)
        coefficients = self._solved(length, self.values.T @ (self.points.T - middle)) + middle
        spline = scipy.interpolate.BSpline(self.knots, coefficients, DEGREE)
        ends = self.knots[DEGREE:-DEGREE]
        taylor = [spline(ends[:-1], order) / factorial(order) for order in range(DEGREE, -1, -1)]
        return scipy.interpolate.PPoly(np.stack(taylor), ends)

    def distances(self, length: float) -> Array:
        """Distances [mm] of the points from the curve along its normal, (n,): positive on the upper side."""
        curve = self.curve(length)
        return along_normal(curve, self.t + to_feet(curve, self.t, self.points), self.points)[1]

    def freedom(self, length: float) -> float:
        """Effective number of parameters of the curve: the trace of the map from points to curve."""
        factor = scipy.linalg.cholesky_banded(self._matrix(length), lower=True)
        products = band_of_inverse(factor) * bands(self.values.T @ self.values)
        return float(np.sum(products[0]) + 2 * np.sum(products[1:]))

    def _solved(self, length: float, right_side: Array) -> Array:
        """Solve the normal equations at a smoothing length [mm], shape of the right side."""
        return np.asarray(scipy.linalg.solveh_banded(self._matrix(length), right_side, lower=True))

    def _matrix(self, length: float) -> Array:
        """Return the bands of the normal equations' matrix at a smoothing length [mm]."""
        return bands(self.values.T @ self.values + length**6 / self.spacing * self.penalty)


def bands(matrix: "csr_array") -> Array:
    """Return diagonal and lower diagonals of a banded symmetric matrix, (DEGREE + 1, n_coefficients)."""
    result = np.zeros((DEGREE + 1, matrix.shape[0]))
    for below in range(DEGREE + 1):
        result[below, : matrix.shape[0] - below] = matrix.diagonal(-below)
    return result


def band_of_inverse(factor: Array) -> Array:
    """Return the bands of the inverse of a matrix with a banded Cholesky factor, both (bandwidth + 1, n).

    From the last row up (Takahashi's equations; Hutchinson and de Hoog (1985), Numerische Mathematik 47,
    99-106).
    """
    ratios = factor[1:] / factor[0]
    band, width = np.zeros_like(factor), len(ratios)
    below = np.zeros((width, width))  # block of the inverse below and right of the diagonal entry
    for i in range(factor.shape[1] - 1, -1, -1):
        column = -below @ ratios[:, i]
        band[0, i] = 1 / factor[0, i] ** 2 - ratios[:, i] @ column
        band[1:, i] = column
        below[1:, 1:] = below[:-1, :-1].copy()
        below[0] = below[:, 0] = band[:-1, i]
    return band


def along_normal(curve: "PPoly", t: Array, points: Array) -> tuple[Array, Array]:
    """Return parts of points (2, n) minus c(t) along the curve and along its normal [mm], (n,) each."""
    (y, z), (dy, dz) = (np.moveaxis(curve(t, order), -1, 0) for order in (0, 1))
    speed = np.hypot(dy, dz)
    off_y, off_z = points[0] - y, points[1] - z
    return (off_y * dy + off_z * dz) / speed, (off_z * dy - off_y * dz) / speed


def with_rms(tolerance: float) -> Rule:
    """Return the rule that takes the smoothing length at which the rms distance is `tolerance` [mm].

    The largest length where all curves lie nearer than that. The rule raises Failure where none does.
    """

    def length(fit: Fit) -> float:
        def excess(log_length: float) -> float:
            return float(np.log((rms(fit.distances(float(np.exp(log_length)))) + ROUNDING) / tolerance))

        low, high = np.log(fit.lengths).tolist()
        if excess(high) <= 0:
            return float(np.exp(high))
        if excess(low) > 0:
            nearest = rms(fit.distances(float(np.exp(low))))
            raise Failure(
                f"tolerance = {tolerance:g} mm: the nearest smooth curve has an rms distance of "
                f"{nearest:.3g} mm from the points; give a larger one, or 0 for a curve through the points"
            )
        return float(np.exp(scipy.optimize.brentq(excess, low, high, xtol=1e-6)))

    return length


def by_cross_validation(fit: Fit) -> float:
    """Return the smoothing length [mm] with the least error of generalised cross-validation.

    That is (rms distance) / (1 - freedom / n) (Craven and Wahba (1979), Numerische Mathematik 31, 377-403);
    it presumes that the errors of neighbouring points are independent.
    """
    n = len(fit.t)

    def score(log_length: float) -> float:
        length = float(np.exp(log_length))
        left_over = max(1 - fit.freedom(length) / n, ROUNDING)
        return float(np.log((rms(fit.distances(length)) + ROUNDING) / left_over))

    low, high = np.log(fit.lengths).tolist()
    trials = np.linspace(low, high, TRIALS)
    best = int(np.argmin([score(trial) for trial in trials]))
    around = trials[max(best - 1, 0)], trials[min(best + 1, len(trials) - 1)]
    options = {"xatol": 0.01}
    return float(np.exp(scipy.optimize.minimize_scalar(score, bounds=around, options=options).x))


def smooth(points: Array, rule: Rule, name: str) -> tuple["PPoly", Array, Smoothing]:
    """Return a smoothed curve, the parameters (n,) of the points' feet on it, and how it was smoothed.

    `points` (2, n) [mm] are in order, no two neighbours equal. Raises Failure where the rule does.
    """
    t = chord_lengths(points)
    bent: Curvature = np.zeros_like
    finest = int(np.clip(round(t[-1] / np.median(np.diff(t))), DEGREE, MOST_INTERVALS))
    intervals = finest
    for _ in range(TURNS):
        fit = Fit.prepare(points, t, intervals, bent)
        length = rule(fit)
        curve = fit.curve(length)
        feet = t + to_feet(curve, t, points)
        lengths = arc_lengths(curve, np.concatenate([feet, curve.x]))
        t, at_knots = np.split(lengths - np.min(lengths[: len(t)]), [len(t)])
        curved = curvature(curve, curve.x)
        change, bent = curved - bent(at_knots), interpolated(at_knots, curved)
        if np.max(np.abs(change)) <= SETTLED * np.max(np.abs(curved)):
            break
        halvings = max(0, int(np.log2(finest * length / PER_LENGTH / fit.length)))
        intervals = max(finest // 2**halvings, DEGREE)
    _check_loops(lengths, points)
    how = Smoothing(name, length, rms(fit.distances(length)), fit.freedom(length), fit.spacing)
    return curve, feet, how


def _check_loops(lengths: Array, points: Array) -> None:
    """Raise Failure for arc lengths [mm] on a curve that is much longer than the polygon of its points."""
    curve, polygon = float(np.ptp(lengths)), float(chord_lengths(points)[-1])
    if curve > LONGEST * polygon:
        raise Failure(
            f"the smoothed curve is {curve:.4g} mm long, {polygon:.4g} mm from point to point, so it has "
            "loops; give a smaller tolerance, or remove the corners of the profile"
        )


def to_feet(curve: "PPoly", t: Array, points: Array) -> Array:
    """Return the steps of the parameters to the feet of the points' normals, (n,): one of Newton's."""
    along, off = along_normal(curve, t, points)
    stretch = 1 + off * curvature(curve, t)  # of distances along the parallel curve
    speed = np.linalg.norm(curve(t, 1), axis=-1)
    return np.asarray(along / (speed * np.maximum(stretch, 0.5)))


def curvature(curve: "PPoly", t: Array) -> Array:
    """Return the curvature [1/mm] at parameters, (n,), with the sign that contours have."""
    (dy, dz), (ddy, ddz) = (np.moveaxis(curve(t, order), -1, 0) for order in (1, 2))
    return np.asarray((dz * ddy - dy * ddz) / np.hypot(dy, dz) ** 3)


def interpolated(at: Array, values: Array) -> Curvature:
    """Return values between their places by linear interpolation."""
    return lambda s: np.interp(s, at, values)


def arc_lengths(curve: "PPoly", t: Array) -> Array:
    """Return arc lengths [mm] at parameters, 0 at the curve's start, (n,); straight beyond its ends."""
    x = curve.x
    to_knots = np.concatenate([[0.0], np.cumsum(length_between(curve, x[:-1], x[1:]))])
    inside = np.clip(t, x[0], x[-1])
    interval = np.clip(np.searchsorted(x, inside, side="right") - 1, 0, len(x) - 2)
    return np.asarray(to_knots[interval] + length_between(curve, x[interval], inside) + (t - inside))


def chord_lengths(points: Array) -> Array:
    """Return lengths [mm] of the polygon through points (2, n) up to each of them, (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=1)))])


def rms(values: ArrayLike) -> float:
    """Return the root mean square of values."""
    return float(np.sqrt(np.mean(np.square(values))))
