"""The dataset of a campaign: all that is kept of its scenes, over the swept keys.

Layout of `sweep.nc` (NetCDF 4; `sweep.zarr` where it would take more than `LARGEST_FILE` bytes):

- dims of a grid: the names of the axes, in the order of the file. Each has a coordinate with the values,
  `units` and `long_name`; values that are not all numbers are text.
- dim of random points and of tables: `sample`. The values of the axes are coordinates along it.
- over these dims: `failure` (text, "" where there is none or where nothing is computed yet), `seconds` (what
  was made of the scene, without models that other scenes have made; NaN: not computed yet) and coordinates:
  `digest` (of all that the scene's results rest on; 0: not computed yet, or to be tried again), `checksum`
  (of the results themselves: `femic.campaigns.checksums`).
- over these dims and its own: every variable of `femic.campaigns.keeping`, NaN where it is not known.
  All are numbers. Dims of their own have labels (`variant`, `body`, `line`, ...), where all scenes have the
  same ones; otherwise "line 0", "line 1", ...
- attributes: `title`, `campaign` (text of the file), `table` (TOML of the scene without the axes), `axes`
  (JSON: name, label, unit, keys with factors, spacing), `keep` (JSON), `points` ("grid" or "samples"),
  `scenes`, `computed`, `failed`, `code`, `versions`, `layout` (digest of all that is not of a scene).
"""

import json
import shutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
import xarray as xr

from femic.cache.digests import results_digest, versions
from femic.cache.files import write_dataset
from femic.campaigns import keeping
from femic.campaigns.arrays import DIGEST, Arrays, InMemory, InZarr, in_zarr
from femic.campaigns.campaign import Axis, Campaign
from femic.campaigns.campaign_file import is_number
from femic.campaigns.checksums import CHECKSUM, LAYOUT, OF_SCENES, layout_of, of_outcomes, of_values
from femic.campaigns.kept import Kept
from femic.campaigns.opened import open_sweep
from femic.campaigns.verified import Verified, require_layout, verified
from femic.scenes.errors import BadScene

SAMPLE = "sample"
FILE, ZARR = "sweep.nc", "sweep.zarr"
TRIED = 10  # scenes of an earlier dataset whose digests are tried
LARGEST_FILE = 200e6  # bytes of a dataset that is held in memory and written as one file


@dataclass(eq=False)
class Collected:
    """The dataset of a campaign while its scenes are finished.

    Scenes say by their results which variables there are, and their dims. A small dataset is held in memory;
    a large one is a zarr store in `folder`, into which scenes are written chunk by chunk.
    """

    campaign: Campaign
    folder: Path
    template: xr.Dataset = field(default_factory=xr.Dataset)  # variables and labels of one scene
    failures: dict[int, str] = field(default_factory=dict)  # by number of the point
    seconds: np.ndarray[Any, Any] = field(init=False)  # by number of the point
    digests: np.ndarray[Any, Any] = field(init=False)
    checksums: np.ndarray[Any, Any] = field(init=False)
    _arrays: Arrays | None = None
    _other_labels: set[str] = field(default_factory=set)  # dims whose labels differ between scenes

    def __post_init__(self) -> None:
        self.seconds = np.full(self.campaign.size, np.nan)
        self.digests = np.zeros(self.campaign.size, dtype=np.uint64)
        self.checksums = np.zeros(self.campaign.size, dtype=np.uint64)

    @property
    def path(self) -> Path:
        """Where the dataset is written to."""
        return self.folder / (ZARR if isinstance(self._arrays, InZarr) else FILE)

    def begin(self, digest_of: Callable[[int], int]) -> str:
        """Go on with the zarr store of an earlier run, if it is one of this campaign and code.

        Axes may have become longer since: scenes are appended. Otherwise the dataset is made anew, also where
        none of some scenes has the digest that it would have now: files that all read have changed. What is
        damaged is made anew, too, and returned as a message.
        """
        path = self.folder / ZARR
        if not path.exists():
            return ""
        try:
            earlier = open_sweep(path)
            if LAYOUT not in earlier.attrs:  # nothing was finished, or by other code
                return ""
            require_layout(earlier)
            found = verified(path, earlier) if self._continues(earlier) else None
        except Exception as error:  # whatever zarr and xarray make of it
            return f"{path}: damaged ({error or type(error).__name__}): all its scenes are made anew"
        if found is None:
            return ""
        damaged = self._take(path, earlier, found)
        known = np.flatnonzero(self.digests)
        some = known[:: max(1, len(known) // TRIED)]
        if not any(digest_of(int(number)) == self.digests[number] for number in some):
            self._forget()
        return f"{path}: {damaged} scenes are damaged or half written: they are made anew" if damaged else ""

    def has(self, number: int, digest: int) -> bool:
        """Whether a scene is there, by all that its results rest on."""
        return bool(self.digests[number] == digest)

    def remove(self, number: int) -> None:
        """Remove what is there of a scene, also values that a killed run has left without a digest."""
        self._put(number, Kept(seconds=np.nan), 0)

    def add(self, number: int, done: Kept, digest: int = 0) -> None:
        """Add what is kept of a scene; one whose arrays have other shapes than those before has failed.

        The digest is 0 where the scene may have other results the next time.
        """
        other = _other_shape(self.template, done)
        if other:
            message = f"its results have other shapes than those of scenes before: {other}"
            done = Kept(failure=message, seconds=done.seconds)
        self._make_room(done.dataset)
        self._put(number, done, digest)

    def write(self) -> Path:
        """Write what is finished so far, completely or not at all; a large dataset is brought up to date."""
        self.folder.mkdir(parents=True, exist_ok=True)
        if isinstance(self._arrays, InZarr):
            self._arrays.write(_with_free_text(self._signed(self._frame())))
            (self.folder / FILE).unlink(missing_ok=True)
            return self.path
        write_dataset(self.dataset(), self.path)
        shutil.rmtree(self.folder / ZARR, ignore_errors=True)
        return self.path

    def dataset(self) -> xr.Dataset:
        """The dataset as it is; of a large one only what is in memory."""
        frame = self._frame()
        if isinstance(self._arrays, InMemory):
            swept, values = swept_dims(self.campaign), self._arrays.values
            frame = frame.assign(
                {
                    name: ((*swept, *variable.dims), values[str(name)], variable.attrs)
                    for name, variable in self.template.data_vars.items()
                }
            )
        return self._signed(frame)

    def _signed(self, frame: xr.Dataset) -> xr.Dataset:
        """A frame with attributes, among them the digest of all that is not of a scene."""
        attributes = self._attributes()
        return frame.assign_attrs(attributes | {LAYOUT: layout_of(frame, self.template, attributes)})

    def _continues(self, earlier: xr.Dataset) -> bool:
        """Whether an earlier dataset is of this campaign and code, with the first values of each axis."""
        now, coords = self._attributes(), xr.Dataset(coords=swept_coords(self.campaign))
        return (
            all(earlier.attrs[name] == now[name] for name in ("table", "keep", "points", "code"))
            and _keys_of(earlier.attrs["axes"]) == _keys_of(str(now["axes"]))
            and all(
                np.array_equal(earlier[axis.name].values, coords[axis.name].values[: earlier[axis.name].size])
                for axis in self.campaign.axes
            )
        )

    def _take(self, path: Path, earlier: xr.Dataset, found: Verified) -> int:
        """Take the scenes of an earlier zarr store but damaged ones; the number of these."""
        shape, swept = self.campaign.shape, swept_dims(self.campaign)
        there = tuple(slice(earlier.sizes[dim]) for dim in swept)
        failures = np.full(shape, "", dtype=object)
        failures[there] = earlier.failure.values
        self.failures = {int(n): str(failures.flat[n]) for n in np.flatnonzero(failures.ravel() != "")}
        for mine, name in ((self.seconds, "seconds"), (self.digests, DIGEST), (self.checksums, CHECKSUM)):
            mine.reshape(shape)[there] = earlier[name].values
        damaged = np.zeros(shape, dtype=bool)
        damaged[there] = found.damaged
        self.digests[damaged.ravel()] = 0
        self.template = earlier.drop_vars(OF_SCENES).isel(dict.fromkeys(swept, 0), drop=True)
        self._other_labels = {
            str(dim)
            for dim, labels in self.template.coords.items()
            if list(labels.values) == _numbered(str(dim), labels.size)
        }
        self._arrays = InZarr.appended(path, shape, swept, map(str, self.template.data_vars))
        self.write()
        found.remove_chunks()
        return int(np.sum(damaged))

    def _forget(self) -> None:
        """Forget all scenes."""
        self.template, self.failures, self._other_labels, self._arrays = xr.Dataset(), {}, set(), None
        self.seconds[:], self.digests[:], self.checksums[:] = np.nan, 0, 0

    def _make_room(self, dataset: xr.Dataset) -> None:
        """Make room for variables of all scenes that none had before, and note labels that differ."""
        for dim, labels in dataset.coords.items():
            if dim in self.template and not np.array_equal(labels.values, self.template[dim].values):
                self._other_labels.add(str(dim))
        new = [str(name) for name in dataset.data_vars if name not in self.template]
        if not new:
            return
        labels = {dim: values for dim, values in dataset.coords.items() if dim not in self.template}
        self.template = self.template.assign_coords(labels)
        self.template = self.template.assign({name: dataset[name].variable for name in new})
        arrays = self._fitting_arrays()
        for name in new:
            arrays.make_room(name, dataset[name].variable)
        self._arrays = arrays

    def _fitting_arrays(self) -> Arrays:
        """The arrays so far, in a zarr store where the dataset is large."""
        campaign = self.campaign
        arrays = self._arrays or InMemory(campaign.shape)
        if isinstance(arrays, InMemory) and self.template.nbytes * campaign.size > LARGEST_FILE:
            new = InZarr.new(self.folder / ZARR, campaign.shape, swept_dims(campaign))
            return in_zarr(arrays, self.template, new)
        return arrays

    def _put(self, number: int, done: Kept, digest: int) -> None:
        """Put a scene at its place."""
        if self._arrays is not None:
            self._arrays.put(number, done.dataset)
        self.failures.pop(number, None)
        if done.failure:
            self.failures[number] = done.failure
        self.seconds[number], self.digests[number] = done.seconds, digest
        self.checksums[number] = self._checksum(done, digest)

    def _checksum(self, done: Kept, digest: int) -> np.uint64:
        """The checksum of a scene, as its values are stored."""
        numbers = [
            of_values(str(name), done.dataset[name].values.astype(variable.dtype))
            for name, variable in self.template.data_vars.items()
            if name in done.dataset
        ]
        outcome = of_outcomes([done.failure], np.array([done.seconds]), np.array([digest], dtype=np.uint64))
        return np.sum([*numbers, *outcome], dtype=np.uint64)

    def _frame(self) -> xr.Dataset:
        """Coordinates, failures and seconds."""
        campaign, swept = self.campaign, swept_dims(self.campaign)
        failure = np.full(campaign.size, "", dtype=object)
        failure[list(self.failures)] = list(self.failures.values())
        described = {
            "failure": (failure, {"long_name": "why there are no results"}),
            "seconds": (
                self.seconds,
                {"units": "s", "long_name": "what was made of the scene; NaN: not computed yet"},
            ),
            DIGEST: (
                self.digests,
                {"long_name": "of all that results rest on; 0: not computed yet, or to be tried again"},
            ),
            CHECKSUM: (self.checksums, {"long_name": "of the results; 0: not computed yet"}),
        }
        of_scenes = {
            name: (swept, values.reshape(campaign.shape), attrs)
            for name, (values, attrs) in described.items()
        }
        frame = xr.Dataset(of_scenes, coords=swept_coords(campaign) | self._labels())
        return frame.set_coords([DIGEST, CHECKSUM])

    def _labels(self) -> dict[str, Any]:
        """The coordinates of the dims that scenes have by themselves."""
        return {
            str(dim): _numbered(str(dim), labels.size) if dim in self._other_labels else labels
            for dim, labels in self.template.coords.items()
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
            "computed": int(np.sum(~np.isnan(self.seconds))) - len(self.failures),
            "failed": len(self.failures),
            "code": results_digest(__name__, keeping.__name__),
            "versions": json.dumps(versions()),
        }


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


def require_other_names(campaign: Campaign, names: Iterable[str]) -> None:
    """Raise BadScene where an axis has the name of a result or of one of its dims."""
    taken = {*names, *OF_SCENES, SAMPLE}
    for axis in campaign.axes:
        if axis.name in taken:
            raise BadScene(
                f"sweep.{axis.name}: results have something of that name, too: rename the axis, such as "
                f"{axis.name}_swept"
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


def _keys_of(axes: str) -> list[tuple[str, dict[str, float | None]]]:
    """Names and keys of axes, as attributes have them."""
    return [(axis["name"], axis["keys"]) for axis in json.loads(axes)]


def _numbered(dim: str, size: int) -> list[str]:
    """Labels of a dim without labels of its own."""
    return [f"{dim} {number}" for number in range(size)]


def _other_shape(template: xr.Dataset, done: Kept) -> str:
    """What has another shape than before in what is kept of a scene; "" if nothing has."""
    dataset = done.dataset
    for name, variable in template.data_vars.items():
        found = dict(dataset[name].sizes) if name in dataset else "nothing"
        if found != dict(variable.sizes) and not (done.failure and found == "nothing"):
            return f"{name} has {found}, not {dict(variable.sizes)}"
    for dim, size in dataset.sizes.items():
        if size != template.sizes.get(dim, size):
            return f"there are {size} along {dim}, not {template.sizes[dim]}"
    return ""
