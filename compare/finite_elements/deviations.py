"""How far contacts by ICs are from those by finite elements, and how well these are known."""

import xarray as xr

from compare.finite_elements.dataset import FE


def deviations(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Ratios of a number by ICs to that by finite elements, less 1, by case and ICs."""
    return _by_ics(dataset, name) / _by_fe(dataset, name) - 1


def known(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """The estimated error of a number by finite elements as a share of it, by case."""
    return abs(known_to(dataset, name) / _by_fe(dataset, name))


def differences(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Numbers by ICs less that by finite elements, in their unit, by case and ICs.

    They say how far numbers are apart that vanish where all is symmetric.
    """
    return _by_ics(dataset, name) - _by_fe(dataset, name)


def known_to(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """The estimated error of a number by finite elements, in its unit, by case."""
    return _by_fe(dataset, f"estimate_{name}")


def _by_ics(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].drop_attrs().drop_sel(ics=FE)


def _by_fe(dataset: xr.Dataset, name: str) -> xr.DataArray:
    return dataset[name].drop_attrs().sel(ics=FE, drop=True)
