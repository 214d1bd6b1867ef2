"""The tables of `femic plan`."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.table import Table

from compare.campaigns.maps import maps_of_scene
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import C, c_jobs, needed_components
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.reference.plan import ModelPlan, plans, total_seconds
from femic.results.contact import require_solvable
from femic.results.ics import run_plans
from femic.results.matrices import expected_seconds, file_size, matrix_plans
from femic.scenes.scene import Scene
from geometries.errors import WrongInput


def show(scene: Scene, workers: int, console: Console) -> None:
    """Print what `femic run`, `femic matrix` and, with loads, `femic contact` of a scene will take."""
    console.print(f"{scene.title}: tolerance {scene.settings.tolerance:g}, {workers} workers")
    console.print(
        f"bodies: {', '.join(scene.solved)} (compared: {', '.join(scene.compared)}); components: "
        f"{', '.join(scene.components)} for `femic run`, all nine for `femic matrix`",
    )
    grid = scene.grid
    matrix_title = (
        f"femic matrix: {grid.n_x} lags of {grid.dx:g} mm, {grid.n_s} strips of {grid.ds:g} mm about "
        f"s = {grid.s:g} mm; matrix.nc takes {file_size(scene) / 1e6:.0f} MB"
    )
    with _refusal_printed("femic run", console):
        _print("femic run", run_plans(scene, workers), workers, console)
    with _refusal_printed("femic matrix", console):
        of_matrices = f" for the models; {expected_seconds(scene):.0f} s for the matrices themselves"
        _print(matrix_title, matrix_plans(scene, workers), workers, console, of_matrices)
    if scene.contact.loads or scene.contact.approaches:
        with _refusal_printed("femic contact", console):
            _show_contact(scene, workers, console)
    console.print(
        "One round; a round more where the estimated error is larger than the tolerance. Stored models take "
        "no time.",
    )


@contextmanager
def _refusal_printed(command: str, console: Console) -> Iterator[None]:
    """Print the reason where a command refuses a scene: others may take it."""
    try:
        yield
    except WrongInput as refusal:
        console.print(f"{command}: {refusal}")


def _show_contact(scene: Scene, workers: int, console: Console) -> None:
    """Print the grids of `femic contact`, and what C takes on them."""
    require_solvable(scene)
    problem = scene.contact_problem
    for grid, loadings in grids_of(problem, maps_of_scene(scene)):
        title = (
            f"femic contact: {grid.n_x} x {grid.n_s} elements of {grid.dx:.3g} x {grid.ds:.3g} mm: "
            f"{', '.join(map(str, loadings))}"
        )
        if C in scene.contact.ics:
            model_plans = list(plans(c_jobs(problem, pair_on_grid(problem, grid)), workers))
            _print(f"{title}; {', '.join(needed_components(problem))} of C:", model_plans, workers, console)
        else:
            console.print(f"{title}; no C: seconds")


def _print(
    title: str, model_plans: list[ModelPlan], workers: int, console: Console, further: str = ""
) -> None:
    """Print a table of models and what they take in all, with a `further` remark."""
    table = Table(title=title, title_justify="left")
    for column in ("model", "engine", "symmetry", "cells ×", "far arc", "along x"):
        table.add_column(column)
    for column in ("unknowns", "wavenumbers", "fields", "s", "MB"):
        table.add_column(column, justify="right")
    for plan in model_plans:
        expected_cost = plan.expected
        table.add_row(
            plan.name,
            plan.engine.name,
            "y" if expected_cost.half_section else "none",
            f"{plan.cells:.3g}",
            f"{plan.far_radius:g} mm",
            plan.along_x,
            f"{expected_cost.unknowns:,}",
            str(expected_cost.wavenumbers or "–"),
            str(expected_cost.fields),
            f"{expected_cost.seconds:.0f}",
            f"{expected_cost.memory:.0f}",
        )
    console.print(table)
    largest_memory = max(plan.expected.memory for plan in model_plans)
    seconds = total_seconds(model_plans, workers)
    console.print(f"about {seconds:.0f} s, {largest_memory:.0f} MB{further}")
