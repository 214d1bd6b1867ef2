"""The file of a campaign's dataset, and its integrity: checksums reveal damage.

The checksum of a scene is the sum of 64-bit numbers of its variables, message, seconds and digest. Missing
variables (all NaN) have the number 0, so that it does not matter which variables other scenes have.
"""

import json
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import blake2b, sha256
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr

from geometries.arrays import Array, Mask
from geometries.errors import Failure

# --- the file -------------------------------------------------------------------------------------------


FILE, ZARR = "sweep.nc", "sweep.zarr"


def file_in(folder: Path) -> Path:
    """Return the path of the dataset in a campaign's folder."""
    large = folder / ZARR
    return large if large.is_dir() else folder / FILE


def open_sweep(path: Path) -> xr.Dataset:
    """Open the dataset in a campaign's folder, or its file `sweep.nc` or `sweep.zarr`.

    A large one is read as it is used. Raises FileNotFoundError where there is none.
    """
    file = path if path.suffix in {".nc", ".zarr"} else file_in(path)
    if file.suffix == ".zarr":
        return xr.open_zarr(file, consolidated=False, chunks=None)
    return xr.load_dataset(file, engine="h5netcdf")


# --- checksums ------------------------------------------------------------------------------------------


CHECKSUM = "checksum"  # the variable of checksums
LAYOUT = "layout"  # the attribute with the digest of everything that is not of a scene
SCENE_VARIABLES = ("failure", "seconds", "digest", CHECKSUM)  # variables over the swept dims only
SIZE = 8  # bytes
REMEDY = "run the campaign again to replace them"

Checksums = np.ndarray[Any, np.dtype[np.uint64]]


@dataclass(frozen=True, eq=False)
class StoreCondition:
    """The condition of a zarr store: damaged scenes over the swept dims, and unreadable chunks."""

    damaged: Mask
    chunks: list[Path] = field(default_factory=list)

    def remove_chunks(self) -> None:
        """Remove unreadable chunks: their values are NaN then."""
        for path in self.chunks:
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)


def value_checksums(name: str, values: np.ndarray[Any, Any], dims: int = 0) -> Checksums:
    """Return numbers for the values of a variable, over its first `dims` dims (those of the campaign)."""
    shape = values.shape[:dims]
    rows = np.ascontiguousarray(values).reshape(int(np.prod(shape)), -1)
    missing = np.isnan(rows)
    plain = np.where(missing, np.nan, rows) if np.any(missing) else rows  # all NaN have the same bits
    numbers = np.zeros(len(rows), dtype=np.uint64)
    named = blake2b(f"{name}\0".encode(), digest_size=SIZE)
    for k in np.flatnonzero(~np.all(missing, axis=1)):
        row_digest = named.copy()
        row_digest.update(plain[k])
        numbers[k] = int.from_bytes(row_digest.digest())
    return numbers.reshape(shape)


def outcome_checksums(failures: Iterable[str], seconds: Array, digests: Checksums) -> Checksums:
    """Return numbers for messages, seconds and digests of scenes, (n_scenes,); 0: not computed."""
    outcomes = zip(failures, seconds.tolist(), digests.tolist(), strict=True)
    return np.array(
        [
            0 if not failure and np.isnan(took) else _number(failure, took, digest)
            for failure, took, digest in outcomes
        ],
        dtype=np.uint64,
    )


def layout_of(dataset: xr.Dataset, template: xr.Dataset, attributes: Mapping[str, Any]) -> str:
    """Return the digest of coordinates, attributes, and names, dims and types of variables.

    The variables are those of `template`, with or without the swept dims.
    """
    swept = dataset[CHECKSUM].dims
    coords = {
        str(name): [labels.dims, labels.values.tolist(), labels.attrs]
        for name, labels in dataset.coords.items()
        if name not in SCENE_VARIABLES
    }
    variables = {
        str(name): [[dim for dim in variable.dims if dim not in swept], variable.dtype.str, variable.attrs]
        for name, variable in template.data_vars.items()
        if name not in SCENE_VARIABLES
    }
    others = {name: value for name, value in attributes.items() if name != LAYOUT}
    text = json.dumps([coords, variables, others], sort_keys=True, default=lambda value: value.tolist())
    return sha256(text.encode()).hexdigest()


def require_layout(dataset: xr.Dataset) -> None:
    """Raise Failure where variables, axes, labels or attributes are damaged."""
    missing = {*SCENE_VARIABLES} - {*dataset.variables}
    if missing:
        raise Failure(f"no {', '.join(sorted(missing))}")
    if layout_of(dataset, dataset, dataset.attrs) != dataset.attrs.get(LAYOUT):
        raise Failure("axes, labels or attributes are not those that were written")


@contextmanager
def damage_reported(path: Path) -> Iterator[None]:
    """Raise Failure for whatever zarr and xarray raise within the context, which reads a file."""
    try:
        yield
    except Exception as error:
        raise Failure(f"{path}: damaged ({error}): {REMEDY}") from error


def open_undamaged(path: Path) -> xr.Dataset:
    """Open the dataset of a campaign's file; raise Failure where anything in it is damaged."""
    with damage_reported(path):
        dataset = open_sweep(path)
        require_layout(dataset)
        damaged = store_condition(path, dataset).damaged if path.is_dir() else damaged_in_memory(dataset)
    if np.any(damaged):
        raise Failure(f"{path}: {np.sum(damaged)} scenes are damaged: {REMEDY}")
    return dataset


def damaged_in_memory(dataset: xr.Dataset) -> Mask:
    """Return which scenes of a dataset, or of a part of it, are damaged, over the swept dims."""
    swept = dataset[CHECKSUM].dims
    sums = np.zeros(dataset[CHECKSUM].shape, dtype=np.uint64)
    for name, variable in dataset.data_vars.items():
        if name not in SCENE_VARIABLES:
            sums += value_checksums(str(name), variable.transpose(*swept, ...).values, len(swept))
    return _differing(dataset, sums)


def store_condition(path: Path, dataset: xr.Dataset) -> StoreCondition:
    """Return the condition of the zarr store of a dataset, read chunk by chunk."""
    group, dims = zarr.open_group(path, mode="r"), dataset[CHECKSUM].ndim
    sums = np.zeros(dataset[CHECKSUM].shape, dtype=np.uint64)
    lost, chunks = np.zeros(sums.shape, dtype=bool), []
    for name in dataset.data_vars.keys() - {*SCENE_VARIABLES}:
        values = group[str(name)]
        for place in np.ndindex(*values.cdata_shape):
            box = tuple(
                slice(k * size, (k + 1) * size)
                for k, size in zip(place[:dims], values.chunks[:dims], strict=True)
            )
            chunk = path / str(name) / values.metadata.encode_chunk_key(place)
            try:
                part = np.asarray(values.blocks[place])
            except Exception:  # whatever zarr and its codecs raise
                part = None
            if part is None or chunk.is_dir():
                lost[box] = True
                chunks.append(chunk)
            else:
                sums[box] += value_checksums(str(name), part, dims)
    return StoreCondition(_differing(dataset, sums) | (lost & _find_finished(dataset)), chunks)


def _differing(dataset: xr.Dataset, sums: Checksums) -> Mask:
    """Return where the checksums of variables and outcomes do not sum up to those of finished scenes."""
    failures, seconds, digests = (dataset[name].values.ravel() for name in ("failure", "seconds", "digest"))
    totals = sums + outcome_checksums(map(str, failures), seconds, digests).reshape(sums.shape)
    return np.asarray(_find_finished(dataset) & (totals != dataset[CHECKSUM].values))


def _find_finished(dataset: xr.Dataset) -> Mask:
    """Return which scenes have a checksum or a digest."""
    return np.asarray((dataset.digest.values != 0) | (dataset[CHECKSUM].values != 0))


def _number(*of: object) -> int:
    return int.from_bytes(blake2b(repr(of).encode(), digest_size=SIZE).digest())
