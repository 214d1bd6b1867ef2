"""Work in parallel processes that end when this one does, however it ends."""

import ctypes
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from threading import Thread
from time import sleep
from typing import TypeVar

from joblib import Parallel, delayed

Argument = TypeVar("Argument")
Result = TypeVar("Result")

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


def end_with_parent(parent: int) -> None:
    """Let this process be killed when its parent ends.

    Linux does so by itself, even in the middle of a long computation, and already when the thread ends that
    started this process. On other systems a thread watches the parent. `parent` is its process id: the parent
    may have ended before this function was called.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(SET_DEATH_SIGNAL, signal.SIGKILL)
        _end_without(parent)
    else:
        Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    """End this process soon after its parent has ended."""
    while True:
        _end_without(parent)
        sleep(LOOK_EVERY)


def _end_without(parent: int) -> None:
    """End this process at once, without cleaning up, if its parent has been replaced by another process."""
    if os.getppid() != parent:
        os._exit(1)
