"""The measures of closed forms hold, and each misses its threshold where a sign or a factor is wrong."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact import frictional
from femic.contact.friction.kinematics import RollingKinematics
from femic.contact.friction.motion import Shift, SteadyRolling
from femic.contact.rolling import RollingProblem
from femic.validation.statements import closed_forms
from femic.validation.statements.registry import STATEMENTS
from tests.femic.validation.statements.friction_makers import BY_CLOSED_FORMS

CRITERIA = {criterion.name: criterion for criterion in STATEMENTS[44].criteria}
RUNS = SimpleNamespace(remembered=lambda _, compute: compute(RUNS))
VELOCITY, BOUND = RollingKinematics.rigid_velocity, frictional.FrictionalProblem.bound
SLIP, GIVEN, WEIGHTS = SteadyRolling.slip_of, Shift.given.fget, RollingProblem.weights.func


def missed(names=CRITERIA):
    """Those of some criteria that are missed in some case."""
    chosen = {name: CRITERIA[name] for name in names}
    return {
        name
        for name, criterion in chosen.items()
        if not all(map(criterion.met, criterion.measure(RUNS).values()))
    }


@pytest.fixture(autouse=True)
def _fewer(monkeypatch):
    """One creepage and one force."""
    monkeypatch.setattr(closed_forms, "CARTERS", (0.5,))
    monkeypatch.setattr(closed_forms, "SHIFTED", (0.6,))


def test_all_criteria_are_named():
    assert {(44, name) for name in CRITERIA} == BY_CLOSED_FORMS


def test_closed_forms_are_met():
    assert not missed()


MUTATIONS = {  # what is wrong, and the criteria that must miss
    "sign of rigid slip": (
        RollingKinematics,
        "rigid_velocity",
        lambda self, creepages: -VELOCITY(self, creepages),
        {"Kalker", "full slip"},
    ),
    "sign of spin": (
        RollingKinematics,
        "rigid_velocity",
        lambda self, creepages: VELOCITY(self, replace(creepages, spin=-creepages.spin)),
        {"Kalker"},
    ),
    "sign of the moment": (
        RollingProblem,
        "weights",
        property(lambda self: {"spin": -WEIGHTS(self)["spin"]}),
        {"Kalker"},
    ),
    "friction by a tenth": (
        frictional.FrictionalProblem,
        "bound",
        lambda self, pressures: 1.1 * BOUND(self, pressures),
        {"full slip", "Cattaneo tractions"},  # the force by a shift hardly depends on friction
    ),
    "displacements count twice in slip": (
        SteadyRolling,
        "slip_of",
        lambda self, u: 2 * SLIP(self, u),
        {"Carter", "Kalker"},
    ),
    "sign of a shift": (
        Shift,
        "given",
        property(lambda self: -GIVEN(self)),
        {"Cattaneo", "Cattaneo tractions"},
    ),
}


QUICK = ("friction by a tenth", "displacements count twice in slip")


@pytest.mark.parametrize(
    "mutation",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in MUTATIONS],
)
def test_wrong_signs_and_factors_miss_criteria(mutation, monkeypatch):
    target, name, wrong, seen_by = MUTATIONS[mutation]
    monkeypatch.setattr(target, name, wrong)
    assert seen_by == missed(seen_by)


def test_errors_of_carter_are_those_of_force_and_width():
    """All of the contact slips in Carter's, half of it sticks here, with half of the force."""
    exact = closed_forms.TractiveRolling(closed_forms.CYLINDERS, 1000.0, 0.3, 1.0)
    dx = 2 * exact.half_width / 4
    p = np.full(4, 0.5 * exact.force / 4 / dx)
    stick = np.array([True, True, False, False])
    made = closed_forms.CarterContact(np.zeros(4), p, stick, dx, exact)
    assert made.force_error == pytest.approx(0.5)
    assert made.stick_error == pytest.approx(0.5)
