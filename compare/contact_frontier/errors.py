"""Errors of the numbers of contacts against a reference, each over its scale: `femic.scenes.wants`.

An error is the largest over the creepages or loads of a case. No error is known better than the reference
is: with the reference's estimate it is at most its bound.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from compare.contact_frontier.scales import ESTIMATE, scale_of
from femic.scenes.wants import Want

DIMENSIONS = ("way", "number", "case")


def error_variables(
    solutions: Mapping[str, xr.Dataset], wants: Sequence[Want], reference: str
) -> dict[str, xr.DataArray]:
    """Return errors [-] over way, number and case of solutions by the names of ways.

    `error`: the largest deviation from the reference, of the reference itself its estimate; `bound`: with the
    reference's estimate added, where the sum is largest; `estimate`: a way's own estimate. Each is NaN where
    a way has no solution, or a case has no number that is known as a share. `judged` and `points` (number,
    case): how many of the case's numbers are known so, and how many there are.
    """
    names = sorted({prefix + want.number for want in wants for prefix in ("", ESTIMATE)})
    ways = xr.DataArray(list(solutions), dims="way", name="way")
    stacked = xr.concat([solution[names] for solution in solutions.values()], ways)
    parts = [_of_want(stacked, solutions[reference], want, reference) for want in wants]
    numbers = xr.DataArray([want.name for want in wants], dims="number", name="number")
    joined = {name: xr.concat([part[name] for part in parts], numbers) for name in parts[0]}
    return {
        name: values.transpose(*(dimension for dimension in DIMENSIONS if dimension in values.dims))
        for name, values in joined.items()
    }


def _of_want(
    stacked: xr.Dataset, of_reference: xr.Dataset, want: Want, reference: str
) -> dict[str, xr.DataArray]:
    """Return the variables of a number; `stacked` has the numbers of all ways."""
    number, estimate = want.number, ESTIMATE + want.number
    scale, others = scale_of(want, of_reference), stacked.way != reference
    own = of_reference[estimate] / scale
    judged = own.notnull() & (own < np.inf)
    away = abs(stacked[number] - of_reference[number]) / scale
    return {
        "error": _largest(away.where(others, own), judged),
        "bound": _largest((away + own).where(others, own), judged),
        "estimate": _largest(stacked[estimate] / scale, judged),
        "judged": _over_points(judged.astype(int), "sum"),
        "points": _over_points(of_reference[number].notnull().astype(int), "sum"),
    }


def _largest(shares: xr.DataArray, judged: xr.DataArray) -> xr.DataArray:
    """Return the largest share over the points that are judged; NaN without one, or where one is missing."""
    missing = _over_points(judged & shares.isnull(), "any")
    return _over_points(shares.where(judged), "max").where(~missing)


def _over_points(values: xr.DataArray, how: str) -> xr.DataArray:
    return getattr(values, how)("point") if "point" in values.dims else values


def worst(dataset: xr.Dataset, names: Sequence[str], case: str | None = None) -> xr.Dataset:
    """Return the errors of the ways in the worst of some numbers, and over all cases unless one is named.

    Variables over `way`: `error`, at least the reference's estimate; `bound`, with it; `floor`, this
    estimate; `number` and `case`, where the bound is largest; `seconds`. NaN where a way has no solution, or
    where no error is known as a share.
    """
    cases = list(dataset.case.values) if case is None else [case]
    chosen = dataset.sel(number=list(names), case=cases)
    judged = np.argwhere(chosen.judged.transpose("number", "case").values > 0)
    places = judged if len(judged) else np.zeros((1, 2), dtype=int)
    bounds, errors = (chosen[name].transpose(*DIMENSIONS).values[:, *places.T] for name in ("bound", "error"))
    missing, rows = np.isnan(bounds).any(axis=1), np.arange(len(bounds))
    where = np.argmax(np.where(np.isnan(bounds), np.inf, bounds), axis=1)
    own = bounds[list(dataset.way.values).index(dataset.attrs["best"]), where]
    number, at_case = places[where].T
    unknown = missing | (len(judged) == 0)
    shares = {"error": np.maximum(errors[rows, where], own), "bound": bounds[rows, where], "floor": own}
    return dataset[["seconds"]].assign(
        {name: ("way", np.where(unknown, np.nan, values)) for name, values in shares.items()}
        | {"number": ("way", chosen.number.values[number]), "case": ("way", chosen.case.values[at_case])}
    )
