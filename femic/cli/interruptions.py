"""Ctrl-C that arrives where Python cannot raise it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from signal import SIGINT, pthread_kill
from threading import Timer, main_thread

DELAY = 0.05  # seconds: the destructor or callback has ended by then


@contextmanager
def delivered() -> Iterator[None]:
    """Deliver an interruption again that arrived in a destructor or in a callback of a library.

    Python prints its traceback there and goes on, as if nobody had pressed Ctrl-C.
    """
    before = sys.unraisablehook

    def hook(raised: "sys.UnraisableHookArgs") -> None:
        if raised.exc_type is not KeyboardInterrupt:
            before(raised)
            return
        again = Timer(DELAY, pthread_kill, (main_thread().ident, SIGINT))
        again.daemon = True
        again.start()

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before
