"""Benchmark of the solid engine: prints the tables of docs/performance.md as Markdown.

1. True error of C on `flat` (where A is exact), its estimate, and the cost, for several meshes.
2. Multigrid against the sparse direct solver (if installed), quarter and half models.
3. Wall time and memory of `femic run geometry1` as a whole process.
"""

import logging
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from time import perf_counter

import numpy as np
from joblib import Memory

from compare.dataset import errors, to_dataset
from compare.pipeline import compute, jobs
from compare.scenes import Scene, load_scene
from femic import pardiso
from femic.reference import requests
from femic.solid import raw_ics
from geometries.patches import Patch

COMPONENTS = ("nn", "ss", "xx", "xs", "xn", "sn")


def table(title: str, head: list[str], rows: Iterator[list[str]]) -> None:
    print(f"\n### {title}\n\n| {' | '.join(head)} |\n|{'---|' * len(head)}", flush=True)
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)


def coarser(scene: Scene, factor: float) -> Scene:
    return replace(scene, cells=scene.cells.scaled(factor), tolerance=1.0)


def error_rows(scene: Scene) -> Iterator[list[str]]:
    """True error (against A) and estimate of the lower body on the lines at 1.6 mm."""
    for factor in (4, 2.83, 2, 1.41, 1):
        results = compute(coarser(scene, factor), workers=1, memory=Memory(None), on_model=lambda *_: None)
        found = errors(results, to_dataset(results))["max"].sel(
            line=["s = 1.6 mm", "x = 1.6 mm"], body="lower"
        )
        worst = {v: found.sel(variant=v).max("line") for v in ("A", "C")}
        models = results.references["lower"].models
        seconds = [sum(models[name].seconds.values()) for name in ("fine", "coarse", "small")]
        shares = [[100 * worst[v].sel(i=c[0], j=c[1]).item() for v in ("A", "C")] for c in COMPONENTS]
        cells = [f"{error:.2f} ({estimate:.2f})" for error, estimate in shares]
        yield [
            f"{factor}",
            f"{models['fine'].unknowns:,}",
            f"{seconds[0]:.1f}",
            f"{sum(seconds):.1f}",
            *cells,
        ]


def solver_rows(scene: Scene) -> Iterator[list[str]]:
    """Seconds of the linear solution, three loads, per solver and symmetry."""
    for model, patch in (("quarter", scene.patch), ("half", Patch(scene.patch.a, scene.patch.b, s=1e-6))):
        for factor in (4, 2.83, 2, 1.41):
            job = replace(jobs(scene)["lower"], cells=scene.cells.scaled(factor), patch=patch)
            request = requests(job)["fine"]
            costs = [raw_ics(replace(request, solver=name)).cost for name in ("multigrid", "direct")]
            seconds = [cost.seconds["solution"] for cost in costs]
            yield [
                model,
                f"{costs[0].unknowns:,}",
                f"{max(costs[0].iterations)}",
                *(f"{s:.1f}" for s in seconds),
                f"{seconds[0] / seconds[1]:.2f}",
            ]


def run_rows() -> Iterator[list[str]]:
    with tempfile.TemporaryDirectory() as out:
        for label in ("first run", "second run (models kept)"):
            start = perf_counter()
            subprocess.run(
                [sys.executable, "-m", "compare", "run", "geometry1", "--out", out],
                check=True,
                stdout=subprocess.DEVNULL,
            )
            peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
            yield [label, f"{perf_counter() - start:.0f}", f"{peak:.0f}"]


def main() -> None:
    logging.getLogger("skfem").setLevel(logging.ERROR)
    np.set_printoptions(precision=3)
    table(
        "`femic run geometry1`", ["", "wall time [s]", "peak memory of the largest process [MB]"], run_rows()
    )
    table(
        "`flat`: true error (estimate) of the lower body on the lines at 1.6 mm [%]",
        ["cells ×", "unknowns", "fine model [s]", "with estimate [s]", *COMPONENTS],
        error_rows(load_scene("flat")),
    )
    if pardiso.available():
        table(
            "`geometry1`: linear solution, three loads",
            ["model", "unknowns", "iterations", "multigrid [s]", "direct [s]", "multigrid / direct"],
            solver_rows(load_scene("geometry1")),
        )


if __name__ == "__main__":
    main()
