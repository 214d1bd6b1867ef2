"""Benchmarks of the solid engine: seconds, memory, errors (docs/evidence/performance.md).

    python benchmarks/solid_engine.py [runs] [flat] [solvers] [growth] [--record]

runs     wall time of `femic run` on the two geometries, by stage and model
flat     true error of C (A is exact there), its estimate, and the cost, for several meshes
solvers  multigrid against the sparse direct solver (if installed), quarter and half models
growth   seconds and memory against unknowns, to about a million, and their exponents
"""

import json
import logging
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from time import perf_counter

import numpy as np
import xarray as xr
from tables import Record, arguments, print_table

from approx.halfspace import HalfSpace
from femic.reference.engine import Cost, RawICs, Request
from femic.reference.engines import SOLID
from femic.reference.job import Job, component_of, line_scale
from femic.reference.result import combine
from femic.reference.run_options import Level, factors
from femic.reference.solid import pardiso
from femic.reference.solid.engine import raw_ics
from femic.results.ics import jobs
from femic.scenes.load import load_scene
from geometries.contours import arc
from geometries.materials import one_body

COMPONENTS = ("nn", "ss", "xx", "xs", "xn", "sn")
LINES = ("s = 1.6 mm", "x = 1.6 mm")
DIRECT_MOST = 600_000  # unknowns: about 12 GB
STAGES = ("mesh", "assembly", "solution")


def solid_jobs(scene: str) -> dict[str, Job]:
    """Return the jobs of a built-in scene by the solid engine."""
    return jobs(load_scene(scene, {"engine": {"kind": "solid", "check": False}}))


def with_cells(job: Job, factor: float) -> Job:
    """Return a job with other cells to start with."""
    return replace(job, settings=replace(job.settings, cells=job.first_cells.scaled(factor)))


def in_fresh_process(request: Request) -> RawICs:
    """Solve in a fresh process: its peak memory is its own, and its idle threads slow down nothing else."""
    with ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn")) as pool:
        return pool.submit(raw_ics, request).result()


def seconds_of(cost: Cost) -> float:
    return sum(cost.seconds.values())


def series(job: Job, levels: list[Level]) -> tuple[dict[Level, RawICs], dict[Level, np.ndarray], dict]:
    """Return all models of some levels, and C and its estimate at each."""
    models: dict[Level, RawICs] = {}
    for level in levels:
        for needed in level.models(SOLID.models).values():
            if needed not in models:
                models[needed] = in_fresh_process(job.request(needed))
    results = {level: combine(job, level, models) for level in levels}
    return models, {k: r.c.ic for k, r in results.items()}, {k: r.c.estimate for k, r in results.items()}


def accuracy_rows(job: Job, levels: list[Level], c: np.ndarray) -> Iterator[list[str]]:
    """Yield the error against the true C, and the estimate, of each level in percent."""
    models, ic, estimate = series(job, levels)
    for level in levels:
        cells, _ = factors(level)
        cost = [models[model].cost for model in level.models(SOLID.models).values()]
        shares = [worst_share(job, c, difference) for difference in (ic[level] - c, estimate[level])]
        both = [f"{100 * e:.2f} ({100 * s:.2f})" for e, s in zip(*shares, strict=True)]
        yield [
            f"{cells:.3g}",
            f"{cost[0].unknowns:,}",
            f"{seconds_of(cost[0]):.1f}",
            f"{sum(map(seconds_of, cost)):.1f}",
            *both,
        ]


def worst_share(job: Job, c: np.ndarray, difference: np.ndarray) -> list[float]:
    errors = [
        np.max(np.abs(difference[..., p]), axis=-1) / line_scale(c[..., p], c[2, 2, p])
        for p in (job.lines[name] for name in LINES)
    ]
    return [component_of(np.max(errors, axis=0), component) for component in COMPONENTS]


HEAD = ["cells ×", "unknowns", "fine model [s]", "with estimate [s]", *(f"{c} [%]" for c in COMPONENTS)]


OF_FLAT = Record(
    "solid_engine.flat",
    "The solid engine: error against seconds",
    "Scene `flat`, where A is exact: error of C, and its estimate in brackets, largest on the lines 1.6 "
    "mm from the load. Cells as multiples of the default. One process.",
    "python benchmarks/solid_engine.py flat",
)
OF_SOLVERS = Record(
    "solid_engine.solvers",
    "Linear solvers",
    "Scene `geometry1`, lower body, three loads: multigrid on one thread, the direct solver (PARDISO) on "
    "two.",
    "python benchmarks/solid_engine.py solvers",
)
OF_GROWTH = Record(
    "solid_engine.growth",
    "The solid engine: growth with the unknowns",
    "Geometry 2, the wheel, three loads, each row in a fresh process.",
    "python benchmarks/solid_engine.py growth",
)
OF_RUNS = Record(
    "solid_engine.runs",
    "`femic run`",
    "Both engines, estimated errors of all components, page and figures.",
    "python benchmarks/solid_engine.py runs",
)


def flat() -> None:
    job = solid_jobs("flat")["lower"]
    solid = HalfSpace(one_body(job.body.material, job.body.side))
    a = solid.ics(job.patch, job.points.x, job.points.s - job.patch.s) / job.patch.area
    levels = [Level(cells) for cells in (-3, -2, -1, 0)]
    print_table(HEAD, accuracy_rows(job, levels, a), record=OF_FLAT)


def solvers() -> None:
    head = ["model", "unknowns", "iterations", "multigrid [s]", "direct [s]", "multigrid / direct"]
    if pardiso.available():
        print_table(head, solver_rows(), record=OF_SOLVERS)


def solver_rows() -> Iterator[list[str]]:
    quarter = solid_jobs("geometry1")["lower"]
    unsymmetric = arc(10.0, np.radians(25.5), np.radians(25.6))
    half = replace(quarter, body=replace(quarter.body, contour=unsymmetric))
    for model, job in (("quarter", quarter), ("half", half)):
        for cells in (4, 2.83, 2, 1.41):
            request = with_cells(job, cells).request(Level())
            costs = [in_fresh_process(replace(request, solver=name)).cost for name in ("multigrid", "direct")]
            seconds = [cost.seconds["solution"] for cost in costs]
            yield [
                model,
                f"{costs[0].unknowns:,}",
                f"{max(costs[0].iterations)}",
                *(f"{s:.1f}" for s in seconds),
                f"{seconds[0] / seconds[1]:.2f}",
            ]


def growth() -> None:
    head = ["solver", "unknowns", "iterations", *(f"{stage} [s]" for stage in STAGES), "memory [MB]"]
    measured: dict[str, list[Cost]] = {"multigrid": []} | ({"direct": []} if pardiso.available() else {})
    print_table(head, growth_rows(measured), record=OF_GROWTH)
    for solver, costs in measured.items():
        unknowns = np.log([cost.unknowns for cost in costs])
        quantities = {stage: [cost.seconds[stage] for cost in costs] for stage in STAGES}
        quantities["peak memory"] = [cost.peak_memory for cost in costs]
        rates = {name: np.polyfit(unknowns[1:], np.log(v[1:]), 1)[0] for name, v in quantities.items()}
        print(f"\nexponents, {solver}: " + ", ".join(f"{name} {rate:.2f}" for name, rate in rates.items()))


def growth_rows(measured: dict[str, list[Cost]]) -> Iterator[list[str]]:
    job = solid_jobs("geometry2")["upper"]
    for solver, costs in measured.items():
        for cells in (3.5, 2.4, 1.7, 1.2, 0.85, 0.65):
            if solver == "direct" and costs and costs[-1].unknowns * 2.3 > DIRECT_MOST:
                break
            request = replace(with_cells(job, cells).request(Level()), solver=solver)
            costs.append(cost := in_fresh_process(request).cost)
            yield [
                solver,
                f"{cost.unknowns:,}",
                f"{max(cost.iterations)}",
                *(f"{cost.seconds[stage]:.1f}" for stage in STAGES),
                f"{cost.peak_memory:.0f}",
            ]


def runs() -> None:
    took = []
    for scene in ("geometry1", "geometry2"):
        with tempfile.TemporaryDirectory() as out:
            first, second = run(scene, out), run(scene, out)
            took.append([f"`femic run {scene}`", f"{first:.0f}", f"{second:.0f}"])
            head = ["model", "unknowns", "solver", *(f"{s} [s]" for s in STAGES), "peak of its process [MB]"]
            print_table(head, stage_rows(out), record=of_stages(scene))
    print_table(["command", "first run [s]", "again, with stored models [s]"], took, record=OF_RUNS)


def of_stages(scene: str) -> Record:
    return Record(
        f"solid_engine.stages_{scene}",
        f"`femic run {scene}` by model",
        "One process per core; memory is that of the process, over all models that it has solved.",
        "python benchmarks/solid_engine.py runs",
    )


def run(scene: str, out: str) -> float:
    """Return wall seconds of `femic run` as a process of its own."""
    start = perf_counter()
    command = [sys.executable, "-m", "femic", "run", scene, "--out", out]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - start


def stage_rows(out: str) -> Iterator[list[str]]:
    with xr.open_dataset(f"{out}/ics.nc", engine="h5netcdf") as dataset:
        models = json.loads(dataset.attrs["models"])
    for name, cost in models.items():
        stages = [f"{cost['seconds'][stage]:.1f}" for stage in STAGES]
        yield [name, f"{cost['unknowns']:,}", cost["solver"], *stages, f"{cost['peak_memory']:.0f}"]


BENCHMARKS: dict[str, Callable[[], None]] = {
    "runs": runs,
    "flat": flat,
    "solvers": solvers,
    "growth": growth,
}

if __name__ == "__main__":
    logging.getLogger("skfem").setLevel(logging.ERROR)
    for name in arguments() or BENCHMARKS:
        BENCHMARKS[name]()
