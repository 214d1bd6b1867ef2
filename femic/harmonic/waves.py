"""From wavenumbers back to x, and the half-space at one wavenumber.

A unit load, uniform over |x| <= a and over a strip of s, is the sum over wavenumbers k of line loads that
vary as cos(k x), of weight sin(k a) / (k a); displacements vary as cos(k x) or sin(k x). On a closed ring of
radius R only k = m / R, m = 0, 1, 2, ... exist. Beyond a largest k a body responds like its tangent
half-space, whose integrals are known in closed form: `tail`.

Responses are smooth in ln k, waves are not: the integrals follow Filon (1928). On each panel of
wavenumbers, in geometric progression, the response is a sum of Legendre polynomials, whose integrals with
cos(k x) and sin(k x) are spherical Bessel functions. So it takes as many wavenumbers far away as near.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc, eval_legendre, iti0k0, k0, k1, spherical_jn

from approx.halfspace import HalfSpace, nine
from femic.harmonic.wavenumbers import Axis
from geometries.arrays import Array
from geometries.patches import Patch
from geometries.quadrature import gauss

SINES = np.array([[False, True, True], [True, False, False], [True, False, False]])  # odd in x
POINTS = 16  # per panel
AT, WEIGHTS = gauss(POINTS)
DEGREES = np.arange(POINTS)
TO_LEGENDRE = WEIGHTS[:, None] * (2 * DEGREES + 1) * eval_legendre(DEGREES, AT[:, None])  # (point, degree)
RATIO = 1.5  # of the ends of panels
LOWEST = 1e-12  # first panel, times the largest wavenumber
GENTLE = 1.0  # phase over half a panel up to which sin(k a) / (k a) is as smooth as the response
CHUNK = 512  # places x at a time
GOING_OVER, STEEPNESS = 300, 4.0  # the order at which a sum goes over into an integral, and how fast
LAST_ORDER = 1200  # of such a sum: its weight is below 1e-14


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Wavenumbers k [1/mm] of the sum (1 / pi) integral dk up to k_max: single ones, then those of panels."""

    single: Array  # (n,)
    weights: Array  # of the single ones
    ends: Array  # of the panels, growing
    share: Array  # of the integrand, at the points of the panels, (panel, POINTS)
    k_max: float

    @property
    def points(self) -> Array:
        """Wavenumbers of the panels, (panel, POINTS)."""
        return _middle(self.ends) + _half(self.ends) * AT

    @property
    def k(self) -> Array:
        """All of them."""
        return np.append(self.single, self.points.ravel())

    def shares(self, a: float, x: Array) -> tuple[Array, Array]:
        """What responses at k add to displacements at x [mm] due to a unit total load over |x| <= a.

        Of even ones, of odd ones; (len(k), len(x)) each.
        """
        parts = [self._shares(a, x[start : start + CHUNK]) for start in range(0, len(x), CHUNK)]
        even, odd = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
        return even, odd

    def _shares(self, a: float, x: Array) -> tuple[Array, Array]:
        single = (self.weights * np.sinc(self.single * a / np.pi))[:, None] * np.exp(
            1j * np.outer(self.single, x)
        )
        gentle = int(np.sum(_half(self.ends) * a <= GENTLE))
        low, high = self.ends[: gentle + 1], self.ends[gentle:]
        k_low, k_high = np.split(self.points, [gentle])
        waves = np.concatenate(
            [
                np.sinc(k_low * a / np.pi)[..., None] * _filon(low, x),
                (_filon(high, x + a) - _filon(high, x - a)) / (2j * a * k_high[..., None]),
            ]
        )
        panels = (self.share[..., None] * waves / np.pi).reshape(-1, len(x))
        both = np.concatenate([single, panels])
        return both.real, both.imag


def _middle(ends: Array) -> Array:
    return (ends[1:, None] + ends[:-1, None]) / 2


def _half(ends: Array) -> Array:
    return np.diff(ends)[:, None] / 2


def _filon(ends: Array, x: Array) -> NDArray[np.complex128]:
    """Weights (panel, POINTS, len(x)) of the values of a smooth function in its integral with exp(i k x)."""
    phase = _half(ends) * x  # (panel, x)
    moments = 1j ** DEGREES[:, None, None] * spherical_jn(DEGREES[:, None, None], phase)
    waves = _half(ends) * np.exp(1j * _middle(ends) * x)
    return np.asarray(np.einsum("qn,npx->pqx", TO_LEGENDRE, moments) * waves[:, None])


def integral(k_max: float) -> Spectrum:
    """Of an infinite body: panels in geometric progression."""
    n = int(np.ceil(-np.log(LOWEST) / np.log(RATIO)))
    ends = np.append(0.0, k_max * np.geomspace(LOWEST, 1.0, n + 1))
    return Spectrum(np.empty(0), np.empty(0), ends, np.ones((len(ends) - 1, POINTS)), k_max)


def orders(k_max: float, radius: float) -> Spectrum:
    """Of a closed ring: k = m / R, the first and the last with half the weight."""
    k = np.arange(int(np.floor(k_max * radius)) + 1) / radius
    weights = np.full_like(k, 1 / (np.pi * radius))
    weights[[0, -1]] /= 2
    return Spectrum(k, weights, k[-1:], np.empty((0, POINTS)), k[-1])


def ring(k_max: float, radius: float) -> Spectrum:
    """Of a closed ring: the sum over its low orders goes over smoothly into the integral.

    The two differ by what comes round the ring, x + 2 pi R: of waves that are short compared with that
    and taken with smooth weights, nothing does.
    """
    if k_max * radius < LAST_ORDER:
        return orders(k_max, radius)
    low, high = orders(LAST_ORDER / radius, radius), integral(k_max)
    by_integral = 1 - _by_sum(high.points * radius)
    felt = int(np.argmax(np.any(by_integral != 0, axis=1)))
    weights = low.weights * _by_sum(low.single * radius)
    return Spectrum(low.single, weights, high.ends[felt:], by_integral[felt:], k_max)


def _by_sum(order: Array) -> Array:
    """The share of an order of a ring that is summed, not integrated."""
    return np.asarray(erfc(STEEPNESS * np.log(np.maximum(order, 1e-9) / GOING_OVER)) / 2)


def spectrum(k_max: float, radius: float) -> Spectrum:
    """The wavenumbers of a body of some rolling radius, up to k_max."""
    return integral(k_max) if np.isinf(radius) else ring(k_max, radius)


def synthesis(response: Array, direction: int, over: Spectrum, a: float, xi: Array) -> Array:
    """Displacements (3, n) at xi [mm] due to a unit total load, from its responses (3, len(k)) at one s."""
    even, odd = over.shares(a, xi)
    return np.where(SINES[:, direction, None], response @ odd, response @ even)


def synthesis_weights(axis: Axis, k: Array, over: Spectrum, a: float, xi: Array) -> tuple[Array, Array]:
    """Shares (len(k), n) of the responses at k in displacements at xi [mm]: of even ones, of odd ones."""
    even, odd = over.shares(a, xi)
    of_even, of_odd = axis.interpolation(k, over.k)
    return of_even.T @ even, of_odd.T @ odd


# --- the half-space --------------------------------------------------------------------------------


def half_space_response(half_space: HalfSpace, b: float, s: float, k: Array) -> Array:
    """The response of a half-space at distance s to a unit line load over |s'| <= b, (3, 3, len(k))."""
    upper, lower = _primitives(k, s + b), _primitives(k, s - b)
    return nine(half_space.constants, (upper - lower) / (2 * b))


def _primitives(k: Array, s: float) -> Array:
    """Integrals over s of the transforms of X^2/R^3, S^2/R^3, XS/R^3, X/R^2, S/R^2, shape (5, len(k))."""
    z = k * abs(s)
    if s == 0:
        zero = np.zeros_like(k)
        return np.stack([zero, zero, -2 / k, zero, zero])
    integral_k0, at_k0 = np.sign(s) * iti0k0(z)[1] / k, s * k0(z)
    decay = -np.expm1(-z) / k
    return np.stack(
        [2 * at_k0, 2 * (integral_k0 - at_k0), -2 * abs(s) * k1(z), np.sign(s) * np.pi * decay, np.pi * decay]
    )


def tail(half_space: HalfSpace, patch: Patch, k_max: float, x: Array, s: float) -> Array:
    """What wavenumbers beyond k_max add [mm/N], shape (3, 3, n): A without those below.

    x, s [mm]: observer minus patch centre.
    """
    over = integral(k_max)
    response = half_space_response(half_space, patch.b, s, over.k)
    even, odd = over.shares(patch.a, x)
    below = np.where(SINES[..., None], response @ odd, response @ even)
    return half_space.ics(patch, x, np.full_like(x, s)) / patch.area - below
