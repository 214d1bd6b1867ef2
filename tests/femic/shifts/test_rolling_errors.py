"""Estimated errors of a rolling wheelset, of stand-ins with known numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from femic.contact.estimates import from_grids
from femic.shifts.rolling.numbers import _error_of_creepage

RADIUS, SLOPE = 460.0, -2.3e9  # mm; N mm


def rolled(creepages, *, given=False):
    """A wheelset on elements of growing size, by its creepage on each."""
    place = SimpleNamespace(layout=SimpleNamespace(nominal_radius=(RADIUS, RADIUS)))
    one = None
    for xi_0 in reversed(creepages):
        wheels = [SimpleNamespace(place=place)] * 2
        one = SimpleNamespace(given=given, xi_0=xi_0, wheels=wheels, torque_slope=SLOPE, coarser=one)
    return one


def test_the_creepage_is_known_to_the_worse_of_larger_elements_and_forces():
    """Forces of error 30 and 40 N turn the axle by 50 N times its radius; over the slope that is 1e-5."""
    by_forces = 50.0 * RADIUS / abs(SLOPE)
    assert by_forces == pytest.approx(1e-5)
    same, apart = [1e-4] * 3, [1e-4, 1.3e-4, 1.7e-4]
    assert _error_of_creepage(rolled(same), [30.0, 40.0]) == pytest.approx(by_forces)
    assert _error_of_creepage(rolled(apart), [30.0, 40.0]) == pytest.approx(from_grids(*apart))
    assert from_grids(*apart) > by_forces


def test_a_given_creepage_is_exact_and_one_on_a_single_grid_is_not_known():
    assert _error_of_creepage(rolled([1e-4, 2e-4], given=True), [30.0, 40.0]) == 0
    assert np.isnan(_error_of_creepage(rolled([1e-4]), [30.0, 40.0]))
