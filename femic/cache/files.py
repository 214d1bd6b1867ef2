"""Files of results that appear whole or not at all.

A file is written under a temporary name, checked, and then moved: it is either complete or unchanged, even if
other processes write it or this one is killed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from geometries.errors import Failure

if TYPE_CHECKING:
    import xarray as xr

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

    Raises Failure where the file has other bytes than were written.
    """
    content = bytes(dataset.to_netcdf(engine="h5netcdf"))
    with replacing(path) as unfinished:
        unfinished.write_bytes(content)
        if unfinished.read_bytes() != content:
            raise Failure(f"{path}: cannot be read back as written; check the disk")
    return path


def remove_unfinished(folder: Path) -> None:
    """Remove the unfinished files of ended processes from a folder."""
    for path in folder.glob(f"{UNFINISHED}*"):
        path.unlink(missing_ok=True)
