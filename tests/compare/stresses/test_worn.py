"""Wear of the contact of a scene: mass balance, error by steps, as many steps as are stable."""

import re

import numpy as np
import pytest

from femic.cli.main import WRONG_INPUT, exit_code
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.damage.estimates import RollingSolution
from femic.damage.laws import STEEL_DENSITY, EnergyLaw
from femic.damage.specification import DamageSpecification
from femic.results import damage as module
from femic.results.damage import compute_wear
from femic.results.stressed_contact import require_stresses
from femic.scenes.load import load_scene
from geometries.errors import WrongInput
from tests.compare.frontier.scenes import text
from tests.femic.contact.friction_problems import POINT, paraboloids, wheel_on

ROLLING = 'motion = "rolling"\nfriction = [0.3]\nics = ["A"]'
MILD = EnergyLaw(mild=0.7, transition=1e9)


@pytest.fixture(scope="module")
def solution():
    """A wheel that rolls on a rail, driven, on elements a seventh of the patch."""
    wheel = wheel_on(paraboloids(14, 18, room=(1.8, 2.1)))
    return RollingSolution(wheel, wheel.contact(Creepages(0.01), Loading(POINT.load)), POINT.load)


def damage(**keys):
    return DamageSpecification(speed=10.0, energy=MILD, **keys)


def test_each_body_loses_its_share_of_the_work(solution):
    """Between that of the new and that of the worn contact, which hardly differ."""
    worn = compute_wear(solution, damage(passages=240.0, revolutions=80.0, steps=4))
    section = worn.worn.sum("s").values / 1e3 * solution.contact.problem.grid.ds
    assert section[0] == pytest.approx(3 * section[1], rel=1e-12)
    joules = section[0] * STEEL_DENSITY / (0.7e-3 * 240.0)
    work = worn.worn_work.values
    assert min(work) <= joules <= max(work) < 1.01 * min(work)


def test_the_contact_is_that_of_the_scene(solution):
    worn = compute_wear(solution, damage(passages=240.0, steps=4))
    new, last = worn.worn_p_max.values
    assert new == pytest.approx(np.max(solution.contact.p[..., 2]), rel=1e-4)
    work = np.sum(solution.contact.dissipation) * solution.contact.problem.grid.area
    assert worn.worn_work[0] == pytest.approx(work, rel=1e-4)
    assert last < new  # wear spreads the contact of convex bodies
    assert np.all(worn.worn[1] == 0)


def test_estimates_bound_the_error_by_steps(solution):
    exact = float(compute_wear(solution, damage(passages=240.0, steps=32)).worn[0].max())
    worn = compute_wear(solution, damage(passages=240.0, steps=4))
    assert worn.wear_steps == 4
    error = abs(float(worn.worn[0].max()) - exact)
    assert 0 < error < worn.estimate_worn[0] < 4 * error
    assert worn.estimate_worn[1] == 0


def test_there_are_more_steps_where_so_few_are_not_stable(solution, monkeypatch):
    steps = int(compute_wear(solution, damage(passages=20_000.0, steps=2)).wear_steps)
    assert steps in {4, 8, 16, 32, 64, 128}
    monkeypatch.setattr(module, "MOST_STEPS", steps - 1)
    with pytest.raises(WrongInput, match=r"steps of wear are needed; passages = .* per step"):
        compute_wear(solution, damage(passages=20_000.0, steps=2))


@pytest.mark.parametrize("spread", [1.0, 30.0])
def test_wear_that_spreads_beyond_the_grid_is_refused_before_any_work(spread, tmp_path, capsys):
    """Its room is known before C: refused are spreads for which no strip of contact is left."""
    path = tmp_path / "mine.toml"
    damage = f"[damage]\npassages = 2e3\nspread = {spread}\n"
    path.write_text(text(contact="loads = [2e3]", motion=ROLLING) + damage, encoding="utf-8")
    assert exit_code(["stresses", str(path), "--out", str(tmp_path / "out")]) == WRONG_INPUT
    said = capsys.readouterr().err
    assert f"damage.spread = {spread:g} mm: " in said
    least = float(re.search(r"give less than ([\d.e-]+) mm", said)[1])
    assert 0 < least < spread
    changed = load_scene(str(path), {"damage": {"spread": 0.9 * least}})
    require_stresses(changed)
    assert not (tmp_path / "out").exists()


def test_wear_that_reaches_the_ends_of_the_grid_is_refused_by_its_key(solution):
    with pytest.raises(WrongInput, match=r"damage\.spread = 0\.6 mm: wear reaches the ends of the grid"):
        compute_wear(solution, damage(passages=240.0, steps=4, spread=0.6))
