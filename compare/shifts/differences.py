"""Differences of the largest pressures to those of the best ICs of each contact: C, or else B-hat."""

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of

ORDER = ("C", "Bhat")  # the best first; then the last of the others
LIMITS = (0.01, 0.05, 0.10)


def ranked(dataset: xr.Dataset) -> list[str]:
    """Return the ICs from the best to the least good as a reference."""
    names = [str(name) for name in dataset.ics.values]
    best = [name for name in ORDER if name in names]
    return [*best, *(name for name in reversed(names) if name not in best)]


def reference_values(dataset: xr.Dataset, quantity: str) -> xr.DataArray:
    """Return a quantity with the best ICs of each contact, over shift and side."""
    first, *others = ranked(dataset)
    values = dataset[quantity].sel(ics=first, drop=True)
    for name in others:
        values = values.fillna(dataset[quantity].sel(ics=name, drop=True))
    return values


def reference_names(dataset: xr.Dataset) -> xr.DataArray:
    """Return the names of the best ICs of each contact, empty where there is none."""
    result = xr.full_like(dataset.p_max.isel(ics=0, drop=True), "", dtype=object)
    for name in reversed(ranked(dataset)):
        result = result.where(np.isnan(dataset.p_max.sel(ics=name, drop=True)), name)
    return result


def difference(dataset: xr.Dataset, ics: str) -> xr.DataArray:
    """Return p_max of some ICs less that of the best of each contact, as a share of it.

    Over shift and side; NaN where these ICs are the best themselves.
    """
    own, best = dataset.p_max.sel(ics=ics, drop=True), reference_values(dataset, "p_max")
    return ((own - best) / best).where(reference_names(dataset) != ics)


def reference_label(dataset: xr.Dataset) -> str:
    """Return the best ICs in words: all that are a reference anywhere."""
    names = reference_names(dataset).values
    used = [name for name in ranked(dataset) if np.any(names == name)]
    return " or ".join(symbol_of(name) for name in used)
