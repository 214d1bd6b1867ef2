"""What the pages of docs/evidence show of the numbers of `validate`, `extremes` and the benchmarks."""

import json
from pathlib import Path
from textwrap import fill
from typing import Any

Values = dict[str, Any]


def recorded(folder: Path) -> dict[str, Values]:
    """Return the tables that benchmarks have recorded, by benchmark and table."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def columns_of(table: Values, names: list[str] | None) -> tuple[list[str], list[list[str]]]:
    """Return the head and the rows of a recorded table, of some columns if they are named."""
    chosen = names or table["columns"]
    places = [table["columns"].index(name) for name in chosen]
    return chosen, [[row[k] for k in places] for row in table["rows"]]


def origin(table: Values) -> str:
    """Return when and by what a table was measured."""
    if "source" in table:
        return str(table["source"])
    return f"{table['date']}, {table['machine']}, code {table['code']}"


def worst_case(criterion: Values) -> Values:
    """Return the case of a criterion that is furthest on the wrong side of its threshold, or nearest to it.

    Cases that are too close to tell do not count, as long as there are others.
    """
    values = {case: value for case, value in criterion["values"].items() if value is not None}
    counted = {case: value for case, value in values.items() if not criterion["close"][case]} or values
    missed = [case for case in counted if not criterion["met"][case] and not criterion["close"][case]]
    pick = max if criterion["relation"] == "<" else min
    case = pick(counted, key=lambda name: counted[name]) if counted else None
    return {
        "case": case,
        "value": counted.get(case),
        "close": sum(criterion["close"][name] for name in values),
        "missed": len(missed),
        "cases": len(values),
    }


def unmet(criteria: list[Values]) -> list[Values]:
    """Return the criteria with a case that is missed or not decided, with its worst case.

    A criterion that says "the same" refers to the last one before it that does not: this is returned, too.
    """
    found = list[Values]()
    named: Values = {}  # the last criterion that says of what it is
    for criterion in ({**each, "worst": worst_case(each)} for each in criteria):
        repeats = criterion["says"].startswith("the same")
        if criterion["worst"]["missed"] or criterion["worst"]["close"]:
            found += [named] if repeats and named not in found else []
            found.append(criterion)
        named = named if repeats else criterion
    return found


def changed_verdicts(validation: Values) -> list[Values]:
    """Return the changes of criteria after which the verdict of a statement is another, each reason once."""
    now = {statement["number"]: statement["verdict"] for statement in validation["statements"]}
    found = {
        (change["number"], change["why"]): change | {"now": now[change["number"]]}
        for change in validation["changes"]
        if change["verdict"] and change["verdict"] != now[change["number"]]
    }
    return list(found.values())


def worst_rows(extremes: Values) -> list[Values]:
    """Return for each part and parameter the case with the largest error over its estimate."""
    return [
        {key: row[key] for key in ("engine", "parameter", "range")}
        | max(row["reached"], key=lambda case: (case["used"] or 0.0, case["error"] or 0.0))
        for row in extremes["rows"]
        if row["reached"]
    ]


def counts(extremes: Values) -> Values:
    """Return how many cases have estimates, how many estimates hold, how many cases beyond are refused."""
    reached = [(row, case) for row in extremes["rows"] for case in row["reached"]]
    beyond = [case for row in extremes["rows"] for case in row["beyond"]]
    estimated = [(row, case) for row, case in reached if case["estimate"] is not None]
    return {
        "cases": len(reached),
        "estimated": len(estimated),
        "held": sum(case["honest"] for _, case in estimated),
        "short": [{"case": case_name(row, case), **case} for row, case in estimated if not case["honest"]],
        "beyond": len(beyond),
        "refused": sum(not case["computed"] and not case.get("failed") for case in beyond),
    }


def refused(extremes: Values) -> dict[str, list[str]]:
    """Return the cases beyond the limits that are refused, by part."""
    parts: dict[str, list[str]] = {}
    for row in extremes["rows"]:
        for case in row["beyond"]:
            if not case["computed"]:
                parts.setdefault(row["engine"], []).append(case_name(row, case, ""))
    return parts


def computed(extremes: Values) -> list[str]:
    """Return the cases beyond the limits that are computed all the same."""
    return [case_name(row, case) for row in extremes["rows"] for case in row["beyond"] if case["computed"]]


def case_name(row: Values, case: Values, separator: str = ", ") -> str:
    """Return a case with its part, if a separator is given, and with its parameter unless it names that."""
    part = f"{row['engine']}{separator}" if separator else ""
    return part + (case["at"] if "=" in case["at"] else f"{row['parameter']}: {case['at']}")


def wrapped(text: str) -> str:
    """Return a paragraph in lines as long as those of the pages."""
    return fill(text, 118, break_long_words=False, break_on_hyphens=False)
