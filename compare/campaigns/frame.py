"""The frame of a campaign's dataset: dims, coordinates and attributes, and arrays over the scenes.

An array is a zarr group in memory, or in a folder and written chunk by chunk.
"""

import json
import shutil
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr
import zarr
from zarr.storage import MemoryStore

from compare.campaigns.campaign import Campaign, SweptAxis
from compare.campaigns.integrity import SCENE_VARIABLES
from compare.campaigns.keys import is_number
from femic.cache.digests import versions
from femic.scenes.errors import BadScene

# --- arrays over the scenes -----------------------------------------------------------------------------


LARGEST_BUFFER = 32e6  # bytes of finished scenes that wait to be written
DIGEST = "digest"  # the variable of digests
CHUNK = 1e6  # bytes of a chunk of a variable, unless one scene has more

Shape = tuple[int, ...]


@dataclass(eq=False)
class SceneArrays:
    """An array over all scenes per variable, NaN where no scene has been put.

    Finished scenes wait until there are enough for whole chunks. A scene with a digest in a folder has its
    values there: digests are written last, and removed before values change.
    """

    shape: Shape  # of the campaign
    dims: tuple[str, ...]  # of the campaign
    path: Path | None = None  # None: in memory
    group: zarr.Group = field(default_factory=lambda: zarr.create_group(MemoryStore()))
    values: dict[str, zarr.Array] = field(default_factory=dict)
    _buffer: dict[int, xr.Dataset] = field(default_factory=dict)
    _buffered: int = 0  # bytes
    _sealed: set[int] = field(default_factory=set)  # scenes whose digests are in the folder

    @classmethod
    def extended(cls, path: Path, shape: Shape, dims: tuple[str, ...], names: Iterable[str]) -> "SceneArrays":
        """Return arrays `names` of an older folder, with room for more scenes; its other arrays are removed.

        Values keep their places: axes may only have become longer. Digests are to be written at once.
        """
        group = zarr.open_group(path, mode="a")
        values = {name: group[name] for name in names}
        for name in set(group.array_keys()) - values.keys():
            del group[name]
        for array in values.values():
            array.resize((*shape, *array.shape[len(shape) :]))
        return cls(shape, dims, path, group, values)

    def moved(self, path: Path, template: xr.Dataset) -> "SceneArrays":
        """Return the arrays in a new folder, which replaces `path`; `template` describes the variables."""
        if path.exists():
            shutil.rmtree(path)
        new = SceneArrays(self.shape, self.dims, path, zarr.open_group(path, mode="w"))
        new._buffer, new._buffered = self._buffer, self._buffered
        for name, values in self.values.items():
            new.add(name, template[name].variable)
            new.values[name][...] = values[...]
        return new

    def add(self, name: str, variable: xr.Variable) -> None:
        """Add the array of a variable that scenes have."""
        self.values[name] = self.group.create_array(
            name,
            shape=(*self.shape, *variable.shape),
            chunks=(*_chunk(self.shape, variable.nbytes), *variable.shape),
            dtype=variable.dtype,
            fill_value=np.nan,
            dimension_names=(*self.dims, *map(str, variable.dims)),
            attributes=dict(variable.attrs),
            compressors="auto" if self.path else None,
        )

    def put(self, number: int, dataset: xr.Dataset) -> None:
        """Put the variables of a scene; those that it lacks become NaN."""
        if self.values:
            self._buffer[number] = dataset
            self._buffered += dataset.nbytes
        if self._buffered > LARGEST_BUFFER:
            self.flush()

    def flush(self) -> None:
        """Write the scenes that wait, chunk by chunk."""
        self._unseal(self._sealed.intersection(self._buffer))
        numbers = np.array(sorted(self._buffer), dtype=int)
        places = np.column_stack(np.unravel_index(numbers, self.shape))  # (n_scenes, n_dims)
        for name, values in self.values.items():
            chunk = values.chunks[: len(self.shape)]
            corners, corner_of = np.unique(places // chunk, axis=0, return_inverse=True)
            for k, corner in enumerate(corners * chunk):
                box, inside = tuple(map(slice, corner, corner + chunk)), corner_of == k
                part = np.array(values[box])
                for number, place in zip(numbers[inside], places[inside] - corner, strict=True):
                    dataset = self._buffer[number]
                    part[tuple(place)] = dataset[name].values if name in dataset else np.nan
                values[box] = part
        self._buffer.clear()
        self._buffered = 0

    def write(self, frame: xr.Dataset) -> None:
        """Write the waiting scenes, then `frame` (coordinates and outcomes of all scenes), its digests last.

        Checksums come before digests: a scene with a digest has its checksum.
        """
        self.flush()
        for name, labels in frame.coords.items():
            if name in self.group and not np.array_equal(self.group[name][...], labels.values):
                del self.group[name]  # numbers may have become text
        for part in (frame.drop_vars(DIGEST), frame[[DIGEST]]):
            part.to_zarr(self.group.store, mode="a", consolidated=False)
        self._sealed = {*map(int, np.flatnonzero(frame[DIGEST]))}

    def _unseal(self, numbers: set[int]) -> None:
        """Remove the digests of scenes whose values are about to change."""
        if numbers:
            places = np.unravel_index(sorted(numbers), self.shape)
            self.group[DIGEST].set_coordinate_selection(places, np.zeros(len(numbers), dtype=np.uint64))
            self._sealed -= numbers


def _chunk(shape: Shape, size: int) -> Shape:
    """Return the number of scenes in a chunk along each dim; a scene has `size` bytes."""
    room, along = max(1, int(CHUNK // max(size, 1))), list[int]()
    for count in reversed(shape):
        along.append(min(count, room))
        room = max(1, room // count)
    return tuple(reversed(along))


# --- dims, coordinates, attributes ----------------------------------------------------------------------


SAMPLE = "sample"


def swept_dims(campaign: Campaign) -> tuple[str, ...]:
    """Return the dims of the campaign: its axes on a grid, else `SAMPLE`."""
    return tuple(axis.name for axis in campaign.axes) if campaign.is_grid else (SAMPLE,)


def swept_coords(campaign: Campaign) -> dict[str, Any]:
    """Return the values of the axes as coordinates."""
    points = () if campaign.is_grid else zip(*campaign.listed, strict=True)
    columns = [axis.values for axis in campaign.axes] if campaign.is_grid else points
    return {
        axis.name: (
            axis.name if campaign.is_grid else SAMPLE,
            _values(values),
            {"long_name": axis.label} | ({"units": axis.unit} if axis.unit else {}),
        )
        for axis, values in zip(campaign.axes, columns, strict=True)
    }


def require_other_names(campaign: Campaign, names: Iterable[str]) -> None:
    """Raise BadScene where an axis has the name of a result or of one of its dims."""
    reserved = {*names, *SCENE_VARIABLES, SAMPLE}
    for axis in campaign.axes:
        if axis.name in reserved:
            raise BadScene(
                f"sweep.{axis.name}: results have something of that name, too: rename the axis, such as "
                f"{axis.name}_swept"
            )


def attributes_of(campaign: Campaign, code: str) -> dict[str, str | int]:
    """Return the attributes that do not depend on results; `code`: the digest of the code of these."""
    return {
        "title": campaign.title,
        "campaign": campaign.text,
        "table": tomlkit.dumps(campaign.table),
        "axes": json.dumps([_describe_axis(axis) for axis in campaign.axes]),
        "keep": json.dumps(campaign.keep),
        "points": "grid" if campaign.is_grid else "samples",
        "scenes": campaign.size,
        "code": code,
        "versions": json.dumps(versions()),
    }


def continues(campaign: Campaign, code: str, earlier: xr.Dataset) -> bool:
    """Whether an earlier dataset is of this campaign and code, with the first values of each axis."""
    now, coords = attributes_of(campaign, code), xr.Dataset(coords=swept_coords(campaign))
    return (
        all(earlier.attrs[name] == now[name] for name in ("table", "keep", "points", "code"))
        and _keys_of(earlier.attrs["axes"]) == _keys_of(str(now["axes"]))
        and all(
            np.array_equal(earlier[axis.name].values, coords[axis.name].values[: earlier[axis.name].size])
            for axis in campaign.axes
        )
    )


def with_free_text(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with coordinates of text of any length, the only text that zarr has specified."""
    return dataset.assign_coords(
        {name: values.astype(object) for name, values in dataset.coords.items() if values.dtype.kind == "U"}
    )


def _values(values: Iterable[Any]) -> np.ndarray[Any, Any]:
    """Return values of an axis: numbers, or else text."""
    listed = list(values)
    return np.array(listed, dtype=float) if all(map(is_number, listed)) else np.array(list(map(str, listed)))


def _describe_axis(axis: SweptAxis) -> dict[str, Any]:
    return {
        "name": axis.name,
        "label": axis.label,
        "unit": axis.unit,
        "keys": dict(axis.factors),
        "spacing": axis.spacing,
    }


def _keys_of(axes: str) -> list[tuple[str, dict[str, float | None]]]:
    """Return names and keys of axes from their attribute."""
    return [(axis["name"], axis["keys"]) for axis in json.loads(axes)]
