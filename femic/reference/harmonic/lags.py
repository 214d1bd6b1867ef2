"""Displacements at all lags of a grid, strip by strip.

On a prismatic body the weight of a response in the displacement at a lag depends on the lag alone, on a body
of revolution also on the radii of both rolling circles. This dependence is smooth and the radii differ
little: weights are computed for a few radii (Chebyshev points) and interpolated between them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from approx.halfspace import HalfSpace
from femic.reference.harmonic.synthesis import WAVE_REACH, Responses
from femic.reference.harmonic.wavenumbers import Samples
from femic.reference.harmonic.waves import SINES, Tail, spectrum, synthesis_weights
from geometries.arrays import Array, Indices, Mask
from geometries.grids import Grid
from geometries.materials import one_body
from geometries.patches import Load, S, mirror_signs, places

INTERPOLATION_DIGITS = 10  # to which the interpolation between radii is exact
ANALYTIC_RANGE = 0.4  # change of ln(radius) within which the weights are analytic at the nearest lag
S_MIRROR = mirror_signs(S)  # signs of the components (i, j) where s changes sign


@dataclass(frozen=True, eq=False)
class Heights:
    """Chebyshev points of the heights of circles, z / R_roll with z into the body, shape (n_points,)."""

    points: Array

    @classmethod
    def of(cls, heights: Array) -> "Heights":
        """Enough points for some heights z / R_roll; one point if they are all alike."""
        half_range = float(np.ptp(heights)) / 2
        digits = INTERPOLATION_DIGITS * np.log(10)
        n = 2 + int(np.ceil(digits / np.log(max(ANALYTIC_RANGE / half_range, 2.0)))) if half_range else 1
        middle = (np.max(heights) + np.min(heights)) / 2
        return cls(middle + half_range * np.cos(np.pi * (np.arange(n) + 0.5) / n))

    @property
    def stretch(self) -> Array:
        """Chart length over arc length at the points, shape (n_points,)."""
        return 1 / (1 - self.points)

    def shares(self, heights: Array) -> Array:
        """Lagrange polynomials of the points at heights, shape (n_points, len(heights))."""
        gaps = heights - self.points[:, None]
        shares = np.ones_like(gaps)
        for m, point in enumerate(self.points):
            other_points = np.arange(len(self.points)) != m
            shares[m] = np.prod(gaps[other_points] / (point - self.points[other_points])[:, None], axis=0)
        return shares


@dataclass(frozen=True, eq=False)
class LagSynthesis:
    """The synthesis of displacements per unit total load [mm/N] at the lags of a grid from responses."""

    grid: Grid
    heights: Array  # z / R_roll of the strips' circles, (n_s,)
    nodes: Heights
    even: Array  # weights [1/mm] of responses even in x, (load radius, k, mean radius, lag)
    odd: Array  # the same of responses odd in x
    tails: Array  # the half-space's share [mm/N], (load radius, i, j, lag, strips apart)
    samples: Samples
    place: Indices  # number of each strip's centre among the observers, (n_s,)
    computed: Mask  # components, (3, 3)
    loads: Mapping[Load, int]  # number of each load among the solved ones

    def column(self, strip: int) -> Array:
        """Displacements [mm/N] due to unit total loads on a strip, shape (3, 3, n_x, n_s).

        Components that are not computed are NaN.
        """
        u = np.full((3, 3, self.grid.n_x, self.grid.n_s), np.nan)
        load_shares = self.nodes.shares(self.heights[[strip]])[:, 0]
        mean_shares = self.nodes.shares((self.heights + self.heights[strip]) / 2)  # (mean radius, n_s)
        for has_parity, by_radius in ((~SINES, self.even), (SINES, self.odd)):
            i, j = np.nonzero(self.computed & has_parity)
            if not len(i):
                continue
            weights = np.tensordot(load_shares, by_radius, axes=1).reshape(len(self.samples.k), -1)
            loads = [self.loads[Load(self.grid.patch(strip), direction)] for direction in j.tolist()]
            responses = self.samples.responses[:, loads, i]  # (k, component, observer)
            at_strips = responses[..., self.place]
            by_mean_radius = (weights.T @ at_strips.reshape(len(at_strips), -1)).reshape(
                len(self.nodes.points), self.grid.n_x, len(i), -1
            )
            u[i, j] = np.einsum("qs,qlcs->cls", mean_shares, by_mean_radius)
        tail_number = np.arange(self.grid.n_s) - strip + self.tails.shape[-1] // 2
        has_tail = (tail_number >= 0) & (tail_number < self.tails.shape[-1])
        u[..., has_tail] += np.tensordot(load_shares, self.tails, axes=1)[..., tail_number[has_tail]]
        return u


def syntheses(solved: Responses, grid: Grid, components: Sequence[str]) -> dict[str, LagSynthesis]:
    """Return the synthesis of displacements from a model (""), and from each of its variations.

    It computes only the given `components`. Everything that does not depend on the loaded strip is prepared,
    and shared between variations with the same largest wavenumber.
    """
    body, a = solved.body, grid.dx / 2
    heights = body.side * body.contour.position(grid.strips)[1] / body.rolling_radius
    nodes = Heights.of(heights)
    observers = np.searchsorted(solved.s, grid.strips)
    loads = {load: number for number, load in enumerate(solved.loads)}
    computed = np.zeros((3, 3), dtype=bool)
    computed[places(components)] = True
    half_space = HalfSpace(one_body(body.material, body.side))
    xi = np.outer(nodes.stretch, grid.lags).ravel()
    shares: dict[float, list[tuple[Array, Array]]] = {}  # by largest wavenumber, per load radius
    by_variation = {}
    for name, samples, k_max in solved.variations():
        wavenumbers = spectrum(k_max, body.rolling_radius)
        if k_max not in shares:
            shares[k_max] = [wavenumbers.shares(a * t, xi) for t in nodes.stretch]
        weights = [
            synthesis_weights(samples.axis, samples.k, wavenumbers, shares_at_radius)
            for shares_at_radius in shares[k_max]
        ]
        shape = (len(nodes.points), len(samples.k), len(nodes.points), grid.n_x)
        even, odd = (np.stack(w).reshape(shape) for w in zip(*weights, strict=True))
        largest = wavenumbers.k_max * nodes.stretch
        m = _reach(grid, float(np.min(largest)))
        tails = np.stack([_tails(half_space, grid, float(k), m) for k in largest])
        by_variation[name] = LagSynthesis(
            grid, heights, nodes, even, odd, tails, samples, observers, computed, loads
        )
    return by_variation


def _reach(grid: Grid, k_max: float) -> int:
    """The number of strips apart up to which the half-space has a share."""
    return min(int(np.ceil((grid.ds / 2 + WAVE_REACH / k_max) / grid.ds)), grid.n_s - 1)


@lru_cache(maxsize=64)
def _tails(half_space: HalfSpace, grid: Grid, k_max: float, m: int) -> Array:
    """The half-space's share of displacements [mm/N], shape (3, 3, n_x, 2 m + 1).

    The last axis counts the strips apart, from -m to m.
    """
    tail = Tail.of(half_space, grid.element, k_max, grid.lags)
    ahead = np.stack([tail.at(grid.ds * n) for n in range(m + 1)], axis=-1)
    behind = S_MIRROR[..., None, None] * ahead[..., :0:-1]
    return np.concatenate([behind, ahead], axis=-1)
