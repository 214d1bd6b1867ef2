"""The only module that loads Gmsh: late, because Gmsh needs system libraries, and one model at a time."""

import ctypes
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from geometries.errors import Failure


class MissingSystemLibrary(Failure):
    """A shared library of the operating system is missing; the message says how to install it."""


def load_gmsh() -> ModuleType:
    """Import gmsh; raises MissingSystemLibrary where it cannot be loaded."""
    try:
        import gmsh
    except OSError as error:
        raise MissingSystemLibrary(
            f"Gmsh cannot be loaded: {error}. Run `sh tools/system-libraries.sh`: it installs "
            "the missing system packages, or says what to ask the administrator for"
        ) from error
    return gmsh


@contextmanager
def gmsh_session() -> Iterator[ModuleType]:
    """A context with an empty, silent, repeatable Gmsh model; Python keeps the handling of Ctrl-C.

    Errors of Gmsh are raised as Failure.
    """
    gmsh = load_gmsh()
    gmsh.initialize(interruptible=False)
    _ignore_closed_connections()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield gmsh
    except Exception as error:
        if type(error) is Exception:  # what Gmsh raises
            raise Failure(
                f"Gmsh: {error}. Likely cause: a contour that crosses itself or the far arc"
            ) from error
        raise
    finally:
        gmsh.finalize()


def _ignore_closed_connections() -> None:
    """Have writes to closed connections raise again: Gmsh lets them end the process (SIGPIPE).

    Python can say that in the main thread only, C in any.
    """
    if signal.getsignal(signal.SIGPIPE) is signal.SIG_IGN:
        set_handler = ctypes.CDLL(None).signal
        set_handler.argtypes, set_handler.restype = (ctypes.c_int, ctypes.c_void_p), ctypes.c_void_p
        set_handler(signal.SIGPIPE, signal.SIG_IGN.value)
