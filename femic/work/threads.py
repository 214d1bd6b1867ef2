"""Threads of the numerical libraries."""

from threadpoolctl import threadpool_limits


def one_blas_thread() -> threadpool_limits:
    """A context with one BLAS thread: more threads, which wait for tiny products, slow sparse sweeps down."""
    return threadpool_limits(limits=1, user_api="blas")
