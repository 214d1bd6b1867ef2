"""Benchmark of the solid engine: prints the tables of docs/performance.md as Markdown.

1. True error of C on `flat` (where A is exact), its estimate, and the cost, for several meshes.
2. Multigrid against the sparse direct solver (if installed), quarter and half models.
3. Wall time of `femic run geometry1` as a whole process, seconds and memory of its stages.
"""

import json
import logging
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from time import perf_counter

import numpy as np
import xarray as xr
from joblib import Memory

from compare.dataset import errors, to_dataset
from compare.pipeline import compute, jobs
from compare.scenes import Scene, load_scene
from femic import pardiso
from femic.reference import requests
from femic.solid import Cost, Request, raw_ics
from geometries.patches import Patch

SOLVERS = ("multigrid", "direct")
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


def cost_in_fresh_process(request: Request) -> Cost:
    """MKL's idle threads would slow down whatever the same process solves next."""
    context = get_context("spawn")
    with ProcessPoolExecutor(max_workers=1, mp_context=context) as pool:
        return pool.submit(raw_ics, request).result().cost


def solver_rows(scene: Scene) -> Iterator[list[str]]:
    """Seconds of the linear solution, three loads, per solver and symmetry."""
    for model, patch in (("quarter", scene.patch), ("half", Patch(scene.patch.a, scene.patch.b, s=1e-6))):
        for factor in (4, 2.83, 2, 1.41):
            job = replace(jobs(scene)["lower"], cells=scene.cells.scaled(factor), patch=patch)
            request = requests(job)["fine"]
            costs = [cost_in_fresh_process(replace(request, solver=name)) for name in SOLVERS]
            seconds = [cost.seconds["solution"] for cost in costs]
            yield [
                model,
                f"{costs[0].unknowns:,}",
                f"{max(costs[0].iterations)}",
                *(f"{s:.1f}" for s in seconds),
                f"{seconds[0] / seconds[1]:.2f}",
            ]


def run_geometry1(out: str) -> float:
    """Wall seconds of `femic run geometry1` as a process of its own."""
    command = [sys.executable, "-m", "compare", "run", "geometry1", "--out", out]
    start = perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - start


def stage_rows(out: str) -> Iterator[list[str]]:
    with xr.open_dataset(f"{out}/ics.nc", engine="h5netcdf") as dataset:
        models = json.loads(dataset.attrs["models"])
    for name, cost in models.items():
        stages = [f"{cost['seconds'][stage]:.1f}" for stage in ("mesh", "assembly", "solution")]
        yield [name, f"{cost['unknowns']:,}", cost["solver"], *stages, f"{cost['peak_memory']:.0f}"]


def main() -> None:
    logging.getLogger("skfem").setLevel(logging.ERROR)
    np.set_printoptions(precision=3)
    with tempfile.TemporaryDirectory() as out:
        first, second = run_geometry1(out), run_geometry1(out)
        print(f"\n`femic run geometry1`: {first:.0f} s, again with the models kept: {second:.0f} s")
        head = [
            "model",
            "unknowns",
            "solver",
            "mesh [s]",
            "assembly [s]",
            "solution [s]",
            "peak of its process [MB]",
        ]
        table("`femic run geometry1` by stage, one process per core", head, stage_rows(out))
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
