"""The workers of a cluster and their tasks."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from time import perf_counter

from distributed import CancelledError, Client, Future, KilledWorker

from femic.campaigns.running.paused import Pauses, running
from femic.campaigns.running.tasks import TaskReport, Unusable
from geometries.errors import Failure

SCENES_PER_WORKER = 4  # submitted at a time, so that no worker waits for this process
GONE = "the scheduler is gone; finished scenes are stored: start it again, and run the same command"
COUNT_EVERY = 1.0  # s from a count of the workers to the next
ANSWERS_WITHIN = 60.0  # s in which the scheduler returns a receipt


@dataclass(eq=False)
class Crew:
    """The workers of a cluster and their open tasks."""

    client: Client
    on_message: Callable[[str], None]
    open: set[Future] = field(default_factory=set)  # submitted, not completed
    ended: SimpleQueue[Future] = field(default_factory=SimpleQueue)
    workers: int = 0
    running: int = 0  # workers that are not paused
    pauses: Pauses = field(init=False)

    def __post_init__(self) -> None:
        self.pauses = Pauses(self.on_message, perf_counter)
        self.count()

    @property
    def window(self) -> int:
        """The number of scenes to have submitted: one per worker once memory ran out."""
        return (1 if self.pauses.reported else SCENES_PER_WORKER) * max(1, self.running)

    def submit(self, task: Callable[..., TaskReport], *given: object, priority: int = 0) -> Future:
        """Submit a task."""
        future = self.client.submit(task, *given, priority=priority, pure=False)
        self.open.add(future)
        future.add_done_callback(self.ended.put)
        return future

    def completed(self) -> Iterator[Future]:
        """Yield tasks as they end, until none is left; raise Failure as `count`."""
        counted = perf_counter()
        while self.open:
            if perf_counter() - counted > COUNT_EVERY:
                self.count()
                counted = perf_counter()
            with suppress(Empty):
                future = self.ended.get(timeout=COUNT_EVERY)
                self.open.remove(future)
                yield future

    def count(self) -> None:
        """Count the workers; raise Failure where the scheduler is gone, or all workers stay paused."""
        workers = self.client.scheduler_info(n_workers=-1).get("workers")
        if workers is None or self.client.status != "running":
            raise Failure(GONE)
        if self.workers and not workers:
            self.on_message(
                "there are no workers any more; waiting for others (Ctrl-C: continue another time)"
            )
        self.workers, self.running = len(workers), running(workers)
        self.pauses.update(workers)


def report_of(future: Future) -> TaskReport:
    """Return the receipt of a task; raise Failure where the campaign cannot go on."""
    try:
        report: TaskReport = future.result(timeout=ANSWERS_WITHIN)
    except CancelledError as error:
        raise Failure(GONE) from error
    except KilledWorker as error:
        return TaskReport(
            f"its worker died {error.allowed_failures + 1} times, most likely for memory: give fewer workers "
            "(--workers), larger cells or a larger tolerance; run again to try again"
        )
    except Unusable:
        raise
    except Exception as error:  # one scene must not end the others
        return TaskReport(f"{type(error).__name__}: {error}")
    return report
