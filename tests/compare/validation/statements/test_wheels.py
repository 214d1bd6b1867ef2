"""Statements on planar contact, narrow peaks, several patches hold; what is wrong misses their criteria."""

from dataclasses import replace

import numpy as np
import pytest

from compare.validation.statements import wheels
from compare.validation.statements.page import STATEMENTS
from femic.contact.pairs import area_grids, planar
from femic.contact.pairs.areas import Areas, Coupling
from femic.contact.undeformed import TangentPlane
from tests.compare.validation.statements.mutations import CRITERIA, missed, quick_and_slow, remembering

OF_WHEELS = [key for key in CRITERIA if key[0] in (46, 47, 48)]
IN_PLANE, FORCE, DISTANCE = planar.planar, planar.PlanarPatch.normal_force.fget, TangentPlane.distance
DISTANCES, LEVELS, GRIDS = Areas.distances_at, Areas.levels.func, wheels.Wheel.grids.func


@pytest.fixture(autouse=True)
def _fewer(monkeypatch):
    """A alone, one cone, one direction of the load, one grid of smaller elements."""
    monkeypatch.setattr(wheels, "ICS", ("A",))
    monkeypatch.setattr(wheels, "SLOPES", (-1 / 10,))
    monkeypatch.setattr(wheels, "ROLLS", (0.03,))
    monkeypatch.setattr(wheels, "FINER", {"strips": (1, 2)})


@pytest.mark.parametrize("number", [pytest.param(46, marks=pytest.mark.slow), 47, 48])
def test_statements_hold_and_have_panels(number):
    assert not missed([key for key in OF_WHEELS if key[0] == number])
    assert list(STATEMENTS[number].panels(remembering()))


@pytest.mark.slow
def test_the_lateral_force_on_the_flange_is_less_than_that_of_the_other_planar_program():
    """By some percent: docs/theory/contact.md says why."""
    (share,) = wheels.planar_lateral(None).values()
    assert -0.05 < share < -0.02


def along_the_load(level):
    """Problems of all areas in which every pressure is along the load."""
    problems = [replace(problem, cosine=np.ones_like(problem.cosine)) for problem in level.problems]
    return replace(level, problems=tuple(problems))


MUTATIONS = {  # what is wrong, and the criteria that must miss
    "the plane is tangent at the first touching point": (
        planar,
        "planar",
        lambda bodies, *_: IN_PLANE(bodies),
        {(46, "CONTACT")},
    ),
    "forces in planes by a tenth": (
        planar.PlanarPatch,
        "normal_force",
        property(lambda self: 1.1 * FORCE(self)),
        {(46, "Hertz")},
    ),
    "distance over a plane by a thousandth": (
        TangentPlane,
        "distance",
        lambda self, *place: 1.001 * DISTANCE(self, *place),
        {(46, "order")},
    ),
    "no refinement": (area_grids, "finer_grid", lambda *_: None, {(47, "unrefined")}),
    "no jump of the curvature": (wheels, "SHARP", 199.0, {(47, "unrefined")}),
    "no coupling": (
        Coupling,
        "displacements",
        lambda _self, _grids, p: [np.zeros_like(own) for own in p],
        {(48, "one grid"), (48, "Hertz")},
    ),
    "the wheel moves to the other side": (
        Areas,
        "distances_at",
        lambda self, approach: DISTANCES(replace(self, roll=-self.roll), approach),
        {(48, "Hertz")},
    ),
    "pressures carry the load as if they were along it": (
        Areas,
        "levels",
        property(lambda self: along_the_load(LEVELS(self))),
        {(48, "load")},
    ),
    "the main patch alone": (
        wheels.Wheel,
        "grids",
        property(lambda self: GRIDS(self)[-1:]),
        {(48, "second patch"), (48, "Hertz")},
    ),
}
QUICK = ("no refinement", "no coupling", "the wheel moves to the other side")


@pytest.mark.parametrize("mutation", quick_and_slow(MUTATIONS, QUICK))
def test_what_is_wrong_misses_criteria(mutation, monkeypatch):
    target, name, wrong, seen_by = MUTATIONS[mutation]
    monkeypatch.setattr(target, name, wrong)
    assert seen_by == missed(seen_by)
