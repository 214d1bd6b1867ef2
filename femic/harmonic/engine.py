"""The harmonic engine: responses of one body to unit strip loads, one section problem per wavenumber.

A body that does not change along x (round its axis) answers a load that varies as cos(k x) by
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), amplitudes of the section alone (`section_model`).
A load along x exchanges sines and cosines: its K is K(-k), which is K(k) with the sign of U changed. So one
factorisation per wavenumber serves all loads. On a body of revolution k = m / R_roll. Sections that are
their own mirror image are solved by halves, even and odd. From the responses, `synthesis` makes the
displacements anywhere along x. Source: design section 4.
"""

from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from typing import Protocol

import numpy as np
from joblib import Parallel, delayed

from femic.accuracy import NotConverged
from femic.harmonic.request import NEARER, HarmonicRequest
from femic.harmonic.section import SectionMesh, section_mesh
from femic.harmonic.section_model import assemble
from femic.harmonic.section_response import Respond
from femic.harmonic.section_size import SectionSize
from femic.harmonic.synthesis import Responses, displacements
from femic.harmonic.wavenumbers import Sampled, sampled
from femic.harmonic.waves import SINES
from femic.models import Cost, RawICs, peak_memory
from femic.work.threads import one_blas_thread
from geometries.arrays import Array
from geometries.patches import Patch

FINER = 5.0  # cells where M is fitted
CENTRES_RESOLVED = 17.5  # as below, where displacements are read at the centres of strips only
RESOLVED = 4.0  # longest cell on a strip, times growth / largest wavenumber

Progress = Callable[[int], None]  # wavenumbers solved so far; 0: the section is assembled


Answer = tuple[Array, float]  # responses (2, load, 3, len(s)) at a wavenumber, and their residual


class Kept(Protocol):
    """Responses at wavenumbers that were solved before."""

    def get(self, k: float) -> Answer | None:
        """The responses at a wavenumber and their residual, if they were."""

    def put(self, k: float, answer: Answer) -> None:
        """Keep those of a new one."""


class _Nothing:
    def get(self, k: float) -> None:
        """Nothing."""

    def put(self, k: float, answer: Answer) -> None:
        """Forget it."""


NOTHING_KEPT = _Nothing()


def build_section(request: HarmonicRequest) -> SectionMesh:
    """The mesh for a request: half of the section where symmetry allows it."""
    half = request.body.contour.symmetric
    cells = request.cells
    wave = RESOLVED * cells.growth / request.k_max
    if request.even_strips:
        wave = min(cells.smallest, CENTRES_RESOLVED * cells.growth / request.k_max)
    near = [(strips(request.exact), cells.smallest / FINER)] if request.exact else []
    sizes = SectionSize(cells, strips(load.patch for load in request.loads), wave, tuple(near))
    return section_mesh(request.body, sizes, half_section=half)


def strips(patches: Iterable[Patch]) -> Array:
    """Ends [mm] of the strips of s under patches, (n, 2)."""
    return np.unique([[patch.s - patch.b, patch.s + patch.b] for patch in patches], axis=0)


def raw_ics(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    workers: int = 1,
    progress: Progress = lambda _: None,
) -> RawICs:
    """Displacements at the points of a request; solves it (`solve`) and sums the wavenumbers."""
    solved = solve(request, most_unknowns, workers=workers, progress=progress)
    return displacements(solved, request.loads, request.points)


def solve(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    *,
    workers: int = 1,
    progress: Progress = lambda _: None,
    kept: Kept = NOTHING_KEPT,
) -> Responses:
    """Mesh, assemble, and solve the wavenumbers in parallel threads.

    Raises NotConverged if the section has more than `most_unknowns`, or if a wavenumber cannot be solved to
    a small residual; the worst one is part of the cost. `kept` has the wavenumbers that an
    earlier run has solved, and takes the new ones.
    """
    start = perf_counter()
    section = build_section(request)
    meshed = perf_counter()
    model = assemble(section)
    if most_unknowns is not None and model.unknowns > most_unknowns:
        raise NotConverged(
            f"a section needs {model.unknowns:,} unknowns, `most_unknowns` = {most_unknowns:,}: give a "
            "larger `tolerance`, larger cells (`growth`) or a larger `most_unknowns`"
        )
    respond = Respond(model, request.loads, request.observed, nearer=1 / NEARER)
    assembled = perf_counter()
    progress(0)
    with one_blas_thread():
        found, residual = _sampled(request, respond, workers, progress, kept)
    seconds = {
        "mesh": meshed - start,
        "assembly": assembled - meshed,
        "solution": perf_counter() - assembled,
    }
    solver = f"direct, {len(found.k)} wavenumbers"
    cells = int(section.mesh.nelements)
    cost = Cost(model.unknowns, cells, solver, (), residual, seconds, peak_memory())
    drawn = section.mesh.p[:, : section.mesh.nvertices], section.mesh.t
    return Responses(request.body, request.loads, request.observed, found, cost, drawn)


def _sampled(
    request: HarmonicRequest, respond: Respond, workers: int, progress: Progress, kept: Kept
) -> tuple[Sampled, float]:
    """Responses (n, 2, load, 3, len(s)), of the far arc where it is and nearer, at enough wavenumbers.

    Also the worst residual of all, those that were kept among them.
    """
    run = Parallel(n_jobs=workers, prefer="threads", return_as="generator")
    residuals: list[float] = []

    def both(k: float) -> Answer:
        answer = kept.get(k)
        if answer is None:
            answer = _answer(request, respond, k)
            kept.put(k, answer)
        return answer

    def all_of(wavenumbers: Sequence[float]) -> list[Array]:
        found = []
        for responses, residual in run(delayed(both)(k) for k in wavenumbers):
            found.append(responses)
            residuals.append(residual)
            progress(len(residuals))
        return found

    odd = np.stack([SINES[:, load.direction] for load in request.loads])[..., None]
    a = min(load.patch.a for load in request.loads)
    return sampled(request.axis, all_of, odd, a, request.accuracy), max(residuals)


def _answer(request: HarmonicRequest, respond: Respond, k: float) -> Answer:
    """With the far arc where it is, and nearer where that is felt; the worse residual."""
    at_arc, residual = respond(k)
    if k >= request.felt:
        return np.stack([at_arc, at_arc]), residual
    nearer, other = respond(k, nearer=True)
    return np.stack([at_arc, nearer]), max(residual, other)
