"""The terminal: names such as Bhat+sn:B and [a] as they are, and the progress of models.

Progress is a bar on a terminal, otherwise a line every few seconds.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Lock, Thread
from time import monotonic
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)
from rich.progress import Progress as Bars

from femic.reference.run_options import Level, Solved, Step, Task, Watch, factors


def terminal(**options: Any) -> Console:
    """Return a console with options of `rich.console.Console`: no part of a text is an emoji or a tag."""
    return Console(emoji=False, markup=False, highlight=False, **options)


EVERY = 5.0  # seconds from a line to the next where there is no terminal
LOOK_EVERY = 0.5  # seconds between looks at the clock

Write = Callable[[str], None]


@contextmanager
def show_progress(console: Console) -> Iterator[Watch]:
    """Yield a watch that shows the progress of models on the console; each finished model has a line.

    On a terminal there is a bar over the models, to which refinement adds. Otherwise a thread looks at the
    clock, so that lines are written even while no model reports.
    """

    def write(text: str) -> None:
        console.print(text, soft_wrap=True)

    if not console.is_terminal:
        lines, stopped = ProgressLines(write), Event()

        def look() -> None:
            while not stopped.wait(LOOK_EVERY):
                lines.write_if_due()

        thread = Thread(target=look, daemon=True)
        thread.start()
        try:
            yield Watch(lambda _: None, lines.on_model, write, lines.on_step)
        finally:
            stopped.set()
            thread.join()
        return
    with bars(console) as progress:
        models = progress.add_task("models", total=0)

        def on_round(todo: Sequence[Task]) -> None:
            progress.update(models, total=(progress.tasks[models].total or 0) + len(todo))

        def on_model(solved: Solved) -> None:
            write(model_text(solved))
            progress.update(models, advance=1, description="models")

        def on_step(step: Step) -> None:
            progress.update(models, description=f"{step.task.job} body: {step_text(step)}")

        yield Watch(on_round, on_model, write, on_step)


def bars(console: Console, *further: ProgressColumn) -> Bars:
    """Return progress bars with a description, the count, the time elapsed, and further columns."""
    columns = SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    return Bars(*columns, TimeElapsedColumn(), *further, console=console)


@dataclass
class ProgressLines:
    """Lines about each model in progress: when it begins, and every EVERY seconds."""

    write: Write
    clock: Callable[[], float] = monotonic
    _working: dict[tuple[str, Level], tuple[float, Step]] = field(default_factory=dict)  # begin [s] and step
    _lock: Lock = field(default_factory=Lock)  # models may report from threads of their own
    _last: float = 0.0  # time of the last line

    def on_step(self, step: Step) -> None:
        """Note the step that a model is at; write a line if it has just begun or the last line is old."""
        with self._lock:
            key = step.task.job, step.task.level
            start = self._working[key][0] if key in self._working else self.clock()
            has_just_begun = key not in self._working
            self._working[key] = start, step
            if has_just_begun:
                self._last = start
                self.write(f"{task_text(step.task)}: {step_text(step)}")
        self.write_if_due()

    def on_model(self, solved: Solved) -> None:
        """Write a line about a model that is finished."""
        with self._lock:
            self._working.pop((solved.task.job, solved.task.level), None)
            self._last = self.clock()
            self.write(model_text(solved))

    def write_if_due(self) -> None:
        """Write the steps that all models are at, if the last line is older than EVERY seconds."""
        with self._lock:
            now = self.clock()
            if now - self._last < EVERY:
                return
            self._last = now
            for start, step in self._working.values():
                self.write(f"{task_text(step.task)}: {step_text(step)}, {now - start:.0f} s")


def task_text(task: Task) -> str:
    """Return text that names the model of a task."""
    cells, domain = factors(task.level)
    return f"  {task.job} body, cells x {cells:.3g}, domain x {domain:.3g}"


def step_text(step: Step) -> str:
    """Return text about the step that a model is at."""
    if not step.wavenumbers:
        return step.stage
    if step.expected is None or step.wavenumbers > step.expected:
        return f"{step.wavenumbers} wavenumbers"
    return f"{step.wavenumbers} of about {step.expected} wavenumbers"


def model_text(solved: Solved) -> str:
    """Return text about a finished model, with its cost."""
    cost = solved.model.cost
    took = "stored by an earlier run" if solved.cached else f"{sum(cost.seconds.values()):.1f} s"
    return f"{task_text(solved.task)}: {cost.unknowns:,} unknowns, {took}"
