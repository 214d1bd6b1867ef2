"""What a plan says of the seconds of its models."""

import pytest

from compare.pages.matrix import cost_table
from femic.reference.engine import Cost, ExpectedCost
from femic.reference.engines import ENGINES
from femic.reference.refinement import ModelPlan, total_seconds
from femic.results.ics import run_plans
from femic.scenes.load import load_scene


def step(engine, expected):
    expected_cost = ExpectedCost(
        unknowns=1000, wavenumbers=20, fields=3, half_section=True, seconds=expected, memory=100.0
    )
    return ModelPlan("a model", ENGINES[engine], 1.0, 100.0, "infinite", expected_cost)


@pytest.mark.parametrize(("workers", "expected"), [(1, 3 + 5 + 8 + 4), (2, 3 + 5 + 6), (4, 3 + 5 + 3)])
def test_models_of_the_solid_engine_share_the_workers_those_of_the_harmonic_follow_each_other(
    workers, expected
):
    """A harmonic model uses all workers by itself: its own seconds already count them."""
    model_plans = [step("harmonic", 3.0), step("solid", 8.0), step("harmonic", 5.0), step("solid", 4.0)]
    assert total_seconds(model_plans, workers) == pytest.approx(expected)


def test_no_models_take_no_time():
    assert total_seconds([], 2) == 0


def models_of(check):
    scene = load_scene("flat", {"bodies": ["lower"], "engine": {"check": check, "tolerance": 0.1}})
    return {one.name: one.cells for one in run_plans(scene, 1)}


def test_a_run_plans_the_models_of_the_scene_and_those_of_its_check():
    harmonic = {"lower, fine": 1.0}
    assert models_of(False) == pytest.approx(harmonic)
    solid = {"check, lower, fine": 1.0, "check, lower, coarse": 1.5, "check, lower, small": 1.5}
    assert models_of(True) == pytest.approx(harmonic | solid)


@pytest.mark.parametrize(
    ("engine", "solver", "told"),
    [("harmonic", "direct, 27 wavenumbers", "20 / 27"), ("solid", "multigrid", "20 / –")],
)
def test_wavenumbers_are_shown_beside_those_planned(engine, solver, told):
    cost = Cost(1200, 100, solver, (), 1e-12, {"mesh": 1.0, "solution": 2.0}, 150.0)
    (row,) = cost_table([step(engine, 4.0)], {"a model": cost, "another": cost}).rows
    assert row.cells == ["1,000 / 1,200", told, "4 / 3", "100 / 150"]
