"""A motion is one registration: scenes, contact and its arrays know it, or say what they lack."""

from dataclasses import replace

import pytest
import xarray as xr

from compare.pages import friction_pages as pages
from compare.pages.friction_pages import require_page
from femic.contact.motions import MOTIONS, find_motion
from femic.contact.specification import ContactSpecification, FrictionSpecification
from femic.results.friction import compute_with_friction
from femic.scenes.errors import BadScene
from geometries.errors import WrongInput
from tests.femic.contact.wheel_on_rail import scene

LOADS = [1e3, 2e3]


@pytest.fixture
def again(monkeypatch):
    """A motion with the keys of compression, whose solutions are one number."""

    def solve(pair, friction, _):
        return xr.Dataset({"number": ((), friction), "seconds": ((), pair.on_grid.grid.dx)})

    monkeypatch.setitem(MOTIONS, "again", replace(MOTIONS["compression"], title="Again", solve=solve))


def pressed(motion):
    return scene(13.0, motion=motion, loads=LOADS, friction=[0.3], ics=["A"], elements=8)


@pytest.mark.usefixtures("again")
def test_registered_motion_is_solved():
    dataset = compute_with_friction(pressed("again"))
    assert dataset.number.values.tolist() == [[0.3]]
    assert dataset.attrs["title"].startswith("Again: ")


@pytest.mark.usefixtures("again")
def test_a_missing_page_of_a_motion_is_reported_before_any_work(monkeypatch):
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
    with pytest.raises(BadScene, match="loads must increase"):
        scene(motion="again", loads=LOADS[::-1])
    monkeypatch.setitem(MOTIONS, "again", replace(MOTIONS["again"], keys=("friction", "lateral"), growing=()))
    assert scene(motion="again", loads=LOADS[::-1], lateral=0.1).contact.friction.lateral == 0.1


def test_unknown_motions_are_refused():
    with pytest.raises(
        BadScene, match=r"contact\.motion = 'sliding': Input should be 'none', 'rolling', 'transient' or"
    ):
        scene(motion="sliding", loads=LOADS)
    sliding = ContactSpecification("sliding", friction=FrictionSpecification((0.3,)))
    with pytest.raises(WrongInput, match="motion = 'sliding': one of none, rolling, transient, compression"):
        find_motion(sliding)
