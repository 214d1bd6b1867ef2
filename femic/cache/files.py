"""Files of results that appear whole or not at all, and their folders, each written by one run at a time.

A file is written under a temporary name, checked, and then moved: it is either complete or unchanged, even if
other processes write it or this one is killed. Folders are checked before any work.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from filelock import FileLock, Timeout

from femic.late import Late
from geometries.errors import Failure, WrongInput

if TYPE_CHECKING:
    import xarray as xr


open_dataset = Late("xarray:open_dataset")


# --- files ---

UNFINISHED = ".unfinished."  # in the names of unfinished files


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A context with the path of a new file, which replaces `path` at the end and has its suffix.

    The new file is removed if writing fails.
    """
    unfinished = path.with_name(f"{UNFINISHED}{uuid4().hex}.{path.name}")
    try:
        yield unfinished
        unfinished.replace(path)
    except BaseException:
        unfinished.unlink(missing_ok=True)
        raise


def write_text(text: str, path: Path) -> Path:
    """Write a text file and return its path."""
    with replacing(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    return path


def write_dataset(dataset: xr.Dataset, path: Path) -> Path:
    """Write a NetCDF file, read it back, and return its path.

    Raises Failure where the file differs from the dataset.
    """
    with replacing(path) as unfinished:
        dataset.to_netcdf(unfinished, engine="h5netcdf")
        with open_dataset(unfinished, engine="h5netcdf") as written:
            wrong = [name for name in dataset.variables if not dataset[name].equals(written[name])]
        if wrong:
            names = ", ".join(map(str, wrong))
            raise Failure(f"{path}: {names} of it cannot be read back as written: is the disk sound?")
    return path


def remove_unfinished(folder: Path) -> None:
    """Remove the unfinished files of ended processes from a folder."""
    for path in folder.glob(f"{UNFINISHED}*"):
        path.unlink(missing_ok=True)


# --- folders ---

LOCK = ".femic.lock"
FOLDERS = ("figures", "fields", "store")  # in results
SUFFIXES = (".csv", ".html", ".json", ".nc", ".png", ".toml", ".txt")  # of files of results
OTHER = "rename it, or name another folder"


def check(folder: Path) -> Path:
    """Return a folder; raises WrongInput if it, or a name in it that results need, is taken."""
    if folder.exists() and not folder.is_dir():
        raise WrongInput(f"--out {folder}: is a file; name a folder")
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
            f"{folder}: another femic writes there: wait for its end, or give another folder (--out); both "
            "may share a store (--store)"
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
    return WrongInput(f"--out {folder}: nothing can be written there ({reason}): name another folder")
