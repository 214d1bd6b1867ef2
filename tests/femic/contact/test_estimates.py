"""Estimates of numbers on three grids: errors that are known, luck, scales, groups, floors."""

import numpy as np
import pytest

from femic.contact.estimates import (
    AREA,
    GIVEN,
    LATERAL,
    LONGITUDINAL,
    MOST_ORDER,
    PRESSURE,
    RELATED,
    ROUNDING,
    SAFETY,
    SLIDING,
    Measured,
    Scale,
    changes,
    estimates,
    from_grids,
    summed,
)

KINDS = {"p_max": PRESSURE, "approach": GIVEN, "F_x": LONGITUDINAL, "F_y": LATERAL, "sliding": SLIDING}
NUMBERS = {"p_max": 500.0, "approach": 0.02, "F_x": 100.0, "F_y": 3.0, "sliding": 0.4}
FORCE, LOAD = 300.0, 1000.0
SCALES = {name: Scale(FORCE, LOAD) for name in ("longitudinal", "lateral")}


def measured_numbers(floors=(), **numbers):
    of_kinds = {floor: 0.0 for kind in KINDS.values() for floor in kind.floors}
    return Measured(NUMBERS | numbers, SCALES, of_kinds | dict(floors))


def moved(**changed):
    return {name: value + changed.get(name, 0.0) for name, value in NUMBERS.items()}


@pytest.mark.parametrize("order", [1.0, 1.25, MOST_ORDER])
def test_known_orders_give_the_error_times_the_safety_factor(order):
    fine, coarse, coarser = (7.0 + 0.1 * h**order for h in (1, 2, 4))
    assert from_grids(fine, coarse, coarser) == pytest.approx(SAFETY * 0.1)


@pytest.mark.parametrize("order", [0.3, 1.7, 2.0, 4.0])
def test_orders_outside_the_assumed_range_give_no_smaller_estimate(order):
    """Of a lower order errors are more, which three grids do not show: so much may a difference miss."""
    fine, coarse, coarser = (7.0 + 0.1 * h**order for h in (1, 2, 4))
    least = 0.1 if order > 1 else coarse - fine
    assert from_grids(fine, coarse, coarser) >= SAFETY * least


def test_accidentally_small_differences_are_ignored():
    """The other difference, over four, does; and where there is no third grid the order is 1."""
    assert from_grids(1.0, 1.0, 1.4) == pytest.approx(SAFETY * 0.1 / (2**MOST_ORDER - 1))
    assert from_grids(1.0, 1.3, 1.3) == pytest.approx(SAFETY * 0.3)
    assert from_grids(1.0, 1.3) == pytest.approx(SAFETY * 0.3)
    assert np.isnan(from_grids(1.0, np.nan, 1.0))


def test_forces_near_zero_have_estimates_on_the_scale_of_friction_times_load():
    of = estimates(measured_numbers(F_y=0.0), KINDS, moved(F_y=-3.0 + 30.0), moved(F_y=-3.0 + 60.0))
    assert of["F_y"] >= 30.0
    assert of["F_y"] < 0.2 * FORCE


def test_related_numbers_count_by_half_and_others_not_at_all():
    of = estimates(measured_numbers(), KINDS, moved(F_x=30.0, F_y=0.5), moved(F_x=60.0, F_y=1.0))
    share = from_grids(0.0, 30.0, 60.0) / FORCE
    assert of["F_y"] == pytest.approx(RELATED * share * FORCE, rel=1e-3)
    assert of["F_x"] == pytest.approx(share * FORCE, rel=1e-3)
    assert of["p_max"] < 1e-5 * NUMBERS["p_max"]


def test_prescribed_and_symmetric_numbers_have_the_estimate_of_rounding():
    """A load is the same on all grids, and a lateral force vanishes on all, whatever others change."""
    changed = moved(F_x=30.0, p_max=10.0)
    of = estimates(measured_numbers({"force": 0.1}), KINDS, changed, changed)
    assert of["F_y"] == pytest.approx(ROUNDING * LOAD)
    assert of["approach"] == pytest.approx(ROUNDING * NUMBERS["approach"])
    assert of["p_max"] >= SAFETY * 10.0


def test_no_estimate_is_zero_and_floors_are_added():
    """Elements may be in the same state on all grids: what could be otherwise is estimated."""
    of = estimates(measured_numbers({"sliding": 0.03}), KINDS, NUMBERS, NUMBERS)
    assert of["sliding"] == pytest.approx(0.03 + ROUNDING)
    assert all(value > 0 for value in of.values())


def test_equal_areas_on_all_grids_keep_the_floor():
    area = Measured({"area": 10.0}, {}, {"area": 0.04})
    assert estimates(area, {"area": AREA}, {"area": 10.0}, {"area": 10.0})["area"] == pytest.approx(
        0.4, rel=1e-3
    )


def test_parts_of_an_estimate_are_added():
    assert summed([{"a": 1.0, "b": 2.0}, {"a": 0.5, "b": 3.0}, {"a": 0.0, "b": 1.0}]) == {"a": 1.5, "b": 6.0}
    assert np.isnan(summed([{"a": 1.0}, {"a": np.nan}])["a"])


def test_changes_include_related_numbers_and_are_no_less_than_their_own():
    of = changes(measured_numbers(), KINDS, moved(F_x=30.0, F_y=12.0))
    assert of["F_x"] == pytest.approx(30.0)
    assert of["F_y"] == pytest.approx(15.0)
    assert changes(measured_numbers(), KINDS, moved(F_y=12.0))["F_y"] == pytest.approx(12.0)


def test_estimates_are_independent_of_units():
    """Forces in other units have the same shares."""
    first = estimates(measured_numbers(), KINDS, moved(F_x=30.0), moved(F_x=50.0))["F_x"]
    kilo = Measured({"F_x": 0.1}, {"longitudinal": Scale(FORCE / 1e3, LOAD / 1e3)}, {"force": 0.0})
    of = estimates(kilo, {"F_x": LONGITUDINAL}, {"F_x": 0.13}, {"F_x": 0.15})
    assert of["F_x"] == pytest.approx(first / 1e3)
