"""Errors of rolling forces over the load: prescribed forces, another route, no error of the same ICs."""

from dataclasses import replace

import numpy as np
import pytest

from compare.studies.validity_limits import HALF, ROLLING_NUMBERS, RollingDeviations, find_crossing
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions import pair_in_motion
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.scenes.load import load_scene

LOAD, FRICTION = 1e5, 0.4
LOADS = (3e4, LOAD)


@pytest.fixture(scope="module")
def rolled():
    """The mix in the place of C: it has xn."""
    of = load_scene("rolling", {"contact": {"elements": 8, "ics": ["A", "Bhat", "mix"]}}).contact_problem
    ((grid, _),) = grids_of(of)
    pair = pair_in_motion(of, pair_on_grid(of, grid))
    operators = {"A": pair.operator("A"), "C": pair.operator("mix"), "same": pair.operator("mix")}
    return RollingDeviations(pair, operators, FRICTION)


def test_with_c_the_wheel_has_half_of_friction_times_load_and_rolls_freely(rolled):
    for load in LOADS:
        numbers = rolled.solved(load, "C").numbers
        assert numbers["half"] == pytest.approx(HALF, abs=1e-4)
        assert numbers["free"] == pytest.approx(0.0, abs=1e-4)
        half, free = rolled.solved(load, "C").creepages
        assert free < half


def test_forces_of_others_are_those_at_the_creepages_of_c(rolled):
    """A solved alone, without a start, at the creepages of the reference."""
    alone = rolled.pair.rolling(rolled.pair.frictional(rolled.operators["A"], FRICTION))
    for number, xi in zip(("half", "free"), rolled.solved(LOAD, "C").creepages, strict=True):
        contact = alone.contact(Creepages(xi), Loading(LOAD)).contact
        share = contact.force[0] / (FRICTION * LOAD)
        expected = share - (HALF if number == "half" else 0.0)
        assert rolled.law(number, "A")(LOAD).error == pytest.approx(expected, abs=2e-4)
        if number == "half":
            of_reference = rolled.solved(LOAD, "C").contacts[0].contact.sliding_share
            differs = contact.sliding_share - of_reference
            assert rolled.law("sliding", "A")(LOAD).error == pytest.approx(differs, abs=0.02)


def test_the_same_ics_have_no_error_and_no_crossing(rolled):
    for number in ROLLING_NUMBERS:
        found = find_crossing(rolled.law(number, "same"), LOADS, 0.001)
        assert found.at is None
        assert abs(found.largest.error) < 1e-4
    assert rolled.law("half", "same")(LOAD).estimate < 1e-4
    assert rolled.law("sliding", "same")(LOAD).estimate > 0.0  # elements may be in another state


def test_without_xn_forces_are_too_small_the_more_the_surface_turns(rolled):
    """A wheel with A still brakes where the reference rolls freely; a crossing is between both loads."""
    small, large = (rolled.law("free", "A")(load) for load in LOADS)
    assert large.error < small.error < 0
    tolerance = (abs(small.error) + abs(large.error)) / 2
    found = find_crossing(rolled.law("free", "A"), LOADS, tolerance, accuracy=0.1)
    assert LOADS[0] < found.at.load < LOADS[1]
    assert abs(found.at.error) == pytest.approx(tolerance, rel=0.05)
    assert small.angle <= found.at.angle <= large.angle


def test_what_c_may_be_wrong_by_is_known_at_the_sampled_loads(rolled):
    """C plus 2 % of itself, sampled at the ends: in between it is interpolated."""
    more = rolled.pair.operator("mix")
    perturbed = replace(more, kernels={places: 1.02 * kernel for places, kernel in more.kernels.items()})
    pair = RollingDeviations(rolled.pair, rolled.operators, FRICTION, perturbed, LOADS)
    ends = [pair.change("free", "A", load) for load in LOADS]
    assert all(0 < end < 0.02 for end in ends)
    between = pair.change("free", "A", float(np.sqrt(np.prod(LOADS))))
    assert between == pytest.approx(np.mean(ends))


def test_the_angle_is_known_no_better_than_c(rolled):
    """C plus 5 % of itself: pressures change by about 3 % (Hertz: compliance^(-2/3)), and related angles may.

    The change of the angle itself is that of a pair that has the softer C as its own.
    """
    of_c = rolled.operators["C"]
    softer = replace(of_c, kernels={places: 1.05 * kernel for places, kernel in of_c.kernels.items()})
    unsure = RollingDeviations(rolled.pair, rolled.operators, FRICTION, softer, LOADS)
    changed = RollingDeviations(rolled.pair, {"C": softer}, FRICTION)
    parts = []
    for load in LOADS:
        (angle, known), (same, less) = rolled.angle(load), unsure.angle(load)
        assert same == angle
        parts.append(less - known)
        assert parts[-1] >= max(0.02 * angle, abs(changed.angle(load)[0] - angle) - 1e-9)
    between = float(np.sqrt(np.prod(LOADS)))
    part = unsure.angle(between)[1] - rolled.angle(between)[1]
    assert part == pytest.approx(np.mean(parts))
