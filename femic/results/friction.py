"""Contact with friction of a scene with several ICs, as `femic.contact` solves it: the dataset `contact.nc`.

Numbers are by load in compression, by distance in transient rolling, and by creepage in steady rolling.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from femic.contact.estimates import Numbers
from femic.contact.pairs.creep_force import OF_DISPLACED, CreepForceCurve
from femic.contact.pairs.ics import NONE_GIVEN, GivenICs
from femic.contact.pairs.pair_with_friction import PairWithFriction, solve_with_friction
from femic.contact.pairs.quantities import OF_COMPRESSION, OF_CURVE, OF_ROLLING
from femic.contact.pairs.solved_compression import SolvedCompression
from femic.contact.pairs.solved_curve import SolvedCurve
from femic.contact.pairs.solved_transient import SolvedTransient
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import PREFIXES, provenance, reference_of, require_solvable, variables
from femic.results.friction_dataset import (
    CHANGE,
    FLOOR,
    LARGER,
    SIMPLIFIED,
    by_friction_and_ics,
    estimate_of_difference,
    floors,
    maps,
    varied_tractions,
)
from femic.results.matrices import discounted
from femic.scenes.errors import BadScene
from femic.scenes.scene import Scene

# --- compression ----------------------------------------------------------------------------------------


UNKNOWN_COMPRESSION = dict.fromkeys(OF_COMPRESSION, np.nan)  # numbers where there is no contact


def compression_dataset(pair: PairWithFriction, solved: SolvedCompression) -> xr.Dataset:
    """Return numbers by load, each with `estimate_NAME`, and maps at the last load.

    `larger_NAME`, `change_NAME` and `floor_NAME` are as in `femic.results.friction_dataset`.
    """
    larger, larger_last = solved.larger or (None, None)
    tables = {
        "": [step.numbers for step in solved.steps],
        "estimate_": solved.errors,
        LARGER: [step.numbers for step in larger] if larger else [UNKNOWN_COMPRESSION for _ in pair.loads],
        CHANGE: solved.change.points,
        FLOOR: [floors(step, OF_COMPRESSION) for step in solved.steps],
    }
    coords = {"load": ("load", list(pair.loads), {"units": "N", "long_name": "prescribed load"})}
    numbers = xr.Dataset(variables(OF_COMPRESSION, "load", tables), coords)
    return numbers.merge(maps(pair, solved.last)).merge(varied_tractions(pair, larger_last, solved.change))


# --- transient rolling ----------------------------------------------------------------------------------


STEADY = "steady_"  # before the names of numbers in steady rolling
CREEPAGES = ("creepage", "lateral", "spin")


def transient_dataset(pair: PairWithFriction, solved: SolvedTransient) -> xr.Dataset:
    """Return numbers by rolled `distance`, each with `estimate_NAME`, and maps at the last distance.

    `steady_NAME` is the number in steady rolling at the same creepages, with `estimate_steady_NAME`;
    `simplified` marks steps that were solved in the less accurate form only.
    """
    path = solved.path
    steady = path.steady.numbers if path.steady else dict.fromkeys(OF_ROLLING, np.nan)
    by_distance = {"": [step.numbers for step in path.steps], "estimate_": solved.errors}
    numbers = {
        **variables(OF_ROLLING, "distance", by_distance),
        **variables(OF_ROLLING, (), {STEADY: steady, f"estimate_{STEADY}": solved.steady_errors}),
        "simplified": ("distance", list(path.simplified), SIMPLIFIED),
    }
    rolled = {"units": "mm", "long_name": "rolled distance"}
    dataset = xr.Dataset(numbers, coords={"distance": ("distance", path.distances, rolled)})
    return dataset.merge(maps(pair, path.last))


def with_creepages(scene: Scene, dataset: xr.Dataset) -> xr.Dataset:
    """Return the arrays of all ICs with load [N] and creepages as attributes."""
    creepages = {name: float(getattr(scene.contact.friction, name)) for name in CREEPAGES}
    return dataset.assign_attrs(load=scene.contact.loads[0], **creepages)


# --- steady rolling: creep-force curves -----------------------------------------------------------------


DISPLACED = "displaced_"  # before the names of numbers with the distance of the displaced wheel
UNKNOWN = dict.fromkeys(OF_ROLLING, np.nan)  # numbers where there is no contact
UNKNOWN_CURVE = dict.fromkeys(OF_CURVE, np.nan)
DISTANCES = {  # of curves
    "rms": "root mean square distance to the reference's curve over friction times load",
    "largest": "largest distance to the reference's curve over friction times load",
}


def creep_force_dataset(pair: PairWithFriction, solved: SolvedCurve) -> xr.Dataset:
    """Return numbers by creepage `xi`, each with `estimate_NAME`, and maps at equal force.

    `larger_NAME`, `change_NAME` and `floor_NAME` are as in `femic.results.friction_dataset`.
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


# --- all coefficients of friction and all ICs -----------------------------------------------------------


@dataclass(frozen=True)
class Labels:
    """How the solutions of a motion become labelled arrays: of each friction and ICs, and of all together."""

    title: str
    labelled: Callable[[PairWithFriction, Any], xr.Dataset]
    of_all: Callable[[Scene, xr.Dataset], xr.Dataset] = lambda _, dataset: dataset


LABELS: dict[str, Labels] = {
    "rolling": Labels("Rolling with friction", creep_force_dataset, with_distances),
    "transient": Labels("Transient rolling with friction", transient_dataset, with_creepages),
    "compression": Labels("Compression with friction", compression_dataset),
}


def _labels_of(scene: Scene) -> Labels:
    """Return the labels of a scene's motion; raises BadScene where none are registered."""
    motion = scene.contact.motion
    if motion not in LABELS:
        raise BadScene(
            f"{scene.name}: contact.motion = {motion!r}: its solutions have no labels: register some in "
            f"{__name__}.LABELS, or use one of {', '.join(LABELS)}"
        )
    return LABELS[motion]


def compute_with_friction(
    scene: Scene, options: RunOptions = DEFAULT, given: Mapping[str, GivenICs] = NONE_GIVEN
) -> xr.Dataset:
    """Return numbers by friction, ICs and the dimension of the motion, each with `estimate_NAME`, and maps.

    `given` are ICs of the caller by name. Raises BadScene for what cannot be solved, and Failure as
    `femic.contact`.
    """
    require_solvable(scene, given)
    start, labels = perf_counter(), _labels_of(scene)
    solve = partial(by_friction_and_ics, labelled=labels.labelled)
    joined = solve_with_friction(scene.contact_problem, solve, options, given)
    attributes = {
        "title": f"{labels.title}: {scene.title}",
        "meaning": "tractions on the upper body along x, s, n of the lower surface; slip over that surface",
        "discounted": discounted(scene),
        **provenance(scene, perf_counter() - start),
    }
    return labels.of_all(scene, joined.assign_attrs(attributes))
