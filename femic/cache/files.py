"""Files of results that appear whole or not at all.

A file is written under a temporary name, checked, and then moved: it is either complete or unchanged, even if
other processes write it or this one is killed.
"""

from __future__ import annotations

import json
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from uuid import uuid4

import numpy as np

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


OLD_FORM = b"CDF"  # first bytes of NetCDF-3
ORDER = "order_of_variables"  # attribute: these files have them by size
SMALL = 16_000_000  # bytes of datasets that take this form, with values of these types or words
SIMPLE = {np.dtype(kind) for kind in (np.float64, np.float32, np.int64, np.bool_)}


def compact_netcdf(dataset: xr.Dataset) -> bytes:
    """Return a NetCDF file; with a small dataset in the older form, which is read thirty times as fast."""
    kinds = {variable.dtype for variable in dataset.variables.values() if variable.dtype.kind not in "UO"}
    if dataset.nbytes < SMALL and kinds <= SIMPLE:
        content = BytesIO()
        file = xr.backends.ScipyDataStore(content, mode="w", format="NETCDF3_64BIT")
        try:
            dataset.assign_attrs({ORDER: json.dumps(list(dataset.data_vars))}).dump_to_store(file)
            file.sync()
            return content.getvalue()
        except (KeyError, TypeError, ValueError):  # a list of words, or a number with more than 32 bits
            pass
    return netcdf(dataset)


def read_netcdf(content: bytes) -> xr.Dataset:
    """Return the dataset of a file of either form: whole numbers have 64 bits, and words are no objects."""
    if not content.startswith(OLD_FORM):
        return xr.load_dataset(BytesIO(content), engine="h5netcdf")
    dataset = xr.load_dataset(BytesIO(content), engine="scipy")
    for attributes in (dataset.attrs, *(variable.attrs for variable in dataset.variables.values())):
        attributes.update({name: _as_usual(value) for name, value in attributes.items()})
    wide = {"i": np.int64, "O": np.str_}
    usual: dict[Hashable, tuple[object, ...]] = {
        name: (variable.dims, variable.values.astype(wide[variable.dtype.kind]), variable.attrs)
        for name, variable in dataset.variables.items()
        if variable.dtype.kind in wide
    }
    order = json.loads(dataset.attrs.pop(ORDER))
    return dataset.assign(usual)[order]


def _as_usual(value: object) -> object:
    """Return a value of an attribute with 64 bits, in this machine's order of bytes."""
    kind = getattr(value, "dtype", np.dtype(object)).kind
    return np.asarray(value).astype({"i": np.int64, "f": np.float64}[kind])[()] if kind in "if" else value


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
