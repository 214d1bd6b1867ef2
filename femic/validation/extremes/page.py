"""`femic extremes` tries all cases and writes `extremes.json` and `extremes.html`."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from compare.ics.dataset import finite
from compare.report.parts import Note, Page, Section
from compare.report.tables import Cell, Row, Table, texts
from compare.report.tables import numbers as heads_of_numbers
from femic.validation import record
from femic.validation.extremes import analytic, exact
from femic.validation.extremes.cases import ANALYTIC, Found, Parameter, Reached, tried
from femic.validation.extremes.engines import Engines

ERRORS = (
    "Analytic: the largest relative error of a component (of turns: of an entry of the matrix), corners of "
    "the range and cases drawn by hypothesis. Engines: the largest error of six components on three lines "
    "at tolerance 0.01 (solid: 0.1), on planes against A, elsewhere against C from cells less than half as "
    "large in a domain more than twice as large; errors and estimates of C are shares of the scale of "
    "refinement, the larger of max |C_ij| and 0.05 max |C_nn| on a line, which the tolerance is for. An "
    "error may be smaller than another component's estimate and larger than its own: the share is that of "
    "each component on each line in its own estimate, the largest of them. Seconds: all models of a case."
)


def try_all(parts: Sequence[str], engines: Engines, folder: Path) -> Path:
    """Try the parts and write the results; returns the path of the page."""
    findings = list(
        tried([row for part in parts for row in rows(part, engines)], engines.options.watch.on_stage)
    )
    return record.write(folder, "extremes", numbers(findings), page_of)


def rows(part: str, engines: Engines) -> list[Parameter]:
    """The parameters of a part: of the analytic ICs or of an engine."""
    return analytic.parameters() if part == ANALYTIC else engines.parameters(part)


def summary(findings: Sequence[Found]) -> str:
    """One paragraph: how many estimates hold, and whether all cases beyond the limits have a message."""
    cases = [case for finding in findings for case in finding.reached]
    judged = [case for case in cases if case.used is not None]
    held = sum(case.honest for case in judged)
    beyond = [case for finding in findings for case in finding.beyond]
    silent = [case.at for case in beyond if not case.says]
    answered = "all of them are answered" if not silent else f"nothing is said at {', '.join(silent)}"
    estimates = (
        f"In {held} of {len(judged)} cases with estimates all of them are at least the error. "
        if judged
        else ""
    )
    return f"{len(cases)} cases within the limits. {estimates}{len(beyond)} beyond: {answered}."


def numbers(findings: Sequence[Found]) -> dict[str, Any]:
    """What was found, as `extremes.json` has it."""
    return {
        "rows": [
            {
                "engine": finding.parameter.engine,
                "parameter": finding.parameter.name,
                "range": finding.parameter.range,
                "reached": [_case(case) for case in finding.reached],
                "beyond": [asdict(case) for case in finding.beyond],
            }
            for finding in findings
        ],
        "summary": summary(findings),
        "digits": exact.DIGITS,
        "seconds": round(sum(case.seconds for finding in findings for case in finding.reached), 1),
    }


def _case(case: Reached) -> dict[str, Any]:
    """A case with None for numbers that JSON does not have, and whether its estimates hold."""
    values = asdict(case).items()
    return {key: finite(v) if isinstance(v, float) else v for key, v in values} | {"honest": case.honest}


def page_of(found: dict[str, Any]) -> Page:
    """The page of the numbers of `extremes.json`."""
    title = "femic at the extremes: how far each part goes, how wrong it is there, what it says beyond"
    seconds = Note(f"All models took {found['seconds']} s. {record.versions_of(found)}")
    sections = [
        Section("", [_reached_table(found["rows"]), Note(ERRORS)]),
        Section("Beyond", [_beyond_table(found["rows"]), seconds]),
    ]
    return Page(title, found["summary"], sections)


def _reached_table(rows: Sequence[dict[str, Any]]) -> Table:
    """The cases within the limits of each parameter."""
    columns = [
        *texts("parameter", "range", "case"),
        *heads_of_numbers("error", "estimate", "largest share of its estimate"),
        *texts("against"),
        *heads_of_numbers("s"),
    ]
    table_rows = []
    for row in rows:
        named = [row["engine"], row["parameter"], row["range"]]
        for case in row["reached"]:
            table_rows.append(Row(named[0], [*named[1:], *_cells(case)]))
            named = ["", "", ""]
    return Table("part", columns, table_rows)


def _cells(case: dict[str, Any]) -> list[Cell | str]:
    """The cells of a case; the share of an estimate that is too small is coloured."""
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
    """What the program says in the cases beyond the limits."""
    table_rows = [
        Row(row["engine"], [row["parameter"], case["at"], case["says"] or "nothing"])
        for row in rows
        for case in row["beyond"]
    ]
    return Table("part", ["parameter", "case", "message of femic"], table_rows, is_text=True)
