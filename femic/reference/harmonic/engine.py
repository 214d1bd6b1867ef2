"""The harmonic engine: responses of one body to unit strip loads, one section problem per wavenumber.

The section of a body is the same everywhere along x (round its axis). A load that varies as cos(k x) causes
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), where U, V, W are amplitudes on the section
(`femic.reference.harmonic.section_model`). For a load along x sines and cosines are exchanged: its K is
K(-k), which is K(k) with the sign of U changed. So one factorisation per wavenumber serves all loads. On a
closed body of revolution k = m / R_roll. Sections that are their own mirror image are halved, with even and
odd fields. `femic.reference.harmonic.synthesis` computes displacements anywhere along x from the responses.
Theory: docs/theory/reference.md.

Models are solved one after the other, each in parallel, and stored. Their cost is known before: the section
is meshed, and its wavenumbers are counted on a half-space under the same loads, which takes a second. The
responses of the half-space are known in closed form, so the search for its wavenumbers takes no mesh and a
tenth of a second. On a plane it finds the same wavenumbers; on curved bodies it finds about four fifths as
many (measured). Seconds and memory follow laws that were fitted on one machine of 2 cores
(docs/how-to/matrix.md): their ratios are more reliable than their values.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from time import perf_counter

import numpy as np

from approx.halfspace import HalfSpace
from femic.cache.workers import Processes, one_blas_thread
from femic.reference.engine import BASE_MEMORY, Cost, ExpectedCost, peak_memory
from femic.reference.harmonic.request import COLUMNS_NEED, HarmonicRequest
from femic.reference.harmonic.section import FitCells, SectionMesh, SectionSize, section_mesh
from femic.reference.harmonic.section_work import MOST_PROCESSES, SectionWork, Solver, processes_for
from femic.reference.harmonic.stored import (
    NOT_STORED,
    StoredWaves,
    model_key,
    requested_part,
    store_model,
    stored_model,
    with_unit_modulus,
)
from femic.reference.harmonic.synthesis import Responses, odd_in_k
from femic.reference.harmonic.wavenumbers import Samples, sample
from femic.reference.harmonic.waves import SINES, half_space_response
from femic.reference.job import NotConverged
from femic.reference.run_options import RunOptions, Solved, Step, Task
from geometries.arrays import Array
from geometries.materials import one_body
from geometries.patches import Patch

# --- the section ---

FINER = 5.0  # the cells at the patches where M is fitted are this much smaller
FINER_GROWTH, FINER_BEHIND = 0.6, 24.0  # their growth over growth, and up to where (half-sides): `FitCells`
WAVE_CELLS = 4.0  # longest cell on a strip times the largest wavenumber, over growth
CENTRE_WAVE_CELLS = 17.5  # like `WAVE_CELLS`, where displacements are read at the centres of strips only


def build_section(request: HarmonicRequest) -> SectionMesh:
    """Mesh the section of a request, half of it where the contour is symmetric."""
    half_section = request.body.symmetric
    cells = request.cells
    wave_cell = WAVE_CELLS * cells.growth / request.k_max
    if request.even_strips:
        k_of_columns = COLUMNS_NEED * request.k_max
        wave_cell = min(cells.smallest, CENTRE_WAVE_CELLS * cells.growth / k_of_columns)
    size = SectionSize(cells, strips(load.patch for load in request.loads), wave_cell, _fit_cells(request))
    return section_mesh(request.body, size, half_section=half_section)


def _fit_cells(request: HarmonicRequest) -> FitCells | None:
    """The cells round the patches where M is fitted, if there are any: finer than under strips as wide."""
    if not request.fit_patches:
        return None
    b = min(patch.b for patch in request.fit_patches)
    half_widths = [load.patch.b for load in request.loads if load.patch not in request.fit_patches]
    smallest = request.cells.smallest * b / min(half_widths, default=b)
    behind = FINER_BEHIND * max(patch.b for patch in request.fit_patches)
    growth = FINER_GROWTH * request.cells.growth
    return FitCells(strips(request.fit_patches), min(smallest, b) / FINER, growth, behind)


def strips(patches: Iterable[Patch]) -> Array:
    """Ends [mm] of the strips of s under patches, without repetitions, shape (n, 2)."""
    return np.unique([[patch.s - patch.b, patch.s + patch.b] for patch in patches], axis=0)


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
    """Mesh, assemble, and solve the wavenumbers in parallel.

    Raises NotConverged if the section has more than `most_unknowns`, or if a wavenumber cannot be solved to
    a small residual. The worst residual is part of the cost. `cache` has the wavenumbers that an earlier
    run has solved, and takes the new ones.
    """
    run = _Run(most_unknowns, workers, progress, cache)
    with one_blas_thread(), run.processes:
        section, samples = _sample(request, run)
        coarser = _with_coarser_cells(request, run, samples.sparser.k)
    unknowns, cells = 3 * section.mesh.doflocs.shape[1], int(section.mesh.nelements)
    solver = f"direct, {len(samples.k)} wavenumbers"
    memory = sum((run.memory | {os.getpid(): peak_memory()}).values())
    cost = Cost(unknowns, cells, solver, (), max(run.residuals), run.seconds, memory)
    drawn = section.mesh.p[:, : section.mesh.nvertices], section.mesh.t
    return Responses(request.body, request.loads, request.observed, samples, coarser, cost, drawn)


def _sample(request: HarmonicRequest, run: "_Run") -> tuple[SectionMesh, Samples]:
    """The section of a request, and its responses (k, 2, load, 3, len(s)) with both far arcs."""
    section = run.section(request)
    solver = run.solver(
        SectionWork(section, request.loads, request.observed, request.shares, request.cutoff_wavenumber)
    )
    run.progress(0)

    def both_arcs(wavenumbers: Sequence[float]) -> list[Array]:
        # one solution serves both where the far arc has no effect, and where an outline leaves it none
        return [
            responses if len(responses) > 1 else np.repeat(responses, 2, axis=0)
            for responses in run.solutions(solver, wavenumbers)
        ]

    with run.timed("solution"):
        a = min(load.patch.a for load in request.loads)
        return section, sample(request.axis, both_arcs, odd_in_k(request.loads), a, request.accuracy)


def _with_coarser_cells(request: HarmonicRequest, run: "_Run", wavenumbers: Array) -> Array:
    """The responses (k, load, 3, len(s)) with coarser cells at wavenumbers [1/mm]."""
    section = run.section(request.coarser)
    solver = run.solver(SectionWork(section, request.loads, request.observed, kind="coarser_"))
    with run.timed("solution"):
        return np.concatenate(run.solutions(solver, wavenumbers.tolist()))


@dataclass(eq=False)
class _Run:
    """Meshes sections and solves their wavenumbers; adds up seconds, residuals and memory."""

    most_unknowns: int | None
    workers: int
    progress: Progress
    cache: StoredWaves
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("mesh", "assembly", "solution"), 0.0)
    )
    residuals: list[float] = field(default_factory=list)  # of all solutions so far, cached ones included
    memory: dict[int, float] = field(default_factory=dict)  # peak memory by process [MB]

    @cached_property
    def processes(self) -> Processes:
        """The processes that solve large sections."""
        return Processes(min(self.workers, MOST_PROCESSES))

    def section(self, request: HarmonicRequest) -> SectionMesh:
        """The section of a request."""
        with self.timed("mesh"):
            section = build_section(request)
        unknowns = 3 * section.mesh.doflocs.shape[1]
        if self.most_unknowns is not None and unknowns > self.most_unknowns:
            raise NotConverged(
                f"a section needs {unknowns:,} unknowns, `most_unknowns` = {self.most_unknowns:,}: give a "
                "larger `tolerance`, larger cells (`growth`) or a larger `most_unknowns`"
            )
        return section

    def solver(self, work: SectionWork) -> Solver:
        """The solver of a section. Where processes assemble it, that time counts as solution."""
        processes = processes_for(work.unknowns, self.workers)
        if processes > 1:
            return work.in_processes(self.processes, processes, self.cache)
        with self.timed("assembly"):
            return work.in_threads(self.workers, self.cache)

    def solutions(self, solver: Solver, k: Sequence[float]) -> list[Array]:
        """Responses (share, load, 3, len(s)) at growing wavenumbers [1/mm], in their order."""
        responses = []
        for solved in solver(k):
            self.memory[solved.process] = solved.peak_memory
            for response, residual in solved.solutions:
                responses.append(response)
                self.residuals.append(residual)
                self.progress(len(self.residuals))
        return responses

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the seconds that a block takes to those of a stage."""
        start = perf_counter()
        yield
        self.seconds[stage] += perf_counter() - start


# --- models of tasks ---


def solve_tasks(tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
    """Solve models, and yield each when it is finished.

    A model that an interrupted run has begun continues after its last finished wavenumber.
    """
    for task in tasks:
        yield _solve_task(task, options)


def _solve_task(task: Task, options: RunOptions) -> Solved:
    """Return the model of a task from the store, or solve it and put it there."""
    stored = stored_model(task.request, options.store)
    if stored is not None:
        return Solved(task, stored, cached=True)
    request = with_unit_modulus(task.request)
    options.watch.on_step(Step(task, "mesh and assembly"))
    expected = _expected_solutions(request)
    responses = solve(
        request,
        task.most_unknowns,
        workers=options.workers,
        progress=lambda solved: options.watch.on_step(Step(task, "wavenumbers", solved, expected)),
        cache=StoredWaves(options.store, model_key(request, options.store)),
    )
    store_model(responses, request, options.store)
    return Solved(task, requested_part(responses, task.request), cached=False)


def _expected_solutions(request: HarmonicRequest) -> int | None:
    """Return the expected number of solutions, None if a half-space needs too many wavenumbers."""
    try:
        samples = expected_samples(request)
        return len(samples.k) + len(samples.sparser.k)
    except NotConverged:  # for the half-space; the body may still converge
        return None


# --- expected wavenumbers ---

OBSERVERS = 60  # about as many observers are taken
DISTANCE_DIGITS = 6  # of distances in half-widths: distances that agree in these are evaluated once


def expected_samples(request: HarmonicRequest) -> Samples:
    """The half-space's samples for a request, some observers; raises NotConverged where `sample` does."""
    loads, observed = request.loads, request.observed
    chosen = slice(None, None, max(1, len(observed) // OBSERVERS))
    accuracy = np.broadcast_to(request.accuracy, (len(loads), 1, len(observed)))[..., chosen]
    directions = [load.direction for load in loads]
    return sample(
        request.axis,
        _half_space(request, observed[chosen]),
        SINES[:, directions].T[..., None],
        min(load.patch.a for load in loads),
        accuracy,
    )


def _half_space(request: HarmonicRequest, s: Array) -> Callable[[Sequence[float]], list[Array]]:
    """A function from wavenumbers [1/mm] to the half-space's responses [mm^2/N], (load, 3, len(s)) each.

    It replaces k by sqrt(k^2 + 1 / L^2) with the far radius L: as with a far arc, responses are finite at
    k = 0.
    """
    loads, body = request.loads, request.body
    half_space = HalfSpace(one_body(body.material, body.side))
    distances = np.stack([s - load.patch.s for load in loads])  # (load, observer)
    half_width = np.broadcast_to([[load.patch.b] for load in loads], distances.shape)
    pairs = np.stack([half_width, distances], axis=-1).reshape(-1, 2) / (unit := np.min(half_width))
    distinct_pairs, pair_numbers = np.unique(pairs.round(DISTANCE_DIGITS), axis=0, return_inverse=True)
    direction = np.array([[load.direction] for load in loads])

    def responses(wavenumbers: Sequence[float]) -> list[Array]:
        k = np.hypot(np.array(wavenumbers), 1 / body.domain.far_radius)
        distinct_responses = np.stack(
            [half_space_response(half_space, b, d, k) for b, d in unit * distinct_pairs]
        )
        all_responses = distinct_responses[
            pair_numbers.reshape(distances.shape)[:, None], np.arange(3)[:, None], direction[..., None]
        ]
        return list(np.moveaxis(all_responses, -1, 0))  # (k, load, i, observer)

    return responses


# --- expected cost ---

FACTOR, FACTOR_GROWTH = 0.28 / 45_700**1.1, 1.1  # seconds of a wavenumber: factor and exponent of unknowns
BY_THREADS, BY_PROCESSES = 0.8, 0.95  # speed-up over the number of workers
START, PER_UNKNOWN = 0.1, 2e-5  # seconds of mesh and assembly: in any case, and per unknown
START_OF_PROCESSES = 1.0  # seconds
MEMORY, MEMORY_OF_PROCESS = 0.012, 0.006  # MB per unknown: in this process, or in each of several


def expected_cost(request: HarmonicRequest, workers: int) -> ExpectedCost:
    """The expected unknowns, wavenumbers, seconds and memory of a model."""
    section, coarser_section = build_section(request), build_section(request.coarser)
    unknowns, coarser = (3 * mesh.doflocs.shape[1] for mesh in (section.mesh, coarser_section.mesh))
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
