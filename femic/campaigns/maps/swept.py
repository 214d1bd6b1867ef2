"""A campaign's dataset on a grid of numbers, between whose scenes is interpolated."""

import json
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from femic.campaigns.checksums import CHECKSUM, LAYOUT
from femic.campaigns.maps.between import Nodes, Stencil
from femic.campaigns.opened import open_sweep
from femic.campaigns.verified import REMEDY, damaged_in_memory, require_layout
from femic.scenes.errors import BadScene
from femic.scenes.keys import set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices
from geometries.errors import Failure, WrongInput


@dataclass(frozen=True, eq=False)
class Swept:
    """The dataset, its axes, and the scene without these."""

    path: Path
    dataset: xr.Dataset
    axes: tuple[Nodes, ...]
    keys: tuple[Mapping[str, float], ...]  # of each axis: keys of a scene, and what a value is multiplied by
    table: Mapping[str, Any]  # of the scenes, but for the axes
    _undamaged: set[tuple[int, ...]] = field(default_factory=set)  # nodes whose values have been verified

    @property
    def names(self) -> str:
        """The names of the axes."""
        return ", ".join(axis.name for axis in self.axes)

    def stencils(self, point: Sequence[float]) -> list[Stencil]:
        """The nodes that make up a point, by axis; raises WrongInput outside the map."""
        return [axis.at(value) for axis, value in zip(self.axes, point, strict=True)]

    def scene(self, point: Sequence[float]) -> Scene:
        """The scene at a point; raises BadScene."""
        table = json.loads(json.dumps(self.table))
        for axis, keys, value in zip(self.axes, self.keys, point, strict=True):
            for key, factor in keys.items():
                set_key(table, key, factor * value, axis.name)
        return scene_from_table(table, ",".join(f"{value:g}" for value in point))

    def at_nodes(self, name: str, stencils: Sequence[Stencil]) -> Array:
        """A variable at the nodes of stencils, (k_1, ..., k_m, ...).

        Raises Failure where it is missing or damaged.
        """
        nodes = {axis.name: stencil.nodes for axis, stencil in zip(self.axes, stencils, strict=True)}
        self._require_undamaged(nodes)
        found = self.dataset[[name, CHECKSUM]].isel(nodes)
        if np.any(np.isnan(found[name])) or not np.all(found[CHECKSUM]):
            raise Failure(self._missing(name, nodes))
        return np.asarray(found[name], dtype=float)

    def _require_undamaged(self, nodes: Mapping[str, Indices]) -> None:
        """Raise Failure where scenes at some nodes do not have the values of their checksums."""
        places = {*product(*(map(int, along) for along in nodes.values()))}
        if places <= self._undamaged:
            return
        try:
            damaged = bool(np.any(damaged_in_memory(self.dataset.isel(nodes))))
        except Exception:  # whatever zarr makes of it
            damaged = True
        if damaged:
            at = "; ".join(f"{name} = {self.dataset[name].values[along]}" for name, along in nodes.items())
            raise Failure(f"{self.path}: a scene is damaged, at {at}: {REMEDY}")
        self._undamaged.update(places)

    def _missing(self, name: str, nodes: Mapping[str, Any]) -> str:
        """Which scene of the campaign has no results, and why."""
        chosen = self.dataset[[name, "failure", CHECKSUM]].isel(nodes)
        others = [dim for dim in chosen[name].dims if dim not in nodes]
        known = chosen[name].notnull().all(others) & (chosen[CHECKSUM] != 0)
        at = np.argwhere(~known.transpose(*nodes).values)[0]
        one = chosen.failure.isel(dict(zip(nodes, at, strict=True)))
        where = ", ".join(f"{axis} = {float(one[axis]):g}" for axis in nodes)
        why = str(one.values) or "not computed yet"
        return f"{self.path}: nothing at {where}: {why}; run the campaign again"


def open_swept(path: Path, keep: str, wanted: Sequence[str]) -> Swept:
    """The dataset of a campaign that kept something, or of its folder; read once until it changes.

    Raises BadScene where it lacks the `wanted` variables, has no grid, or axes without numbers.
    """
    if not path.exists():
        raise BadScene(f"{path}: no such file; `femic sweep` of a campaign that keeps {keep!r} makes one")
    swept = _opened(path, path.stat().st_mtime_ns)
    if not all(name in swept.dataset for name in wanted):
        raise BadScene(f"{path}: no map: the campaign needs keep = [{keep!r}]")
    return swept


@lru_cache(maxsize=4)
def _opened(path: Path, _changed: int) -> Swept:
    try:
        dataset = open_sweep(path)
    except Exception as error:  # whatever zarr and xarray make of it
        raise BadScene(f"{path}: no file of a campaign: {error}; make one by `femic sweep`") from error
    if dataset.attrs.get("points") != "grid" or "axes" not in dataset.attrs:
        raise BadScene(f"{path}: no map: the campaign needs points = 'all'")
    _require_layout(path, dataset)
    axes = json.loads(dataset.attrs["axes"])
    texts = [axis["name"] for axis in axes if dataset[axis["name"]].dtype.kind not in "fi"]
    if texts:
        raise BadScene(f"{path}: {', '.join(texts)}: there is nothing between values that are no numbers")
    try:
        nodes = tuple(
            Nodes(axis["name"], tuple(map(float, dataset[axis["name"]].values)), axis["spacing"])
            for axis in axes
        )
    except WrongInput as error:
        raise BadScene(f"{path}: {error}") from error
    keys = tuple({key: factor or 1.0 for key, factor in axis["keys"].items()} for axis in axes)
    return Swept(path, dataset, nodes, keys, tomllib.loads(dataset.attrs["table"]))


def _require_layout(path: Path, dataset: xr.Dataset) -> None:
    """Raise BadScene for files of older versions, Failure for damaged ones."""
    if LAYOUT not in dataset.attrs:
        raise BadScene(f"{path}: by an older version; make it again by `femic sweep`")
    try:
        require_layout(dataset)
    except Exception as error:  # whatever zarr and xarray make of it
        raise Failure(f"{path}: damaged ({error}): {REMEDY}") from error
