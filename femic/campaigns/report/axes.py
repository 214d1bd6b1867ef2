"""The swept axes of a campaign as its page names and draws them."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from geometries.arrays import Array

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
        return [] if self.is_number else list(dict.fromkeys(map(text_of, self.values)))

    @property
    def at(self) -> Array:
        """The positions of the values in charts, (n,): the number, or the place of a category."""
        if self.is_number:
            return self.values
        numbers = {text: float(k) for k, text in enumerate(self.categories)}
        return np.array([numbers[text_of(value)] for value in self.values])


def axes_of(dataset: xr.Dataset) -> list[ShownAxis]:
    """Return all axes of a campaign, in the order of its file."""
    return [
        _axis(dataset[described["name"]], described.get("spacing", "linear"))
        for described in json.loads(dataset.attrs["axes"])
    ]


def swept(axes: Iterable[ShownAxis]) -> list[ShownAxis]:
    """Return the axes with more than one value."""
    return [axis for axis in axes if len(axis.values) > 1]


def prepared(dataset: xr.Dataset) -> xr.Dataset:
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
    axes = axes_of(dataset)
    dataset = dataset.sortby([axis.name for axis in axes if axis.is_number])
    return dataset.squeeze([axis.name for axis in axes if len(axis.values) == 1])


def is_grid(dataset: xr.Dataset) -> bool:
    """Whether the scenes are all combinations of the axes' values."""
    return str(dataset.attrs["points"]) == "grid"


def text_of(value: Any) -> str:
    """Return a value of an axis as text."""
    if isinstance(value, str):
        bare = value.translate(QUOTES)
        return bare if "," in bare else bare.strip("[]")
    short = f"{float(value):.4g}"
    large = "e+" in short and abs(float(value)) < LARGE
    return np.format_float_positional(float(short), trim="-") if large else short


def values_text(values: Names) -> str:
    """Return values of axes as text: flank = 30, ratio = 1.1."""
    return ", ".join(f"{name} = {text_of(value)}" for name, value in values.items())


def evenly_spaced(count: int, most: int) -> list[int]:
    """Return up to `most` of the numbers below `count`, evenly spaced, with the first and the last."""
    return sorted({int(k) for k in np.round(np.linspace(0, count - 1, min(count, most)))})


def point_of(dataset: xr.Dataset, place: Iterable[Any]) -> str:
    """Return the name of the scene at a place, one number for each swept dim."""
    seconds = dataset["seconds"]
    scene = seconds.isel(dict(zip(seconds.dims, place, strict=True)))
    return values_text({axis.name: scene[axis.name].item() for axis in axes_of(dataset)})


def _axis(values: xr.DataArray, spacing: str) -> ShownAxis:
    label = str(values.attrs.get("long_name") or values.name)
    unit = values.attrs.get("units", "")
    is_number = values.dtype.kind in "fiu"
    return ShownAxis(
        str(values.name),
        f"{label} [{unit}]" if unit else label,
        np.atleast_1d(values.values.astype(float if is_number else str)),
        spacing,
        str(unit),
    )
