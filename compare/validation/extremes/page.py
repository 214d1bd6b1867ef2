"""`femic extremes` runs all cases and writes `extremes.json` and `extremes.html`."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import cycle, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from compare.report.charts import Curve, Panel, chart_of
from compare.report.errors import red
from compare.report.looks import FURTHER, INK, OWN, Look
from compare.report.parts import Folded, Note, Page, Section
from compare.report.tables import Cell, Column, Row, Table, texts
from compare.report.tables import numbers as number_heads
from compare.validation import study as record
from compare.validation.extremes import compute
from compare.validation.extremes.cases import CONTACT, FRICTION
from compare.validation.extremes.engines import ENGINE_TOLERANCE, Engines

TITLE = "femic at its limits: range of each part, errors at the limits, messages beyond them"
ERRORS = (
    "Analytic: the largest relative error of a component (of rotations: of an entry of the matrix), corners "
    "of the range and cases drawn by hypothesis. Engines: the largest error of six components on three "
    "lines, on planes against A, elsewhere against C from cells less than half as large in a domain more "
    "than twice as large; errors and estimates of C are shares of the scale of refinement, the larger of max "
    "|C_ij| and 0.05 max |C_nn| on a line, which the tolerance is for. An error may be smaller than another "
    "component's estimate and larger than its own: error over estimate is the largest of a component on a "
    "line over its own. Contacts: the largest error of their numbers, named with each case, against a closed "
    "form, against smaller elements or a finer C, or against the same contact in other units or mirrored; "
    "shares of each number, or of the largest possible (work of friction, sliding, forces that vanish). "
    "Time: of all models of a case, of a contact with its estimates."
)
OF_CONTACT = (CONTACT, FRICTION)
TOO_SMALL = red(0.3)  # background of an error that is larger than its estimate, and of no refusal
COLOURED = [replace(look, dash="") for look in (*OWN.values(), *FURTHER) if look.colour != INK]
LOOKS = [  # of parameters; where there are more of these than colours, with markers of the next colours
    *COLOURED,
    *(replace(look, marker=other.marker) for look, other in pairwise(COLOURED)),
]

Entry = dict[str, Any]  # a limit of a part, or a case, as in extremes.json


def write_extremes(parts: Sequence[str], engines: Engines, folder: Path) -> Path:
    """Run the cases of some parts and write the results; returns the path of the page."""
    content = compute.numbers(compute.compute(parts, engines))
    return record.write(folder, "extremes", content, page_of)


def page_of(content: dict[str, Any]) -> Page:
    """Return the page; `content` is the content of `extremes.json`."""
    return Page(TITLE, content["summary"], _sections(content), _answer(content["rows"]))


def _by_part(rows: Sequence[Entry]) -> dict[str, list[Entry]]:
    parts: dict[str, list[Entry]] = {}
    for row in rows:
        parts.setdefault(row["engine"], []).append(row)
    return parts


def _cases(rows: Sequence[Entry]) -> list[Entry]:
    return [case for row in rows for case in row["reached"]]


def _largest(cases: Sequence[Entry], key: str) -> float:
    """Return the largest number of cases, NaN without any."""
    return max((case[key] for case in cases if case[key] is not None), default=np.nan)


# --- the answer -----------------------------------------------------------------------------------------


def _answer(rows: Sequence[Entry]) -> Table:
    """Return the worst of each part."""
    heads = ["tolerance", "largest error", "largest estimate", "largest error over estimate"]
    table_rows = [
        Row(part, [_tolerance(part), *_worst(_cases(limits))]) for part, limits in _by_part(rows).items()
    ]
    return Table("part", number_heads(*heads, unit="1"), table_rows)


def _tolerance(part: str) -> Cell:
    return Cell(ENGINE_TOLERANCE.get(part, np.nan), "g")


def _worst(cases: Sequence[Entry]) -> list[Cell]:
    """Return the cells of the largest error, estimate, and error over estimate of cases."""
    return _number_cells(*(_largest(cases, key) for key in ("error", "estimate", "used")))


def _number_cells(error: float, estimate: float, used: float) -> list[Cell]:
    colour = TOO_SMALL if used > 1 else ""
    return [Cell(error, ".2g"), Cell(estimate, ".2g"), Cell(used, ".2f", colour=colour)]


# --- what is behind it ----------------------------------------------------------------------------------


def _sections(content: dict[str, Any]) -> Iterator[Section | Folded]:
    rows = content["rows"]
    if estimated := [row for row in rows if any(case["used"] is not None for case in row["reached"])]:
        yield Section("", [chart_of("errors", _panels(estimated), 1)])
    yield Section("Limits and the largest errors there", [_limits_table(rows)])
    yield Section("Beyond the limits", [_beyond_table(rows)])
    tables = [Section(part, [_cases_table(limits)]) for part, limits in _by_part(rows).items()]
    yield Folded("All cases within the limits, and how errors are measured", [Note(ERRORS), *tables])
    cost = f"All models and contacts took {content['seconds']} s. {record.version_text(content)}"
    yield Folded("Cost and versions", [cost])


def _panels(rows: Sequence[Entry]) -> list[Panel]:
    """Return errors over their estimates, of C and of contacts apart."""
    of_contact = [row for row in rows if row["engine"] in OF_CONTACT]
    of_c = [row for row in rows if row["engine"] not in OF_CONTACT]
    looks = dict(zip(dict.fromkeys(row["parameter"] for row in rows), cycle(LOOKS), strict=False))
    return [_panel(group, looks) for group in (of_c, of_contact) if group]


def _panel(rows: Sequence[Entry], looks: Mapping[str, Look]) -> Panel:
    """Return errors over their estimates, a mark per case: filled for the first part, open for another."""
    kinds = dict(zip(_by_part(rows), ("filled", "open"), strict=False))
    curves = []
    for row in rows:
        look, cases = looks[row["parameter"]], [case for case in row["reached"] if case["used"] is not None]
        marker = look.marker + ("-open" if kinds[row["engine"]] == "open" else "")
        used, errors = ([case[key] for case in cases] for key in ("used", "error"))
        curves.append(Curve(row["parameter"], used, errors, replace(look, marker=marker)))
    marks = ", ".join(f"{kind}: {part}" for part, kind in kinds.items())
    title = f"{marks}; right of the dotted line an estimate is too small"
    return Panel(title, "error over its estimate [-]", "error [-]", curves, log_y=True, marks=(1.0,))


def _limits_table(rows: Sequence[Entry]) -> Table:
    """Return the range of each parameter of each part, with the worst of its cases."""
    table_rows = [
        Row(
            "" if position else part,
            [f"{limit['parameter']}", limit["range"], *_worst(limit["reached"])],
        )
        for part, limits in _by_part(rows).items()
        for position, limit in enumerate(limits)
    ]
    columns = [
        *texts("parameter", "range"),
        *number_heads("error", "estimate", "error over estimate", unit="1"),
    ]
    return Table("part", columns, table_rows)


def _beyond_table(rows: Sequence[Entry]) -> Table:
    """Return the table of messages in cases beyond the limits."""
    table_rows = [
        Row(row["engine"], [row["parameter"], case["at"], _message(case)])
        for row in rows
        for case in row["beyond"]
    ]
    return Table("part", ["parameter", "case", "message of femic"], table_rows, is_text=True)


def _message(case: Entry) -> Cell:
    """Return the cell of what femic says beyond a limit, coloured where it does not refuse the case."""
    text = case["says"] or "nothing"
    if case["failed"]:
        return Cell(f"failed: {text}", colour=TOO_SMALL)
    return Cell(text, colour="" if case["says"] else TOO_SMALL)


def _cases_table(limits: Sequence[Entry]) -> Table:
    """Return all cases within the limits of a part."""
    columns = [
        *texts("case"),
        *number_heads("error", "estimate", "error over estimate", unit="1"),
        *texts("against"),
        Column("time", "s"),
    ]
    rows = [
        Row("" if position else f"{limit['parameter']}, {limit['range']}", _cells(case))
        for limit in limits
        for position, case in enumerate(limit["reached"])
    ]
    return Table("parameter", columns, rows)


def _cells(case: Entry) -> list[Cell | str]:
    note = f"; {case['note']}" if case["note"] else ""
    known = (np.nan if case[key] is None else case[key] for key in ("error", "estimate", "used"))
    return [f"{case['at']}{note}", *_number_cells(*known), case["exact"], Cell(case["seconds"], ".2g")]
