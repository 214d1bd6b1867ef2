"""The list of all pages in a folder of results, `index.html`."""

import html
import os
import re
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from compare.report.parts import Page, Section, write_page
from compare.report.tables import Cell, Row, Table, texts

INDEX = "index.html"
TITLE = re.compile(r"<title>(.*?)</title>", re.DOTALL)
PAGES = "*/[!.]*.html", "profiles/*/profile.html"
HEAD = 4096  # characters within which a page has its title


def write_index(folder: Path) -> Path | None:
    """Write `index.html` of the pages in the folders of a folder, newest first; None where there are none.

    Pages of profiles are in folders of `profiles`.

    Other runs may write, move and remove pages meanwhile: what is unfinished or gone is left out.
    """
    pages = (path for pattern in PAGES for path in folder.glob(pattern))
    entries = filter(None, map(_entry, pages))
    rows = [_row(folder, *entry) for entry in sorted(entries, reverse=True)]
    if not rows:
        return None
    table = Table("folder", texts("page", "title", "written"), rows)
    sentence = "Results in this folder, the newest first. Each page is one file: it may be moved and sent."
    return write_page(Page("femic: results", sentence, [Section("", [table])]), folder / INDEX)


def _entry(path: Path) -> tuple[float, Path, str] | None:
    """Return when a page was written, its path and its title; None where it cannot be read or has none."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            title = TITLE.search(file.read(HEAD))
        return (path.stat().st_mtime, path, html.unescape(title[1])) if title else None
    except OSError:
        return None


def _row(folder: Path, seconds: float, path: Path, title: str) -> Row:
    written = datetime.fromtimestamp(seconds).astimezone()
    link = Cell(path.name, link=quote(os.fsencode(path.relative_to(folder))))
    return Row(path.parent.relative_to(folder).as_posix(), [link, title, f"{written:%Y-%m-%d %H:%M}"])
