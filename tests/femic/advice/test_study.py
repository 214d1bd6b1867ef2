"""The study that advice knows of: random scenes, their features, and solved ones that are stored."""

import json
from types import SimpleNamespace
from unittest.mock import Mock

import advice_scenes as store
import numpy as np
import pytest
from advice_reliability import ics_errors, reference_estimates
from advice_scenes import ANGLES, TOOLS, entries, random_scene, solve_missing, solve_scene

from femic.advice.knowledge import FEATURES, contact_features, packaged_knowledge, saturation, turn_beyond
from femic.cache.digests import results_digest
from femic.contact.pairs.pair_on_grid import undeformed_surfaces
from geometries.contours import arc

SOLVED_AGAIN = 2


def test_scenes_are_determined_by_seed_and_number():
    one, same, other = (random_scene(*which) for which in ((3, 1), (3, 1), (3, 2)))
    assert one.size == same.size
    assert one.problem.specification == same.problem.specification
    assert one.size != other.size


@pytest.mark.parametrize("number", [0, 1, 2])
def test_patches_turn_by_angles_in_their_range_between_the_flanks(number):
    scene = random_scene(5, number)
    features = contact_features(scene.problem, scene.size)
    assert features.keys() == FEATURES.keys()
    assert 0.9 * ANGLES[0] < features["angle"] < 1.1 * ANGLES[1]
    assert features["beyond"] > 0
    lower = scene.problem.bodies["lower"].contour
    touching = undeformed_surfaces(scene.problem).touching[0]
    middle = np.degrees(float(lower.inclination(touching)))
    # patches go further on the side of the smaller curvature
    assert abs(abs(middle) - features["middle"]) < 0.35 * features["angle"]


def test_features_do_not_depend_on_units_of_length_and_modulus():
    scene = random_scene(5, 1)
    step = saturation(scene.problem, scene.size, 0.3, 1000.0)
    assert saturation(scene.problem, scene.size, 0.6, 1000.0) == pytest.approx(2 * step)
    assert saturation(scene.problem, scene.size, 0.3, 500.0) == pytest.approx(step / 2)


@pytest.mark.slow  # C: a minute
@pytest.mark.parametrize("index", range(SOLVED_AGAIN))
def test_known_scenes_are_as_solved_again(index):
    known = packaged_knowledge().scenes[index]
    entry = solve_scene(random_scene(known.seed, known.number), known.seed, known.number)
    errors, estimates = ics_errors(entry), reference_estimates(entry)
    for ics, of_ics in known.errors.items():
        for number, error in of_ics.items():
            # stored with four digits; tractions of rolling to 1e-4
            allowed = estimates[number] + 1e-3 * (1 + abs(error))
            assert abs(errors[ics][number] - error) <= allowed, (ics, number)


@pytest.mark.parametrize("flanks", [(20.0, 50.0), (50.0, 20.0)])
@pytest.mark.parametrize("narrow", ["lower", "upper"])
def test_what_lies_beyond_a_patch_is_that_of_the_body_and_the_side_with_the_least(narrow, flanks):
    """A patch from -12 to 15 degrees: to a flank of 20 degrees it has 8 or 5 degrees left, to others more."""
    wide = "upper" if narrow == "lower" else "lower"
    contours = {narrow: arc(10.0, *np.radians(flanks)), wide: arc(11.0, np.radians(60.0), np.radians(61.0))}
    problem = SimpleNamespace(bodies={name: SimpleNamespace(contour=one) for name, one in contours.items()})
    least = 8.0 if flanks[0] == 20.0 else 5.0
    assert turn_beyond(problem, np.array([-12.0, 15.0])) == pytest.approx(least)


# --- the store ------------------------------------------------------------------------------------------

WANTED = [(1, 0), (1, 1), (2, 0)]


def solve(seed, number):
    return {"seed": seed, "number": number, "value": 10 * seed + number}


def never(seed, number):
    raise AssertionError(f"{seed}-{number} is solved again")


def test_an_interrupted_study_goes_on(tmp_path):
    study, second = solve_missing(tmp_path, WANTED, 1, solve), Mock(side_effect=solve)
    next(study)
    study.close()
    assert len(entries(tmp_path, 1)) == 1
    rest = list(solve_missing(tmp_path, WANTED, 1, second))
    assert [call.args for call in second.call_args_list] == WANTED[1:]
    assert [(entry["seed"], entry["number"]) for entry in rest] == WANTED[1:]
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
    monkeypatch.setattr(store, "random_scene", Mock(side_effect=store.Failure("no patch")))
    assert store.solve_entry(1, 2) == {"seed": 1, "number": 2, "failure": "no patch"}
    monkeypatch.setattr(store, "random_scene", never)
    with pytest.raises(AssertionError):
        store.solve_entry(1, 2)
