"""Outcomes of scenes in the store, as parts under a key of their own.

They are not entries of their own, because NetCDF takes fifty times as long for a few small arrays.
"""

import json
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from femic.cache.store import Store

FOLDER = "sweep"  # the key of all outcomes
LAYOUT = "layout"


@dataclass(frozen=True, eq=False)
class SceneOutcome:
    """Results of a scene, or the message of its failure, and the seconds of the computation."""

    dataset: xr.Dataset = field(default_factory=xr.Dataset)
    failure: str = ""
    seconds: float = 0.0


def keys_in(store: Store) -> set[str]:
    """Return the keys of all outcomes in a store."""
    return set(store.part_names(FOLDER))


def put(store: Store, key: str, outcome: SceneOutcome) -> None:
    """Store an outcome under a key."""
    dataset = outcome.dataset
    layout = {
        "failure": outcome.failure,
        "seconds": outcome.seconds,
        "labels": {str(dim): labels.attrs for dim, labels in dataset.coords.items()},
        "variables": {
            str(name): [list(map(str, variable.dims)), variable.attrs]
            for name, variable in dataset.data_vars.items()
        },
    }
    arrays = {str(name): variable.values for name, variable in dataset.variables.items()}
    store.put_part(FOLDER, key, {LAYOUT: np.array(json.dumps(layout)), **arrays})


def get(store: Store, key: str) -> SceneOutcome | None:
    """Return the outcome under a key, None where there is no undamaged one."""
    arrays = store.part(FOLDER, key)
    if arrays is None:
        return None
    layout = json.loads(str(arrays[LAYOUT]))
    dataset = xr.Dataset(
        {name: (dims, arrays[name], attrs) for name, (dims, attrs) in layout["variables"].items()},
        {dim: (dim, arrays[dim], attrs) for dim, attrs in layout["labels"].items()},
    )
    return SceneOutcome(dataset, layout["failure"], layout["seconds"])
