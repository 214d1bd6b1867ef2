"""`femic validate` assesses statements one by one and writes the results as JSON and as a page."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from compare.ics.compute import reference_of, seconds_of
from compare.ics.dataset import finite
from compare.ics.errors import measure_of
from compare.report.charts import Chart, chart_of
from compare.report.parts import Block, Folded, Items, Note, Page, Picture, Section
from compare.report.tables import Cell, Row, Table, texts
from compare.report.tables import numbers as number_heads
from femic.cache import folders
from femic.ic_errors.error_measure import Measure
from femic.validation import record
from femic.validation.statements import figures, verdicts
from femic.validation.statements.changes import CHANGES
from femic.validation.statements.runs import Runs
from femic.validation.statements.verdicts import (
    DEPENDS,
    NOT_DECIDED,
    NOT_REPRODUCED,
    REPRODUCED,
    Finding,
    assess,
)

TITLE = "femic: statements on these influence coefficients, and their verdicts"
RULES = (
    "Each statement is decided by numbers that femic computes and by thresholds that were fixed in its code "
    "before the first run (changes are listed below). “Reproduced”: every criterion is met in every case; "
    "“not reproduced”: no criterion is met in any case; otherwise it “depends”, and the failures are listed. "
    "Errors: max |v − C| over a line as a share of max |C_ij| over all lines, four elements from the load "
    "and further; where a component vanishes, of 0.05 max |C_nn|. Convex: the lower body; concave: the upper."
)
VERDICT_COLOURS = {
    REPRODUCED: "#d9f0d9",
    DEPENDS: "#fdf1cd",
    NOT_REPRODUCED: "#f9d9d6",
    NOT_DECIDED: "#dddddd",
}


def validate(numbers: Sequence[int], runs: Runs, folder: Path) -> Path:
    """Assess statements; write `validation.json`, figures and `validation.html`; return the page's path."""
    folders.make(folder)
    start, findings = perf_counter(), []
    for number in numbers:
        runs.options.watch.on_stage(f"statement {number}")
        findings.append(assess(number, runs))
        runs.options.watch.on_stage(f"statement {number}: {findings[-1].verdict}")
    runs.options.watch.on_stage("  figures and report")
    content = record_content(findings, runs, perf_counter() - start)
    return record.write(folder, "validation", verdicts.__name__, content, partial(page_of, findings))


def summary(findings: Sequence[Finding]) -> str:
    """Return the number of statements with each verdict as a sentence."""
    parts = []
    for verdict in VERDICT_COLOURS:
        numbers = [str(finding.statement.number) for finding in findings if finding.verdict == verdict]
        if numbers:
            parts.append(f"{verdict}: {len(numbers)} ({', '.join(numbers)})")
    return f"Of {len(findings)} statements, {'; '.join(parts)}."


def record_content(findings: Sequence[Finding], runs: Runs, seconds: float) -> dict[str, Any]:
    """Return the content of `validation.json`; `seconds` is the time of all statements together."""
    return {
        "statements": [_statement(finding) for finding in findings],
        "runs": {name: _run_record(runs, name) for name in runs.done},
        "changes": [asdict(change) for change in CHANGES],
        "tolerance": runs.tolerance,
        "seconds": round(seconds, 1),
    }


def _statement(finding: Finding) -> dict[str, Any]:
    return {
        "number": finding.statement.number,
        "claim": finding.statement.claim,
        "verdict": finding.verdict,
        "failed": finding.failed,
        "unmet": [
            f"{criterion.description}: {case}: {value:.4g} (not {criterion.relation} "
            f"{criterion.threshold:.3g}{'; too close to decide' if criterion.close(value) else ''})"
            for criterion, case, value in finding.unmet
        ],
        "criteria": [
            {
                "name": criterion.name,
                "says": criterion.description,
                "relation": criterion.relation,
                "threshold": criterion.threshold,
                "values": {case: finite(value) for case, value in values.items()},
                "met": {case: criterion.met(value) for case, value in values.items()},
                "close": {case: criterion.close(value) for case, value in values.items()},
            }
            for criterion in finding.statement.criteria
            if (values := finding.values.get(criterion.name))
        ],
        "details": {case: finite(value) for case, value in finding.details.items()},
    }


def _run_record(runs: Runs, name: str) -> dict[str, float]:
    """Return the largest estimate of a run's C on both scales [-], its seconds and its unknowns."""
    results = runs.done[name]
    estimate, weight = (
        max(
            float(np.max(line_shares))
            for body in results.scene.compared
            for line_shares in shares(
                measure_of(results, body), reference_of(results, body).estimate
            ).values()
        )
        for shares in (Measure.shares, Measure.weights)
    )
    return {
        "estimate": estimate,
        "weight": weight,
        "seconds": round(seconds_of(results.models), 1),
        "unknowns": max(cost.unknowns for cost in results.models.values()),
    }


def page_of(findings: Sequence[Finding], content: dict[str, Any]) -> Page:
    """Return the page of statements; `content` is the content of `validation.json`."""
    return Page(TITLE, summary(findings), _sections(findings, content))


def _sections(findings: Sequence[Finding], content: dict[str, Any]) -> Iterator[Section]:
    rows, sections = [], []
    for finding, entry in zip(findings, content["statements"], strict=True):
        anchor, colour = f"s{entry['number']}", VERDICT_COLOURS[finding.verdict]
        claim, verdict = Cell(entry["claim"], link=f"#{anchor}"), Cell(finding.verdict, colour=colour)
        rows.append(Row(str(entry["number"]), [claim, verdict]))
        heading = f"{entry['number']}. {finding.verdict}"
        sections.append(Section(heading, list(_statement_blocks(finding, entry)), colour, anchor))
    yield Section("", [RULES, Table("#", ["statement", "verdict"], rows, is_text=True)])
    yield from sections
    yield Section("Changes of the criteria", [_changes_table(content["changes"])])
    settings = (
        f"Tolerance of C: {content['tolerance']}; total time: {content['seconds']} s, without models that "
        f"were in the store. {record.version_text(content)}"
    )
    yield Section("The runs and their C", [_runs_table(content["runs"]), Note(settings)])


def _statement_blocks(finding: Finding, entry: dict[str, Any]) -> Iterator[Block]:
    """Yield claim, failures, figures and numbers of a statement."""
    yield entry["claim"]
    if entry["failed"]:
        yield entry["failed"]
    if entry["unmet"]:
        yield "Not met:"
        yield Items(entry["unmet"])
    yield from _pictures(finding)
    rows = [*_criteria_rows(entry["criteria"]), *_detail_rows(entry["details"])]
    columns = [*texts("case"), *number_heads("value"), *texts("threshold", "met")]
    yield Folded("Numbers", [Table("criterion", columns, rows)])


def _criteria_rows(criteria: Sequence[dict[str, Any]]) -> Iterator[Row]:
    for criterion in criteria:
        for number, (case, value) in enumerate(criterion["values"].items()):
            close = ", but too close to decide" if criterion["close"][case] else ""
            yield Row(
                "" if number else criterion["says"],
                [
                    case,
                    Cell(np.nan if value is None else value, ".4g"),
                    f"{criterion['relation']} {criterion['threshold']:.3g}",
                    ("yes" if criterion["met"][case] else "no") + close,
                ],
            )


def _detail_rows(details: dict[str, Any]) -> Iterator[Row]:
    for number, (case, value) in enumerate(details.items()):
        number_cell = Cell(np.nan if value is None else value, ".3g")
        yield Row("" if number else "further numbers", [case, number_cell, "", ""])


def _changes_table(changes: Sequence[dict[str, Any]]) -> Table:
    rows = [
        Row(str(change["number"]), [change["old"], change["verdict"] or "–", change["new"], change["why"]])
        for change in changes
    ]
    return Table("#", ["before", "verdict then", "now", "why"], rows, is_text=True)


def _runs_table(runs: dict[str, Any]) -> Table:
    columns = ["estimate of C", "of max |C_nn|", "seconds of its models", "unknowns of the largest"]
    rows = [
        Row(
            name,
            [
                Cell(run["estimate"], ".3%"),
                Cell(run["weight"], ".3%"),
                Cell(run["seconds"], "g"),
                Cell(run["unknowns"], ",d"),
            ],
        )
        for name, run in runs.items()
    ]
    return Table("run", columns, rows)


def _pictures(finding: Finding) -> Iterator[Chart | Picture]:
    if finding.failed:
        return
    name = f"statement{finding.statement.number}"
    if finding.panels:
        yield chart_of(f"{name}_curves", finding.panels, finding.statement.columns)
    yield Picture(f"{name}_numbers", figures.numbers(finding))
