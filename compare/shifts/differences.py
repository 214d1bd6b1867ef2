"""Differences of results to those with the best ICs of each contact: C, or else B-hat."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from compare.report.looks import symbol_of
from femic.contact.pairs.planar import PLANAR

ORDER = ("C", "Bhat")  # the best first; then the last of the others
LIMITS = (0.01, 0.05, 0.10)


@dataclass(frozen=True)
class Quantity:
    """A result that is compared: its name in the dataset, symbol, and unit, of which it has `per_unit`.

    `of_friction`: whether its differences are shares of friction times load; else of itself.
    """

    name: str
    symbol: str
    unit: str
    form: str
    per_unit: float = 1.0
    of_friction: bool = False

    @property
    def label(self) -> str:
        """Symbol and unit."""
        return f"{self.symbol} [{self.unit}]"


P_MAX = Quantity("p_max", "p_max", "MPa", ".0f")
F_X, F_Y = (Quantity(name, name, "kN", ".2f", 1e-3, of_friction=True) for name in ("F_x", "F_y"))
WORK = Quantity("work", "work of friction", "J/m", ".1f")
OF_ROLLING = (F_X, F_Y, WORK)


def compared_quantities(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Return the quantities by which ICs are compared."""
    return (P_MAX, *OF_ROLLING) if "F_x" in dataset else (P_MAX,)


def ranked(dataset: xr.Dataset) -> list[str]:
    """Return the ICs from the best to the least good as a reference; planar contact is never one."""
    names = [str(name) for name in dataset.ics.values if name != PLANAR]
    best = [name for name in ORDER if name in names]
    return [*best, *(name for name in reversed(names) if name not in best)]


def reference_values(dataset: xr.Dataset, quantity: str) -> xr.DataArray:
    """Return a quantity with the best ICs of each contact, over shift and side."""
    first, *others = ranked(dataset)
    values = dataset[quantity].sel(ics=first, drop=True)
    for name in others:
        values = values.fillna(dataset[quantity].sel(ics=name, drop=True))
    return values


def reference_names(dataset: xr.Dataset, quantity: str = "p_max") -> xr.DataArray:
    """Return the names of the best ICs of each contact, empty where there is none."""
    result = xr.full_like(dataset[quantity].isel(ics=0, drop=True), "", dtype=object)
    for name in reversed(ranked(dataset)):
        result = result.where(np.isnan(dataset[quantity].sel(ics=name, drop=True)), name)
    return result


def difference(dataset: xr.Dataset, ics: str, quantity: Quantity = P_MAX) -> xr.DataArray:
    """Return a quantity with some ICs less that with the best of each contact, as a share.

    Over shift and side; NaN where these ICs are the best themselves.
    """
    own = dataset[quantity.name].sel(ics=ics, drop=True)
    best = reference_values(dataset, quantity.name)
    scale = dataset.attrs["friction"] * dataset.attrs["load"] if quantity.of_friction else best
    return ((own - best) / scale).where(reference_names(dataset, quantity.name) != ics)


def compared(dataset: xr.Dataset) -> list[str]:
    """Return the ICs that are compared with better ones: half-spaces first, planar contact last."""
    names = [*reversed(ranked(dataset)), *(PLANAR for name in dataset.ics.values if name == PLANAR)]
    return [name for name in names if np.isfinite(difference(dataset, name)).any()]


def reference_label(dataset: xr.Dataset, quantity: str = "p_max") -> str:
    """Return the best ICs in words: all that are a reference anywhere."""
    names = reference_names(dataset, quantity).values
    used = [name for name in ranked(dataset) if np.any(names == name)]
    return " or ".join(symbol_of(name) for name in used)
