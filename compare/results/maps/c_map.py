"""A map of C: C_nn on a grid at any values of the swept keys of a campaign that kept "matrix".

C less B-hat is interpolated between the nodes, as a share of the mean B-hat of an element on itself: it is
smaller and smoother than C, and does not depend on the size of the moduli. B-hat itself is exact. At a node
the map is C to rounding. What is known of it: the estimate of C at the nodes around, and
the error on left-out nodes next to the place, along each axis.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import xarray as xr

from compare.results.contact.pairing import Placed
from compare.results.maps.between import Nodes, Stencil, combined
from compare.results.sweep.dataset import open_sweep
from compare.scenes.campaign import key_of, set_key
from compare.scenes.errors import BadScene
from compare.scenes.file import MAP
from compare.scenes.load import scene_from_table
from compare.scenes.scene import Scene
from contact.operators.dense import dense
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.grids import Grid

SAME = 1e-9  # relative difference of numbers that are the same
KEPT = ("c", "c_estimate", "bhat")


@dataclass(frozen=True, eq=False)
class CMap:
    """The file of a campaign that kept "matrix", as a map of C."""

    path: Path
    dataset: xr.Dataset
    axes: tuple[Nodes, ...]
    keys: tuple[Mapping[str, float], ...]  # of each axis: keys of a scene, and what a value is multiplied by
    table: Mapping[str, Any]  # of the scenes, but for the axes

    @cached_property
    def base(self) -> Scene:
        """The scene without the axes' keys; it has the grid of the map."""
        return scene_from_table(dict(self.table), str(self.path))

    @property
    def grid(self) -> Grid:
        """The grid on which C is known."""
        return self.base.grid

    def at(self, scene: Scene, placed: Placed) -> tuple[Array, Array]:
        """C_nn [mm/MPa] of both bodies of a scene on the grid, and what it is known to, (n_x, n_s, n_s) each.

        Raises BadScene where the scene is not one of the map's but for the axes, WrongInput outside the map,
        and Failure where a scene of the campaign that is needed has no results.
        """
        point = self.point_of(scene)
        stencils = [axis.at(value) for axis, value in zip(self.axes, point, strict=True)]
        bhat = bhat_nn(placed)
        own, axes = _own(bhat), tuple(range(len(stencils)))
        correction = combined(self._corrections(stencils), stencils)
        estimate = np.max(self._at_nodes("c_estimate", stencils), axis=axes)
        return bhat + own * correction, estimate + own * self._error(point)

    def point_of(self, scene: Scene) -> tuple[float, ...]:
        """The values of the axes in a scene, which must be one of the map's but for these."""
        table, own = tomllib.loads(scene.text), json.loads(json.dumps(self.table))
        point = []
        for axis, keys in zip(self.axes, self.keys, strict=True):
            values = [_number(table, key, axis.name) / factor for key, factor in keys.items()]
            if not np.ptp(values) <= SAME * np.max(np.abs(values)):
                raise BadScene(
                    f"{scene.name}: {', '.join(keys)} give {axis.name} = {values}: in {self.path} "
                    "they are the same"
                )
            for key in keys:
                set_key(own, key, key_of(table, key, axis.name), axis.name)
            point.append(self._rounded(axis, float(values[0])))
        self._require_same(scene, scene_from_table(own, scene.name))
        return tuple(point)

    def _rounded(self, axis: Nodes, value: float) -> float:
        """The value of a node that a value is to rounding, else the value."""
        return next((node for node in axis.values if abs(node - value) <= SAME * abs(node)), value)

    def _require_same(self, scene: Scene, own: Scene) -> None:
        """Raise BadScene where C of a scene differs from that of the map's scene with the same axes."""
        swept = ", ".join(axis.name for axis in self.axes)
        for name in ("lower", "upper"):
            mine, others = (_c_rests_on(one, name) for one in (scene, own))
            different = [what for what, value in mine.items() if value != others[what]]
            if different:
                raise BadScene(
                    f"{scene.name}: {' and '.join(different)} of the {name} body: not as in {self.path}, "
                    f"which knows C for other values of {swept} only"
                )

    def _corrections(self, stencils: list[Stencil]) -> Array:
        """C less B-hat at the nodes of stencils, over the mean B-hat of an element on itself [-]."""
        bhat = self._at_nodes("bhat", stencils)
        return (self._at_nodes("c", stencils) - bhat) / _own(bhat)[..., None, None, None]

    def _at_nodes(self, name: str, stencils: list[Stencil]) -> Array:
        """A variable at the nodes of stencils, (k_1, ..., k_m, lag, observed, loaded)."""
        nodes = {axis.name: stencil.nodes for axis, stencil in zip(self.axes, stencils, strict=True)}
        values = self.dataset[name].isel(nodes).values
        if np.any(np.isnan(values)):
            raise Failure(self._missing(nodes))
        return np.asarray(values, dtype=float)

    def _missing(self, nodes: Mapping[str, Any]) -> str:
        """Which scenes of the campaign have no results, and why."""
        failure = self.dataset.failure.isel(nodes)
        at = np.argwhere(self.dataset.c.isel(nodes).isnull().any(("lag", "observed", "loaded")).values)[0]
        one = failure.isel(dict(zip(nodes, at, strict=True)))
        where = ", ".join(f"{name} = {float(one[name]):g}" for name in nodes)
        return (
            f"{self.path}: no C at {where}: {str(one.values) or 'not computed yet'}; run `femic sweep` again"
        )

    def _error(self, point: tuple[float, ...]) -> Array:
        """Errors of corrections on left-out nodes next to a point [-], the largest along each axis, added."""
        nearest = [
            Stencil(np.array([int(np.argmin(np.abs(np.array(axis.values) - value)))]), np.ones(1))
            for axis, value in zip(self.axes, point, strict=True)
        ]
        errors = []
        for k, (axis, value) in enumerate(zip(self.axes, point, strict=True)):
            along = []
            for node, others in axis.left_out(value):
                line = [*nearest[:k], others, *nearest[k + 1 :]]
                itself = [*nearest[:k], Stencil(np.array([node]), np.ones(1)), *nearest[k + 1 :]]
                predicted, known = (combined(self._corrections(of), of) for of in (line, itself))
                along.append(np.abs(predicted - known))
            errors.append(np.max(along, axis=0))
        return np.asarray(np.sum(errors, axis=0))


def open_map(name: str) -> CMap:
    """The map of C of ICs such as "map:out/flanks/sweep.nc"; raises BadScene where the file is none.

    It is the file of a campaign, or the folder with it, that kept "matrix" on a grid of numbers.
    """
    path = Path(name.removeprefix(MAP))
    if not path.exists():
        raise BadScene(f'{name}: no such file; `femic sweep` of a campaign that keeps "matrix" makes one')
    return _opened(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _opened(path: Path, _changed: int) -> CMap:
    """The map of a file, read once until it is changed."""
    try:
        dataset = open_sweep(path)
    except (OSError, ValueError) as error:
        raise BadScene(f"map:{path}: no file of a campaign: {error}; make one by `femic sweep`") from error
    if dataset.attrs.get("points") != "grid" or not all(name in dataset for name in KEPT):
        raise BadScene(f"map:{path}: no map of C: the campaign needs keep = ['matrix'] and points = 'all'")
    axes = json.loads(dataset.attrs["axes"])
    texts = [axis["name"] for axis in axes if dataset[axis["name"]].dtype.kind not in "fi"]
    if texts:
        raise BadScene(f"map:{path}: {', '.join(texts)}: there is nothing between values that are no numbers")
    try:
        nodes = tuple(_nodes(dataset, axis) for axis in axes)
    except WrongInput as error:
        raise BadScene(f"map:{path}: {error}") from error
    keys = tuple({key: factor or 1.0 for key, factor in axis["keys"].items()} for axis in axes)
    return CMap(path, dataset, nodes, keys, tomllib.loads(dataset.attrs["table"]))


def bhat_nn(placed: Placed) -> Array:
    """B-hat_nn of both bodies on a grid [mm/MPa], (n_x, n_s, n_s)."""
    return dense(placed.operator("Bhat"))[..., 0, 0]


def _own(bhat: Array) -> Array:
    """The mean of B-hat (..., lag, observed, loaded) of an element on itself [mm/MPa], (...)."""
    return np.asarray(np.mean(np.diagonal(bhat[..., 0, :, :], axis1=-2, axis2=-1), axis=-1))


def _nodes(dataset: xr.Dataset, axis: Mapping[str, Any]) -> Nodes:
    values = tuple(float(value) for value in dataset[axis["name"]].values)
    return Nodes(axis["name"], values, axis["logarithmic"])


def _number(table: Mapping[str, Any], key: str, axis: str) -> float:
    value = key_of(table, key, axis)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise BadScene(f"{key} = {value!r}: a map of C over {axis} needs a number there")
    return float(value)


def _c_rests_on(scene: Scene, name: str) -> dict[str, object]:
    """What C of a body rests on, but for its accuracy and the grid."""
    body, settings = scene.bodies[name], scene.settings
    return {
        "contour": joblib.hash(body.contour),
        "E": body.material.E,
        "nu": body.material.nu,
        "rolling_radius": body.rolling_radius,
        "hub_radius": body.hub_radius,
        "rotation_reach": settings.rotation_reach,
        "moment_arm": settings.moment_arm,
        "contact.shift": scene.contact.shift,
    }
