"""Threads of the numerical libraries."""

from threadpoolctl import threadpool_limits


def one_blas_thread() -> threadpool_limits:
    """A context with one BLAS thread.

    More of them slow sparse sweeps and products of small matrices down: they wait for each other most of the
    time. Displacements from responses take twice as long with two.
    """
    return threadpool_limits(limits=1, user_api="blas")
