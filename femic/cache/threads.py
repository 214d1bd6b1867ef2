"""Threads of this program and of the numerical libraries."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import TypeVar

from threadpoolctl import threadpool_limits

Argument = TypeVar("Argument")
Result = TypeVar("Result")

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
