"""Fits of B-hat-prime between the scenes of a campaign that kept "calibration".

C at the points of the calibration is interpolated, and then fitted: parameters that the data hardly determine
jump from scene to scene, C does not.
"""

from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from approx.calibration import Fit, fit
from approx.target import Target
from compare.calibration.compute import target_from, unit_of
from femic.campaigns.maps.interpolation import Stencil, interpolate
from femic.campaigns.maps.scene_grid import SceneGrid, open_grid
from geometries.arrays import Array

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
    rows = [_deviations(fits, along, node, body) for along, node in cases]
    values = np.array([_point(fits, node) for _, node in cases])
    share = {"units": "1", "long_name": "deviation from C, share of max |C| of the points"}
    return xr.Dataset(
        {
            name: (("node", "by"), np.array(rows)[:, :, number], share)
            for number, name in enumerate(("rms", "worst"))
        }
        | {axis.name: ("node", values[:, k]) for k, axis in enumerate(fits.axes)}
        | {"along": ("node", [fits.axes[along].name for along, _ in cases])},
        coords={"by": list(BY)},
    )


def _deviations(fits: SceneGrid, along: int, node: tuple[int, ...], body: str) -> list[tuple[float, float]]:
    point = _point(fits, node)
    itself = [axis.single(k) for axis, k in zip(fits.axes, node, strict=True)]
    others = [*itself[:along], fits.axes[along].without(node[along]), *itself[along + 1 :]]
    properties = fits.scene(point).calibration.properties
    target, predicted = (_target(fits, point, stencils, body) for stencils in (itself, others))
    approximations = [
        target.bhat_prime(fit(predicted, properties).effective),
        target.bhat_prime(fit(target, properties).effective),
        target.approximate("Bhat"),
    ]
    return [_rms_and_worst(target, ics) for ics in approximations]


def _point(fits: SceneGrid, node: Sequence[int]) -> list[float]:
    """Return the values of the axes at a node."""
    return [axis.values[k] for axis, k in zip(fits.axes, node, strict=True)]


def _rms_and_worst(target: Target, ics: Array) -> tuple[float, float]:
    deviation = np.abs(ics - target.ics) / target.scales
    return float(np.sqrt(np.mean(deviation**2))), float(np.max(deviation))


def _target(fits: SceneGrid, point: Sequence[float], stencils: list[Stencil], body: str) -> Target:
    """Return C of stencils as the target of a fit at a point."""
    scene = fits.scene(point)
    place = list(fits.dataset.fitted_body.values).index(body)
    values = interpolate(fits.at_nodes("fit_c", stencils), stencils)[place]
    return target_from(scene, values / unit_of(scene), body)
