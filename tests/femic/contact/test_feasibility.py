"""Contacts that have no solution are refused before anything is solved, with the reason and a remedy."""

import numpy as np
import pytest

from femic.contact.exact.creepage_coefficients import creepage_coefficients
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.feasibility import impossible
from femic.contact.motions.rolling import BEYOND
from femic.results.contact import require_solvable, solve_scene
from femic.results.friction import compute_with_friction
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene
from tests.approx.new_forms import register
from tests.femic.contact.wheel_on_rail import FLANKS, RADIUS, ROLLING, STEEL, WHEEL
from tests.femic.contact.wheel_on_rail import scene as wheel_on_rail

SPREAD = 2 * (2 * RADIUS * np.radians(FLANKS))  # arc and flanks: what the bodies may touch over


def scene(upper=(), lower=(), **contact):
    """A wheel on a rail, whose contact would be solved by A."""
    return wheel_on_rail(upper=upper, lower=lower, **{"ics": ["A"], "loads": [100.0]} | contact)


PRISMATIC = {"rolling_radius": float("inf")}
MODULUS = combined_modulus(*[scene().bodies[name].material for name in ("upper", "lower")])
BEARABLE = MODULUS * SPREAD**2
LARGEST_SIDEWAYS = 100.0 * np.tan(np.radians(FLANKS))
UPPER_ENDS = {"kind": "points", "points": [[y, -(y**2) / 60] for y in np.linspace(-6, 6, 25)]}  # flatter
LIMITS = {  # what is allowed, what is not, and what is said
    "parallel cylinders": (
        {"upper": {"rolling_radius": 1e5}},
        {"upper": PRISMATIC},
        r"upper\.rolling_radius = inf: two prismatic bodies touch along .*give upper\.rolling_radius",
    ),
    "parallel cylinders on a grid": (
        {"grid": "scene"},
        {"upper": PRISMATIC, "grid": "scene"},
        r"upper\.rolling_radius = inf",
    ),
    "a lower wheel": (
        {},
        {"lower": {"rolling_radius": 300.0}},
        r"lower\.rolling_radius = 300: in contact the lower body must be prismatic; leave this key out, "
        "or exchange",
    ),
    "a load": (
        {"loads": [1.0, 0.99 * BEARABLE]},
        {"loads": [1.0, 1.01 * BEARABLE]},
        r"contact\.loads\.1 = .*: strains would be larger than 1: .* give a smaller load, or larger E",
    ),
    "a modulus": (
        {"lower": {"E": 1.0}},
        {"lower": {"E": 1e-3}},
        r"contact\.loads\.0 = 100: strains would be larger than 1: .* with E\* = 0\.0011 MPa",
    ),
    "an approach": (
        {"loads": [], "approaches": [0.99 * SPREAD]},
        {"loads": [], "approaches": [1.01 * SPREAD]},
        r"contact\.approaches\.0 = 42\.3.*: strains would exceed 1",
    ),
    "a place": (
        {"shift": -0.5},
        {"shift": -1.01 * SPREAD},
        r"contact\.shift = -42\.3.*: more than the 41\.8879 mm over which the bodies may touch",
    ),
    "contours that do not fit": (
        {"upper": {"contour": {"kind": "plane"}}},
        {"lower": {"contour": {"kind": "arc", "radius": -20.0, "flank_inclination_deg": FLANKS}}},
        r"contact\.shift = 0: the bodies touch first at the end of a contour, s = -?41\.8",
    ),
    "a cylinder on a plane": (
        {},
        {"lower": {"contour": {"kind": "plane"}}, "upper": {"contour": {"kind": "plane"}}},
        r"lower\.contour, upper\.contour: the bodies touch everywhere, .*; give contours of different shape",
    ),
    "the end of the upper contour": (
        {"upper": {"contour": UPPER_ENDS}},
        {"upper": {"contour": UPPER_ENDS}, "shift": 5.0},
        r"contact\.shift = 5: the bodies touch first at the end of a contour, s = -",
    ),
    "a lateral force": (
        {"lateral_force": -0.99 * LARGEST_SIDEWAYS},
        {"lateral_force": -1.01 * LARGEST_SIDEWAYS},
        r"contact\.lateral_force = -174\.9.*: without friction it is at most 173\.2 N at 100 N",
    ),
}


@pytest.mark.parametrize("name", LIMITS)
def test_contact_without_solution_is_refused_beyond_its_limit(name):
    allowed, refused, says = LIMITS[name]
    require_solvable(scene(**allowed))
    with pytest.raises(BadScene, match=rf"pair: 1 error\(s\)\n  {says}"):
        require_solvable(scene(**refused))


def test_parallel_cylinders_are_allowed_with_a_gap_that_varies_along_x(tmp_path):
    """It is refused where the gap is the same at all x."""
    x, s = (values.ravel() for values in np.meshgrid(np.linspace(-9, 9, 19), [-9.0, 9.0]))
    gap = tmp_path / "gap.txt"
    np.savetxt(gap, np.column_stack([x, s, 1e-3 * x**2]))
    of = scene(upper=PRISMATIC, extra_gap=str(gap), elements=8)
    (contact,) = solve_scene(of).contacts.values()
    assert contact.normal.load == pytest.approx(100.0)
    np.savetxt(gap, [(-9.0, 0.0), (9.0, 0.0)])
    with pytest.raises(BadScene, match=r"upper\.rolling_radius = inf"):
        require_solvable(scene(upper=PRISMATIC, extra_gap=str(gap)))


def misfits(**contact):
    """What makes rolling impossible that starts without creepage."""
    of = scene(motion="rolling", **contact)
    return list(impossible(of.contact_problem))


def test_forces_of_rolling_beyond_those_without_slip_are_refused():
    """Kalker's, on the ellipse of Hertz: a crown of another radius beside it adds a millionth."""
    load, creepage, share = 100.0, 0.02, 0.25
    ellipse = PointContact(1 / ROLLING, 1 / RADIUS - 1 / WHEEL, MODULUS).at_load(load)
    G = STEEL["E"] / (2 * (1 + STEEL["nu"]))
    coefficients = creepage_coefficients(ellipse.a, ellipse.b, STEEL["nu"])
    without_slip, _, _ = coefficients.forces(G, creepage, 0.0, 0.0)
    limit = BEYOND * without_slip / (share * load)
    keys = {"longitudinal": [-creepage, 0.0], "equal_force": -share}
    assert misfits(friction=[0.3, 0.98 * limit], **keys) == []
    (message,) = misfits(friction=[0.3, 1.02 * limit], **keys)
    assert message.startswith(f"contact.friction.1 = {1.02 * limit:g}: tractions are compared at F_x = ")
    assert "give larger ones in contact.longitudinal, less friction, or a smaller equal_force" in message


def test_the_force_at_which_ics_are_compared_need_not_be_within_the_creepages():
    """Nobody wrote it: it is that of a curve to creepages that reach it."""
    few = {"motion": "rolling", "loads": [100.0], "friction": [0.3], "elements": 8}
    numbers = []
    for largest in (1e-6, 0.01):
        of = scene(**few, longitudinal=[-largest, 0.0, largest])
        require_solvable(of)
        numbers.append(compute_with_friction(of).equal_creepage.item())
    assert numbers[0] == pytest.approx(numbers[1], rel=1e-4)
    assert numbers[0] > 10e-6


def test_a_force_beyond_friction_at_any_angle_is_refused():
    """Inclined places may carry more than the load, but not `BEYOND` times as much."""
    keys = {"friction": [0.3], "longitudinal": [-0.01, 0.0], "equal_force": 0.6}

    def with_largest(factor):
        return misfits(friction_by_angle=[[0, 0.1], [20, factor]], **keys)

    assert with_largest(1.02 * 0.6 / BEYOND) == []
    (message,) = with_largest(0.98 * 0.6 / BEYOND)
    assert message.startswith("contact.equal_force = 0.6: ")
    assert "give a smaller equal_force, or larger factors" in message


def test_enormous_friction_is_refused_before_any_work():
    with pytest.raises(BadScene, match=r"rolling: 1 error\(s\)\n  contact\.friction\.0 = 1000: "):
        require_solvable(load_scene("rolling", {"contact": {"friction": [1000.0]}}))


@pytest.mark.parametrize("motion", [{}, {"motion": "rolling", "friction": [0.3]}])
def test_form_that_is_not_symmetric_in_x_is_refused_before_any_work(motion, monkeypatch):
    register(monkeypatch)
    require_solvable(scene(ics=["A", "Alength", "Btilde"], **motion))
    with pytest.raises(BadScene, match=r"contact\.ics: variant = 'Askew': its ICs at -x.*leave it out"):
        require_solvable(scene(ics=["A", "Askew"], **motion))
