"""The only module that loads Gmsh: late, because it needs system libraries, and one model at a time."""

from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from geometries.errors import Failure

SYSTEM_PACKAGES = "libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1 libegl1"


class MissingSystemLibrary(Failure):
    """A shared library of the operating system is missing; the message says how to install it."""


def load_gmsh() -> ModuleType:
    """Import gmsh, or say which system packages to install."""
    try:
        import gmsh
    except OSError as error:
        raise MissingSystemLibrary(
            f"Gmsh cannot be loaded: {error}. Run `make setup` as root, or ask the administrator "
            f"for: apt-get install -y --no-install-recommends {SYSTEM_PACKAGES}"
        ) from error
    return gmsh


@contextmanager
def gmsh_session() -> Iterator[ModuleType]:
    """An empty, silent, repeatable Gmsh model; Ctrl-C stays with Python."""
    gmsh = load_gmsh()
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield gmsh
    finally:
        gmsh.finalize()
