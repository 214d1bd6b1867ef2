"""The harmonic engine: responses of one body to unit strip loads, one section problem per wavenumber.

The section of a body is the same everywhere along x (round its axis). A load that varies as cos(k x) causes
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x), where U, V, W are amplitudes on the section
(`section_model`). For a load along x sines and cosines are exchanged: its K is K(-k), which is K(k) with the
sign of U changed. So one factorisation per wavenumber serves all loads. On a closed body of revolution k = m
/ R_roll. Sections that are their own mirror image are halved, with even and odd fields. `synthesis` computes
displacements anywhere along x from the responses. Theory: docs/theory/reference.md.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from femic.cache.threads import in_threads, one_blas_thread
from femic.reference.accuracy import NotConverged
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.entry import NOT_STORED, StoredWaves, WaveSolution
from femic.reference.harmonic.request import COLUMNS_NEED, HarmonicRequest
from femic.reference.harmonic.section import SectionMesh, section_mesh
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.harmonic.section_size import FitCells, SectionSize
from femic.reference.harmonic.synthesis import Responses, odd_in_k
from femic.reference.harmonic.wavenumbers import Samples, sample
from femic.reference.models import Cost, peak_memory
from geometries.arrays import Array
from geometries.patches import Patch

FINER = 5.0  # the cells at the patches where M is fitted are this much smaller
FINER_GROWTH, FINER_BEHIND = 0.6, 24.0  # their growth over growth, and up to where (half-sides): `FitCells`
WAVE_CELLS = 4.0  # longest cell on a strip times the largest wavenumber, over growth
CENTRE_WAVE_CELLS = 17.5  # like `WAVE_CELLS`, where displacements are read at the centres of strips only

Progress = Callable[[int], None]  # takes the number of solutions so far, 0 after the assembly


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


def solve(
    request: HarmonicRequest,
    most_unknowns: int | None = None,
    *,
    workers: int = 1,
    progress: Progress = lambda _: None,
    cache: StoredWaves = NOT_STORED,
) -> Responses:
    """Mesh, assemble, and solve the wavenumbers in parallel threads.

    Raises NotConverged if the section has more than `most_unknowns`, or if a wavenumber cannot be solved to
    a small residual. The worst residual is part of the cost. `cache` has the wavenumbers that an earlier
    run has solved, and takes the new ones.
    """
    builder = _SectionBuilder(most_unknowns)
    solutions = _WaveSolutions(workers, progress, cache)
    with one_blas_thread():
        section, samples = _sampled(request, builder, solutions)
        coarser = _with_coarser_cells(request, builder, solutions, samples.sparser.k)
    unknowns, cells = 3 * section.mesh.doflocs.shape[1], int(section.mesh.nelements)
    solver = f"direct, {len(samples.k)} wavenumbers"
    cost = Cost(unknowns, cells, solver, (), max(solutions.residuals), builder.seconds, peak_memory())
    drawn = section.mesh.p[:, : section.mesh.nvertices], section.mesh.t
    return Responses(request.body, request.loads, request.observed, samples, coarser, cost, drawn)


def _sampled(
    request: HarmonicRequest, builder: "_SectionBuilder", solutions: "_WaveSolutions"
) -> tuple[SectionMesh, Samples]:
    """The section of a request, and its responses (k, 2, load, 3, len(s)) with both far arcs."""
    section, respond = builder.of(request, request.shares)
    solutions.progress(0)

    def both_arcs(k: Sequence[float]) -> list[WaveSolution]:
        return _with_both_arcs(request, respond, k)

    def responses_at(wavenumbers: Sequence[float]) -> list[Array]:
        felt = [k for k in wavenumbers if k < request.felt]
        groups = felt, [k for k in wavenumbers if k >= request.felt]
        return solutions.at("", both_arcs, groups, respond.together)

    with builder.timed("solution"):
        a = min(load.patch.a for load in request.loads)
        return section, sample(request.axis, responses_at, odd_in_k(request.loads), a, request.accuracy)


def _with_coarser_cells(
    request: HarmonicRequest, builder: "_SectionBuilder", solutions: "_WaveSolutions", wavenumbers: Array
) -> Array:
    """The responses (k, load, 3, len(s)) with coarser cells at wavenumbers [1/mm]."""
    _, respond = builder.of(request.coarser, (1.0,))

    def at_arc(k: Sequence[float]) -> list[WaveSolution]:
        responses, residuals = respond(k)
        return list(zip(responses, residuals.tolist(), strict=True))

    with builder.timed("solution"):
        return np.concatenate(solutions.at("coarser_", at_arc, [wavenumbers.tolist()], respond.together))


@dataclass(eq=False)
class _SectionBuilder:
    """Meshes and assembles sections, and adds up the seconds of each stage."""

    most_unknowns: int | None
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("mesh", "assembly", "solution"), 0.0)
    )

    def of(self, request: HarmonicRequest, shares: Sequence[float]) -> tuple[SectionMesh, SectionSolver]:
        """The section of a request and its equations, with the far arc at some shares of its radius."""
        with self.timed("mesh"):
            section = build_section(request)
        unknowns = 3 * section.mesh.doflocs.shape[1]
        if self.most_unknowns is not None and unknowns > self.most_unknowns:
            raise NotConverged(
                f"a section needs {unknowns:,} unknowns, `most_unknowns` = {self.most_unknowns:,}: give a "
                "larger `tolerance`, larger cells (`growth`) or a larger `most_unknowns`"
            )
        with self.timed("assembly"):
            return section, SectionSolver(section, request.loads, request.observed, shares)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the seconds that a block takes to those of a stage."""
        start = perf_counter()
        yield
        self.seconds[stage] += perf_counter() - start


@dataclass(eq=False)
class _WaveSolutions:
    """Solves wavenumbers, a few at once and in parallel threads, or takes their solutions from a cache."""

    workers: int
    progress: Progress
    cache: StoredWaves
    residuals: list[float] = field(default_factory=list)  # of all solutions so far, cached ones included

    def at(
        self,
        kind: str,
        respond: Callable[[Sequence[float]], list[WaveSolution]],
        groups: Iterable[Sequence[float]],
        together: int,
    ) -> list[Array]:
        """Return the responses at groups of wavenumbers [1/mm], in their order.

        No two groups are solved together, and no more than `together` of one. `kind` begins the names of
        their solutions.
        """
        parts = [part for group in groups for part in in_parts(group, together, self.workers)]
        all_responses = []
        for solutions in in_threads(lambda part: self._solutions(kind, respond, part), parts, self.workers):
            for responses, residual in solutions:
                all_responses.append(responses)
                self.residuals.append(residual)
                self.progress(len(self.residuals))
        return all_responses

    def _solutions(
        self, kind: str, respond: Callable[[Sequence[float]], list[WaveSolution]], k: Sequence[float]
    ) -> list[WaveSolution]:
        """The solutions at some wavenumbers [1/mm], of which those are solved that are not stored."""
        names = {one: f"{kind}k{float(one)!r}" for one in k}
        stored = {one: self.cache.get(name) for one, name in names.items()}
        missing = [one for one, solution in stored.items() if solution is None]
        solved = dict(zip(missing, respond(missing) if missing else (), strict=True))
        for one, solution in solved.items():
            self.cache.put(names[one], solution)
        return [solved[one] if found is None else found for one, found in stored.items()]


def _with_both_arcs(
    request: HarmonicRequest, respond: SectionSolver, k: Sequence[float]
) -> list[WaveSolution]:
    """Responses (2, load, 3, len(s)) with both far arcs at wavenumbers [1/mm], and the worse residuals.

    Beyond `request.felt` the far arc has no effect on any of them, and an outline has none: one solution
    serves both.
    """
    shares = request.shares if min(k) < request.felt else request.shares[:1]
    responses, residuals = respond(k, shares)
    both = responses if len(shares) > 1 else np.repeat(responses, 2, axis=1)
    return list(zip(both, residuals.tolist(), strict=True))
