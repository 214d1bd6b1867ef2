"""What the HTML reports share: templates, cells of error tables, embedded pictures."""

import base64
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from compare.results.measure import ROUNDING


@dataclass(frozen=True)
class Cell:
    """A number of a table with its background, and a small one below it."""

    text: str
    colour: str
    below: str = ""


WHITE = "#ffffff"
VANISHING = " †"  # marks errors of what vanishes, which are shares of 0.05 max |C_nn|


@dataclass(frozen=True)
class Picture:
    """A PNG as base64 text."""

    name: str
    data: str


def rendered(template: str, **values: object) -> str:
    """A template of this package with its values filled in; a missing one is an error."""
    environment = Environment(
        loader=PackageLoader("compare.pages"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    return environment.get_template(template).render(**values)


def error_cell(error: float, weight: float = np.nan, *, vanishes: bool = False, mark: str = "") -> Cell:
    """An error, its background by its size, with its weight; a dash where nothing was computed."""
    if np.isnan(error):
        return Cell("–", WHITE)
    if error < ROUNDING:
        return Cell("0" + mark, WHITE)
    return Cell(percent(error) + (VANISHING if vanishes else "") + mark, colour(error), _below(weight))


def known_cell(estimate: float, weight: float = np.nan, *, vanishes: bool = False, mark: str = "") -> Cell:
    """How well C is known, likewise; it has no share of itself where it vanishes."""
    if vanishes:
        return Cell("vanishes" + mark, WHITE, _below(weight))
    return error_cell(estimate, weight, mark=mark)


def _below(weight: float) -> str:
    return "" if np.isnan(weight) or weight < ROUNDING else percent(weight)


def percent(share: float) -> str:
    """As tables show it."""
    if share < 5e-5:
        return "< 0.01 %"
    return f"{100 * share:.2f} %" if share < 0.1 else f"{100 * share:.1f} %"


def colour(error: float) -> str:
    """White at 0.1 %, red at 100 %, by decades."""
    share = float(np.clip((np.log10(max(error, 1e-9)) + 3) / 3, 0, 1))
    green_blue = round(255 - 120 * share)
    return f"#ff{green_blue:02x}{green_blue:02x}"


def embedded(path: Path) -> Picture:
    """A PNG file as part of a report."""
    return Picture(path.stem, base64.b64encode(path.read_bytes()).decode())
