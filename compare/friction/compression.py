"""Compression with friction with some ICs as labelled arrays."""

import xarray as xr

from compare.contact.dataset import variables
from compare.friction.dataset import maps
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_COMPRESSION
from femic.contact.pairs.solved_compression import SolvedCompression


def labelled(pair: PairWithFriction, solved: SolvedCompression) -> xr.Dataset:
    """Return numbers by load, each with `estimate_NAME`, and maps at the last load."""
    tables = {"": [step.numbers for step in solved.steps], "estimate_": solved.errors}
    coords = {"load": ("load", list(pair.loads), {"units": "N"})}
    return xr.Dataset(variables(OF_COMPRESSION, "load", tables), coords).merge(maps(pair, solved.last))
