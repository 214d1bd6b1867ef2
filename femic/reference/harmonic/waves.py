"""Displacements along x from responses at wavenumbers, and the response of the half-space at a wavenumber.

A unit load, uniform over |x| <= a and over a strip of s, is the sum over wavenumbers k of line loads that
vary as cos(k x), with weight sin(k a) / (k a); displacements vary as cos(k x) or sin(k x). On a closed ring
of radius R only k = m / R, m = 0, 1, 2, ... exist. Beyond a largest k a body responds like its tangent
half-space, whose integrals are known in closed form: `Tail`. The transition is smooth (`taper`): at an abrupt
end the error of the mesh, which is largest there, would spread far along x.

Responses are smooth in ln k, while cos(k x) and sin(k x) oscillate far away: the integrals follow Filon
(1928). The panels of wavenumbers are in geometric progression. On each of them the response is a sum of
Legendre polynomials, whose integrals with cos(k x) and sin(k x) are spherical Bessel functions. So
displacements far away take no more wavenumbers than displacements nearby.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfc, eval_legendre, iti0k0, k0, k1, spherical_jn

from approx.halfspace import HalfSpace, ics_from_integrals
from femic.reference.harmonic.wavenumbers import Axis
from geometries.arrays import Array, Indices
from geometries.patches import Patch, X, mirror_signs
from geometries.quadrature import gauss

SINES = mirror_signs(X) < 0  # (i, j): components odd in x
PANEL_POINTS = 16  # Gauss points per panel
PANEL_NODES, PANEL_WEIGHTS = gauss(PANEL_POINTS)
DEGREES = np.arange(PANEL_POINTS)
TO_LEGENDRE = (
    PANEL_WEIGHTS[:, None] * (2 * DEGREES + 1) * eval_legendre(DEGREES, PANEL_NODES[:, None])
)  # (point, degree)
PANEL_RATIO = 1.5  # upper over lower end of a panel
TAPERED_PANELS = 2  # last panels, on which the half-space replaces the body
LOWEST_PANEL = 1e-12  # upper end of the first panel over the largest wavenumber
GENTLE_PHASE = 1.0  # phase over half a panel up to which sin(k a) / (k a) is as smooth as the response
POSITIONS_AT_ONCE = 512  # positions x that are worked on at a time
CROSSOVER_ORDER, CROSSOVER_STEEPNESS = 300, 4.0  # where and how fast a ring's sum becomes an integral
LAST_ORDER = 1200  # last order of such a sum, whose weight is below 1e-14


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Wavenumbers k [1/mm] and weights of the sum over k, (1 / pi) integral dk up to k_max.

    First come single wavenumbers, then panels of them.
    """

    single: Array  # single wavenumbers [1/mm], (n,)
    weights: Array  # weights of the single wavenumbers [1/mm], (n,)
    ends: Array  # ends of the panels [1/mm], growing, (n_panels + 1,)
    share: Array  # share of the integrand that counts at the points of the panels, (panel, PANEL_POINTS)
    k_max: float

    @property
    def points(self) -> Array:
        """Wavenumbers of the panels [1/mm], shape (panel, PANEL_POINTS)."""
        return _middle(self.ends) + _half(self.ends) * PANEL_NODES

    @property
    def k(self) -> Array:
        """All wavenumbers [1/mm], first the single ones, then the ones on panels, shape (n,)."""
        return np.append(self.single, self.points.ravel())

    def shares(self, a: float, x: Array) -> tuple[Array, Array]:
        """Weights of the responses at k in displacements at x [mm] due to a unit total load over |x| <= a.

        The first array is for responses with cos(k x), even in x, the second for responses with
        sin(k x), odd in x; each has shape (len(k), len(x)) and the unit 1/mm.
        """
        return self.shares_of_loads([a], x)[0]

    def shares_of_loads(self, half_lengths: Sequence[float], x: Array) -> list[tuple[Array, Array]]:
        """The `shares` for loads of several half-lengths a [mm]."""
        even, odd = np.empty((2, len(half_lengths), len(self.k), len(x)))
        for start in range(0, len(x), POSITIONS_AT_ONCE):
            positions = slice(start, start + POSITIONS_AT_ONCE)
            for load, shares in enumerate(self._shares(half_lengths, x[positions])):
                even[load, :, positions], odd[load, :, positions] = shares.real, shares.imag
        return list(zip(even, odd, strict=True))

    def _shares(self, half_lengths: Sequence[float], x: Array) -> Iterator[NDArray[np.complex128]]:
        """The weights even in x + i times the weights odd in x, at a few positions x, load by load."""
        n_gentle = int(np.sum(_half(self.ends) * max(half_lengths) <= GENTLE_PHASE))
        steep_ends = self.ends[n_gentle:]
        gentle_k, steep_k = np.split(self.points, [n_gentle])
        single = self.weights[:, None] * np.exp(1j * np.outer(self.single, x))
        gentle, share = _filon(self.ends[: n_gentle + 1], x), self.share[..., None] / np.pi
        for a in half_lengths:
            steep = (_filon(steep_ends, x + a) - _filon(steep_ends, x - a)) / (2j * a * steep_k[..., None])
            panels = share * np.concatenate([np.sinc(gentle_k * a / np.pi)[..., None] * gentle, steep])
            singles = np.sinc(self.single * a / np.pi)[:, None] * single
            yield np.concatenate([singles, panels.reshape(-1, len(x))])


def _middle(ends: Array) -> Array:
    """Middles of panels, shape (panel, 1)."""
    return (ends[1:, None] + ends[:-1, None]) / 2


def _half(ends: Array) -> Array:
    """Half-widths of panels, shape (panel, 1)."""
    return np.diff(ends)[:, None] / 2


def _filon(ends: Array, x: Array) -> NDArray[np.complex128]:
    """Weights of the values of a smooth function of k in its integral with exp(i k x) over each panel.

    Shape (panel, PANEL_POINTS, len(x)).
    """
    phase = _half(ends) * x  # (panel, x)
    moments = 1j ** DEGREES[:, None, None] * spherical_jn(DEGREES[:, None, None], phase)
    waves = _half(ends) * np.exp(1j * _middle(ends) * x)
    return np.asarray(np.einsum("qn,npx->pqx", TO_LEGENDRE, moments) * waves[:, None])


def integral(k_max: float) -> Spectrum:
    """The wavenumbers of an endless body up to k_max [1/mm]: panels in geometric progression."""
    n = int(np.ceil(-np.log(LOWEST_PANEL) / np.log(PANEL_RATIO)))
    ends = np.append(0.0, k_max * PANEL_RATIO ** np.arange(-n, 1.0))
    points = _middle(ends) + _half(ends) * PANEL_NODES
    return Spectrum(np.empty(0), np.empty(0), ends, taper(points / k_max), k_max)


def orders(k_max: float, radius: float, last: int | None = None) -> Spectrum:
    """Orders of a closed ring, k = m / R, up to k_max [1/mm] or a last one; m = 0 has half the weight."""
    k = np.arange((int(np.floor(k_max * radius)) if last is None else last) + 1) / radius
    weights = taper(k / k_max) / (np.pi * radius)
    weights[0] /= 2
    return Spectrum(k, weights, k[-1:], np.empty((0, PANEL_POINTS)), k_max)


def ring(k_max: float, radius: float) -> Spectrum:
    """The wavenumbers of a closed ring up to k_max [1/mm]: its low orders, then panels of an integral.

    The sum over orders and the integral differ by the periodic images at x + 2 pi R. Waves that are short
    compared with the ring, with smooth weights, contribute nothing there.
    """
    if k_max * radius < LAST_ORDER:
        return orders(k_max, radius)
    summed, integrated = orders(k_max, radius, LAST_ORDER), integral(k_max)
    weights = summed.weights * _by_sum(summed.single * radius)
    by_integral = integrated.share * (1 - _by_sum(integrated.points * radius))
    first_panel = int(np.argmax(np.any(by_integral != 0, axis=1)))
    return Spectrum(summed.single, weights, integrated.ends[first_panel:], by_integral[first_panel:], k_max)


def taper(k: Array) -> Array:
    """Share of the body's response at k, over the largest wavenumber, beside the half-space's; shape of k.

    It falls from 1 at the start of the tapered panels to 0 at their end, with two continuous derivatives:
    an abrupt end would spread a small difference between the two far along x.
    """
    start = PANEL_RATIO**-TAPERED_PANELS
    rest = np.clip((1 - k) / (1 - start), 0.0, 1.0)
    return np.asarray(rest**3 * (10 + rest * (6 * rest - 15)))


def _by_sum(order: Array) -> Array:
    """Share of the orders of a ring that is summed and not integrated, shape of `order`."""
    return np.asarray(erfc(CROSSOVER_STEEPNESS * np.log(np.maximum(order, 1e-9) / CROSSOVER_ORDER)) / 2)


def spectrum(k_max: float, radius: float) -> Spectrum:
    """The wavenumbers of a body of a rolling radius [mm] up to k_max [1/mm]."""
    return integral(k_max) if np.isinf(radius) else ring(k_max, radius)


def synthesis_weights(
    axis: Axis, k: Array, wavenumbers: Spectrum, shares: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Weights [1/mm] of the responses at the solved k in displacements, shape (len(k), n) each.

    The first weights are for responses even in x, the second for odd ones: the `shares` of the wavenumbers
    with the interpolation between the solved ones.
    """
    even, odd = shares
    even_interpolation, odd_interpolation = axis.interpolation(k, wavenumbers.k)
    return even_interpolation.T @ even, odd_interpolation.T @ odd


# --- the half-space ---


def half_space_response(half_space: HalfSpace, b: float, s: float, k: Array) -> Array:
    """Response [mm^2/N] of a half-space at distance s [mm] to a unit line load over |s'| <= b.

    Shape (3, 3, len(k)).
    """
    upper, lower = _primitives(k, s + b), _primitives(k, s - b)
    return ics_from_integrals(half_space.constants, (upper - lower) / (2 * b))


def _primitives(k: Array, s: float) -> Array:
    """Integrals over s of the transforms of X^2/R^3, S^2/R^3, XS/R^3, X/R^2, S/R^2, shape (5, len(k))."""
    z = k * abs(s)
    if s == 0:
        zero = np.zeros_like(k)
        return np.stack([zero, zero, -2 / k, zero, zero])
    integral_k0, s_k0 = np.sign(s) * iti0k0(z)[1] / k, s * k0(z)
    decay = -np.expm1(-z) / k
    return np.stack(
        [2 * s_k0, 2 * (integral_k0 - s_k0), -2 * abs(s) * k1(z), np.sign(s) * np.pi * decay, np.pi * decay]
    )


@dataclass(frozen=True, eq=False)
class Tail:
    """The half-space's share of displacements under a unit load at x (n,) [mm] from the centre of its patch.

    It is A less its tapered sum up to a largest wavenumber: what short waves add.
    """

    half_space: HalfSpace
    patch: Patch
    x: Array
    k: Array  # wavenumbers of the sum [1/mm]
    weights: tuple[Array, Array]  # of responses even and odd in x, (len(k), n) each [1/mm]

    @classmethod
    def prepare(cls, half_space: HalfSpace, patch: Patch, k_max: float, x: Array) -> "Tail":
        """Prepare the share beyond a largest wavenumber [1/mm]."""
        wavenumbers = integral(k_max)
        distances, number = np.unique(np.abs(x), return_inverse=True)
        even, odd = wavenumbers.shares(patch.a, distances)
        return cls(half_space, patch, x, wavenumbers.k, (even[:, number], odd[:, number] * np.sign(x)))

    def at(self, s: float, chosen: Indices | slice = slice(None)) -> Array:
        """Displacements [mm/N] at all x, or some of them, at a distance s [mm] along s, (3, 3, n)."""
        x, (even, odd) = self.x[chosen], (part[:, chosen] for part in self.weights)
        response = half_space_response(self.half_space, self.patch.b, s, self.k)
        below = np.where(SINES[..., None], response @ odd, response @ even)
        return self.half_space.ics(self.patch, x, np.full_like(x, s)) / self.patch.area - below
