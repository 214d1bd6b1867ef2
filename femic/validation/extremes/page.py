"""`femic extremes` runs all cases and writes `extremes.json` and `extremes.html`."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from compare.ics.dataset import finite
from compare.report.parts import Note, Page, Section
from compare.report.tables import Cell, Row, Table, texts
from compare.report.tables import numbers as number_heads
from femic.validation import record
from femic.validation.extremes import analytic, exact
from femic.validation.extremes.cases import ANALYTIC, Limit, LimitResult, WithinLimit, results_of
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
    limits: list[Limit] = []
    for part in parts:
        limits += analytic.limits() if part == ANALYTIC else engines.limits(part)
    results = list(results_of(limits, engines.options.watch.on_stage))
    return record.write(folder, "extremes", __name__, numbers(results), page_of)


def summary(results: Sequence[LimitResult]) -> str:
    """Return how many estimates hold, and whether all cases beyond the limits have a message."""
    cases = [case for result in results for case in result.reached]
    estimated = [case for case in cases if case.used is not None]
    held = sum(case.honest for case in estimated)
    beyond = [case for result in results for case in result.beyond]
    silent = [case.at for case in beyond if not case.says]
    messages = "each has a message" if not silent else f"no message at {', '.join(silent)}"
    estimates = (
        f"In {held} of {len(estimated)} cases with estimates all of them are at least the error. "
        if estimated
        else ""
    )
    return f"{len(cases)} cases within the limits. {estimates}{len(beyond)} beyond: {messages}."


def numbers(results: Sequence[LimitResult]) -> dict[str, Any]:
    """Return the content of `extremes.json`."""
    return {
        "rows": [
            {
                "engine": result.limit.engine,
                "parameter": result.limit.name,
                "range": result.limit.range,
                "reached": [_case(case) for case in result.reached],
                "beyond": [asdict(case) for case in result.beyond],
            }
            for result in results
        ],
        "summary": summary(results),
        "digits": exact.DIGITS,
        "seconds": round(sum(case.seconds for result in results for case in result.reached), 1),
    }


def _case(case: WithinLimit) -> dict[str, Any]:
    """Return a case with None for numbers that JSON lacks, and whether its estimates hold."""
    values = asdict(case).items()
    return {key: finite(v) if isinstance(v, float) else v for key, v in values} | {"honest": case.honest}


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
