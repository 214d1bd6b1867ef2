"""`femic validate` assesses statements one by one and writes the results as JSON and as a page.

Statements 1 to 13, 16 to 21 and 26 to 41 are from [BVSV], all others are on this program. Thresholds were set
before the first run and have not been changed since; `changes` lists the changes of claims and criteria.
Errors are shares of the component itself (docs/theory/errors.md) on the lines of the scenes. Where scenes are
compared, curves are dimensionless.

`validation.json` has the statements with their numbers, the runs, and changes of criteria.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from operator import attrgetter
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from compare.report.charts import Panel, simple_chart
from compare.report.errors import orange
from compare.report.parts import Block, Folded, Note, Page, Section, range_text
from compare.report.tables import Cell, Column, Row, Table, texts
from compare.report.tables import numbers as number_heads
from compare.report.verdicts import NOT_DECIDED
from compare.validation.statements import (
    changed_operators,
    closed_forms,
    components_and_moduli,
    coupling_components,
    direct_components,
    engines_and_limits,
    finite_elements,
    normal_contacts,
    random_contacts,
    rolling_and_compression,
    wheels,
)
from compare.validation.statements.changes import CHANGES
from compare.validation.statements.frame import (
    DEPENDS,
    NOT_REPRODUCED,
    REPRODUCED,
    Statement,
    estimated_error,
    find_verdict,
)
from compare.validation.statements.runs import Runs
from compare.validation.study import versions_text, write_study
from femic.cache import folders
from femic.ic_errors.error_measure import Measure
from femic.results.ics import ics_measure, reference_ics, solver_seconds
from femic.results.ics_dataset import finite
from femic.scenes.load import in_keys
from geometries.errors import Failure, WrongInput

GROUPS = (
    *(direct_components, coupling_components, engines_and_limits, finite_elements, normal_contacts),
    *(rolling_and_compression, components_and_moduli),
    *(changed_operators, closed_forms, random_contacts, wheels),
)
STATEMENTS: Mapping[int, Statement] = {
    statement.number: statement
    for statement in sorted((each for group in GROUPS for each in group.STATEMENTS), key=attrgetter("number"))
}
SOURCE = frozenset((*range(1, 14), *range(16, 22), *range(26, 42)))  # numbers of statements from [BVSV]

# --- validation.json ------------------------------------------------------------------------------------


Entry = dict[str, Any]  # a statement, or a criterion of one, as in validation.json


def select_statements(only: Iterable[int] | None) -> tuple[int, ...]:
    """Return the numbers of the selected statements, by default all; raises WrongInput for unknown ones."""
    numbers = tuple(dict.fromkeys(only)) if only is not None else tuple(STATEMENTS)
    unknown = [number for number in numbers if number not in STATEMENTS]
    if unknown or not numbers:
        raise WrongInput(f"--only {' '.join(map(str, unknown)) or '?'}: give some of 1 to {max(STATEMENTS)}")
    return numbers


def assess(number: int, runs: Runs) -> tuple[Entry, Sequence[Panel]]:
    """Measure the numbers of a statement and decide it; it is not decided if C cannot be computed."""
    statement = STATEMENTS[number]
    try:
        values = {criterion.name: criterion.measure(runs) for criterion in statement.criteria}
        panels, details = list(statement.panels(runs)), statement.details(runs)
    except Failure as error:
        return as_entry(statement, {}, failed=in_keys(error)), ()
    return as_entry(statement, values, details), panels


def as_entry(
    statement: Statement,
    values: Mapping[str, Mapping[str, float]],
    details: Mapping[str, float] | None = None,
    failed: str = "",
) -> Entry:
    """Return a statement with its verdict and its numbers: by criterion and case, and further ones.

    `failed` says why nothing could be measured.
    """
    criteria = [
        (criterion, measured) for criterion in statement.criteria if (measured := values.get(criterion.name))
    ]
    return {
        "number": statement.number,
        "claim": statement.claim,
        "verdict": find_verdict(statement, values),
        "failed": failed,
        "unmet": [
            f"{criterion.description}: {case}: {value:.4g} (not {criterion.relation} "
            f"{criterion.threshold:.3g}{'; not decided' if criterion.close(value) else ''})"
            for criterion, measured in criteria
            for case, value in measured.items()
            if not criterion.met(value)
        ],
        "criteria": [
            {
                "name": criterion.name,
                "says": criterion.description,
                "relation": criterion.relation,
                "threshold": criterion.threshold,
                "values": {case: finite(value) for case, value in measured.items()},
                "estimates": {case: finite(estimated_error(value)) for case, value in measured.items()},
                "met": {case: criterion.met(value) for case, value in measured.items()},
                "close": {case: criterion.close(value) for case, value in measured.items()},
            }
            for criterion, measured in criteria
        ],
        "details": {case: finite(value) for case, value in (details or {}).items()},
    }


def run_entries(runs: Runs) -> Mapping[str, Entry]:
    """Return the largest estimate of each run's C on both scales [-], its seconds and its unknowns."""
    entries = {}
    for name, results in runs.done.items():
        estimate, weight = (
            max(
                float(np.max(shares))
                for body in results.scene.compared
                for shares in of(ics_measure(results, body), reference_ics(results, body).estimate).values()
            )
            for of in (Measure.shares, Measure.weights)
        )
        entries[name] = {
            "estimate": estimate,
            "weight": weight,
            "seconds": round(solver_seconds(results.models), 1),
            "unknowns": max(cost.unknowns for cost in results.models.values()),
        }
    return entries


def validate(numbers: Sequence[int], runs: Runs, folder: Path) -> Path:
    """Assess statements; write `validation.json`, figures and `validation.html`; return the page's path."""
    folders.make(folder)
    start, entries, panels = perf_counter(), [], {}
    for number in numbers:
        runs.options.watch.on_stage(f"statement {number}")
        entry, panels[number] = assess(number, runs)
        entries.append(entry)
        runs.options.watch.on_stage(f"statement {number}: {entry['verdict']}")
    runs.options.watch.on_stage("  figures and report")
    content = {
        "statements": entries,
        "runs": run_entries(runs),
        "changes": CHANGES,
        "tolerance": runs.tolerance,
        "seconds": round(perf_counter() - start, 1),
    }
    return write_study(folder, "validation", content, partial(make_page, panels))


# --- the page -------------------------------------------------------------------------------------------


TITLE = "Validation of femic: statements about influence coefficients, and whether they hold"
RULES = (
    "femic computes numbers for each statement and compares them with thresholds that were fixed before "
    "the first run (changes are listed below). “Reproduced”: every criterion is met in every case. “Not "
    "reproduced”: no criterion is met in any case. Otherwise the verdict is “depends”, and the failures "
    "are listed. A case does not count if its number differs from the threshold by less than its "
    "estimated error, or by less than 0.2 % of the threshold. A statement of which a criterion has more such "
    "cases than others is “not decided”, unless it depends anyway. Errors: max |v − C| over a line, "
    "relative to max |C_ij| over all lines at four or more elements from the load; where a component "
    "vanishes, relative to 0.05 max |C_nn|."
)
READING = (
    "Convex: the lower body. Concave: the upper body. A component names the displacement, then the "
    "traction: sn is the displacement along s under a normal load. The curves are dimensionless, with the "
    "reference length L and the reference modulus E of the scene. The band about C is its estimated "
    "error, often thinner than the line."
)
COLOURS = {  # backgrounds, translucent for light and for dark pages: blue, yellow, orange, grey
    REPRODUCED: "rgba(0, 114, 178, 0.28)",
    DEPENDS: "rgba(240, 228, 66, 0.3)",
    NOT_REPRODUCED: orange(0.35),
    NOT_DECIDED: "rgba(128, 128, 128, 0.3)",
}
IN_CASES = {
    REPRODUCED: "reproduced in every case",
    DEPENDS: "in some cases only",
    NOT_REPRODUCED: "in no case",
    NOT_DECIDED: NOT_DECIDED,
}
MOST_UNMET = 3  # cases that are listed beside a criterion
HEIGHT = 0.85  # of panels, over the standard


def make_page(panels: Mapping[int, Sequence[Panel]], content: dict[str, Any]) -> Page:
    """Return the page of `validation.json`, with panels by the numbers of statements."""
    entries = content["statements"]
    return Page(TITLE, summary(entries), _sections(panels, content), _answer(entries))


# --- the answer -----------------------------------------------------------------------------------------


def summary(entries: Sequence[Entry]) -> str:
    """Return how many statements have each verdict, and how many numbers meet their criteria."""
    sentences = []
    for subject, chosen in _by_subject(entries).items():
        counts = Counter(entry["verdict"] for entry in chosen)
        listed = (f"{counts[verdict]} {how}" for verdict, how in IN_CASES.items() if counts[verdict])
        sentences.append(f"Statements {subject} ({len(chosen)}): {', '.join(listed)}.")
    count, met, close = (sum(_count(entry, key) for entry in entries) for key in ("values", "met", "close"))
    undecided = f"; not decided: {close}" if close else ""
    return " ".join([*sentences, f"Numbers that meet their criteria: {met} of {count}{undecided}."])


def _by_subject(entries: Sequence[Entry]) -> dict[str, list[Entry]]:
    """Return the statements of the source and those on this program, as far as there are any."""
    subjects: dict[str, list[Entry]] = {}
    for entry in entries:
        subject = "from the source [BVSV]" if entry["number"] in SOURCE else "on this program"
        subjects.setdefault(subject, []).append(entry)
    return subjects


def _count(entry: Entry, key: str) -> int:
    """Return in how many cases of all criteria a number is known ("values"), met or close."""
    flags = [flag for criterion in entry["criteria"] for flag in criterion[key].values()]
    return len(flags) if key == "values" else sum(flags)


def _answer(entries: Sequence[Entry]) -> Table:
    """Return the numbers of the statements by verdict and subject."""
    subjects = _by_subject(entries)
    rows = []
    for verdict, colour in COLOURS.items():
        chosen = [
            [str(entry["number"]) for entry in listed if entry["verdict"] == verdict]
            for listed in subjects.values()
        ]
        if verdict != NOT_DECIDED or any(chosen):
            cells = [
                Cell(f"{len(some)}: {', '.join(some)}", colour=colour) if some else Cell("none")
                for some in chosen
            ]
            rows.append(Row(verdict, cells))
    return Table("statements", texts(*subjects), rows)


# --- what is behind it ----------------------------------------------------------------------------------


def _sections(panels: Mapping[int, Sequence[Panel]], content: dict[str, Any]) -> Iterator[Section | Folded]:
    entries = content["statements"]
    columns: list[Column | str] = [*texts("statement"), "verdict", "criteria met"]
    rows = [
        Row(
            str(entry["number"]),
            [
                Cell(entry["claim"], link=f"#s{entry['number']}"),
                Cell(entry["verdict"], colour=COLOURS[entry["verdict"]]),
                f"{_count(entry, 'met')} of {_count(entry, 'values')}",
            ],
        )
        for entry in entries
    ]
    yield Section("", [Table("#", columns, rows), Note(READING)])
    rows = [
        Row(str(change["number"]), [change["old"], change["verdict"] or "–", change["new"], change["why"]])
        for change in content["changes"]
    ]
    changes = Table("#", ["before", "verdict then", "now", "why"], rows, is_text=True)
    yield Folded("How the verdicts are reached", [RULES, Section("Changes of the criteria", [changes])])
    for entry in entries:
        number, verdict = entry["number"], entry["verdict"]
        blocks = list(_statement_blocks(entry, panels[number]))
        yield Section(f"{number}. {verdict}", blocks, COLOURS[verdict], f"s{number}")
    heads = [
        Column("estimated error of C", "%"),
        Column("relative to max |C_nn|", "%"),
        Column("time of its models", "s"),
    ]
    heads.append(Column("unknowns of the largest model"))
    formats = {"estimate": ".2g", "weight": ".2g", "seconds": ".0f", "unknowns": ",d"}
    percent = {"estimate": 100, "weight": 100}
    rows = [
        Row(name, [Cell(percent.get(key, 1) * run[key], form) for key, form in formats.items()])
        for name, run in content["runs"].items()
    ]
    settings = (
        f"Tolerance of C: {content['tolerance']}; total time: {content['seconds']} s, excluding stored "
        f"models. {versions_text(content)}"
    )
    yield Folded("The runs and their C", [Table("run", heads, rows), Note(settings)])


def _statement_blocks(entry: Entry, panels: Sequence[Panel]) -> Iterator[Block]:
    """Yield claim, criteria, curves and numbers of a statement, or why nothing could be measured."""
    yield entry["claim"]
    if entry["failed"]:
        yield entry["failed"]
        return
    yield _criteria_table(entry["criteria"])
    if panels:
        number = entry["number"]
        yield simple_chart(f"statement{number}_curves", panels, STATEMENTS[number].columns, HEIGHT)
    yield Folded("All numbers", [_numbers_table(entry)])


def _criteria_table(criteria: Sequence[Entry]) -> Table:
    """Return how many cases meet each criterion, the range of its numbers, and where it is not met.

    Cases furthest from the threshold come first, and those whose number is unknown before them.
    """
    rows = []
    for criterion in criteria:
        met, threshold = criterion["met"], criterion["threshold"]
        values = {case: _number(value) for case, value in criterion["values"].items()}
        fulfilled = sum(met.values())
        verdict = REPRODUCED if fulfilled == len(met) else DEPENDS if fulfilled else NOT_REPRODUCED
        apart = {
            case: np.nan_to_num(abs(value - threshold), nan=np.inf)
            for case, value in values.items()
            if not met[case]
        }
        unmet = [
            f"{case}: {Cell(values[case], '.3g').text}{_close(criterion, case)}"
            for case in sorted(apart, key=apart.__getitem__)[::-1]
        ]
        further = [f"{len(unmet) - MOST_UNMET} more"] if len(unmet) > MOST_UNMET else []
        cells: list[Cell | str] = [
            f"{criterion['relation']} {threshold:.3g}",
            Cell(f"{fulfilled} of {len(met)}", colour=COLOURS[verdict]),
            "–" if np.all(np.isnan(list(values.values()))) else range_text(list(values.values()), ".3g"),
            "; ".join([*unmet[:MOST_UNMET], *further]),
        ]
        rows.append(Row(criterion["says"], cells))
    columns = [*number_heads("must be", "met", "numbers"), *texts("not met, largest deviation first")]
    if all(all(criterion["met"].values()) for criterion in criteria):
        columns, rows = columns[:-1], [Row(row.name, row.cells[:-1]) for row in rows]
    return Table("criterion", columns, rows)


def _number(value: float | None) -> float:
    return np.nan if value is None else float(value)


def _close(criterion: Entry, case: str) -> str:
    return " (not decided)" if criterion["close"][case] else ""


def _numbers_table(entry: Entry) -> Table:
    """Return the numbers of all criteria by case, and further numbers."""
    rows = []
    for criterion in entry["criteria"]:
        must_be = f"{criterion['relation']} {criterion['threshold']:.3g}"
        for position, (case, met) in enumerate(criterion["met"].items()):
            colour = "" if met else COLOURS[NOT_REPRODUCED]
            known = criterion["estimates"][case]
            cells: list[Cell | str] = [
                case,
                Cell(_number(criterion["values"][case]), ".4g", colour=colour),
                Cell(np.inf if known is None else known, ".2g") if known != 0 else Cell(""),
                must_be,
                ("yes" if met else "no") + _close(criterion, case),
            ]
            rows.append(Row("" if position else criterion["says"], cells))
    for position, (case, value) in enumerate(entry["details"].items()):
        number = Cell(_number(value), ".3g")
        rows.append(Row("" if position else "further numbers", [case, number, "", "", ""]))
    columns = [*texts("case"), *number_heads("value", "estimated error ±", "must be", "met")]
    return Table("criterion", columns, rows)
