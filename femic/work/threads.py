"""Threads of the numerical libraries."""

from threadpoolctl import threadpool_limits


def one_blas_thread() -> threadpool_limits:
    """Sparse sweeps run on one core; BLAS threads waiting for the next tiny product slow them down."""
    return threadpool_limits(limits=1, user_api="blas")
