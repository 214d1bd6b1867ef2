"""A map of C: C_nn on a grid at any values of the swept keys of a campaign that kept "matrix".

C less B-hat is interpolated between the nodes, as a share of the mean B-hat of an element on itself: it is
smaller and smoother than C, and does not depend on the size of the moduli. B-hat itself is exact. At a node
the map is C to rounding. What is known of it: the estimate of C at the nodes around, and the largest
error on left-out nodes around the place, along each axis.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import joblib
import numpy as np

from femic.campaigns.maps.between import KINK, Nodes, Stencil, combined
from femic.campaigns.maps.swept import Swept, open_swept
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.scenes.errors import BadScene
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.keys import key_of, set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.grids import Grid
from geometries.patches import N

SAME = 1e-9  # relative difference of numbers that are the same
KEPT = ("c", "c_estimate", "bhat")


@dataclass(frozen=True, eq=False)
class CMap:
    """The dataset of a campaign that kept "matrix", as a map of C."""

    swept: Swept

    @cached_property
    def base(self) -> Scene:
        """The scene without the axes' keys; it has the grid of the map."""
        return scene_from_table(dict(self.swept.table), str(self.swept.path))

    @property
    def grid(self) -> Grid:
        """The grid on which C is known."""
        return self.base.grid

    def at(self, scene: Scene, on_grid: PairOnGrid) -> tuple[Array, Array]:
        """C_nn [mm/MPa] of both bodies of a scene on the grid, and what it is known to, (n_x, n_s, n_s) each.

        Raises BadScene where the scene is not one of the map's but for the axes, WrongInput outside the map,
        and Failure where a scene of the campaign that is needed has no results.
        """
        point = self.point_of(scene)
        stencils = self.swept.stencils(point)
        bhat = bhat_nn(on_grid)
        own, axes = _own(bhat), tuple(range(len(stencils)))
        correction = combined(self._corrections(stencils), stencils)
        estimate = np.max(self.swept.at_nodes("c_estimate", stencils), axis=axes)
        return bhat + own * correction, estimate + own * self._error(point)

    def point_of(self, scene: Scene) -> tuple[float, ...]:
        """The values of the axes in a scene, which must be one of the map's but for these."""
        table, own = tomllib.loads(scene.text), json.loads(json.dumps(self.swept.table))
        point = []
        for axis, keys in zip(self.swept.axes, self.swept.keys, strict=True):
            values = [_number(table, key, axis.name) / factor for key, factor in keys.items()]
            if not np.ptp(values) <= SAME * np.max(np.abs(values)):
                raise BadScene(
                    f"{scene.name}: {', '.join(keys)} give {axis.name} = {values}: in {self.swept.path} "
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
        swept = ", ".join(axis.name for axis in self.swept.axes)
        for name in ("lower", "upper"):
            mine, others = (_c_rests_on(one, name) for one in (scene, own))
            different = [what for what, value in mine.items() if value != others[what]]
            if different:
                raise BadScene(
                    f"{scene.name}: {' and '.join(different)} of the {name} body: not as in "
                    f"{self.swept.path}, which knows C for other values of {swept} only"
                )

    def _corrections(self, stencils: list[Stencil]) -> Array:
        """C less B-hat at the nodes of stencils, over the mean B-hat of an element on itself [-]."""
        bhat = self.swept.at_nodes("bhat", stencils)
        return (self.swept.at_nodes("c", stencils) - bhat) / _own(bhat)[..., None, None, None]

    def _error(self, point: tuple[float, ...]) -> Array:
        """Errors of corrections near a point [-]: the largest on left-out nodes along each axis, added.

        These lie on the lines through all nodes around the point: a kink may lie elsewhere on each.
        """
        around = [axis.beside(value) for axis, value in zip(self.swept.axes, point, strict=True)]
        errors = []
        for k, (axis, value) in enumerate(zip(self.swept.axes, point, strict=True)):
            along = [
                self._missed(
                    [*beside[:k], others, *beside[k:]], [*beside[:k], axis.itself(node), *beside[k:]]
                )
                for beside in product(*around[:k], *around[k + 1 :])
                for node, others in axis.left_out(value)
            ]
            errors.append(KINK * np.max(along, axis=0))
        return np.asarray(np.sum(errors, axis=0))

    def _missed(self, others: list[Stencil], itself: list[Stencil]) -> Array:
        """By how much corrections from other nodes differ from those at a node itself [-]."""
        predicted, known = (combined(self._corrections(of), of) for of in (others, itself))
        return np.abs(predicted - known)


def open_map(name: str) -> CMap:
    """The map of C of ICs such as "map:out/flanks/sweep.nc"; raises BadScene where the file is none.

    It is the file of a campaign, or the folder with it, that kept "matrix" on a grid of numbers.
    """
    try:
        return CMap(open_swept(Path(name.removeprefix(MAP)), "matrix", KEPT))
    except BadScene as error:
        raise BadScene(f"contact.ics: {MAP}{error}") from error


@dataclass(frozen=True, eq=False)
class MapOfScene:
    """A map of C for one scene, as contact takes ICs that are given."""

    c_map: CMap
    scene: Scene

    @property
    def grid(self) -> Grid:
        """The grid on which C is known."""
        return self.c_map.grid

    def at(self, on_grid: PairOnGrid) -> tuple[Array, Array]:
        """C_nn of both bodies and its errors, as `CMap.at`."""
        return self.c_map.at(self.scene, on_grid)


def maps_of_scene(scene: Scene) -> dict[str, MapOfScene]:
    """The maps of C among the ICs of a scene, by name; raises as `open_map`."""
    return {name: MapOfScene(open_map(name), scene) for name in scene.contact.ics if is_map(name)}


def bhat_nn(on_grid: PairOnGrid) -> Array:
    """B-hat_nn of both bodies on a grid [mm/MPa], (n_x, n_s, n_s)."""
    ics = approximate_matrix("Bhat", on_grid.pair, on_grid.grid, upper_offset=on_grid.offset)
    return ics[..., N, N]


def _own(bhat: Array) -> Array:
    """The mean of B-hat (..., lag, observed, loaded) of an element on itself [mm/MPa], (...)."""
    return np.asarray(np.mean(np.diagonal(bhat[..., 0, :, :], axis1=-2, axis2=-1), axis=-1))


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
        "discount": scene.discount,
        "engine.far_radius": scene.support_radius,
        "reference_length": settings.approach_side,
        "contact.shift": scene.contact.shift,
    }
