"""Tables as data: heads with units, rows of cells that are numbers in a format, or texts."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from femic.contact.pairs.quantities import Quantity

ROUNDING = 1e-9  # share below which a difference is rounding
VANISHING = 1e-4  # share of its estimate below which a difference is none
LEAST_POWER, LARGEST_POWER = -4, 7  # powers of ten of numbers that are written without one
UNRESOLVED = 0.5  # share of its estimate up to which a number is not resolved
ROUGH = 0.5  # share of a number from which its estimate has one digit
NONZERO, MINUS = re.compile("[1-9in]"), "\N{MINUS SIGN}"  # also of inf and nan


def number_text(value: float | xr.DataArray, form: str) -> str:
    """Return a number in a format: with a minus sign, and without any sign where all its digits are 0."""
    text = format(value.item() if isinstance(value, xr.DataArray) else value, form)
    if not NONZERO.search(text.partition("e")[0]):
        return text.lstrip("+-")
    return text.replace("-", MINUS, 1) if text.startswith("-") else text


@dataclass(frozen=True)
class Cell:
    """A cell of a table: a number and its format, or a text; below it a smaller text. NaN is a dash.

    `link` leads to a page, or with # to the anchor of a section.
    """

    value: float | str
    form: str = ""
    below: str = ""
    colour: str = ""
    link: str = ""

    @property
    def text(self) -> str:
        """The number in its format, or the text."""
        if isinstance(self.value, str):
            return self.value
        return "–" if np.isnan(self.value) else number_text(self.value, self.form)


@dataclass(frozen=True)
class Column:
    """The head of a column with its unit; texts are aligned to the left and may have several lines."""

    head: str
    unit: str = ""
    is_text: bool = False

    @property
    def title(self) -> str:
        """The head and the unit, in brackets."""
        return f"{self.head} [{'-' if self.unit == '1' else self.unit}]" if self.unit else self.head


def texts(*heads: str) -> list[Column]:
    """Return columns of texts."""
    return [Column(head, is_text=True) for head in heads]


def numbers(*heads: str, unit: str = "") -> list[Column]:
    """Return columns of numbers."""
    return [Column(head, unit) for head in heads]


@dataclass(frozen=True)
class Row:
    """A row of a table; without a name it continues the row above."""

    name: str
    cells: Sequence[Cell | str]

    @property
    def filled(self) -> list[Cell]:
        """The cells, also of plain texts."""
        return [Cell(cell) if isinstance(cell, str) else cell for cell in self.cells]


@dataclass(frozen=True)
class Table:
    """A table; its caption is the head of the column of the rows' names. `is_text` holds for all columns."""

    caption: str
    columns: Sequence[Column | str]
    rows: Sequence[Row]
    is_text: bool = False

    @property
    def heads(self) -> list[Column]:
        """The columns, also of plain heads."""
        return [Column(head, "", self.is_text) if isinstance(head, str) else head for head in self.columns]

    @property
    def is_grouped(self) -> bool:
        """Whether rows continue others."""
        return not all(row.name for row in self.rows)


def with_estimate(
    value: float | xr.DataArray, estimate: float | xr.DataArray, *, signed: bool = False
) -> str:
    """Return a number and its estimate, rounded to two digits of the estimate, such as 684.3 ± 4.3.

    Where the estimate is half of the number or more, it is rounded to one: 500 ± 600. A number of at most
    half of its estimate is not resolved: it lies within ± the sum of both. With an estimate of rounding a
    number has six digits, with one that is not known, NaN, four and "± ?". A number that is NaN is a dash.
    With `signed`, a positive number has its sign.
    """
    number, error, power = _texts(float(value), float(estimate), signed=signed)
    text = f"{number} {error}".rstrip()
    return f"({text}){power}" if power else text


def number_and_estimate(
    value: float | xr.DataArray, estimate: float | xr.DataArray, *, signed: bool = False
) -> tuple[str, str]:
    """Return the two texts of `with_estimate` apart, such as 684.3 and ± 4.3; the second may be empty."""
    number, error, power = _texts(float(value), float(estimate), signed=signed)
    return number + power, error + power


def _texts(value: float, estimate: float, *, signed: bool) -> tuple[str, str, str]:
    """Return a number, its estimate after ±, and the power of ten of both, empty where it is 1."""
    sign = "+" if signed and value > 0 else ""
    if np.isnan(value):
        return "–", "", ""
    if np.isnan(estimate):
        power = _power(value, 3)
        plain = LEAST_POWER <= power <= LARGEST_POWER
        return sign + (_rounded_text(value, power - 3) if plain else number_text(value, ".4g")), "± ?", ""
    if estimate <= ROUNDING * abs(value):
        return sign + number_text(value, ".6g"), "", ""
    first = _power(estimate, 1)  # power of ten of its first digit
    power = _power(max(abs(value), estimate))
    last = first - (estimate < ROUGH * abs(value))
    if abs(value) <= UNRESOLVED * estimate or round(value, -last) == 0:
        largest = abs(value) + estimate
        plain_text = _rounded_text(largest, _power(largest, 1) - 1)
        return f"within ± {plain_text if power >= LEAST_POWER else f'{largest:.1e}'}", "", ""
    plain = LEAST_POWER <= power <= LARGEST_POWER
    scale, exponent = (1.0, "") if plain else (10.0**power, f"e{power}")
    shift = 0 if plain else power
    number, error = (_rounded_text(one / scale, last - shift) for one in (value, estimate))
    return sign + number, f"± {error}", exponent


def _rounded_text(value: float, last: int) -> str:
    """Return a number rounded to a power of ten, with no further digits."""
    return number_text(round(value, -last), f".{max(-last, 0)}f")


def _power(value: float, digits: int = 6) -> int:
    """Return the power of ten of the first digit of a number, rounded to some digits behind that."""
    return int(f"{value:.{digits}e}".split("e")[1])


def changed_cell(value: xr.DataArray, before: xr.DataArray, estimate: xr.DataArray) -> Cell:
    """Return a cell with the change of a number, below it the former number with its estimate."""
    change = float(value) - float(before)
    rounding = max(ROUNDING * abs(float(before)), VANISHING * float(estimate))
    below = f"before: {with_estimate(before, estimate)}"
    return Cell(change, "+.2g", below) if abs(change) > rounding else Cell("0", "", below)


def changes_table(
    caption: str, quantities: Mapping[str, Quantity], before: xr.Dataset, changed: xr.Dataset, prefix: str
) -> Table:
    """Return the changes of quantities due to other supports, a column per change; `changed` has a prefix."""
    names = [str(name) for name in changed.supports.values]
    rows = [
        Row(
            Column(quantity.symbol, quantity.unit).title,
            [
                changed_cell(changed[prefix + key].sel(supports=name), before[key], before[f"estimate_{key}"])
                for name in names
            ],
        )
        for key, quantity in quantities.items()
    ]
    return Table(caption, numbers(*names), rows)
