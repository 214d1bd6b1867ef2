"""Pages of parts: each a paragraph with its figure; then tables of numbers, what they took, and the scene."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from compare.report.html import write_page
from compare.report.styles import save

ROUNDING = 1e-9  # of a number, below which a change is none


@dataclass(frozen=True)
class Part:
    """A heading of a page, a paragraph that says what its figure shows, and that figure, by name."""

    heading: str
    text: str
    name: str
    figure: Figure


@dataclass(frozen=True)
class Row:
    """A row of a table."""

    name: str
    cells: Sequence[Mapping[str, str]]


@dataclass(frozen=True)
class Table:
    """A table of numbers, or of text, which may have several lines."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Row]
    is_text: bool = False


@dataclass(frozen=True)
class Page:
    """A page: sentences, parts, tables, what is below each number of these, what all took, and the scene."""

    title: str
    summary: str
    parts: Iterable[Part]
    tables: Sequence[Table]
    below: str
    cost: str
    scene: str
    of_text: str = "The scene"  # heading of the text at the end

    def write(self, path: Path, prefix: str) -> Path:
        """Write the page, and its figures PREFIX_NAME.png into `figures` beside it; returns its path."""
        folder = path.parent / "figures"
        folder.mkdir(exist_ok=True)
        shown = [
            {
                "heading": part.heading,
                "text": part.text,
                "figures": [save(part.figure, folder / f"{prefix}_{part.name}.png")],
            }
            for part in self.parts
        ]
        values = {
            name: getattr(self, name) for name in ("title", "summary", "tables", "below", "cost", "of_text")
        }
        return write_page(path, "parts.html.j2", **values, parts=shown, text=self.scene)


def cell(value: xr.DataArray, estimate: xr.DataArray | None = None, *, digits: int = 4) -> dict[str, str]:
    """A cell of a table: a number, and its estimate below."""
    below = "" if estimate is None or np.isnan(float(estimate)) else f"± {float(estimate):.2g}"
    return {"text": f"{float(value):.{digits}g}", "below": below}


def changed_cell(value: xr.DataArray, before: xr.DataArray, estimate: xr.DataArray) -> dict[str, str]:
    """A cell of a table: by how much a number changes, below it what it was, with its estimate."""
    change = float(value) - float(before)
    text = f"{change:+.2g}" if abs(change) > ROUNDING * abs(float(before)) else "0"
    return {"text": text, "below": f"of {float(before):.4g} ± {float(estimate):.2g}"}


def listed(words: Iterable[str]) -> str:
    """Words with commas and "and" between them."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def onset(angles: ArrayLike, beyond: ArrayLike) -> str:
    """From which angle [deg] on something is so, as far as solved cases say: an interval between two of them.

    "" where it never is. Cases may come in any order.
    """
    order = np.argsort(angles)
    at, is_so = np.asarray(angles, dtype=float)[order], np.asarray(beyond, dtype=bool)[order]
    if not is_so.any():
        return ""
    first = int(np.argmax(is_so))
    where = f"between {at[first - 1]:.0f} and {at[first]:.0f} degrees" if first else f"{at[0]:.0f} degrees"
    not_again = [f"{angle:.0f}" for angle in at[first:][~is_so[first:]]]
    return " ".join(
        [
            f"from {where} on" if first else f"already at {where}, the least that was solved",
            *([f"(not at {listed(not_again)})"] if not_again else []),
        ]
    )


def furthest(values: xr.DataArray) -> float:
    """The value that is furthest from zero."""
    return float(values.values.ravel()[np.argmax(np.abs(values.values))])
