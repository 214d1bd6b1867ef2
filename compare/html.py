"""What the HTML reports share: templates, cells of error tables, embedded pictures."""

import base64
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined


@dataclass(frozen=True)
class Cell:
    """A number of a table with its background."""

    text: str
    colour: str


ZERO = Cell("0", "#ffffff")


@dataclass(frozen=True)
class Picture:
    """A PNG as base64 text."""

    name: str
    data: str


def rendered(template: str, **values: object) -> str:
    """A template of this package with its values filled in; a missing one is an error."""
    environment = Environment(
        loader=PackageLoader("compare"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    return environment.get_template(template).render(**values)


def error_cell(error: float, note: str = "") -> Cell:
    """An error in percent, its background by its size; a dash where nothing was computed."""
    if np.isnan(error):
        return Cell("–", "#ffffff")
    text = f"{100 * error:.2f} %" if error < 0.1 else f"{100 * error:.1f} %"
    return Cell(text + note, colour(error))


def colour(error: float) -> str:
    """White at 0.1 %, red at 100 %, by decades."""
    share = float(np.clip((np.log10(max(error, 1e-9)) + 3) / 3, 0, 1))
    green_blue = round(255 - 120 * share)
    return f"#ff{green_blue:02x}{green_blue:02x}"


def embedded(path: Path) -> Picture:
    """A PNG file as part of a report."""
    return Picture(path.stem, base64.b64encode(path.read_bytes()).decode())
