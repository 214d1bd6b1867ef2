"""Benchmark of both engines side by side: print the tables of docs/evidence/harmonic-engine.md as Markdown.

    python benchmarks/engines.py [tolerance of the harmonic engine ...]

1. Both geometries, all six components of both bodies with estimates, on two cores: wall seconds of all
   models, the largest model, memory, the worst estimate, how far the harmonic engine is from the solid one,
   and the ratio of the seconds. The solid engine runs with multigrid and, where it is installed, with the
   direct solver.
2. One body under 64 strips, all directions, with estimates: by the harmonic engine, and what the solid one
   would take, extrapolated from one load.
3. How the cost of a harmonic model grows with its cells and with its domain.
"""

import sys
from dataclasses import replace
from time import perf_counter

import numpy as np

from compare.ics.compute import Results, compute, jobs
from compare.ics.errors import refinement_shares_of
from compare.matrix.compute import matrix_jobs
from femic.reference.accuracy import component_of
from femic.reference.harmonic.engine import raw_ics
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.level import Level
from femic.reference.matrix.reference import matrices
from femic.reference.run_options import RunOptions
from femic.reference.solid import pardiso
from femic.scenes.load import load_scene

BODIES = ("lower", "upper")
GEOMETRIES = ("geometry1", "geometry2")
STRIPS = 64


def run(name: str, **engine: object) -> tuple[Results, float]:
    scene = load_scene(name, {"engine": {"check": False, **engine}})
    start = perf_counter()
    results = compute(scene, RunOptions(2))
    return results, perf_counter() - start


def worst_share(results: Results, deviations: dict[str, np.ndarray]) -> float:
    """Return largest share of the scale of refinement over both bodies, lines and components."""
    return max(
        component_of(share, c)
        for body in BODIES
        for share in refinement_shares_of(results, body, deviations[body]).values()
        for c in results.scene.components
    )


def table(*head: str) -> None:
    print(f"\n| {' | '.join(head)} |\n|{'---|' * len(head)}", flush=True)


def row(*cells: object) -> None:
    print(f"| {' | '.join(str(cell) for cell in cells)} |", flush=True)


def engines(tolerances: list[float]) -> None:
    table("scene", "engine", "tolerance", "s", "ratio", "unknowns", "MB", "estimate", "from the solid engine")
    for name in GEOMETRIES:
        solid, took = run(name, kind="solid", tolerance=0.01, solver="multigrid")
        row(name, "solid, multigrid", 0.01, f"{took:.0f}", 1, *described(solid), "")
        if pardiso.available():
            direct, seconds = run(name, kind="solid", tolerance=0.01, solver="direct")
            row(
                name, "solid, direct", 0.01, f"{seconds:.0f}", f"{took / seconds:.1f}", *described(direct), ""
            )
        for tolerance in tolerances:
            results, seconds = run(name, kind="harmonic", tolerance=tolerance)
            deviations = {b: results.references[b].c.ic - solid.references[b].c.ic for b in BODIES}
            apart, ratio = f"{worst_share(solid, deviations):.2%}", f"{took / seconds:.1f}"
            row(name, "harmonic", f"{tolerance:g}", f"{seconds:.0f}", ratio, *described(results), apart)


def described(results: Results) -> tuple[str, str, str]:
    """Return unknowns of the largest model, memory, worst estimate of the results."""
    models = [cost for body in BODIES for cost in results.references[body].models.values()]
    estimate = worst_share(results, {body: results.references[body].c.estimate for body in BODIES})
    return (
        f"{max(m.unknowns for m in models):,}",
        f"{max(m.peak_memory for m in models):.0f}",
        f"{estimate:.2%}",
    )


def many_loads() -> None:
    table(
        "scene, body",
        f"{STRIPS} strips, harmonic: s",
        "unknowns",
        "one load, solid: s",
        f"{STRIPS}, extrapolated: s",
        "ratio",
    )
    for name in GEOMETRIES:
        grid = {"grid": {"n_x": 3, "n_s": STRIPS}}
        job = matrix_jobs(load_scene(name, grid | {"engine": {"check": False, "tolerance": 0.01}}))["lower"]
        start = perf_counter()
        results = matrices({"lower": job}, RunOptions(2))["lower"]
        seconds = perf_counter() - start
        start = perf_counter()
        solid_scene = load_scene(
            name, {"bodies": ["lower"], "engine": {"kind": "solid", "check": False, "tolerance": 0.01}}
        )
        compute(solid_scene, RunOptions(2))
        one = perf_counter() - start
        unknowns = f"{results.models['fine'].unknowns:,}"
        cells = f"{seconds:.0f}", unknowns, f"{one:.0f}", f"{STRIPS * one:.0f}"
        row(f"{name}, lower", *cells, f"{STRIPS * one / seconds:.0f}")


def growth() -> None:
    table("cells ×", "domain ×", "unknowns", "wavenumbers", "s", "ms per wavenumber")
    request = jobs(load_scene("geometry1"))["lower"].request(Level())
    for cells, domain in ((1.0, 1.0), (0.7, 1.0), (0.5, 1.0), (0.35, 1.0), (1.0, 4.0), (1.0, 16.0)):
        body = replace(request.body, domain=request.body.domain.scaled(domain))
        timed(replace(request, cells=request.cells.scaled(cells), body=body), cells, domain)


def timed(request: HarmonicRequest, cells: float, domain: float) -> None:
    cost = raw_ics(request, workers=2).cost
    n = int(cost.solver.split()[1])
    seconds = sum(cost.seconds.values())
    per_wave = 1000 * cost.seconds["solution"] / n
    row(f"{cells:g}", f"{domain:g}", f"{cost.unknowns:,}", n, f"{seconds:.1f}", f"{per_wave:.0f}")


def main() -> None:
    engines([float(value) for value in sys.argv[1:]] or [0.01, 0.001, 0.0001])
    many_loads()
    growth()


if __name__ == "__main__":
    main()
