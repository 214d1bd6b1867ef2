"""`femic plan`: what a scene will take, and why; afterwards, what it took."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from compare.matrix.results import file_size, matrix_jobs
from compare.pipeline import jobs
from compare.scenes.scene import Scene
from femic.harmonic.engine import HarmonicRequest
from femic.models import Cost
from femic.plan import Planned, planned
from femic.reference import Level, factors, request
from femic.solid.engine import Request


@dataclass(frozen=True)
class Step:
    """A model of a plan: its name, size of cells over the scene's, extent, and what it takes."""

    name: str
    engine: str
    cells: float
    far_radius: float
    along_x: str
    takes: Planned


def run_steps(scene: Scene, workers: int) -> list[Step]:
    """The models of `femic run`."""
    steps = list(_at_points(scene, workers, ""))
    return steps + (list(_at_points(scene.check, workers, "check, ")) if scene.check else [])


def _at_points(scene: Scene, workers: int, prefix: str) -> Iterator[Step]:
    for name, job in jobs(scene).items():
        for model, level in Level().models(job.engine).items():
            asked = request(job, level)
            yield _step(f"{prefix}{name}, {model}", job.engine, asked, level, workers)


def matrix_steps(scene: Scene, workers: int) -> list[Step]:
    """The models of `femic matrix`."""
    return [
        _step(f"{name}, {model}", "harmonic", job.request(level), level, workers)
        for name, job in matrix_jobs(scene).items()
        for model, level in Level().models("harmonic").items()
    ]


def _step(name: str, engine: str, asked: Request | HarmonicRequest, level: Level, workers: int) -> Step:
    body = asked.body
    length = "endless" if np.isinf(body.xi_end) else f"{body.xi_end:.4g} mm"
    along_x = "all round" if body.closed else length
    cells = factors(level)[0]
    return Step(name, engine, cells, body.domain.far_radius, along_x, planned(asked, workers))


def seconds(steps: list[Step], workers: int) -> float:
    """Of all steps: harmonic models one after the other, solid ones side by side."""
    harmonic = sum(step.takes.seconds for step in steps if step.engine == "harmonic")
    return harmonic + sum(step.takes.seconds for step in steps if step.engine == "solid") / workers


def show(scene: Scene, workers: int, console: Console) -> None:
    """Print what `femic run` and `femic matrix` of a scene would take."""
    console.print(f"{scene.title}: tolerance {scene.tolerance:g}, {workers} workers", markup=False)
    console.print(
        f"bodies: {', '.join(scene.solved)} (compared: {', '.join(scene.compared)}); components: "
        f"{', '.join(scene.components)} for `femic run`, all nine for `femic matrix`",
        markup=False,
    )
    grid = scene.grid
    of_matrix = (
        f"femic matrix: {grid.n_x} lags of {grid.dx:g} mm, {grid.n_s} strips of {grid.ds:g} mm about "
        f"s = {grid.s:g} mm; matrix.nc takes {file_size(scene) / 1e6:.0f} MB"
    )
    for title, steps in (
        ("femic run", run_steps(scene, workers)),
        (of_matrix, matrix_steps(scene, workers)),
    ):
        _print(title, steps, workers, console)
    console.print(
        "One round; a round more where the estimated error is larger than the tolerance. Kept models take no "
        "time.",
        markup=False,
    )


def _print(title: str, steps: list[Step], workers: int, console: Console) -> None:
    table = Table(title=title, title_justify="left")
    for column in ("model", "engine", "symmetry", "cells ×", "far arc", "along x"):
        table.add_column(column)
    for column in ("unknowns", "wavenumbers", "fields", "s", "MB"):
        table.add_column(column, justify="right")
    for step in steps:
        takes = step.takes
        table.add_row(
            step.name,
            step.engine,
            "y" if takes.half_section else "none",
            f"{step.cells:.3g}",
            f"{step.far_radius:g} mm",
            step.along_x,
            f"{takes.unknowns:,}",
            str(takes.wavenumbers or "–"),
            str(takes.fields),
            f"{takes.seconds:.0f}",
            f"{takes.memory:.0f}",
        )
    console.print(table)
    most = max(step.takes.memory for step in steps)
    console.print(f"about {seconds(steps, workers):.0f} s, {most:.0f} MB", markup=False)


def compared(steps: list[Step], costs: Mapping[str, Cost]) -> list[dict[str, str]]:
    """What models were expected to take beside what they took."""
    rows = []
    for step in steps:
        cost = costs.get(step.name)
        if cost is not None:
            wavenumbers = cost.solver.split(", ")[-1].split()[0] if step.engine == "harmonic" else "–"
            rows.append(
                {
                    "name": step.name,
                    "unknowns": f"{step.takes.unknowns:,} / {cost.unknowns:,}",
                    "wavenumbers": f"{step.takes.wavenumbers or '–'} / {wavenumbers}",
                    "seconds": f"{step.takes.seconds:.0f} / {sum(cost.seconds.values()):.0f}",
                    "memory": f"{step.takes.memory:.0f} / {cost.peak_memory:.0f}",
                }
            )
    return rows
