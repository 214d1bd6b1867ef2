"""`femic extremes` runs all cases and writes `extremes.json` and `extremes.html`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import cycle, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from compare.report.charts import Curve, Panel, simple_chart
from compare.report.errors import orange
from compare.report.looks import FURTHER, INK, OWN
from compare.report.parts import Folded, Note, Page, Section
from compare.report.tables import Cell, Column, Row, Table, texts
from compare.report.tables import numbers as number_heads
from compare.validation.extremes import analytic, engines, friction, frictionless
from compare.validation.extremes.cases import (
    ANALYTIC,
    CONTACT,
    FRICTION,
    HARMONIC,
    SOLID,
    Entry,
    Limit,
    run_limits,
    summary,
)
from compare.validation.study import versions_text, write_study
from femic.reference.run_options import RunOptions

TITLE = "femic at its limits: range of each part, errors at the limits, and messages beyond them"
ERRORS = (
    "Analytic: the largest relative error of a component (for rotations: of an entry of the matrix), at "
    "the corners of the range and in cases drawn by hypothesis. Engines: the largest error of six "
    "components on three lines. On planes the comparison is with A, elsewhere with C from cells less than "
    "half as large in a domain more than twice as large. Errors and estimated errors of C are relative to "
    "the scale of refinement, the larger of max |C_ij| and 0.05 max |C_nn| on a line, to which the "
    "tolerance applies. Error/estimate is the largest ratio of the error of a component on a line to the "
    "estimated error of the same component and line. Contacts: the largest error of the numbers named "
    "with each case, compared with a closed form, with smaller elements or a finer C, or with the same "
    "contact in other units or mirrored. It is relative to the number itself, or to its largest possible "
    "value (work of friction, sliding, forces that vanish). Time: all models of a case, or a contact with "
    "its error estimates."
)
TOO_SMALL = orange(0.35)  # background of an error that is larger than its estimate, and of no refusal
COLOURED = [replace(look, dash="") for look in (*OWN.values(), *FURTHER) if look.colour != INK]
LOOKS = [  # of parameters; where there are more of these than colours, with markers of the next colours
    *COLOURED,
    *(replace(look, marker=other.marker) for look, other in pairwise(COLOURED)),
]

LIMITS: Mapping[str, Callable[[], list[Limit]]] = {
    ANALYTIC: analytic.limits,
    HARMONIC: engines.harmonic_limits,
    SOLID: engines.solid_limits,
    CONTACT: frictionless.limits,
    FRICTION: friction.limits,
}


def write_extremes(parts: Sequence[str], options: RunOptions, folder: Path) -> Path:
    """Run the cases of some parts and write the results; returns the path of the page."""
    limits = [limit for part in parts for limit in LIMITS[part]()]
    return write_study(folder, "extremes", as_content(list(run_limits(limits, options))), make_page)


def as_content(rows: Sequence[Entry]) -> dict[str, Any]:
    """Return the content of `extremes.json`."""
    seconds = sum(case["seconds"] for case in _cases(rows))
    return {"rows": rows, "summary": summary(rows), "digits": analytic.DIGITS, "seconds": round(seconds, 1)}


def make_page(content: dict[str, Any]) -> Page:
    """Return the page of `extremes.json`."""
    return Page(TITLE, content["summary"], _sections(content), _answer(content["rows"]))


def _by_part(rows: Sequence[Entry]) -> dict[str, list[Entry]]:
    parts: dict[str, list[Entry]] = {}
    for row in rows:
        parts.setdefault(row["engine"], []).append(row)
    return parts


def _cases(rows: Sequence[Entry]) -> list[Entry]:
    return [case for row in rows for case in row["reached"]]


# --- the answer -----------------------------------------------------------------------------------------


def _answer(rows: Sequence[Entry]) -> Table:
    """Return the worst of each part."""
    heads = ["tolerance", "largest error", "largest estimate", "largest error / estimated error"]
    table_rows = []
    for part, limits in _by_part(rows).items():
        tolerance = Cell(engines.TOLERANCE.get(part, np.nan), "g")
        table_rows.append(Row(part, [tolerance, *_worst(_cases(limits))]))
    return Table("part", number_heads(*heads, unit="1"), table_rows)


def _worst(cases: Sequence[Entry]) -> list[Cell]:
    """Return the cells of the largest error, estimate, and error over estimate of cases."""
    error, estimate, used = (
        max((case[key] for case in cases if case[key] is not None), default=np.nan)
        for key in ("error", "estimate", "used")
    )
    share = Cell(used, ".2f", "estimate too small", TOO_SMALL) if used > 1 else Cell(used, ".2f")
    return [Cell(error, ".2g"), Cell(estimate, ".2g"), share]


# --- what is behind it ----------------------------------------------------------------------------------


def _sections(content: dict[str, Any]) -> Iterator[Section | Folded]:
    rows = content["rows"]
    if estimated := [row for row in rows if any(case["used"] is not None for case in row["reached"])]:
        yield Section("", [simple_chart("errors", _panels(estimated), 1)])
    yield Section("Limits and the largest errors there", [_limits_table(rows)])
    yield Section("Beyond the limits", [_beyond_table(rows)])
    tables = [Section(part, [_cases_table(limits)]) for part, limits in _by_part(rows).items()]
    yield Folded("All cases within the limits, and how errors are measured", [Note(ERRORS), *tables])
    cost = f"All models and contacts took {content['seconds']} s. {versions_text(content)}"
    yield Folded("Cost and versions", [cost])


def _panels(rows: Sequence[Entry]) -> list[Panel]:
    """Return errors over their estimates, of C and of contacts apart.

    A mark per case: filled for the first part, open for another.
    """
    looks = dict(zip(dict.fromkeys(row["parameter"] for row in rows), cycle(LOOKS), strict=False))
    panels = []
    for are_contacts in (False, True):
        group = [row for row in rows if (row["engine"] in (CONTACT, FRICTION)) == are_contacts]
        kinds = dict(zip(_by_part(group), ("filled", "open"), strict=False))
        curves = []
        for row in group:
            look, cases = looks[row["parameter"]], [c for c in row["reached"] if c["used"] is not None]
            marker = look.marker + ("-open" if kinds[row["engine"]] == "open" else "")
            used, errors = ([case[key] for case in cases] for key in ("used", "error"))
            curves.append(Curve(row["parameter"], used, errors, replace(look, marker=marker)))
        marks = ", ".join(f"{kind}: {part}" for part, kind in kinds.items())
        title = f"{marks}; right of the dotted line the estimated error is too small"
        if group:
            axes = "error / estimated error [-]", "error [-]"
            panels.append(Panel(title, *axes, curves, log_y=True, marks=(1.0,)))
    return panels


SHARES = number_heads("error", "estimate", "error / estimate", unit="1")


def _limits_table(rows: Sequence[Entry]) -> Table:
    """Return the range of each parameter of each part, with the worst of its cases."""
    table_rows = [
        Row("" if position else part, [f"{limit['parameter']}", limit["range"], *_worst(limit["reached"])])
        for part, limits in _by_part(rows).items()
        for position, limit in enumerate(limits)
    ]
    return Table("part", [*texts("parameter", "range"), *SHARES], table_rows)


def _beyond_table(rows: Sequence[Entry]) -> Table:
    """Return the table of messages in cases beyond the limits, coloured where femic does not refuse."""
    table_rows = []
    for row in rows:
        for case in row["beyond"]:
            refused = case["says"] and not case["failed"]
            text = ("failed: " if case["failed"] else "") + (case["says"] or "nothing")
            message = Cell(text, colour="" if refused else TOO_SMALL)
            table_rows.append(Row(row["engine"], [row["parameter"], case["at"], message]))
    return Table("part", ["parameter", "case", "message of femic"], table_rows, is_text=True)


def _cases_table(limits: Sequence[Entry]) -> Table:
    """Return all cases within the limits of a part."""
    rows = []
    for limit in limits:
        for position, case in enumerate(limit["reached"]):
            note = f"; {case['note']}" if case["note"] else ""
            time = Cell(case["seconds"], ".2g")
            cells = [f"{case['at']}{note}", *_worst([case]), case["exact"], time]
            rows.append(Row("" if position else f"{limit['parameter']}, {limit['range']}", cells))
    columns = [*texts("case"), *SHARES, *texts("against"), Column("time", "s")]
    return Table("parameter", columns, rows)
