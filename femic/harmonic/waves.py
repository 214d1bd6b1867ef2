"""From wavenumbers back to x, and the half-space at one wavenumber.

A unit load, uniform over |x| <= a and over a strip of s, is the sum over wavenumbers k of line loads that
vary as cos(k x), of weight sin(k a) / (k a); displacements vary as cos(k x) or sin(k x). On a closed ring of
radius R only k = m / R, m = 0, 1, 2, ... exist. Beyond a largest k a body responds like its tangent
half-space, whose integrals are known in closed form: `tail`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc, iti0k0, k0, k1

from approx.halfspace import HalfSpace, nine
from femic.harmonic.wavenumbers import Axis
from geometries.patches import Patch

Array = NDArray[np.float64]

SINES = np.array([[False, True, True], [True, False, False], [True, False, False]])  # odd in x
GAUSS = 8  # points per panel
PANELS_PER_PERIOD = 1.5
RATIO = 1.5  # of successive panels, as long as they are shorter
LOWEST = 1e-12  # first panel, times the largest wavenumber
CHUNK = 4096  # wavenumbers of a sum at a time
GOING_OVER, STEEPNESS = 300, 4.0  # the order at which a sum goes over into an integral, and how fast
LAST_ORDER = 1200  # of such a sum: its weight is below 1e-14


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Wavenumbers k [1/mm] and weights of the sum (1 / pi) integral dk, up to k_max."""

    k: Array
    weights: Array
    k_max: float


def integral(k_max: float, x_max: float) -> Spectrum:
    """Of an infinite body: Gauss panels, in geometric progression up to a share of the period of cos(k x)."""
    longest = 2 * np.pi / (PANELS_PER_PERIOD * x_max)
    edges = [0.0, LOWEST * k_max]
    while edges[-1] < k_max:
        edges.append(min(RATIO * edges[-1], edges[-1] + longest, k_max))
    at, weights = np.polynomial.legendre.leggauss(GAUSS)
    low, half = np.array(edges[:-1])[:, None], np.diff(edges)[:, None] / 2
    return Spectrum((low + half * (1 + at)).ravel(), (half * weights).ravel() / np.pi, k_max)


def orders(k_max: float, radius: float) -> Spectrum:
    """Of a closed ring: k = m / R, the first and the last with half the weight."""
    k = np.arange(int(np.floor(k_max * radius)) + 1) / radius
    weights = np.full_like(k, 1 / (np.pi * radius))
    weights[[0, -1]] /= 2
    return Spectrum(k, weights, k[-1])


def ring(k_max: float, x_max: float, radius: float) -> Spectrum:
    """Of a closed ring: the sum over its low orders goes over smoothly into the integral.

    The two differ by what comes round the ring, x + 2 pi R: of waves that are short compared with that
    and taken with smooth weights, nothing does.
    """
    if k_max * radius < LAST_ORDER:
        return orders(k_max, radius)
    low, high = orders(LAST_ORDER / radius, radius), integral(k_max, x_max)
    k = np.append(low.k, high.k)
    by_sum = erfc(STEEPNESS * np.log(np.maximum(k * radius, 1e-9) / GOING_OVER)) / 2
    weights = np.append(low.weights, high.weights) * np.append(by_sum[: len(low.k)], 1 - by_sum[len(low.k) :])
    kept = weights != 0
    return Spectrum(k[kept], weights[kept], k_max)


def spectrum(k_max: float, x_max: float, radius: float) -> Spectrum:
    """The wavenumbers of a body of some rolling radius, up to k_max."""
    return integral(k_max, x_max) if np.isinf(radius) else ring(k_max, x_max, radius)


def synthesis(response: Array, direction: int, over: Spectrum, a: float, xi: Array) -> Array:
    """Displacements (3, n) at xi [mm] due to a unit total load, from its responses (3, len(k)) at one s."""
    weighted = response * (over.weights * np.sinc(over.k * a / np.pi))
    phase = np.outer(over.k, xi)
    return np.where(SINES[:, direction, None], weighted @ np.sin(phase), weighted @ np.cos(phase))


def synthesis_weights(axis: Axis, k: Array, over: Spectrum, a: float, xi: Array) -> tuple[Array, Array]:
    """Shares (len(k), n) of the responses at k in displacements at xi [mm]: of even ones, of odd ones."""
    even, odd = np.zeros((2, len(k), len(xi)))
    for start in range(0, len(over.k), CHUNK):
        part = slice(start, start + CHUNK)
        at = over.k[part]
        weights = (over.weights[part] * np.sinc(at * a / np.pi))[:, None]
        of_even, of_odd = axis.interpolation(k, at)
        phase = np.outer(at, xi)
        even += of_even.T @ (weights * np.cos(phase))
        odd += of_odd.T @ (weights * np.sin(phase))
    return even, odd


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
    over = integral(k_max, max(float(np.max(np.abs(x))), patch.a))
    response = half_space_response(half_space, patch.b, s, over.k)
    below = np.stack([synthesis(response[:, j], j, over, patch.a, x) for j in range(3)], axis=1)
    return half_space.ics(patch, x, np.full_like(x, s)) / patch.area - below
