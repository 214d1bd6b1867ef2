"""Equivalent conicity: the cone that moves along the track with the wavelength of given profiles.

The motion of a free wheelset without slip, e r_0 y'' + dr(y) = 0 (e distance of the touching points, r_0
rolling radius, dr rolling-radius difference, ' along the track), has the first integral

    y'^2 = 2 / (e r_0) * S(y),   S(y) = integral of dr from y to y_max,

so its wavelength is 2 * integral of dy / y' from y_min to y_max. That of a cone (Klingel) is
2 pi sqrt(e r_0 / (2 tan gamma)). EN 15302, annex B: equal wavelengths give the conicity

    tan gamma_e = (pi / I)^2,   I = integral of dy / sqrt(S(y)) from y_min to y_max.

e and r_0 cancel. The amplitude is half of the distance of both ends, y_max - y_min = 2 A. A motion has S = 0
at both ends and S > 0 between. With its middle at m,

    S(y_min) = F(m) = integral of dr from m - A to m + A,

so motions are the zeros of F at which it grows. Where dr = 0 over a width (cylinders, flat treads) a
wheelset stays where it is: as long as 2 A is not larger than this width, S = 0 and the conicity is 0.
"""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.quadrature import on_panels

AT_END = 1e-9  # of the amplitude: shifts as near to an end as this are the end
POINTS = 12  # of Gauss's rule between two shifts
NO_DIFFERENCE = 1e-9  # mm: what touching points leave of a difference that is 0
HALVINGS = 20  # of the amplitude that is named where there is no motion
AREA_ROUNDING = 1e-12  # of the sum of |dr|: integrals of differences nearer to 0 are 0


@dataclass(frozen=True)
class Conicity:
    """Equivalent conicity tan(gamma_e) of a motion between two shifts about a centre [mm].

    The centre is the shift between the ends at which a wheelset stays, or the middle of such shifts.
    """

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
            raise WrongInput("shifts must increase, and differences be finite numbers")
        values = np.where(np.abs(self.values) <= NO_DIFFERENCE, 0.0, self.values)
        object.__setattr__(self, "values", values)

    def integral(self, y: ArrayLike) -> Array:
        """Integral [mm^2] of the differences from the first shift to y, shape of y."""
        y = np.asarray(y, dtype=float)
        sums = scipy.integrate.cumulative_trapezoid(self.values, self.shifts, initial=0.0)
        k = np.clip(np.searchsorted(self.shifts, y, side="right") - 1, 0, len(self.shifts) - 2)
        along = y - self.shifts[k]
        slope = np.diff(self.values)[k] / np.diff(self.shifts)[k]
        return np.asarray(sums[k] + along * (self.values[k] + slope * along / 2))

    def crossings(self) -> Array:
        """Shifts between the given ones at which the difference is 0 and changes its sign, (m,)."""
        first, second = self.values[:-1], self.values[1:]
        k = np.flatnonzero(first * second < 0)
        return np.asarray(self.shifts[k] - first[k] * np.diff(self.shifts)[k] / (second[k] - first[k]))

    def centres(self) -> list[tuple[float, float]]:
        """Ranges of shifts at which a wheelset stays and to which it returns; their ends may be equal.

        Left of one the difference is negative and right of it positive, or there are no shifts.
        """
        at = np.union1d(self.shifts, self.crossings())
        values = np.interp(at, self.shifts, self.values)
        values[np.isin(at, self.crossings())] = 0.0
        still = np.concatenate([[False], values == 0, [False]])
        starts, ends = (np.flatnonzero(np.diff(still.astype(int)) == sign) for sign in (1, -1))
        return [
            (float(at[a]), float(at[b - 1]))
            for a, b in zip(starts, ends, strict=True)
            if (a == 0 or values[a - 1] < 0) and (b == len(at) or values[b] > 0)
        ]


def equivalent_conicity(shifts: ArrayLike, differences: ArrayLike, amplitude: float) -> Conicity:
    """Equivalent conicity of rolling-radius differences (n,) [mm] over shifts (n,) [mm] at an amplitude [mm].

    The amplitude is half of the distance of the two ends of the motion; of several motions that is taken
    whose centre is nearest to 0. Differences are left minus right for shifts to the left. Between the shifts
    they are straight. Raises Failure where no motion of this amplitude lies within the shifts.
    """
    if not 0 < amplitude < np.inf:
        raise WrongInput(f"amplitude = {amplitude!r}: must be a positive length [mm]")
    curve = Differences(np.asarray(shifts, dtype=float), np.asarray(differences, dtype=float))
    motions = [*_at_rest(curve, amplitude), *_moving(curve, amplitude)]
    if not motions:
        raise Failure(_no_motion(curve, amplitude))
    return min(motions, key=lambda motion: abs(motion.centre))


def _at_rest(curve: Differences, amplitude: float) -> list[Conicity]:
    """Shifts 2 * amplitude apart between which there are no differences, as near to 0 as they can be."""
    wide = [(low, high) for low, high in curve.centres() if high - low >= 2 * amplitude * (1 - AT_END)]
    middles = [min(max(0.0, low + amplitude), high - amplitude) for low, high in wide]
    return [Conicity(0.0, amplitude, m, (m - amplitude, m + amplitude)) for m in middles]


def _moving(curve: Differences, amplitude: float) -> list[Conicity]:
    """The motions whose ends are 2 * amplitude apart."""
    found = []
    for middle in _middles(curve, amplitude):
        ends = middle - amplitude, middle + amplitude
        stays = [centre for centre in curve.centres() if ends[0] < centre[0] and centre[1] < ends[1]]
        if stays and _returns(curve, ends):
            lowest = min(stays, key=lambda centre: float(curve.integral(centre[0])))
            value = (np.pi / _time(curve, ends)) ** 2
            found.append(Conicity(value, amplitude, sum(lowest) / 2, ends))
    return found


def _middles(curve: Differences, amplitude: float) -> list[float]:
    """Shifts m at which F(m), the integral of the differences from m - A to m + A, grows through 0.

    Between the places at which an end passes a shift F is a parabola; its turning point divides it.
    """
    low, high = curve.shifts[0] + amplitude, curve.shifts[-1] - amplitude
    if low > high * (1 + np.sign(high) * AT_END) + AT_END * amplitude:
        return []
    high = max(low, high)
    m = np.concatenate([[low, high], curve.shifts - amplitude, curve.shifts + amplitude])
    m = np.unique(m[(m >= low) & (m <= high)])

    def at_ends(m: Array) -> tuple[Array, Array]:
        return m - amplitude, m + amplitude

    def area(m: ArrayLike) -> Array:
        first, last = at_ends(np.asarray(m, dtype=float))
        return curve.integral(last) - curve.integral(first)

    first, last = (np.interp(end, curve.shifts, curve.values) for end in at_ends(m))
    rate = last - first
    k = np.flatnonzero(rate[:-1] * rate[1:] < 0)
    turns = m[k] - rate[k] * np.diff(m)[k] / (rate[k + 1] - rate[k])
    m = np.union1d(m, turns)
    total = float(np.sum(np.abs(curve.values[1:] + curve.values[:-1]) * np.diff(curve.shifts))) / 2
    values = area(m)
    values[np.abs(values) <= AREA_ROUNDING * total] = 0.0
    zeros = m[values == 0].tolist()
    zeros += [
        float(scipy.optimize.brentq(area, m[k], m[k + 1], xtol=1e-13))
        for k in np.flatnonzero((values[:-1] < 0) & (values[1:] > 0))
    ]
    return zeros


def _returns(curve: Differences, ends: tuple[float, float]) -> bool:
    """Whether the wheelset moves between the ends: S > 0 between them, at all shifts and turning points."""
    inside = np.concatenate([curve.shifts, curve.crossings()])
    margin = AT_END * (ends[1] - ends[0])
    inside = inside[(inside > ends[0] + margin) & (inside < ends[1] - margin)]
    return bool(np.all(curve.integral(ends[1]) - curve.integral(inside) > 0))


def _no_motion(curve: Differences, amplitude: float) -> str:
    """Why there is no motion of an amplitude."""
    first, last = curve.shifts[0], curve.shifts[-1]
    if not curve.centres():
        return (
            f"equivalent conicity: the rolling-radius difference goes from {curve.values[0]:g} to "
            f"{curve.values[-1]:g} mm and does not increase through 0, so the wheelset does not return to "
            "the middle"
        )
    widest, beyond = 0.0, min(amplitude, float(last - first))
    for _ in range(HALVINGS):
        middle = (widest + beyond) / 2
        moves = _at_rest(curve, middle) or _moving(curve, middle)
        widest, beyond = (middle, beyond) if moves else (widest, middle)
    return (
        f"amplitude = {amplitude:g} mm: between the shifts from {first:g} to {last:g} mm, and where the "
        f"wheelset returns to the middle, the largest amplitude is {widest:.4g} mm"
    )


def _time(curve: Differences, ends: tuple[float, float]) -> float:
    """The integral I of 1 / sqrt(S) between the ends: with y = middle + amplitude * sin(angle)."""
    middle, amplitude = sum(ends) / 2, (ends[1] - ends[0]) / 2
    knots = (np.union1d(curve.shifts, curve.crossings()) - middle) / amplitude
    inner = np.arcsin(knots[np.abs(knots) < 1 - AT_END])
    angles = np.concatenate([[-np.pi / 2], inner, [np.pi / 2]])
    angle, weights = on_panels(angles[:-1], angles[1:], POINTS)
    left = curve.integral(ends[1]) - curve.integral(middle + amplitude * np.sin(angle))
    return float(np.sum(weights * amplitude * np.cos(angle) / np.sqrt(left)))
