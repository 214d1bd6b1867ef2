"""Threads of this program and of the numerical libraries."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from threadpoolctl import threadpool_limits

Argument = TypeVar("Argument")
Result = TypeVar("Result")

AHEAD = 2  # results and arguments at work per worker, while the first result is waited for


def in_threads(
    function: Callable[[Argument], Result], arguments: Iterable[Argument], workers: int
) -> Iterator[Result]:
    """Yield the results of a function for arguments, in their order; a single worker is this thread.

    At most `AHEAD` results per worker wait to be taken. After an error or Ctrl-C the threads finish their
    current argument first: a program that ends while they run loses its exit code.
    """
    if workers == 1:
        yield from map(function, arguments)
        return
    pool, waiting = ThreadPoolExecutor(workers), deque[Future[Result]]()
    try:
        for argument in arguments:
            waiting.append(pool.submit(function, argument))
            if len(waiting) > AHEAD * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


def one_blas_thread() -> threadpool_limits:
    """A context with one BLAS thread.

    More threads slow sparse sweeps and products of small matrices down, because they mostly wait for each
    other. Displacements from responses take twice as long with two.
    """
    return threadpool_limits(limits=1, user_api="blas")
