"""Creep-force curves of a wheel with several ICs as labelled arrays."""

import numpy as np
import xarray as xr

from compare.contact.dataset import reference_of, variables
from compare.friction.dataset import maps
from femic.contact.pairs.displaced import OF_DISPLACED
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_CURVE, OF_ROLLING
from femic.contact.pairs.solved_curve import SolvedCurve
from femic.scenes.scene import Scene

DISPLACED = "displaced_"  # before the names of numbers with the distance of the displaced wheel
UNKNOWN = dict.fromkeys(OF_ROLLING, np.nan)  # numbers where there is no contact
DISTANCES = {  # of curves
    "rms": "root mean square distance to the reference's curve over friction times load",
    "largest": "largest distance to the reference's curve over friction times load",
}


def labelled(pair: PairWithFriction, solved: SolvedCurve) -> xr.Dataset:
    """Return numbers by creepage `xi`, each with `estimate_NAME`, and maps at equal force.

    `simplified` marks contacts with the less accurate solution only. `displaced_NAME` is a number at
    the creepage nearest 0 with the distance of the displaced wheel, which is linearised otherwise.
    """
    xis, curve = pair.specification.longitudinal, solved.curve
    points = [curve.points[xi].numbers if xi in curve.points else UNKNOWN for xi in xis]
    numbers = {
        **variables(OF_ROLLING, "xi", {"": points, "estimate_": solved.point_errors}),
        **variables(OF_CURVE, (), {"": curve.free.numbers, "estimate_": solved.curve_errors}),
        **variables(OF_DISPLACED, (), {DISPLACED: solved.displaced}),
        "simplified": ("xi", [xi in curve.contacts and curve.contacts[xi].simplified for xi in xis]),
    }
    return xr.Dataset(numbers, coords={"xi": list(xis)}).merge(maps(pair, curve.equal.contact))


def with_distances(scene: Scene, dataset: xr.Dataset) -> xr.Dataset:
    """Return the arrays of all ICs with distances of their curves to the reference's: `rms` and `largest`."""
    friction = scene.contact.friction
    dataset.attrs["load"] = scene.contact.loads[0]
    dataset.attrs["equal_force"] = friction.equal_force if friction else 0.0
    return dataset.assign(_distances(dataset))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """Return the longitudinal force, or what goes with it, over friction times load."""
    return dataset[name].drop_attrs() / (dataset.friction * dataset.attrs["load"])


def _distances(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return distances of curves to the reference's over friction times load, and their estimates.

    By the triangle inequality, the error of a distance is at most the same distance of the sum of the
    estimates of both curves; for the reference itself it is 0.
    """
    force, estimate = scaled_force(dataset), scaled_force(dataset, "estimate_F_x")
    reference = reference_of(dataset)
    away = abs(force - force.sel(ics=reference))
    both = (estimate + estimate.sel(ics=reference)).where(dataset.ics != reference, 0.0)
    distances = {}
    for prefix, values in (("", away), ("estimate_", both.where(away.notnull()))):
        distances[f"{prefix}rms"] = (values**2).mean("xi") ** 0.5
        distances[f"{prefix}largest"] = values.max("xi")
    return {
        name: distance.assign_attrs(units="1", long_name=DISTANCES[name.removeprefix("estimate_")])
        for name, distance in distances.items()
    }
