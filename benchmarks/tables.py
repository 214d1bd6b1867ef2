"""Tables in Markdown, and their record for the pages of docs/evidence.

With --record a benchmark also writes its tables to docs/numbers/benchmarks/, one file for each benchmark;
`python tools/write_docs.py` makes the pages. Without it a benchmark prints only.
"""

import json
import os
import platform
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from femic.cache.digests import STUDY_FOLDERS, results_digest

NUMBERS = Path(__file__).parents[1] / "docs" / "numbers" / "benchmarks"
OPTION = "--record"
_recording: list[bool] = []


@dataclass(frozen=True)
class Record:
    """Where a table is kept, and what a page says about it."""

    place: str  # file and table, "engines.growth"
    title: str
    shows: str  # in one or two sentences
    command: str  # that makes it


def arguments() -> list[str]:
    """Take --record out of the command line, remember it, and return the other arguments.

    Processes that a benchmark starts keep compiled sources, as they do for users: without them each one
    compiles all sources anew, which takes seconds.
    """
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    if OPTION in sys.argv:
        sys.argv.remove(OPTION)
        _recording.append(True)
    return sys.argv[1:]


def print_table(
    head: Sequence[str], rows: Iterable[Sequence[object]], title: str = "", record: Record | None = None
) -> None:
    """Print a table, each row as soon as it is there; keep it where a record is given and wanted."""
    if title or record:
        print(f"\n### {title or record.title}")
    print(f"\n{line_of(head)}\n|{'---|' * len(head)}", flush=True)
    done = []
    for row in rows:
        print(line_of(row), flush=True)
        done.append([str(cell) for cell in row])
    if record:
        keep(record, head, done)


def keep(record: Record, head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Write a table beside the others of its benchmark, if this is wanted."""
    if _recording:
        made = {"date": date.today().isoformat(), "machine": machine()}
        write(record, head, rows, made | {"code": results_digest(*STUDY_FOLDERS)})


def write(record: Record, head: Sequence[str], rows: Sequence[Sequence[str]], origin: dict[str, str]) -> None:
    """Write a table and where it comes from: date, machine and code, or a source."""
    name, table = record.place.split(".")
    path = NUMBERS / f"{name}.json"
    tables = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    about = {"title": record.title, "shows": record.shows, "command": record.command}
    tables[table] = about | origin | {"columns": list(head), "rows": [list(row) for row in rows]}
    NUMBERS.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(tables, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def machine() -> str:
    """Return the number of cores, the processor, and the version of Python."""
    return f"{os.cpu_count()} cores, {processor()}, Python {platform.python_version()}"


def processor() -> str:
    """Return the name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", info.read_text()) if info.exists() else None
    return found[1] if found else platform.machine()


def line_of(cells: Sequence[object]) -> str:
    """Return a line of a table."""
    return f"| {' | '.join(map(str, cells))} |"
