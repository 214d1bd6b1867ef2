"""Estimates of differences between the contacts of several ICs, as those of distances to C.

On the same elements much of the error of both contacts is the same, and is no error of their difference. So
a difference is evaluated again on elements twice as large, with numbers plus their floors, and with changed
ICs: its error is estimated as

    F |d_h - d_2h| + |d| / 20 + sum over ICs of |d(number + floor) - d|
    + sum over ICs of max over +- of |d(ICs +- their estimated errors) - d|,

with F = 1.25 and the first order of `femic.contact.estimates`. Two grids may agree by luck: elements know a
difference, like any number, to a share of itself; and ICs whose edges and borders are not the same cut
elements in other places (`compare.friction.dataset`).
"""

from collections.abc import Callable

import xarray as xr

from compare.contact.dataset import ics_of
from compare.friction.dataset import CHANGE, FLOOR, LARGER
from femic.contact.estimates import SAFETY

MISSED = 0.05  # share of a difference that elements may miss

Difference = Callable[[xr.Dataset], xr.DataArray]
Norm = Callable[[xr.DataArray], xr.DataArray]


def on_larger_elements(dataset: xr.Dataset) -> xr.Dataset:
    """Return numbers and tractions on elements twice as large, by the same names; NaN where missing."""
    names = _varied(dataset, LARGER)
    places = [name for name in ("x", "s") if LARGER + name in dataset.coords]
    return dataset[[LARGER + name for name in names]].rename(
        {LARGER + name: name for name in (*names, *places)}
    )


def with_floors(dataset: xr.Dataset, ics: str) -> xr.Dataset:
    """Return the contacts with the numbers of some ICs plus their floors."""
    at = dataset.ics == ics
    names = _varied(dataset, FLOOR)
    return dataset.assign({name: dataset[name] + dataset[FLOOR + name].where(at, 0.0) for name in names})


def with_changed_ics(dataset: xr.Dataset, ics: str, sign: float) -> xr.Dataset:
    """Return the contacts with some ICs plus (sign 1) or minus (-1) their estimated errors."""
    at = dataset.ics == ics
    changed = {
        name: dataset[name] + sign * dataset[CHANGE + name].where(at, 0.0)
        for name in _varied(dataset, CHANGE)
    }
    return dataset.assign(changed)


def estimate_of_difference(dataset: xr.Dataset, difference: Difference, norm: Norm = abs) -> xr.DataArray:
    """Return the estimated error of a difference between contacts; NaN where it is not known.

    `difference` takes it from contacts; its sign is of use, where it has one. `norm` makes a size of several
    differences: by the triangle inequality the sizes are as far apart as the size of what changes, at most.
    """
    given = difference(dataset)
    estimate = SAFETY * norm(difference(on_larger_elements(dataset)) - given) + MISSED * norm(given)
    if _varied(dataset, FLOOR):
        for ics in ics_of(dataset):
            estimate = estimate + norm(difference(with_floors(dataset, ics)) - given)
    for ics in _with_known_errors(dataset):
        ways = [norm(difference(with_changed_ics(dataset, ics, sign)) - given) for sign in (1.0, -1.0)]
        estimate = estimate + xr.concat(ways, "sign").max("sign", skipna=False)
    return estimate


def _varied(dataset: xr.Dataset, prefix: str) -> list[str]:
    """Return the names of what a prefix gives a variation of."""
    return [str(name).removeprefix(prefix) for name in dataset.data_vars if str(name).startswith(prefix)]


def _with_known_errors(dataset: xr.Dataset) -> list[str]:
    """Return the ICs by which anything changes; those of unknown changes, NaN, are among them."""
    changes = [dataset[CHANGE + name] for name in _varied(dataset, CHANGE)]
    return [name for name in ics_of(dataset) if any(bool((one.sel(ics=name) != 0).any()) for one in changes)]
