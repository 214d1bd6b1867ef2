"""The dataset of a campaign: results of all its scenes, over the swept keys.

Outcomes of scenes are parts in the store, under a key of their own. They are not entries of their own,
because NetCDF takes fifty times as long for a few small arrays.

Layout of `sweep.nc` (NetCDF 4; `sweep.zarr` where it would take more than `LARGEST_FILE` bytes):

- dims of a grid: the names of the axes, in the order of the file. Each has a coordinate with the values,
  `units` and `long_name`; values that are not all numbers are text.
- dim of random points and of tables: `sample`. The values of the axes are coordinates along it.
- over these dims: `failure` (text, "" where there is none or where nothing is computed yet), `seconds` (for
  the scene, without models that other scenes have solved; NaN: not computed yet) and coordinates: `digest`
  (of all inputs of the results; 0: not computed yet, or to be computed again), `checksum` (of the
  results: `compare.campaigns.integrity`).
- over these dims and its own: every variable of `compare.campaigns.results`, NaN where it is not known.
  All are numbers. Dims of their own have labels (`variant`, `body`, `line`, ...), where all scenes have the
  same ones; otherwise "line 0", "line 1", ...
- attributes: `title`, `campaign` (text of the file), `table` (TOML of the scene without the axes), `axes`
  (JSON: name, label, unit, keys with factors, spacing), `keep` (JSON), `points` ("grid" or "samples"),
  `scenes`, `computed`, `failed`, `code`, `versions`, `layout` (digest of all that is not of a scene).
"""

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from compare.campaigns.campaign import Campaign
from compare.campaigns.frame import (
    DIGEST,
    SceneArrays,
    attributes_of,
    continues,
    swept_coords,
    swept_dims,
    with_free_text,
)
from compare.campaigns.integrity import (
    CHECKSUM,
    FILE,
    LAYOUT,
    SCENE_VARIABLES,
    ZARR,
    StoreCondition,
    layout_of,
    open_sweep,
    outcome_checksums,
    require_layout,
    store_condition,
    value_checksums,
)
from femic.cache.files import write_dataset
from femic.cache.store import Store

# --- outcomes of scenes ---------------------------------------------------------------------------------


FOLDER = "sweep"  # the key of all outcomes
OUTCOME_LAYOUT = "layout"


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
    layout = {
        "failure": outcome.failure,
        "seconds": outcome.seconds,
        "labels": {str(dim): labels.attrs for dim, labels in dataset.coords.items()},
        "variables": {
            str(name): [list(map(str, variable.dims)), variable.attrs]
            for name, variable in dataset.data_vars.items()
        },
    }
    arrays = {str(name): variable.values for name, variable in dataset.variables.items()}
    store.put_part(FOLDER, key, {OUTCOME_LAYOUT: np.array(json.dumps(layout)), **arrays})


def get(store: Store, key: str) -> SceneOutcome | None:
    """Return the outcome under a key, None where there is no undamaged one."""
    arrays = store.part(FOLDER, key)
    if arrays is None:
        return None
    layout = json.loads(str(arrays[OUTCOME_LAYOUT]))
    dataset = xr.Dataset(
        {name: (dims, arrays[name], attrs) for name, (dims, attrs) in layout["variables"].items()},
        {dim: (dim, arrays[dim], attrs) for dim, attrs in layout["labels"].items()},
    )
    return SceneOutcome(dataset, layout["failure"], layout["seconds"])


# --- the dataset ----------------------------------------------------------------------------------------


SAMPLED = 10  # scenes of an earlier dataset whose digests are compared
LARGEST_FILE = 200e6  # bytes of a dataset that is held in memory and written as one file
ABOUT = {
    "failure": {"long_name": "why there are no results"},
    "seconds": {"units": "s", "long_name": "time for the scene; NaN: not computed yet"},
    DIGEST: {"long_name": "of all inputs of the results; 0: not computed yet, or to be computed again"},
    CHECKSUM: {"long_name": "of the results; 0: not computed yet"},
}


@dataclass(eq=False)
class Collected:
    """The dataset of a campaign while its scenes are computed.

    The first results say which variables there are, and their dims. A small dataset is held in memory; a
    large one is a zarr store in `folder`, into which scenes are written chunk by chunk.
    """

    campaign: Campaign
    folder: Path
    code: str = field(default="", init=False)  # digest of the code that results rest on
    template: xr.Dataset = field(init=False)  # variables and labels of one scene
    failures: dict[int, str] = field(init=False)  # by number of the point
    seconds: np.ndarray[Any, Any] = field(init=False)  # (n_points,)
    digests: np.ndarray[Any, Any] = field(init=False)  # (n_points,)
    checksums: np.ndarray[Any, Any] = field(init=False)  # (n_points,)
    _arrays: SceneArrays = field(init=False)
    _differing: set[str] = field(init=False)  # dims whose labels differ between scenes

    def __post_init__(self) -> None:
        self._clear()

    @property
    def path(self) -> Path:
        """The path of the written dataset."""
        return self._arrays.path or self.folder / FILE

    def begin(self, digest_of: Callable[[int], int], code: str) -> str:
        """Continue the zarr store of an earlier run, if it has the same campaign and code.

        Axes may have become longer since: scenes are appended. Otherwise the dataset starts empty, also where
        none of some scenes has the digest that it would have now: files that all read have changed. Damaged
        scenes are computed again; returns a message about them.
        """
        self.code, path = code, self.folder / ZARR
        if not path.exists():
            return ""
        try:
            earlier = open_sweep(path)
            if LAYOUT not in earlier.attrs:  # nothing was finished, or by other code
                return ""
            require_layout(earlier)
            condition = store_condition(path, earlier) if continues(self.campaign, code, earlier) else None
        except Exception as error:  # whatever zarr and xarray raise
            return f"{path}: damaged ({error or type(error).__name__}): all its scenes are computed again"
        if condition is None:
            return ""
        damaged = self._take(path, earlier, condition)
        known = np.flatnonzero(self.digests)
        some = known[:: max(1, len(known) // SAMPLED)]
        if not any(digest_of(int(number)) == self.digests[number] for number in some):
            self._clear()
        return (
            f"{path}: {damaged} scenes are damaged or half written: they are computed again"
            if damaged
            else ""
        )

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
        other = _other_shape(self.template, outcome)
        if other:
            message = f"its results have other shapes than in earlier scenes: {other}"
            outcome = SceneOutcome(failure=message, seconds=outcome.seconds)
        self._extend(outcome.dataset)
        self._put(number, outcome, digest)

    def write(self) -> Path:
        """Write all finished scenes, completely or not at all; a large dataset is updated."""
        self.folder.mkdir(parents=True, exist_ok=True)
        if self._arrays.path:
            self._arrays.write(with_free_text(self._signed(self._frame())))
            (self.folder / FILE).unlink(missing_ok=True)
        else:
            write_dataset(self._in_memory(), self.path)
            shutil.rmtree(self.folder / ZARR, ignore_errors=True)
        return self.path

    def _in_memory(self) -> xr.Dataset:
        """Return the dataset with all variables."""
        self._arrays.flush()
        swept = swept_dims(self.campaign)
        variables = {
            name: ((*swept, *variable.dims), self._arrays.values[str(name)][...], variable.attrs)
            for name, variable in self.template.data_vars.items()
        }
        return self._signed(self._frame().assign(variables))

    def _signed(self, frame: xr.Dataset) -> xr.Dataset:
        """Return the frame with attributes, among them the digest of all that is not of a scene."""
        attributes = attributes_of(self.campaign, self.code) | {
            "computed": int(np.sum(~np.isnan(self.seconds))) - len(self.failures),
            "failed": len(self.failures),
        }
        return frame.assign_attrs(attributes | {LAYOUT: layout_of(frame, self.template, attributes)})

    def _take(self, path: Path, earlier: xr.Dataset, condition: StoreCondition) -> int:
        """Take the undamaged scenes of an earlier zarr store; returns the number of damaged ones."""
        shape, swept = self.campaign.shape, swept_dims(self.campaign)
        there = tuple(slice(earlier.sizes[dim]) for dim in swept)
        failures = np.full(shape, "", dtype=object)
        failures[there] = earlier.failure.values
        self.failures = {int(n): str(failures.flat[n]) for n in np.flatnonzero(failures.ravel() != "")}
        for mine, name in ((self.seconds, "seconds"), (self.digests, DIGEST), (self.checksums, CHECKSUM)):
            mine.reshape(shape)[there] = earlier[name].values
        self.digests.reshape(shape)[there][condition.damaged] = 0
        self.template = earlier.drop_vars(SCENE_VARIABLES).isel(dict.fromkeys(swept, 0), drop=True)
        self._differing = {
            str(dim)
            for dim, labels in self.template.coords.items()
            if list(labels.values) == _number_labels(str(dim), labels.size)
        }
        self._arrays = SceneArrays.extended(path, shape, swept, map(str, self.template.data_vars))
        self.write()
        condition.remove_chunks()
        return int(np.sum(condition.damaged))

    def _clear(self) -> None:
        """Start with no scenes."""
        campaign = self.campaign
        self.template, self.failures, self._differing = xr.Dataset(), {}, set()
        self._arrays = SceneArrays(campaign.shape, swept_dims(campaign))
        self.seconds = np.full(campaign.size, np.nan)
        self.digests, self.checksums = np.zeros((2, campaign.size), dtype=np.uint64)

    def _extend(self, dataset: xr.Dataset) -> None:
        """Add arrays for variables that no scene had before, and note labels that differ."""
        for dim, labels in dataset.coords.items():
            if dim in self.template and not np.array_equal(labels.values, self.template[dim].values):
                self._differing.add(str(dim))
        new = [str(name) for name in dataset.data_vars if name not in self.template]
        if not new:
            return
        labels = {dim: values for dim, values in dataset.coords.items() if dim not in self.template}
        before = self.template
        self.template = before.assign_coords(labels).assign({name: dataset[name].variable for name in new})
        if not self._arrays.path and self.template.nbytes * self.campaign.size > LARGEST_FILE:
            self._arrays = self._arrays.moved(self.folder / ZARR, before)
        for name in new:
            self._arrays.add(name, dataset[name].variable)

    def _put(self, number: int, outcome: SceneOutcome, digest: int) -> None:
        """Put a scene at its place."""
        self._arrays.put(number, outcome.dataset)
        self.failures.pop(number, None)
        if outcome.failure:
            self.failures[number] = outcome.failure
        self.seconds[number], self.digests[number] = outcome.seconds, digest
        self.checksums[number] = self._checksum(outcome, digest)

    def _checksum(self, outcome: SceneOutcome, digest: int) -> np.uint64:
        """Return the checksum of a scene, with its values as they are stored."""
        numbers = [
            value_checksums(str(name), outcome.dataset[name].values.astype(variable.dtype))
            for name, variable in self.template.data_vars.items()
            if name in outcome.dataset
        ]
        seconds, digests = np.array([outcome.seconds]), np.array([digest], dtype=np.uint64)
        return np.sum([*numbers, *outcome_checksums([outcome.failure], seconds, digests)], dtype=np.uint64)

    def _frame(self) -> xr.Dataset:
        """Return coordinates, failures and seconds."""
        campaign, swept = self.campaign, swept_dims(self.campaign)
        failure = np.full(campaign.size, "", dtype=object)
        failure[list(self.failures)] = list(self.failures.values())
        columns = (failure, self.seconds, self.digests, self.checksums)
        outcomes = {
            name: (swept, values.reshape(campaign.shape), ABOUT[name])
            for name, values in zip(SCENE_VARIABLES, columns, strict=True)
        }
        frame = xr.Dataset(outcomes, coords=swept_coords(campaign) | self._labels())
        return frame.set_coords([DIGEST, CHECKSUM])

    def _labels(self) -> dict[str, Any]:
        """Return the coordinates of the dims that scenes have by themselves."""
        return {
            str(dim): _number_labels(str(dim), labels.size) if dim in self._differing else labels
            for dim, labels in self.template.coords.items()
        }


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
