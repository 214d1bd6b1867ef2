"""Benchmark of both engines side by side: seconds, memory, estimates (docs/evidence/performance.md).

    python benchmarks/engines.py [tolerance of the harmonic engine ...] [--record]

1. Both geometries, all six components of both bodies with estimates, on two cores, each row of the harmonic
   engine in a fresh process: wall seconds of all models, the largest model, memory, the worst estimate, how
   far the harmonic engine is from the solid one, and the ratio of the seconds. The solid engine runs with
   multigrid and, where it is installed, with the direct solver.
2. How the cost of a harmonic model grows with its cells and with its domain.
"""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from time import perf_counter

import numpy as np
from tables import Record, arguments, print_table

from femic.reference.harmonic.engine import solve
from femic.reference.job import component_of
from femic.reference.run_options import Level, RunOptions
from femic.reference.solid import pardiso
from femic.results.ics import Results, compute, jobs, refinement_shares
from femic.scenes.load import load_scene

BODIES = ("lower", "upper")
GEOMETRIES = ("geometry1", "geometry2")
ENGINES = (
    "scene",
    "engine",
    "tolerance",
    "time [s]",
    "speed over solid, multigrid",
    "unknowns",
    "memory [MB]",
    "estimated error",
    "difference from the solid engine",
)
GROWTH = (
    "cells ×",
    "domain ×",
    "unknowns",
    "wavenumbers, fine and coarser",
    "time [s]",
    "per wavenumber [ms]",
)
OF_ENGINES = Record(
    "engines.engines",
    "Both engines",
    "C of both bodies, all six components with estimated errors, on three lines. Estimated error and "
    "difference are the largest of any component, divided by the scale of refinement. Unknowns are "
    "those of the largest model, memory is the peak of all processes together.",
    "python benchmarks/engines.py",
)
OF_GROWTH = Record(
    "engines.growth",
    "Growth of a harmonic model",
    "Geometry 1, lower body, with the coarser section of the estimate.",
    "python benchmarks/engines.py",
)


def run(name: str, **engine: object) -> tuple[Results, float]:
    """Return the results of a scene, and their seconds."""
    scene = load_scene(name, {"engine": {"check": False, **engine}})
    start = perf_counter()
    results = compute(scene, RunOptions(2))
    return results, perf_counter() - start


def run_harmonic(name: str, tolerance: float) -> tuple[dict[str, np.ndarray], tuple[str, ...], float]:
    """Return C of both bodies by the harmonic engine, what `described` says, and the seconds."""
    results, seconds = run(name, kind="harmonic", tolerance=tolerance)
    return {body: results.references[body].c.ic for body in BODIES}, described(results), seconds


def worst_share(results: Results, deviations: dict[str, np.ndarray]) -> float:
    """Return largest share of the scale of refinement over both bodies, lines and components."""
    return max(
        component_of(share, c)
        for body in BODIES
        for share in refinement_shares(results, body, deviations[body]).values()
        for c in results.scene.components
    )


def engine_rows(tolerances: list[float]) -> Iterator[list[object]]:
    for name in GEOMETRIES:
        solid, took = run(name, kind="solid", tolerance=0.01, solver="multigrid")
        yield [name, "solid, multigrid", 0.01, f"{took:.0f}", 1, *described(solid), ""]
        if pardiso.available():
            direct, seconds = run(name, kind="solid", tolerance=0.01, solver="direct")
            ratio = f"{took / seconds:.1f}"
            yield [name, "solid, direct", 0.01, f"{seconds:.0f}", ratio, *described(direct), ""]
        for tolerance in tolerances:
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh:
                ics, numbers, seconds = fresh.submit(run_harmonic, name, tolerance).result()
            deviations = {body: ics[body] - solid.references[body].c.ic for body in BODIES}
            apart, ratio = f"{worst_share(solid, deviations):.2%}", f"{took / seconds:.1f}"
            yield [name, "harmonic", f"{tolerance:g}", f"{seconds:.0f}", ratio, *numbers, apart]


def described(results: Results) -> tuple[str, str, str]:
    """Return unknowns of the largest model, memory, worst estimate of the results."""
    models = [cost for body in BODIES for cost in results.references[body].models.values()]
    estimate = worst_share(results, {body: results.references[body].c.estimate for body in BODIES})
    return (
        f"{max(m.unknowns for m in models):,}",
        f"{max(m.peak_memory for m in models):.0f}",
        f"{estimate:.2%}",
    )


def growth_rows() -> Iterator[list[object]]:
    request = jobs(load_scene("geometry1"))["lower"].request(Level())
    for cells, domain in ((1.0, 1.0), (0.7, 1.0), (0.5, 1.0), (0.35, 1.0), (1.0, 4.0), (1.0, 16.0)):
        body = replace(request.body, domain=request.body.domain.scaled(domain))
        solved = solve(replace(request, cells=request.cells.scaled(cells), body=body), workers=2)
        cost, fine, coarser = solved.cost, len(solved.samples.k), len(solved.coarser)
        seconds, per_wave = sum(cost.seconds.values()), cost.seconds["solution"] / (fine + coarser)
        yield [
            f"{cells:g}",
            f"{domain:g}",
            f"{cost.unknowns:,}",
            f"{fine}, {coarser}",
            f"{seconds:.1f}",
            f"{1000 * per_wave:.0f}",
        ]


if __name__ == "__main__":
    chosen = [float(value) for value in arguments()] or [0.01, 0.001, 0.0001]
    print_table(ENGINES, engine_rows(chosen), record=OF_ENGINES)
    print_table(GROWTH, growth_rows(), record=OF_GROWTH)
