"""A map of fits of B-hat-prime to circular arcs with flanks, over flank inclination and radius ratio."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import xarray as xr
from scipy.interpolate import RegularGridInterpolator

from approx.calibration import Fit, fit
from compare.results.calibration import Calibrated, calibrate, target_from
from compare.results.provenance import results_digest
from compare.scenes.load import load_scene, scene_from_table
from compare.scenes.scene import Scene
from femic.means import DEFAULT, Means
from geometries.errors import WrongInput

Node = tuple[float, float]  # flank inclination [deg], radius of the upper arc over that of the lower

MOST_GEOMETRIES = 40  # of a map, with those left out
STEEPEST = 85.0  # degrees
SMOOTH = 4  # number of nodes per axis from which on interpolation is cubic
TRIED = ("map", "fit", "Bhat")  # compared on the geometries left out: fit from the map, own fit, no fit


@dataclass(frozen=True)
class Axes:
    """Flank inclinations [deg] and radius ratios of a map, each growing.

    Raises WrongInput if one of them is too short, does not grow or is out of its limits, or if the map has
    more than `MOST_GEOMETRIES`.
    """

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
        if total > MOST_GEOMETRIES:
            raise WrongInput(
                f"flanks, ratios: {total} scenes with those left out; at most {MOST_GEOMETRIES}: give fewer"
            )

    @property
    def nodes(self) -> list[Node]:
        """The geometries whose fits make up the map, with ratios running fastest."""
        return list(product(self.flanks, self.ratios))

    @property
    def left_out(self) -> list[Node]:
        """The geometries on which the map is tried: the middle of every cell."""
        cells = product(pairwise(self.flanks), pairwise(self.ratios))
        return [((a + b) / 2, (c + d) / 2) for (a, b), (c, d) in cells]


def compute_map(base: str, axes: Axes, means: Means = DEFAULT) -> xr.Dataset:
    """Compute the fits at the nodes, and the residuals of fits from the map on the geometries left out.

    `base` is a scene: its materials, patch, rolling radius and calibration are those of all nodes, its
    reference length is the radius of the lower arc. Raises as
    `compare.results.calibration.calibrate` does.
    """
    scene = load_scene(base)

    def calibrated_at(node: Node) -> Calibrated:
        means.watch.on_stage(f"  flanks {node[0]:g} degrees, radius ratio {node[1]:g}")
        return calibrate(scene_at(scene.text, scene.reference_length, node), means)

    dataset = _node_dataset(scene, axes, [calibrated_at(node) for node in axes.nodes])
    residuals = [_residuals(dataset, node, calibrated_at(node)) for node in axes.left_out]
    meaning = {"units": "1", "meaning": "deviation of B-hat-prime from C, share of max |C| of the points"}
    return dataset.assign(
        residual=(("left_out", "by", "measure"), np.array(residuals), meaning)
    ).assign_coords(
        left_out_flank=("left_out", [node[0] for node in axes.left_out], {"units": "deg"}),
        left_out_ratio=("left_out", [node[1] for node in axes.left_out]),
        by=list(TRIED),
        measure=["rms", "worst"],
    )


def scene_at(text: str, radius: float, node: Node) -> Scene:
    """The scene of a text with the arcs of a node; `radius` [mm] is that of the lower arc.

    It compares and calibrates both bodies together.
    """
    table, (flank, ratio) = tomllib.loads(text), node
    for body, factor in (("lower", 1.0), ("upper", ratio)):
        arc = {"kind": "arc", "radius": radius * factor, "flank_inclination_deg": flank}
        table[body] = table[body] | {"contour": arc}
    table["engine"] = table.get("engine", {}) | {"check": False}
    table["calibration"] = table.get("calibration", {}) | {"bodies": ["combined"]}
    return scene_from_table(table | {"bodies": ["combined"]}, f"flank {flank:g}, ratio {ratio:g}")


def _node_dataset(scene: Scene, axes: Axes, calibrations: Sequence[Calibrated]) -> xr.Dataset:
    """C at the points of the calibration [-], the fits and their residuals, at all nodes."""
    fits = [calibrated.fits["combined"] for calibrated in calibrations]
    dims, shape = ("flank", "ratio"), (len(axes.flanks), len(axes.ratios), -1)
    c = [_unit(calibrated.scene) * calibrated.targets["combined"].ics for calibrated in calibrations]
    return xr.Dataset(
        {
            "c": ((*dims, "component", "point"), np.reshape(c, (*shape[:2], *c[0].shape)), {"units": "1"}),
            "value": (
                (*dims, "parameter"),
                np.reshape([[p.value for p in node_fit.parameters] for node_fit in fits], shape),
            ),
            "rms": ((*dims, "component"), np.reshape([node_fit.rms for node_fit in fits], shape)),
            "worst": ((*dims, "component"), np.reshape([node_fit.worst for node_fit in fits], shape)),
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
            "code": results_digest(__name__),
        },
    )


def _unit(scene: Scene) -> float:
    """The factor that makes ICs per unit pressure dimensionless [MPa/mm]."""
    return scene.reference_E * scene.reference_length / scene.patch.area


def fit_at(dataset: xr.Dataset, flank: float, ratio: float) -> Fit:
    """The fit of B-hat-prime to C interpolated between the nodes, for the patch and materials of the map.

    The interpolation is cubic in the inclination and the inverse ratio, and linear in both if one has fewer
    than four nodes. r_inf is in mm for the map's `reference_length`; for other sizes with the same
    proportions it is in proportion. Raises WrongInput outside the map.
    """
    flanks, ratios = dataset.flank.values, dataset.ratio.values
    if not (flanks[0] <= flank <= flanks[-1] and ratios[0] <= ratio <= ratios[-1]):
        raise WrongInput(
            f"flank = {flank:g} degrees, ratio = {ratio:g}: outside the map, {flanks[0]:g} ... "
            f"{flanks[-1]:g} degrees and {ratios[0]:g} ... {ratios[-1]:g}"
        )
    scene = scene_at(dataset.attrs["scene"], dataset.attrs["reference_length"], (flank, ratio))
    method = "cubic" if min(len(flanks), len(ratios)) >= SMOOTH else "linear"
    interpolated = RegularGridInterpolator((flanks, -1 / ratios), dataset.c.values, method=method)
    ics = interpolated((flank, -1 / ratio)) / _unit(scene)
    return fit(target_from(scene, ics), scene.calibration.properties)


def _residuals(dataset: xr.Dataset, node: Node, calibrated: Calibrated) -> list[list[float]]:
    """Residuals (rms, worst) [-] on one geometry: of the fit from the map, of its own fit, and of B-hat."""
    target, own_fit = calibrated.targets["combined"], calibrated.fits["combined"]
    approximations = (
        target.of(fit_at(dataset, *node).effective),
        target.of(own_fit.effective),
        target.by("Bhat"),
    )
    deviations = [np.abs(ics - target.ics) / target.scales for ics in approximations]
    return [[float(np.sqrt(np.mean(deviation**2))), float(np.max(deviation))] for deviation in deviations]
