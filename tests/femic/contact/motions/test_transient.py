"""Transient rolling of a pair: its distances, its estimates, C, failures."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.estimates import Measured
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion, transient
from femic.contact.motions.transient import (
    GROUP,
    TransientPath,
    interpolate_path,
    rolled_distance,
    solve_last_distance,
    solve_path,
    solve_transient,
)
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.rolling import RollingProblem
from femic.contact.specification import FrictionSpecification
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid
from tests.femic.contact.pairs.problems import problem
from tests.femic.contact.problems import Products

LOAD = 2000.0
GRID = Grid(24, 24, 0.6, 0.13)


def pair(grid=GRID, **keys):
    friction = FrictionSpecification((0.3,), **keys)
    of = problem(loads=(LOAD,), motion="transient", friction=friction, ics=("Bhat",), grid=grid)
    return pair_in_motion(of, pair_on_grid(of, grid))


@pytest.fixture(scope="module")
def solved():
    return solve_transient(pair(distance=4.7), 0.3, "Bhat")


def test_distances_are_steps_of_an_element_up_to_a_multiple_of_four(solved):
    np.testing.assert_allclose(solved.distance, 0.6 * np.arange(9))
    assert solved.F_x.shape == solved.estimate_F_x.shape == solved.simplified.shape == (9,)
    assert rolled_distance(pair(distance=4.8)) == pytest.approx(4.8)
    assert rolled_distance(pair(distance=4.81)) == pytest.approx(7.2)
    with pytest.raises(
        WrongInput, match=r"contact\.distance = 1e\+06 mm: more than 4000 elements of 0\.6 mm"
    ):
        rolled_distance(pair(distance=1e6))


def test_by_default_three_lengths_of_the_patch_are_rolled():
    of = pair()
    contact = of.on_grid.solve(of.on_grid.operator("Bhat"), Loading(LOAD)).normal
    ((low, high),) = [patch.x for patch in contact.patches]
    rolled = rolled_distance(of) - 3 * (high - low) * GRID.dx
    assert 0 <= rolled < GROUP * GRID.dx


def test_a_long_transient_from_rest_ends_at_the_steady_numbers():
    path = solve_path(pair(distance=20.0), pair().frictional(pair().operator("Bhat"), 0.3), "long")
    assert path.steady is not None
    for name, steady in path.steady.numbers.items():
        assert path.steps[-1].numbers[name] == pytest.approx(steady, rel=1e-4, abs=1e-4 * 0.3 * LOAD)
    assert path.steps[0].numbers["F_x"] == pytest.approx(0.0, abs=1e-5 * LOAD)
    assert path.steps[1].numbers["F_x"] > 0.05 * 0.3 * LOAD
    assert path.steps[2].numbers["F_x"] < 0.9 * path.steady.numbers["F_x"]


def test_creepages_of_the_specification_are_used():
    """A driven wheel is pushed on; lateral slip is resisted, and so is spin."""

    def last(**creepages):
        of = pair(distance=2.4, **creepages)
        place, numbers = solve_last_distance(of, of.frictional(of.operator("A"), 0.3), "A")
        assert place == pytest.approx(2.4)
        return numbers

    driven, braked = last(creepage=2e-3), last(creepage=-2e-3)
    assert driven["F_x"] > 0.5 * 0.3 * LOAD > -0.5 * 0.3 * LOAD > braked["F_x"]
    assert last(creepage=0.0, lateral=2e-3)["F_y"] < -0.5 * 0.3 * LOAD
    assert abs(driven["F_y"]) < 1e-4 * LOAD
    assert last(creepage=0.0, spin=2e-3)["M_z"] < -10 * abs(driven["M_z"])


def test_numbers_on_larger_elements_are_interpolated_between_steps():
    steps = [Measured({"F_x": value}, {}, {}) for value in (0.0, 4.0, 5.0)]
    path = TransientPath(np.array([0.0, 2.0, 4.0]), steps, None, [], None)
    rows = interpolate_path(path, np.arange(5.0))
    assert [row.numbers["F_x"] for row in rows] == [0.0, 2.0, 4.0, 4.5, 5.0]


def test_estimates_hold_against_elements_half_as_large(solved):
    fine = pair(Grid(48, 48, 0.3, 0.065), distance=4.7)
    path = solve_path(fine, fine.frictional(fine.operator("Bhat"), 0.3), "fine")
    finer = interpolate_path(path, solved.distance.values)
    for name in ("F_x", "F_y", "M_z", "p_max", "area", "sliding_share", "approach"):
        away = abs(solved[name] - [step.numbers[name] for step in finer])
        assert np.mean(away <= solved[f"estimate_{name}"]) >= 0.85, name
    assert solved.estimate_F_x[4] < 0.2 * solved.F_x[4]


def test_errors_with_c_include_the_change_by_its_estimate(monkeypatch, solved):
    """Of compliances that may be a tenth larger, as the approach of Hertz at a load."""
    of = pair(distance=2.4)
    reference = SimpleNamespace(operator=of.operator("Bhat"), perturbed=Products(of.operator("Bhat"), 1.1))
    monkeypatch.setattr(
        "femic.contact.pairs.pair_with_friction.full_reference_ics", lambda *_, **__: reference
    )
    with_c = solve_transient(of, 0.3, "C")
    for name in ("approach", "F_x"):
        assert with_c[name][2] == solved[name][2]
        assert with_c[f"estimate_{name}"][2] > solved[f"estimate_{name}"][2]
    growth = float((with_c.estimate_approach - solved.estimate_approach)[2])
    assert growth == pytest.approx((1.1 ** (2 / 3) - 1) * float(solved.approach[2]), rel=0.1)
    assert with_c.estimate_steady_approach > solved.estimate_steady_approach


def test_failures_name_the_label_and_the_distance(monkeypatch):
    def failing(self, creepages, *_):
        yield self.contact(creepages, Loading(LOAD))
        raise Failure("no solution")

    monkeypatch.setattr(RollingProblem, "transient", failing)
    of = pair(distance=2.4)
    with pytest.raises(Failure, match=r"mine, 0\.6 mm: no solution"):
        solve_path(of, of.frictional(of.operator("A"), 0.3), "mine")


def raising(failure):
    def failing(*_, **__):
        raise failure

    return failing


def test_missing_steady_rolling_leaves_its_numbers_unknown(monkeypatch):
    monkeypatch.setattr(RollingProblem, "contact", raising(Failure("no")))
    result = solve_transient(pair(distance=2.4), 0.3, "A")
    assert np.isnan(result.steady_F_x)
    assert np.isnan(result.estimate_steady_F_x)
    assert result.estimate_F_x[2] > 0


def test_short_grids_raise(monkeypatch):
    monkeypatch.setattr(RollingProblem, "contact", raising(PotentialAreaTooSmall(("x < 0",), Loading(LOAD))))
    with pytest.raises(PotentialAreaTooSmall):
        solve_transient(pair(distance=2.4), 0.3, "A")


def test_errors_are_unknown_where_larger_elements_have_no_solution(monkeypatch):
    def fine_only(pair, problem, label):
        if "larger" in label:
            raise Failure("no")
        return solve_path(pair, problem, label)

    monkeypatch.setattr(transient, "solve_path", fine_only)
    result = solve_transient(pair(distance=2.4), 0.3, "A")
    assert np.all(np.isnan(result.estimate_F_x))
