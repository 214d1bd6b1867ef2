"""What the commands of `femic` do: scenes in, files and messages out."""

import os
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)

from compare.pipeline import n_models
from compare.run import run_scene
from compare.scene_listing import listing
from compare.scenes import builtin_names, load_scene
from femic.reference import Solved


def run(
    scene: str,
    /,
    *,
    out: Annotated[Path | None, Parameter(help="folder for the results; default out/SCENE")] = None,
    workers: Annotated[int | None, Parameter(help="parallel processes; default: one per core")] = None,
) -> None:
    """Compute and compare the influence coefficients of a scene; write a report.

    Parameters
    ----------
    scene
        built-in name (see `femic scenes`) or TOML file
    """
    loaded = load_scene(scene)
    folder = out or Path("out") / loaded.name
    console = Console()
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("3D models", total=n_models(loaded))

        def on_model(solved: Solved) -> None:
            cost = solved.raw.cost
            took = "kept from an earlier run" if solved.kept else f"{sum(cost.seconds.values()):.1f} s"
            name = f"{solved.job} body, {solved.model} model"
            progress.console.print(f"  {name}: {cost.unknowns:,} unknowns, {took}")
            progress.advance(task)
            if progress.finished:
                progress.update(task, description="figures and report")

        report = run_scene(loaded, folder, workers=workers or os.cpu_count() or 1, on_model=on_model)
    console.print(f"Report: {report}", soft_wrap=True)


def scenes(
    *, show: Annotated[str | None, Parameter(help="print this scene with every key, ready to copy")] = None
) -> None:
    """List the built-in scenes, or print one with every key, unit and default."""
    console = Console(highlight=False, soft_wrap=True)
    if show is not None:
        console.print(listing(show), end="", markup=False)
        return
    for name in builtin_names():
        console.print(f"{name:12} {load_scene(name).title}", markup=False)
