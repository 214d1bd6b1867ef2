"""The workers of a cluster, the tasks that they have been given, and the ends of these."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from time import perf_counter

from distributed import CancelledError, Client, Future, KilledWorker

from femic.campaigns.running.paused import Pauses, running
from femic.campaigns.running.tasks import Receipt, Unusable
from geometries.errors import Failure

SCENES_PER_WORKER = 4  # that the scheduler has at a time: enough for no worker to wait for this process
GONE = "the scheduler is gone; finished scenes are kept: start it again, and run the same command"
COUNT_EVERY = 1.0  # s between countings of workers
ANSWERS_WITHIN = 60.0  # s in which the scheduler hands over a receipt


@dataclass(eq=False)
class Crew:
    """The workers of a cluster, and the tasks that they have been given."""

    client: Client
    on_message: Callable[[str], None]
    open: set[Future] = field(default_factory=set)  # submitted, and not ended
    ended: SimpleQueue[Future] = field(default_factory=SimpleQueue)
    workers: int = 0
    running: int = 0  # workers that are not paused
    pauses: Pauses = field(init=False)

    def __post_init__(self) -> None:
        self.pauses = Pauses(self.on_message, perf_counter)
        self.count()

    @property
    def window(self) -> int:
        """The number of scenes that the scheduler should have: one per worker once memory ran out."""
        return (1 if self.pauses.seen else SCENES_PER_WORKER) * max(1, self.running)

    def submit(self, task: Callable[..., Receipt], *given: object, priority: int = 0) -> Future:
        """Submit a task."""
        future = self.client.submit(task, *given, priority=priority, pure=False)
        self.open.add(future)
        future.add_done_callback(self.ended.put)
        return future

    def endings(self) -> Iterator[Future]:
        """Yield tasks as they end, until none is left; raises Failure as `count`."""
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
        """Count the workers; raises Failure where the scheduler is gone, or all workers stay paused."""
        workers = self.client.scheduler_info(n_workers=-1).get("workers")
        if workers is None or self.client.status != "running":
            raise Failure(GONE)
        if self.workers and not workers:
            self.on_message("there are no workers any more; waiting for others (Ctrl-C: go on another time)")
        self.workers, self.running = len(workers), running(workers)
        self.pauses.update(workers)


def receipt_of(future: Future) -> Receipt:
    """Return the receipt of a task; raises Failure where the campaign cannot go on."""
    try:
        receipt: Receipt = future.result(timeout=ANSWERS_WITHIN)
    except CancelledError as error:
        raise Failure(GONE) from error
    except KilledWorker as error:
        return Receipt(
            f"its worker died {error.allowed_failures + 1} times, most likely for memory: give fewer workers "
            "(--workers), larger cells or a larger tolerance; run again to try again"
        )
    except Unusable:
        raise
    except Exception as error:  # one scene must not end the others
        return Receipt(f"{type(error).__name__}: {error}")
    return receipt
