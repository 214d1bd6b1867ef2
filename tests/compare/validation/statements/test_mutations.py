"""Closed forms are met, statements on contact hold, and criteria are missed where something is wrong.

C is made of approximations: nothing is solved but contacts. What changes all ICs alike is seen by statements
without ICs: circles of a wheel that are all alike change no criterion of statement 34.
"""

from dataclasses import replace

import numpy as np
import pytest

from compare.validation.statements import closed_forms, wheels
from compare.validation.statements.friction_contacts import SINGLE
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.runs import Runs
from femic.cache.store import Store
from femic.contact import small
from femic.contact.friction.motion import RollingKinematics, Shift, SteadyRolling
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.operators.approximations import approximate_matrix
from femic.contact.pairs import area_grids, planar
from femic.contact.pairs.areas import Areas, Coupling
from femic.contact.pairs.ics import GivenICs
from femic.contact.rolling import RollingProblem
from femic.contact.undeformed import TangentPlane, Undeformed
from femic.reference.run_options import RunOptions
from femic.scenes.load import load_scene
from geometries.errors import Failure
from geometries.patches import Grid
from tests.compare.validation.statements.mutations import (
    CRITERIA,
    cases_met,
    changed,
    mirrored,
    missed,
    quick_and_slow,
    remembering,
    times,
)

# --- closed forms, planar contact, narrow peaks, several patches ---------------------------------------


@pytest.fixture
def _fewer(monkeypatch):
    """One creepage and one force; A alone, one cone, one direction of loads, one grid of smaller elements."""
    monkeypatch.setattr(closed_forms, "CARTERS", (0.5,))
    monkeypatch.setattr(closed_forms, "SHIFTED", (0.6,))
    monkeypatch.setattr(wheels, "ICS", ("A",))
    monkeypatch.setattr(wheels, "SLOPES", (-1 / 10,))
    monkeypatch.setattr(wheels, "ROLLS", (0.03,))
    monkeypatch.setattr(wheels, "FINER", {"strips": (1, 2)})


@pytest.mark.usefixtures("_fewer")
@pytest.mark.parametrize("number", [44, pytest.param(46, marks=pytest.mark.slow), 47, 48])
def test_statements_hold_and_have_panels(number):
    runs = remembering()
    assert not missed([key for key in CRITERIA if key[0] == number], runs)
    assert list(STATEMENTS[number].panels(runs))


def spin_turned(right, self, creepages):
    return right(self, replace(creepages, spin=-creepages.spin))


def from_the_touching_point(right, self, s):
    return right(self, s) - right(self, self.touching[0])


def along_the_load(right, self):
    """Every pressure is along the load, in the problems of all areas."""

    def of_level(level):
        problems = [replace(problem, cosine=np.ones_like(problem.cosine)) for problem in level.problems]
        return replace(level, problems=tuple(problems))

    return of_level(right(self))


def uncoupled(_right, _self, _grids, p):
    return [np.zeros_like(own) for own in p]


VELOCITY = RollingKinematics, "rigid_velocity"
WITHOUT_ICS = {  # what is wrong, and the criteria that must miss
    "sign of rigid slip": (times(*VELOCITY, -1), {(44, "Kalker"), (44, "full slip")}),
    "sign of spin": (changed(*VELOCITY, spin_turned), {(44, "Kalker")}),
    "sign of the moment": (
        changed(RollingProblem, "weights", lambda right, self: {"spin": -right(self)["spin"]}),
        {(44, "Kalker")},
    ),
    "friction by a tenth": (  # the force by a shift hardly depends on friction
        times(FrictionalProblem, "bound", 1.1),
        {(44, "full slip"), (44, "Cattaneo tractions")},
    ),
    "displacements count twice in slip": (
        times(SteadyRolling, "elastic_slip", 2),
        {(44, "Carter"), (44, "Kalker")},
    ),
    "sign of the wheel's circles": (mirrored(*VELOCITY, "height"), {(44, "circles"), (44, "spin of cones")}),
    "height of the wheel to the other side": (
        times(Undeformed, "upper_height", -1),
        {(44, "circles"), (44, "spin of cones")},
    ),
    "height from the touching point": (
        changed(Undeformed, "upper_height", from_the_touching_point),
        {(44, "circles")},
    ),
    "sign of the wheel's fall and rise": (mirrored(*VELOCITY, "x"), {(44, "spin of cones")}),
    "sign of a shift": (times(Shift, "given", -1), {(44, "Cattaneo"), (44, "Cattaneo tractions")}),
    "the plane is tangent at the first touching point": (
        changed(planar, "planar", lambda right, bodies, *_: right(bodies)),
        {(46, "CONTACT")},
    ),
    "forces in planes by a tenth": (times(planar.PlanarPatch, "normal_force", 1.1), {(46, "Hertz")}),
    "distance over a plane by a thousandth": (times(TangentPlane, "distance", 1.001), {(46, "order")}),
    "no refinement": ((area_grids, "finer_grid", lambda *_: None), {(47, "unrefined")}),
    "no jump of the curvature": ((wheels, "SHARP", 199.0), {(47, "unrefined")}),
    "no coupling": (changed(Coupling, "displacements", uncoupled), {(48, "one grid"), (48, "Hertz")}),
    "the wheel moves to the other side": (mirrored(Areas, "distances_at", "roll"), {(48, "Hertz")}),
    "pressures carry the load as if they were along it": (
        changed(Areas, "levels", along_the_load),
        {(48, "load")},
    ),
    "the main patch alone": (
        changed(wheels.Wheel, "grids", lambda right, self: right(self)[-1:]),
        {(48, "second patch"), (48, "Hertz")},
    ),
}
QUICK = (
    *("friction by a tenth", "displacements count twice in slip"),
    *("no refinement", "no coupling", "the wheel moves to the other side"),
)


@pytest.mark.usefixtures("_fewer")
@pytest.mark.parametrize("mutation", quick_and_slow(WITHOUT_ICS, QUICK))
def test_wrong_signs_and_factors_miss_criteria(mutation, monkeypatch):
    """What is changed is in the solvers for any grid: nothing is left to compiled loops."""
    change, seen_by = WITHOUT_ICS[mutation]
    monkeypatch.setattr(small, "MOST_ELEMENTS", 0)
    monkeypatch.setattr(*change)
    assert seen_by == missed(seen_by)


def test_a_cone_rolls_on_its_circle_whichever_side_it_falls_to():
    """The circle of a point of the line of the wheel's contour beside the arc of its rail, by hand."""
    low, high = (closed_forms.Cone(delta) for delta in (0.1, -0.1))
    rail_y = 300 * np.sin(0.1)
    assert low.circle == pytest.approx(460 - (40 - rail_y) * np.tan(0.1))
    assert high.circle == pytest.approx(460 + (40 + rail_y) * np.tan(0.1))
    assert low.free > 0 > high.free
    # against the spin's lateral slip ahead, where tractions are low
    assert low.forces[1] < 0 < high.forces[1]
    for cone in (low, high):
        contour, touching = closed_forms.on_grid(cone).undeformed.upper.contour, 300 * np.sin(cone.delta) - 40
        assert 460 - contour.position(touching / np.cos(cone.delta))[1] == pytest.approx(cone.circle)


def test_errors_of_carter_are_those_of_force_and_width():
    """All of the contact slips in Carter's, half of it sticks here, with half of the force."""
    exact = closed_forms.TractiveRolling(closed_forms.CYLINDERS, 1000.0, 0.3, 1.0)
    dx = 2 * exact.half_width / 4
    p = np.full(4, 0.5 * exact.force / 4 / dx)
    stick = np.array([True, True, False, False])
    made = closed_forms.CarterContact(np.zeros(4), p, stick, dx, exact)
    assert (made.force_error, made.stick_error) == (pytest.approx(0.5), pytest.approx(0.5))


@pytest.mark.slow
def test_the_lateral_force_on_the_flange_is_less_than_that_of_the_other_planar_program():
    """By some percent: docs/theory/contact.md says why."""
    (share,) = wheels.planar_lateral(None).values()
    assert -0.05 < share < -0.02


# --- contacts of scenes, with C that is made of approximations -----------------------------------------


TABLE = {"n_x": 16, "n_s": 16, "dx": 1.7, "ds": 2.3, "s": 0.0}
COARSE = {
    "rolling": {"longitudinal": [-4e-3, -2e-3, -1e-3, 0.0, 1e-3, 3e-3]},
    "compression": {"loads": [20e3, 60e3, 100e3]},
}


class CoarseFriction(Runs):
    """Contacts on coarse elements, with C that is a mix."""

    def friction(self, name, changes, given=None):
        contact = changes["contact"] | {"grid": "scene", "ics": [*SINGLE, "C"]} | COARSE[name]
        contact.pop("elements", None)
        grid = Grid(*TABLE.values())
        ics = approximate_matrix("Bhat+sn:B+xn:Bhat_prime", load_scene("rolling").pair, grid)
        c = {"C": GivenICs(grid, ics)}
        return super().friction(name, {"contact": contact, "grid": TABLE}, c | (given or {}))


def cases_with_friction(number, folder):
    """Which criteria of a statement are met in which cases; none where nothing can be measured."""
    runs = CoarseFriction(RunOptions(1, Store(folder)), 1e-3)
    try:
        return {key: cases_met(runs, key) for key in CRITERIA if key[0] == number}
    except Failure:
        return {}


def longitudinal_turned(right, self):
    """What tractions contribute to the longitudinal force has the other sign."""
    weights = right(self)
    return weights | {"longitudinal": -weights["longitudinal"]}


def turned_back(right, self, approach):
    """An approach moves surfaces along s to the other side."""
    return 2 * self.given - right(self, approach)


WITH_FRICTION = {  # what is wrong, and the statement that must say so
    "sign of the longitudinal force": (changed(RollingProblem, "weights", longitudinal_turned), 35),
    "friction three times as large": (times(FrictionalProblem, "bound", 3), 36),
    "approach moves surfaces the other way": (changed(Shift, "given_at", turned_back), 37),
}


@pytest.mark.slow
@pytest.mark.parametrize("mutation", WITH_FRICTION)
def test_wrong_signs_and_factors_change_what_is_met_in_scenes(mutation, monkeypatch, tmp_path):
    change, number = WITH_FRICTION[mutation]
    monkeypatch.setattr(small, "MOST_ELEMENTS", 0)
    before = cases_with_friction(number, tmp_path / "right")
    assert before
    monkeypatch.setattr(*change)
    assert cases_with_friction(number, tmp_path / "wrong") != before
