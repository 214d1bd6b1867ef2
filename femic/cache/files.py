"""Files of results: each is written under a name of its own, checked, and then moved to its place.

So a file is complete or as it was before, whoever else writes the same one, and whenever this process ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

from femic.late import Late
from geometries.errors import Failure

if TYPE_CHECKING:
    import xarray as xr

open_dataset = Late("xarray:open_dataset")

UNFINISHED = ".unfinished."  # within the names of files that are being written


@contextmanager
def published(path: Path) -> Iterator[Path]:
    """The path of a new file, with the suffix of `path`, whose place it takes at the end.

    Nothing is left of it if writing fails.
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
    with published(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
    return path


def write_dataset(dataset: xr.Dataset, path: Path) -> Path:
    """Write a NetCDF file, read it back, and return its path.

    Raises Failure where it does not hold what was written.
    """
    with published(path) as unfinished:
        dataset.to_netcdf(unfinished, engine="h5netcdf")
        with open_dataset(unfinished, engine="h5netcdf") as found:
            wrong = [name for name in dataset.variables if not dataset[name].equals(found[name])]
        if wrong:
            names = ", ".join(map(str, wrong))
            raise Failure(f"{path}: {names} of it cannot be read back as written: is the disk sound?")
    return path


def remove_unfinished(folder: Path) -> None:
    """Remove files in a folder that ended processes have not finished."""
    for path in folder.glob(f"{UNFINISHED}*"):
        path.unlink(missing_ok=True)
