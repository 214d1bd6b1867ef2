"""C at any values of the swept keys of a campaign: maps of C on a grid, and fits of B-hat-prime.

A map of C is of a campaign that kept "matrix": of C_nn, or, where its scenes have friction, of all
components, as their motion needs them. C less B-hat is interpolated between the nodes, as a share of
the mean B-hat of an element on itself: it is smaller and smoother than C, and does not depend on the size of
the moduli. B-hat itself is exact. At a node the map is C to rounding. Its error: the estimate of C at the
nodes around, and the largest error at left-out nodes around the place, along each axis.

Fits are of a campaign that kept "calibration". C at the points of the calibration is interpolated, and then
fitted: parameters that the data hardly determine jump from scene to scene, C does not.
"""

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import joblib
import numpy as np
import xarray as xr

from approx.calibration import Fit, Target, fit
from compare.campaigns.interpolation import KINK, SceneGrid, Stencil, interpolate, open_grid
from compare.campaigns.keys import is_number
from femic.contact.motions import find_motion
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs.ics import GivenICs
from femic.contact.pairs.pair_on_grid import PairOnGrid, pair_on_grid
from femic.results.calibration import dimensionless_factor, target_from
from femic.scenes.errors import BadScene
from femic.scenes.ic_names import MAP, is_map
from femic.scenes.input_files import key_of, set_key
from femic.scenes.load import scene_from_table
from femic.scenes.scene import Scene
from geometries.arrays import Array
from geometries.patches import Grid, N

# --- maps of C ------------------------------------------------------------------------------------------


SAME = 1e-9  # relative difference of numbers that are the same
VARIABLES = ("c", "c_estimate", "bhat")


@dataclass(frozen=True, eq=False)
class CMap:
    """The map of C of a campaign that kept "matrix", at the place of one scene.

    A contact without friction takes it as given ICs (`femic.contact.pairs.ics.NormalICs`).
    """

    nodes: SceneGrid
    scene: Scene

    @cached_property
    def grid(self) -> Grid:
        """The grid on which C is known."""
        return scene_from_table(dict(self.nodes.table), str(self.nodes.path)).grid

    def at(self, on_grid: PairOnGrid) -> tuple[Array, Array]:
        """Return C [mm/MPa] of both bodies on the grid, and its error.

        Shape (n_x, n_s, n_s) each, C_nn; with friction (n_x, n_s, n_s, 3, 3). Raises BadScene where the scene
        is not one of the map's but for the axes, WrongInput outside the map, and Failure where a scene of the
        campaign that is needed has no results.
        """
        point = self.point
        stencils = self.nodes.stencils(point)
        bhat = bhat_for_map(self.scene, on_grid)
        own, axes = self._self_ic(bhat), tuple(range(len(stencils)))
        correction = interpolate(self._corrections(stencils), stencils)
        estimate = np.max(self.nodes.at_nodes("c_estimate", stencils), axis=axes)
        return bhat + own * correction, estimate + own * self._error(point)

    @property
    def point(self) -> tuple[float, ...]:
        """The values of the axes in the scene, which must otherwise equal the map's; raises BadScene."""
        scene = self.scene
        table, own = tomllib.loads(scene.text), json.loads(json.dumps(self.nodes.table))
        point = []
        for axis, keys in zip(self.nodes.axes, self.nodes.keys, strict=True):
            entries = {key: key_of(table, key, axis.name) for key in keys}
            for key, entry in entries.items():
                if not is_number(entry):
                    raise BadScene(f"{key} = {entry!r}; a map of C over {axis.name} needs a number")
                set_key(own, key, entry, axis.name)
            values = [float(entries[key]) / factor for key, factor in keys.items()]
            if not np.ptp(values) <= SAME * np.max(np.abs(values)):
                raise BadScene(
                    f"{scene.name}: {', '.join(keys)} give {axis.name} = {values}: in {self.nodes.path} "
                    "they are the same"
                )
            same = (node for node in axis.values if abs(node - values[0]) <= SAME * abs(node))
            point.append(next(same, values[0]))
        own_scene = scene_from_table(own, scene.name)
        for name in ("lower", "upper"):
            inputs, own_inputs = _inputs_of_c(scene, name), _inputs_of_c(own_scene, name)
            different = [what for what, value in inputs.items() if value != own_inputs[what]]
            if different:
                axes = ", ".join(axis.name for axis in self.nodes.axes)
                raise BadScene(
                    f"{scene.name}: {' and '.join(different)} of the {name} body: not as in "
                    f"{self.nodes.path}, which holds C for other values of {axes} only"
                )
        return tuple(point)

    def _corrections(self, stencils: list[Stencil]) -> Array:
        """Return C less B-hat at the nodes of stencils, over the mean B-hat of an element on itself [-]."""
        bhat = self.nodes.at_nodes("bhat", stencils)
        own = self._self_ic(bhat)
        return (self.nodes.at_nodes("c", stencils) - bhat) / own.reshape(
            own.shape + (1,) * (bhat.ndim - own.ndim)
        )

    def _self_ic(self, bhat: Array) -> Array:
        """Return the mean of B-hat_nn of an element on itself [mm/MPa], by node."""
        nn = bhat[..., N, N] if self.scene.contact.friction else bhat
        return np.asarray(np.mean(np.diagonal(nn[..., 0, :, :], axis1=-2, axis2=-1), axis=-1))

    def _error(self, point: tuple[float, ...]) -> Array:
        """Return errors of corrections near a point [-]: the sum over axes of the largest at left-out nodes.

        These lie on the lines through all nodes around the point: a kink may lie elsewhere on each.
        """
        around = [axis.neighbours(value) for axis, value in zip(self.nodes.axes, point, strict=True)]
        errors = []
        for k, (axis, value) in enumerate(zip(self.nodes.axes, point, strict=True)):
            along = []
            for beside in product(*around[:k], *around[k + 1 :]):
                for node, others in axis.left_out(value):
                    itself = [*beside[:k], axis.single(node), *beside[k:]]
                    stencils = [*beside[:k], others, *beside[k:]]
                    predicted = interpolate(self._corrections(stencils), stencils)
                    along.append(np.abs(predicted - interpolate(self._corrections(itself), itself)))
            errors.append(KINK * np.max(along, axis=0))
        return np.asarray(np.sum(errors, axis=0))


def open_map(name: str, scene: Scene) -> CMap:
    """Open the map of C of ICs such as "map:out/flanks/sweep.nc"; raise BadScene for other files.

    The file, or the folder with it, is of a campaign that kept "matrix" on a grid of numbers.
    """
    try:
        return CMap(open_grid(Path(name.removeprefix(MAP)), "matrix", VARIABLES), scene)
    except BadScene as error:
        raise BadScene(f"contact.ics: {MAP}{error}") from error


def maps_of_scene(scene: Scene) -> dict[str, Any]:
    """Open the maps of C among the ICs of a scene, by name; raise as `open_map`.

    With friction they are read on their grid (`femic.contact.pairs.ics.GivenICs`), which raises as `CMap.at`.
    """
    maps = {name: open_map(name, scene) for name in scene.contact.ics if is_map(name)}
    if not scene.contact.friction:
        return dict(maps)
    problem = scene.contact_problem
    return {name: GivenICs(own.grid, *own.at(pair_on_grid(problem, own.grid))) for name, own in maps.items()}


def bhat_for_map(scene: Scene, on_grid: PairOnGrid) -> Array:
    """Return B-hat of both bodies on a grid [mm/MPa], nn or, with friction, all: (n_x, n_s, n_s[, 3, 3])."""
    ics = approximate_matrix("Bhat", on_grid.pair, on_grid.grid, upper_offset=on_grid.offset)
    return ics if scene.contact.friction else ics[..., N, N]


def _inputs_of_c(scene: Scene, name: str) -> dict[str, object]:
    """Return the inputs of C of a body, except its accuracy and the grid."""
    body, settings = scene.bodies[name], scene.settings
    return {
        "contour": joblib.hash(body.contour),
        "E": body.material.E,
        "nu": body.material.nu,
        "rolling_radius": body.rolling_radius,
        "hub_radius": body.hub_radius,
        "outline": joblib.hash(body.outline),
        "rotation_reach": settings.rotation_reach,
        "moment_arm": settings.moment_arm,
        "discount": scene.discount,
        "engine.far_radius": scene.support_radius,
        "reference_length": settings.approach_side,
        "contact.shift": scene.contact.shift,
        "contact.motion": scene.contact.friction and find_motion(scene.contact).wheel_rolls,
    }


# --- fits of B-hat-prime --------------------------------------------------------------------------------


BY = ("map", "own", "Bhat")  # fit of C from other nodes, own fit, no fit


def open_fits(path: Path) -> SceneGrid:
    """Open the dataset of a campaign that kept "calibration"; raise BadScene for others."""
    return open_grid(path, "calibration", ("fit_c",))


def fit_at(fits: SceneGrid, point: Sequence[float], body: str = "combined") -> Fit:
    """Return the fit to C at values of the axes, for the patch and the materials of the campaign.

    Raises WrongInput outside the map, Failure where a scene that is needed has no results.
    """
    return fit(_target(fits, point, fits.stencils(point), body), fits.scene(point).calibration.properties)


def leave_one_out(fits: SceneGrid, body: str = "combined") -> xr.Dataset:
    """Return deviations from C, `rms` and `worst` (node, by), at nodes that the others on an axis predict.

    They are shares of max |C| of the points: of the fit to C from the other nodes ("map"), of the fit to C
    itself ("own"), and of B-hat. `along` is the axis along which the node was left out.
    """
    places = [range(len(axis.values)) for axis in fits.axes]
    inner = [range(1, len(axis.values) - 1) for axis in fits.axes]
    cases = [
        (along, node)
        for along in range(len(fits.axes))
        for node in product(*(inner[k] if k == along else places[k] for k in range(len(places))))
    ]
    values = np.array(
        [[axis.values[k] for axis, k in zip(fits.axes, node, strict=True)] for _, node in cases]
    )
    rows = []
    for (along, node), point in zip(cases, values.tolist(), strict=True):
        itself = [axis.single(k) for axis, k in zip(fits.axes, node, strict=True)]
        others = [*itself[:along], fits.axes[along].without(node[along]), *itself[along + 1 :]]
        properties = fits.scene(point).calibration.properties
        target, predicted = (_target(fits, point, stencils, body) for stencils in (itself, others))
        approximations = [
            target.bhat_prime(fit(predicted, properties).effective),
            target.bhat_prime(fit(target, properties).effective),
            target.approximate("Bhat"),
        ]
        shares = [np.abs(ics - target.ics) / target.scales for ics in approximations]
        rows.append([(np.sqrt(np.mean(share**2)), np.max(share)) for share in shares])
    share = {"units": "1", "long_name": "deviation from C, relative to max |C| of the points"}
    return xr.Dataset(
        {
            name: (("node", "by"), np.array(rows)[:, :, number], share)
            for number, name in enumerate(("rms", "worst"))
        }
        | {axis.name: ("node", values[:, k]) for k, axis in enumerate(fits.axes)}
        | {"along": ("node", [fits.axes[along].name for along, _ in cases])},
        coords={"by": list(BY)},
    )


def _target(fits: SceneGrid, point: Sequence[float], stencils: list[Stencil], body: str) -> Target:
    """Return C of stencils as the target of a fit at a point."""
    scene = fits.scene(point)
    place = list(fits.dataset.fitted_body.values).index(body)
    values = interpolate(fits.at_nodes("fit_c", stencils), stencils)[place]
    return target_from(scene, values / dimensionless_factor(scene), body)
