"""Meshed bodies against Hertz's ellipse: numbers, equilibrium, bounds, rates, and what far bodies add."""

import numpy as np
import pytest

from femic.contact.finite_elements.meshed_contact import ZoneTooSmall, mesh_bodies, solved
from femic.contact.finite_elements.result import compute_numbers
from femic.reference.job import NotConverged
from tests.femic.contact.finite_elements.ellipse import (
    HERTZ,
    LOAD,
    OF_LOWER,
    OF_UPPER,
    SURFACES,
    bodies,
    expected,
)

CELLS, FAR = 5.0, 15.0


@pytest.fixture(scope="module")
def meshes():
    return mesh_bodies(bodies(far=FAR), expected(), CELLS)


@pytest.fixture(scope="module")
def level(meshes):
    return solved(bodies(far=FAR), meshes, LOAD)


def test_numbers_agree_with_hertz(level):
    """Measured: half-lengths within 2.2 %, the pressure within 0.7 %, of 5 cells per half-width."""
    numbers = compute_numbers(level)
    assert [numbers.a, numbers.b] == pytest.approx([HERTZ.a, HERTZ.b], rel=0.035)
    assert numbers.p_max == pytest.approx(HERTZ.p_max, rel=0.015)


def test_pressures_do_not_alternate(level):
    """Inside of 80 % of the ellipse each is Hertz's, to 3 % of the largest (hat functions: 11 %)."""
    x, s = level.pair.x, level.pair.s
    inside = np.hypot(x / HERTZ.a, s / HERTZ.b) < 0.8
    assert np.count_nonzero(inside) > 20
    assert level.p[inside] == pytest.approx(HERTZ.pressure(x, s)[inside], abs=0.03 * HERTZ.p_max)


def test_both_bodies_are_in_equilibrium(level):
    assert level.load_of_pressures == pytest.approx(LOAD, rel=1e-5)
    assert level.reactions == pytest.approx((LOAD, -LOAD), rel=1e-5)


def test_there_is_neither_tension_nor_penetration(level):
    state, active = level.solution.state, level.solution.active
    gap = level.pair.gap(state.u_lower, state.u_upper, state.approach) / level.pair.area
    assert 20 < np.count_nonzero(active) < len(active) - 20
    assert state.p[active].min() > -1e-5 * state.p.max()
    assert np.all(state.p[~active] == 0)
    assert gap[~active].min() > -1e-5 * state.approach
    assert gap[active] == pytest.approx(np.zeros(np.count_nonzero(active)), abs=1e-5 * state.approach)


def test_far_bodies_add_a_displacement_in_proportion_to_the_load(level, meshes):
    """The approach is Hertz's, less what clamped far arcs take away: the same per load at half of it."""
    half = solved(bodies(far=FAR), meshes, LOAD / 2, level)
    added = [
        (compute_numbers(solution).approach - SURFACES.at_load(solution.load).approach) / solution.load
        for solution in (level, half)
    ]
    assert added[0] < 0
    assert abs(added[0]) * LOAD < 0.1 * HERTZ.approach
    assert added[1] == pytest.approx(added[0], rel=0.06)


def test_shifted_wheel_has_the_shifted_contact(level):
    """Spheres side by side touch at a distance in proportion to their radii; the numbers are the same."""
    aside = 4.0
    whole = bodies(symmetric=False, far=FAR, shift=aside)
    middle = aside * OF_LOWER / (OF_LOWER + OF_UPPER)
    solution = solved(whole, mesh_bodies(whole, expected(middle), 4.0), LOAD)
    numbers = compute_numbers(solution)
    assert whole.share == 0.5
    assert np.mean(solution.s_range) == pytest.approx(middle, abs=0.03)
    of_half = compute_numbers(level)
    assert numbers.p_max == pytest.approx(of_half.p_max, rel=0.02)
    assert [numbers.a, numbers.b] == pytest.approx([of_half.a, of_half.b], rel=0.05)
    assert numbers.approach == pytest.approx(of_half.approach, rel=0.01)  # other cells, far away, too


def test_contact_larger_than_its_zone_is_refused(meshes):
    with pytest.raises(ZoneTooSmall, match="larger `expected`"):
        solved(bodies(far=FAR), meshes, 8 * LOAD)


def test_endless_search_for_the_contact_area_is_refused(meshes, monkeypatch):
    monkeypatch.setattr("femic.contact.finite_elements.saddle.MOST_STEPS", 1)
    with pytest.raises(NotConverged, match=r"still change after 1 steps .* Try more `cells`"):
        solved(bodies(far=FAR), meshes, LOAD / 3)


@pytest.mark.slow
def test_errors_fall_with_the_cell_size():
    """Pressure: second order or nearly so; half-lengths stay within a fifth of a cell."""
    errors = []
    for cells in (5.0, 10.0):
        fine = bodies()
        numbers = compute_numbers(solved(fine, mesh_bodies(fine, expected(), cells), LOAD))
        errors.append(abs(numbers.p_max / HERTZ.p_max - 1))
        for result, true in ((numbers.a, HERTZ.a), (numbers.b, HERTZ.b)):
            assert abs(result - true) < 0.2 * HERTZ.b / cells
    assert np.log2(errors[0] / errors[1]) > 1.5
