"""Benchmark of the solution of a wavenumber: milliseconds by threads, processes, SuperLU.

    python benchmarks/elimination.py [--record]

Sections of Geometry 2 at tolerance 0.001, under one load and under all strips of a grid: milliseconds per
wavenumber, with all responses and their residuals, by one thread, by two, and by two processes; and of
SuperLU (SciPy) for the factors of K alone, in the same order, which a route by sparse factors would need
besides.
"""

from collections.abc import Callable, Iterator
from functools import partial
from time import perf_counter

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu
from tables import Record, arguments, print_table

from femic.cache.workers import Prepared, Processes, in_threads, one_blas_thread
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.engine import AT_ONCE, build_section
from femic.reference.harmonic.section import SectionMesh, assemble
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.run_options import Level
from femic.results.ics import jobs
from femic.results.matrices import SOURCE, matrix_jobs
from femic.scenes.load import load_scene

WAVENUMBERS = np.geomspace(0.01, 3.0, 16).tolist()  # [1/mm]
REPEATED = 3
GRID = {"n_s": 64, "n_x": 128}
COLUMNS = (
    "section",
    "unknowns",
    "1 thread [ms]",
    "2 threads [ms]",
    "2 processes [ms]",
    "SuperLU, K alone, 1 thread [ms]",
    "SuperLU over 1 thread",
)
RECORD = Record(
    "elimination.wavenumber",
    "One wavenumber",
    "Time per wavenumber with all responses and their residuals, beside SuperLU (SciPy) for the factors "
    "of K alone.",
    "python benchmarks/elimination.py",
)


def milliseconds(work: Callable[[], object]) -> float:
    """Return the least milliseconds per wavenumber of some work on all of them."""
    runs = []
    for _ in range(REPEATED):
        start = perf_counter()
        work()
        runs.append(perf_counter() - start)
    return 1e3 * min(runs) / len(WAVENUMBERS)


def by_threads(solver: SectionSolver, workers: int) -> float:
    """Return milliseconds per wavenumber in threads."""
    parts = in_parts(WAVENUMBERS, solver.batch_size, workers)
    return milliseconds(lambda: list(in_threads(solver, parts, workers)))


def by_processes(prepare: Callable[[], SectionSolver], workers: int) -> float:
    """Return milliseconds per wavenumber in processes that have prepared the equations."""
    each, parts = Prepared(partial(on_one_thread, prepare)), in_parts(WAVENUMBERS, AT_ONCE, workers)
    with Processes(workers) as processes:
        return milliseconds(lambda: list(processes(each, parts)))


def on_one_thread(prepare: Callable[[], SectionSolver]) -> Callable[[list[float]], object]:
    """Return a prepared solver that uses one BLAS thread, as femic's own processes do."""
    solver = prepare()

    def at(wavenumbers: list[float]) -> object:
        with one_blas_thread():
            return solver(wavenumbers)

    return at


def by_superlu(solver: SectionSolver, section: SectionMesh) -> float:
    """Return milliseconds per wavenumber for factors of K of the free amplitudes, in the same order."""
    model, amplitudes = assemble(section), solver._shared[0][0].elimination.amplitudes
    of_cells = (3 * model.cells[:, :, None] + np.arange(3)).reshape(len(model.cells), -1)
    place = np.full(3 * section.mesh.doflocs.shape[1], -1)
    place[amplitudes] = np.arange(len(amplitudes))
    shape = model.cell_matrices[0].shape
    rows, columns = (
        place[np.broadcast_to(part, shape).ravel()] for part in (of_cells[:, :, None], of_cells[:, None])
    )
    free = (rows >= 0) & (columns >= 0)
    k0, k1, k2 = (
        csc_array(coo_array((part.ravel()[free], (rows[free], columns[free])), shape=(len(amplitudes),) * 2))
        for part in model.cell_matrices
    )

    def factored() -> None:
        for k in WAVENUMBERS:
            splu(
                (k0 + k * k1 + k**2 * k2).tocsc(),
                permc_spec="NATURAL",
                panel_size=1,
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )

    return milliseconds(factored)


def rows() -> Iterator[list[object]]:
    """Yield a row for each section."""
    engine = {"check": False, "tolerance": 1e-3}
    single = jobs(load_scene("geometry2", {"engine": engine}))
    on_grid = matrix_jobs(load_scene("geometry2", {"grid": GRID, "engine": engine}), further=(SOURCE,))
    for kind, of_bodies in (("one load", single), (f"{GRID['n_s']} × {GRID['n_x']}", on_grid)):
        for body, job in of_bodies.items():
            request = job.request(Level())
            section = build_section(request)
            prepare = partial(SectionSolver, section, request.loads, request.observed, request.shares)
            solver = prepare()
            alone, both = (by_threads(solver, workers) for workers in (1, 2))
            processes, superlu = by_processes(prepare, 2), by_superlu(solver, section)
            unknowns = 3 * section.mesh.doflocs.shape[1]
            times = f"{alone:.0f}", f"{both:.0f}", f"{processes:.0f}", f"{superlu:.0f}"
            yield [f"{body}, {kind}", f"{unknowns:,}", *times, f"{superlu / alone:.1f}"]


if __name__ == "__main__":
    arguments()
    with one_blas_thread():
        print_table(COLUMNS, rows(), record=RECORD)
