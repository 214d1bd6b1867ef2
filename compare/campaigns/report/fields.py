"""The fields of a campaign: numbers over the swept axes by row (ICs) and column (component).

They are errors of ICs, numbers of contacts, and fits.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
import xarray as xr

from compare.campaigns.kinds import CURVES_LARGEST, HALF, OF_CONTACTS
from compare.report.errors import COMPONENTS
from compare.report.looks import INK, ics_looks, ics_symbol
from compare.report.parts import join_words
from femic.contact.pairs.quantities import OF_FRICTIONLESS
from femic.ic_errors.error_measure import ROUNDING
from femic.results.contact import reference_name
from femic.results.damage import OF_DAMAGE
from geometries.arrays import Array

# --- swept axes -----------------------------------------------------------------------------------------


LARGE = 1e8  # value from which on powers of ten are written
LONG = 10.0  # ratio of the ends from which on an axis may be logarithmic
QUOTES = str.maketrans("", "", "'\"")  # that text of a list has
ZARRS_TEXT = "T"  # kind of the dtype of text of any length
ICS, LAST = "ICs", "the last ICs"  # names where lists of ICs differ between scenes
Names = Mapping[str, Any]  # values by the names of axes


@dataclass(frozen=True, eq=False)
class ShownAxis:
    """A swept axis; `values` of a grid or of all scenes, text in the order of the file."""

    name: str
    heading: str  # label and unit
    values: Array  # (n,) numbers or text
    spacing: str = "linear"  # in the campaign file: "linear", "logarithmic", "inverse"
    unit: str = ""

    @property
    def label(self) -> str:
        """The name with the unit, as on axes of charts."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def meaning(self) -> str:
        """The name and what it stands for, where the file says so."""
        return self.label if self.heading == self.label else f"{self.name}: {self.heading}"

    @property
    def is_number(self) -> bool:
        """Whether the values are numbers, not text."""
        return self.values.dtype.kind == "f"

    @property
    def is_logarithmic(self) -> bool:
        """Whether values are spread over powers, or their median is nearer to the geometric mean."""
        if not self.is_number or len(self.values) < 3 or np.min(self.values) <= 0:
            return False
        if self.spacing == "logarithmic":
            return True
        low, high, median = np.min(self.values), np.max(self.values), np.median(self.values)
        middle = np.log(median / low) / np.log(high / low) if high > low else 0.0
        linear = (median - low) / (high - low) if high > low else 0.0
        return bool(high > LONG * low and abs(middle - 0.5) < abs(linear - 0.5))

    @cached_property
    def categories(self) -> list[str]:
        """The texts of an axis without numbers, in the order of their first scenes; () of numbers."""
        return [] if self.is_number else list(dict.fromkeys(map(value_text, self.values)))

    @property
    def at(self) -> Array:
        """The positions of the values in charts, (n,): the number, or the place of a category."""
        if self.is_number:
            return self.values
        numbers = {text: float(k) for k, text in enumerate(self.categories)}
        return np.array([numbers[value_text(value)] for value in self.values])


def read_axes(dataset: xr.Dataset) -> list[ShownAxis]:
    """Return all axes of a campaign, in the order of its file."""
    axes = []
    for described in json.loads(dataset.attrs["axes"]):
        values = dataset[described["name"]]
        label, unit = str(values.attrs.get("long_name") or values.name), str(values.attrs.get("units", ""))
        axes.append(
            ShownAxis(
                str(values.name),
                f"{label} [{unit}]" if unit else label,
                np.atleast_1d(values.values.astype(float if values.dtype.kind in "fiu" else str)),
                described.get("spacing", "linear"),
                unit,
            )
        )
    return axes


def swept(axes: Iterable[ShownAxis]) -> list[ShownAxis]:
    """Return the axes with more than one value."""
    return [axis for axis in axes if len(axis.values) > 1]


def prepare(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with ascending numbers along each axis of a grid, without dims of one value.

    Text is as in NetCDF: NumPy cannot cast the text of zarr. Where lists of ICs differ between scenes, they
    are named after their places, the last one C.
    """
    dataset = dataset.copy()
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == ZARRS_TEXT:
            dataset[name] = variable.dims, variable.values.astype(object).astype(str), variable.attrs
    for dim in ("variant", "ics"):
        if dim in dataset.coords and str(dataset[dim].values[0]) == f"{dim} 0":
            count = dataset.sizes[dim]
            last = "C" if dim == "variant" else LAST
            dataset = dataset.assign_coords({dim: [*(f"{ICS} {k}" for k in range(1, count)), last]})
    if not is_grid(dataset):
        return dataset
    axes = read_axes(dataset)
    dataset = dataset.sortby([axis.name for axis in axes if axis.is_number])
    return dataset.squeeze([axis.name for axis in axes if len(axis.values) == 1])


def is_grid(dataset: xr.Dataset) -> bool:
    """Whether the scenes are all combinations of the axes' values."""
    return str(dataset.attrs["points"]) == "grid"


def value_text(value: Any) -> str:
    """Return a value of an axis as text."""
    if isinstance(value, str):
        bare = value.translate(QUOTES)
        return bare if "," in bare else bare.strip("[]")
    short = f"{float(value):.4g}"
    large = "e+" in short and abs(float(value)) < LARGE
    return np.format_float_positional(float(short), trim="-") if large else short


def values_text(values: Names) -> str:
    """Return values of axes as text: flank = 30, ratio = 1.1."""
    return ", ".join(f"{name} = {value_text(value)}" for name, value in values.items())


def evenly_spaced(count: int, most: int) -> list[int]:
    """Return up to `most` of the numbers below `count`, evenly spaced, with the first and the last."""
    return sorted({int(k) for k in np.round(np.linspace(0, count - 1, min(count, most)))})


def point_name(dataset: xr.Dataset, place: Iterable[Any]) -> str:
    """Return the name of the scene at a place, one number for each swept dim."""
    seconds = dataset["seconds"]
    scene = seconds.isel(dict(zip(seconds.dims, place, strict=True)))
    return values_text({axis.name: scene[axis.name].item() for axis in read_axes(dataset)})


# --- a field --------------------------------------------------------------------------------------------


ROW, COLUMN = "(row)", "(column)"  # dims that no axis can have the name of
C = "C"
LEVELS = (0.01, 0.02, 0.05, 0.1)  # errors and deviations whose places are reported and drawn
REPORTED = 0.05  # the level of the page's sentences
LOWEST = 1e-4  # smallest error of curves and points; those below are drawn there
VANISHES = " †"
Kind = Literal["error", "deviation", "value"]


@dataclass(frozen=True, eq=False)
class Field:
    """Numbers over the swept dims, `ROW` and `COLUMN`; `floor`: their estimated error, without `ROW`.

    Errors are positive shares, deviations are ratios minus 1, values have units.
    """

    name: str
    kind: Kind
    what: str  # the numbers in a few words: "errors"
    text: str  # the numbers in a sentence
    values: xr.DataArray
    floor: xr.DataArray | None = None
    reference: str = C  # the ICs with which others are compared, and which `floor` is of

    @property
    def rows(self) -> list[str]:
        """Names of rows, such as ICs."""
        return [str(name) for name in self.values[ROW].values]

    @property
    def columns(self) -> list[str]:
        """Names of columns."""
        return [str(name) for name in self.values[COLUMN].values]

    @property
    def title(self) -> str:
        """`what` as a heading."""
        return self.what[0].upper() + self.what[1:]

    @property
    def rates_ics(self) -> bool:
        """Whether the numbers rate ICs: errors and deviations."""
        return self.kind != "value"

    @property
    def closest(self) -> str:
        """The row with the smallest numbers on the average over scenes and columns."""
        options = self.sizes.mean([dim for dim in self.sizes.dims if dim != ROW])
        return self.rows[int(options.argmin(ROW))]

    @property
    def shown(self) -> xr.DataArray:
        """The numbers of charts: errors and deviations in percent."""
        return 100 * self.values if self.rates_ics else self.values

    @property
    def sizes(self) -> xr.DataArray:
        """The numbers without their signs."""
        return abs(self.values)

    def worst_over(self, dim: str) -> "Field":
        """Return the numbers that are furthest from zero along a dim; of values, those at its first place."""
        values = furthest_along(self.values, dim) if self.rates_ics else self.values.isel({dim: 0}, drop=True)
        return replace(self, values=values, floor=None)

    def select(self, *, rows: list[str] | None = None, columns: list[str] | None = None) -> "Field":
        """Return the field with some rows and columns only."""
        chosen = {COLUMN: columns or self.columns}
        floor = None if self.floor is None else self.floor.sel(chosen)
        return replace(self, values=self.values.sel(chosen | {ROW: rows or self.rows}), floor=floor)

    def at(self, **places: Any) -> "Field":
        """Return the field at some places of swept dims."""
        floor = None if self.floor is None else self.floor.isel(places)
        return replace(self, values=self.values.isel(places), floor=floor)


def share(value: float) -> str:
    """Return a share in percent, short."""
    return f"{100 * value:.3g} %" if abs(value) < 0.1 else f"{100 * value:.0f} %"


def plain(column: str) -> str:
    """Return the name of a column without marks."""
    return column.removesuffix(VANISHES)


def shown_body(dataset: xr.Dataset) -> str:
    """Return the body whose ICs are shown: both together, or the first one compared."""
    bodies = [str(body) for body in dataset.body.values]
    return "combined" if "combined" in bodies else bodies[0]


def swept_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the dims of the campaign."""
    return tuple(map(str, dataset["seconds"].dims))


def furthest_along(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Return the values that are furthest from zero along a dim, NaN where none is known."""
    low, high = values.min(dim), values.max(dim)
    return high.where(high >= -low, low)


# --- the fields of a dataset ----------------------------------------------------------------------------


RATIOS = (  # numbers of contacts, compared as ratios
    *("p_max", "a", "b", "approach", "angle", "slope"),
    *("work", "t_gamma", "largest_depth_energy", "largest_depth_twin_disc"),
)
SHARES = (CURVES_LARGEST, "sliding_share")  # numbers that are shares: compared as they are
SYMBOLS = {"slope": "dF_x/dξ", CURVES_LARGEST: "F_x(ξ)", "sliding_share": "sliding"} | {
    name: number.symbol for name, number in OF_DAMAGE.items() if name not in OF_CONTACTS
}
MEANINGS = {
    "slope": " dF_x/dξ: slope of the creep-force curve at zero force.",
    CURVES_LARGEST: " F_x(ξ): largest difference of the creep-force curves, relative to friction times load.",
    "sliding_share": " Sliding: difference of the sliding part of the patch.",
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
    f" {VANISHES}: this component of C vanishes or nearly vanishes in some scenes; its errors there are "
    "relative to 0.05 max |C_nn|."
)
BY_PLACE = " The scenes use different ICs; they are named here after their positions in the lists."


def find_fields(dataset: xr.Dataset) -> list[Field]:
    """Return all fields of a campaign's dataset in which anything is computed."""
    fields = [*_errors(dataset)]
    kept = {*json.loads(dataset.attrs["keep"])}
    if "stresses" in kept:
        fields += _stresses(dataset)
    if {"contact", "stresses"} & kept:
        fields += _contact(dataset)
    if "fit_value" in dataset:
        fields += _calibration(dataset)
    return [field for field in fields if field.values.size and np.any(np.isfinite(field.values))]


def _errors(dataset: xr.Dataset) -> Iterator[Field]:
    """Yield errors of all ICs, the worst over the lines, of components that do not vanish by symmetry.

    Without them, errors with the estimate of C, the worst over lines and components, where these are known.
    """
    if "error" not in dataset and "known_error" not in dataset:
        return
    body, columns = shown_body(dataset), {}
    if "error" in dataset:
        at_body = dataset[["error", "vanishes"]].sel(body=body, drop=True).drop_attrs()
        for component in SHOWN_ORDER:
            at_component = at_body.sel(i=component[0], j=component[1], drop=True)
            worst = at_component.error.max("line").load()
            if worst.max() > ROUNDING:
                vanishes = at_component.vanishes == 1
                mark = VANISHES if vanishes.any() else ""
                columns[component + mark] = worst.where((worst.variant != C) | ~vanishes)
        text = (
            f"Error of the {body} ICs: largest deviation from C over all lines, relative to the component "
            f"itself. {COMPONENTS}"
        )
    else:
        columns[ANY] = dataset.known_error.sel(body=body, drop=True).drop_attrs()
        text = f"Error of the {body} ICs plus the estimated error of C: largest over lines and components."
    if not columns:
        return
    text += VANISHING if any(name.endswith(VANISHES) for name in columns) else ""
    errors = xr.concat(columns.values(), xr.Variable(COLUMN, list(columns))).rename(variant=ROW)
    text += BY_PLACE if f"{ICS} 1" in errors[ROW] else ""
    approximations = [name for name in map(str, errors[ROW].values) if not name.startswith(C)]
    floor = errors.sel({ROW: C}, drop=True)
    yield Field("errors", "error", "errors", text, errors.sel({ROW: approximations}), floor)


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
    labels, last = xr.Variable(COLUMN, heads), f", at the last {several}" if several else ""
    yield Field(
        "reference",
        "value",
        "the contact",
        f"Numbers of the contact with {ics_symbol(reference)}{last}.",
        xr.concat([at_last[name] for name in shown], labels, coords="minimal").rename(ics=ROW),
        reference=ics_symbol(reference),
    )


def _deviations(dataset: xr.Dataset, numbers: Sequence[str], reference: str, over: str) -> Field:
    """Return numbers of the contact with other ICs than the reference over those with it."""
    deviations, estimates = [], []
    for name in numbers:
        values = dataset[name].drop_attrs()
        at_reference = values.sel(ics=reference, drop=True)
        unit = xr.ones_like(at_reference) if name in SHARES else at_reference.where(at_reference != 0)
        deviation = (values - at_reference) / unit
        estimate = dataset.get(f"estimate_{name}", xr.full_like(values, np.nan)).drop_attrs()
        estimate = abs(estimate.sel(ics=reference, drop=True) / unit)
        for dim in _own_dims(dataset, name):
            deviation, estimate = furthest_along(deviation, dim), estimate.max(dim)
        deviations.append(deviation)
        estimates.append(estimate)
    labels, base = xr.Variable(COLUMN, [_symbol(name) for name in numbers]), ics_symbol(reference)
    values = xr.concat(deviations, labels).rename(ics=ROW)
    notes = [MEANINGS[name] for name in numbers if name in MEANINGS] + [BY_PLACE] * (reference == LAST)
    return Field(
        "contact",
        "deviation",
        "errors of the contact",
        "Relative difference of the contact numbers with each of the ICs from those with "
        f"{base}{over}.{''.join(notes)}",
        values.sel({ROW: [name for name in map(str, values[ROW].values) if name != reference]}),
        xr.concat(estimates, labels),
        base,
    )


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
        "errors of half-space stresses",
        "Relative difference of the largest stresses in half-spaces from those in the actual bodies, "
        "under the same tractions.",
        (flat / true - 1).expand_dims({ROW: ["half-space"]}),
        xr.concat(estimates, labels) / abs(true),
        "actual bodies",
    )
    yield Field(
        "stresses",
        "value",
        "largest stresses",
        "Largest stresses in the actual bodies [MPa].",
        true.assign_coords({COLUMN: [f"{label} [MPa]" for label in labels.values]}).expand_dims(
            {ROW: ["actual body"]}
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
            f"Largest deviation from C of {body} with B̂ and with the fitted B̂′, relative to max |C| of "
            "the points.",
            xr.concat(errors, xr.Variable(ROW, list(kinds))).rename(fitted_component=COLUMN),
        )


# --- the advised ICs ------------------------------------------------------------------------------------


NONE, GREY = "none", "#c8ccd2"
Advice = tuple[xr.DataArray, dict[str, str]]  # places among names of ICs over the swept dims; their colours


def find_advice(dataset: xr.Dataset) -> Advice | None:
    """Return the advised ICs of a campaign that kept them, of those that are advised anywhere; else None.

    Colours are those of the ICs' curves, grey for none; C, whose curves have the colour of ink, is black.
    """
    if "advised" not in dataset:
        return None
    numbers = dataset.advised.sel(body=shown_body(dataset), drop=True).drop_attrs().load()
    known = np.unique(numbers.values[np.isfinite(numbers.values)]).astype(int)
    if not known.size:
        return None
    used = sorted(known, key=lambda k: (k < 0, k))  # -1, none, comes last
    places = np.select([numbers == k for k in used], range(len(used)), np.nan)
    names = [str(dataset.variant.values[k]) for k in used if k >= 0]
    looks = ics_looks(names)
    colours = {ics_symbol(name): looks[name].colour.replace(INK, "#000000") for name in names}
    return numbers.copy(data=places), colours | ({NONE: GREY} if -1 in used else {})
