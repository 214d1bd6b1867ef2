"""Damaged scenes of a campaign's dataset: scenes whose values do not match their checksum."""

import shutil
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import xarray as xr
import zarr

from femic.campaigns.dataset.checksums import (
    CHECKSUM,
    LAYOUT,
    SCENE_VARIABLES,
    Checksums,
    layout_of,
    outcome_checksums,
    value_checksums,
)
from geometries.arrays import Mask
from geometries.errors import Failure

REMEDY = "run the campaign again to replace them"


@dataclass(frozen=True, eq=False)
class Verified:
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


def require_layout(dataset: xr.Dataset) -> None:
    """Raise Failure where variables, axes, labels or attributes are damaged."""
    missing = {*SCENE_VARIABLES} - {*dataset.variables}
    if missing:
        raise Failure(f"no {', '.join(sorted(missing))}")
    if layout_of(dataset, dataset, dataset.attrs) != dataset.attrs.get(LAYOUT):
        raise Failure("axes, labels or attributes are not those that were written")


def require_undamaged(path: Path, dataset: xr.Dataset) -> None:
    """Raise Failure where anything in the dataset of a campaign's file is damaged."""
    try:
        require_layout(dataset)
        damaged = verified(path, dataset).damaged if path.is_dir() else damaged_in_memory(dataset)
    except Exception as error:  # whatever zarr and xarray raise
        raise Failure(f"{path}: damaged ({error}): {REMEDY}") from error
    if np.any(damaged):
        raise Failure(f"{path}: {np.sum(damaged)} scenes are damaged: {REMEDY}")


def damaged_in_memory(dataset: xr.Dataset) -> Mask:
    """Return which scenes of a dataset, or of a part of it, are damaged, over the swept dims."""
    swept = dataset[CHECKSUM].dims
    sums = np.zeros(dataset[CHECKSUM].shape, dtype=np.uint64)
    for name, variable in dataset.data_vars.items():
        if name not in SCENE_VARIABLES:
            sums += value_checksums(str(name), variable.transpose(*swept, ...).values, len(swept))
    return _differing(dataset, sums)


def verified(path: Path, dataset: xr.Dataset) -> Verified:
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
    return Verified(_differing(dataset, sums) | (lost & _finished(dataset)), chunks)


def _differing(dataset: xr.Dataset, sums: Checksums) -> Mask:
    """Return where the checksums of variables and outcomes do not sum up to those of finished scenes."""
    failures, seconds, digests = (dataset[name].values.ravel() for name in ("failure", "seconds", "digest"))
    totals = sums + outcome_checksums(map(str, failures), seconds, digests).reshape(sums.shape)
    return np.asarray(_finished(dataset) & (totals != dataset[CHECKSUM].values))


def _finished(dataset: xr.Dataset) -> Mask:
    """Return which scenes have a checksum or a digest."""
    return np.asarray((dataset.digest.values != 0) | (dataset[CHECKSUM].values != 0))
