"""Displacements along x from the responses of a section."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from approx.halfspace import HalfSpace
from femic.cache.threads import one_blas_thread
from femic.reference.harmonic.wavenumbers import Samples
from femic.reference.harmonic.waves import SINES, Tail, spectrum, synthesis_weights
from femic.reference.level import HIGHER
from femic.reference.models import Cost, Points, RawICs
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, Patch

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


def part_of(
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


def displacements(solved: Responses, loads: Sequence[Load], points: Points) -> RawICs:
    """Displacements [mm/N] at points on the surface under some of the solved loads, before the discount.

    `perturbed` of the result has the displacements from the variations of the responses.
    """
    loads_of_patch: dict[Patch, list[int]] = {}
    for j, load in enumerate(loads):
        loads_of_patch.setdefault(load.patch, []).append(j)
    variations = list(solved.variations())
    u = {name: np.empty((len(loads), 3, len(points.x))) for name, _, _ in variations}
    with one_blas_thread():
        for numbers in loads_of_patch.values():
            under_patch = _UnderPatch.of(
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
    def of(
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
        tail = Tail.of(half_space, patch, k_max, points.x[near])
        for s in np.unique(points.s[near]):
            on_strip = np.flatnonzero(points.s[near] == s)
            u[..., near[on_strip]] = tail.at(s - patch.s, on_strip)
    return u
