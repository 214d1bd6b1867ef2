"""`femic validate` assesses statements one by one and writes the results as JSON and as a page.

The verdict of a statement follows from which criteria are met in which cases. `validation.json` has the
statements with their numbers, the runs, and changes of criteria.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from compare.report.charts import Panel, chart_of
from compare.report.errors import red
from compare.report.parts import Block, Folded, Note, Page, Section, range_text
from compare.report.tables import Cell, Column, Row, Table, texts
from compare.report.tables import numbers as number_heads
from compare.validation import study as record
from compare.validation.statements import registry
from compare.validation.statements.changes import CHANGES
from compare.validation.statements.contact_series import estimate_of
from compare.validation.statements.criteria import Criterion, Statement
from compare.validation.statements.registry import STATEMENTS
from compare.validation.statements.runs import Runs
from femic.cache import folders
from femic.ic_errors.error_measure import Measure
from femic.results.ics import measure_of, reference_of, seconds_of
from femic.results.ics_dataset import finite
from femic.scenes.load import in_keys
from geometries.errors import Failure, WrongInput

# --- verdicts -------------------------------------------------------------------------------------------


REPRODUCED, NOT_REPRODUCED, DEPENDS = "reproduced", "not reproduced", "depends"
NOT_DECIDED = "not decided"


@dataclass(frozen=True)
class Finding:
    """A statement with its numbers by criterion and case, panels and further numbers, and its verdict."""

    statement: Statement
    values: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    panels: Sequence[Panel] = ()
    details: Mapping[str, float] = field(default_factory=dict)
    failed: str = ""  # why nothing could be measured

    @property
    def verdict(self) -> str:
        """Reproduced if every criterion is met in every case, not reproduced if none is met in any case.

        Otherwise it depends. Cases whose numbers are too close to the threshold to tell do not count; a
        statement of which nothing, or no case of some criterion, can be told is not decided, unless it
        depends anyway.
        """
        told = {
            name: [criterion.met(value) for criterion, _, value in self.decided if criterion.name == name]
            for name in self.values
        }
        met = [is_met for by_case in told.values() for is_met in by_case]
        if any(met) and not all(met):
            return DEPENDS
        if self.failed or not all(told.values()):
            return NOT_DECIDED
        return REPRODUCED if all(met) else NOT_REPRODUCED

    @property
    def numbers(self) -> Iterator[tuple[Criterion, str, float]]:
        """Each criterion with each of its cases and values; empty if nothing could be measured."""
        for criterion in self.statement.criteria:
            for case, value in self.values.get(criterion.name, {}).items():
                yield criterion, case, value

    @property
    def decided(self) -> list[tuple[Criterion, str, float]]:
        """The criteria, cases and values that are not too close to the threshold to tell."""
        return [
            (criterion, case, value) for criterion, case, value in self.numbers if not criterion.close(value)
        ]

    @property
    def unmet(self) -> list[tuple[Criterion, str, float]]:
        """The criteria, cases and values that are not met, those too close to tell included."""
        return [
            (criterion, case, value) for criterion, case, value in self.numbers if not criterion.met(value)
        ]


def assess(number: int, runs: Runs) -> Finding:
    """Measure the numbers of a statement and decide it; it is not decided if C cannot be computed."""
    statement = STATEMENTS[number]
    try:
        values = {criterion.name: criterion.measure(runs) for criterion in statement.criteria}
        return Finding(statement, values, statement.panels(runs), statement.details(runs))
    except Failure as error:
        return Finding(statement, failed=in_keys(error))


def selection(only: Iterable[int] | None) -> tuple[int, ...]:
    """Return the numbers of the selected statements, by default all; raises WrongInput for unknown ones."""
    numbers = tuple(dict.fromkeys(only)) if only is not None else tuple(STATEMENTS)
    unknown = [number for number in numbers if number not in STATEMENTS]
    if unknown or not numbers:
        raise WrongInput(f"--only {' '.join(map(str, unknown)) or '?'}: give some of 1 to {max(STATEMENTS)}")
    return numbers


# --- validation.json ------------------------------------------------------------------------------------


def content_of(findings: Sequence[Finding], runs: Runs, seconds: float) -> dict[str, Any]:
    """Return the content of `validation.json`; `seconds` is the time of all statements together."""
    return {
        "statements": [entry(finding) for finding in findings],
        "runs": {name: _run_record(runs, name) for name in runs.done},
        "changes": [asdict(change) for change in CHANGES],
        "tolerance": runs.tolerance,
        "seconds": round(seconds, 1),
    }


def entry(finding: Finding) -> dict[str, Any]:
    """Return a statement with its verdict and its numbers."""
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
                "estimates": {case: finite(estimate_of(value)) for case, value in values.items()},
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


# --- the page -------------------------------------------------------------------------------------------


TITLE = "femic: statements on these influence coefficients, and their verdicts"
RULES = (
    "Each statement is decided by numbers that femic computes and by thresholds that were fixed in its code "
    "before the first run (changes are listed below). “Reproduced”: every criterion is met in every case; "
    "“not reproduced”: no criterion is met in any case; otherwise it “depends”, and the failures are listed. "
    "Cases whose numbers are closer to a threshold than what they are known to do not count. "
    "Errors: max |v − C| over a line as a share of max |C_ij| over all lines, four elements from the load "
    "and further; where a component vanishes, of 0.05 max |C_nn|."
)
READING = (
    "Convex: the lower body; concave: the upper. Components: displacement, then traction, such as sn: the "
    "displacement along s under a normal load. Curves are dimensionless: L is the reference length of the "
    "scene, E its reference modulus; the band about C is its estimated error, often thinner than "
    "the line."
)
COLOURS = {  # backgrounds, translucent for light and for dark pages
    REPRODUCED: "rgba(40, 170, 70, 0.25)",
    DEPENDS: "rgba(240, 170, 0, 0.3)",
    NOT_REPRODUCED: red(0.3),
    NOT_DECIDED: "rgba(128, 128, 128, 0.3)",
}
IN_CASES = {
    REPRODUCED: "reproduced in every case",
    DEPENDS: "in some cases only",
    NOT_REPRODUCED: "in no case",
    NOT_DECIDED: "not decided",
}
ON_PROGRAM = frozenset(statement.number for group in registry.ON_PROGRAM for statement in group.STATEMENTS)
MOST_UNMET = 3  # cases that are listed beside a criterion
HEIGHT = 0.85  # of panels, over the standard

Entry = dict[str, Any]  # a statement, or a criterion of one, as in validation.json


def validate(numbers: Sequence[int], runs: Runs, folder: Path) -> Path:
    """Assess statements; write `validation.json`, figures and `validation.html`; return the page's path."""
    folders.make(folder)
    start, findings = perf_counter(), []
    for number in numbers:
        runs.options.watch.on_stage(f"statement {number}")
        findings.append(assess(number, runs))
        runs.options.watch.on_stage(f"statement {number}: {findings[-1].verdict}")
    runs.options.watch.on_stage("  figures and report")
    content = content_of(findings, runs, perf_counter() - start)
    return record.write(folder, "validation", content, partial(page_of, findings))


def page_of(findings: Sequence[Finding], content: dict[str, Any]) -> Page:
    """Return the page of statements; `content` is the content of `validation.json`."""
    entries = content["statements"]
    return Page(TITLE, summary(entries), _sections(findings, content), _answer(entries))


# --- the answer -----------------------------------------------------------------------------------------


def summary(entries: Sequence[Entry]) -> str:
    """Return how many statements have each verdict, and how many numbers meet their criteria."""
    sentences = [_verdicts_text(subject, chosen) for subject, chosen in _by_subject(entries).items()]
    count, met, close = (sum(_count(entry, key) for entry in entries) for key in ("values", "met", "close"))
    undecided = f"; too close to a threshold to tell: {close}" if close else ""
    return " ".join([*sentences, f"Numbers that meet their criteria: {met} of {count}{undecided}."])


def _by_subject(entries: Sequence[Entry]) -> dict[str, list[Entry]]:
    """Return the statements of the source and those on this program, as far as there are any."""
    subjects: dict[str, list[Entry]] = {}
    for entry in entries:
        subject = "on this program" if entry["number"] in ON_PROGRAM else "from the source [BVSV]"
        subjects.setdefault(subject, []).append(entry)
    return subjects


def _verdicts_text(subject: str, entries: Sequence[Entry]) -> str:
    counts = Counter(entry["verdict"] for entry in entries)
    listed = (f"{counts[verdict]} {how}" for verdict, how in IN_CASES.items() if counts[verdict])
    return f"Statements {subject} ({len(entries)}): {', '.join(listed)}."


def _count(entry: Entry, key: str) -> int:
    """Return in how many cases of all criteria a number is known ("values"), met or close."""
    flags = [flag for criterion in entry["criteria"] for flag in criterion[key].values()]
    return len(flags) if key == "values" else sum(flags)


def _answer(entries: Sequence[Entry]) -> Table:
    """Return the numbers of the statements by verdict and subject."""
    subjects = _by_subject(entries)
    rows = [
        Row(verdict, [_numbers_cell(chosen, verdict) for chosen in subjects.values()])
        for verdict in COLOURS
        if verdict != NOT_DECIDED or any(entry["verdict"] == verdict for entry in entries)
    ]
    return Table("statements", texts(*subjects), rows)


def _numbers_cell(entries: Sequence[Entry], verdict: str) -> Cell:
    chosen = [str(entry["number"]) for entry in entries if entry["verdict"] == verdict]
    return Cell(f"{len(chosen)}: {', '.join(chosen)}", colour=COLOURS[verdict]) if chosen else Cell("none")


# --- what is behind it ----------------------------------------------------------------------------------


def _sections(findings: Sequence[Finding], content: dict[str, Any]) -> Iterator[Section | Folded]:
    yield Section("", [_verdicts_table(content["statements"]), Note(READING)])
    changes = Section("Changes of the criteria", [_changes_table(content["changes"])])
    yield Folded("How the verdicts come about", [RULES, changes])
    for finding, entry in zip(findings, content["statements"], strict=True):
        heading, colour = f"{entry['number']}. {finding.verdict}", COLOURS[finding.verdict]
        yield Section(heading, list(_statement_blocks(finding, entry)), colour, _anchor(entry))
    settings = (
        f"Tolerance of C: {content['tolerance']}; total time: {content['seconds']} s, without models that "
        f"were in the store. {record.version_text(content)}"
    )
    yield Folded("The runs and their C", [_runs_table(content["runs"]), Note(settings)])


def _anchor(entry: Entry) -> str:
    return f"s{entry['number']}"


def _verdicts_table(entries: Sequence[Entry]) -> Table:
    """Return the verdict of each statement, with a link to it, and how many of its numbers meet criteria."""
    rows = [
        Row(
            str(entry["number"]),
            [
                Cell(entry["claim"], link=f"#{_anchor(entry)}"),
                Cell(entry["verdict"], colour=COLOURS[entry["verdict"]]),
                f"{_count(entry, 'met')} of {_count(entry, 'values')}",
            ],
        )
        for entry in entries
    ]
    return Table("#", [*texts("statement"), "verdict", "criteria met"], rows)


def _statement_blocks(finding: Finding, entry: Entry) -> Iterator[Block]:
    """Yield claim, criteria, curves and numbers of a statement, or why nothing could be measured."""
    yield entry["claim"]
    if entry["failed"]:
        yield entry["failed"]
        return
    yield _criteria_table(entry["criteria"])
    if finding.panels:
        name = f"statement{finding.statement.number}_curves"
        yield chart_of(name, finding.panels, finding.statement.columns, HEIGHT)
    rows = [*_number_rows(entry["criteria"]), *_detail_rows(entry["details"])]
    columns = [*texts("case"), *number_heads("value", "known to ±", "must be", "met")]
    yield Folded("All numbers", [Table("criterion", columns, rows)])


def _criteria_table(criteria: Sequence[Entry]) -> Table:
    """Return how many cases meet each criterion, the range of its numbers, and where it is not met."""
    rows = [
        Row(
            criterion["says"],
            [_threshold(criterion), _met_cell(criterion), _range(criterion), _unmet_text(criterion)],
        )
        for criterion in criteria
    ]
    columns = [*number_heads("must be", "met", "numbers"), *texts("not met, worst first")]
    if all(all(criterion["met"].values()) for criterion in criteria):
        columns, rows = columns[:-1], [Row(row.name, row.cells[:-1]) for row in rows]
    return Table("criterion", columns, rows)


def _threshold(criterion: Entry) -> str:
    return f"{criterion['relation']} {criterion['threshold']:.3g}"


def _met_cell(criterion: Entry) -> Cell:
    met, count = sum(criterion["met"].values()), len(criterion["met"])
    verdict = REPRODUCED if met == count else DEPENDS if met else NOT_REPRODUCED
    return Cell(f"{met} of {count}", colour=COLOURS[verdict])


def _range(criterion: Entry) -> str:
    known = [value for value in criterion["values"].values() if value is not None]
    return range_text(known, ".3g") if known else "–"


def _unmet_text(criterion: Entry) -> str:
    """Return the cases in which a criterion is not met, those furthest from the threshold first."""
    unmet = sorted(
        (case for case, met in criterion["met"].items() if not met), key=partial(_distance, criterion)
    )[::-1]
    listed = [
        f"{case}: {Cell(_number(criterion, case), '.3g').text}{_close(criterion, case)}" for case in unmet
    ]
    further = [f"{len(unmet) - MOST_UNMET} more"] if len(unmet) > MOST_UNMET else []
    return "; ".join([*listed[:MOST_UNMET], *further])


def _distance(criterion: Entry, case: str) -> float:
    """Return how far a number is from its threshold; infinity where it is unknown."""
    value = criterion["values"][case]
    return np.inf if value is None else abs(value - criterion["threshold"])


def _number(criterion: Entry, case: str) -> float:
    value = criterion["values"][case]
    return np.nan if value is None else float(value)


def _close(criterion: Entry, case: str) -> str:
    return " (too close to tell)" if criterion["close"][case] else ""


def _number_rows(criteria: Sequence[Entry]) -> Iterator[Row]:
    for criterion in criteria:
        for position, (case, met) in enumerate(criterion["met"].items()):
            value = Cell(_number(criterion, case), ".4g", colour="" if met else COLOURS[NOT_REPRODUCED])
            met_text = ("yes" if met else "no") + _close(criterion, case)
            cells = [case, value, _known_to(criterion, case), _threshold(criterion), met_text]
            yield Row("" if position else criterion["says"], cells)


def _known_to(criterion: Entry, case: str) -> Cell:
    estimate = criterion["estimates"][case]
    return Cell(np.inf if estimate is None else estimate, ".2g") if estimate != 0 else Cell("")


def _detail_rows(details: dict[str, Any]) -> Iterator[Row]:
    for position, (case, value) in enumerate(details.items()):
        number_cell = Cell(np.nan if value is None else value, ".3g")
        yield Row("" if position else "further numbers", [case, number_cell, "", "", ""])


def _changes_table(changes: Sequence[Entry]) -> Table:
    rows = [
        Row(str(change["number"]), [change["old"], change["verdict"] or "–", change["new"], change["why"]])
        for change in changes
    ]
    return Table("#", ["before", "verdict then", "now", "why"], rows, is_text=True)


def _runs_table(runs: dict[str, Any]) -> Table:
    columns = [
        Column("estimate of C", "%"),
        Column("of max |C_nn|", "%"),
        Column("its models", "s"),
        Column("unknowns of the largest"),
    ]
    rows = [
        Row(
            name,
            [
                Cell(100 * run["estimate"], ".2g"),
                Cell(100 * run["weight"], ".2g"),
                Cell(run["seconds"], ".0f"),
                Cell(run["unknowns"], ",d"),
            ],
        )
        for name, run in runs.items()
    ]
    return Table("run", columns, rows)
