"""From the responses of a section to displacements along x."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from approx.halfspace import HalfSpace
from femic.harmonic.wavenumbers import Sampled
from femic.harmonic.waves import SINES, spectrum, synthesis_weights, tail
from femic.level import HIGHER
from femic.models import Cost, Points, RawICs
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, Patch

REACH = 40.0  # lengths 1 / k beyond which nothing is left of a wave


@dataclass(frozen=True, eq=False)
class Responses:
    """What a section answers to unit line loads on its strips at enough wavenumbers, and what that took.

    `found.responses` has shape (k, 2 supports, load, 3, len(s)): amplitudes of sin(k x) or cos(k x) of the
    local components at arc lengths s, with the far arc where it is and nearer. `drawn` are vertices (2, n)
    and triangles (3, m) of its mesh, to be looked at.
    """

    body: Body
    loads: tuple[Load, ...]
    s: Array
    found: Sampled
    cost: Cost
    drawn: tuple[Array, Indices]

    @property
    def nearer(self) -> Sampled:
        """With the far arc at half its radius."""
        return replace(self.found, responses=self.found.responses[:, 1])

    def variations(self) -> Iterator[tuple[str, Sampled, float]]:
        """What displacements are made of, then with less of something: name, responses, largest k.

        "sparser": without the last wavenumber of each interval; "lower": half of the largest wavenumber;
        "nearer": far arc at half its radius.
        """
        far, k_max = replace(self.found, responses=self.found.responses[:, 0]), self.found.axis.k_max
        yield "", far, k_max
        yield "nearer", self.nearer, k_max
        yield "sparser", far.sparser, k_max
        yield "lower", far, k_max / HIGHER


def displacements(solved: Responses, loads: Sequence[Load], points: Points) -> RawICs:
    """Displacements at points on the surface under some of the solved loads.

    `perturbed` of the result: as the variations of the responses.
    """
    of = {name: _summed(solved, found, k_max, loads, points) for name, found, k_max in solved.variations()}
    return RawICs(of.pop(""), solved.cost, of, solved.drawn)


def _summed(solved: Responses, found: Sampled, k_max: float, loads: Sequence[Load], points: Points) -> Array:
    """Displacements (load, 3, n_points) from responses (k, load, 3, n_s) below k_max.

    What lies beyond is added as that of the half-space.
    """
    u = np.empty((len(loads), 3, len(points.x)))
    of_patch: dict[Patch, list[int]] = {}
    for j, load in enumerate(loads):
        of_patch.setdefault(load.patch, []).append(j)
    for alike in of_patch.values():
        u[alike] = _under_patch(solved, found, k_max, [loads[j] for j in alike], points)
    return u


def _under_patch(
    solved: Responses, found: Sampled, k_max: float, loads: Sequence[Load], points: Points
) -> Array:
    """Displacements (load, 3, n_points) under loads on one patch."""
    body, patch = solved.body, loads[0].patch
    place = np.searchsorted(solved.s, points.s)
    xi = body.surface.chart_x(points.x, points.s, patch.s)
    apart, column = np.unique(np.abs(xi), return_inverse=True)
    stretch = float(body.surface.chart_x(1.0, patch.s, patch.s))  # of the chart at the load
    over = spectrum(k_max, body.rolling_radius)
    even, odd = synthesis_weights(found.axis, found.k, over, patch.a * stretch, apart)
    weights = np.stack([even[:, column], odd[:, column] * np.sign(xi)])
    u = np.empty((len(loads), 3, len(xi)))
    for row, load in enumerate(loads):
        of_load = found.responses[:, solved.loads.index(load)]
        for i, sine in enumerate(SINES[:, load.direction]):
            u[row, i] = np.einsum("kp,kp->p", of_load[:, i, place], weights[int(sine)])
    half_space, beyond = HalfSpace(one_body(body.material, body.side)), over.k_max * stretch
    directions = [load.direction for load in loads]
    for s in np.unique(points.s[np.abs(points.s - patch.s) < patch.b + REACH / beyond]):
        at = points.s == s
        u[..., at] += np.swapaxes(tail(half_space, patch, beyond, points.x[at], s - patch.s), 0, 1)[
            directions
        ]
    return u
