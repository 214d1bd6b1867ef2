"""The dataset of a campaign: all that is kept of its scenes, over the swept keys.

Layout of `sweep.nc` (NetCDF 4; `sweep.zarr` where it would take more than `LARGEST_FILE` bytes):

- dims of a grid: the names of the axes, in the order of the file. Each has a coordinate with the values,
  `units` and `long_name`; values that are not all numbers are text.
- dim of random points and of tables: `sample`. The values of the axes are coordinates along it.
- over these dims: `failure` (text, "" where there is none or where nothing is computed yet) and `seconds`
  (what was made of the scene, without models that other scenes have made; NaN: not computed yet).
- over these dims and its own: every variable of `compare.results.sweep.keeping`, NaN where it is not known.
  All are numbers. Dims of their own have labels (`variant`, `body`, `line`, ...), where all scenes have the
  same ones; otherwise "line 0", "line 1", ...
- attributes: `title`, `campaign` (text of the file), `table` (TOML of the scene without the axes), `axes`
  (JSON: name, label, unit, keys with factors, spacing), `keep` (JSON), `points` ("grid" or "samples"),
  `scenes`, `computed`, `failed`, `code`, `versions`.
"""

import json
import shutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr
import zarr

from compare.results.provenance import results_digest
from compare.scenes.campaign import Axis, Campaign
from compare.scenes.campaign_file import is_number
from compare.scenes.errors import BadScene
from femic.work.provenance import versions

SAMPLE = "sample"
OF_SCENES = ("failure", "seconds")  # variables over the swept dims only
LARGEST_FILE = 200e6  # bytes of a dataset that is held in memory and written as one file
LARGEST_BUFFER = 32e6  # bytes of finished scenes that wait for being written into a larger one
CHUNK = 1e6  # bytes of a chunk of a variable, or one scene's


@dataclass(eq=False)
class Collected:
    """The dataset of a campaign while its scenes are finished.

    The first scene with results decides which variables there are, and their dims. A small dataset is held in
    memory; a large one is a zarr store in `folder`, into which scenes are written chunk by chunk.
    """

    campaign: Campaign
    folder: Path
    first: xr.Dataset | None = None
    failures: dict[int, str] = field(default_factory=dict)  # by number of the point
    seconds: dict[int, float] = field(default_factory=dict)
    _values: dict[str, Any] = field(default_factory=dict)  # by variable: an array of NumPy or zarr
    _buffer: dict[int, xr.Dataset] = field(default_factory=dict)
    _other_labels: set[str] = field(default_factory=set)  # dims whose labels differ between scenes

    @property
    def is_large(self) -> bool:
        """Whether the dataset is a zarr store."""
        return self.first is not None and self.first.nbytes * self.campaign.size > LARGEST_FILE

    @property
    def path(self) -> Path:
        """Where the dataset is written to."""
        return self.folder / ("sweep.zarr" if self.is_large else "sweep.nc")

    @property
    def size(self) -> int:
        """The number of scenes that are finished, failed ones included."""
        return len(self.seconds)

    def add(self, number: int, dataset: xr.Dataset, seconds: float) -> None:
        """Add what is kept of a scene; one whose arrays have other shapes than the first's has failed.

        Raises BadScene where an axis has the name of a result.
        """
        if self.first is None:
            self._begin(dataset)
        other = _other_shape(self.first or dataset, dataset)
        if other:
            self.fail(number, f"its results have other shapes than those of scenes before: {other}", seconds)
            return
        self._note_labels(dataset)
        self.seconds[number] = seconds
        if not self.is_large:
            self._write({number: dataset})
            return
        self._buffer[number] = dataset
        if sum(one.nbytes for one in self._buffer.values()) > LARGEST_BUFFER:
            self._flush()

    def fail(self, number: int, message: str, seconds: float) -> None:
        """Note why a scene has no results."""
        self.failures[number], self.seconds[number] = message, seconds

    def write(self) -> Path:
        """Write what is finished so far, completely or not at all; a large dataset is brought up to date."""
        self.folder.mkdir(parents=True, exist_ok=True)
        if self.is_large:
            self._flush()
            small = _with_free_text(self._frame().assign_attrs(self._attributes()))
            small.to_zarr(self.path, mode="a", consolidated=False)
        else:
            temporary = self.path.with_suffix(".part")
            self.dataset().to_netcdf(temporary, engine="h5netcdf")
            temporary.replace(self.path)
        return self.path

    def dataset(self) -> xr.Dataset:
        """The dataset as it is; of a large one only what is in memory."""
        frame = self._frame()
        if self.first is not None and not self.is_large:
            swept = swept_dims(self.campaign)
            frame = frame.assign(
                {
                    name: ((*swept, *variable.dims), self._values[str(name)], variable.attrs)
                    for name, variable in self.first.data_vars.items()
                }
            )
        return frame.assign_attrs(self._attributes())

    def _frame(self) -> xr.Dataset:
        """Coordinates, failures and seconds."""
        campaign = self.campaign
        failure = np.full(campaign.size, "", dtype=object)
        seconds = np.full(campaign.size, np.nan)
        failure[list(self.failures)] = list(self.failures.values())
        seconds[list(self.seconds)] = list(self.seconds.values())
        swept = swept_dims(campaign)
        return xr.Dataset(
            {
                "failure": (
                    swept,
                    failure.reshape(campaign.shape),
                    {"long_name": "why there are no results"},
                ),
                "seconds": (
                    swept,
                    seconds.reshape(campaign.shape),
                    {"units": "s", "long_name": "what was made of the scene; NaN: not computed yet"},
                ),
            },
            coords=swept_coords(campaign) | self._labels(),
        )

    def _labels(self) -> dict[str, Any]:
        """The coordinates of the dims that scenes have by themselves."""
        if self.first is None:
            return {}
        return {
            str(dim): [f"{dim} {k}" for k in range(labels.size)] if dim in self._other_labels else labels
            for dim, labels in self.first.coords.items()
        }

    def _attributes(self) -> dict[str, str | int]:
        campaign = self.campaign
        return {
            "title": campaign.title,
            "campaign": campaign.text,
            "table": tomlkit.dumps(campaign.table),
            "axes": json.dumps([_described(axis) for axis in campaign.axes]),
            "keep": json.dumps(campaign.keep),
            "points": "grid" if campaign.is_grid else "samples",
            "scenes": campaign.size,
            "computed": len(self.seconds) - len(self.failures),
            "failed": len(self.failures),
            "code": results_digest(__name__),
            "versions": json.dumps(versions()),
        }

    def _begin(self, first: xr.Dataset) -> None:
        """Make room for the results of all scenes."""
        require_other_names(self.campaign, first)
        self.first = first
        if self.is_large:
            self._values = dict(_zarr_arrays(self.campaign, first, self.path))
            return
        self._values = {
            str(name): np.full((*self.campaign.shape, *variable.shape), np.nan, dtype=variable.dtype)
            for name, variable in first.data_vars.items()
        }

    def _note_labels(self, dataset: xr.Dataset) -> None:
        """Note dims whose labels are not those of the first scene."""
        for dim, labels in (self.first or dataset).coords.items():
            if not np.array_equal(labels.values, dataset[dim].values):
                self._other_labels.add(str(dim))

    def _write(self, datasets: Mapping[int, xr.Dataset]) -> None:
        for number, dataset in datasets.items():
            place = np.unravel_index(number, self.campaign.shape)
            for name, values in self._values.items():
                values[place] = dataset[name].values

    def _flush(self) -> None:
        """Write the scenes of the buffer, those of a chunk at once."""
        for name, values in self._values.items():
            swept = len(self.campaign.shape)
            chunk = values.chunks[:swept]
            for box, numbers in _by_chunk(self._buffer, self.campaign.shape, chunk):
                part = np.array(values[box])
                for number in numbers:
                    place = np.unravel_index(number, self.campaign.shape)
                    inside = tuple(k - along.start for k, along in zip(place, box, strict=True))
                    part[inside] = self._buffer[number][name].values
                values[box] = part
        self._buffer.clear()


def _with_free_text(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with text of any length, the only kind that zarr has a specification for."""
    texts = {
        name: dataset[name].astype(object) for name in dataset.variables if dataset[name].dtype.kind == "U"
    }
    return dataset.assign_coords({name: text for name, text in texts.items() if name in dataset.coords})


def swept_dims(campaign: Campaign) -> tuple[str, ...]:
    """The dims over which scenes lie."""
    return tuple(axis.name for axis in campaign.axes) if campaign.is_grid else (SAMPLE,)


def swept_coords(campaign: Campaign) -> dict[str, Any]:
    """The values of the axes as coordinates."""
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


def require_other_names(campaign: Campaign, results: xr.Dataset) -> None:
    """Raise BadScene where an axis has the name of a result or of one of its dims."""
    taken = {*map(str, results.variables), *map(str, results.dims), *OF_SCENES, SAMPLE}
    for axis in campaign.axes:
        if axis.name in taken:
            raise BadScene(
                f"sweep.{axis.name}: results have something of that name, too: rename the axis, such as "
                f"{axis.name}_swept; what is finished is kept"
            )


def _values(values: Iterable[Any]) -> np.ndarray[Any, Any]:
    """Values of an axis: numbers, or else text."""
    listed = list(values)
    return np.array(listed, dtype=float) if all(map(is_number, listed)) else np.array(list(map(str, listed)))


def _described(axis: Axis) -> dict[str, Any]:
    return {
        "name": axis.name,
        "label": axis.label,
        "unit": axis.unit,
        "keys": dict(axis.factors),
        "spacing": axis.spacing,
    }


def _other_shape(first: xr.Dataset, dataset: xr.Dataset) -> str:
    """What has another shape in a dataset than in the first one; "" if nothing has."""
    for name, variable in first.data_vars.items():
        found = dict(dataset[name].sizes) if name in dataset else "nothing"
        if found != dict(variable.sizes):
            return f"{name} has {found}, not {dict(variable.sizes)}"
    return ""


def _zarr_arrays(campaign: Campaign, first: xr.Dataset, path: Path) -> Iterable[tuple[str, Any]]:
    """Yield empty arrays of a new zarr store by variable; an older store there is removed."""
    if path.exists():
        shutil.rmtree(path)
    group = zarr.open_group(path, mode="w")
    for name, variable in first.data_vars.items():
        array = group.create_array(
            str(name),
            shape=(*campaign.shape, *variable.shape),
            chunks=(*_chunk(campaign.shape, variable.nbytes), *variable.shape),
            dtype=variable.dtype,
            fill_value=np.nan,
            dimension_names=(*swept_dims(campaign), *map(str, variable.dims)),
            attributes=dict(variable.attrs),
        )
        yield str(name), array


def _chunk(shape: tuple[int, ...], size: int) -> tuple[int, ...]:
    """Scenes of a chunk along the swept dims, the last ones first, where each has some bytes."""
    room, along = max(1, int(CHUNK // max(size, 1))), []
    for count in reversed(shape):
        along.append(min(count, room))
        room = max(1, room // count)
    return tuple(reversed(along))


def _by_chunk(
    numbers: Iterable[int], shape: tuple[int, ...], chunk: tuple[int, ...]
) -> Iterable[tuple[tuple[slice, ...], list[int]]]:
    """Yield the places of chunks and the numbers of points in them."""

    def corner(number: int) -> tuple[int, ...]:
        places = np.unravel_index(number, shape)
        return tuple(int(place) // size for place, size in zip(places, chunk, strict=True))

    for found, members in groupby(sorted(numbers, key=corner), key=corner):
        ends = zip(found, chunk, shape, strict=True)
        yield tuple(slice(k * size, min((k + 1) * size, end)) for k, size, end in ends), list(members)
