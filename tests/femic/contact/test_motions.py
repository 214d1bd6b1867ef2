"""A motion is one registration: scenes, contact and its arrays know it, or say what they lack."""

from dataclasses import replace

import numpy as np
import pytest

from compare.pages import friction_pages as pages
from compare.pages.friction_pages import require_page
from femic.contact.motions import MOTIONS
from femic.contact.pairs.pair_with_friction import solve_with_friction
from femic.contact.pairs.solved_curve import solve_curve
from femic.contact.specification import FrictionSpecification
from femic.results import friction as compute
from femic.results.friction import compute_with_friction
from femic.scenes.errors import BadScene
from geometries.errors import WrongInput
from tests.compare.friction.scenes import scene
from tests.femic.contact.pairs.problems import SMALL, problem

LOADS = [1e3, 2e3]


@pytest.fixture
def again(monkeypatch):
    """A motion that is compression by another name."""
    monkeypatch.setitem(MOTIONS, "again", replace(MOTIONS["compression"], slip_unit="m"))


def pressed(motion):
    return scene(13.0, motion=motion, loads=LOADS, friction=[0.3], ics=["A"])


@pytest.mark.usefixtures("again")
def test_registered_motion_is_solved(monkeypatch):
    monkeypatch.setitem(compute.LABELS, "again", compute.LABELS["compression"])
    known, other = (compute_with_friction(pressed(motion)) for motion in ("compression", "again"))
    for name in MOTIONS["again"].quantities:
        np.testing.assert_array_equal(other[name], known[name])
    assert other.slip.attrs["units"] == "m"


@pytest.mark.usefixtures("again")
def test_missing_parts_of_a_motion_are_reported_before_any_work(monkeypatch):
    with pytest.raises(BadScene, match=r"contact\.motion = 'again': its solutions have no labels"):
        compute_with_friction(pressed("again"))
    with pytest.raises(BadScene, match=r"contact\.motion = 'again': no page: register one"):
        require_page(pressed("again"))
    monkeypatch.setitem(pages.PAGES, "again", pages.PAGES["compression"])
    require_page(pressed("again"))


@pytest.mark.usefixtures("again")
def test_motion_accepts_its_registered_keys_only(monkeypatch):
    with pytest.raises(
        BadScene, match=r"lateral is only of motion = 'rolling' or 'transient', not 'again': leave it out"
    ):
        scene(motion="again", loads=LOADS, lateral=0.1)
    with pytest.raises(BadScene, match="loads must grow"):
        scene(motion="again", loads=LOADS[::-1])
    monkeypatch.setitem(MOTIONS, "again", replace(MOTIONS["again"], keys=("friction", "lateral"), growing=()))
    assert scene(motion="again", loads=LOADS[::-1], lateral=0.1).contact.friction.lateral == 0.1


def test_unknown_motions_are_refused():
    with pytest.raises(
        BadScene, match=r"contact\.motion = 'sliding': Input should be 'none', 'rolling', 'transient' or"
    ):
        scene(motion="sliding", loads=LOADS)
    with pytest.raises(WrongInput, match="motion = 'sliding': one of none, rolling, transient, compression"):
        problem(loads=(1e3,), motion="sliding", friction=FrictionSpecification((0.3,)))


@pytest.mark.parametrize("motion", MOTIONS)
def test_all_late_names_resolve(motion):
    """Names of what is imported late, and of the numbers that have a function."""
    of = MOTIONS[motion]
    assert all(quantity.evaluate for quantity in of.quantities.values())
    assert all(callable(one.resolved) for one in (of.solve, of.one_point) if one)
    assert (of.solve is not None) == of.has_friction


def test_rolling_needs_no_scene():
    """At large creepages all of a small contact slides: forces are friction times load."""
    friction = FrictionSpecification((0.3,), (-4e-3, 0.0, 4e-3), equal_force=0.3)
    of = problem(loads=(SMALL,), motion="rolling", friction=friction, ics=("A",), elements=8)
    result = solve_with_friction(of, lambda pair: solve_curve(pair, 0.3, "A"))
    for xi in (-4e-3, 4e-3):
        numbers = result.curve.points[xi].numbers
        assert numbers["sliding_share"] == 1.0
        assert numbers["F_x"] == pytest.approx(np.sign(xi) * 0.3 * SMALL, rel=5e-3)
    assert 0 < result.curve.free.numbers["equal_creepage"] < 4e-3
