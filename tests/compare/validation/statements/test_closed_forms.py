"""The measures of closed forms hold, and each misses its threshold where a sign or a factor is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from compare.validation.statements import closed_forms
from femic.contact import frictional
from femic.contact.friction.motion import RollingKinematics, Shift, SteadyRolling
from femic.contact.rolling import RollingProblem
from femic.contact.undeformed import Undeformed
from tests.compare.validation.statements.mutations import CRITERIA, missed, quick_and_slow

VELOCITY, BOUND = RollingKinematics.rigid_velocity, frictional.FrictionalProblem.bound
SLIP, GIVEN, WEIGHTS = SteadyRolling.elastic_slip, Shift.given.fget, RollingProblem.weights.func
HEIGHT = Undeformed.upper_height


@pytest.fixture(autouse=True)
def _fewer(monkeypatch):
    """One creepage and one force."""
    monkeypatch.setattr(closed_forms, "CARTERS", (0.5,))
    monkeypatch.setattr(closed_forms, "SHIFTED", (0.6,))


def test_closed_forms_are_met():
    assert not missed(key for key in CRITERIA if key[0] == 44)


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
        "elastic_slip",
        lambda self, u: 2 * SLIP(self, u),
        {"Carter", "Kalker"},
    ),
    "sign of the wheel's circles": (
        RollingKinematics,
        "rigid_velocity",
        lambda self, creepages: VELOCITY(replace(self, height=-self.height), creepages),
        {"circles", "spin of cones"},
    ),
    "height of the wheel to the other side": (
        Undeformed,
        "upper_height",
        lambda self, s: -HEIGHT(self, s),
        {"circles", "spin of cones"},
    ),
    "height from the touching point": (
        Undeformed,
        "upper_height",
        lambda self, s: HEIGHT(self, s) - HEIGHT(self, self.touching[0]),
        {"circles"},
    ),
    "sign of the wheel's fall and rise": (
        RollingKinematics,
        "rigid_velocity",
        lambda self, creepages: VELOCITY(replace(self, x=-self.x), creepages),
        {"spin of cones"},
    ),
    "sign of a shift": (
        Shift,
        "given",
        property(lambda self: -GIVEN(self)),
        {"Cattaneo", "Cattaneo tractions"},
    ),
}


QUICK = ("friction by a tenth", "displacements count twice in slip")


@pytest.mark.parametrize("mutation", quick_and_slow(MUTATIONS, QUICK))
def test_wrong_signs_and_factors_miss_criteria(mutation, monkeypatch):
    target, name, wrong, names = MUTATIONS[mutation]
    monkeypatch.setattr(target, name, wrong)
    seen_by = {(44, name) for name in names}
    assert seen_by == missed(seen_by)


def test_a_cone_rolls_on_its_circle_whichever_side_it_falls_to():
    """The circle of a point of the line of the wheel's contour beside the arc of its rail, by hand."""
    low, high = (closed_forms.Cone(delta) for delta in (0.1, -0.1))
    rail_y = 300 * np.sin(0.1)
    assert low.circle == pytest.approx(460 - (40 - rail_y) * np.tan(0.1))
    assert high.circle == pytest.approx(460 + (40 + rail_y) * np.tan(0.1))
    assert low.free > 0 > high.free
    assert (
        low.forces[1] < 0 < high.forces[1]
    )  # against the spin's lateral slip ahead, where tractions are low
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
    assert made.force_error == pytest.approx(0.5)
    assert made.stick_error == pytest.approx(0.5)
