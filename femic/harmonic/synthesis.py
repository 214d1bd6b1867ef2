"""Displacements along x from the responses of a section."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from approx.halfspace import HalfSpace
from femic.harmonic.wavenumbers import Sampled
from femic.harmonic.waves import SINES, spectrum, synthesis_weights, tail
from femic.level import HIGHER
from femic.models import Cost, Points, RawICs
from femic.work.threads import one_blas_thread
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, Patch

WAVE_REACH = 40.0  # distance times k beyond which nothing is left of a wave


@dataclass(frozen=True, eq=False)
class Responses:
    """Responses of a section to unit line loads on its strips at enough wavenumbers, and their cost.

    `samples.responses` [mm^2/N] has shape (k, 2 supports, load, 3, len(s)): amplitudes of sin(k x) or
    cos(k x) of the local components at arc lengths s [mm], first with the far arc at its radius, then with
    the nearer one. `coarser` are those with coarser cells, at the wavenumbers of `samples.sparser` only.
    `drawn` are vertices (2, n) [mm] and triangles (3, m) of its mesh, for pictures.
    """

    body: Body
    loads: tuple[Load, ...]
    s: Array
    samples: Sampled
    coarser: Array  # (sparser k, load, 3, len(s)) [mm^2/N]
    cost: Cost
    drawn: tuple[Array, Indices]

    def variations(self) -> Iterator[tuple[str, Sampled, float]]:
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
    """Which responses to loads are odd in k, as displacements are in x, shape (load, 3, 1)."""
    return np.stack([SINES[:, load.direction] for load in loads])[..., None]


def displacements(solved: Responses, loads: Sequence[Load], points: Points) -> RawICs:
    """Displacements [mm/N] at points on the surface under some of the solved loads, before the discount.

    `perturbed` of the result has those by the variations of the responses.
    """
    with one_blas_thread():
        by_variation = {
            name: _summed(solved, samples, k_max, loads, points)
            for name, samples, k_max in solved.variations()
        }
    return RawICs(by_variation.pop(""), solved.cost, by_variation, solved.drawn)


def _summed(
    solved: Responses, samples: Sampled, k_max: float, loads: Sequence[Load], points: Points
) -> Array:
    """Displacements [mm/N] from responses (k, load, 3, n_s) up to k_max [1/mm], shape (load, 3, n_points).

    Wavenumbers beyond k_max are added as those of the half-space.
    """
    u = np.empty((len(loads), 3, len(points.x)))
    loads_of_patch: dict[Patch, list[int]] = {}
    for j, load in enumerate(loads):
        loads_of_patch.setdefault(load.patch, []).append(j)
    for numbers in loads_of_patch.values():
        u[numbers] = _under_patch(solved, samples, k_max, [loads[j] for j in numbers], points)
    return u


def _under_patch(
    solved: Responses, samples: Sampled, k_max: float, loads: Sequence[Load], points: Points
) -> Array:
    """Displacements [mm/N] under loads on one patch, shape (load, 3, n_points)."""
    body, patch = solved.body, loads[0].patch
    observer = np.searchsorted(solved.s, points.s)
    xi = body.surface.chart_x(points.x, points.s, patch.s)
    distances, distance_number = np.unique(np.abs(xi), return_inverse=True)
    stretch = float(body.surface.chart_x(1.0, patch.s, patch.s))  # chart length over arc length at the load
    wavenumbers = spectrum(k_max, body.rolling_radius)
    even, odd = synthesis_weights(samples.axis, samples.k, wavenumbers, patch.a * stretch, distances)
    weights = np.stack([even[:, distance_number], odd[:, distance_number] * np.sign(xi)])
    u = np.empty((len(loads), 3, len(xi)))
    for row, load in enumerate(loads):
        responses = samples.responses[:, solved.loads.index(load)]
        for i, is_odd in enumerate(SINES[:, load.direction]):
            u[row, i] = np.einsum("kp,kp->p", responses[:, i, observer], weights[int(is_odd)])
    half_space, k_max_at_load = HalfSpace(one_body(body.material, body.side)), wavenumbers.k_max * stretch
    directions = [load.direction for load in loads]
    for s in np.unique(points.s[np.abs(points.s - patch.s) < patch.b + WAVE_REACH / k_max_at_load]):
        on_strip = points.s == s
        u[..., on_strip] += np.swapaxes(
            tail(half_space, patch, k_max_at_load, points.x[on_strip], s - patch.s), 0, 1
        )[directions]
    return u
