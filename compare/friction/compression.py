"""Compression with friction with some ICs as labelled arrays."""

import numpy as np
import xarray as xr

from compare.contact.dataset import variables
from compare.friction.dataset import CHANGE, FLOOR, LARGER, floors, maps, varied_tractions
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_COMPRESSION
from femic.contact.pairs.solved_compression import SolvedCompression

UNKNOWN = dict.fromkeys(OF_COMPRESSION, np.nan)  # numbers where there is no contact


def labelled(pair: PairWithFriction, solved: SolvedCompression) -> xr.Dataset:
    """Return numbers by load, each with `estimate_NAME`, and maps at the last load.

    `larger_NAME`, `change_NAME` and `floor_NAME` are as in `compare.friction.dataset`.
    """
    larger, larger_last = solved.larger or (None, None)
    tables = {
        "": [step.numbers for step in solved.steps],
        "estimate_": solved.errors,
        LARGER: [step.numbers for step in larger] if larger else [UNKNOWN for _ in pair.loads],
        CHANGE: solved.change.points,
        FLOOR: [floors(step, OF_COMPRESSION) for step in solved.steps],
    }
    coords = {"load": ("load", list(pair.loads), {"units": "N", "long_name": "prescribed load"})}
    numbers = xr.Dataset(variables(OF_COMPRESSION, "load", tables), coords)
    return numbers.merge(maps(pair, solved.last)).merge(varied_tractions(pair, larger_last, solved.change))
