"""Solved scenes are stored one by one: an interrupted study goes on, damaged files are solved again."""

import json

import advice_scenes as store
import pytest
from advice_scenes import TOOLS, entries, solve_missing

from femic.cache.digests import results_digest

WANTED = [(1, 0), (1, 1), (2, 0)]


def solve(seed, number):
    return {"seed": seed, "number": number, "value": 10 * seed + number}


def never(seed, number):
    raise AssertionError(f"{seed}-{number} is solved again")


def test_an_interrupted_study_goes_on(tmp_path):
    study = solve_missing(tmp_path, WANTED, 1, solve)
    next(study)
    study.close()
    assert len(entries(tmp_path, 1)) == 1
    asked = []

    def second(seed, number):
        asked.append((seed, number))
        return solve(seed, number)

    rest = list(solve_missing(tmp_path, WANTED, 1, second))
    assert asked == [(entry["seed"], entry["number"]) for entry in rest] == WANTED[1:]
    assert [entry["value"] for entry in entries(tmp_path, 1)] == [10, 11]
    assert list(solve_missing(tmp_path, WANTED, 1, never)) == []


def test_damaged_entries_and_those_of_other_code_are_solved_again(tmp_path, caplog):
    list(solve_missing(tmp_path, WANTED, 1, solve))
    (tmp_path / "1-0.json").write_text('{"seed": 1, "num', encoding="utf-8")
    old = json.loads((tmp_path / "2-0.json").read_text(encoding="utf-8")) | {"code": "other"}
    (tmp_path / "2-0.json").write_text(json.dumps(old), encoding="utf-8")
    assert entries(tmp_path, 2, results_digest(TOOLS)) == []
    again = list(solve_missing(tmp_path, WANTED, 1, solve))
    assert [(entry["seed"], entry["number"]) for entry in again] == [(1, 0), (2, 0)]
    assert "damaged" in caplog.text


def test_scenes_without_a_contact_say_why(monkeypatch):
    def fails(*_):
        raise store.Failure("no patch")

    monkeypatch.setattr(store, "random_scene", fails)
    assert store.solve_entry(1, 2) == {"seed": 1, "number": 2, "failure": "no patch"}
    monkeypatch.setattr(store, "random_scene", never)
    with pytest.raises(AssertionError):
        store.solve_entry(1, 2)
