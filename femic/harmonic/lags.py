"""Displacements at all lags of a grid, strip by strip.

How a response at one wavenumber enters the displacement at a lag depends on the lag alone on a prismatic
body, on a body of revolution also on the radii of both circles. That dependence is smooth, and the radii
differ little: weights are computed for a few of them (Chebyshev points) and interpolated.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from approx.halfspace import HalfSpace
from femic.harmonic.synthesis import REACH, Responses
from femic.harmonic.wavenumbers import Sampled
from femic.harmonic.waves import SINES, spectrum, synthesis_weights, tail
from geometries.arrays import Array, Indices
from geometries.grids import Grid
from geometries.materials import one_body
from geometries.patches import Load, Patch, S

DIGITS = 10  # of the interpolation between radii
ANALYTIC = 0.4  # change of ln(radius) within which the weights are analytic at the nearest lag
MIRROR = np.where(
    (np.arange(3) == S)[:, None] ^ (np.arange(3) == S), -1.0, 1.0
)  # of components: s changes sign
ODD, EVEN = np.nonzero(SINES), np.nonzero(~SINES)  # (i, j) of the components odd and even in x


@dataclass(frozen=True, eq=False)
class Radii:
    """Chebyshev points of the height z / R_roll of circles over a range, to interpolate between."""

    points: Array

    @classmethod
    def of(cls, heights: Array) -> "Radii":
        """Enough for some heights; one if they are all alike."""
        half = float(np.ptp(heights)) / 2
        n = 1 if half == 0 else 2 + int(np.ceil(DIGITS * np.log(10) / np.log(max(ANALYTIC / half, 2.0))))
        middle = (np.max(heights) + np.min(heights)) / 2
        return cls(middle + half * np.cos(np.pi * (np.arange(n) + 0.5) / n))

    @property
    def stretch(self) -> Array:
        """Chart length over arc length."""
        return 1 / (1 - self.points)

    def shares(self, heights: Array) -> Array:
        """Lagrange polynomials, (n_points, len(heights))."""
        gaps = heights - self.points[:, None]
        out = np.ones_like(gaps)
        for m, point in enumerate(self.points):
            others = np.arange(len(self.points)) != m
            out[m] = np.prod(gaps[others] / (point - self.points[others])[:, None], axis=0)
        return out


@dataclass(frozen=True, eq=False)
class LagSynthesis:
    """From responses to displacements per unit total load [mm/N] at the lags of a grid."""

    grid: Grid
    heights: Array  # of the strips' circles, over R_roll
    radii: Radii
    even: Array  # (load radius, k, mean radius, lag)
    odd: Array
    tails: Array  # (load radius, i, j, lag, strips apart)
    found: Sampled
    place: Indices  # of the strips among the observers
    loads: Indices  # (strip, direction): place among the loads

    @classmethod
    def of(cls, solved: Responses, found: Sampled, k_max: float, grid: Grid) -> "LagSynthesis":
        """Prepare all that does not depend on the strip."""
        body, a = solved.body, grid.dx / 2
        heights = body.side * body.contour.position(grid.strips)[1] / body.rolling_radius
        radii = Radii.of(heights)
        xi = np.outer(radii.stretch, grid.lags).ravel()
        over = spectrum(k_max, body.rolling_radius)
        weights = [synthesis_weights(found.axis, found.k, over, a * t, xi) for t in radii.stretch]
        shape = (len(radii.points), len(found.k), len(radii.points), grid.n_x)
        even, odd = (np.stack(w).reshape(shape) for w in zip(*weights, strict=True))
        half_space = HalfSpace(one_body(body.material, body.side))
        tails = np.stack([_tails(half_space, grid, float(over.k_max * t)) for t in radii.stretch])
        place = np.searchsorted(solved.s, grid.strips)
        number = {load: n for n, load in enumerate(solved.loads)}
        loads = np.array([[number[Load(grid.patch(m), j)] for j in range(3)] for m in range(grid.n_s)])
        return cls(grid, heights, radii, even, odd, tails, found, place, loads)

    def column(self, strip: int) -> Array:
        """Displacements due to unit loads on a strip, shape (3, 3, n_x, n_s)."""
        u = np.empty((3, 3, self.grid.n_x, self.grid.n_s))
        of_load = self.radii.shares(self.heights[[strip]])[:, 0]
        of_pair = self.radii.shares((self.heights + self.heights[strip]) / 2)  # (mean radius, n_s)
        responses = self.found.responses[:, self.loads[strip]]  # (k, j, i, observer)
        for (i, j), by_radius in ((EVEN, self.even), (ODD, self.odd)):
            weights = np.tensordot(of_load, by_radius, axes=1).reshape(len(self.found.k), -1)
            chosen = responses[:, j, i][..., self.place]  # (k, component, n_s)
            summed = (weights.T @ chosen.reshape(len(chosen), -1)).reshape(
                len(self.radii.points), self.grid.n_x, len(i), -1
            )
            u[i, j] = np.einsum("qs,qlcs->cls", of_pair, summed)
        apart = np.arange(self.grid.n_s) - strip + self.tails.shape[-1] // 2
        near = (apart >= 0) & (apart < self.tails.shape[-1])
        u[..., near] += np.tensordot(of_load, self.tails, axes=1)[..., apart[near]]
        return u


@lru_cache(maxsize=64)
def _tails(half_space: HalfSpace, grid: Grid, beyond: float) -> Array:
    """What wavenumbers beyond the largest add, (3, 3, n_x, strips apart from -m to m): the half-space's."""
    m = min(int(np.ceil((grid.ds / 2 + REACH / beyond) / grid.ds)), grid.n_s - 1)
    patch = Patch(grid.dx / 2, grid.ds / 2)
    ahead = np.stack([tail(half_space, patch, beyond, grid.lags, grid.ds * n) for n in range(m + 1)], axis=-1)
    behind = MIRROR[..., None, None] * ahead[..., :0:-1]
    return np.concatenate([behind, ahead], axis=-1)
