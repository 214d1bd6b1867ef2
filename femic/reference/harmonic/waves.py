"""Wavenumbers: which are solved, displacements along x from responses at them, and the half-space's response.

**Choice.** Responses are smooth in t = asinh(k / scale), which is like ln k beyond the scale; below it they
are even or odd in k. Between the solved wavenumbers they are interpolated by splines of fifth degree. An
interval is halved as long as the error of the spline in the middle of the interval changes the displacements
too much. On a closed ring only k = m / R exists, m = 0, 1, 2, ... The orders m = 0 and 1, which may move the
ring as a whole, are solved and not interpolated.

**Sum.** A unit load, uniform over |x| <= a and over a strip of s, is the sum over wavenumbers k of line loads
that vary as cos(k x), with weight sin(k a) / (k a); displacements vary as cos(k x) or sin(k x). On a closed
ring of radius R only k = m / R, m = 0, 1, 2, ... exist. Beyond a largest k a body responds like its tangent
half-space, whose integrals are known in closed form: `tail`. The transition is smooth (`taper`): at an abrupt
end the error of the mesh, which is largest there, would spread far along x.

Responses are smooth in ln k, while cos(k x) and sin(k x) oscillate far away: the integrals follow Filon
(1928). The panels of wavenumbers are in geometric progression. On each of them the response is a sum of
Legendre polynomials, whose integrals with cos(k x) and sin(k x) are spherical Bessel functions. So
displacements far away take no more wavenumbers than displacements nearby.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.special import erfc, eval_legendre, iti0k0, k0, k1, spherical_jn

from approx.halfspace import HalfSpace, ics_from_integrals
from femic.reference.job import NotConverged
from geometries.arrays import Array, Indices, Mask
from geometries.patches import Patch, X, mirror_signs
from geometries.quadrature import gauss

# --- the wavenumbers that are solved ---

SPLINE_DEGREE = 5
FIRST_SPACING = 1.2  # spacing in t of the first wavenumbers
FEWEST_ORDERS = 8  # number of orders m = 0, 1, ... of a ring that are always solved; 3 for a large ring
MOST_WAVENUMBERS = 1000  # largest number of wavenumbers
HALVING_GAIN = 64  # approximate factor by which the error of an interval falls when it is halved


@dataclass(frozen=True)
class Axis:
    """The wavenumbers 0 ... k_max [1/mm] of an infinitely long body, or k = m / radius of a ring [mm].

    `scale` [1/mm] is the scale in t = asinh(k / scale).
    """

    scale: float
    k_max: float
    radius: float = np.inf

    def first(self) -> Array:
        """Wavenumbers [1/mm] to begin with, in growing order and with both ends, shape (n,)."""
        t_end = np.arcsinh(self.k_max / self.scale)
        k = self.scale * np.sinh(
            np.linspace(0, t_end, max(int(np.ceil(t_end / FIRST_SPACING)), SPLINE_DEGREE) + 1)
        )
        if np.isinf(self.radius):
            return np.asarray(k)
        last_order = np.floor(self.k_max * self.radius)
        fewest_orders = 3 if self.radius * self.scale > 1 else FEWEST_ORDERS
        orders = np.append(np.round(k * self.radius), np.arange(fewest_orders))
        return np.unique(np.minimum(orders, last_order)) / self.radius

    def between(self, low: float, high: float) -> float | None:
        """The wavenumber [1/mm] in the middle of two, or None where the ring has no order between them."""
        k = float(self.scale * np.sinh(np.mean(np.arcsinh(np.array([low, high]) / self.scale))))
        if np.isinf(self.radius):
            return k
        first_order, last_order = round(low * self.radius) + 1, round(high * self.radius) - 1
        if first_order > last_order:
            return None
        return float(np.clip(round(k * self.radius), first_order, last_order)) / self.radius

    def interpolation(self, nodes: Array, targets: Array) -> tuple[Array, Array]:
        """Return matrices that interpolate functions of k: the first even functions, the second odd ones.

        Each has shape (len(targets), len(nodes)) and maps values at the wavenumbers `nodes` to values at the
        wavenumbers `targets` [1/mm].
        """
        if np.isinf(self.radius):
            mirrored_nodes, identity = np.append(-nodes[:0:-1], nodes), np.eye(len(nodes))
            even, odd = (
                self._spline(mirrored_nodes, np.vstack([parity * identity[:0:-1], identity]), targets)
                for parity in (+1, -1)
            )
            return even, odd
        rigid = nodes < 1.5 / self.radius
        matrix = np.zeros((len(targets), len(nodes)))
        for order in np.flatnonzero(rigid):
            matrix[np.round(targets * self.radius) == order, order] = 1.0
        elastic_targets = targets * self.radius > 1.5
        elastic_nodes = nodes[~rigid]
        matrix[np.ix_(elastic_targets, ~rigid)] = self._spline(
            elastic_nodes, np.eye(len(elastic_nodes)), targets[elastic_targets]
        )
        return matrix, matrix

    def _spline(self, nodes: Array, values: Array, targets: Array) -> Array:
        """Values at other wavenumbers by the spline in t through values at nodes."""
        spline = scipy.interpolate.make_interp_spline(np.arcsinh(nodes / self.scale), values, k=SPLINE_DEGREE)
        return np.asarray(spline(np.arcsinh(targets / self.scale)))


@dataclass(frozen=True, eq=False)
class Samples:
    """Responses (n, ...) at the solved wavenumbers k (n,) [1/mm].

    `last` (n,) marks the wavenumbers that were solved last in their interval.
    """

    axis: Axis
    k: Array
    responses: Array
    last: Mask

    @property
    def sparser(self) -> "Samples":
        """The samples without those that were solved last in their interval."""
        k = self.k[~self.last]
        return Samples(self.axis, k, self.responses[~self.last], np.zeros(len(k), dtype=bool))

    def changed(self, at_sparser: Array, odd: Mask) -> "Samples":
        """The samples changed to `at_sparser` (n_sparser, ...) at the wavenumbers of `sparser`.

        Between these the change is interpolated: where it is small, so is the error of that. `odd` marks the
        entries of a response that are odd in k.
        """
        sparser = self.sparser
        change = interpolated(self.axis, sparser.k, at_sparser - sparser.responses, odd, self.k)
        return replace(self, responses=self.responses + change)


def sample(
    axis: Axis,
    solve: Callable[[Sequence[float]], Sequence[Array]],
    odd: Mask,
    a: float,
    accuracy: Array | float,
) -> Samples:
    """Solve as many wavenumbers as the displacements need.

    `solve` returns the responses to unit loads at given wavenumbers. `odd` marks the entries of a response
    that are odd in k. `a` [mm] is the half-length of the loads. Intervals are halved until the error that
    each leaves in the displacements is below `accuracy` [mm/N], a number or an array; `odd` and `accuracy`
    broadcast with a response. Errors of neighbouring intervals alternate in sign. Raises NotConverged where
    more than `MOST_WAVENUMBERS` would be needed.
    """
    first_wavenumbers = axis.first().tolist()
    responses_at = dict(zip(first_wavenumbers, solve(first_wavenumbers), strict=True))
    open_intervals = list(pairwise(first_wavenumbers))
    all_middles: dict[float, tuple[float, float]] = {}
    while open_intervals:
        middles = {k: ends for ends in open_intervals if (k := axis.between(*ends)) is not None}
        if len(responses_at) + len(middles) > MOST_WAVENUMBERS:
            raise NotConverged(
                f"more than {MOST_WAVENUMBERS} wavenumbers are needed for displacements within "
                f"{np.min(accuracy):.1e} mm/N: give a larger `tolerance`, or shorter lines"
            )
        nodes = sorted(responses_at)
        known = np.stack([responses_at[k] for k in nodes])
        expected = interpolated(axis, np.array(nodes), known, odd, np.array(list(middles)))
        solved_at = dict(zip(middles, solve(list(middles)), strict=True))
        errors = {
            k: np.max(np.abs(solved_at[k] - interpolation) / accuracy)
            for k, interpolation in zip(solved_at, expected, strict=True)
        }
        responses_at |= solved_at
        all_middles |= middles
        open_intervals = []
        for middle, (low, high) in middles.items():
            reach = (high - low) / np.pi * min(1.0, 1 / (middle * a))
            if errors[middle] * reach / HALVING_GAIN > 1:
                open_intervals += [(low, middle), (middle, high)]
    wavenumbers, interval_ends = sorted(responses_at), {end for ends in all_middles.values() for end in ends}
    last = np.array([k in all_middles and k not in interval_ends for k in wavenumbers])
    return Samples(axis, np.array(wavenumbers), np.stack([responses_at[k] for k in wavenumbers]), last)


def interpolated(axis: Axis, nodes: Array, values: Array, odd: Mask, targets: Array) -> Array:
    """Values (len(targets), ...) at other wavenumbers, interpolated between those at `nodes` [1/mm]."""
    even_values, odd_values = (
        np.tensordot(matrix, values, axes=1) for matrix in axis.interpolation(nodes, targets)
    )
    return np.where(odd, odd_values, even_values)


# --- sums over wavenumbers ---

SINES = mirror_signs(X) < 0  # (i, j): components odd in x
PANEL_POINTS = 16  # Gauss points per panel
PANEL_NODES, PANEL_WEIGHTS = gauss(PANEL_POINTS)
DEGREES = np.arange(PANEL_POINTS)
# rows are points of a panel, columns are degrees
TO_LEGENDRE = PANEL_WEIGHTS[:, None] * (2 * DEGREES + 1) * eval_legendre(DEGREES, PANEL_NODES[:, None])
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
        n_gentle = int(np.sum(_half(self.ends) * max(half_lengths) <= GENTLE_PHASE))
        gentle_k, steep_k = np.split(self.points, [n_gentle])
        gentle_ends, steep_ends = self.ends[: n_gentle + 1], self.ends[n_gentle:]
        for start in range(0, len(x), POSITIONS_AT_ONCE):
            here = slice(start, start + POSITIONS_AT_ONCE)
            single = self.weights[:, None] * np.exp(1j * np.outer(self.single, x[here]))
            gentle, share = _filon(gentle_ends, x[here]), self.share[..., None] / np.pi
            for number, a in enumerate(half_lengths):
                steep = _filon(steep_ends, x[here] + a) - _filon(steep_ends, x[here] - a)
                steep = steep / (2j * a * steep_k[..., None])
                panels = share * np.concatenate([np.sinc(gentle_k * a / np.pi)[..., None] * gentle, steep])
                singles = np.sinc(self.single * a / np.pi)[:, None] * single
                shares = np.concatenate([singles, panels.reshape(-1, len(x[here]))])
                even[number, :, here], odd[number, :, here] = shares.real, shares.imag
        return list(zip(even, odd, strict=True))


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


def spectrum(k_max: float, radius: float) -> Spectrum:
    """The wavenumbers of a body of a rolling radius [mm] up to k_max [1/mm].

    On a closed ring they are its low orders, then panels of an integral. The sum over orders and the integral
    differ by the periodic images at x + 2 pi R. Waves that are short compared with the ring, with smooth
    weights, contribute nothing there.
    """
    if np.isinf(radius):
        return integral(k_max)
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


def tail(half_space: HalfSpace, patch: Patch, k_max: float, x: Array) -> Callable[..., Array]:
    """What short waves add to displacements under a unit load, at x (n,) [mm] from the centre of its patch.

    It is A less its tapered sum up to a largest wavenumber [1/mm]: the half-space's share. The result takes a
    distance along s [mm], and which of x to `choose`, to displacements [mm/N], (3, 3, n).
    """
    wavenumbers = integral(k_max)
    distances, number = np.unique(np.abs(x), return_inverse=True)
    shares = wavenumbers.shares(patch.a, distances)
    weights = shares[0][:, number], shares[1][:, number] * np.sign(x)  # of responses even and odd in x

    def at(s: float, choose: Indices | slice = slice(None)) -> Array:
        here, (even, odd) = x[choose], (part[:, choose] for part in weights)
        response = half_space_response(half_space, patch.b, s, wavenumbers.k)
        below = np.where(SINES[..., None], response @ odd, response @ even)
        return half_space.ics(patch, here, np.full_like(here, s)) / patch.area - below

    return at
