"""Threads: of our own, and those of the numerical libraries."""

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

    Where it ends early, by an error or Ctrl-C, threads end with what they are at before it does: a program
    that ends under them loses its exit code.
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

    More of them slow sparse sweeps and products of small matrices down: they wait for each other most of the
    time. Displacements from responses take twice as long with two.
    """
    return threadpool_limits(limits=1, user_api="blas")
