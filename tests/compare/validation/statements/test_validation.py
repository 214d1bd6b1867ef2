"""`femic validate`: verdicts follow from numbers, numbers from the code, and nothing is solved twice."""

import json
from dataclasses import replace

import numpy as np
import pytest

from approx import forms
from approx.effective import EffectiveProperties, Transition
from approx.forms import Rotation
from compare.report.charts import simple_chart
from compare.validation.statements import page as verdicts
from compare.validation.statements.direct_components import nn_error
from compare.validation.statements.frame import NOT_DECIDED, REPRODUCED, Criterion, Statement
from compare.validation.statements.page import STATEMENTS, assess
from compare.validation.statements.runs import GEOMETRIES, Runs
from femic.cache.store import Store
from femic.cli.main import DONE, INTERRUPTED, WRONG_INPUT, exit_code
from femic.reference import result
from femic.reference.harmonic import engine as harmonic_engine
from femic.reference.run_options import RunOptions
from geometries.errors import Failure
from tests.compare.pages import read_chart
from tests.compare.validation.statements.mutations import cases_met, changed, quick_and_slow

NEED_MORE = (8, 11, 14, 15, *range(21, 49))  # statements on other runs than those of both geometries
OF_GEOMETRIES = tuple(number for number in STATEMENTS if number not in NEED_MORE)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("validation") / "store")


class Coarse(Runs):
    """A quarter of the points, and a fit that was made before: that of a scene to its C has its own tests."""

    def _scene(self, name, changes=None, *, check=False):
        lines = [{"along": along, at: distance, "points": 101} for along, at, distance in LINES]
        return super()._scene(name, {"lines": lines} | dict(changes or {}), check=check)

    def _fit(self, _):
        return {"combined": EffectiveProperties(mismatch_k=FITTED)}


LINES = (("x", "s", 1.6), ("x", "s", 0.0), ("s", "x", 1.6))  # the default ones
FITTED = Transition(0.14, 10.0, 1.5, 4.0)


@pytest.fixture(scope="module")
def runs(store):
    """Both geometries by the harmonic engine, not as accurate as `femic validate` has them."""
    coarse = Coarse(RunOptions(2, store), tolerance=0.01)
    for name in GEOMETRIES:
        coarse.fitted(name)
    return coarse


# --- numbers and verdicts ------------------------------------------------------------------------------


def test_statements_are_numbered_and_their_criteria_named():
    assert list(STATEMENTS) == sorted({statement.number for statement in STATEMENTS.values()})
    for statement in STATEMENTS.values():
        names = [criterion.name for criterion in statement.criteria]
        assert names
        assert len(set(names)) == len(names)


def test_every_criterion_is_measured_in_some_case(runs):
    for number in OF_GEOMETRIES:
        entry, panels = assess(number, runs)
        assert len(entry["criteria"]) == len(STATEMENTS[number].criteria)
        for criterion in entry["criteria"]:
            assert None not in criterion["values"].values(), number
        assert panels
        content = read_chart(simple_chart("", panels, STATEMENTS[number].columns))
        assert len({str(dict(each, label="")) for each in content["legend"]}) == len(content["legend"])


# --- from the code to verdicts --------------------------------------------------------------------------


def a_times(entry, by):
    """A, as approximations see it, with one component and its reciprocal wrong by a factor."""

    def change(right, self):
        a = right(self).copy()
        for at in {entry, entry[::-1]}:
            a[at] *= by
        return a

    return changed(forms.Ingredients, "a", change)


def c_times(entry, by):
    """C with one component wrong by a factor."""

    def change(right, *arguments):
        ic, raw, m = right(*arguments)
        ic = ic.copy()
        ic[entry] *= by
        return ic, raw, m

    return changed(result, "discounted", change)


def backwards(right, *arguments):
    """Rotations in the wrong direction."""
    quaternion = right(*arguments).quaternion.copy()
    quaternion[1:] *= -1
    return Rotation(quaternion)


def not_discounted(right, *arguments):
    _, raw, m = right(*arguments)
    return raw, raw, m


MUTATIONS = {  # what is wrong, and some of the criteria that must say so
    "A_xx too large": (a_times((0, 0), 1.2), {(2, "A"), (17, "xx"), (18, "at the load")}),
    "sign of A_xn": (a_times((0, 2), -1), {(6, "in B"), (6, "in B̂"), (18, "at the load")}),
    "sign of A_sn": (a_times((1, 2), -1), {(5, "add"), (9, "convex"), (9, "concave")}),
    "direction of rotations": (
        changed(forms, "rotation_between", backwards),
        {(6, "in B"), (9, "B"), (9, "arc")},
    ),
    "sign of C_xn": (c_times((0, 2), -1), {(5, "add"), (7, "too large"), (18, "at the load")}),
    "sign of C_sn": (c_times((1, 2), -1), {(9, "convex"), (9, "concave"), (9, "arc")}),
    "C_nn too large": (c_times((2, 2), 1.1), {(18, "at the load")}),
    "no rigid-body discount": (
        changed(result, "discounted", not_discounted),
        {(3, "other way"), (5, "cancel"), (18, "at the load")},
    ),
}
QUICK = ("direction of rotations", "sign of C_xn")


@pytest.mark.parametrize("mutation", quick_and_slow(MUTATIONS, QUICK))
def test_wrong_signs_and_factors_change_what_is_met(mutation, runs, monkeypatch):
    """A wrong sign or factor is seen; C is read from the store, A of its conditions and tails stays right."""
    change, seen_by = MUTATIONS[mutation]
    before = {key: cases_met(runs, key) for key in seen_by}
    monkeypatch.setattr(*change)
    mutated = replace(runs, done={})
    unchanged = {key for key in seen_by if cases_met(mutated, key) == before[key]}
    assert not unchanged


# --- the command ----------------------------------------------------------------------------------------


def test_the_command_writes_json_and_a_page_and_continues_after_an_interruption(
    runs, store, tmp_path, monkeypatch, capsys
):
    """The models of both geometries are in the store: neither run makes a mesh."""
    monkeypatch.setattr(harmonic_engine, "build_section", lambda *_: pytest.fail("a mesh was made"))
    monkeypatch.setattr("compare.validation.statements.runs.Runs", Coarse)
    command = ["validate", "--only", "1", "2", "--tolerance", "0.01", "--out", str(tmp_path)]
    command += ["--store", str(store.location)]

    def interrupted(_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        broken = replace(STATEMENTS[2], details=interrupted)
        patch.setattr(verdicts, "STATEMENTS", {**STATEMENTS, 2: broken})
        assert exit_code(command) == INTERRUPTED
    assert not (tmp_path / "validation.html").exists()
    assert exit_code(command) == DONE
    record = json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))
    assert [entry["number"] for entry in record["statements"]] == [1, 2]
    assert record["statements"][0]["verdict"] == assess(1, runs)[0]["verdict"]
    first = record["statements"][0]["criteria"][0]
    assert first["values"] == pytest.approx({name: nn_error("A")(runs.geometry(name)) for name in GEOMETRIES})
    assert set(record["runs"]) == set(GEOMETRIES)
    assert all(0 < run["weight"] < 0.01 for run in record["runs"].values())
    assert all(run["weight"] < run["estimate"] < 0.2 for run in record["runs"].values())
    assert {change["number"] for change in record["changes"]} <= set(STATEMENTS)
    page = (tmp_path / "validation.html").read_text(encoding="utf-8")
    assert page.count('<div class="chart"') == 2
    capsys.readouterr()


def entry_of(values, threshold=0.5):
    criterion = Criterion("less", "it is less", "<", threshold, lambda _: values)
    return verdicts.as_entry(Statement(99, "A claim.", [criterion], lambda _: ()), {"less": values})


def test_unknown_numbers_are_valid_json_and_come_first_in_the_table_of_criteria():
    entry = entry_of({"one": 0.4, "two": np.nan, "three": 0.7})
    assert json.loads(json.dumps(entry, allow_nan=False)) == entry
    row = verdicts._criteria_table(entry["criteria"]).rows[0]
    assert row.cells[-1].startswith("two: ")
    assert "three: 0.7" in row.cells[-1]


def test_where_all_cases_meet_a_criterion_the_column_of_the_others_is_left_out():
    table = verdicts._criteria_table(entry_of({"one": 0.4, "two": 0.3})["criteria"])
    assert [len(row.cells) for row in table.rows] == [len(table.columns)] == [3]


def test_a_registered_statement_is_assessed_and_reported(tmp_path, monkeypatch, capsys):
    """One entry in the registry suffices: the command knows its number, verdict, numbers and page follow."""
    number = max(STATEMENTS) + 1
    criterion = Criterion("half", "a half", "<", 0.6, lambda runs: {"here": 500 * runs.tolerance})
    statement = Statement(number, "A half is less.", (criterion,), lambda _: (), lambda _: {"twice": 1.0})
    monkeypatch.setitem(STATEMENTS, number, statement)
    assert exit_code(["validate", "--only", str(number), "--out", str(tmp_path)]) == DONE
    record = json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))
    (assessed,) = record["statements"]
    assert (assessed["number"], assessed["claim"]) == (number, "A half is less.")
    assert (assessed["verdict"], assessed["details"]) == (REPRODUCED, {"twice": 1.0})
    assert assessed["criteria"][0]["values"] == {"here": 0.5}
    page = (tmp_path / "validation.html").read_text(encoding="utf-8")
    assert "A half is less." in page
    assert page.count('<div class="chart"') == 0  # no curves
    capsys.readouterr()


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        *(("--only", number, f"give some of 1 to {max(STATEMENTS)}") for number in (0, max(STATEMENTS) + 1)),
        *(("--tolerance", tolerance, "--tolerance") for tolerance in (-1, 0.5, "nan")),
    ],
)
def test_wrong_options_are_refused_and_nothing_is_written(option, value, message, tmp_path, capsys):
    assert exit_code(["validate", option, str(value), "--out", str(tmp_path)]) == WRONG_INPUT
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_statement_that_cannot_be_computed_is_not_decided(runs, monkeypatch):
    def failing(_):
        raise Failure("not converged, and what to try")

    broken = replace(STATEMENTS[1], details=failing)
    monkeypatch.setattr(verdicts, "STATEMENTS", {**STATEMENTS, 1: broken})
    entry, panels = assess(1, runs)
    assert (entry["verdict"], entry["failed"]) == (NOT_DECIDED, "not converged, and what to try")
    assert not panels


@pytest.mark.slow
@pytest.mark.parametrize("number", [14, 15, 22, 23, 24])
def test_the_program_can_be_trusted(number, tmp_path):
    """Both engines on both geometries, all limits, and contact without ICs, in full."""
    assert exit_code(["validate", "--only", str(number), "--out", str(tmp_path)]) == DONE
    record = json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))
    assert [entry["verdict"] for entry in record["statements"]] == [REPRODUCED]
