"""The quickest of all attacks of `make attack`; and what attacks find is seen to be found."""

import random
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

sys.path.append(str(Path(__file__).parents[1] / "tools" / "attack"))
import fuzz
from commands import COMMANDS, Ended, Place
from contacts import contacts, summed
from damages import DAMAGES, damages
from kills import broken, kills
from outcomes import Outcome, row, text_of_rows
from races import races

from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.grids import Grid

SEED = 1


@pytest.fixture(scope="module")
def place():
    with Place() as found:
        yield found


def short(outcomes):
    return [(one.attack, one.short) for one in outcomes if one.short]


@pytest.mark.parametrize("change", ["scenes", "campaigns", "tables", "gaps"])
def test_changed_files_are_taken_or_refused(change, tmp_path):
    found = list(getattr(fuzz, change)(tmp_path, 60, SEED))
    assert not short(found)
    assert {"taken", "refused"} <= {one.answer for one in found}


def test_strange_contacts_obey_mechanics():
    found = list(contacts(12, SEED))
    assert not short(found)
    assert sum(one.answer == "solved" for one in found) > 4


# --- commands --------------------------------------------------------------------------------------------

QUICK = [command for command in COMMANDS if command.name in ("rolling", "compression")]


def test_what_is_killed_goes_on(place):
    (found,) = kills(place, 1, SEED, QUICK[:1])
    assert not found.short


def test_what_is_damaged_is_made_again(place):
    assert not short(damages(place, 3, SEED, QUICK))


def test_of_two_in_one_folder_one_has_the_results(place):
    (found,) = races(place, 1, SEED, QUICK[:1])
    assert not found.short
    assert found.answer in ("done and refused", "done and done")


def test_other_results_broken_files_and_tracebacks_are_noticed(place):
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
    assert (
        Ended(1, "Traceback (most recent call last):\n  x\nKeyError: 3").trouble == "traceback: KeyError: 3"
    )
    assert Ended(-11, "").trouble == "exit code -11"
    assert Ended(2, "femic: no").trouble == ""
    assert Ended(2, "femic: no").failure == "exit code 2: femic: no"


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda one: one.__name__)
def test_damages_change_files(damage, tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.nc").write_bytes(random.Random(name).randbytes(1000))
    before = (tmp_path / "a.nc").read_bytes()
    damage(tmp_path / "a.nc", random.Random(3))
    assert not (tmp_path / "a.nc").exists() or (tmp_path / "a.nc").read_bytes() != before


# --- what is said ----------------------------------------------------------------------------------------


def test_files_fall_short_by_tracebacks_wrong_values_and_silence():
    def fails(error):
        raise error

    answers = {
        "traceback": (KeyError("3"), "KeyError: '3'"),
        "wrong": (AssertionError("read as 4"), "read as 4"),
        "refused": (WrongInput(" "), "without a message"),
    }
    for answer, (error, text) in answers.items():
        assert fuzz.outcome("a", lambda error=error: fails(error)) == Outcome("a", answer, text)
    assert fuzz.outcome("a", lambda: "refused").short == "without a message"
    assert fuzz.outcome("a", lambda: fails(WrongInput("a = 3: give 4"))) == Outcome("a", "refused")


def test_the_table_has_what_falls_short():
    attacks = [Outcome("a", "done"), Outcome("b", "done", "lost"), Outcome("c", "killed")]
    found = row("kills", "killed", attacks)
    assert (found["attacks"], found["answers"], found["short"]) == (3, {"done": 2, "killed": 1}, 1)
    assert text_of_rows([found | {"seconds": 3}]).splitlines() == [
        "kills           3 attacks in 3 s: 2 done, 1 killed; 1 fall short",
        "    b: lost",
    ]


def test_forces_of_strange_contacts_are_summed_by_another_route():
    """A pressure of 2 MPa on a square millimetre at the bottom of a groove, and one at 45 degrees."""
    contour = arc(-10.0, 1.2, 1.2)
    grid = Grid(1, 1, 1.0, 1.0, 10 * np.pi / 4)
    placed = SimpleNamespace(x=np.array([3.0]), grid=grid)
    force, moment = summed(np.array([[[0.0, 0.0, 2.0]]]), contour, placed)
    at = np.array([3.0, *np.ravel(contour.position(grid.strips))])
    np.testing.assert_allclose(np.abs(force), [0, np.sqrt(2), np.sqrt(2)], atol=1e-8)
    np.testing.assert_allclose(moment, np.cross(at, force), atol=1e-8)
    assert force[1] * at[1] < 0  # towards the middle of the groove
