"""Compression with friction with some ICs as labelled arrays."""

import xarray as xr

from compare.friction.dataset import maps, tables
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_COMPRESSION
from femic.contact.pairs.solved_compression import SolvedCompression


def labelled(pair: PairWithFriction, solved: SolvedCompression) -> xr.Dataset:
    """Numbers by load, each with `estimate_NAME`, and maps at the last load."""
    rows = {"": [step.numbers for step in solved.steps], "estimate_": solved.errors}
    variables = tables(OF_COMPRESSION, "load", rows)
    dataset = xr.Dataset(variables, coords={"load": ("load", list(pair.loads), {"units": "N"})})
    return dataset.merge(maps(pair, solved.last)).assign(seconds=((), solved.seconds, {"units": "s"}))
