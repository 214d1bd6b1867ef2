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

Given = TypeVar("Given")
Made = TypeVar("Made")

SET_DEATH_SIGNAL = 1  # Linux: PR_SET_PDEATHSIG of prctl
LOOK_EVERY = 0.5  # seconds, at whether the parent is there


def in_processes(function: Callable[[Given], Made], given: Iterable[Given], workers: int) -> Iterator[Made]:
    """What a function makes of each thing given, as it is finished; `workers` at a time, one: here.

    Each thing is taken from `given` when a process is free for it.
    """
    run = Parallel(
        n_jobs=workers,
        return_as="generator_unordered",
        pre_dispatch=workers,
        batch_size=1,
        initializer=end_with_parent,
        initargs=(os.getpid(),),
    )
    yield from run(delayed(function)(one) for one in given)


def end_with_parent(parent: int) -> None:
    """Let this process be killed when its parent ends.

    Linux does so by itself, in the middle of a long computation, too, already when the thread ends that
    started this process; elsewhere a thread looks at the parent. `parent` is its process id: it may have
    ended before this was called.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(SET_DEATH_SIGNAL, signal.SIGKILL)
        _end_without(parent)
    else:
        Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while True:
        _end_without(parent)
        sleep(LOOK_EVERY)


def _end_without(parent: int) -> None:
    """End at once, without cleaning up, if the parent is gone: another process has taken its place."""
    if os.getppid() != parent:
        os._exit(1)
