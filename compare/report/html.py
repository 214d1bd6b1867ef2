"""Pages, cells of error tables and embedded pictures of the HTML reports."""

import base64
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined

from compare.ics.error_measure import ROUNDING
from femic.cache.files import write_text


@dataclass(frozen=True)
class Cell:
    """A cell of a table: a number, its background, and a smaller number below it."""

    text: str
    colour: str
    below: str = ""


@dataclass(frozen=True)
class Row:
    """The errors of one variant at one place, a line or a scene: a cell per component.

    Only the first row of a variant has its symbol.
    """

    symbol: str
    place: str
    cells: list[Cell]


WHITE = "#ffffff"
VANISHING = " †"  # marks errors of components that vanish: shares of 0.05 max |C_nn|


def write_page(path: Path, template: str, **values: object) -> Path:
    """Write a template of this package with values filled in; raises UndefinedError where one is missing."""
    environment = Environment(
        loader=PackageLoader("compare.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters["base64"] = lambda picture: base64.b64encode(picture.read_bytes()).decode()
    return write_text(environment.get_template(template).render(**values), path)


def error_cell(
    error: float, weight: float = np.nan, *, vanishes: bool = False, mark: str = "", known: bool = False
) -> Cell:
    """Cell of an error, coloured by its size, with its weight below; a dash where nothing was computed.

    `known`: the error is the estimated one of C, which has no share where the component vanishes.
    """
    if known and vanishes:
        return Cell("vanishes" + mark, WHITE, _weight_text(weight))
    if np.isnan(error):
        return Cell("–", WHITE)
    if error < ROUNDING:
        return Cell("0" + mark, WHITE)
    return Cell(percent(error) + (VANISHING if vanishes else "") + mark, colour(error), _weight_text(weight))


def cell_of(errors: xr.Dataset, *, known: bool, mark: str = "") -> Cell:
    """Cell of a dataset with a single `error` [-], its `weight` and whether the component `vanishes`."""
    error, weight, vanishes = (errors[name].item() for name in ("error", "weight", "vanishes"))
    return error_cell(error, weight, vanishes=vanishes, mark=mark, known=known)


def _weight_text(weight: float) -> str:
    return "" if np.isnan(weight) or weight < ROUNDING else percent(weight)


def percent(share: float) -> str:
    """A share in percent, as tables show it."""
    if share < 5e-5:
        return "< 0.01 %"
    return f"{100 * share:.2f} %" if share < 0.1 else f"{100 * share:.1f} %"


def colour(error: float) -> str:
    """Background of an error: white up to 0.1 %, red from 100 % on, logarithmic between."""
    redness = float(np.clip((np.log10(max(error, 1e-9)) + 3) / 3, 0, 1))
    green_blue = round(255 - 120 * redness)
    return f"#ff{green_blue:02x}{green_blue:02x}"
