"""The fields in the dataset of a campaign: errors of ICs, numbers of contacts, fits."""

import json
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr

from compare.contact.compute import reference_name
from compare.report.errors import COMPONENTS
from compare.report.looks import symbol_of
from compare.report.parts import join_words
from compare.stresses.dataset import OF_DAMAGE, variable_of
from femic.campaigns.report.axes import ICS, LAST
from femic.campaigns.report.fields import (
    COLUMN,
    ROW,
    VANISHES,
    C,
    Field,
    body_of,
    furthest_along,
    swept_dims,
)
from femic.campaigns.results.contact import CURVES_LARGEST
from femic.campaigns.results.stresses import HALF, OF_CONTACTS
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.ic_errors.error_measure import ROUNDING

RATIOS = (  # numbers of contacts, compared as ratios
    *("p_max", "a", "b", "approach", "angle", "slope"),
    *("work", "t_gamma", "largest_depth_energy", "largest_depth_twin_disc"),
)
SHARES = (CURVES_LARGEST, "sliding_share")  # numbers that are shares: compared as they are
SYMBOLS = {"slope": "dF_x/dξ", CURVES_LARGEST: "F_x(ξ)", "sliding_share": "sliding"} | {
    variable_of(name): number.symbol for name, number in OF_DAMAGE.items() if name not in OF_CONTACTS
}
MEANINGS = {
    "slope": " dF_x/dξ: slope of the creep-force curve where it has no force.",
    CURVES_LARGEST: " F_x(ξ): largest distance of creep-force curves, share of friction times load.",
    "sliding_share": " Sliding: share of the patch that slides, the difference.",
}
DIMS = {"case": "load", "load": "load", "friction": "friction", "xi": "creepage"}  # dims in words
SHOWN_ORDER = ("nn", "ss", "xx", "xs", "xn", "sn", "sx", "nx", "ns")  # of components
STRESSES = {
    f"{name}_{body}": symbol
    for name, symbol in (("mises", "σ_Mises"), ("dang_van", "τ_DV"))
    for body in ("upper", "lower")
}
ANY = "the worst component"
VANISHING = (
    f" {VANISHES}: in some scenes this component of C vanishes, or nearly does; its errors there are shares "
    "of 0.05 max |C_nn|."
)
BY_PLACE = " Scenes differ in their ICs: here they are named after their places in the lists."


def fields_of(dataset: xr.Dataset) -> list[Field]:
    """Return all fields of a campaign's dataset in which anything is computed."""
    fields: list[Field] = []
    if "error" in dataset:
        fields += _errors(dataset)
    if "known_error" in dataset and "error" not in dataset:
        fields += _error_bounds(dataset)
    kept = {*json.loads(dataset.attrs["keep"])}
    if "stresses" in kept:
        fields += _stresses(dataset)
    if {"contact", "stresses"} & kept:
        fields += _contact(dataset)
    if "fit_value" in dataset:
        fields += _calibration(dataset)
    return [field for field in fields if field.values.size and np.any(np.isfinite(field.values))]


def _errors(dataset: xr.Dataset) -> Iterator[Field]:
    """Yield errors of all ICs, the worst over the lines, of components that do not vanish by symmetry."""
    body, columns = body_of(dataset), {}
    dataset_of_body = dataset[["error", "vanishes"]].sel(body=body, drop=True).drop_attrs()
    for component in SHOWN_ORDER:
        component_errors = dataset_of_body.sel(i=component[0], j=component[1], drop=True)
        worst = component_errors.error.max("line").load()
        if worst.max() > ROUNDING:
            vanishes = component_errors.vanishes == 1
            mark = VANISHES if vanishes.any() else ""
            columns[component + mark] = worst.where((worst.variant != C) | ~vanishes)
    if not columns:
        return
    errors = xr.concat(columns.values(), xr.Variable(COLUMN, list(columns))).rename(variant=ROW)
    notes = [VANISHING] if any(name.endswith(VANISHES) for name in columns) else []
    notes += [BY_PLACE] if f"{ICS} 1" in errors[ROW] else []
    yield _error_field(
        errors,
        f"Error of the {body} ICs: largest deviation from C over a line, share of the component itself; the "
        f"worst over all lines. {COMPONENTS}{''.join(notes)}",
    )


def _error_bounds(dataset: xr.Dataset) -> Iterator[Field]:
    """Yield errors of all ICs with the estimate of C, the worst over lines and components."""
    body = body_of(dataset)
    bounds = dataset.known_error.sel(body=body, drop=True).drop_attrs().rename(variant=ROW)
    text = f"Error of the {body} ICs with the estimate of C: the worst over lines and components."
    yield _error_field(bounds.expand_dims({COLUMN: [ANY]}), text)


def _error_field(errors: xr.DataArray, text: str) -> Field:
    """Return errors of approximations, with those of C as their floor."""
    approximations = [name for name in map(str, errors[ROW].values) if not name.startswith(C)]
    floor = errors.sel({ROW: C}, drop=True)
    return Field("errors", "error", "errors", text, errors.sel({ROW: approximations}), floor)


def _contact(dataset: xr.Dataset) -> Iterator[Field]:
    """Yield numbers of the contact with each of the ICs over those with the reference, and the latter."""
    numbers = [name for name in (*RATIOS, *SHARES) if name in dataset and "ics" in dataset[name].dims]
    if not numbers:
        return
    ics = [str(name) for name in dataset.ics.values]
    reference = reference_name(ics)
    own = sorted({str(dim) for name in numbers for dim in _own_dims(dataset, name)})
    several = join_words([DIMS.get(dim, dim) for dim in own if dataset.sizes[dim] > 1] or [""])
    if len(ics) > 1:
        yield _deviations(dataset, numbers, reference, f", the furthest over {several}" if several else "")
    shown = [name for name in numbers if name != CURVES_LARGEST]
    heads = [f"{_symbol(name)} [{dataset[name].attrs.get('units', '1')}]" for name in shown]
    at_last = dataset[shown].isel(dict.fromkeys(own, -1), drop=True).sel(ics=[reference]).drop_attrs()
    labels = xr.Variable(COLUMN, heads)
    yield Field(
        "reference",
        "value",
        "the contact",
        f"Numbers of the contact with {symbol_of(reference)}{f', at the last {several}' if several else ''}.",
        xr.concat([at_last[name] for name in shown], labels, coords="minimal").rename(ics=ROW),
        reference=symbol_of(reference),
    )


def _deviations(dataset: xr.Dataset, numbers: Sequence[str], reference: str, over: str) -> Field:
    """Return numbers of the contact with other ICs than the reference over those with it."""
    deviations, estimates = zip(
        *(_relative_deviations(dataset, name, reference) for name in numbers), strict=True
    )
    labels, base = xr.Variable(COLUMN, [_symbol(name) for name in numbers]), symbol_of(reference)
    values = xr.concat(deviations, labels).rename(ics=ROW)
    notes = [MEANINGS[name] for name in numbers if name in MEANINGS] + [BY_PLACE] * (reference == LAST)
    return Field(
        "contact",
        "deviation",
        "deviations of the contact",
        f"Numbers of the contact with each of the ICs over those with {base}, minus 1{over}.{''.join(notes)}",
        values.sel({ROW: [name for name in map(str, values[ROW].values) if name != reference]}),
        xr.concat(estimates, labels),
        base,
    )


def _relative_deviations(dataset: xr.Dataset, name: str, reference: str) -> tuple[xr.DataArray, xr.DataArray]:
    """Return deviations of a number of the contact from the reference's, and the estimate of the latter."""
    values = dataset[name].drop_attrs()
    reference_values = values.sel(ics=reference, drop=True)
    unit = xr.ones_like(reference_values) if name in SHARES else reference_values.where(reference_values != 0)
    deviations = (values - reference_values) / unit
    estimate = dataset.get(f"estimate_{name}", xr.full_like(values, np.nan)).drop_attrs()
    estimates = abs(estimate.sel(ics=reference, drop=True) / unit)
    for dim in _own_dims(dataset, name):
        deviations, estimates = furthest_along(deviations, dim), estimates.max(dim)
    return deviations, estimates


def _stresses(dataset: xr.Dataset) -> Iterator[Field]:
    """Yield how far half-spaces are off the largest stresses of both bodies, and these stresses."""
    names = [name for name in STRESSES if name in dataset]
    if not names:
        return
    labels = xr.Variable(COLUMN, [f"{STRESSES[name]}, {name.rpartition('_')[2]} body" for name in names])
    true = xr.concat([dataset[name].drop_attrs() for name in names], labels)
    flat = xr.concat([dataset[f"{HALF}{name}"].drop_attrs() for name in names], labels)
    unknown = xr.full_like(dataset[names[0]], np.nan)
    estimates = [dataset.get(f"estimate_{name}", unknown).drop_attrs() for name in names]
    yield Field(
        "half_space",
        "deviation",
        "deviations of half-spaces",
        "Largest stresses in half-spaces under the same tractions over those in the true bodies, minus 1.",
        (flat / true - 1).expand_dims({ROW: ["half-space"]}),
        xr.concat(estimates, labels) / abs(true),
        "true bodies",
    )
    yield Field(
        "stresses",
        "value",
        "largest stresses",
        "Largest stresses in the true bodies [MPa].",
        true.assign_coords({COLUMN: [f"{label} [MPa]" for label in labels.values]}).expand_dims(
            {ROW: ["true body"]}
        ),
    )


def _own_dims(dataset: xr.Dataset, name: str) -> list[str]:
    return [str(dim) for dim in dataset[name].dims if dim not in (*swept_dims(dataset), "ics")]


def _symbol(name: str) -> str:
    return SYMBOLS.get(name) or OF_FRICTIONLESS[name].symbol


def _calibration(dataset: xr.Dataset) -> Iterator[Field]:
    """Yield fitted parameters, and deviations of B-hat-prime with them from C, by fitted body."""
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
        errors = [values.sel(fitted_body=body, drop=True).drop_attrs() for values in kinds.values()]
        yield Field(
            f"fitted_{number}",
            "error",
            f"errors of the fit to {body}",
            f"Largest deviation from C of {body} for B̂ and the fitted B̂′, share of max |C| of the points.",
            xr.concat(errors, xr.Variable(ROW, list(kinds))).rename(fitted_component=COLUMN),
        )
