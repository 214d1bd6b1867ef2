"""The harmonic engine: responses of one body to unit strip loads, one section problem per wavenumber.

The section of a body is the same everywhere along x (round its axis). A load that varies as cos(k x) causes
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), where U, V, W are amplitudes on the section
(`section_model`). For a load along x sines and cosines are exchanged: its K is K(-k), which is K(k) with the
sign of U changed. So one factorisation per wavenumber serves all loads. On a closed body of revolution k = m
/ R_roll. Sections that are their own mirror image are halved, with even and odd fields. `synthesis` computes
displacements anywhere along x from the responses. Source: design section 4.
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

FINER = 5.0  # the cells near the patches where M is fitted are this much smaller
WAVE_CELLS = 4.0  # longest cell on a strip times the largest wavenumber, over growth
CENTRE_WAVE_CELLS = 17.5  # like `WAVE_CELLS`, where displacements are read at the centres of strips only

Progress = Callable[[int], None]  # takes the number of wavenumbers solved so far, 0 after the assembly
Answer = tuple[Array, float]  # responses (2, load, 3, len(s)) [mm^2/N] at a wavenumber, and their residual


class Kept(Protocol):
    """A store of the responses at wavenumbers that were solved before."""

    def get(self, k: float) -> Answer | None:
        """The responses at a wavenumber [1/mm] and their residual, None if it was not solved."""

    def put(self, k: float, answer: Answer) -> None:
        """Keep the responses at a wavenumber [1/mm] and their residual."""


def build_section(request: HarmonicRequest) -> SectionMesh:
    """Mesh the section of a request, half of it where the contour is symmetric."""
    half_section = request.body.contour.symmetric
    cells = request.cells
    wave_cell = WAVE_CELLS * cells.growth / request.k_max
    if request.even_strips:
        wave_cell = min(cells.smallest, CENTRE_WAVE_CELLS * cells.growth / request.k_max)
    finer = [(strips(request.fit_patches), cells.smallest / FINER)] if request.fit_patches else []
    size = SectionSize(cells, strips(load.patch for load in request.loads), wave_cell, tuple(finer))
    return section_mesh(request.body, size, half_section=half_section)


def strips(patches: Iterable[Patch]) -> Array:
    """Ends [mm] of the strips of s under patches, without repetitions, shape (n, 2)."""
    return np.unique([[patch.s - patch.b, patch.s + patch.b] for patch in patches], axis=0)


def raw_ics(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    workers: int = 1,
    progress: Progress = lambda _: None,
) -> RawICs:
    """Displacements [mm/N] at the points of a request: solve it (`solve`), then sum over the wavenumbers."""
    solved = solve(request, most_unknowns, workers=workers, progress=progress)
    return displacements(solved, request.loads, request.points)


def solve(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    *,
    workers: int = 1,
    progress: Progress = lambda _: None,
    kept: Kept | None = None,
) -> Responses:
    """Mesh, assemble, and solve the wavenumbers in parallel threads.

    Raises NotConverged if the section has more than `most_unknowns`, or if a wavenumber cannot be solved to
    a small residual. The worst residual is part of the cost. `kept` holds the wavenumbers that an earlier
    run has solved, and receives the new ones.
    """
    with one_blas_thread():
        return _solve(request, most_unknowns, workers, progress, kept)


def _solve(
    request: HarmonicRequest, most_unknowns: int | None, workers: int, progress: Progress, kept: Kept | None
) -> Responses:
    """The responses of `solve`."""
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
    samples, residual = _sampled(request, respond, workers, progress, kept)
    seconds = {
        "mesh": meshed - start,
        "assembly": assembled - meshed,
        "solution": perf_counter() - assembled,
    }
    solver = f"direct, {len(samples.k)} wavenumbers"
    cells = int(section.mesh.nelements)
    cost = Cost(model.unknowns, cells, solver, (), residual, seconds, peak_memory())
    drawn = section.mesh.p[:, : section.mesh.nvertices], section.mesh.t
    return Responses(request.body, request.loads, request.observed, samples, cost, drawn)


def _sampled(
    request: HarmonicRequest, respond: Respond, workers: int, progress: Progress, kept: Kept | None
) -> tuple[Sampled, float]:
    """Responses at enough wavenumbers, and the worst residual of all, kept ones included.

    The responses have shape (n, 2, load, 3, len(s)): first with the far arc at its radius, then with the
    nearer far arc.
    """
    parallel = Parallel(n_jobs=workers, prefer="threads", return_as="generator")
    residuals: list[float] = []

    def answer_at(k: float) -> Answer:
        answer = kept.get(k) if kept else None
        if answer is None:
            answer = _answer(request, respond, k)
            if kept:
                kept.put(k, answer)
        return answer

    def responses_at(wavenumbers: Sequence[float]) -> list[Array]:
        all_responses = []
        for responses, residual in parallel(delayed(answer_at)(k) for k in wavenumbers):
            all_responses.append(responses)
            residuals.append(residual)
            progress(len(residuals))
        return all_responses

    odd = np.stack([SINES[:, load.direction] for load in request.loads])[..., None]
    a = min(load.patch.a for load in request.loads)
    return sampled(request.axis, responses_at, odd, a, request.accuracy), max(residuals)


def _answer(request: HarmonicRequest, respond: Respond, k: float) -> Answer:
    """Responses with both far arcs at a wavenumber [1/mm], and the worse residual of the two.

    From `request.felt` on the distance of the far arc does not matter: one solution serves both.
    """
    at_arc, residual = respond(k)
    if k >= request.felt:
        return np.stack([at_arc, at_arc]), residual
    nearer, nearer_residual = respond(k, nearer=True)
    return np.stack([at_arc, nearer]), max(residual, nearer_residual)
