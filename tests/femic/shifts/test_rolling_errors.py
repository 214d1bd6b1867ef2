"""Estimated errors of a rolling wheelset, of stand-ins with known numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.estimates import from_grids
from femic.shifts.axle import WheelNumbers, axle_numbers

RADIUS, SLOPE = 460.0, -2.3e9  # mm; N mm


def numbers(creepages, error_left=30.0, error_right=40.0, *, given=False):
    """Numbers and errors of a wheelset on elements of growing size, by its creepage on each.

    The left wheel at y = 750, the right one at -740 mm; lateral forces point towards the middle.
    """
    places = [SimpleNamespace(touch=SimpleNamespace(point=(y, 0.0))) for y in (750.0, -740.0)]
    state = SimpleNamespace(
        wheels=[SimpleNamespace(place=place, nominal_radius=RADIUS) for place in places],
        contacts=[SimpleNamespace(torque=5.0), SimpleNamespace(torque=-2.0)],
        levels=[SimpleNamespace(xi_0=xi_0) for xi_0 in creepages],
        xi_0=creepages[0],
        given=given,
        slope=SLOPE / 1e9,
        unit=1e9,
    )
    left = WheelNumbers({"F_x": 100.0, "F_y": 20.0}, {"F_x": error_left, "F_y": 2.0}, ())
    right = WheelNumbers({"F_x": -80.0, "F_y": 50.0}, {"F_x": error_right, "F_y": 5.0}, ())
    return axle_numbers(state, left, right)


def test_the_creepage_is_known_to_the_worse_of_larger_elements_and_forces():
    """Forces of error 30 and 40 N turn the axle by 50 N times its radius; over the slope that is 1e-5."""
    by_forces = 50.0 * RADIUS / abs(SLOPE)
    assert by_forces == pytest.approx(1e-5)
    same, apart = [1e-4] * 3, [1e-4, 1.3e-4, 1.7e-4]
    assert numbers(same)[1]["xi_0"] == pytest.approx(by_forces)
    assert numbers(apart)[1]["xi_0"] == pytest.approx(from_grids(*apart))
    assert from_grids(*apart) > by_forces


def test_forces_and_moments_of_a_wheelset_are_known_to_the_sums_of_those_of_its_wheels():
    own, errors = numbers([1e-4], 3.0, 4.0, given=True)
    assert own == {
        "xi_0": 1e-4,
        "axle_torque": 3.0,
        "sum_F_y": 30.0,
        "steering": 100.0 * 750.0 + 80.0 * 740.0,
    }
    assert errors == {"xi_0": 0.0, "sum_F_y": 7.0, "steering": 3.0 * 750.0 + 4.0 * 740.0}


def test_a_given_creepage_is_exact_and_one_on_a_single_grid_is_not_known():
    assert numbers([1e-4, 2e-4], given=True)[1]["xi_0"] == 0
    assert np.isnan(numbers([1e-4])[1]["xi_0"])
