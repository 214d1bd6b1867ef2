"""Transient rolling with some ICs as labelled arrays."""

import numpy as np
import xarray as xr

from compare.contact.dataset import variables
from compare.friction.dataset import SIMPLIFIED, maps
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_ROLLING
from femic.contact.pairs.solved_transient import SolvedTransient
from femic.scenes.scene import Scene

STEADY = "steady_"  # before the names of numbers in steady rolling
CREEPAGES = ("creepage", "lateral", "spin")


def labelled(pair: PairWithFriction, solved: SolvedTransient) -> xr.Dataset:
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
