"""Checksums of the dataset of a campaign, which reveal damage.

The checksum of a scene is the sum of 64-bit numbers of its variables, message, seconds and digest. Missing
variables (all NaN) have the number 0, so that it does not matter which variables other scenes have.
"""

import json
from collections.abc import Iterable, Mapping
from hashlib import blake2b, sha256
from typing import Any

import numpy as np
import xarray as xr

from geometries.arrays import Array

CHECKSUM = "checksum"  # the variable of checksums
LAYOUT = "layout"  # the attribute with the digest of everything that is not of a scene
SCENE_VARIABLES = ("failure", "seconds", "digest", CHECKSUM)  # variables over the swept dims only
SIZE = 8  # bytes

Checksums = np.ndarray[Any, np.dtype[np.uint64]]


def value_checksums(name: str, values: np.ndarray[Any, Any], dims: int = 0) -> Checksums:
    """Return numbers for the values of a variable, over its first `dims` dims (those of the campaign)."""
    shape = values.shape[:dims]
    rows = np.ascontiguousarray(values).reshape(int(np.prod(shape)), -1)
    missing = np.isnan(rows)
    plain = np.where(missing, np.nan, rows) if np.any(missing) else rows  # all NaN have the same bits
    numbers = np.zeros(len(rows), dtype=np.uint64)
    named = blake2b(f"{name}\0".encode(), digest_size=SIZE)
    for k in np.flatnonzero(~np.all(missing, axis=1)):
        row_digest = named.copy()
        row_digest.update(plain[k])
        numbers[k] = int.from_bytes(row_digest.digest())
    return numbers.reshape(shape)


def outcome_checksums(failures: Iterable[str], seconds: Array, digests: Checksums) -> Checksums:
    """Return numbers for messages, seconds and digests of scenes, (n_scenes,); 0: not computed."""
    outcomes = zip(failures, seconds.tolist(), digests.tolist(), strict=True)
    return np.array(
        [
            0 if not failure and np.isnan(took) else _number(failure, took, digest)
            for failure, took, digest in outcomes
        ],
        dtype=np.uint64,
    )


def layout_of(dataset: xr.Dataset, template: xr.Dataset, attributes: Mapping[str, Any]) -> str:
    """Return the digest of coordinates, attributes, and names, dims and types of variables.

    The variables are those of `template`, with or without the swept dims.
    """
    swept = dataset[CHECKSUM].dims
    coords = {
        str(name): [labels.dims, labels.values.tolist(), labels.attrs]
        for name, labels in dataset.coords.items()
        if name not in SCENE_VARIABLES
    }
    variables = {
        str(name): [[dim for dim in variable.dims if dim not in swept], variable.dtype.str, variable.attrs]
        for name, variable in template.data_vars.items()
        if name not in SCENE_VARIABLES
    }
    others = {name: value for name, value in attributes.items() if name != LAYOUT}
    text = json.dumps([coords, variables, others], sort_keys=True, default=lambda value: value.tolist())
    return sha256(text.encode()).hexdigest()


def _number(*of: object) -> int:
    return int.from_bytes(blake2b(repr(of).encode(), digest_size=SIZE).digest())
