"""Threads of this program and of the numerical libraries."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from threadpoolctl import threadpool_limits

Argument = TypeVar("Argument")
Result = TypeVar("Result")


def in_threads(
    function: Callable[[Argument], Result], arguments: Sequence[Argument], workers: int
) -> Iterator[Result]:
    """Yield the results of a function for arguments, in their order; a single worker is this thread.

    After an error or Ctrl-C the threads finish their current argument first: a program that ends while they
    run loses its exit code.
    """
    if workers == 1:
        yield from map(function, arguments)
        return
    pool = ThreadPoolExecutor(workers)
    try:
        yield from pool.map(function, arguments)
    finally:
        pool.shutdown(cancel_futures=True)


def one_blas_thread() -> threadpool_limits:
    """A context with one BLAS thread.

    More threads slow sparse sweeps and products of small matrices down, because they mostly wait for each
    other. Displacements from responses take twice as long with two.
    """
    return threadpool_limits(limits=1, user_api="blas")
