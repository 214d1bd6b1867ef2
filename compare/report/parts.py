"""Pages as data: sections of paragraphs, tables and figures; `write_page` is the only way to a file."""

import base64
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from compare.report.styles import save
from femic.cache import folders
from femic.cache.files import write_dataset, write_text


@dataclass(frozen=True)
class Cell:
    """A cell of a table: a number and its format, or a text; below it a smaller text. NaN is a dash.

    `link` is the anchor of a section.
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
        return "–" if np.isnan(self.value) else format(self.value, self.form)


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
    """Columns of texts."""
    return [Column(head, is_text=True) for head in heads]


def numbers(*heads: str, unit: str = "") -> list[Column]:
    """Columns of numbers."""
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

    kind: ClassVar[str] = "table"
    caption: str
    columns: Sequence[Column | str]
    rows: Sequence[Row]
    is_text: bool = False

    @property
    def heads(self) -> list[Column]:
        """The columns, also of plain heads."""
        return [Column(one, "", self.is_text) if isinstance(one, str) else one for one in self.columns]

    @property
    def is_grouped(self) -> bool:
        """Whether rows continue others."""
        return not all(row.name for row in self.rows)


@dataclass(frozen=True)
class Picture:
    """A figure and the name of its file, without ending; or the path of a picture that is drawn already."""

    kind: ClassVar[str] = "picture"
    name: str
    figure: Figure | Path


@dataclass(frozen=True)
class Note:
    """A paragraph in small print."""

    kind: ClassVar[str] = "note"
    text: str


@dataclass(frozen=True)
class Items:
    """A list of sentences."""

    kind: ClassVar[str] = "items"
    items: Sequence[str]


@dataclass(frozen=True)
class Verbatim:
    """Text that is shown as it is, such as a scene file."""

    kind: ClassVar[str] = "verbatim"
    text: str


@dataclass(frozen=True)
class Folded:
    """Details that are shown on request."""

    kind: ClassVar[str] = "folded"
    heading: str
    blocks: "Sequence[Block]"


@dataclass(frozen=True)
class Section:
    """A heading, or none, and what is below it; also sections. Links lead to the anchor."""

    kind: ClassVar[str] = "section"
    heading: str
    blocks: "Sequence[Block]"
    colour: str = ""
    anchor: str = ""


@dataclass(frozen=True)
class Part:
    """A section of one figure: a heading, a paragraph that says what the figure shows, and that, by name."""

    heading: str
    text: str
    name: str
    figure: Figure

    @property
    def section(self) -> Section:
        """The same as a section."""
        return Section(self.heading, [self.text, Picture(self.name, self.figure)])


INDICES = re.compile(r"\b([ACJfr])_(∞|[a-zφ]{1,2}\b)")  # of a symbol: C_nn, r_∞
Block = str | Table | Picture | Note | Items | Verbatim | Folded | Section  # a string is a paragraph


@dataclass(frozen=True)
class Page:
    """A page: its title, sentences on the results, and sections, which may be made one by one."""

    title: str
    summary: str
    sections: Iterable[Section | Part]


def closing(
    tables: Sequence[Table], below: str, cost: str, scene: str, heading: str = "The scene"
) -> list[Section]:
    """The end of a page: tables, what is below their numbers, what they took, and the scene."""
    return [Section("Numbers", [below, *tables, cost]), Section(heading, [Verbatim(scene)])]


def write_results(page: Page, folder: Path, name: str, dataset: xr.Dataset | None = None) -> Path:
    """Write NAME.nc, NAME.html and figures NAME_FIGURE.png into a folder; returns the path of the page."""
    folders.made(folder)
    if dataset is not None:
        write_dataset(dataset, folder / f"{name}.nc")
    return write_page(page, folder / f"{name}.html", name)


def write_page(page: Page, path: Path, prefix: str = "") -> Path:
    """Write a self-contained page, and figures/PREFIX_NAME.png beside it; returns the path of the page."""
    figures = folders.made(path.parent / "figures")
    environment = Environment(
        loader=PackageLoader("compare.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters["embedded"] = lambda picture: _embedded(picture, figures, prefix)
    environment.filters["typeset"] = _typeset
    sections = (one.section if isinstance(one, Part) else one for one in page.sections)
    text = environment.get_template("page.html.j2").render(page=page, sections=sections)
    return write_text(text, path)


def _typeset(text: str) -> Markup:
    """A text with the indices of ICs, such as C_nn, set as indices."""
    return Markup(INDICES.sub(r"\1<sub>\2</sub>", str(escape(text))))


def _embedded(picture: Picture, folder: Path, prefix: str) -> str:
    """The content of a picture's file, which is written before unless it is there."""
    path = picture.figure
    if isinstance(path, Figure):
        name = f"{prefix}_{picture.name}" if prefix else picture.name
        path = save(path, folder / f"{name}.png")
    return base64.b64encode(path.read_bytes()).decode()


def listed(words: Iterable[str]) -> str:
    """Words with commas and "and" between them."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def onset(angles: ArrayLike, beyond: ArrayLike) -> str:
    """From which angle [deg] on something holds, as far as solved cases say: an interval between two of them.

    "" where it never does. Cases may come in any order.
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
