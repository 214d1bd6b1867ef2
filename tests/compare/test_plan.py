"""The seconds of a whole plan."""

from compare import plan
from femic.plan import Planned


def step(engine, seconds):
    return plan.Step("", engine, 1.0, 1.0, "", Planned(1, 1, 1, False, seconds, 1.0))


def test_solid_models_are_solved_side_by_side_harmonic_ones_one_after_the_other():
    steps = [step("harmonic", 3.0), step("harmonic", 4.0), step("solid", 10.0), step("solid", 20.0)]
    assert plan.seconds(steps, 1) == 37.0
    assert plan.seconds(steps, 5) == 7.0 + 6.0
    assert plan.seconds(steps[:2], 5) == 7.0
