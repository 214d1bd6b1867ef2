"""What the page of a campaign shows, as numbers over the swept axes by row (ICs) and column (component)."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import xarray as xr

from compare.pages.styles import SYMBOLS, symbol_of
from compare.results.contact.compute import reference_name
from compare.results.contact.quantities import QUANTITIES
from compare.results.measure import ROUNDING

ROW, COLUMN = "(row)", "(column)"  # dims that no axis can have the name of
C = "C"
OF_CONTACT = ("p_max", "a", "b", "approach", "angle", "slope")
LEVELS = (0.01, 0.02, 0.05, 0.1)  # errors and deviations whose places are told and drawn
VANISHES = " †"
SHOWN_ORDER = ("nn", "ss", "xx", "xs", "xn", "sn", "sx", "nx", "ns")  # of components
Kind = Literal["error", "deviation", "value"]


@dataclass(frozen=True, eq=False)
class Field:
    """Numbers over the swept dims, `ROW` and `COLUMN`; `floor`: how well they are known, without `ROW`.

    Errors are positive shares, deviations are ratios less 1, values have units.
    """

    name: str
    kind: Kind
    what: str  # of which the page speaks: "error of the combined ICs"
    text: str  # what the numbers are
    values: xr.DataArray
    floor: xr.DataArray | None = None

    @property
    def rows(self) -> list[str]:
        """Names of rows, such as ICs."""
        return [str(name) for name in self.values[ROW].values]

    @property
    def columns(self) -> list[str]:
        """Names of columns."""
        return [str(name) for name in self.values[COLUMN].values]

    @property
    def sizes(self) -> xr.DataArray:
        """The numbers without their signs."""
        return abs(self.values)

    def worst_over(self, dim: str) -> "Field":
        """The field with the numbers that are furthest from zero along a dim; values: at its first place."""
        if self.kind == "value":
            return replace(self, values=self.values.isel({dim: 0}, drop=True), floor=None)
        floor = None if self.floor is None else self.floor.max(dim)
        return replace(self, values=furthest_along(self.values, dim), floor=floor)

    def of(self, *, rows: list[str] | None = None, columns: list[str] | None = None) -> "Field":
        """The field with some rows and columns only."""
        chosen = {COLUMN: columns or self.columns}
        floor = None if self.floor is None else self.floor.sel(chosen)
        return replace(self, values=self.values.sel(chosen | {ROW: rows or self.rows}), floor=floor)

    def at(self, **places: Any) -> "Field":
        """The field at some places of swept dims."""
        floor = None if self.floor is None else self.floor.isel(places)
        return replace(self, values=self.values.isel(places), floor=floor)


def fields_of(dataset: xr.Dataset) -> list[Field]:
    """All that the dataset of a campaign has to show over its axes, as far as anything is computed."""
    kept = json.loads(dataset.attrs["keep"])
    found: list[Field] = []
    if "error" in dataset:
        found += _errors(dataset)
    if "known_error" in dataset and "error" not in dataset:
        found += _known_errors(dataset)
    if "contact" in kept:
        found += _contact(dataset)
    if "fit_value" in dataset:
        found += _calibration(dataset)
    return [field for field in found if field.values.size and np.any(np.isfinite(field.values))]


def label_of(name: str) -> str:
    """The symbol of a row where it has one."""
    known = name in SYMBOLS or "+" in name
    return symbol_of(name) if known else name


def plain(column: str) -> str:
    """The name of a column without marks."""
    return column.removesuffix(VANISHES)


def body_of(dataset: xr.Dataset) -> str:
    """The body whose ICs are shown: both together, or the first one compared."""
    bodies = [str(body) for body in dataset.body.values]
    return "combined" if "combined" in bodies else bodies[0]


def swept_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dims over which scenes lie."""
    return tuple(map(str, dataset["seconds"].dims))


def furthest_along(values: xr.DataArray, dim: str) -> xr.DataArray:
    """The values that are furthest from zero along a dim, NaN where none is known."""
    low, high = values.min(dim), values.max(dim)
    return high.where(high >= -low, low)


def _errors(dataset: xr.Dataset) -> Iterator[Field]:
    """Errors of all ICs, the worst over the lines, of components that do not vanish by symmetry."""
    body, columns = body_of(dataset), {}
    of_body = dataset[["error", "vanishes"]].sel(body=body, drop=True).drop_attrs()
    for component in SHOWN_ORDER:
        one = of_body.sel(i=component[0], j=component[1], drop=True)
        worst = one.error.max("line").load()
        if worst.max() > ROUNDING:
            mark = VANISHES if (one.vanishes == 1).any() else ""
            columns[component + mark] = worst.where((worst.variant != C) | (one.vanishes != 1))
    if not columns:
        return
    errors = xr.concat(columns.values(), xr.Variable(COLUMN, list(columns))).rename(variant=ROW)
    others = [name for name in map(str, errors[ROW].values) if not name.startswith(C)]
    note = (
        " † In some scenes this component of C vanishes, or nearly does: its errors there are shares of "
        "0.05 max |C_nn|."
        if any(name.endswith(VANISHES) for name in columns)
        else ""
    )
    yield Field(
        "errors",
        "error",
        "errors",
        f"Error of the {body} ICs: largest deviation from C over a line, share of the component itself; the "
        f"worst over all lines.{note}",
        errors.sel({ROW: others}),
        errors.sel({ROW: C}, drop=True) if C in errors[ROW] else None,
    )


def _known_errors(dataset: xr.Dataset) -> Iterator[Field]:
    """Errors of all ICs with the estimate of C, the worst over lines and components."""
    body = body_of(dataset)
    known = dataset.known_error.sel(body=body, drop=True).drop_attrs().rename(variant=ROW)
    known = known.expand_dims({COLUMN: ["all"]})
    others = [name for name in map(str, known[ROW].values) if not name.startswith(C)]
    yield Field(
        "errors",
        "error",
        "errors",
        f"Error of the {body} ICs with the estimate of C: the worst over lines and components.",
        known.sel({ROW: others}),
        known.sel({ROW: C}, drop=True),
    )


def _contact(dataset: xr.Dataset) -> Iterator[Field]:
    """Numbers of the contact by each of the ICs over those by the reference, and these themselves."""
    numbers = [name for name in OF_CONTACT if name in dataset and "ics" in dataset[name].dims]
    if not numbers:
        return
    reference = reference_name([str(name) for name in dataset.ics.values])
    symbols = {name: _symbol(name) for name in numbers}
    ratios = {symbols[name]: _off(dataset, name, reference) for name in numbers}
    labels = xr.Variable(COLUMN, list(ratios))
    off = xr.concat([ratio for ratio, _ in ratios.values()], labels).rename(ics=ROW)
    others = [name for name in map(str, off[ROW].values) if name != reference]
    by = label_of(reference)
    dims = sorted({str(dim) for name in numbers for dim in _own_dims(dataset, name)})
    several = [dim for dim in dims if dataset.sizes[dim] > 1]
    worst = f", the furthest over {' and '.join(several)}" if several else ""
    if others:
        yield Field(
            "contact",
            "deviation",
            "numbers of the contact",
            f"Numbers of the contact by each of the ICs over those by {by}, less 1{worst}.",
            off.sel({ROW: others}),
            xr.concat([known for _, known in ratios.values()], labels),
        )
    heads = [f"{symbols[name]} [{_unit(dataset, name)}]" for name in numbers]
    last = dict.fromkeys(dims, -1)
    at_last = f", at the last {' and '.join(several)}" if several else ""
    values = [
        dataset[name].sel(ics=[reference]).isel(last, missing_dims="ignore", drop=True).drop_attrs()
        for name in numbers
    ]
    yield Field(
        "reference",
        "value",
        "the contact",
        f"Numbers of the contact by {by}{at_last}.",
        xr.concat(values, xr.Variable(COLUMN, heads), coords="minimal", compat="override").rename(ics=ROW),
    )


def _off(dataset: xr.Dataset, name: str, reference: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Ratios less 1 of a number of the contact to the reference's, and what is known of the latter."""
    values = dataset[name].drop_attrs()
    of_reference = values.sel(ics=reference, drop=True)
    of_reference = of_reference.where(of_reference != 0)
    off = values / of_reference - 1
    estimate = f"estimate_{name}"
    known = (
        abs(dataset[estimate].drop_attrs().sel(ics=reference, drop=True) / of_reference)
        if estimate in dataset
        else xr.full_like(of_reference, np.nan)
    )
    for dim in _own_dims(dataset, name):
        off, known = furthest_along(off, dim), known.max(dim)
    return off, known


def _own_dims(dataset: xr.Dataset, name: str) -> list[str]:
    return [str(dim) for dim in dataset[name].dims if dim not in (*swept_dims(dataset), "ics")]


def _symbol(name: str) -> str:
    return QUANTITIES[name].symbol if name in QUANTITIES else name


def _unit(dataset: xr.Dataset, name: str) -> str:
    return QUANTITIES[name].unit if name in QUANTITIES else str(dataset[name].attrs.get("units", "1"))


def _calibration(dataset: xr.Dataset) -> Iterator[Field]:
    """Fitted parameters, and the deviations of B-hat-prime by them from C, by fitted body."""
    labels: Mapping[str, str] = {"fitted_body": ROW, "parameter": COLUMN}
    yield Field(
        "fits",
        "value",
        "fitted parameters",
        "Parameters of B̂′ fitted to C, by fitted body: r_inf in mm, G in MPa.",
        dataset.fit_value.drop_attrs().rename(labels),
    )
    kinds = {"Bhat": dataset.Bhat_worst, "Bhat_prime": dataset.fit_worst}
    for number, body in enumerate(map(str, dataset.fitted_body.values)):
        of_body = [one.sel(fitted_body=body, drop=True).drop_attrs() for one in kinds.values()]
        yield Field(
            f"fitted_{number}",
            "error",
            f"errors of the fit to {body}",
            f"Largest deviation from C of {body} by B̂ and by the fitted B̂′, share of max |C| of the points.",
            xr.concat(of_body, xr.Variable(ROW, list(kinds))).rename(fitted_component=COLUMN),
        )
