"""Arrays over the scenes of a campaign: in memory, or in a zarr store that is written chunk by chunk."""

import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import xarray as xr
import zarr

LARGEST_BUFFER = 32e6  # bytes of finished scenes that wait for being written into a zarr store
DIGEST = "digest"  # the variable of digests
CHUNK = 1e6  # bytes of a chunk of a variable, or one scene's

Shape = tuple[int, ...]


class Arrays(Protocol):
    """An array over all scenes by name of a variable, NaN where nothing has been put."""

    def make_room(self, name: str, variable: xr.Variable) -> None:
        """Make an array for a variable that each scene has."""

    def put(self, number: int, dataset: xr.Dataset) -> None:
        """Put the variables of a scene; those that it lacks are NaN."""

    def flush(self) -> None:
        """Write what waits for being written."""


@dataclass(frozen=True, eq=False)
class InMemory:
    """Arrays of NumPy."""

    shape: Shape  # of the scenes
    values: dict[str, Any] = field(default_factory=dict)

    def make_room(self, name: str, variable: xr.Variable) -> None:
        """As of `Arrays`."""
        self.values[name] = np.full((*self.shape, *variable.shape), np.nan, dtype=variable.dtype)

    def put(self, number: int, dataset: xr.Dataset) -> None:
        """As of `Arrays`."""
        place = np.unravel_index(number, self.shape)
        for name, values in self.values.items():
            values[place] = _of(dataset, name)

    def flush(self) -> None:
        """Nothing waits."""


@dataclass(eq=False)
class InZarr:
    """Arrays in a zarr store; finished scenes wait until there are enough for whole chunks.

    A scene that has a digest in the store has its values there: digests are written last, and removed before
    values change.
    """

    group: zarr.Group
    shape: Shape  # of the scenes
    dims: tuple[str, ...]  # of the scenes
    values: dict[str, zarr.Array] = field(default_factory=dict)
    _buffer: dict[int, xr.Dataset] = field(default_factory=dict)
    _buffered: int = 0  # bytes
    _sealed: set[int] = field(default_factory=set)  # scenes whose digests are in the store

    @classmethod
    def new(cls, path: Path, shape: Shape, dims: tuple[str, ...]) -> "InZarr":
        """No arrays; what is at the path is removed."""
        if path.exists():
            shutil.rmtree(path)
        return cls(zarr.open_group(path, mode="w"), shape, dims)

    @classmethod
    def appended(cls, path: Path, shape: Shape, dims: tuple[str, ...], names: Iterable[str]) -> "InZarr":
        """Those of an older store with some names, and room for more scenes; others are removed.

        What is there keeps its place: axes may only have become longer. Digests are to be written at once.
        """
        group = zarr.open_group(path, mode="a")
        values = {name: group[name] for name in names}
        for name in set(group.array_keys()) - values.keys():
            del group[name]
        for array in values.values():
            array.resize((*shape, *array.shape[len(shape) :]))
        return cls(group, shape, dims, values)

    def make_room(self, name: str, variable: xr.Variable) -> None:
        """As of `Arrays`."""
        self.values[name] = self.group.create_array(
            name,
            shape=(*self.shape, *variable.shape),
            chunks=(*_chunk(self.shape, variable.nbytes), *variable.shape),
            dtype=variable.dtype,
            fill_value=np.nan,
            dimension_names=(*self.dims, *map(str, variable.dims)),
            attributes=dict(variable.attrs),
        )

    def put(self, number: int, dataset: xr.Dataset) -> None:
        """As of `Arrays`."""
        self._buffer[number] = dataset
        self._buffered += dataset.nbytes
        if self._buffered > LARGEST_BUFFER:
            self.flush()

    def flush(self) -> None:
        """Write the scenes that wait, those of a chunk at once."""
        self._unseal(self._sealed.intersection(self._buffer))
        for name, values in self.values.items():
            for box, numbers in _by_chunk(self._buffer, self.shape, values.chunks[: len(self.shape)]):
                part = np.array(values[box])
                for number in numbers:
                    place = np.unravel_index(number, self.shape)
                    inside = tuple(k - along.start for k, along in zip(place, box, strict=True))
                    part[inside] = _of(self._buffer[number], name)
                values[box] = part
        self._buffer.clear()
        self._buffered = 0

    def write(self, frame: xr.Dataset) -> None:
        """Write the scenes that wait, then what is said of all scenes (`frame`), at last their digests.

        Checksums come before digests: what has a digest has its checksum.
        """
        self.flush()
        for name, labels in frame.coords.items():
            if name in self.group and not np.array_equal(self.group[name][...], labels.values):
                del self.group[name]  # it may have been of numbers, and have become text
        for part in (frame.drop_vars(DIGEST), frame[[DIGEST]]):
            part.to_zarr(self.group.store, mode="a", consolidated=False)
        self._sealed = {*map(int, np.flatnonzero(frame[DIGEST]))}

    def _unseal(self, numbers: set[int]) -> None:
        """Remove the digests of scenes whose values are about to change."""
        if numbers:
            places = np.unravel_index(sorted(numbers), self.shape)
            self.group[DIGEST].set_coordinate_selection(places, np.zeros(len(numbers), dtype=np.uint64))
            self._sealed -= numbers


def in_zarr(arrays: InMemory, template: xr.Dataset, new: InZarr) -> InZarr:
    """Arrays in a new zarr store that were in memory; `template` has the variables that they are of."""
    for name, values in arrays.values.items():
        new.make_room(name, template[name].variable)
        new.values[name][...] = values
    return new


def _of(dataset: xr.Dataset, name: str) -> Any:
    """The values of a variable, NaN where a dataset does not have it."""
    return dataset[name].values if name in dataset else np.nan


def _chunk(shape: Shape, size: int) -> Shape:
    """Scenes of a chunk along the swept dims, the last ones first, where each has some bytes."""
    room, along = max(1, int(CHUNK // max(size, 1))), []
    for count in reversed(shape):
        along.append(min(count, room))
        room = max(1, room // count)
    return tuple(reversed(along))


def _by_chunk(
    numbers: Iterable[int], shape: Shape, chunk: Shape
) -> Iterator[tuple[tuple[slice, ...], list[int]]]:
    """Yield the places of chunks and the numbers of points in them."""

    def corner(number: int) -> Shape:
        places = np.unravel_index(number, shape)
        return tuple(int(place) // size for place, size in zip(places, chunk, strict=True))

    for found, members in groupby(sorted(numbers, key=corner), key=corner):
        ends = zip(found, chunk, shape, strict=True)
        yield tuple(slice(k * size, min((k + 1) * size, end)) for k, size, end in ends), list(members)
