"""`femic validate`: verdicts follow from numbers, numbers from the code, and nothing is solved twice."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from approx import orientation, variants
from approx.orientation import Turn
from compare.cli import DONE, INTERRUPTED, WRONG_INPUT, exit_code
from compare.validation import direct, program, verdicts
from compare.validation.criteria import STATEMENTS, Criterion, Statement
from compare.validation.curves import Measured
from compare.validation.program import agreement, cylinder_error, far_field_error, point_load
from compare.validation.runs import GEOMETRIES, Runs
from compare.validation.verdicts import (
    DEPENDS,
    MEASURES,
    NOT_DECIDED,
    NOT_REPRODUCED,
    REPRODUCED,
    Judged,
    judge,
)
from femic import reference
from femic.harmonic import engine as harmonic_engine
from femic.store import Store
from geometries.errors import Failure
from geometries.materials import Material, one_body
from geometries.surfaces import LOWER, UPPER

OF_GEOMETRIES = (1, 2, 3, 4, 5, 6, 7, 9, 10, 12, 13)  # statements that need no other runs
NEAR, LARGE = Criterion("near", "", "<", 0.1), Criterion("large", "", ">", 1.0)


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return Store(tmp_path_factory.mktemp("validation") / "store")


@pytest.fixture(scope="module")
def runs(store):
    """Both geometries by the harmonic engine, not as accurate as `femic validate` has them."""
    found = Runs(2, store, tolerance=0.01)
    for name in GEOMETRIES:
        found.fitted(name)
    return found


@pytest.fixture(scope="module")
def verdicts_before(runs):
    return {number: judge(number, runs).verdict for number in OF_GEOMETRIES}


# --- from numbers to verdicts ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("near", "large", "verdict", "unmet"),
    [
        ({"a": 0.05}, {"a": 1.5}, REPRODUCED, 0),
        ({"a": 0.15}, {"a": 0.5}, NOT_REPRODUCED, 2),
        ({"a": 0.05, "b": 0.15}, {"a": 1.5}, DEPENDS, 1),
        ({"a": np.nan}, {"a": np.nan}, NOT_REPRODUCED, 2),
    ],
)
def test_a_verdict_is_what_the_criteria_say(near, large, verdict, unmet):
    judged = Judged(0, Statement("", (NEAR, LARGE)), Measured({"near": near, "large": large}))
    assert judged.verdict == verdict
    assert len(judged.unmet) == unmet


def test_every_statement_has_a_measure_and_criteria():
    assert list(MEASURES) == list(STATEMENTS) == list(range(1, 16))
    for statement in STATEMENTS.values():
        names = [criterion.name for criterion in statement.criteria]
        assert names
        assert len(set(names)) == len(names)


def test_every_criterion_is_measured_in_some_case(runs):
    for number in OF_GEOMETRIES:
        judged = judge(number, runs)
        assert set(judged.measured.values) == {criterion.name for criterion in judged.statement.criteria}
        assert all(judged.measured.values.values())
        assert all(np.isfinite(value) for _, _, value in judged.numbers), number
        assert judged.measured.panels


# --- from the code to verdicts --------------------------------------------------------------------------


def factor(entry, by):
    """A, as approximations see it, with one component and its reciprocal wrong by a factor."""
    right = variants.Ingredients.a.fget

    def wrong(self):
        a = right(self).copy()
        for at in {entry, entry[::-1]}:
            a[at] *= by
        return a

    return variants.Ingredients, "a", property(wrong)


def backwards(*arguments):
    """Turns the wrong way."""
    turn = orientation.turn_between(*arguments).quaternion.copy()
    turn[1:] *= -1
    return Turn(turn)


def c_times(entry, by):
    """C with one component wrong by a factor."""
    right = reference.discounted

    def wrong(*arguments):
        ic, raw, m = right(*arguments)
        ic = ic.copy()
        ic[entry] *= by
        return ic, raw, m

    return reference, "discounted", wrong


def not_discounted(*arguments):
    _, raw, m = DISCOUNTED(*arguments)
    return raw, raw, m


DISCOUNTED = reference.discounted
MUTATIONS = {
    "A_xx too large": (factor((0, 0), 1.2), {2}),
    "sign of A_xn": (factor((0, 2), -1), set()),
    "direction of turns": ((variants, "turn_between", backwards), {7, 12}),
    "sign of C_xn": (c_times((0, 2), -1), {7}),
    "no rigid-body discount": ((reference, "discounted", not_discounted), set()),
}
QUICK = ("direction of turns", "sign of C_xn")


@pytest.mark.parametrize(
    "mutation",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in MUTATIONS],
)
def test_verdicts_change_with_the_code(mutation, runs, verdicts_before, monkeypatch):
    """A wrong sign or factor is seen; C is read from the store, A of its conditions and tails stays right."""
    change, seen_by = MUTATIONS[mutation]
    numbers = {number: list(judge(number, runs).numbers) for number in OF_GEOMETRIES}
    monkeypatch.setattr(*change)
    mutated = replace(runs, done={}, fits={} if "C" in mutation.split()[-1] else runs.fits)
    found = {number: judge(number, mutated) for number in OF_GEOMETRIES}
    changed = {n for n in OF_GEOMETRIES if found[n].verdict != verdicts_before[n]}
    assert changed >= seen_by, changed
    met = {n: [c.met(v) for c, _, v in numbers[n]] for n in OF_GEOMETRIES}
    assert any([c.met(v) for c, _, v in found[n].numbers] != met[n] for n in OF_GEOMETRIES)


# --- statements 14 and 15 -------------------------------------------------------------------------------


def test_point_loads_are_homogeneous_and_reciprocal():
    """As Boussinesq and Cerruti have them: homogeneous of degree -1, C(-x) the transposed of C(x)."""
    constants = one_body(Material(210e3, 0.3), UPPER)
    x, s = np.array([0.3, -2.0]), np.array([1.0, 0.4])
    u = point_load(constants, x, s)
    np.testing.assert_allclose(point_load(constants, 2 * x, 2 * s), u / 2, rtol=1e-14)
    np.testing.assert_allclose(np.swapaxes(point_load(constants, -x, -s), 0, 1), u, rtol=1e-14)
    nn = (1 - 0.3**2) / (np.pi * 210e3 * np.hypot(x, s))
    np.testing.assert_allclose(u[2, 2], nn, rtol=1e-14)


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
def test_limits_hold_and_a_wrong_factor_does_not(nu, monkeypatch):
    criteria = {criterion.name: criterion for criterion in STATEMENTS[15].criteria}
    assert criteria["point loads"].met(far_field_error(nu))
    assert all(criteria["cylinder"].met(cylinder_error(side, nu)) for side in (UPPER, LOWER))
    without_factor = partial(program._cylinder, factor=False)
    monkeypatch.setattr(program, "_cylinder", without_factor)
    assert criteria["cylinder"].met(cylinder_error(UPPER, nu)) == (nu == 0.5)  # nothing to multiply there


def test_agreement_of_engines_is_measured_in_estimates(runs):
    results = runs.geometry("geometry1")
    same = replace(results, checks=results.references)
    assert max(agreement(same, "combined").values()) == 0
    body = results.references["lower"]
    off = replace(body, c=replace(body.c, ic=body.c.ic + 3 * body.c.estimate))
    apart = agreement(replace(results, checks={**results.references, "lower": off}), "lower")
    assert apart["nn"] == pytest.approx(1.5)  # three of the one, of two


# --- the command ----------------------------------------------------------------------------------------


def test_it_writes_json_and_a_page_and_goes_on_where_it_was_interrupted(
    runs, store, tmp_path, monkeypatch, capsys
):
    """The models of both geometries are in the store: neither run makes a mesh."""
    monkeypatch.setattr(harmonic_engine, "build_section", lambda *_: pytest.fail("a mesh was made"))
    command = ["validate", "--only", "1", "2", "--tolerance", "0.01", "--out", str(tmp_path)]
    command += ["--store", str(store.location)]

    def interrupted(_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(verdicts, "MEASURES", {**MEASURES, 2: interrupted})
        assert exit_code(command) == INTERRUPTED
    assert not (tmp_path / "validation.html").exists()
    assert exit_code(command) == DONE
    found = json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))
    assert [one["number"] for one in found["statements"]] == [1, 2]
    assert found["statements"][0]["verdict"] == judge(1, runs).verdict
    first = found["statements"][0]["criteria"][0]
    assert first["values"] == pytest.approx(direct.nn_follows(runs).values["B lateral"])
    assert set(found["runs"]) == set(GEOMETRIES)
    assert all(0 < run["estimate"] < 0.01 for run in found["runs"].values())
    page = (tmp_path / "validation.html").read_text(encoding="utf-8")
    assert page.count("data:image/png") == 4
    assert "://" not in page
    capsys.readouterr()


@pytest.mark.parametrize("only", ["0", "16"])
def test_statements_that_are_none_are_refused(only, tmp_path, capsys):
    assert exit_code(["validate", "--only", only, "--out", str(tmp_path)]) == WRONG_INPUT
    assert "give some of 1 to 15" in capsys.readouterr().err


@pytest.mark.parametrize("tolerance", ["-1", "0.5", "nan"])
def test_a_tolerance_that_proves_nothing_is_refused(tolerance, tmp_path, capsys):
    assert exit_code(["validate", "--tolerance", tolerance, "--out", str(tmp_path)]) == WRONG_INPUT
    assert "--tolerance" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_computed_is_not_decided(runs, monkeypatch):
    def failing(_):
        raise Failure("not converged, and what to try")

    monkeypatch.setattr(verdicts, "MEASURES", {**MEASURES, 1: failing})
    judged = judge(1, runs)
    assert judged.verdict == NOT_DECIDED
    assert judged.failed == "not converged, and what to try"


def test_numbers_next_to_their_threshold_are_said_to_be_close():
    assert LARGE.close(1.001)
    assert LARGE.close(0.999)
    assert not LARGE.close(1.01)
    assert not Criterion("", "", "<", 1e-12).close(1e-15)


@pytest.mark.slow
def test_the_program_can_be_trusted(tmp_path):
    """Statements 14 and 15 in full: both engines on both geometries, and all limits."""
    assert exit_code(["validate", "--only", "14", "15", "--out", str(tmp_path)]) == DONE
    found = json.loads((tmp_path / "validation.json").read_text(encoding="utf-8"))
    assert [one["verdict"] for one in found["statements"]] == [REPRODUCED, REPRODUCED]
