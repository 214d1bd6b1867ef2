"""A map of fits: B-hat-prime of circular arcs with flanks, over flank inclination and radius ratio."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import xarray as xr
from scipy.interpolate import RegularGridInterpolator

from approx.calibration import Fit, fit
from compare.reports.calibration.fits import Calibrated, calibrate, target_from
from compare.results.provenance import results_digest
from compare.scenes.load import load_scene, scene_from_table
from compare.scenes.scene import Scene
from femic.means import DEFAULT, Means
from geometries.errors import WrongInput

Node = tuple[float, float]  # flank inclination [deg], radius of the upper arc over that of the lower

MOST = 40  # scenes
STEEPEST = 85.0  # degrees
SMOOTH = 4  # nodes of an axis from which on interpolation is cubic
TRIED = ("map", "fit", "Bhat")  # on geometries left out: interpolated, their own fit, none


@dataclass(frozen=True)
class Axes:
    """Flank inclinations [deg] and radius ratios of a map, each growing. Raises WrongInput."""

    flanks: tuple[float, ...]
    ratios: tuple[float, ...]

    def __post_init__(self) -> None:
        limits = {"flanks": (0.0, STEEPEST), "ratios": (1.0, np.inf)}
        for name, (low, high) in limits.items():
            values = getattr(self, name)
            growing = len(values) >= 2 and all(a < b for a, b in pairwise(values))
            if not (growing and low <= values[0] and values[-1] <= high and np.isfinite(values[-1])):
                raise WrongInput(f"{name} = {values}: two or more, growing, within {low:g} ... {high:g}")
        total = len(self.nodes) + len(self.left_out)
        if total > MOST:
            raise WrongInput(
                f"flanks, ratios: {total} scenes with those left out; at most {MOST}: give fewer"
            )

    @property
    def nodes(self) -> list[Node]:
        """What the map is made of, ratios running fastest."""
        return list(product(self.flanks, self.ratios))

    @property
    def left_out(self) -> list[Node]:
        """What it is tried on: the middle of every cell."""
        cells = product(pairwise(self.flanks), pairwise(self.ratios))
        return [((a + b) / 2, (c + d) / 2) for (a, b), (c, d) in cells]


def compute_map(base: str, axes: Axes, means: Means = DEFAULT) -> xr.Dataset:
    """Fits at the nodes, and how well B-hat-prime interpolated from them does on the geometries left out.

    `base` is a scene: its materials, patch, rolling radius and calibration are those of all nodes, its
    reference length the radius of the lower arc. Raises as `compare.reports.calibration.fits.calibrate`.
    """
    scene = load_scene(base)

    def at(node: Node) -> Calibrated:
        means.watch.on_stage(f"  flanks {node[0]:g} degrees, radius ratio {node[1]:g}")
        return calibrate(scene_at(scene.text, scene.reference_length, node), means)

    dataset = _of_nodes(scene, axes, [at(node) for node in axes.nodes])
    tried = [_tried(dataset, node, at(node)) for node in axes.left_out]
    meaning = {"units": "1", "meaning": "deviation of B-hat-prime from C, share of max |C| of the points"}
    return dataset.assign(residual=(("left_out", "by", "measure"), np.array(tried), meaning)).assign_coords(
        left_out_flank=("left_out", [node[0] for node in axes.left_out], {"units": "deg"}),
        left_out_ratio=("left_out", [node[1] for node in axes.left_out]),
        by=list(TRIED),
        measure=["rms", "worst"],
    )


def scene_at(text: str, radius: float, node: Node) -> Scene:
    """The scene of a text with the arcs of a node, the lower one of a radius [mm], both bodies together."""
    table, (flank, ratio) = tomllib.loads(text), node
    for body, factor in (("lower", 1.0), ("upper", ratio)):
        arc = {"kind": "arc", "radius": radius * factor, "flank_inclination_deg": flank}
        table[body] = table[body] | {"contour": arc}
    table["engine"] = table.get("engine", {}) | {"check": False}
    table["calibration"] = table.get("calibration", {}) | {"bodies": ["combined"]}
    return scene_from_table(table | {"bodies": ["combined"]}, f"flank {flank:g}, ratio {ratio:g}")


def _of_nodes(scene: Scene, axes: Axes, found: Sequence[Calibrated]) -> xr.Dataset:
    """C at the points of the calibration, fits and their residuals at the nodes."""
    targets, fits = [one.targets["combined"] for one in found], [one.fits["combined"] for one in found]
    over, shape = ("flank", "ratio"), (len(axes.flanks), len(axes.ratios), -1)
    c = [_unit(one.scene) * target.ics for one, target in zip(found, targets, strict=True)]
    return xr.Dataset(
        {
            "c": ((*over, "component", "point"), np.reshape(c, (*shape[:2], *c[0].shape)), {"units": "1"}),
            "value": (
                (*over, "parameter"),
                np.reshape([[p.value for p in f.parameters] for f in fits], shape),
            ),
            "rms": ((*over, "component"), np.reshape([f.rms for f in fits], shape)),
            "worst": ((*over, "component"), np.reshape([f.worst for f in fits], shape)),
        },
        coords={
            "flank": ("flank", list(axes.flanks), {"units": "deg"}),
            "ratio": list(axes.ratios),
            "parameter": [parameter.name for parameter in fits[0].parameters],
            "component": list(scene.calibration.components),
        },
        attrs={
            "title": f"B-hat-prime over flank inclination and radius ratio: {scene.name}",
            "scene": scene.text,
            "reference_length": scene.reference_length,
            "half_space": float(getattr(scene.pair.constants, scene.calibration.properties[0])),
            "code": results_digest(),
        },
    )


def _unit(scene: Scene) -> float:
    """Makes ICs per unit pressure dimensionless [MPa/mm]."""
    return scene.reference_E * scene.reference_length / scene.patch.area


def fit_at(dataset: xr.Dataset, flank: float, ratio: float) -> Fit:
    """The fit of B-hat-prime to C interpolated between the nodes, for the patch and materials of the map.

    Cubic in the inclination and the inverse ratio, linear in both where one has fewer than four nodes. r_inf
    is in mm for the map's `reference_length`: other sizes with the same proportions have it in proportion.
    Raises WrongInput outside the map.
    """
    flanks, ratios = dataset.flank.values, dataset.ratio.values
    if not (flanks[0] <= flank <= flanks[-1] and ratios[0] <= ratio <= ratios[-1]):
        raise WrongInput(
            f"flank = {flank:g} degrees, ratio = {ratio:g}: outside the map, {flanks[0]:g} ... "
            f"{flanks[-1]:g} degrees and {ratios[0]:g} ... {ratios[-1]:g}"
        )
    scene = scene_at(dataset.attrs["scene"], dataset.attrs["reference_length"], (flank, ratio))
    method = "cubic" if min(len(flanks), len(ratios)) >= SMOOTH else "linear"
    between = RegularGridInterpolator((flanks, -1 / ratios), dataset.c.values, method=method)
    ics = between((flank, -1 / ratio)) / _unit(scene)
    return fit(target_from(scene, ics), scene.calibration.properties)


def _tried(dataset: xr.Dataset, node: Node, found: Calibrated) -> list[list[float]]:
    """Residuals on one geometry, rms and worst: by the map, by its own fit, by B-hat."""
    target, own = found.targets["combined"], found.fits["combined"]
    tried = (target.of(fit_at(dataset, *node).effective), target.of(own.effective), target.by("Bhat"))
    offs = [np.abs(ics - target.ics) / target.scales for ics in tried]
    return [[float(np.sqrt(np.mean(off**2))), float(np.max(off))] for off in offs]
