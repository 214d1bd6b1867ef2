"""Progress while models are solved: a live bar on a terminal, else a line now and then."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Lock, Thread
from time import monotonic

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
)

from femic.level import Level, factors
from femic.means import Solved, Step, Task, Watch

EVERY = 5.0  # seconds from a line to the next where there is no terminal
LOOK_EVERY = 0.5  # seconds

Write = Callable[[str], None]


@contextmanager
def shown(console: Console) -> Iterator[Watch]:
    """Whom to tell of models while they are solved; each finished one has its line on the console."""

    def write(text: str) -> None:
        console.print(text, soft_wrap=True)

    with _bar(console, write) if console.is_terminal else _lines(write) as watch:
        yield watch


@contextmanager
def _bar(console: Console, write: Write) -> Iterator[Watch]:
    """A progress bar over the models; refinement adds some."""
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console) as progress:
        models = progress.add_task("models", total=0)

        def on_round(todo: Sequence[Task]) -> None:
            progress.update(models, total=(progress.tasks[models].total or 0) + len(todo))

        def on_model(solved: Solved) -> None:
            write(finished(solved))
            progress.update(models, advance=1, description="models")

        def on_step(step: Step) -> None:
            progress.update(models, description=f"{step.task.job} body: {doing(step)}")

        yield Watch(on_round, on_model, write, on_step)


@contextmanager
def _lines(write: Write) -> Iterator[Watch]:
    """Lines, also while nothing is heard from the models: a thread looks at the clock."""
    lines, end = Lines(write), Event()

    def look() -> None:
        while not end.wait(LOOK_EVERY):
            lines.tell()

    thread = Thread(target=look, daemon=True)
    thread.start()
    try:
        yield Watch(lambda _: None, lines.on_model, write, lines.on_step)
    finally:
        end.set()
        thread.join()


@dataclass
class Lines:
    """A line per model that is being solved, when it begins and every EVERY seconds."""

    write: Write
    clock: Callable[[], float] = monotonic
    _working: dict[tuple[str, Level], tuple[float, Step]] = field(default_factory=dict)  # begun, and at what
    _lock: Lock = field(default_factory=Lock)  # models may tell from threads of their own
    _last: float = 0.0

    def on_step(self, step: Step) -> None:
        """A model goes on."""
        with self._lock:
            key = step.task.job, step.task.level
            begun = self._working[key][0] if key in self._working else self.clock()
            new = key not in self._working
            self._working[key] = begun, step
            if new:
                self._last = begun
                self.write(f"{named(step.task)}: {doing(step)}")
        self.tell()

    def on_model(self, solved: Solved) -> None:
        """A model is finished."""
        with self._lock:
            self._working.pop((solved.task.job, solved.task.level), None)
            self._last = self.clock()
            self.write(finished(solved))

    def tell(self) -> None:
        """Write what all models are at, if the last line was long ago."""
        with self._lock:
            now = self.clock()
            if now - self._last < EVERY:
                return
            self._last = now
            for begun, step in self._working.values():
                self.write(f"{named(step.task)}: {doing(step)}, {now - begun:.0f} s")


def named(task: Task) -> str:
    """The model of a task."""
    cells, domain = factors(task.level)
    return f"  {task.job} body, cells x {cells:.3g}, domain x {domain:.3g}"


def doing(step: Step) -> str:
    """What a model is at."""
    if not step.wavenumbers:
        return step.stage
    if step.expected is None or step.wavenumbers > step.expected:
        return f"{step.wavenumbers} wavenumbers"
    return f"{step.wavenumbers} of about {step.expected} wavenumbers"


def finished(solved: Solved) -> str:
    """What a model took."""
    cost = solved.model.cost
    took = "kept from an earlier run" if solved.kept else f"{sum(cost.seconds.values()):.1f} s"
    return f"{named(solved.task)}: {cost.unknowns:,} unknowns, {took}"
