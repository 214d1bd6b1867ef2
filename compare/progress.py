"""Progress on the terminal while models are solved."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)

from femic.reference import factors
from femic.refinement import Watch
from femic.workers import Solved, Task


@contextmanager
def shown(console: Console) -> Iterator[Watch]:
    """A progress bar over the models, with a line for each finished one; refinement adds models."""
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("models", total=0)

        def on_round(todo: list[Task]) -> None:
            progress.update(task, total=(progress.tasks[task].total or 0) + len(todo))

        def on_model(solved: Solved) -> None:
            cost = solved.model.cost
            took = "kept from an earlier run" if solved.kept else f"{sum(cost.seconds.values()):.1f} s"
            cells, domain = factors(solved.task.level)
            console.print(
                f"  {solved.task.job} body, cells x {cells:.3g}, domain x {domain:.3g}: "
                f"{cost.unknowns:,} unknowns, {took}"
            )
            progress.update(task, advance=1, description="models")

        def on_step(text: str) -> None:
            progress.update(task, description=text)

        yield Watch(on_round, on_model, lambda text: console.print(text, soft_wrap=True), on_step)
