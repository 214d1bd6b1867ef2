"""Deviations of contacts with ICs from finite elements, and estimates of the latter."""

import xarray as xr

from compare.finite_elements.dataset import FE


def deviations(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return ratios of a number with ICs to the same by finite elements, minus 1, by case and ICs."""
    return _with_ics(dataset, name) / _with_fe(dataset, name) - 1


def relative_estimates(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the estimated error of a number by finite elements as a share of it, by case."""
    return abs(estimates(dataset, name) / _with_fe(dataset, name))


def differences(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return numbers with ICs minus finite elements, in their unit, by case and ICs.

    They serve for numbers that vanish by symmetry.
    """
    return _with_ics(dataset, name) - _with_fe(dataset, name)


def estimates(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the estimated error of a number by finite elements, in its unit, by case."""
    return _with_fe(dataset, f"estimate_{name}")


def _with_ics(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].drop_attrs().drop_sel(ics=FE)


def _with_fe(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].drop_attrs().sel(ics=FE, drop=True)
