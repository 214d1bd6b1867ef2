"""Workers that Dask has paused because memory is short: they take no tasks until there is room again."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from geometries.errors import Failure

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
                f"{_counted(paused, workers)}: the campaign goes on with fewer tasks at once. If that lasts: "
                f"{REMEDY}"
            )
        if self._idle is not None and now - self._idle >= GIVE_UP_AFTER:
            raise Failure(
                f"{_counted(paused, workers)}, and none has a task at work: {REMEDY}. Finished scenes "
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


def _counted(paused: list[Mapping[str, Any]], workers: Workers) -> str:
    """Return the number of paused workers, and the memory of the largest."""
    largest = max(paused, key=lambda worker: float(worker.get("metrics", {}).get("memory", 0)))
    memory, limit = largest.get("metrics", {}).get("memory", 0), largest.get("memory_limit") or 0
    used = f" ({memory / 2**20:.0f} of {limit / 2**20:.0f} MB)" if limit else ""
    return f"{len(paused)} of {len(workers)} workers are paused by Dask for their memory{used}"
