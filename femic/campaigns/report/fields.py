"""Numbers over the swept axes of a campaign by row (ICs) and column (component)."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import xarray as xr

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
    def unit(self) -> str:
        """The unit of the numbers in charts; values have units of their own, in the names of columns."""
        return "%" if self.rates_ics else ""

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

    def of(self, *, rows: list[str] | None = None, columns: list[str] | None = None) -> "Field":
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


def body_of(dataset: xr.Dataset) -> str:
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
