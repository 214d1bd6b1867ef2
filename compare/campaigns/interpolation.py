"""Interpolation between the scenes of a campaign on a grid, and its error at scenes that are left out.

Along each axis a polynomial goes through the nearest four nodes (cubic), so that a place needs few nodes of
a large map. The error is measured where it can be: each inner one of these nodes is left out, and predicted
from the others of its line. There the nodes are twice as far apart, so that a smooth function is predicted
about seven times worse than half way between nodes. A function with a kink is not: with one half way between
two nodes the polynomial errs by 3/8 there, and by 1/6 at each of the two when it is left out (slopes -1 and
1, nodes at distance 1). So the largest error of all these nodes counts `KINK` times.
"""

import json
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from compare.campaigns.dataset import DIGEST, damage_reported, open_sweep
from femic.scenes.errors import BadScene
from femic.scenes.input_files import set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.arrays import Array, Indices
from geometries.errors import Failure, WrongInput

NEAREST = 4  # nodes along an axis through which a polynomial goes
KINK = (3 / 8) / (1 / 6)  # error at a kink half way between nodes over that on left-out nodes beside it
SPACINGS: Mapping[str, Callable[[Array], Array]] = MappingProxyType(
    {"linear": np.asarray, "logarithmic": np.log, "inverse": lambda values: -1 / values}
)
FEWEST = 3  # nodes of an axis: fewer tell nothing about the error


# --- nodes along an axis --------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Stencil:
    """Numbers (k,) of nodes along an axis, and their weights (k,), whose sum is 1."""

    nodes: Indices
    weights: Array


@dataclass(frozen=True)
class AxisNodes:
    """The increasing values of an axis, and how distances between them are measured: `SPACINGS`.

    Raises WrongInput where there are fewer than `FEWEST`, they do not increase, or are not positive where
    they have to be.
    """

    name: str
    values: tuple[float, ...]
    spacing: str = "linear"

    def __post_init__(self) -> None:
        increasing = all(a < b for a, b in pairwise(self.values))
        positive = self.spacing == "linear" or self.values[0] > 0
        if len(self.values) < FEWEST or not increasing or not positive:
            raise WrongInput(
                f"axis {self.name}, {len(self.values)} values: a map needs {FEWEST} or more that increase"
                f"{'' if positive else ', all positive'}"
            )

    @property
    def places(self) -> Array:
        """The places of the nodes on the scale of `spacing`, (n,)."""
        return SPACINGS[self.spacing](np.array(self.values))

    def place(self, value: float) -> float:
        """Return the place of a value on the scale of `spacing`."""
        return float(SPACINGS[self.spacing](np.array(value)))

    def at(self, value: float) -> Stencil:
        """Return the stencil of a value; raise WrongInput outside the axis."""
        low, high = self.values[0], self.values[-1]
        if not low <= value <= high:
            raise WrongInput(f"{self.name} = {value:g}: outside the map, {low:g} ... {high:g}")
        if value in self.values:
            return Stencil(np.array([self.values.index(value)]), np.ones(1))
        return self._through(np.arange(len(self.values)), self.place(value))

    def left_out(self, value: float) -> list[tuple[int, Stencil]]:
        """Return the inner nodes among the nearest to a value, each with the stencil that predicts it."""
        everywhere, place = np.arange(len(self.values)), self.place(value)
        nearest = self._through(everywhere, place).nodes
        return [(int(node), self.without(int(node))) for node in nearest if 0 < node < len(everywhere) - 1]

    def neighbours(self, value: float) -> list[Stencil]:
        """Return the stencils of the nodes on both sides of a value."""
        place = self.place(value)
        below = int(np.searchsorted(self.places, place, "right")) - 1
        low = min(max(below, 0), len(self.values) - 2)
        return [self.single(node) for node in (low, low + 1)]

    def single(self, node: int) -> Stencil:
        """Return the stencil of a single node."""
        return Stencil(np.array([node]), np.ones(1))

    def without(self, node: int) -> Stencil:
        """Return the stencil of the other nodes that predicts an inner node."""
        everywhere = np.arange(len(self.values))
        return self._through(everywhere[everywhere != node], float(self.places[node]))

    def _through(self, allowed: Indices, place: float) -> Stencil:
        """Return the polynomial through the nearest of some nodes at a place."""
        nearest = np.argsort(np.abs(self.places[allowed] - place), kind="stable")[:NEAREST]
        chosen = np.sort(allowed[nearest])
        at = self.places[chosen]
        weights = [np.prod([(place - b) / (a - b) for b in at if b != a]) for a in at]
        return Stencil(chosen, np.array(weights))


def interpolate(values: Array, stencils: list[Stencil]) -> Array:
    """Return the sum of values (k_1, ..., k_m, ...) at the nodes of stencils, times their weights."""
    for stencil in stencils:
        values = np.tensordot(stencil.weights, values, axes=(0, 0))
    return np.asarray(values)


# --- scenes as nodes ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class SceneGrid:
    """The dataset of a campaign, its axes as nodes, and the scene that they vary."""

    path: Path
    dataset: xr.Dataset
    axes: tuple[AxisNodes, ...]
    keys: tuple[Mapping[str, float], ...]  # by axis: keys of a scene, and the factor of each
    table: Mapping[str, Any]  # of the scenes, but for the axes

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
        with damage_reported(self.path):
            chosen = self.dataset[[name, "failure", DIGEST]].isel(nodes).load()
        others = [dim for dim in chosen[name].dims if dim not in nodes]
        known = (chosen[name].notnull().all(others) & (chosen[DIGEST] != 0)).transpose(*nodes).values
        if not np.all(known):
            first = dict(zip(nodes, np.argwhere(~known)[0], strict=True))
            failure = chosen.failure.isel(first)
            where = ", ".join(f"{axis} = {float(failure[axis]):g}" for axis in nodes)
            why = str(failure.values) or "not computed yet"
            raise Failure(f"{self.path}: no result at {where}: {why}; run the campaign again")
        return np.asarray(chosen[name], dtype=float)


def open_grid(path: Path, keep: str, variables: Sequence[str]) -> SceneGrid:
    """Open the dataset of a campaign with results `keep`, by its file or folder; read once until it changes.

    Raises BadScene where it lacks `variables`, has no grid, or axes without numbers.
    """
    if not path.exists():
        raise BadScene(f"{path}: no such file; `femic sweep` of a campaign that keeps {keep!r} makes one")
    grid = _open(path, path.stat().st_mtime_ns)
    if not all(name in grid.dataset for name in variables):
        raise BadScene(f"{path}: no map: the campaign needs keep = [{keep!r}]")
    return grid


@lru_cache(maxsize=4)
def _open(path: Path, _changed: int) -> SceneGrid:
    try:
        dataset = open_sweep(path)
    except Exception as error:  # whatever zarr and xarray raise
        raise BadScene(f"{path}: not the file of a campaign: {error}; make one by `femic sweep`") from error
    if dataset.attrs.get("points") != "grid" or "axes" not in dataset.attrs:
        raise BadScene(f"{path}: not a map; the campaign needs points = 'all'")
    if DIGEST not in dataset.variables:
        raise BadScene(f"{path}: written by an older version; run `femic sweep` again")
    with damage_reported(path):
        dataset = dataset.load() if path.is_file() else dataset
        axes = json.loads(dataset.attrs["axes"])
        values = {axis["name"]: dataset[axis["name"]].values for axis in axes}
    if texts := [name for name, along in values.items() if along.dtype.kind not in "fi"]:
        raise BadScene(f"{path}: {', '.join(texts)}: values that are not numbers cannot be interpolated")
    try:
        nodes = tuple(
            AxisNodes(axis["name"], tuple(map(float, values[axis["name"]])), axis["spacing"]) for axis in axes
        )
    except WrongInput as error:
        raise BadScene(f"{path}: {error}") from error
    keys = tuple({key: factor or 1.0 for key, factor in axis["keys"].items()} for axis in axes)
    return SceneGrid(path, dataset, nodes, keys, tomllib.loads(dataset.attrs["table"]))
