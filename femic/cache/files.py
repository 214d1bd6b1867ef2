"""Files of results that appear whole or not at all.

A file is written under a temporary name, checked, and then moved: it is either complete or unchanged, even if
other processes write it or this one is killed.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from uuid import uuid4

from femic.lazy import lazy_imports
from geometries.errors import Failure

with lazy_imports():
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


def netcdf(dataset: xr.Dataset) -> bytes:
    """Return the content of a NetCDF file with a dataset.

    Without xarray's lock, for which it would ask the scheduler of any Dask cluster of this process: each file
    would cost messages, and none could be written after the cluster has ended. h5py locks HDF5 itself.
    """
    content = BytesIO()
    with xr.backends.H5NetCDFStore.open(content, mode="w", lock=False) as file:
        dataset.dump_to_store(file)
    return content.getvalue()


def write_dataset(dataset: xr.Dataset, path: Path) -> Path:
    """Write a NetCDF file, read it back, and return its path.

    Raises Failure where the file has other bytes than were written.
    """
    content = netcdf(dataset)
    with replacing(path) as unfinished:
        unfinished.write_bytes(content)
        if unfinished.read_bytes() != content:
            raise Failure(f"{path}: cannot be read back as written; check the disk")
    return path


def remove_unfinished(folder: Path) -> None:
    """Remove the unfinished files of ended processes from a folder."""
    for path in folder.glob(f"{UNFINISHED}*"):
        path.unlink(missing_ok=True)
