"""Parallel work: threads of this program and of the numerical libraries, and processes.

Processes end when this one does, however it ends.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from threading import Thread
from time import sleep
from typing import Any, Generic, Self, TypeVar
from uuid import uuid4

from joblib import Parallel, delayed
from joblib.externals.loky import ProcessPoolExecutor
from threadpoolctl import threadpool_limits

from geometries.errors import Failure

Argument = TypeVar("Argument")
Result = TypeVar("Result")


# --- threads ---

AHEAD = 2  # calls per worker that are begun or finished before the result of the first of them is taken


def in_threads(
    function: Callable[[Argument], Result], arguments: Iterable[Argument], workers: int
) -> Iterator[Result]:
    """Yield the results of a function for arguments, in their order; a single worker is this thread.

    At most `AHEAD` calls per worker are ahead of the result that is taken. After an error or Ctrl-C the
    threads finish their current argument first: a program that ends while they run loses its exit code.
    """
    if workers == 1:
        yield from map(function, arguments)
        return
    pool = ThreadPoolExecutor(workers)
    try:
        yield from in_order(pool, function, arguments, AHEAD * workers)
    finally:
        pool.shutdown(cancel_futures=True)


def in_order(
    pool: Executor, function: Callable[[Argument], Result], arguments: Iterable[Argument], ahead: int
) -> Iterator[Result]:
    """Yield the results of a function for arguments, in their order, with some calls ahead."""
    waiting = deque[Future[Result]]()
    for argument in arguments:
        waiting.append(pool.submit(function, argument))
        if len(waiting) >= ahead:
            yield waiting.popleft().result()
    while waiting:
        yield waiting.popleft().result()


def one_blas_thread() -> threadpool_limits:
    """A context with one BLAS thread.

    More threads slow sparse sweeps and products of small matrices down, because they mostly wait for each
    other. Displacements from responses take twice as long with two.
    """
    return threadpool_limits(limits=1, user_api="blas")


# --- processes ---

SET_DEATH_SIGNAL = 1  # Linux: PR_SET_PDEATHSIG of prctl
LOOK_EVERY = 0.5  # seconds between checks whether the parent still runs


def in_processes(
    function: Callable[[Argument], Result], arguments: Iterable[Argument], workers: int
) -> Iterator[Result]:
    """Yield the results of a function for arguments, in the order in which they are finished.

    `workers` processes work in parallel; a single worker is this process. An argument is taken from the
    iterable when a process is free for it.
    """
    parallel = Parallel(
        n_jobs=workers,
        return_as="generator_unordered",
        pre_dispatch=workers,
        batch_size=1,
        initializer=end_with_parent,
        initargs=(os.getpid(),),
    )
    yield from parallel(delayed(function)(argument) for argument in arguments)


class Processes:
    """Processes for one piece of work: they begin with its first call and end with this context."""

    def __init__(self, workers: int) -> None:
        """Take the number of processes; none is begun yet."""
        self._workers = workers
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        """Return these processes."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes, also in the middle of their work."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, kill_workers=True)

    def __call__(
        self, function: Callable[[Argument], Result], arguments: Iterable[Argument]
    ) -> Iterator[Result]:
        """Yield the results of a function for arguments, in their order.

        Raises Failure where a process ends without a result.
        """
        if self._pool is None:
            self._pool = ProcessPoolExecutor(
                self._workers, initializer=end_with_parent, initargs=(os.getpid(),)
            )
        try:
            yield from in_order(self._pool, function, arguments, AHEAD * self._workers)
        except BrokenProcessPool as error:
            raise Failure(
                f"one of {self._workers} worker processes ended without a result. Most likely the system "
                "killed it because memory ran out. Use fewer workers (`workers` = 1) or a larger "
                "`tolerance`. Stored results are kept"
            ) from error


@dataclass(frozen=True, eq=False)
class Prepared(Generic[Argument, Result]):
    """A function that each process prepares once for many arguments; a process keeps the last one only."""

    prepare: Callable[[], Callable[[Argument], Result]]
    name: str = field(default_factory=lambda: uuid4().hex)

    def __call__(self, argument: Argument) -> Result:
        """Return the result of the prepared function for an argument."""
        if self.name not in _PREPARED:
            _PREPARED.clear()
            _PREPARED[self.name] = self.prepare()
        result: Result = _PREPARED[self.name](argument)
        return result


_PREPARED: dict[str, Callable[[Any], Any]] = {}  # of this process, by name


def end_with_parent(parent: int) -> None:
    """Let this process be killed when its parent ends.

    Linux does so by itself, even in the middle of a long computation, and already when the thread ends that
    started this process. On other systems a thread watches the parent. `parent` is its process id: the parent
    may have ended before this function was called.
    """
    if sys.platform != "linux":
        Thread(target=_watch, args=(parent,), daemon=True).start()
        return
    ctypes.CDLL(None, use_errno=True).prctl(SET_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _watch(parent: int) -> None:
    """End this process, without cleaning up, soon after its parent has been replaced by another process."""
    while os.getppid() == parent:
        sleep(LOOK_EVERY)
    os._exit(1)
