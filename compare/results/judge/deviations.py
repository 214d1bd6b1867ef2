"""How far contacts by ICs are from those by finite elements, and how well these are known."""

import xarray as xr

from compare.results.judge.dataset import FE


def deviations(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Ratios of a number by ICs to that by finite elements, less 1, by case and ICs."""
    values = dataset[name].drop_attrs()
    return values.drop_sel(ics=FE) / values.sel(ics=FE, drop=True) - 1


def known(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """The estimated error of a number by finite elements as a share of it, by case."""
    of_fe = dataset.sel(ics=FE, drop=True)
    return abs(of_fe[f"estimate_{name}"] / of_fe[name]).drop_attrs()
