"""The workers of a cluster and their tasks.

Workers that Dask has paused because memory is short take no tasks until there is room again.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from time import perf_counter
from typing import Any

from distributed import CancelledError, Client, Future, KilledWorker

from compare.campaigns.tasks import TaskReport, Unusable
from geometries.errors import Failure

# --- pauses ---------------------------------------------------------------------------------------------


REPORTED_AFTER = 10.0  # seconds of a pause
GIVE_UP_AFTER = 25.0  # seconds in which all workers are paused, and none has a task at work
REMEDY = (
    "give workers more memory (dask worker --memory-limit) and one thread each (--nthreads 1), start fewer "
    "on a machine, or more elsewhere"
)

Workers = Mapping[str, Mapping[str, Any]]  # by address, as a scheduler describes them


@dataclass
class Pauses:
    """Pauses of workers so far, and messages about them."""

    on_message: Callable[[str], None]
    clock: Callable[[], float]
    reported: bool = False  # whether workers have been paused for long
    _begin: float | None = field(default=None, init=False)  # when some were paused, without an end since
    _idle: float | None = field(default=None, init=False)  # when the last one had a task at work

    def update(self, workers: Workers) -> None:
        """Report pauses, once; raise Failure where no task can progress any more."""
        now, paused = self.clock(), [worker for worker in workers.values() if _is_paused(worker)]
        self._begin = _since(self._begin, now) if paused else None
        stuck = bool(paused) and len(paused) == len(workers) and not any(map(_at_work, paused))
        self._idle = _since(self._idle, now) if stuck else None
        if self._begin is not None and now - self._begin >= REPORTED_AFTER and not self.reported:
            self.reported = True
            self.on_message(
                f"{_count_paused(paused, workers)}: the campaign goes on with fewer tasks at once. "
                f"If that lasts: {REMEDY}"
            )
        if self._idle is not None and now - self._idle >= GIVE_UP_AFTER:
            raise Failure(
                f"{_count_paused(paused, workers)}, and none has a task at work: {REMEDY}. Finished scenes "
                "are stored: run the same command to continue"
            )


def running(workers: Workers) -> int:
    """Return the number of workers that take tasks."""
    return sum(not _is_paused(worker) for worker in workers.values())


def _since(before: float | None, now: float) -> float:
    return now if before is None else before


def _is_paused(worker: Mapping[str, Any]) -> bool:
    return bool(worker.get("status") == "paused")


def _at_work(worker: Mapping[str, Any]) -> bool:
    """Whether a worker has a task at work."""
    return bool(worker.get("metrics", {}).get("task_counts", {}).get("executing", 0))


def _count_paused(paused: list[Mapping[str, Any]], workers: Workers) -> str:
    """Return the number of paused workers, and the memory of the largest."""
    largest = max(paused, key=lambda worker: float(worker.get("metrics", {}).get("memory", 0)))
    memory, limit = largest.get("metrics", {}).get("memory", 0), largest.get("memory_limit") or 0
    used = f" ({memory / 2**20:.0f} of {limit / 2**20:.0f} MB)" if limit else ""
    return f"{len(paused)} of {len(workers)} workers are paused by Dask for their memory{used}"


# --- tasks ----------------------------------------------------------------------------------------------


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
