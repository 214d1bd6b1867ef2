"""Tables of benchmarks are recorded when this is wanted; pages of evidence show worst cases."""

import json
import sys
from pathlib import Path

import evidence_page as page
import pytest

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
import tables

RECORD = tables.Record("speed.solid", "Speed", "Seconds of two engines.", "python benchmarks/speed.py")


@pytest.fixture
def numbers(tmp_path, monkeypatch):
    """The folder of recorded tables; nothing is recorded yet."""
    monkeypatch.setattr(tables, "NUMBERS", tmp_path)
    monkeypatch.setattr(tables, "_recording", [])
    return tmp_path


def test_a_table_is_recorded_only_if_this_is_wanted(numbers, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["speed.py", "3", "--record"])
    tables.print_table(["engine", "time [s]"], [["solid", 2]], record=RECORD)
    assert list(numbers.iterdir()) == []
    assert tables.arguments() == ["3"]
    tables.print_table(["engine", "time [s]"], [["solid", 2]], record=RECORD)
    assert capsys.readouterr().out.count("| solid | 2 |") == 2
    table = page.recorded(numbers)["speed"]["solid"]
    assert page.columns_of(table, ["time [s]", "engine"]) == (["time [s]", "engine"], [["2", "solid"]])
    assert f"code {table['code']}" in page.origin(table)


def test_a_record_keeps_the_other_tables_of_its_benchmark(numbers):
    (numbers / "speed.json").write_text(json.dumps({"harmonic": {"source": "by hand"}}), encoding="utf-8")
    tables.write(RECORD, ["engine"], [["solid"]], {"source": "by hand, too"})
    found = page.recorded(numbers)["speed"]
    assert [page.origin(found[name]) for name in ("harmonic", "solid")] == ["by hand", "by hand, too"]


def criterion(relation, **values):
    """A criterion with a threshold of 1; names in capitals are too close to tell."""
    met = {name: value < 1 if relation == "<" else value > 1 for name, value in values.items()}
    return {
        "relation": relation,
        "values": values,
        "met": met,
        "close": {name: name.isupper() for name in values},
    }


@pytest.mark.parametrize(
    ("relation", "values", "case", "missed", "close"),
    [
        ("<", {"a": 0.2, "b": 0.5}, "b", 0, 0),
        (">", {"a": 2.0, "b": 0.5}, "b", 1, 0),
        ("<", {"a": 0.2, "B": 1.5}, "a", 0, 1),  # what is too close to tell does not count
        ("<", {"A": 0.9, "B": 1.5}, "B", 0, 2),  # unless there is nothing else
        ("<", {"a": None, "b": 0.5}, "b", 0, 0),
    ],
)
def test_the_worst_case_of_a_criterion(relation, values, case, missed, close):
    numbers = {name: value for name, value in values.items() if value is not None}
    given = criterion(relation, **numbers)
    given["values"] = values
    worst = page.worst_case(given)
    assert (worst["case"], worst["missed"], worst["close"]) == (case, missed, close)
    assert worst["cases"] == len(numbers)


def test_criteria_that_are_met_are_left_out_unless_another_refers_to_them():
    says = ("met", "the same, missed", "the same, met", "missed", "the same, too close", "also met")
    values = ({"a": 0.1}, {"a": 2.0}, {"a": 0.1}, {"a": 2.0}, {"A": 2.0}, {"a": 0.1})
    given = [criterion("<", **each) | {"says": text} for text, each in zip(says, values, strict=True)]
    found = page.unmet(given)
    assert [each["says"] for each in found] == [says[k] for k in (0, 1, 3, 4)]
    assert [each["worst"]["missed"] for each in found] == [0, 1, 1, 0]


def test_changes_without_another_verdict_are_left_out():
    statements = [{"number": 1, "verdict": "depends"}, {"number": 2, "verdict": "reproduced"}]
    changes = [
        {"number": 1, "verdict": "depends", "why": "x"},
        {"number": 2, "verdict": "depends", "why": "y"},
        {"number": 2, "verdict": "", "why": "before the first run"},
    ]
    (found,) = page.changed_verdicts({"statements": statements, "changes": changes})
    assert (found["number"], found["now"]) == (2, "reproduced")


def test_extremes_are_counted():
    reached = [
        {"at": "x = 1", "error": 1.0, "estimate": 2.0, "used": 0.5, "honest": True},
        {"at": "2", "error": 3.0, "estimate": 2.0, "used": 1.5, "honest": False},
        {"at": "3", "error": 9.0, "estimate": None, "used": None, "honest": True},
    ]
    beyond = [{"at": "4", "computed": True}, {"at": "5", "computed": False}]
    row = {"engine": "solid", "parameter": "x", "range": "1 … 3", "reached": reached, "beyond": beyond}
    counts = page.counts({"rows": [row]})
    assert [counts[name] for name in ("cases", "estimated", "held", "beyond", "refused")] == [3, 2, 1, 2, 1]
    assert [case["case"] for case in counts["short"]] == ["solid, x: 2"]
    assert [row["at"] for row in page.worst_rows({"rows": [row]})] == ["2"]
    assert page.refused({"rows": [row]}) == {"solid": ["x: 5"]}
    assert page.computed({"rows": [row]}) == ["solid, x: 4"]
