"""Which scenes of a campaign's dataset are damaged: their values are not those of their checksums."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr

from femic.campaigns.checksums import (
    CHECKSUM,
    LAYOUT,
    OF_SCENES,
    Checksums,
    layout_of,
    of_outcomes,
    of_values,
)
from geometries.errors import Failure

Box = tuple[slice, ...]
REMEDY = "run the campaign again, which makes them anew"
Mask = np.ndarray[Any, np.dtype[np.bool_]]


def require_layout(dataset: xr.Dataset) -> None:
    """Raise Failure where what is not of scenes is damaged: variables, axes, labels, attributes."""
    missing = {*OF_SCENES} - {*dataset.variables}
    if missing:
        raise Failure(f"no {', '.join(sorted(missing))}")
    if layout_of(dataset, dataset, dataset.attrs) != dataset.attrs.get(LAYOUT):
        raise Failure("axes, labels or attributes are not those that were written")


def damaged_in_memory(dataset: xr.Dataset) -> Mask:
    """Which scenes of a dataset, or of a part of it, are damaged, over the swept dims."""
    swept = dataset[CHECKSUM].dims
    sums = np.zeros(dataset[CHECKSUM].shape, dtype=np.uint64)
    for name, variable in dataset.data_vars.items():
        if name not in OF_SCENES:
            sums += of_values(str(name), variable.transpose(*swept, ...).values, len(swept))
    return _differ(dataset, sums)


@dataclass(frozen=True, eq=False)
class Verified:
    """What was found in a zarr store: damaged scenes over the swept dims, and chunks that cannot be read."""

    damaged: Mask
    chunks: list[Path] = field(default_factory=list)

    def remove_chunks(self) -> None:
        """Remove the chunks that cannot be read: their values are NaN then."""
        for path in self.chunks:
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)


def verified(path: Path, dataset: xr.Dataset) -> Verified:
    """The scenes of the zarr store of a dataset, read chunk by chunk."""
    group, dims = zarr.open_group(path, mode="r"), dataset[CHECKSUM].ndim
    sums = np.zeros(dataset[CHECKSUM].shape, dtype=np.uint64)
    lost, chunks = np.zeros(sums.shape, dtype=bool), []
    for name in dataset.data_vars.keys() - {*OF_SCENES}:
        values = group[str(name)]
        for place, box in _boxes(values):
            chunk = path / str(name) / values.metadata.encode_chunk_key(place)
            try:
                part = np.asarray(values[box])
            except Exception:  # whatever zarr and its codecs make of it
                part = None
            if part is None or chunk.is_dir():
                lost[box[:dims]] = True
                chunks.append(chunk)
            else:
                sums[box[:dims]] += of_values(str(name), part, dims)
    return Verified(_differ(dataset, sums) | (lost & _finished(dataset)), chunks)


def require_undamaged(path: Path, dataset: xr.Dataset) -> None:
    """Raise Failure where anything in the dataset of a campaign's file is damaged."""
    try:
        require_layout(dataset)
        damaged = verified(path, dataset).damaged if path.is_dir() else damaged_in_memory(dataset)
    except Exception as error:  # whatever zarr and xarray make of it
        raise Failure(f"{path}: damaged ({error}): {REMEDY}") from error
    if np.any(damaged):
        raise Failure(f"{path}: {np.sum(damaged)} scenes are damaged: {REMEDY}")


def _differ(dataset: xr.Dataset, sums: Checksums) -> Mask:
    """Where sums over variables, with the numbers of outcomes, are not the checksums of finished scenes."""
    failures, seconds, digests = (dataset[name].values.ravel() for name in ("failure", "seconds", "digest"))
    found = sums + of_outcomes(map(str, failures), seconds, digests).reshape(sums.shape)
    return np.asarray(_finished(dataset) & (found != dataset[CHECKSUM].values))


def _finished(dataset: xr.Dataset) -> Mask:
    """Which scenes have a checksum or a digest."""
    return np.asarray((dataset.digest.values != 0) | (dataset[CHECKSUM].values != 0))


def _boxes(values: zarr.Array) -> Iterator[tuple[tuple[int, ...], Box]]:
    """Yield the places of the chunks of an array, and what lies in them."""
    counts = [range(-(-size // along)) for size, along in zip(values.shape, values.chunks, strict=True)]
    for place in product(*counts):
        yield (
            place,
            tuple(
                slice(k * along, min((k + 1) * along, size))
                for k, along, size in zip(place, values.chunks, values.shape, strict=True)
            ),
        )
