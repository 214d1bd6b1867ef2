"""The harmonic engine: displacements of one body under unit patch loads, one section problem per wavenumber.

A body that does not change along x (round its axis) answers a load that varies as cos(k x) by
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), amplitudes of the section alone (`section_model`).
A load along x exchanges sines and cosines: its K is K(-k), which is K(k) with the sign of U changed. So one
factorisation per wavenumber serves all loads. On a body of revolution k = m / R_roll. Sections that are
their own mirror image are solved by halves, even and odd. Source: design section 4.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count
from time import perf_counter

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from approx.halfspace import HalfSpace
from femic.accuracy import NotConverged
from femic.cell_size import Cells
from femic.harmonic.section import SectionMesh, section_mesh
from femic.harmonic.section_model import assemble
from femic.harmonic.section_response import Respond
from femic.harmonic.wavenumbers import Axis, Sampled, sampled
from femic.harmonic.waves import SINES, spectrum, synthesis_weights, tail
from femic.models import Cost, Points, RawICs, peak_memory
from femic.threads import one_blas_thread
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, Patch

Array = NDArray[np.float64]

LOWEST = 0.7  # scale of the wavenumbers, times 1 / far radius: below it the clamped far arc rules
HIGHEST = 2 * np.pi  # largest wavenumber, times 1 / least half-side: beyond it the half-space does
CURVED = 0.05  # half-side over radius of curvature from which on larger wavenumbers are needed
RESOLVED = 4.0  # longest cell on a strip, times growth / largest wavenumber
ROUNDING = 1e-9
REACH = 40.0  # lengths 1 / k beyond which nothing is left of a wave
FAR_REACH = 7.0  # lengths 1 / k beyond which the far arc is not felt
NEARER = 2.0  # far radius over the one of the check
LOWER = 2.0  # largest wavenumber over the one of the check

Progress = Callable[[int], None]  # wavenumbers solved so far


@dataclass(frozen=True)
class HarmonicRequest:
    """What one model is solved for; points are relative to each load in x.

    `cells`: smallest and growth, away from the ends of the loaded strips. `accuracy` [mm/N] is asked of the
    interpolation between wavenumbers; `highest` is the largest, times the least half-side of the loads.
    """

    body: Body
    loads: tuple[Load, ...]
    points: Points
    cells: Cells
    accuracy: float
    highest: float = HIGHEST

    @property
    def k_max(self) -> float:
        """Largest wavenumber [1/mm]: the more curved the surface under the loads, the larger.

        There and at half of it the patch's own weight sin(k a) / (k a) is 0: little is cut off.
        """
        patches = [load.patch for load in self.loads]
        bend = max(_curvature(self.body, patch.s, patch.b) * max(patch.a, patch.b) for patch in patches)
        a, b = min(patch.a for patch in patches), min(patch.b for patch in patches)
        needed = self.highest / min(a, b) * max(1.0, bend / CURVED) ** 0.5
        return 2 * np.pi / a * int(np.ceil(needed * a / (2 * np.pi) - ROUNDING))

    @property
    def axis(self) -> Axis:
        """The axis of wavenumbers."""
        return Axis(LOWEST / self.body.domain.far_radius, self.k_max, self.body.rolling_radius)


def _curvature(body: Body, s: float, b: float) -> float:
    """Largest curvature [1/mm] of the surface over a strip."""
    turn = float(np.ptp(body.contour.inclination(np.linspace(s - b, s + b, 9)))) / (2 * b)
    return max(turn, 1 / float(body.surface.circle_radius(s)))


def build_section(request: HarmonicRequest) -> SectionMesh:
    """The mesh for a request: half of the section where symmetry allows it."""
    half = request.body.contour.symmetric
    wave = RESOLVED * request.cells.growth / request.k_max
    return section_mesh(request.body, request.cells, strips(request.loads), wave, half_section=half)


def strips(loads: Sequence[Load]) -> Array:
    """Ends [mm] of the strips of s under the loads, (n, 2)."""
    return np.unique([[load.patch.s - load.patch.b, load.patch.s + load.patch.b] for load in loads], axis=0)


def raw_ics(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    workers: int = 1,
    progress: Progress = lambda _: None,
) -> RawICs:
    """Mesh, assemble, solve the wavenumbers in parallel threads, and sum them at the points.

    `perturbed` of the result: "nearer" (far arc at half its radius), "sparser" (without the last
    wavenumber of each interval), "lower" (half of the largest wavenumber). Raises NotConverged if the
    section has more than `most_unknowns`.
    """
    start = perf_counter()
    section = build_section(request)
    meshed = perf_counter()
    model = assemble(section)
    if most_unknowns is not None and model.unknowns > most_unknowns:
        raise NotConverged(
            f"a section needs {model.unknowns:,} unknowns, engine.most_unknowns = {most_unknowns:,}: give a "
            "larger engine.tolerance, larger cells (engine.growth) or a larger most_unknowns"
        )
    respond = Respond(model, request.loads, np.unique(request.points.s), nearer=1 / NEARER)
    assembled = perf_counter()
    with one_blas_thread():
        found = responses(request, respond, workers, progress)
    solved = perf_counter()
    u, nearer = displacements(request, found, request.k_max)
    sparser = displacements(request, found.sparser, request.k_max)[0]
    lower = displacements(request, found, request.k_max / LOWER)[0]
    seconds = {
        "mesh": meshed - start,
        "assembly": assembled - meshed,
        "solution": solved - assembled,
        "synthesis": perf_counter() - solved,
    }
    solver = f"direct, {len(found.k)} wavenumbers"
    cells = int(section.mesh.nelements)
    cost = Cost(model.unknowns, cells, solver, (), respond.residual, seconds, peak_memory())
    return RawICs(u, cost, {"nearer": nearer, "sparser": sparser, "lower": lower})


def responses(request: HarmonicRequest, respond: Respond, workers: int, progress: Progress) -> Sampled:
    """Responses (n, 2, load, 3, len(s)), of the far arc where it is and nearer, at enough wavenumbers."""
    far = FAR_REACH * NEARER / request.body.domain.far_radius
    run = Parallel(n_jobs=workers, prefer="threads", return_as="generator")
    solved = count(1)

    def both(k: float) -> Array:
        at_arc = respond(k, nearer=False)
        return np.stack([at_arc, respond(k, nearer=True) if k < far else at_arc])

    def solve(k: Sequence[float]) -> list[Array]:
        found = []
        for response in run(delayed(both)(value) for value in k):
            found.append(response)
            progress(next(solved))
        return found

    odd = np.stack([SINES[:, load.direction] for load in request.loads])[..., None]
    a = min(load.patch.a for load in request.loads)
    return sampled(request.axis, solve, odd, a, request.accuracy)


def displacements(request: HarmonicRequest, found: Sampled, k_max: float) -> Array:
    """Displacements (variant, load, 3, n_points) from responses (k, variant, load, 3, n_s) below k_max.

    What lies beyond is added as that of the half-space.
    """
    u = np.empty((found.responses.shape[1], len(request.loads), 3, len(request.points.x)))
    of_patch: dict[Patch, list[int]] = {}
    for j, load in enumerate(request.loads):
        of_patch.setdefault(load.patch, []).append(j)
    for patch, alike in of_patch.items():
        u[:, alike] = _under_patch(request, found, k_max, patch, alike)
    return u


def _under_patch(
    request: HarmonicRequest, found: Sampled, k_max: float, patch: Patch, alike: list[int]
) -> Array:
    """Displacements (variant, load, 3, n_points) under the loads `alike` on one patch."""
    body, points = request.body, request.points
    s, place = np.unique(points.s, return_inverse=True)
    xi = body.surface.chart_x(points.x, points.s, patch.s)
    apart, column = np.unique(np.abs(xi), return_inverse=True)
    stretch = float(body.surface.chart_x(1.0, patch.s, patch.s))  # of the chart at the load
    over = spectrum(k_max, apart[-1] + patch.a, body.rolling_radius)
    even, odd = synthesis_weights(found.axis, found.k, over, patch.a * stretch, apart)
    weights = np.stack([even[:, column], odd[:, column] * np.sign(xi)])
    u = np.empty((found.responses.shape[1], len(alike), 3, len(xi)))
    for row, j in enumerate(alike):
        for i, sine in enumerate(SINES[:, request.loads[j].direction]):
            at_points = found.responses[:, :, j, i, place]  # (k, variant, point)
            u[:, row, i] = np.einsum("kvp,kp->vp", at_points, weights[int(sine)])
    half_space, beyond = HalfSpace(one_body(body.material, body.side)), over.k_max * stretch
    directions = [request.loads[j].direction for j in alike]
    for m in np.flatnonzero(np.abs(s - patch.s) < patch.b + REACH / beyond):
        at = place == m
        added = tail(half_space, patch, beyond, points.x[at], s[m] - patch.s)
        u[..., at] += np.swapaxes(added[:, directions], 0, 1)
    return u
