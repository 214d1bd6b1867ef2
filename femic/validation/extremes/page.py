"""`femic extremes` runs all cases and writes `extremes.json` and `extremes.html`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from compare.report.parts import Note, Page, Section
from compare.report.tables import Cell, Row, Table, texts
from compare.report.tables import numbers as number_heads
from femic.validation import record
from femic.validation.extremes import compute
from femic.validation.extremes.engines import Engines

ERRORS = (
    "Analytic: the largest relative error of a component (of rotations: of an entry of the matrix), corners "
    "of the range and cases drawn by hypothesis. Engines: the largest error of six components on three lines "
    "at tolerance 0.01 (solid: 0.1), on planes against A, elsewhere against C from cells less than half as "
    "large in a domain more than twice as large; errors and estimates of C are shares of the scale of "
    "refinement, the larger of max |C_ij| and 0.05 max |C_nn| on a line, which the tolerance is for. An "
    "error may be smaller than another component's estimate and larger than its own: the share is the "
    "largest error of a component on a line over its own estimate. Seconds: all models of a case."
)


def write_extremes(parts: Sequence[str], engines: Engines, folder: Path) -> Path:
    """Run the cases of some parts and write the results; returns the path of the page."""
    content = compute.numbers(compute.compute(parts, engines))
    return record.write(folder, "extremes", compute.__name__, content, page_of)


def page_of(content: dict[str, Any]) -> Page:
    """Return the page; `content` is the content of `extremes.json`."""
    title = "femic at its limits: range of each part, errors at the limits, messages beyond them"
    seconds = Note(f"All models took {content['seconds']} s. {record.version_text(content)}")
    sections = [
        Section("", [_within_table(content["rows"]), Note(ERRORS)]),
        Section("Beyond the limits", [_beyond_table(content["rows"]), seconds]),
    ]
    return Page(title, content["summary"], sections)


def _within_table(rows: Sequence[dict[str, Any]]) -> Table:
    """Return the table of cases within the limits."""
    columns = [
        *texts("parameter", "range", "case"),
        *number_heads("error", "estimate", "largest share of its estimate"),
        *texts("against"),
        *number_heads("s"),
    ]
    table_rows = []
    for row in rows:
        named = [row["engine"], row["parameter"], row["range"]]
        for case in row["reached"]:
            table_rows.append(Row(named[0], [*named[1:], *_cells(case)]))
            named = ["", "", ""]
    return Table("part", columns, table_rows)


def _cells(case: dict[str, Any]) -> list[Cell | str]:
    """Return the cells of a case; errors larger than their estimate are coloured."""
    note = f"; {case['note']}" if case["note"] else ""
    return [
        f"{case['at']}{note}",
        Cell(np.nan if case["error"] is None else case["error"], ".1e"),
        "" if case["estimate"] is None else Cell(case["estimate"], ".1e"),
        Cell("" if case["used"] is None else case["used"], ".2f", colour="" if case["honest"] else "#f9d9d6"),
        case["exact"],
        Cell(case["seconds"], ".2g"),
    ]


def _beyond_table(rows: Sequence[dict[str, Any]]) -> Table:
    """Return the table of messages in cases beyond the limits."""
    table_rows = [
        Row(row["engine"], [row["parameter"], case["at"], case["says"] or "nothing"])
        for row in rows
        for case in row["beyond"]
    ]
    return Table("part", ["parameter", "case", "message of femic"], table_rows, is_text=True)
