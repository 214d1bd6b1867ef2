"""The dataset of a campaign: results of all its scenes, over the swept keys.

Layout of `sweep.nc` (NetCDF 4; `sweep.zarr` where it would take more than `LARGEST_FILE` bytes):

- dims of a grid: the names of the axes, in the order of the file. Each has a coordinate with the values,
  `units` and `long_name`; values that are not all numbers are text.
- dim of random points and of tables: `sample`. The values of the axes are coordinates along it.
- over these dims: `failure` (text, "" where there is none or where nothing is computed yet), `seconds` (for
  the scene, without models that other scenes have solved; NaN: not computed yet) and the coordinate `digest`
  (of all inputs of the results; 0: not computed yet, or to be computed again).
- over these dims and its own: every variable of `compare.campaigns.kinds`, NaN where it is not known. All
  are numbers. Dims of their own have labels (`variant`, `body`, `line`, ...), where all scenes have the same
  ones; otherwise "line 0", "line 1", ...
- attributes: `title`, `campaign` (text of the file), `table` (TOML of the scene without the axes), `axes`
  (JSON: name, label, unit, keys with factors, spacing), `keep` (JSON), `points` ("grid" or "samples"),
  `scenes`, `computed`, `failed`, `code`, `versions`, `variables` (JSON: names of all).

HDF5 and zarr verify checksums (Fletcher-32, CRC-32C) of all numbers that they read. A damaged `sweep.zarr`
is written anew, with the results of its scenes in the store, which verifies them itself.
"""

import json
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr
import zarr
from zarr.codecs import Crc32cCodec, ZstdCodec
from zarr.storage import MemoryStore

from compare.campaigns.campaign import Campaign
from compare.campaigns.keys import is_number
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.cache.files import write_dataset
from femic.cache.store import Store
from femic.scenes.errors import BadScene
from geometries.errors import Failure

# --- files of datasets ----------------------------------------------------------------------------------


FILE, ZARR = "sweep.nc", "sweep.zarr"
SAMPLE, DIGEST = "sample", "digest"
SCENE_VARIABLES = ("failure", "seconds", DIGEST)  # over the swept dims only
REMEDY = "run the campaign again to replace them"
EACH_CHUNK = {"array.write_empty_chunks": True}  # a missing chunk of finished scenes is lost, not empty


def dataset_path(folder: Path) -> Path:
    """Return the path of the dataset in a campaign's folder."""
    large = folder / ZARR
    return large if large.is_dir() else folder / FILE


def open_sweep(path: Path) -> xr.Dataset:
    """Open the dataset in a campaign's folder, or its file `sweep.nc` or `sweep.zarr`.

    It is read as it is used. Raises FileNotFoundError where there is none.
    """
    file = path if path.suffix in {".nc", ".zarr"} else dataset_path(path)
    if file.suffix == ".zarr":
        return xr.open_zarr(file, consolidated=False, chunks=None)
    return xr.open_dataset(file, engine="h5netcdf")


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
        if path.is_dir():
            require_all_chunks(path)
            return open_sweep(path)
        return open_sweep(path).load()


def require_all_chunks(path: Path) -> None:
    """Raise Failure for missing arrays and chunks, and whatever zarr raises about unreadable ones."""
    group = zarr.open_group(path, mode="r")
    if missing := {*json.loads(str(group.attrs["variables"]))} - {*group.array_keys()}:
        raise Failure(f"no {', '.join(sorted(missing))}")
    digests = group[DIGEST]
    swept, finished = set(_dims(digests)), np.asarray(digests[...]) != 0
    for name, values in group.arrays():
        along = [dim for dim in _dims(values) if dim in swept]
        for place in np.ndindex(*values.cdata_shape):
            corner = zip(place, values.chunks, strict=True)
            box = {dim: slice(k * n, (k + 1) * n) for dim, (k, n) in zip(_dims(values), corner, strict=True)}
            has_finished = bool(finished[tuple(box.get(dim, slice(None)) for dim in _dims(digests))].any())
            chunk = f"{name}/{values.metadata.encode_chunk_key(place)}"
            if not (path / chunk).is_file() and (has_finished or not along or name in SCENE_VARIABLES):
                raise Failure(f"no {chunk}")
            try:
                values.blocks[place]
            except Exception as error:
                raise Failure(f"{chunk}: {error}") from error


def _dims(values: zarr.Array) -> tuple[str, ...]:
    return tuple(map(str, values.metadata.dimension_names))


# --- outcomes of scenes ---------------------------------------------------------------------------------


FOLDER = "sweep"  # the key of all outcomes, which are its parts: NetCDF takes fifty times as long for each
DESCRIPTION = "layout"


@dataclass(frozen=True, eq=False)
class SceneOutcome:
    """Results of a scene, or the message of its failure, and the seconds of the computation."""

    dataset: xr.Dataset = field(default_factory=xr.Dataset)
    failure: str = ""
    seconds: float = 0.0


def keys_in(store: Store) -> set[str]:
    """Return the keys of all outcomes in a store."""
    return set(store.part_names(FOLDER))


def put(store: Store, key: str, outcome: SceneOutcome) -> None:
    """Store an outcome under a key."""
    dataset = outcome.dataset
    description = json.dumps([outcome.failure, outcome.seconds, dataset.to_dict(data=False)])
    arrays = {str(name): variable.values for name, variable in dataset.variables.items()}
    store.put_part(FOLDER, key, {DESCRIPTION: np.array(description), **arrays})


def get(store: Store, key: str) -> SceneOutcome | None:
    """Return the outcome under a key, None where there is no undamaged one."""
    arrays = store.part(FOLDER, key)
    if arrays is None:
        return None
    failure, seconds, described = json.loads(str(arrays[DESCRIPTION]))
    for variables in (described["coords"], described["data_vars"]):
        for name, entry in variables.items():
            entry["data"] = arrays[name]
    return SceneOutcome(xr.Dataset.from_dict(described), failure, seconds)


# --- dims and attributes --------------------------------------------------------------------------------


def swept_dims(campaign: Campaign) -> tuple[str, ...]:
    """Return the dims of the campaign: its axes on a grid, else `SAMPLE`."""
    return tuple(axis.name for axis in campaign.axes) if campaign.is_grid else (SAMPLE,)


def swept_coords(campaign: Campaign) -> xr.Dataset:
    """Return the values of the axes as coordinates: numbers, or else text."""
    listed = zip(*campaign.listed, strict=True)
    columns = [axis.values for axis in campaign.axes] if campaign.is_grid else listed
    coords = {}
    for axis, column in zip(campaign.axes, columns, strict=True):
        values = np.array(column, float) if all(map(is_number, column)) else np.array([*map(str, column)])
        about = {"long_name": axis.label} | ({"units": axis.unit} if axis.unit else {})
        coords[axis.name] = (axis.name if campaign.is_grid else SAMPLE, values, about)
    return xr.Dataset(coords=coords)


def require_other_names(campaign: Campaign, names: Iterable[str]) -> None:
    """Raise BadScene where an axis has the name of a result or of one of its dims."""
    reserved = {*names, *SCENE_VARIABLES, SAMPLE}
    for axis in campaign.axes:
        if axis.name in reserved:
            raise BadScene(
                f"sweep.{axis.name}: results have something of that name, too: rename the axis, such as "
                f"{axis.name}_swept"
            )


def attributes(campaign: Campaign) -> dict[str, str | int]:
    """Return the attributes that do not depend on results."""
    axes = [
        {
            "name": axis.name,
            "label": axis.label,
            "unit": axis.unit,
            "keys": dict(axis.factors),
            "spacing": axis.spacing,
        }
        for axis in campaign.axes
    ]
    return {
        "title": campaign.title,
        "campaign": campaign.text,
        "table": tomlkit.dumps(campaign.table),
        "axes": json.dumps(axes),
        "keep": json.dumps(campaign.keep),
        "points": "grid" if campaign.is_grid else "samples",
        "scenes": campaign.size,
        "code": results_digest(*STUDY_FOLDERS),
        "versions": json.dumps(versions()),
    }


def _is_continued(earlier: xr.Dataset, campaign: Campaign) -> bool:
    """Whether a campaign has the scenes and the code of an earlier dataset; its axes may be longer."""
    now, coords = attributes(campaign), swept_coords(campaign)
    axes, earlier_axes = (json.loads(str(attrs["axes"])) for attrs in (now, earlier.attrs))
    return (
        all(earlier.attrs[name] == now[name] for name in ("table", "keep", "points", "code"))
        and [(a["name"], a["keys"]) for a in axes] == [(a["name"], a["keys"]) for a in earlier_axes]
        and all(
            np.array_equal(earlier[axis].values, coords[axis].values[: earlier[axis].size])
            for axis in coords.coords
        )
    )


# --- the dataset while its scenes are computed ----------------------------------------------------------


LARGEST_FILE = 200e6  # bytes of a dataset that is held in memory and written as one file
LARGEST_BUFFER = 32e6  # bytes of finished scenes that wait to be written
CHUNK = 1e6  # bytes of a chunk of a variable, unless one scene has more
CODECS = (ZstdCodec(), Crc32cCodec())
ABOUT = {
    "failure": {"long_name": "why there are no results"},
    "seconds": {"units": "s", "long_name": "time of the scene; NaN: not yet computed"},
    DIGEST: {"long_name": "of all inputs of the results; 0: not computed yet, or to be computed again"},
}


@dataclass(eq=False)
class CampaignDataset:
    """The dataset of a campaign while its scenes are computed.

    The first results say which variables there are, and their dims. Each variable is an array over all
    scenes of a zarr group, in memory, or in `folder` where the dataset is large. Finished scenes wait until
    there are enough for whole chunks. A scene with a digest in the folder has its values there: digests are
    written last, and removed before values change.
    """

    campaign: Campaign
    folder: Path
    template: xr.Dataset = field(init=False)  # variables and labels of one scene
    failures: dict[int, str] = field(init=False)  # by number of the point
    seconds: np.ndarray[Any, Any] = field(init=False)  # (n_points,)
    digests: np.ndarray[Any, Any] = field(init=False)  # (n_points,)
    is_large: bool = field(default=False, init=False)
    _group: zarr.Group = field(init=False)
    _differing: set[str] = field(default_factory=set, init=False)  # dims whose labels differ between scenes
    _waiting: dict[int, xr.Dataset] = field(default_factory=dict, init=False)
    _written: set[int] = field(default_factory=set, init=False)  # scenes whose digests are in the folder

    def __post_init__(self) -> None:
        self.template, self.failures = xr.Dataset(), {}
        self.seconds = np.full(self.campaign.size, np.nan)
        self.digests = np.zeros(self.campaign.size, dtype=np.uint64)
        self._group = zarr.create_group(MemoryStore())

    @property
    def path(self) -> Path:
        """The path of the written dataset."""
        return self.folder / (ZARR if self.is_large else FILE)

    def resume(self, first_digest: int) -> str:
        """Continue the zarr store of an earlier run, if it has the same campaign and code.

        Axes may have become longer since: scenes are appended. Otherwise the dataset starts empty, also where
        its first scene has not the digest that it would have now: files that all read may have changed.
        Returns a message about damage.
        """
        path = self.folder / ZARR
        if not path.exists():
            return ""
        try:
            earlier = open_sweep(path)
            if "code" not in earlier.attrs:  # nothing was finished
                return ""
            require_all_chunks(path)
            if _is_continued(earlier, self.campaign) and earlier[DIGEST].values.flat[0] == first_digest:
                self._take(path, earlier.drop_vars(SCENE_VARIABLES), earlier[[*SCENE_VARIABLES]].load())
        except Exception as error:  # whatever zarr and xarray raise
            return (
                f"{path}: damaged ({error or type(error).__name__}); it is written again from the finished "
                "scenes in the store"
            )
        return ""

    def has(self, number: int, digest: int) -> bool:
        """Whether the scene is there, computed from everything in `digest`."""
        return bool(self.digests[number] == digest)

    def remove(self, number: int) -> None:
        """Remove a scene, and values without a digest that a killed run has left."""
        self._put(number, SceneOutcome(seconds=np.nan), 0)

    def add(self, number: int, outcome: SceneOutcome, digest: int = 0) -> None:
        """Add the results of a scene; a scene whose arrays differ in shape from earlier ones has failed.

        The digest is 0 where the scene may have other results the next time.
        """
        if difference := _other_shape(self.template, outcome):
            message = f"its results have a different shape from those of earlier scenes: {difference}"
            outcome = SceneOutcome(failure=message, seconds=outcome.seconds)
        self._add_variables(outcome.dataset)
        self._put(number, outcome, digest)

    def write(self) -> Path:
        """Write all finished scenes, completely or not at all; a large dataset is updated."""
        self.folder.mkdir(parents=True, exist_ok=True)
        self.flush()
        dataset = self._scenes()
        if not self.is_large:
            dims = swept_dims(self.campaign)
            dataset = dataset.assign(
                {
                    name: ((*dims, *variable.dims), self._group[str(name)][...], variable.attrs)
                    for name, variable in self.template.data_vars.items()
                }
            )
            for variable in dataset.variables.values():
                if variable.dtype.kind in "iuf":
                    variable.encoding["fletcher32"] = True
            write_dataset(dataset, self.path)
            shutil.rmtree(self.folder / ZARR, ignore_errors=True)
            return self.path
        for name, labels in dataset.coords.items():
            if name in self._group and not np.array_equal(self._group[name][...], labels.values):
                del self._group[name]  # numbers may have become text
        for part in (dataset.drop_vars(DIGEST), dataset[[DIGEST]]):
            encoding = {name: {"compressors": CODECS} for name in part.variables if name not in self._group}
            part.to_zarr(self.path, mode="a", consolidated=False, encoding=encoding, write_empty_chunks=True)
        self._written = {*map(int, np.flatnonzero(self.digests))}
        (self.folder / FILE).unlink(missing_ok=True)
        return self.path

    def flush(self) -> None:
        """Write the scenes that wait into the arrays, chunk by chunk."""
        shape = self.campaign.shape
        if changing := sorted(self._written.intersection(self._waiting)):
            zeros = np.zeros(len(changing), dtype=np.uint64)
            self._group[DIGEST].set_coordinate_selection(np.unravel_index(changing, shape), zeros)
            self._written.difference_update(changing)
        numbers = np.array(sorted(self._waiting), dtype=int)
        places = np.column_stack(np.unravel_index(numbers, shape))  # (n_scenes, n_dims)
        with zarr.config.set(EACH_CHUNK):
            arrays = {name: self._group[str(name)] for name in self.template.data_vars}
        for name, values in arrays.items():
            chunk = values.chunks[: len(shape)]
            corners, corner_numbers = np.unique(places // chunk, axis=0, return_inverse=True)
            for k, corner in enumerate(corners * chunk):
                box, inside = tuple(map(slice, corner, corner + chunk)), corner_numbers == k
                part = np.array(values[box])
                for number, place in zip(numbers[inside], places[inside] - corner, strict=True):
                    dataset = self._waiting[number]
                    part[tuple(place)] = dataset[name].values if name in dataset else np.nan
                values[box] = part
        self._waiting.clear()

    def _put(self, number: int, outcome: SceneOutcome, digest: int) -> None:
        """Put a scene at its place."""
        if self.template.data_vars:
            self._waiting[number] = outcome.dataset
        self.failures.pop(number, None)
        if outcome.failure:
            self.failures[number] = outcome.failure
        self.seconds[number], self.digests[number] = outcome.seconds, digest
        if len(self._waiting) * self.template.nbytes > LARGEST_BUFFER:
            self.flush()

    def _scenes(self) -> xr.Dataset:
        """Return coordinates, attributes, and what is known of all scenes, without their variables."""
        dims, shape = swept_dims(self.campaign), self.campaign.shape
        failure = np.full(self.campaign.size, "", dtype=object)
        failure[list(self.failures)] = list(self.failures.values())
        columns = zip(SCENE_VARIABLES, (failure, self.seconds, self.digests), strict=True)
        coords = swept_coords(self.campaign).assign_coords(
            {
                dim: _number_labels(str(dim), labels.size) if dim in self._differing else labels
                for dim, labels in self.template.coords.items()
            }
        )
        if self.is_large:  # text of any length is the only one that zarr has specified
            text = {name: values for name, values in coords.coords.items() if values.dtype.kind == "U"}
            coords = coords.assign_coords({name: values.astype(object) for name, values in text.items()})
        scenes = coords.assign({name: (dims, column.reshape(shape), ABOUT[name]) for name, column in columns})
        computed = int(np.sum(~np.isnan(self.seconds))) - len(self.failures)
        about = attributes(self.campaign) | {"computed": computed, "failed": len(self.failures)}
        about |= {"variables": json.dumps(sorted(map(str, {*scenes.variables, *self.template.data_vars})))}
        return scenes.set_coords(DIGEST).assign_attrs(about)

    def _take(self, path: Path, variables: xr.Dataset, scenes: xr.Dataset) -> None:
        """Take the scenes of an earlier zarr store, with room for more: axes may only have become longer."""
        shape, dims = self.campaign.shape, swept_dims(self.campaign)
        there = tuple(slice(scenes.sizes[dim]) for dim in dims)
        failures = np.full(shape, "", dtype=object)
        failures[there] = scenes.failure.values
        self.failures = {int(n): str(failures.flat[n]) for n in np.flatnonzero(failures.ravel() != "")}
        self.seconds.reshape(shape)[there] = scenes.seconds.values
        self.digests.reshape(shape)[there] = scenes[DIGEST].values
        self.template = variables.isel(dict.fromkeys(dims, 0), drop=True).load()
        self._differing = {
            str(dim)
            for dim, labels in self.template.coords.items()
            if list(labels.values) == _number_labels(str(dim), labels.size)
        }
        self.is_large, self._group = True, zarr.open_group(path, mode="a")
        for name in [*self._group.array_keys()]:
            if name not in self.template.data_vars:
                del self._group[name]
            else:
                values = self._group[name]
                values.resize((*shape, *values.shape[len(shape) :]))
        self.write()

    def _add_variables(self, dataset: xr.Dataset) -> None:
        """Add arrays for variables that no scene had before, and note labels that differ.

        Where the dataset becomes large with them, arrays are moved into the folder.
        """
        for dim, labels in dataset.coords.items():
            if dim in self.template and not np.array_equal(labels.values, self.template[dim].values):
                self._differing.add(str(dim))
        new = {str(name): values.variable for name, values in dataset.data_vars.items()}
        new = {name: variable for name, variable in new.items() if name not in self.template}
        labels = {dim: values for dim, values in dataset.coords.items() if dim not in self.template}
        known = self.template.data_vars
        self.template = self.template.assign_coords(labels).assign(new)
        if new and not self.is_large and self.template.nbytes * self.campaign.size > LARGEST_FILE:
            before, path = self._group, self.folder / ZARR
            shutil.rmtree(path, ignore_errors=True)  # of an earlier run
            self.is_large, self._group = True, zarr.open_group(path, mode="w")
            for name in map(str, known):
                self._create_array(name, self.template[name].variable)[...] = before[name][...]
        for name, variable in new.items():
            self._create_array(name, variable)

    def _create_array(self, name: str, variable: xr.Variable) -> zarr.Array:
        """Create the array of a variable that scenes have, NaN where no scene has been put."""
        shape, room = self.campaign.shape, max(1, int(CHUNK // max(variable.nbytes, 1)))
        chunk = list[int]()  # scenes along each dim
        for count in reversed(shape):
            chunk.insert(0, min(count, room))
            room = max(1, room // count)
        return self._group.create_array(
            name,
            shape=(*shape, *variable.shape),
            chunks=(*chunk, *variable.shape),
            dtype=variable.dtype,
            fill_value=np.nan,
            dimension_names=(*swept_dims(self.campaign), *map(str, variable.dims)),
            attributes=dict(variable.attrs),
            compressors=CODECS if self.is_large else None,
            config={"write_empty_chunks": True},
        )


def _number_labels(dim: str, size: int) -> list[str]:
    """Return labels of a dim without labels of its own."""
    return [f"{dim} {number}" for number in range(size)]


def _other_shape(template: xr.Dataset, outcome: SceneOutcome) -> str:
    """Describe a result whose shape differs from earlier scenes; "" without one."""
    dataset = outcome.dataset
    for name, variable in template.data_vars.items():
        sizes = dict(dataset[name].sizes) if name in dataset else "nothing"
        if sizes != dict(variable.sizes) and not (outcome.failure and sizes == "nothing"):
            return f"{name} has {sizes}, not {dict(variable.sizes)}"
    for dim, size in dataset.sizes.items():
        if size != template.sizes.get(dim, size):
            return f"there are {size} along {dim}, not {template.sizes[dim]}"
    return ""
