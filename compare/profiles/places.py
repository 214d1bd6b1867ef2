"""Folders of the pages of profiles: none is written over that of another file."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import xarray as xr

from compare.profiles.understood import Understood

DATASET = "profile.nc"


def folders_of(profiles: Sequence[Understood], out: Path) -> list[Path]:
    """Return a folder in `out` for each profile: the first of its names that has no page of another file."""
    result: list[Path] = []
    for one in profiles:
        free = (
            folder for name in names_of(one) if _is_free(folder := out / name, one) and folder not in result
        )
        result.append(next(free))
    return result


def names_of(profile: Understood) -> Iterator[str]:
    """Yield names of a folder: that of the file, with its ending, with its folders, and numbered."""
    name, path = profile.figure.name, Path(profile.file)
    yield name
    name = f"{name}-{path.suffix.removeprefix('.') or 'profile'}"
    yield name
    for parent in path.parents[:-1]:
        name = f"{parent.name}-{name}"
        yield name
    number = 1
    while True:
        number += 1
        yield f"{name}-{number}"


def _is_free(folder: Path, profile: Understood) -> bool:
    """Whether a folder has no page, or one of this profile."""
    path = folder / DATASET
    if not path.is_file():
        return True
    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            return bool(dataset.attrs.get("file") == profile.file)
    except OSError:  # no dataset: left by an interrupted run
        return True
