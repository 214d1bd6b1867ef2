"""Displacements along x from the responses of a section: at points, and at all lags of a grid.

On a grid they are computed strip by strip. On a prismatic body the weight of a response in the displacement
at a lag depends on the lag alone, on a body of revolution also on the radii of both rolling circles. This
dependence is smooth and the radii differ little: weights are computed for a few radii (Chebyshev points) and
interpolated between them.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import factorial

import numpy as np

from approx.halfspace import HalfSpace
from femic.cache.workers import one_blas_thread
from femic.reference.engine import Cost, Points, RawICs
from femic.reference.harmonic.request import COLUMNS_NEED
from femic.reference.harmonic.wavenumbers import Samples
from femic.reference.harmonic.waves import SINES, Tail, spectrum, synthesis_weights
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


def select_part(
    solved: Responses, loads: Sequence[Load], members: Sequence[Indices], s: Array, places: Indices
) -> Responses:
    """Return the responses at some arc lengths s [mm] to loads that are means of solved loads.

    `members` are the numbers of the solved loads that make up each load, `places` the numbers of the arc
    lengths.
    """

    def part(responses: Array) -> Array:
        means = [np.mean(responses[..., numbers, :, :], axis=-3) for numbers in members]
        return np.stack(means, axis=-3)[..., places]

    samples = replace(solved.samples, responses=part(solved.samples.responses))
    return replace(solved, loads=tuple(loads), s=s, samples=samples, coarser=part(solved.coarser))


def odd_in_k(loads: Sequence[Load]) -> Mask:
    """Return which responses to loads are odd in k, as displacements are in x, shape (load, 3, 1)."""
    return np.stack([SINES[:, load.direction] for load in loads])[..., None]


# --- at points ---


def displacements(solved: Responses, loads: Sequence[Load], points: Points) -> RawICs:
    """Displacements [mm/N] at points on the surface under some of the solved loads, before the discount.

    The result has the displacements from the variations of the responses as `RawICs.perturbed`.
    """
    loads_of_patch: dict[Patch, list[int]] = {}
    for j, load in enumerate(loads):
        loads_of_patch.setdefault(load.patch, []).append(j)
    variations = list(solved.variations())
    u = {name: np.empty((len(loads), 3, len(points.x))) for name, _, _ in variations}
    with one_blas_thread():
        for numbers in loads_of_patch.values():
            under_patch = _UnderPatch.prepare(
                solved, [loads[j] for j in numbers], points, {k_max for _, _, k_max in variations}
            )
            for name, samples, k_max in variations:
                u[name][numbers] = under_patch.displacements(samples, k_max)
    return RawICs(u.pop(""), solved.cost, u, solved.drawn)


@dataclass(frozen=True, eq=False)
class _UnderPatch:
    """Displacements at points under loads on one patch; what variations have in common is computed once."""

    solved: Responses
    loads: list[Load]  # on the same patch
    points: Points
    observer: Indices  # number of each point's arc length in the responses
    distance: Indices  # number of each point's |xi| in the shares
    sign: Array  # of each point's xi
    shares: dict[float, tuple[Array, Array]]  # at |xi| without repetitions, by the largest wavenumber
    tails: dict[float, Array]  # the half-space's share [mm/N], (3, 3, n_points), by the largest wavenumber

    @classmethod
    def prepare(
        cls, solved: Responses, loads: list[Load], points: Points, largest: Iterable[float]
    ) -> "_UnderPatch":
        """Prepare what variations with these largest wavenumbers [1/mm] have in common."""
        surface, patch = solved.body.surface, loads[0].patch
        xi = surface.chart_x(points.x, points.s, patch.s)
        distances, distance = np.unique(np.abs(xi), return_inverse=True)
        stretch = float(surface.chart_x(1.0, patch.s, patch.s))
        observer = np.searchsorted(solved.s, points.s)
        shares = {
            k_max: spectrum(k_max, solved.body.rolling_radius).shares(patch.a * stretch, distances)
            for k_max in largest
        }
        half_space = HalfSpace(one_body(solved.body.material, solved.body.side))
        tails = {k_max: _tail(half_space, patch, k_max * stretch, points) for k_max in shares}
        return cls(solved, loads, points, observer, distance, np.sign(xi), shares, tails)

    def displacements(self, samples: Samples, k_max: float) -> Array:
        """Displacements [mm/N] from responses (k, load, 3, n_s) up to k_max [1/mm], (load, 3, n_points).

        The half-space's share is added.
        """
        wavenumbers = spectrum(k_max, self.solved.body.rolling_radius)
        even, odd = synthesis_weights(samples.axis, samples.k, wavenumbers, self.shares[k_max])
        weights = np.stack([even[:, self.distance], odd[:, self.distance] * self.sign])
        u = np.empty((len(self.loads), 3, len(self.points.x)))
        for row, load in enumerate(self.loads):
            responses = samples.responses[:, self.solved.loads.index(load)]
            for i, is_odd in enumerate(SINES[:, load.direction]):
                u[row, i] = np.einsum("kp,kp->p", responses[:, i, self.observer], weights[int(is_odd)])
        directions = [load.direction for load in self.loads]
        return u + np.swapaxes(self.tails[k_max], 0, 1)[directions]


def _tail(half_space: HalfSpace, patch: Patch, k_max: float, points: Points) -> Array:
    """The half-space's share of displacements (3, 3, n_points); k_max [1/mm] is the largest k at the load."""
    u = np.zeros((3, 3, len(points.x)))
    near = np.flatnonzero(np.abs(points.s - patch.s) < patch.b + WAVE_REACH / k_max)
    if len(near):
        tail = Tail.prepare(half_space, patch, k_max, points.x[near])
        for s in np.unique(points.s[near]):
            on_strip = np.flatnonzero(points.s[near] == s)
            u[..., near[on_strip]] = tail.at(s - patch.s, on_strip)
    return u


# --- at the lags of a grid ---

INTERPOLATION_DIGITS = 10  # to which the interpolation between radii is exact
ANALYTIC_RANGE = 0.4  # change of ln(radius) within which the weights are analytic at the nearest lag
S_MIRROR = mirror_signs(S)  # signs of the components (i, j) where s changes sign


@dataclass(frozen=True, eq=False)
class Heights:
    """Chebyshev points of the heights of circles, z / R_roll with z into the body, shape (n_points,)."""

    points: Array

    @classmethod
    def covering(cls, heights: Array) -> "Heights":
        """Enough points for some heights z / R_roll; one point if they are all alike."""
        half_range = float(np.ptp(heights)) / 2
        digits = INTERPOLATION_DIGITS * np.log(10)
        n = 2 + int(np.ceil(digits / np.log(max(ANALYTIC_RANGE / half_range, 2.0)))) if half_range else 1
        return cls._chebyshev(heights, n)

    @property
    def stretch(self) -> Array:
        """Chart length over arc length at the points, shape (n_points,)."""
        return 1 / (1 - self.points)

    @classmethod
    def covering_loads(cls, heights: Array, phase: float) -> "Heights":
        """Enough points for the heights z / R_roll of loads: `phase` is k_max a.

        At the radius of a load weights depend on its half-length alone, by sin(k a) / (k a): their n-th
        derivative is less than (k a)^n.
        """
        half_range = float(np.ptp(heights)) / 2
        phase *= half_range * float(np.max(1 / (1 - heights))) ** 2
        n = 1
        while 2 * (phase / 2) ** n / factorial(n) > 10.0**-INTERPOLATION_DIGITS:
            n += 1
        return cls._chebyshev(heights, n)

    @classmethod
    def _chebyshev(cls, heights: Array, n: int) -> "Heights":
        middle, half_range = (np.max(heights) + np.min(heights)) / 2, np.ptp(heights) / 2
        return cls(middle + half_range * np.cos(np.pi * (np.arange(n) + 0.5) / n))

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
    loads_at: Heights  # circles of loads
    nodes: Heights  # circles half way between load and observer
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
        load_shares = self.loads_at.shares(self.heights[[strip]])[:, 0]
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
    and shared between variations with the same wavenumbers.
    """
    body, k_of_model = solved.body, COLUMNS_NEED * solved.samples.axis.k_max
    heights = body.side * body.contour.position(grid.strips)[1] / body.rolling_radius
    loads_at, nodes = Heights.covering_loads(heights, k_of_model * grid.dx / 2), Heights.covering(heights)
    weights = _Weights(body, grid, loads_at, nodes)
    observers = np.searchsorted(solved.s, grid.strips)
    loads = {load: number for number, load in enumerate(solved.loads)}
    computed = np.zeros((3, 3), dtype=bool)
    computed[places(components)] = True
    half_space = HalfSpace(one_body(body.material, body.side))
    by_variation = {}
    for name, samples, k_of_m in solved.variations():
        k_max = COLUMNS_NEED * k_of_m
        even, odd = weights.look_up(samples, k_max)
        largest = k_max * loads_at.stretch
        m = _reach(grid, float(np.min(largest)))
        tails = np.stack([_tails(half_space, grid, float(k), m) for k in largest])
        by_variation[name] = LagSynthesis(
            grid, heights, loads_at, nodes, even, odd, tails, samples, observers, computed, loads
        )
    return by_variation


@dataclass(frozen=True, eq=False)
class _Weights:
    """The weights of responses in displacements at the lags, computed once for the same wavenumbers."""

    body: Body
    grid: Grid
    loads_at: Heights
    nodes: Heights
    shares: dict[float, list[tuple[Array, Array]]] = field(default_factory=dict)  # by largest wavenumber
    known: dict[tuple[float, bytes], tuple[Array, Array]] = field(default_factory=dict)

    def look_up(self, samples: Samples, k_max: float) -> tuple[Array, Array]:
        """Weights [1/mm] of responses even and odd in x, (load radius, k, mean radius, lag) each."""
        key = k_max, samples.k.tobytes()
        if key not in self.known:
            self.known[key] = self._compute(samples, k_max)
        return self.known[key]

    def _compute(self, samples: Samples, k_max: float) -> tuple[Array, Array]:
        wavenumbers = spectrum(k_max, self.body.rolling_radius)
        if k_max not in self.shares:
            half_lengths = (self.grid.dx / 2 * self.loads_at.stretch).tolist()
            xi = np.outer(self.nodes.stretch, self.grid.lags).ravel()
            self.shares[k_max] = wavenumbers.shares_of_loads(half_lengths, xi)
        weights = [synthesis_weights(samples.axis, samples.k, wavenumbers, w) for w in self.shares[k_max]]
        shape = (len(weights), len(samples.k), len(self.nodes.points), self.grid.n_x)
        even, odd = (np.stack(w).reshape(shape) for w in zip(*weights, strict=True))
        return even, odd


def _reach(grid: Grid, k_max: float) -> int:
    """The number of strips apart up to which the half-space has a share."""
    return min(int(np.ceil((grid.ds / 2 + WAVE_REACH / k_max) / grid.ds)), grid.n_s - 1)


@lru_cache(maxsize=64)
def _tails(half_space: HalfSpace, grid: Grid, k_max: float, m: int) -> Array:
    """The half-space's share of displacements [mm/N], shape (3, 3, n_x, 2 m + 1).

    The last axis counts the strips apart, from -m to m.
    """
    tail = Tail.prepare(half_space, grid.element, k_max, grid.lags)
    ahead = np.stack([tail.at(grid.ds * n) for n in range(m + 1)], axis=-1)
    behind = S_MIRROR[..., None, None] * ahead[..., :0:-1]
    return np.concatenate([behind, ahead], axis=-1)
