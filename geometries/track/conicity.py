"""Equivalent conicity: the cone that moves along the track with the wavelength of given profiles.

The motion of a free wheelset without slip, e r_0 y'' + dr(y) = 0 (e distance of the touching points, r_0
rolling radius, dr rolling-radius difference, ' along the track), has the first integral

    y'^2 = 2 / (e r_0) * S(y),   S(y) = integral of dr from y to y_max,

so its wavelength is 2 * integral of dy / y' from y_min to y_max. That of a cone (Klingel) is
2 pi sqrt(e r_0 / (2 tan gamma)). EN 15302, annex B: equal wavelengths give the conicity

    tan gamma_e = (pi / I)^2,   I = integral of dy / sqrt(S(y)) from y_min to y_max.

e and r_0 cancel.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.quadrature import on_panels

AT_END = 1e-9  # of the amplitude: shifts as near to an end as this are the end
POINTS = 12  # of Gauss's rule between two shifts


@dataclass(frozen=True)
class Conicity:
    """Equivalent conicity tan(gamma_e) of a motion between two shifts about a centre [mm]."""

    value: float
    amplitude: float
    centre: float
    ends: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Differences:
    """Rolling-radius differences (n,) [mm] at growing shifts, straight between them."""

    shifts: Array
    values: Array

    def __post_init__(self) -> None:
        shapes = np.shape(self.shifts), np.shape(self.values)
        if len(shapes[0]) != 1 or shapes[0] != shapes[1] or shapes[0][0] < 2:
            raise WrongInput(f"shifts, differences of shapes {shapes}: must be equal, (n,), n at least 2")
        if not (np.all(np.isfinite(self.values)) and np.all(np.diff(self.shifts) > 0)):
            raise WrongInput("shifts must grow, and differences be finite numbers")

    def integral(self, y: ArrayLike) -> Array:
        """Integral [mm^2] of the differences from the first shift to y, shape of y."""
        y = np.asarray(y, dtype=float)
        sums = scipy.integrate.cumulative_trapezoid(self.values, self.shifts, initial=0.0)
        k = np.clip(np.searchsorted(self.shifts, y, side="right") - 1, 0, len(self.shifts) - 2)
        along = y - self.shifts[k]
        slope = np.diff(self.values)[k] / np.diff(self.shifts)[k]
        return np.asarray(sums[k] + along * (self.values[k] + slope * along / 2))

    def centre(self) -> float:
        """The shift nearest to 0 at which the difference grows through zero; Failure if there is none."""
        first, second = self.values[:-1], self.values[1:]
        k = np.flatnonzero((first <= 0) & (second > 0))
        if not len(k):
            raise Failure(
                f"equivalent conicity: the rolling-radius difference goes from {self.values[0]:g} to "
                f"{self.values[-1]:g} mm without growing through 0: no motion returns; take more shifts"
            )
        zeros = self.shifts[k] - first[k] * np.diff(self.shifts)[k] / (second[k] - first[k])
        return float(zeros[np.argmin(np.abs(zeros))])

    def reach(self, centre: float) -> tuple[float, float]:
        """Shifts between which the differences lead back to the centre."""
        left = np.flatnonzero((self.shifts < centre) & (self.values >= 0))
        right = np.flatnonzero((self.shifts > centre) & (self.values <= 0))
        return (
            float(self.shifts[left[-1] + 1] if len(left) else self.shifts[0]),
            float(self.shifts[right[0] - 1] if len(right) else self.shifts[-1]),
        )


def equivalent_conicity(shifts: ArrayLike, differences: ArrayLike, amplitude: float) -> Conicity:
    """Equivalent conicity of rolling-radius differences (n,) [mm] over shifts (n,) [mm] at an amplitude [mm].

    The amplitude is half of the distance of the two ends of the motion. Differences are left minus right
    for shifts to the left. Between the shifts they are straight.
    """
    if not 0 < amplitude < np.inf:
        raise WrongInput(f"amplitude = {amplitude!r}: must be a positive length [mm]")
    curve = Differences(np.asarray(shifts, dtype=float), np.asarray(differences, dtype=float))
    centre = curve.centre()
    ends = _ends(curve, centre, amplitude)
    return Conicity((np.pi / _time(curve, ends)) ** 2, amplitude, centre, ends)


def _ends(curve: Differences, centre: float, amplitude: float) -> tuple[float, float]:
    """The ends of a motion, 2 * amplitude apart, between which the differences sum up to 0."""
    least, largest = curve.reach(centre)
    at_centre, at_left, at_right = curve.integral([centre, least, largest])
    level = min(at_left, at_right) - at_centre  # what the motion may have at the centre

    def other_end(end: float) -> float:
        value = curve.integral(end)
        return _root(lambda y: float(curve.integral(y) - value), least, centre)

    farthest = _root(lambda y: float(curve.integral(y) - at_centre) - level, centre, largest)
    widest = (farthest - other_end(farthest)) / 2
    if amplitude > widest * (1 + 1e-12):
        raise Failure(
            f"amplitude = {amplitude:g} mm: the motion about {centre:g} mm is {widest:g} mm at most. The "
            f"shifts, or the differences that lead back, go from {least:g} to {largest:g} mm; take more"
        )
    end = _root(lambda y: y - other_end(y) - 2 * amplitude, centre, farthest)
    return other_end(end), end


def _time(curve: Differences, ends: tuple[float, float]) -> float:
    """The integral I of 1 / sqrt(S) between the ends: with y = middle + amplitude * sin(angle)."""
    middle, amplitude = sum(ends) / 2, (ends[1] - ends[0]) / 2
    knots = (curve.shifts - middle) / amplitude
    inner = np.arcsin(knots[np.abs(knots) < 1 - AT_END])
    angles = np.concatenate([[-np.pi / 2], inner, [np.pi / 2]])
    angle, weights = on_panels(angles[:-1], angles[1:], POINTS)
    left = curve.integral(ends[1]) - curve.integral(middle + amplitude * np.sin(angle))
    return float(np.sum(weights * amplitude * np.cos(angle) / np.sqrt(left)))


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """A root between two shifts; an end that misses it by rounding is one."""
    at_low, at_high = function(low), function(high)
    if at_low * at_high >= 0:
        return low if abs(at_low) < abs(at_high) else high
    return float(scipy.optimize.brentq(function, low, high, xtol=1e-13))
