"""Estimates of numbers on three grids: errors that are known, luck, scales, groups, floors."""

import numpy as np
import pytest

from femic.contact.estimates import (
    AREA,
    BESIDE_FLOOR,
    GIVEN,
    LATERAL,
    LONGITUDINAL,
    MOST_ORDER,
    PRESSURE,
    RELATED,
    ROUNDING,
    SAFETY,
    SLIDING,
    Kind,
    Measured,
    Scale,
    changes,
    errors,
    estimates,
    from_grids,
)

RELATED_NUMBERS = Kind("creepage", related=(("creepage", RELATED),))
KINDS = {"p_max": PRESSURE, "approach": GIVEN, "F_x": LONGITUDINAL, "F_y": LATERAL, "sliding": SLIDING}
NUMBERS = {"p_max": 500.0, "approach": 0.02, "F_x": 100.0, "F_y": 3.0, "sliding": 0.4}
FORCE, LOAD = 300.0, 1000.0
SCALES = {name: Scale(FORCE, LOAD) for name in ("longitudinal", "lateral")}


def measured_numbers(floors=(), exact=(), **numbers):
    of_kinds = {floor: 0.0 for kind in KINDS.values() for floor in kind.floors}
    return Measured(NUMBERS | numbers, SCALES, of_kinds | dict(floors), exact)


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
    assert of["F_y"] >= BESIDE_FLOOR * 30.0
    assert of["F_y"] < 0.2 * FORCE


def test_related_numbers_count_by_half_and_others_not_at_all():
    kinds = {"xi": RELATED_NUMBERS, "xi_e": RELATED_NUMBERS, "p_max": PRESSURE}
    numbers = {"xi": 1.0, "xi_e": 2.0, "p_max": 500.0}
    of = estimates(Measured(numbers, {}, {"peak": 0.0}), kinds, numbers | {"xi": 1.3}, numbers | {"xi": 1.6})
    share = from_grids(0.0, 0.3, 0.6)
    assert of["xi"] == pytest.approx(share, rel=1e-3)
    assert of["xi_e"] == pytest.approx(2 * RELATED * share, rel=1e-3)
    assert of["p_max"] < 1e-5 * numbers["p_max"]


def test_a_change_counts_by_half_beside_a_floor_of_the_number():
    of = estimates(measured_numbers({"longitudinal": 0.01}), KINDS, moved(F_x=30.0), moved(F_x=60.0))
    expected = 0.5 * from_grids(0.0, 30.0, 60.0) + 0.01 * FORCE
    assert of["F_x"] == pytest.approx(expected, rel=1e-3)
    assert of["F_y"] < 1e-2  # other forces have errors of their own


def test_exact_numbers_have_the_estimate_of_rounding():
    """A load is prescribed, and a lateral force vanishes by symmetry, whatever others change."""
    changed = moved(F_x=30.0, p_max=10.0)
    of = estimates(measured_numbers({"lateral": 0.1}, exact=("F_y", "approach")), KINDS, changed, changed)
    assert of["F_y"] == pytest.approx(ROUNDING * LOAD)
    assert of["approach"] == pytest.approx(ROUNDING * NUMBERS["approach"])
    assert of["p_max"] >= BESIDE_FLOOR * SAFETY * 10.0


def test_numbers_that_agree_on_all_grids_are_not_taken_for_exact():
    """Three grids may agree by luck: the floor stays."""
    of = estimates(measured_numbers({"lateral": 0.01}), KINDS, NUMBERS, NUMBERS)
    assert of["F_y"] == pytest.approx(0.01 * FORCE, rel=1e-2)


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
    fine, coarse = measured_numbers(), measured_numbers()
    alone = errors(KINDS, fine, [coarse])
    parts = [dict.fromkeys(KINDS, 1.0), dict.fromkeys(KINDS, 0.5)]
    assert errors(KINDS, fine, [coarse], parts) == pytest.approx({name: alone[name] + 1.5 for name in KINDS})
    assert np.isnan(errors(KINDS, fine, [coarse], [dict.fromkeys(KINDS, np.nan)])["F_x"])


def test_changes_are_no_less_than_those_of_related_numbers():
    kinds = {"xi": RELATED_NUMBERS, "xi_e": RELATED_NUMBERS}
    of = changes(Measured({"xi": 1.0, "xi_e": 2.0}, {}, {}), kinds, {"xi": 1.3, "xi_e": 2.1})
    assert of == pytest.approx({"xi": 0.3, "xi_e": 0.3})
    assert changes(measured_numbers(), KINDS, moved(F_y=12.0))["F_y"] == pytest.approx(12.0)


def test_estimates_are_independent_of_units():
    """Forces in other units have the same shares."""
    first = estimates(measured_numbers(), KINDS, moved(F_x=30.0), moved(F_x=50.0))["F_x"]
    kilo = Measured({"F_x": 0.1}, {"longitudinal": Scale(FORCE / 1e3, LOAD / 1e3)}, {"longitudinal": 0.0})
    of = estimates(kilo, {"F_x": LONGITUDINAL}, {"F_x": 0.13}, {"F_x": 0.15})
    assert of["F_x"] == pytest.approx(first / 1e3)
