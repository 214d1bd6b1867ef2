"""Templates, cells of error tables and embedded pictures of the HTML reports."""

import base64
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from compare.results.measure import ROUNDING


@dataclass(frozen=True)
class Cell:
    """A cell of a table: a number, its background, and a smaller number below it."""

    text: str
    colour: str
    below: str = ""


WHITE = "#ffffff"
VANISHING = " †"  # marks errors of components that vanish: shares of 0.05 max |C_nn|


@dataclass(frozen=True)
class Picture:
    """A PNG picture as base64 text."""

    name: str
    data: str


def rendered(template: str, **values: object) -> str:
    """A template of this package with values filled in; raises UndefinedError where one is missing."""
    environment = Environment(
        loader=PackageLoader("compare.pages"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    return environment.get_template(template).render(**values)


def error_cell(error: float, weight: float = np.nan, *, vanishes: bool = False, mark: str = "") -> Cell:
    """Cell of an error, coloured by its size, with its weight below; a dash where nothing was computed."""
    if np.isnan(error):
        return Cell("–", WHITE)
    if error < ROUNDING:
        return Cell("0" + mark, WHITE)
    return Cell(percent(error) + (VANISHING if vanishes else "") + mark, colour(error), _weight_text(weight))


def known_cell(estimate: float, weight: float = np.nan, *, vanishes: bool = False, mark: str = "") -> Cell:
    """Cell of the estimated error of C, likewise; it has no share where the component vanishes."""
    if vanishes:
        return Cell("vanishes" + mark, WHITE, _weight_text(weight))
    return error_cell(estimate, weight, mark=mark)


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


def embedded(path: Path) -> Picture:
    """A PNG file as a picture to embed in a report."""
    return Picture(path.stem, base64.b64encode(path.read_bytes()).decode())
