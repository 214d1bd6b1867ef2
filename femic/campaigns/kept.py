"""What is kept of scenes in the store: parts under a key of their own.

They are not entries of their own, because NetCDF takes fifty times as long for a few small arrays.
"""

import json
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from femic.cache.store import Arrays, Store

FOLDER = "sweep"  # the key of all that is kept of scenes
LAYOUT = "layout"


@dataclass(frozen=True, eq=False)
class Kept:
    """What is kept of a scene by one name: numbers, or the message of why there are none; and the seconds."""

    dataset: xr.Dataset = field(default_factory=xr.Dataset)
    failure: str = ""
    seconds: float = 0.0


def kept_keys(store: Store) -> set[str]:
    """The keys of all that is kept."""
    return set(store.part_names(FOLDER))


def put(store: Store, key: str, kept: Kept) -> None:
    """Keep something under a key."""
    store.put_part(FOLDER, key, _packed(kept))


def get(store: Store, key: str) -> Kept | None:
    """What is kept under a key, None where there is nothing undamaged."""
    arrays = store.part(FOLDER, key)
    return None if arrays is None else _unpacked(arrays)


def _packed(kept: Kept) -> Arrays:
    """Arrays by name, and what they are as text."""
    dataset = kept.dataset
    layout = {
        "failure": kept.failure,
        "seconds": kept.seconds,
        "labels": {str(dim): labels.attrs for dim, labels in dataset.coords.items()},
        "variables": {
            str(name): [list(map(str, variable.dims)), variable.attrs]
            for name, variable in dataset.data_vars.items()
        },
    }
    arrays = {str(name): variable.values for name, variable in dataset.variables.items()}
    return {LAYOUT: np.array(json.dumps(layout)), **arrays}


def _unpacked(arrays: Arrays) -> Kept:
    layout = json.loads(str(arrays[LAYOUT]))
    dataset = xr.Dataset(
        {name: (dims, arrays[name], attrs) for name, (dims, attrs) in layout["variables"].items()},
        {dim: (dim, arrays[dim], attrs) for dim, attrs in layout["labels"].items()},
    )
    return Kept(dataset, layout["failure"], layout["seconds"])
