"""Benchmark of the solution of a wavenumber: print a table of docs/evidence/performance.md as Markdown.

    python benchmarks/elimination.py

Sections of Geometry 2 at tolerance 0.001, under one load and under all strips of a grid: milliseconds per
wavenumber, with all responses and their residuals, by one and by two threads; and of SuperLU (SciPy) for the
factors of K alone, in the same order, which a route by sparse factors would need besides.
"""

from collections.abc import Callable, Iterator, Sequence
from time import perf_counter

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu
from tables import print_table

from compare.ics.compute import jobs
from compare.matrix.jobs import matrix_jobs
from femic.cache.threads import in_threads, one_blas_thread
from femic.reference.harmonic.elimination import in_parts
from femic.reference.harmonic.engine import build_section
from femic.reference.harmonic.section_model import assemble
from femic.reference.harmonic.section_response import SectionSolver
from femic.reference.level import Level
from femic.scenes.load import load_scene

WAVENUMBERS = np.geomspace(0.01, 3.0, 16).tolist()  # [1/mm]
REPEATED = 3
GRID = {"n_s": 64, "n_x": 128}
COLUMNS = ("section", "unknowns", "1 thread: ms", "2 threads: ms", "SuperLU, K alone, 1 thread: ms", "ratio")


def milliseconds(work: Callable[[list[float]], object], together: int, workers: int) -> float:
    """Return the least milliseconds per wavenumber."""
    parts = in_parts(WAVENUMBERS, together, workers)
    runs = []
    for _ in range(REPEATED):
        start = perf_counter()
        list(in_threads(work, parts, workers))
        runs.append(perf_counter() - start)
    return 1e3 * min(runs) / len(WAVENUMBERS)


def by_superlu(solver: SectionSolver, section) -> Callable[[Sequence[float]], None]:
    """Return a function that factors K of the free amplitudes, in the order of elimination."""
    model, amplitudes = assemble(section), solver._shared[0].condensation.elimination.amplitudes
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

    def factored(wavenumbers: Sequence[float]) -> None:
        for k in wavenumbers:
            splu(
                (k0 + k * k1 + k**2 * k2).tocsc(),
                permc_spec="NATURAL",
                panel_size=1,
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )

    return factored


def rows() -> Iterator[list[object]]:
    """Yield a row for each section."""
    engine = {"check": False, "tolerance": 1e-3}
    single = jobs(load_scene("geometry2", {"engine": engine}))
    on_grid = matrix_jobs(load_scene("geometry2", {"grid": GRID, "engine": engine}))
    for kind, of_bodies in (("one load", single), (f"{GRID['n_s']} × {GRID['n_x']}", on_grid)):
        for body, job in of_bodies.items():
            request = job.request(Level())
            section = build_section(request)
            solver = SectionSolver(section, request.loads, request.observed, request.shares)
            alone, both = (milliseconds(solver, solver.together, workers) for workers in (1, 2))
            superlu = milliseconds(by_superlu(solver, section), len(WAVENUMBERS), 1)
            unknowns = 3 * section.mesh.doflocs.shape[1]
            cells = f"{alone:.0f}", f"{both:.0f}", f"{superlu:.0f}", f"{superlu / alone:.1f}"
            yield [f"{body}, {kind}", f"{unknowns:,}", *cells]


if __name__ == "__main__":
    with one_blas_thread():
        print_table(COLUMNS, rows())
