"""Creep-force curves of a wheel with several ICs as labelled arrays."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from compare.contact.dataset import PREFIXES, reference_of, variables
from compare.friction.dataset import CHANGE, FLOOR, LARGER, SIMPLIFIED, floors, maps, varied_tractions
from compare.friction.differences import estimate_of_difference
from femic.contact.estimates import Numbers
from femic.contact.pairs.creep_force import CreepForceCurve
from femic.contact.pairs.displaced import OF_DISPLACED
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_CURVE, OF_ROLLING
from femic.contact.pairs.solved_curve import SolvedCurve
from femic.scenes.scene import Scene

DISPLACED = "displaced_"  # before the names of numbers with the distance of the displaced wheel
UNKNOWN = dict.fromkeys(OF_ROLLING, np.nan)  # numbers where there is no contact
UNKNOWN_CURVE = dict.fromkeys(OF_CURVE, np.nan)
DISTANCES = {  # of curves
    "rms": "root mean square distance to the reference's curve over friction times load",
    "largest": "largest distance to the reference's curve over friction times load",
}


def labelled(pair: PairWithFriction, solved: SolvedCurve) -> xr.Dataset:
    """Return numbers by creepage `xi`, each with `estimate_NAME`, and maps at equal force.

    `larger_NAME`, `change_NAME` and `floor_NAME` are as in `compare.friction.dataset`.
    `simplified` marks contacts with the less accurate solution only. `displaced_NAME` is a number at
    the creepage nearest 0 with the distance of the displaced wheel, which is linearised otherwise.
    """
    xis, curve, larger = pair.specification.longitudinal, solved.curve, solved.larger
    by_creepage = {
        "": _points(curve, xis),
        "estimate_": solved.point_errors,
        LARGER: _points(larger, xis),
        CHANGE: solved.change.points,
        FLOOR: [floors(curve.points.get(xi), OF_ROLLING) for xi in xis],
    }
    of_curve = {
        "": curve.free.numbers,
        "estimate_": solved.curve_errors,
        LARGER: larger.free.numbers if larger else UNKNOWN_CURVE,
        CHANGE: solved.free_change,
        FLOOR: floors(curve.free, OF_CURVE),
    }
    numbers = {
        **variables(OF_ROLLING, "xi", by_creepage),
        **variables(OF_CURVE, (), of_curve),
        **variables(OF_DISPLACED, (), {DISPLACED: solved.displaced}),
        "simplified": (
            "xi",
            [xi in curve.contacts and curve.contacts[xi].simplified for xi in xis],
            SIMPLIFIED,
        ),
    }
    varied = varied_tractions(pair, larger.equal.contact if larger else None, solved.change)
    creepages = {"units": "1", "long_name": "longitudinal creepage"}
    dataset = xr.Dataset(numbers, coords={"xi": ("xi", list(xis), creepages)})
    return dataset.merge(maps(pair, curve.equal.contact)).merge(varied)


def _points(curve: CreepForceCurve | None, xis: Sequence[float]) -> list[Numbers]:
    """Return the numbers of a curve by creepage; NaN where there is no contact."""
    return [curve.points[xi].numbers if curve and xi in curve.points else UNKNOWN for xi in xis]


def with_distances(scene: Scene, dataset: xr.Dataset) -> xr.Dataset:
    """Return the arrays of all ICs with distances of their curves to the reference's: `rms` and `largest`."""
    friction = scene.contact.friction
    dataset.attrs["load"] = scene.contact.loads[0]
    dataset.attrs["equal_force"] = friction.equal_force if friction else 0.0
    return dataset.assign(_distances(dataset))


def scaled_force(dataset: xr.Dataset, name: str = "F_x") -> xr.DataArray:
    """Return the longitudinal force, or what goes with it, over friction times load."""
    return dataset[name].drop_attrs(deep=False) / (dataset.friction * dataset.attrs["load"])


def _from_reference(dataset: xr.Dataset) -> xr.DataArray:
    """Return differences of curves to the reference's over friction times load, (friction, ics, xi)."""
    force = scaled_force(dataset)
    return force - force.sel(ics=reference_of(dataset))


def _rms(differences: xr.DataArray) -> xr.DataArray:
    return (differences**2).mean("xi") ** 0.5


def _largest(differences: xr.DataArray) -> xr.DataArray:
    return abs(differences).max("xi")


def _distances(dataset: xr.Dataset) -> dict[str, xr.DataArray]:
    """Return distances of curves to the reference's over friction times load, and their estimates.

    Creepages without a contact do not count. Estimates are those of the differences, and 0 for the reference.
    """
    distances, others = {}, dataset.ics != reference_of(dataset)
    for name, norm in (("rms", _rms), ("largest", _largest)):
        estimate = estimate_of_difference(dataset, _from_reference, norm)
        for prefix, distance in (
            ("", norm(_from_reference(dataset))),
            ("estimate_", estimate.where(others, 0.0)),
        ):
            distances[prefix + name] = distance.assign_attrs(
                units="1", long_name=DISTANCES[name] + PREFIXES[prefix]
            )
    return distances
