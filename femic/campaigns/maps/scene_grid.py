"""The dataset of a campaign on a grid of numbers, as the nodes of an interpolation."""

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

from femic.campaigns.dataset.integrity import (
    CHECKSUM,
    LAYOUT,
    REMEDY,
    damage_reported,
    damaged_in_memory,
    require_layout,
)
from femic.campaigns.dataset.reading import open_sweep
from femic.campaigns.maps.interpolation import AxisNodes, Stencil
from femic.scenes.errors import BadScene
from femic.scenes.keys import set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices
from geometries.errors import Failure, WrongInput


@dataclass(frozen=True, eq=False)
class SceneGrid:
    """The dataset of a campaign, its axes as nodes, and the scene that they vary."""

    path: Path
    dataset: xr.Dataset
    axes: tuple[AxisNodes, ...]
    keys: tuple[Mapping[str, float], ...]  # by axis: keys of a scene, and the factor of each
    table: Mapping[str, Any]  # of the scenes, but for the axes
    _undamaged: set[tuple[int, ...]] = field(default_factory=set)  # nodes whose values have been verified

    @property
    def names(self) -> str:
        """The names of the axes."""
        return ", ".join(axis.name for axis in self.axes)

    def stencils(self, point: Sequence[float]) -> list[Stencil]:
        """Return the stencil of a point along each axis; raise WrongInput outside the map."""
        return [axis.at(value) for axis, value in zip(self.axes, point, strict=True)]

    def scene(self, point: Sequence[float]) -> Scene:
        """Return the scene at a point; raise BadScene."""
        table = json.loads(json.dumps(self.table))
        for axis, keys, value in zip(self.axes, self.keys, point, strict=True):
            for key, factor in keys.items():
                set_key(table, key, factor * value, axis.name)
        return scene_from_table(table, ",".join(f"{value:g}" for value in point))

    def at_nodes(self, name: str, stencils: Sequence[Stencil]) -> Array:
        """Return a variable at the nodes of stencils, (k_1, ..., k_m, ...).

        Raises Failure where it is missing or damaged.
        """
        nodes = {axis.name: stencil.nodes for axis, stencil in zip(self.axes, stencils, strict=True)}
        self._require_undamaged(nodes)
        chosen = self.dataset[[name, CHECKSUM]].isel(nodes)
        if np.any(np.isnan(chosen[name])) or not np.all(chosen[CHECKSUM]):
            raise Failure(self._missing(name, nodes))
        return np.asarray(chosen[name], dtype=float)

    def _require_undamaged(self, nodes: Mapping[str, Indices]) -> None:
        """Raise Failure where scenes at some nodes do not have the values of their checksums."""
        places = {*product(*(map(int, along) for along in nodes.values()))}
        if places <= self._undamaged:
            return
        try:
            damaged = bool(np.any(damaged_in_memory(self.dataset.isel(nodes))))
        except Exception:  # whatever zarr raises
            damaged = True
        if damaged:
            at = "; ".join(f"{name} = {self.dataset[name].values[along]}" for name, along in nodes.items())
            raise Failure(f"{self.path}: a scene is damaged, at {at}: {REMEDY}")
        self._undamaged.update(places)

    def _missing(self, name: str, nodes: Mapping[str, Any]) -> str:
        """Return the message about the first scene without results."""
        chosen = self.dataset[[name, "failure", CHECKSUM]].isel(nodes)
        others = [dim for dim in chosen[name].dims if dim not in nodes]
        known = chosen[name].notnull().all(others) & (chosen[CHECKSUM] != 0)
        at = np.argwhere(~known.transpose(*nodes).values)[0]
        failure = chosen.failure.isel(dict(zip(nodes, at, strict=True)))
        where = ", ".join(f"{axis} = {float(failure[axis]):g}" for axis in nodes)
        why = str(failure.values) or "not computed yet"
        return f"{self.path}: nothing at {where}: {why}; run the campaign again"


def open_grid(path: Path, keep: str, variables: Sequence[str]) -> SceneGrid:
    """Open the dataset of a campaign with results `keep`, by its file or folder; read once until it changes.

    Raises BadScene where it lacks `variables`, has no grid, or axes without numbers.
    """
    if not path.exists():
        raise BadScene(f"{path}: no such file; `femic sweep` of a campaign that keeps {keep!r} makes one")
    grid = _opened(path, path.stat().st_mtime_ns)
    if not all(name in grid.dataset for name in variables):
        raise BadScene(f"{path}: no map: the campaign needs keep = [{keep!r}]")
    return grid


@lru_cache(maxsize=4)
def _opened(path: Path, _changed: int) -> SceneGrid:
    try:
        dataset = open_sweep(path)
    except Exception as error:  # whatever zarr and xarray raise
        raise BadScene(f"{path}: not the file of a campaign: {error}; make one by `femic sweep`") from error
    if dataset.attrs.get("points") != "grid" or "axes" not in dataset.attrs:
        raise BadScene(f"{path}: no map: the campaign needs points = 'all'")
    _require_layout(path, dataset)
    axes = json.loads(dataset.attrs["axes"])
    texts = [axis["name"] for axis in axes if dataset[axis["name"]].dtype.kind not in "fi"]
    if texts:
        raise BadScene(f"{path}: {', '.join(texts)}: there is nothing between values that are not numbers")
    try:
        nodes = tuple(
            AxisNodes(axis["name"], tuple(map(float, dataset[axis["name"]].values)), axis["spacing"])
            for axis in axes
        )
    except WrongInput as error:
        raise BadScene(f"{path}: {error}") from error
    keys = tuple({key: factor or 1.0 for key, factor in axis["keys"].items()} for axis in axes)
    return SceneGrid(path, dataset, nodes, keys, tomllib.loads(dataset.attrs["table"]))


def _require_layout(path: Path, dataset: xr.Dataset) -> None:
    """Raise BadScene for files of older versions, Failure for damaged ones."""
    if LAYOUT not in dataset.attrs:
        raise BadScene(f"{path}: written by an older version; make it again by `femic sweep`")
    with damage_reported(path):
        require_layout(dataset)
