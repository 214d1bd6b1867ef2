"""Texts of users on pages, and names of their files: pages show them, and nothing is written elsewhere."""

import json
import random
import re
from collections.abc import Iterator
from contextlib import chdir
from html import escape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from fuzz import by_code, outcome
from outcomes import Outcome

from compare.report.charts import Chart, Curve, Map, Panel
from compare.report.files import figures_as
from compare.report.looks import label_looks
from compare.report.parts import Page, Section, write_page
from compare.report.tables import Row, Table, texts
from femic.cli.main import exit_code
from femic.shifts.specification import example

PARTS = (
    *(
        "<!--",
        "<script>",
        "</script>",
        "</title>",
        "<b>",
        "<br>",
        "&lt;",
        "&",
        '"',
        "'",
        "\\",
        "$",
        "$\\frac",
    ),
    *(
        "%{y}",
        "{{ 1 }}",
        "{% raw %}",
        "_",
        "a",
        "ü",
        "\u202e",
        "\x00",
        "\x07",
        "\ud800",
        " ",
        "]]>",
        "{",
        "C_nn",
    ),
)
NAMES = (
    "..",
    ".",
    " ",
    "...",
    "a",
    "-",
    "#",
    "%20",
    "?",
    "[/a]",
    "~",
    "$HOME",
    "\x07",
    "ü",
    "<b>",
    "\udcff",
    "'",
)
POINTS = "\n".join(
    f"{30 * np.sin(angle):.6f} {30 * np.cos(angle):.6f}" for angle in np.linspace(-1.4, 1.4, 61)
)
DATA = re.compile(r'<script type="application/json">(.*?)</script', re.DOTALL)
X = np.linspace(0.0, 1.0, 3)


def pages(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield pages with a text wherever texts of users stand: whole, with charts and pictures."""
    for number in range(count):
        chance = random.Random(f"page {seed} {number}")
        text = "".join(chance.choices(PARTS, k=chance.randint(1, 5)))
        yield outcome(f"page with {text!r}", lambda text=text: _page(text, folder))


def _page(text: str, folder: Path) -> str:
    curve = Curve(text, X, X, label_looks([text])[text], names=[text] * 3, notes=[text] * 3)
    cells = [
        Panel(text, text, text, [curve], names_x=[text] * 3),
        Map(text, text, text, X, X, np.eye(3), text, classes=[text, "b"], names_y=[text] * 3),
    ]
    blocks = [text, Table(text, texts(text), [Row(text, [text])]), Chart("chart", {text: cells}, slider=text)]
    with figures_as(["svg"]):
        page = write_page(Page(text, text, [Section(text, blocks)]), folder / "page.html").read_text("utf-8")
    (data,) = DATA.findall(page)
    shown = text.encode(errors="replace").decode()
    if "<" in data or list(json.loads(data)["labels"]) != [shown]:
        raise AssertionError("data of its chart are not whole")
    if f"<title>{escape(shown).replace('&quot;', '&#34;').replace('&#x27;', '&#39;')}</title>" not in page:
        raise AssertionError("its title is another")
    for picture in (folder / "figures").glob("*.svg"):
        ElementTree.parse(picture)
    return "taken"


def names(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Yield profiles and wheelsets in files of odd names: results are in their folder, or nowhere."""
    work = folder / "work"
    work.mkdir(parents=True)
    for number in range(count):
        chance = random.Random(f"name {seed} {number}")
        name = "".join(chance.choices(NAMES, k=chance.randint(1, 2)))
        command = ("profiles", "shifts")[number % 2]
        with chdir(work):
            yield outcome(
                f"{command} of {name!r}", lambda name=name, command=command: _named(name, command, folder)
            )


def _named(name: str, command: str, folder: Path) -> str:
    is_profile = command == "profiles"
    path = Path("d") / f"{name}{'.txt' if is_profile else '.toml'}"
    path.parent.mkdir(exist_ok=True)
    path.write_text(POINTS if is_profile else example(), encoding="utf-8")
    options = ["--kind", "rail", "--axes", "field"] if is_profile else ["--write", "0"]
    answer = by_code(exit_code([command, str(path), *options]))
    path.unlink()
    elsewhere = [
        one
        for one in folder.rglob("*")
        if one.is_file() and one.relative_to(folder).parts[:2] != ("work", "out")
    ]
    if elsewhere:
        raise AssertionError(f"{elsewhere[0]} was written")
    return answer
