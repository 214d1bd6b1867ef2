"""The command `plan`: what a scene will take, before anything is solved."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.table import Table

from femic.cli.progress import terminal
from femic.cli.work import TABLE_WIDTH, SceneName, Workers, maps_of
from femic.lazy import lazy_imports
from femic.reference.run_options import cores
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

with lazy_imports():
    from femic.contact.pairs import grids, pair_on_grid
    from femic.contact.pairs import ics as contact_ics
    from femic.reference import refinement
    from femic.results import contact as contacts
    from femic.results import ics, matrices


def plan(scene: SceneName, /, *, workers: Workers = None) -> None:
    """Estimate the cost of a scene: models, unknowns, wavenumbers, seconds, memory, file size.

    Covers `femic run`, `femic matrix` and, for a scene with loads, `femic contact`.
    """
    loaded, count, console = load_scene(scene), workers or cores(), terminal(width=TABLE_WIDTH)
    console.print(f"{loaded.title}: tolerance {loaded.settings.tolerance:g}, {count} workers")
    console.print(
        f"bodies: {', '.join(loaded.solved)} (compared: {', '.join(loaded.compared)}); components: "
        f"{', '.join(loaded.components)} for `femic run`, all nine for `femic matrix`",
    )
    with _refusal_printed("femic run", console):
        _print("femic run", ics.run_plans(loaded, count), count, console)
    grid = loaded.grid
    title = (
        f"femic matrix: {grid.n_x} lags of {grid.dx:g} mm, {grid.n_s} strips of {grid.ds:g} mm about "
        f"s = {grid.s:g} mm; matrix.nc takes {matrices.file_size(loaded) / 1e6:.0f} MB"
    )
    with _refusal_printed("femic matrix", console):
        rest = f" for the models; {matrices.expected_seconds(loaded):.0f} s for the matrices"
        _print(title, matrices.matrix_plans(loaded, count), count, console, rest)
    if loaded.contact.loads or loaded.contact.approaches:
        with _refusal_printed("femic contact", console):
            contacts.require_solvable(loaded)
            problem = loaded.contact_problem
            for of_loads, loadings in grids.grids_of(problem, maps_of(loaded)):
                title = (
                    f"femic contact: {of_loads.n_x} x {of_loads.n_s} elements of {of_loads.dx:.3g} x "
                    f"{of_loads.ds:.3g} mm: {', '.join(map(str, loadings))}"
                )
                if contact_ics.C not in loaded.contact.ics:
                    console.print(f"{title}; no C: seconds")
                    continue
                jobs = contact_ics.c_jobs(problem, pair_on_grid.pair_on_grid(problem, of_loads))
                components = ", ".join(contact_ics.needed_components(problem))
                _print(f"{title}; {components} of C:", list(refinement.plans(jobs, count)), count, console)
    console.print(
        "Times are for one round. Another round follows if the estimated error exceeds the tolerance. "
        "Stored models take no time.",
    )


@contextmanager
def _refusal_printed(command: str, console: Console) -> Iterator[None]:
    """Print the reason where a command refuses a scene: others may take it."""
    try:
        yield
    except WrongInput as refusal:
        console.print(f"{command}: {refusal}")


def _print(
    title: str, plans: "list[refinement.ModelPlan]", workers: int, console: Console, further: str = ""
) -> None:
    """Print a table of models and what they take in all, with a `further` remark."""
    table = Table(title=title, title_justify="left")
    for column in ("model", "engine", "symmetry", "cells ×", "far arc", "along x"):
        table.add_column(column)
    for column in ("unknowns", "wavenumbers", "fields", "s", "MB"):
        table.add_column(column, justify="right")
    for plan in plans:
        cost = plan.expected
        table.add_row(
            plan.name,
            plan.engine.name,
            "y" if cost.half_section else "none",
            f"{plan.cells:.3g}",
            f"{plan.far_radius:g} mm",
            plan.along_x,
            f"{cost.unknowns:,}",
            str(cost.wavenumbers or "–"),
            str(cost.fields),
            f"{cost.seconds:.0f}",
            f"{cost.memory:.0f}",
        )
    console.print(table)
    largest_memory = max(plan.expected.memory for plan in plans)
    seconds = refinement.total_seconds(plans, workers)
    console.print(f"about {seconds:.0f} s, {largest_memory:.0f} MB{further}")
