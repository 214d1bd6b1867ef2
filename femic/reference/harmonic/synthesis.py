"""Displacements along x from the responses of a section: at points, and at all lags of a grid.

On a grid they are computed strip by strip. On a prismatic body the weight of a response in the displacement
at a lag depends on the lag alone, on a body of revolution also on the radii of both rolling circles. This
dependence is smooth and the radii differ little: weights are computed for a few radii (Chebyshev points) and
interpolated between them.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import factorial

import numpy as np

from approx.halfspace import HalfSpace
from femic.cache.workers import one_blas_thread
from femic.reference.engine import Cost, Points, RawICs
from femic.reference.harmonic.request import COLUMNS_NEED
from femic.reference.harmonic.waves import SINES, Samples, spectrum, synthesis_weights, tail
from femic.reference.run_options import HIGHER
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Grid, Load, Patch, S, mirror_signs, places

# --- responses and their variations ---

WAVE_REACH = 60.0  # distance times the largest k beyond which the share of the half-space is negligible


@dataclass(frozen=True, eq=False)
class Responses:
    """Responses of a section to unit line loads on its strips at enough wavenumbers, and their cost.

    `samples.responses` [mm^2/N] has shape (k, 2 supports, load, 3, len(s)): amplitudes of sin(k x) or
    cos(k x) of the local components at arc lengths s [mm], first with the far arc at its radius, then with
    the nearer one. `coarser` are responses with coarser cells, at the wavenumbers of `samples.sparser` only.
    `drawn` are vertices (2, n) [mm] and triangles (3, m) of its mesh, for pictures.
    """

    body: Body
    loads: tuple[Load, ...]
    s: Array
    samples: Samples
    coarser: Array  # (sparser k, load, 3, len(s)) [mm^2/N]
    cost: Cost
    drawn: tuple[Array, Indices]

    def variations(self) -> Iterator[tuple[str, Samples, float]]:
        """All responses, then variations for estimates of the error: name, responses, largest k [1/mm] each.

        The name of all responses is "". "nearer" has the far arc at half its radius, "coarser" has larger
        cells, "sparser" lacks the last wavenumber of each interval, "lower" goes to half of the largest
        wavenumber.
        """
        samples, k_max = self.samples, self.samples.axis.k_max
        at_arc, nearer = (replace(samples, responses=samples.responses[:, arc]) for arc in range(2))
        yield "", at_arc, k_max
        yield "nearer", nearer, k_max
        yield "coarser", at_arc.changed(self.coarser, odd_in_k(self.loads)), k_max
        yield "sparser", at_arc.sparser, k_max
        yield "lower", at_arc, k_max / HIGHER


def odd_in_k(loads: Sequence[Load]) -> Mask:
    """Return which responses to loads are odd in k, as displacements are in x, shape (load, 3, 1)."""
    return np.stack([SINES[:, load.direction] for load in loads])[..., None]


# --- at points ---


def displacements(solved: Responses, loads: Sequence[Load], points: Points) -> RawICs:
    """Displacements [mm/N] at points on the surface under some of the solved loads, before the discount.

    The result has the displacements from the variations of the responses as `RawICs.perturbed`.
    """
    surface, radius = solved.body.surface, solved.body.rolling_radius
    half_space = HalfSpace(one_body(solved.body.material, solved.body.side))
    variations = list(solved.variations())
    u = {name: np.empty((len(loads), 3, len(points.x))) for name, _, _ in variations}
    observer = np.searchsorted(solved.s, points.s)
    with one_blas_thread():
        for patch in dict.fromkeys(load.patch for load in loads):
            xi = surface.chart_x(points.x, points.s, patch.s)
            distances, distance = np.unique(np.abs(xi), return_inverse=True)
            stretch = float(surface.chart_x(1.0, patch.s, patch.s))
            known: dict[float, tuple[tuple[Array, Array], Array]] = {}  # by the largest wavenumber
            for name, samples, k_max in variations:
                wavenumbers = spectrum(k_max, radius)
                if k_max not in known:
                    shares = wavenumbers.shares(patch.a * stretch, distances)
                    known[k_max] = shares, _tail(half_space, patch, k_max * stretch, points)
                shares, tail = known[k_max]
                even, odd = synthesis_weights(samples.axis, samples.k, wavenumbers, shares)
                weights = even[:, distance], odd[:, distance] * np.sign(xi)
                for row, load in enumerate(loads):
                    if load.patch != patch:
                        continue
                    responses = samples.responses[:, solved.loads.index(load)]
                    for i, is_odd in enumerate(SINES[:, load.direction]):
                        under_waves = np.einsum("kp,kp->p", responses[:, i, observer], weights[int(is_odd)])
                        u[name][row, i] = under_waves + tail[i, load.direction]
    return RawICs(u.pop(""), solved.cost, u, solved.drawn)


def _tail(half_space: HalfSpace, patch: Patch, k_max: float, points: Points) -> Array:
    """The half-space's share of displacements (3, 3, n_points); k_max [1/mm] is the largest k at the load."""
    u = np.zeros((3, 3, len(points.x)))
    near = np.flatnonzero(np.abs(points.s - patch.s) < patch.b + WAVE_REACH / k_max)
    if len(near):
        beyond = tail(half_space, patch, k_max, points.x[near])
        for s in np.unique(points.s[near]):
            on_strip = np.flatnonzero(points.s[near] == s)
            u[..., near[on_strip]] = beyond(s - patch.s, on_strip)
    return u


# --- at the lags of a grid ---

INTERPOLATION_DIGITS = 10  # to which the interpolation between radii is exact
ANALYTIC_RANGE = 0.4  # change of ln(radius) within which the weights are analytic at the nearest lag
S_MIRROR = mirror_signs(S)  # signs of the components (i, j) where s changes sign


def chebyshev_points(values: Array, n: int) -> Array:
    """The n Chebyshev points of the range of some values, shape (n,)."""
    middle, half_range = (np.max(values) + np.min(values)) / 2, np.ptp(values) / 2
    return np.asarray(middle + half_range * np.cos(np.pi * (np.arange(n) + 0.5) / n))


def lagrange_shares(points: Array, values: Array) -> Array:
    """Lagrange polynomials of points at some values, shape (len(points), len(values))."""
    gaps = values - points[:, None]
    shares = np.ones_like(gaps)
    for m, point in enumerate(points):
        others = np.arange(len(points)) != m
        shares[m] = np.prod(gaps[others] / (point - points[others])[:, None], axis=0)
    return shares


def node_heights(heights: Array) -> Array:
    """Enough Chebyshev points for some heights z / R_roll; one point if they are all alike."""
    half_range = float(np.ptp(heights)) / 2
    digits = INTERPOLATION_DIGITS * np.log(10)
    n = 2 + int(np.ceil(digits / np.log(max(ANALYTIC_RANGE / half_range, 2.0)))) if half_range else 1
    return chebyshev_points(heights, n)


def load_heights(heights: Array, phase: float) -> Array:
    """Enough Chebyshev points for the heights z / R_roll of loads: `phase` is k_max a.

    At the radius of a load weights depend on its half-length alone, by sin(k a) / (k a): their n-th
    derivative is less than (k a)^n.
    """
    phase *= float(np.ptp(heights)) / 2 * float(np.max(1 / (1 - heights))) ** 2
    n = 1
    while 2 * (phase / 2) ** n / factorial(n) > 10.0**-INTERPOLATION_DIGITS:
        n += 1
    return chebyshev_points(heights, n)


def columns(solved: Responses, grid: Grid, components: Sequence[str]) -> dict[str, Callable[[int], Array]]:
    """Return what computes columns, of a model (""), and of each of its variations.

    A column has the displacements [mm/N] due to unit total loads on a strip, shape (3, 3, n_x, n_s), NaN
    where they are not among the `components`. Everything that does not depend on the strip is prepared, and
    shared between variations with the same wavenumbers.
    """
    body, k_of_model = solved.body, COLUMNS_NEED * solved.samples.axis.k_max
    heights = body.side * body.contour.position(grid.strips)[1] / body.rolling_radius
    loads_at, nodes = load_heights(heights, k_of_model * grid.dx / 2), node_heights(heights)
    half_lengths, xi = grid.dx / 2 / (1 - loads_at), np.outer(1 / (1 - nodes), grid.lags).ravel()
    place = np.searchsorted(solved.s, grid.strips)  # of each strip's centre among the observers
    load_number = {load: number for number, load in enumerate(solved.loads)}
    computed = np.zeros((3, 3), dtype=bool)
    computed[places(components)] = True

    def column(samples: Samples, weights: tuple[Array, Array], tails: Array, strip: int) -> Array:
        u = np.full((3, 3, grid.n_x, grid.n_s), np.nan)
        load_shares = lagrange_shares(loads_at, heights[[strip]])[:, 0]
        mean_shares = lagrange_shares(nodes, (heights + heights[strip]) / 2)
        for has_parity, by_radius in zip((~SINES, SINES), weights, strict=True):
            i, j = np.nonzero(computed & has_parity)
            if not len(i):
                continue
            of_load = np.tensordot(load_shares, by_radius, axes=1).reshape(len(samples.k), -1)
            loads = [load_number[Load(grid.patch(strip), direction)] for direction in j.tolist()]
            at_strips = samples.responses[:, loads, i][..., place]  # (k, component, observer)
            by_mean_radius = (of_load.T @ at_strips.reshape(len(at_strips), -1)).reshape(
                len(nodes), grid.n_x, len(i), -1
            )
            u[i, j] = np.einsum("qs,qlcs->cls", mean_shares, by_mean_radius)
        number = np.arange(grid.n_s) - strip + tails.shape[-1] // 2
        has_tail = (number >= 0) & (number < tails.shape[-1])
        u[..., has_tail] += np.tensordot(load_shares, tails, axes=1)[..., number[has_tail]]
        return u

    half_space = HalfSpace(one_body(body.material, body.side))
    shares: dict[float, list[tuple[Array, Array]]] = {}  # by largest wavenumber
    # Of responses even and odd in x [1/mm], (load radius, k, mean radius, lag) each, by all wavenumbers.
    weights: dict[tuple[float, bytes], tuple[Array, Array]] = {}
    by_variation: dict[str, Callable[[int], Array]] = {}
    for name, samples, k_of_m in solved.variations():
        k_max, key = COLUMNS_NEED * k_of_m, (k_of_m, samples.k.tobytes())
        if key not in weights:
            wavenumbers = spectrum(k_max, body.rolling_radius)
            if k_max not in shares:
                shares[k_max] = wavenumbers.shares_of_loads(half_lengths.tolist(), xi)
            by_load = [synthesis_weights(samples.axis, samples.k, wavenumbers, w) for w in shares[k_max]]
            shape = (len(by_load), len(samples.k), len(nodes), grid.n_x)
            even, odd = (np.stack(w).reshape(shape) for w in zip(*by_load, strict=True))
            weights[key] = even, odd
        largest = k_max / (1 - loads_at)
        reach = grid.ds / 2 + WAVE_REACH / float(np.min(largest))
        m = min(int(np.ceil(reach / grid.ds)), grid.n_s - 1)  # strips apart up to which a tail reaches
        tails = np.stack([_tails(half_space, grid, float(k), m) for k in largest])
        by_variation[name] = partial(column, samples, weights[key], tails)
    return by_variation


@lru_cache(maxsize=64)
def _tails(half_space: HalfSpace, grid: Grid, k_max: float, m: int) -> Array:
    """The half-space's share of displacements [mm/N], shape (3, 3, n_x, 2 m + 1).

    The last axis counts the strips apart, from -m to m.
    """
    beyond = tail(half_space, grid.element, k_max, grid.lags)
    ahead = np.stack([beyond(grid.ds * n) for n in range(m + 1)], axis=-1)
    behind = S_MIRROR[..., None, None] * ahead[..., :0:-1]
    return np.concatenate([behind, ahead], axis=-1)
