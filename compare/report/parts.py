"""Pages as data: sections of paragraphs, tables and figures; `write_page` writes them.

`write_index` lists all pages in a folder of results in `index.html`.
"""

import base64
import html
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

import numpy as np
import xarray as xr
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from numpy.typing import ArrayLike

from compare.report import interactive
from compare.report.charts import Chart
from compare.report.files import save_charts
from compare.report.tables import Cell, Row, Table, texts
from femic.cache import folders
from femic.cache.files import write_dataset, write_text

# --- pages ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Picture:
    """An existing picture, a PNG file, and its name."""

    name: str
    path: Path


@dataclass(frozen=True)
class Note:
    """A paragraph in small print."""

    text: str


@dataclass(frozen=True)
class Items:
    """A list of sentences."""

    items: Sequence[str]


@dataclass(frozen=True)
class Verbatim:
    """Text shown verbatim, such as a scene file."""

    text: str


@dataclass(frozen=True)
class Folded:
    """Details shown on request."""

    heading: str
    blocks: "Sequence[Block]"


@dataclass(frozen=True)
class Section:
    """A heading, or none, and its blocks, also sections. Links lead to the anchor."""

    heading: str
    blocks: "Sequence[Block]"
    colour: str = ""
    anchor: str = ""


FIGURES = "figures"  # the folder of the files of figures
INDICES = re.compile("\\b([ABCJfr][\u0302\u0304]?′?)_(∞|[a-zφ]{1,2}\\b)")  # of a symbol: C_nn, B̂′_xn, r_∞
Block = str | Table | Chart | Picture | Note | Items | Verbatim | Folded | Section  # a string is a paragraph


@dataclass(frozen=True)
class Page:
    """A page: its title, the answer in at most three sentences and a table, and what is behind it.

    `doubts` say what may be wrong or unusual; they stand right below the answer. Sections may be made one by
    one; folded ones are shown on request.
    """

    title: str
    summary: str
    sections: Iterable[Section | Folded]
    answer: Table | None = None
    doubts: Sequence[str] = ()


def write_results(page: Page, folder: Path, name: str, dataset: xr.Dataset | None = None) -> Path:
    """Write NAME.nc and NAME.html into a folder, and figures as asked for; returns the path of the page."""
    folders.make(folder)
    if dataset is not None:
        write_dataset(dataset, folder / f"{name}.nc")
    return write_page(page, folder / f"{name}.html", name)


def write_page(page: Page, path: Path, prefix: str = "") -> Path:
    """Write a self-contained page; returns its path.

    Figures are written into figures/PREFIX_NAME.FORMAT beside it, in the formats of `files.figures_as`.
    """
    figures, prefix = folders.make(path.parent) / FIGURES, f"{prefix}_" if prefix else ""
    environment = Environment(
        loader=PackageLoader("compare.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters["kind"] = lambda block: type(block).__name__
    environment.filters["embedded"] = _embed
    environment.filters["explorable"] = interactive.as_json
    environment.filters["typeset"] = lambda text: Markup(INDICES.sub(r"\1<sub>\2</sub>", str(escape(text))))
    sections = list(page.sections)
    charts = list(_charts(sections))
    libraries = interactive.libraries(charts)
    text = environment.get_template("page.html.j2").render(page=page, sections=sections, libraries=libraries)
    save_charts(charts, figures, prefix)
    return write_text(text.encode(errors="replace").decode(), path)  # names of files need not be UTF-8


def _charts(blocks: Iterable[Block]) -> Iterator[Chart]:
    """Yield the charts in some blocks, also in sections."""
    for block in blocks:
        if isinstance(block, Chart):
            yield block
        yield from _charts(getattr(block, "blocks", ()))


def _embed(block: Picture) -> str:
    """Return a picture as a data URL."""
    return f"data:image/png;base64,{base64.b64encode(block.path.read_bytes()).decode()}"


def join_words(words: Iterable[str]) -> str:
    """Return words with commas and "and" between them; an empty text without words."""
    *first, last = [*words] or [""]
    return f"{', '.join(first)} and {last}" if first else last


def onset(angles: ArrayLike, beyond: ArrayLike) -> str:
    """Return from which angle [deg] on something holds: an interval between two solved cases, in any order.

    The text is empty where it never holds.
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
            f"above a limit {where}" if first else f"already at {where}, the smallest angle solved",
            *([f"(not at {join_words(not_again)})"] if not_again else []),
        ]
    )


def range_text(values: ArrayLike, form: str) -> str:
    """Return the least and the largest of values, or one number where these look the same, without NaN."""
    low, high = (format(float(of(values)), form) for of in (np.nanmin, np.nanmax))
    return low if low == high else f"{low} ... {high}"


def extreme(values: xr.DataArray) -> float:
    """Return the value furthest from zero."""
    return float(values.values.ravel()[np.argmax(np.abs(values.values))])


# --- the list of all pages ------------------------------------------------------------------------------


INDEX = "index.html"
TITLE = re.compile(r"<title>(.*?)</title>", re.DOTALL)
PAGES = "*/[!.]*.html", "profiles/*/profile.html"
HEAD = 4096  # characters within which a page has its title


def write_index(folder: Path) -> Path | None:
    """Write `index.html` of the pages in the folders of a folder, newest first; None where there are none.

    Pages of profiles are in folders of `profiles`.

    Other runs may write, move and remove pages meanwhile: what is unfinished or gone is left out.
    """
    entries = []
    for path in (path for pattern in PAGES for path in folder.glob(pattern)):
        try:
            with path.open(encoding="utf-8", errors="replace") as file:
                title = TITLE.search(file.read(HEAD))
            if title:
                entries.append((path.stat().st_mtime, path, html.unescape(title[1])))
        except OSError:
            continue
    rows = []
    for seconds, path, name in sorted(entries, reverse=True):
        written = f"{datetime.fromtimestamp(seconds).astimezone():%Y-%m-%d %H:%M}"
        link = Cell(path.name, link=quote(os.fsencode(path.relative_to(folder))))
        rows.append(Row(path.parent.relative_to(folder).as_posix(), [link, name, written]))
    if not rows:
        return None
    table = Table("folder", texts("page", "title", "written"), rows)
    sentence = "Results in this folder, newest first. Each page is a single file that you can move or send."
    return write_page(Page("femic: results", sentence, [Section("", [table])]), folder / INDEX)
