"""The harmonic engine: responses of one body to unit strip loads, one section problem per wavenumber.

The section of a body is the same everywhere along x (round its axis). A load that varies as cos(k x) causes
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), where U, V, W are amplitudes on the section
(`femic.reference.harmonic.section`). For a load along x sines and cosines are exchanged: its K is
K(-k), which is K(k) with the sign of U changed. So one factorisation per wavenumber serves all loads. On a
closed body of revolution k = m / R_roll. Sections that are their own mirror image are halved, with even and
odd fields. `femic.reference.harmonic.synthesis` computes displacements anywhere along x from the responses.
Theory: docs/theory/reference.md.

Models are solved one after the other, each in parallel, and stored. Their cost is known before: the section
is meshed, and its wavenumbers are counted on a half-space under the same loads, which takes a second. The
responses of the half-space are known in closed form, so the search for its wavenumbers takes no mesh and a
tenth of a second. On a plane it finds the same wavenumbers; on curved bodies it finds about four fifths as
many (measured). Seconds and memory follow laws that were fitted on one machine of 2 cores
(docs/evidence/performance.md): their ratios are more reliable than their values.

For each of the many small matrices of an elimination NumPy gives the interpreter's lock back and takes it
again, so threads wait for each other: two are 1.5 to 1.8 times as fast as one, two processes 1.9 times. But a
process takes a second to start, and prepares the equations once more. So threads serve small sections,
processes large ones.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property, partial
from time import perf_counter
from typing import Any

import numpy as np

from approx.halfspace import HalfSpace
from femic.cache.workers import Prepared, Processes, in_threads, one_blas_thread
from femic.reference.engine import BASE_MEMORY, Cost, ExpectedCost, peak_memory
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.request import COLUMNS_NEED, HarmonicRequest
from femic.reference.harmonic.section import FitCells, SectionMesh, SectionSize, section_mesh
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.stored import (
    NOT_STORED,
    StoredWaves,
    WaveSolution,
    model_key,
    requested_part,
    store_model,
    stored_model,
    with_unit_modulus,
)
from femic.reference.harmonic.synthesis import Responses, odd_in_k
from femic.reference.harmonic.waves import SINES, Samples, half_space_response, sample
from femic.reference.job import NotConverged
from femic.reference.run_options import RunOptions, Solved, Step, Task
from geometries.arrays import Array
from geometries.materials import one_body
from geometries.patches import Load, Patch

# --- the section ---

FINER = 5.0  # the cells at the patches where M is fitted are this much smaller
FINER_GROWTH, FINER_BEHIND = 0.6, 24.0  # their growth over growth, and up to where (half-sides): `FitCells`
WAVE_CELLS = 4.0  # longest cell on a strip times the largest wavenumber, over growth
CENTRE_WAVE_CELLS = 17.5  # like `WAVE_CELLS`, where displacements are read at the centres of strips only


def build_section(request: HarmonicRequest) -> SectionMesh:
    """Mesh the section of a request, half of it where the contour is symmetric.

    Around the patches where M is fitted, cells are finer than under strips as wide.
    """
    cells, fit_cells = request.cells, None
    wave_cell = WAVE_CELLS * cells.growth / request.k_max
    if request.on_strips:
        k_of_columns = COLUMNS_NEED * request.k_max
        wave_cell = min(cells.smallest, CENTRE_WAVE_CELLS * cells.growth / k_of_columns)
    if request.fit_patches:
        half_widths = [patch.b for patch in request.fit_patches]
        b, others = min(half_widths), [load.patch for load in request.loads]
        least = min((patch.b for patch in others if patch not in request.fit_patches), default=b)
        smallest = min(cells.smallest * b / least, b) / FINER
        behind = FINER_BEHIND * max(half_widths)
        fit_cells = FitCells(strips(request.fit_patches), smallest, FINER_GROWTH * cells.growth, behind)
    size = SectionSize(cells, strips(load.patch for load in request.loads), wave_cell, fit_cells)
    return section_mesh(request.body, size, half_section=request.body.symmetric)


def strips(patches: Iterable[Patch]) -> Array:
    """Ends [mm] of the strips of s under patches, without repetitions, shape (n, 2)."""
    return np.unique([[patch.s - patch.b, patch.s + patch.b] for patch in patches], axis=0)


# --- the wavenumbers of a section, in threads or processes ---

UNKNOWNS_FOR_PROCESSES = 25_000  # of a section, from which on processes are faster
MOST_PROCESSES = 8  # each has equations of its own, hundreds of MB
AT_ONCE = 4  # wavenumbers that a process solves before it takes others


def processes_for(unknowns: int, workers: int) -> int:
    """Return how many processes solve the wavenumbers of a section; 1 is this process, with its threads."""
    return min(workers, MOST_PROCESSES) if unknowns >= UNKNOWNS_FOR_PROCESSES else 1


@dataclass(frozen=True, eq=False)
class SectionWork:
    """A section with loads, and observers at arc lengths s [mm], whose wavenumbers are solved.

    Solutions have responses (share, load, 3, len(s)), with the far arc at some `shares` of its radius; from
    `cutoff_wavenumber` [1/mm] on with the far arc at the first of them only. They are taken from the `cache`
    where it has them, and kept there; `kind` begins their names in it.
    """

    section: SectionMesh
    loads: tuple[Load, ...]
    s: Array
    cache: StoredWaves
    kind: str = ""
    shares: tuple[float, ...] = (1.0,)
    cutoff_wavenumber: float = 0.0

    @cached_property
    def equations(self) -> SectionSolver:
        """The prepared equations."""
        return SectionSolver(self.section, self.loads, self.s, self.shares)

    @cached_property
    def _in_each_process(self) -> Prepared[Sequence[float], tuple[list[WaveSolution], int, float]]:
        return Prepared(partial(replace, self))

    def __call__(self, k: Sequence[float]) -> tuple[list[WaveSolution], int, float]:
        """Solve a group of wavenumbers [1/mm], all on one side of `cutoff_wavenumber`.

        Returns the solutions, the number of this process, and its peak memory so far [MB].
        """
        names = {one: f"{self.kind}k{float(one)!r}" for one in k}
        found = {one: self.cache.get(name) for one, name in names.items()}
        missing = [one for one, solution in found.items() if solution is None]
        shares = self.shares if min(k) < self.cutoff_wavenumber else self.shares[:1]
        with one_blas_thread():
            for batch in in_parts(missing, self.equations.batch_size, workers=1) if missing else ():
                responses, residuals = self.equations(batch, shares)
                for one, *solution in zip(batch, responses, residuals.tolist(), strict=True):
                    found[one] = solution[0], solution[1]
                    self.cache.put(names[one], (solution[0], solution[1]))
        return [solution for solution in found.values() if solution], os.getpid(), peak_memory()

    def solve(
        self, k: Sequence[float], workers: int, processes: Processes | None = None
    ) -> Iterator[tuple[list[WaveSolution], int, float]]:
        """Solve growing wavenumbers [1/mm] in threads, or in processes, group by group in their order."""
        at_once = AT_ONCE if processes else self.equations.batch_size
        below = [one for one in k if one < self.cutoff_wavenumber]
        sides = below, [one for one in k if one >= self.cutoff_wavenumber]
        groups = [group for side in sides for group in in_parts(side, at_once, workers)]
        return processes(self._in_each_process, groups) if processes else in_threads(self, groups, workers)


# --- responses ---

Progress = Callable[[int], None]  # takes the number of solutions so far, 0 after the assembly


def solve(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    *,
    workers: int = 1,
    progress: Progress = lambda _: None,
    cache: StoredWaves = NOT_STORED,
) -> Responses:
    """Mesh, assemble, and solve the wavenumbers in parallel, then some of them with coarser cells.

    Raises NotConverged if the section has more than `most_unknowns`, or if a wavenumber cannot be solved to
    a small residual. The worst residual is part of the cost. `cache` has the wavenumbers that an earlier
    run has solved, and takes the new ones.
    """
    seconds = dict.fromkeys(("mesh", "assembly", "solution"), 0.0)
    residuals: list[float] = []  # of all solutions so far, cached ones included
    memory: dict[int, float] = {}  # peak memory by process [MB]

    @contextmanager
    def timed(stage: str) -> Iterator[None]:
        start = perf_counter()
        yield
        seconds[stage] += perf_counter() - start

    def prepare(request: HarmonicRequest, *arcs: Any) -> SectionWork:
        """Mesh a section, and assemble it where threads share it; processes do so while they solve."""
        with timed("mesh"):
            section = build_section(request)
        if most_unknowns is not None and section.unknowns > most_unknowns:
            raise NotConverged(
                f"a section needs {section.unknowns:,} unknowns, `most_unknowns` = {most_unknowns:,}: give a "
                "larger `tolerance`, larger cells (`growth`) or a larger `most_unknowns`"
            )
        work = SectionWork(section, request.loads, request.observed, cache, *arcs)
        if processes_for(section.unknowns, workers) == 1:
            with timed("assembly"):
                assert work.equations
        return work

    def solve_waves(work: SectionWork, k: Sequence[float]) -> list[Array]:
        responses = []
        n = processes_for(work.section.unknowns, workers)
        solved = work.solve(k, n, processes) if n > 1 else work.solve(k, workers)
        for solutions, process, peak in solved:
            memory[process] = peak
            for response, residual in solutions:
                responses.append(response)
                residuals.append(residual)
                progress(len(residuals))
        return responses

    with one_blas_thread(), Processes(min(workers, MOST_PROCESSES)) as processes:
        work = prepare(request, "", request.shares, request.cutoff_wavenumber)
        progress(0)

        def both_arcs(k: Sequence[float]) -> list[Array]:
            """One solution serves both where the far arc has no effect, and where an outline leaves none."""
            return [np.repeat(r, 2, axis=0) if len(r) == 1 else r for r in solve_waves(work, k)]

        with timed("solution"):
            a = min(load.patch.a for load in request.loads)
            samples = sample(request.axis, both_arcs, odd_in_k(request.loads), a, request.accuracy)
        coarser_work = prepare(request.coarser, "coarser_")
        with timed("solution"):
            coarser = np.concatenate(solve_waves(coarser_work, samples.sparser.k.tolist()))
    mesh, solver = work.section.mesh, f"direct, {len(samples.k)} wavenumbers"
    total_memory = sum((memory | {os.getpid(): peak_memory()}).values())
    cost = Cost(work.section.unknowns, int(mesh.nelements), solver, (), max(residuals), seconds, total_memory)
    drawn = mesh.p[:, : mesh.nvertices], mesh.t
    return Responses(request.body, request.loads, request.observed, samples, coarser, cost, drawn)


def solve_task(task: Task, options: RunOptions) -> Solved:
    """Return the model of a task from the store, or solve it and put it there.

    A model that an interrupted run has begun continues after its last finished wavenumber.
    """
    stored = stored_model(task.request, options.store)
    if stored is not None:
        return Solved(task, stored, cached=True)
    request = with_unit_modulus(task.request)
    options.watch.on_step(Step(task, "mesh and assembly"))
    try:
        samples = expected_samples(request)
        expected = len(samples.k) + len(samples.sparser.k)
    except NotConverged:  # for the half-space; the body may still converge
        expected = None
    responses = solve(
        request,
        task.most_unknowns,
        workers=options.workers,
        progress=lambda solved: options.watch.on_step(Step(task, "wavenumbers", solved, expected)),
        cache=StoredWaves(options.store, model_key(request, options.store)),
    )
    store_model(responses, request, options.store)
    return Solved(task, requested_part(responses, task.request), cached=False)


# --- expected wavenumbers ---

OBSERVERS = 60  # about as many observers are taken
DISTANCE_DIGITS = 6  # of distances in half-widths: distances that agree in these are evaluated once


def expected_samples(request: HarmonicRequest) -> Samples:
    """The half-space's samples for a request, some observers; raises NotConverged where `sample` does.

    The half-space's k is sqrt(k^2 + 1 / L^2) with the far radius L: as with a far arc, responses are finite
    at k = 0.
    """
    loads, observed, body = request.loads, request.observed, request.body
    chosen = slice(None, None, max(1, len(observed) // OBSERVERS))
    accuracy = np.broadcast_to(request.accuracy, (len(loads), 1, len(observed)))[..., chosen]
    directions = np.array([load.direction for load in loads])
    distances = np.stack([observed[chosen] - load.patch.s for load in loads])  # (load, observer)
    half_width = np.broadcast_to([[load.patch.b] for load in loads], distances.shape)
    pairs = np.stack([half_width, distances], axis=-1).reshape(-1, 2) / (unit := np.min(half_width))
    distinct_pairs, number = np.unique(pairs.round(DISTANCE_DIGITS), axis=0, return_inverse=True)
    number = number.reshape(distances.shape)[:, None]
    half_space = HalfSpace(one_body(body.material, body.side))

    def respond(wavenumbers: Sequence[float]) -> list[Array]:
        """Responses [mm^2/N], (load, 3, observer) each."""
        k = np.hypot(np.array(wavenumbers), 1 / body.domain.far_radius)
        distinct = np.stack([half_space_response(half_space, b, d, k) for b, d in unit * distinct_pairs])
        responses = distinct[number, np.arange(3)[:, None], directions[:, None, None]]
        return list(np.moveaxis(responses, -1, 0))

    odd = SINES[:, directions].T[..., None]
    return sample(request.axis, respond, odd, min(load.patch.a for load in loads), accuracy)


# --- expected cost ---

FACTOR, FACTOR_GROWTH = 0.28 / 45_700**1.1, 1.1  # seconds of a wavenumber: factor and exponent of unknowns
BY_THREADS, BY_PROCESSES = 0.8, 0.95  # speed-up over the number of workers
START, PER_UNKNOWN = 0.1, 2e-5  # seconds of mesh and assembly: in any case, and per unknown
START_OF_PROCESSES = 1.0  # seconds
MEMORY, MEMORY_OF_PROCESS = 0.012, 0.006  # MB per unknown: in this process, or in each of several


def expected_cost(request: HarmonicRequest, workers: int) -> ExpectedCost:
    """The expected unknowns, wavenumbers, seconds and memory of a model."""
    section, coarser_section = build_section(request), build_section(request.coarser)
    unknowns, coarser = section.unknowns, coarser_section.unknowns
    half_section = section.half_section
    loads = {
        (abs(load.patch.s) if half_section else load.patch.s, load.patch.b, load.direction)
        for load in request.loads
    }
    samples = expected_samples(request)

    def solution(unknowns: int) -> float:
        """Seconds that a wavenumber takes."""
        processes = processes_for(unknowns, workers)
        speed_up = BY_PROCESSES * processes if processes > 1 else max(1.0, BY_THREADS * workers)
        return FACTOR * unknowns**FACTOR_GROWTH / speed_up

    seconds = 2 * START + PER_UNKNOWN * (unknowns + coarser)
    seconds += len(samples.k) * solution(unknowns) + len(samples.sparser.k) * solution(coarser)
    memory, processes = BASE_MEMORY + MEMORY * unknowns, processes_for(unknowns, workers)
    if processes > 1:
        seconds += START_OF_PROCESSES
        memory = BASE_MEMORY + processes * (BASE_MEMORY + MEMORY_OF_PROCESS * unknowns)
    return ExpectedCost(unknowns, len(samples.k), len(loads), half_section, float(seconds), memory)
