"""Folders of results: checked before any work, each written by one run at a time."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from femic.cache.files import remove_unfinished
from geometries.errors import Failure, WrongInput

LOCK = ".femic.lock"
FOLDERS = ("figures", "fields", "store")  # in results
SUFFIXES = (".csv", ".html", ".json", ".nc", ".png", ".toml", ".txt")  # of files of results
OTHER = "rename it, or name another folder"


def check(folder: Path) -> Path:
    """Return a folder; raises WrongInput if it, or a name in it that results need, is taken."""
    if folder.exists() and not folder.is_dir():
        raise WrongInput(f"--out {folder}: this is a file; name a folder")
    for path in (folder / name for name in FOLDERS):
        if path.is_file():
            raise WrongInput(f"--out {folder}: {path.name} in it is a file, not a folder of results: {OTHER}")
    for path in folder.glob("*"):
        if path.suffix in SUFFIXES and path.is_dir():
            raise WrongInput(f"--out {folder}: {path.name} in it is a folder, not a file of results: {OTHER}")
    return folder


def make(folder: Path) -> Path:
    """Create a folder where it does not exist, and return it.

    Raises WrongInput as `check` does, and if it cannot be created.
    """
    try:
        check(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _not_usable(folder, error) from error
    return folder


@contextmanager
def locked(folder: Path) -> Iterator[Path]:
    """A context with a folder, created if it does not exist, that no other run writes into.

    The lock ends with its process, even if that is killed; unfinished files are removed. Raises
    WrongInput as `make` does and where nothing can be written there, Failure where another run does.
    """
    path = make(folder) / LOCK
    lock = FileLock(path, fallback_to_soft=False)
    try:
        path.touch()
        lock.acquire(timeout=0)
    except Timeout as error:
        raise Failure(
            f"{folder}: another femic run writes there. Wait until it ends, or give another folder "
            "(--out); the runs can share a store (--store)"
        ) from error
    except (OSError, NotImplementedError) as error:
        raise _not_usable(folder, error) from error
    try:
        for own in (folder, *(folder / name for name in FOLDERS)):  # others may have runs of their own
            remove_unfinished(own)
        yield folder
    finally:
        lock.release()


def require_usable(folder: Path) -> Path:
    """Return a folder, created if it does not exist; raises as `locked` does."""
    with locked(folder):
        return folder


def _not_usable(folder: Path, error: Exception) -> WrongInput:
    reason = error.strerror if isinstance(error, OSError) else str(error)
    return WrongInput(f"--out {folder}: cannot write there ({reason}): name another folder")
