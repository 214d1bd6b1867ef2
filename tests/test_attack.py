"""The quickest attacks of `make attack`, and the detection of shortcomings by them."""

import random
from itertools import chain
from types import SimpleNamespace
from unittest.mock import Mock

import fuzz
import names
import numpy as np
import pytest
import xarray as xr
from commands import COMMANDS, Ended, Place
from contacts import contacts, summed
from damages import DAMAGES, damages
from kills import broken, kills
from labels import labels
from outcomes import Outcome, row_of, text_of_row
from races import races
from stresses import stresses
from wheelsets import shifts

from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.patches import Grid

SEED = 1


@pytest.fixture(scope="module")
def place():
    with Place() as temporary:
        yield temporary


def judged(outcomes, *answers):
    """No outcome falls short, and the answers are among them."""
    outcomes = list(outcomes)
    assert not [(outcome.attack, outcome.short) for outcome in outcomes if outcome.short]
    assert {*answers} <= {outcome.answer for outcome in outcomes}
    return outcomes


CHANGES = ("scenes", "campaigns", "tables", "gaps")


@pytest.mark.parametrize("change", CHANGES)
def test_changed_files_are_taken_or_refused(change, tmp_path, monkeypatch):
    """Without the plan of the first scene: the slow test has it."""
    monkeypatch.setattr(fuzz, "exit_code", lambda _: 0)
    judged(getattr(fuzz, change)(tmp_path, 8, SEED), "taken", "refused")


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES)
def test_many_changed_files_are_taken_or_refused(change, tmp_path):
    judged(getattr(fuzz, change)(tmp_path, 60, SEED), "taken", "refused")


def test_hostile_texts_and_names_do_no_harm(tmp_path):
    hostile = names.pages(tmp_path / "pages", 6, SEED), names.names(tmp_path / "names", 8, SEED)
    judged(chain(*hostile), "taken", "refused")


@pytest.mark.parametrize(("attack", "count"), [(shifts, 15), (stresses, 20)])
def test_changed_wheelsets_and_stresses_are_taken_or_refused(attack, count, tmp_path, monkeypatch):
    """None is solved: the slow test has one of each."""
    monkeypatch.setattr("wheelsets._solved", lambda _: "taken")
    monkeypatch.setattr("stresses._run", lambda *_: "taken")
    monkeypatch.setattr("stresses.SOLVED", 1000)
    judged(attack(tmp_path, count, SEED), "taken", "refused")


@pytest.mark.slow
@pytest.mark.parametrize(("attack", "answer"), [(shifts, "solved"), (stresses, "run")])
def test_some_wheelsets_and_stresses_are_solved(attack, answer, tmp_path):
    judged(attack(tmp_path, 1, SEED + 1), answer)


def test_labelled_arrays_give_the_same_in_any_order(tmp_path):
    assert {outcome.answer for outcome in judged(labels(tmp_path, 7, SEED))} == {"the same"}


def test_strange_contacts_obey_mechanics():
    assert sum(outcome.answer == "solved" for outcome in judged(contacts(9, SEED))) > 4


# --- commands --------------------------------------------------------------------------------------------

QUICK = [command for command in COMMANDS if command.name in ("rolling", "compression")]


# of a store: tests/femic/cache; of data sets and campaigns: tests/compare/campaigns
@pytest.mark.slow
@pytest.mark.parametrize(("attack", "commands"), [(kills, QUICK[:1]), (damages, QUICK)])
def test_killed_commands_continue_and_damaged_files_are_recomputed(attack, commands, place):
    """Of results and of the store."""
    judged(attack(place, 1 if attack is kills else 6, SEED, commands))


@pytest.mark.slow
def test_two_commands_in_one_folder_do_not_mix_results(place):
    (outcome,) = judged(races(place, 1, SEED, QUICK[:1]))
    assert outcome.answer in ("done and refused", "done and done")


@pytest.mark.slow
def test_changed_results_and_broken_files_are_noticed(place):
    (rolling, *_), reference = QUICK, place.reference(QUICK[0])[0]
    at = place.copy(reference, "other")
    path = at / rolling.folder / "contact.nc"
    with xr.load_dataset(path, engine="h5netcdf") as dataset:
        other = dataset.assign(p_max=dataset.p_max * (1 + 1e-15))
    path.unlink()
    other.to_netcdf(path, engine="h5netcdf")
    assert rolling.differences(reference, reference) == broken(at) == ""
    assert rolling.differences(at, reference) == "contact.nc: p_max differs"
    path.write_bytes(path.read_bytes()[:1000])
    assert "contact.nc was left broken" in broken(at)
    path.unlink()
    assert rolling.differences(at, reference) == "contact.nc: is missing"


@pytest.mark.parametrize(
    ("ended", "trouble", "failure"),
    [
        (Ended(1, "Traceback (most recent call last):\n  x\nKeyError: 3"), "traceback: KeyError: 3", None),
        (Ended(-11, ""), "exit code -11", None),
        (Ended(2, "femic: no"), "", "exit code 2: femic: no"),
    ],
)
def test_tracebacks_and_crashes_are_noticed(ended, trouble, failure):
    assert ended.trouble == trouble
    assert failure in (None, ended.failure)


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
def test_damages_change_files(damage, tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.nc").write_bytes(random.Random(name).randbytes(1000))
    before = (tmp_path / "a.nc").read_bytes()
    damage(tmp_path / "a.nc", random.Random(3))
    assert not (tmp_path / "a.nc").exists() or (tmp_path / "a.nc").read_bytes() != before


# --- what is said ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "answer", "short"),
    [
        (KeyError("3"), "traceback", "KeyError: '3'"),
        (AssertionError("read as 4"), "wrong", "read as 4"),
        (WrongInput(" "), "refused", "without a message"),
        (WrongInput("a = 3: give 4"), "refused", ""),
    ],
)
def test_tracebacks_wrong_values_and_silence_fall_short(error, answer, short):
    assert fuzz.outcome("a", Mock(side_effect=error)) == Outcome("a", answer, short)
    assert fuzz.outcome("a", lambda: "refused").short == "without a message"


def test_row_lists_shortcomings():
    attacks = [Outcome("a", "done"), Outcome("b", "done", "lost"), Outcome("c", "killed")]
    row = row_of("kills", "killed", attacks)
    assert (row["attacks"], row["answers"], row["short"]) == (3, {"done": 2, "killed": 1}, 1)
    assert text_of_row(row | {"seconds": 3}).splitlines() == [
        "kills           3 attacks in 3 s: 2 done, 1 killed; 1 fall short",
        "    b: lost",
    ]


def test_summed_forces_and_moments_match_the_geometry():
    """A pressure of 2 MPa on a square millimetre at the bottom of a groove, and one at 45 degrees."""
    contour = arc(-10.0, 1.2, 1.2)
    grid = Grid(1, 1, 1.0, 1.0, 10 * np.pi / 4)
    placed = SimpleNamespace(x=np.array([3.0]), grid=grid)
    force, moment = summed(np.array([[[0.0, 0.0, 2.0]]]), contour, placed)
    at = np.array([3.0, *np.ravel(contour.position(grid.strips))])
    np.testing.assert_allclose(np.abs(force), [0, np.sqrt(2), np.sqrt(2)], atol=1e-8)
    np.testing.assert_allclose(moment, np.cross(at, force), atol=1e-8)
    assert force[1] * at[1] < 0  # towards the middle of the groove
