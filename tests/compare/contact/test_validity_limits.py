"""Crossings: known ones of laws, scaled ICs, no error on planes, and the same on finer grids."""

from dataclasses import replace

import numpy as np
import pytest

from compare.studies.validity_limits import (
    NUMBERS,
    Deviation,
    Ladder,
    PairDeviations,
    find_crossing,
    solve_deviations,
)
from femic.cache.store import Store
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import numbers
from femic.reference.run_options import RunOptions
from geometries.errors import Failure, WrongInput
from tests.femic.contact.wheel_on_rail import scene

LOADS = np.geomspace(1e3, 1e6, 7)
ESTIMATE = 0.004


def law(error, estimate=ESTIMATE):
    """A law whose angle is the third root of the load, and whose error is a function of the angle."""
    return lambda load: Deviation(load, load ** (1 / 3), 0.5, error(load ** (1 / 3)), estimate)


@pytest.mark.parametrize(
    ("error", "angle", "stays"),
    [
        (lambda angle: 1e-5 * angle**2, np.sqrt(5000), True),
        (lambda angle: -1e-5 * angle**2, np.sqrt(5000), True),
        # a sine of amplitude 10 % passes 5 % at a sixth of half of its period, and comes back
        (lambda angle: 0.1 * np.sin(np.pi * angle / 80), 80 / 6, False),
    ],
)
def test_the_first_crossing_is_found_with_either_sign(error, angle, stays):
    """Angles go like the third root of loads."""
    found = find_crossing(law(error), LOADS, 0.05)
    assert found.at.angle == pytest.approx(angle, rel=0.01)
    assert found.at.error == pytest.approx(error(found.at.angle))
    assert abs(found.at.error) == pytest.approx(0.05, rel=0.01)
    assert not found.before
    assert found.stays == stays
    assert found.end.load == pytest.approx(1e6)
    if stays:
        assert found.at.angle == pytest.approx(angle, rel=0.01 / 3)
        assert found.largest.load == found.end.load


def test_the_error_of_a_crossing_is_that_of_the_error_over_its_slope_and_that_of_the_angle():
    """On a straight line 1e-3 angle an error of 0.4 % is 4 degrees; the angle is known to 0.5."""
    found = find_crossing(law(lambda angle: 1e-3 * angle), LOADS, 0.05, accuracy=1e-9)
    assert found.estimate == pytest.approx(ESTIMATE / 1e-3 + 0.5)


@pytest.mark.parametrize("accuracy", [0.3, 0.08, 0.01])
@pytest.mark.parametrize("power", [1 / 3, 1.0])
def test_the_accuracy_of_the_load_is_part_of_the_error_of_a_crossing(accuracy, power):
    """All else is known: the angle is load^power, the error 1e-3 times its square root.

    The estimate covers the true error in crossings all over an interval. It is the accuracy times a slope of
    the angle over log load: at most the steepest one there, and at least that of a chord below the crossing.
    """
    interval = power * np.log(LOADS[3] / LOADS[2])
    chord = -np.expm1(-interval) / interval  # of its slope over that at its upper end
    for exact in np.geomspace(1.2e4, 3e4, 7):

        def known(load):
            return Deviation(load, load**power, 0.0, 1e-3 * load ** (power / 2), 0.0)

        found = find_crossing(known, LOADS, 1e-3 * exact ** (power / 2), accuracy)
        assert 0 < abs(found.at.angle - exact**power) <= found.estimate
        at, above = (power * angle * accuracy for angle in (found.at.angle, LOADS[3] ** power))
        assert chord * at * (1 - 1e-9) <= found.estimate <= above * (1 + 1e-9)


def test_a_crossing_at_a_load_that_was_solved_first_is_exact():
    """The error is the tolerance at one of them, or beyond it at the first."""

    def known(load):
        return Deviation(load, load ** (1 / 3), 0.5, 1e-6 * load, 0.0)

    assert find_crossing(known, LOADS, 1e-6 * LOADS[3], accuracy=0.1).estimate == 0.5
    assert find_crossing(known, LOADS, 1e-6, accuracy=0.1).estimate == 0.5


def test_no_crossing_has_the_largest_error_and_the_end_and_an_earlier_one_was_before():
    """The error is largest at angle 50 and within the tolerance everywhere; then large from the beginning."""
    found = find_crossing(law(lambda angle: 0.04 * np.exp(-(((angle - 50) / 20) ** 2))), LOADS, 0.05)
    assert found.at is None
    assert np.isnan(found.estimate)
    assert abs(found.largest.angle - 50) < 10
    assert found.end.angle == pytest.approx(100.0)
    found = find_crossing(law(lambda _: -0.2), LOADS, 0.05)
    assert found.before
    assert found.at.load == LOADS[0]


@pytest.mark.parametrize("loads", [[1e3], [2e3, 1e3]])
def test_loads_that_do_not_grow_are_refused(loads):
    with pytest.raises(WrongInput, match="two or more that grow"):
        find_crossing(law(lambda _: 0.0), loads, 0.05)


def problem(ratio, radius=10.0, elements=12, load=1e5):
    lower, upper = (
        {"nu": 0.28, "contour": {"kind": "arc", "radius": one, "flank_inclination_deg": 60.0}}
        for one in (radius, radius * ratio)
    )
    keys = {"loads": [load], "elements": elements, "flanks": False}
    return scene(rolling_radius=500.0, lower=lower, upper=upper, **keys).contact_problem


def deviations(of, factor=1.0, perturbed=None):
    """Deviations of A and B-hat, with B-hat times a factor in the place of C."""
    ((grid, _),) = grids_of(of)
    on_grid = pair_on_grid(of, grid)
    b_hat = GridOperator.from_convolution(on_grid.operator("Bhat"))

    def times(factor):
        return replace(b_hat, transformed=factor * b_hat.transformed)

    operators = {"A": on_grid.operator("A"), "Bhat": b_hat, "C": times(factor)}
    return PairDeviations(on_grid, operators, perturbed and times(perturbed))


@pytest.mark.parametrize(
    ("number", "power"), [("p_max", 2 / 3), ("a", -1 / 3), ("b", -1 / 3), ("approach", -2 / 3)]
)
def test_stiffer_ics_have_the_errors_of_hertz_at_all_loads(number, power):
    """p_max goes like compliance^(-2/3), lengths like ^(1/3), the approach like ^(2/3): steady errors."""
    of = problem(1.4, load=200.0)
    pair = deviations(of, factor=1.2)
    for load in (100.0, 200.0):
        error, estimate = pair.error(number, "Bhat", load)
        assert error == pytest.approx(1.2**power - 1, abs=0.005 + estimate)
        assert estimate < 0.05


def test_on_planes_nothing_crosses():
    """Sections of 10 m: the patch turns by 0.4 degrees, and A, B-hat are the same."""
    pair = deviations(problem(1.5, radius=1e4, load=5e4))
    loads = [1e4, 2e4, 5e4]
    for number in NUMBERS:
        found = find_crossing(pair.law(number, "A"), loads, 0.001)
        assert found.at is None
        assert abs(found.largest.error) < 1e-4
    assert pair.angle(5e4)[0] < 0.5


@pytest.mark.parametrize("number", ["a", "b"])
def test_readings_of_edges_that_agree_are_known_to_their_accuracy(number):
    """By the same ICs errors are 0, and edges are read on elements all the same."""
    of = problem(1.25)
    ((grid, _),) = grids_of(of)
    step = grid.dx if number == "a" else grid.ds
    pair = deviations(of)
    error, estimate = pair.error(number, "Bhat", 1e4)
    assert error == 0
    assert estimate > 1e-4 * step / numbers(pair.on_grid, pair.contact(1e4, "C").normal)[number]


@pytest.fixture(scope="module")
def coarse_and_fine():
    return [deviations(problem(1.25, elements=elements, load=3e5)) for elements in (12, 40)]


@pytest.mark.parametrize("number", NUMBERS)
def test_estimates_hold_against_finer_grids(coarse_and_fine, number):
    coarse, fine = coarse_and_fine
    for load in (5e4, 3e5):
        (error, estimate), (finer, rest) = (pair.error(number, "A", load) for pair in coarse_and_fine)
        assert abs(error - finer) <= estimate + rest
        assert rest < 0.03
    assert coarse.angle(3e5)[0] == pytest.approx(fine.angle(3e5)[0], abs=coarse.angle(3e5)[1])


def test_crossings_are_the_same_on_finer_grids(coarse_and_fine):
    tolerance = np.mean([coarse_and_fine[0].error("p_max", "A", load)[0] for load in (5e4, 3e5)])
    loads = [5e4, 1.2e5, 3e5]
    coarse, fine = (find_crossing(pair.law("p_max", "A"), loads, tolerance) for pair in coarse_and_fine)
    assert coarse.at.angle == pytest.approx(fine.at.angle, abs=coarse.estimate)
    assert fine.estimate < 5.0
    assert not coarse.before


def test_what_c_may_be_wrong_by_is_part_of_estimates():
    """One percent of compliance is two thirds of a percent of p_max."""
    of = problem(1.4, load=200.0)
    known, unsure = deviations(of), deviations(of, perturbed=1.01)
    more = unsure.error("p_max", "A", 200.0)[1] - known.error("p_max", "A", 200.0)[1]
    assert more == pytest.approx(0.01 * 2 / 3, rel=0.1)


def test_ladders_have_the_angles_asked_for_and_end_at_the_largest_load():
    of = problem(1.25)
    loads = Ladder(30.0, 80.0, steps=4).loads(of)
    np.testing.assert_allclose(np.diff(np.log(loads)), np.log(loads[-1] / loads[0]) / 3)
    for load, angle in ((loads[0], 30.0), (loads[-1], 80.0)):
        sized = deviations(problem(1.25, load=load))
        assert sized.angle(load)[0] == pytest.approx(angle, rel=0.05)
    assert Ladder(30.0, 80.0, 1e5, steps=4).loads(of)[-1] == pytest.approx(1e5)


def test_a_ladder_below_the_angle_of_the_least_load_is_refused():
    """Under 1 N the patch of closely fitting arcs turns by degrees already."""
    with pytest.raises(Failure, match=r"patch with B-hat turns by 0.1 degrees: it turns by .* under 1 N"):
        Ladder(0.1, 60.0, steps=3).loads(problem(1.01))


@pytest.mark.slow  # C of a pair
def test_with_c_of_nearly_flat_bodies_nothing_crosses(tmp_path):
    def crossing(pair):
        return find_crossing(pair.law("p_max", "A"), [1e3, 2e3], 0.02)

    of, options = problem(1.5, radius=300.0, elements=8, load=2e3), RunOptions(1, Store(tmp_path))
    found = solve_deviations(of, [2e3], ["A", "Bhat"], crossing, options)
    assert found.at is None
    assert abs(found.largest.error) < found.largest.estimate + 0.01
