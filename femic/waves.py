"""From wavenumbers back to x, and the half-space at one wavenumber.

A unit load, uniform over |x| <= a and over a strip of s, is the sum over wavenumbers k of line loads that
vary as cos(k x), of weight sin(k a) / (k a); displacements vary as cos(k x) or sin(k x). On a closed ring of
radius R only k = m / R, m = 0, 1, 2, ... exist. Beyond a largest k a body responds like its tangent
half-space, whose integrals are known in closed form: `Tail`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.special import iti0k0, k0, k1

from approx.halfspace import HalfSpace, nine
from geometries.patches import Patch

Array = NDArray[np.float64]

SINES = np.array([[False, True, True], [True, False, False], [True, False, False]])  # odd in x
GAUSS = 8  # points per panel
PANELS_PER_PERIOD = 1.5
RATIO = 1.5  # of successive panels, as long as they are shorter
LOWEST = 1e-12  # first panel, times the largest wavenumber
MOST_ORDERS = 400_000  # circumferential orders that are summed; beyond, the integral


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Wavenumbers k [1/mm] and weights of the sum (1 / pi) integral dk."""

    k: Array
    weights: Array


def integral(k_max: float, x_max: float) -> Spectrum:
    """Of an infinite body: Gauss panels, in geometric progression up to a share of the period of cos(k x)."""
    longest = 2 * np.pi / (PANELS_PER_PERIOD * x_max)
    edges = [0.0, LOWEST * k_max]
    while edges[-1] < k_max:
        edges.append(min(RATIO * edges[-1], edges[-1] + longest, k_max))
    at, weights = np.polynomial.legendre.leggauss(GAUSS)
    low, half = np.array(edges[:-1])[:, None], np.diff(edges)[:, None] / 2
    return Spectrum((low + half * (1 + at)).ravel(), (half * weights).ravel() / np.pi)


def orders(k_max: float, radius: float) -> Spectrum:
    """Of a closed ring: k = m / R, the first and the last with half the weight."""
    k = np.arange(int(np.floor(k_max * radius)) + 1) / radius
    weights = np.full_like(k, 1 / (np.pi * radius))
    weights[[0, -1]] /= 2
    return Spectrum(k, weights)


def spectrum(k_max: float, x_max: float, radius: float) -> Spectrum:
    """The sum over orders on a wheel, as long as it is affordable; else the integral."""
    if radius * k_max < MOST_ORDERS:
        return orders(k_max, radius)
    return integral(k_max, x_max)


def synthesis(response: Array, direction: int, over: Spectrum, a: float, xi: Array) -> Array:
    """Displacements (3, n) at xi [mm] due to a unit total load, from its responses (3, len(k)) at one s."""
    weighted = response * (over.weights * np.sinc(over.k * a / np.pi))
    phase = np.outer(over.k, xi)
    return np.where(SINES[:, direction, None], weighted @ np.sin(phase), weighted @ np.cos(phase))


def interpolated(k: Array, response: Array, direction: int, at: Array, scale: float) -> Array:
    """Responses (3, len(at)) to a load between solved wavenumbers, from (len(k), 3); k[0] = 0.

    A cubic spline over asinh(k / scale): like ln k beyond the scale, and smooth at k = 0, where
    even responses have no slope and odd ones no curvature.
    """
    t, at_t = np.arcsinh(k / scale), np.arcsinh(at / scale)
    out = np.empty((3, len(at)))
    for i, odd in enumerate(SINES[:, direction]):
        out[i] = CubicSpline(t, response[:, i], bc_type=((2 if odd else 1, 0.0), "not-a-knot"))(at_t)
    return out


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
