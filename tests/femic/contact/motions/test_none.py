"""Frictionless contact of two bodies: Hertz at small loads, ICs, estimates, extra gaps, lateral forces."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import matrix
from femic.contact.loading import Loading
from femic.contact.motions.none import solve_frictionless
from femic.contact.pairs.ics import GivenICs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import numbers
from femic.contact.specification import extra_gap
from geometries.errors import WrongInput
from geometries.patches import Grid, N
from tests.femic.contact.pairs.problems import (
    RADIUS,
    ROLLING,
    SMALL,
    WHEEL,
    hertz,
    like_bhat,
    problem,
    solved,
)


def contacts_of(of):
    """The contacts of a problem of one load, by ICs."""
    return {ics: contact for (_, ics), contact in solve_frictionless(of).contacts.items()}


def test_small_contacts_agree_with_hertz():
    numbers, errors = solved(problem(loads=(SMALL,), elements=40))
    expected = hertz().at_load(SMALL)
    exact = {
        "a": expected.a,
        "b": expected.b,
        "p_max": expected.p_max,
        "approach": expected.approach,
        "stiffness": expected.stiffness,
        "load": SMALL,
    }
    for name, value in exact.items():
        assert numbers[name] == pytest.approx(value, abs=errors[name] + 2e-4 * value), name
        assert errors[name] < 0.03 * value


def test_estimates_cover_the_change_by_twice_as_many_elements():
    (coarse, errors), (fine, _) = (solved(problem(10.2, loads=(3e3,), elements=n)) for n in (16, 32))
    for name in ("a", "b", "p_max", "approach", "angle"):
        assert abs(coarse[name] - fine[name]) <= errors[name], name


def test_contacts_at_the_approach_that_a_load_causes_carry_this_load():
    approach = solved(problem(loads=(2e3,)))[0]["approach"]
    numbers, _ = solved(problem(approaches=(approach,), ics=("Bhat",)))
    assert numbers["load"] == pytest.approx(2e3, rel=2e-3)  # on another grid


def test_conforming_contact_is_wider_and_softer_than_on_half_spaces():
    """B-hat turns loads away from the normals of distant elements: less displacement there than A has."""
    of = problem(10.2, loads=(2e4,))
    a, bhat = (solved(of, name)[0] for name in ("A", "Bhat"))
    assert bhat["b"] > 1.03 * a["b"]
    assert bhat["p_max"] < 0.99 * a["p_max"]
    assert bhat["approach"] < a["approach"]


def test_the_exact_distance_agrees_where_the_approach_is_small_beside_the_radii():
    def difference(load):
        contact = contacts_of(problem(10.2, loads=(load,)))["Bhat"]
        return abs(float(contact.displaced.normal.p.max() / contact.normal.p.max()) - 1)

    assert difference(20.0) < 2e-3 < difference(2e4)


def test_problems_with_the_exact_distance_are_solved_with_it():
    linear, exact = (contacts_of(problem(10.2, loads=(2e4,), gap=gap))["Bhat"] for gap in ("linear", "exact"))
    assert exact.normal.approach == pytest.approx(linear.displaced.normal.approach, rel=1e-4)
    assert exact.displaced is None


def test_estimates_contain_what_the_linearised_distance_does():
    """p_max and the width of a conforming contact by the exact distance, on elements too small to matter."""
    linear, exact = (
        contacts_of(problem(10.2, loads=(2e4,), elements=40, gap=gap))["Bhat"] for gap in ("linear", "exact")
    )
    known, of_elements = linear.estimated_errors(), exact.estimated_errors()
    (by_linear, by_exact) = (numbers(each.on_grid, each.normal) for each in (linear, exact))
    for name in ("p_max", "b", "angle"):
        away = abs(by_linear[name] - by_exact[name])
        assert of_elements[name] < away <= known[name] < 3 * away, name


def test_without_the_exact_distance_errors_are_not_known():
    linear = contacts_of(problem(10.2, loads=(2e3,)))["Bhat"]
    assert np.isnan(replace(linear, displaced=None).estimated_errors()["p_max"])
    assert np.isfinite(linear.estimated_errors()["p_max"])


def test_given_ics_are_solved_on_their_grid_with_their_errors():
    """The matrix of B-hat, and twice that: softer by what the estimate says."""
    grid = Grid(32, 40, 0.5, 0.3)
    of = problem(10.2, loads=(3e3,), ics=("Bhat", "own", "softer"))
    nn = matrix("Bhat", of.pair, grid)[..., N, N]
    given = {"own": GivenICs(grid, nn, nn), "softer": GivenICs(grid, 2 * nn)}
    result = {ics: contact for (_, ics), contact in solve_frictionless(of, given=given).contacts.items()}
    assert {contact.on_grid.grid for contact in result.values()} == {grid}
    np.testing.assert_allclose(result["own"].normal.p, result["Bhat"].normal.p, atol=1e-3 * 3e3)
    np.testing.assert_array_equal(result["own"].perturbed.normal.p, result["softer"].normal.p)
    other = {"own": given["own"], "softer": GivenICs(replace(grid, s=0.1), nn)}
    with pytest.raises(WrongInput, match=r"own, softer have different grids: name one"):
        solve_frictionless(of, given=other)


def test_estimate_of_c_is_added_to_the_estimate_by_elements(monkeypatch):
    """Not the larger of both: ICs larger by 4 % change the approach by 2.4 % or more, and p_max."""
    monkeypatch.setattr("femic.contact.pairs.ics.normal_reference_ics", like_bhat(1.0, 1.04))
    contact = contacts_of(problem(10.2, loads=(3e3,), ics=("C",), elements=12))["C"]
    assert contact.perturbed.normal.approach > 1.02 * contact.normal.approach
    both, of_elements = (one.estimated_errors() for one in (contact, replace(contact, perturbed=None)))
    fine, changed = (numbers(contact.on_grid, one.normal) for one in (contact, contact.perturbed))
    for name, value in changed.items():
        assert both[name] - of_elements[name] >= 0.999 * abs(value - fine[name]), name
        assert of_elements[name] > 0, name
    assert both["approach"] - of_elements["approach"] < 0.05 * fine["approach"]


CORNERS = [(x, s) for x in (-50.0, 50.0) for s in (-9.0, 9.0)]


def with_gap(points, load=SMALL):
    """The contact with B-hat with an extra gap at points (x, s, gap), or (s, gap)."""
    gap = extra_gap(np.array(points))
    return contacts_of(problem(loads=(load,), ics=("Bhat",), extra_gap=gap))["Bhat"]


def test_a_constant_extra_gap_is_closed_by_the_approach():
    """Along the normals, that is: the relative curvature changes by 0.01 mm / R^2, 0.4 % of it."""
    before = contacts_of(problem(loads=(SMALL,), ics=("Bhat",)))["Bhat"].normal
    after = with_gap([(*at, 0.01) for at in CORNERS]).normal
    assert after.approach - before.approach == pytest.approx(0.01, rel=1e-4)
    np.testing.assert_allclose(after.p, before.p, atol=4e-3 * before.p.max())


@pytest.mark.parametrize(("slopes", "along"), [((0.0, 4e-4), 1), ((1e-4, 0.0), 0), ((-5e-5, 3e-4), None)])
def test_rising_gap_moves_the_contact_the_other_way(slopes, along):
    """Of parabolas of curvature c the least of c t^2 / 2 + g t is at -g / c."""
    rising = [(x, s, slopes[0] * x + slopes[1] * s) for x, s in CORNERS]
    contact = with_gap(rising)
    p, on_grid = contact.normal.p, contact.on_grid
    middle = np.sum(p * on_grid.x[:, None]) / p.sum(), np.sum(p * on_grid.grid.strips) / p.sum()
    expected = -slopes[0] * ROLLING, -slopes[1] / (1 / RADIUS - 1 / WHEEL)
    step = on_grid.grid.dx, on_grid.grid.ds
    for k in (0, 1) if along is None else (along, 1 - along):
        assert middle[k] == pytest.approx(expected[k], rel=0.02, abs=0.02 * step[k])
        assert expected[k] == 0 or abs(expected[k]) > step[k] / 2


def test_a_hollow_in_the_middle_leaves_two_patches():
    hollow = [(*at, 0.0) for at in [*CORNERS, (-50.0, -0.2), (50.0, -0.2), (-50.0, 0.2), (50.0, 0.2)]]
    contact = with_gap([*hollow, (-50.0, 0.0, 0.01), (50.0, 0.0, 0.01)], load=20.0)
    left, right = contact.normal.patches
    assert left.s[1] < right.s[0]
    assert contact.normal.load == pytest.approx(20.0)


@pytest.mark.parametrize("columns", [2, 3])
def test_profile_gap_is_the_same_at_all_x(columns):
    """A profile that was measured at one x, the natural case: as if it were given far away on both sides."""
    s = np.linspace(-9.0, 9.0, 7)
    profile, far = np.column_stack([s, 1e-4 * s**2]), 50.0
    both = np.concatenate([np.column_stack([np.full(7, x), profile]) for x in (-far, far)])
    given = profile if columns == 2 else np.column_stack([np.zeros(7), profile])
    alone, between = (with_gap(points).normal for points in (given, both))
    np.testing.assert_allclose(alone.p, between.p, atol=1e-6 * between.p.max())


def test_bodies_that_are_not_opposite_on_the_grid_are_refused():
    of = problem(loads=(1.0,), ics=("A",))
    beside_the_wheel = replace(pair_on_grid(of, Grid(8, 8, 0.1, 0.1)), grid=Grid(2, 8, 5 * ROLLING, 0.1))
    with pytest.raises(
        WrongInput, match=r"contact at 1 N: at a shift of 0 mm no part .* on s = -0\.4 \.\.\. 0\.4"
    ):
        beside_the_wheel.solve_in_place(beside_the_wheel.operator("A"), Loading(1.0))


def test_bodies_that_do_not_touch_on_the_grid_are_refused():
    of = problem(approaches=(1e-5,), ics=("A",), grid=Grid(64, 32, 0.2, 0.2), shift=3.0)
    with pytest.raises(WrongInput, match=r"contact at 1e-05 mm: the bodies do not touch on s = "):
        solve_frictionless(of)


def sideways(**keys):
    """Numbers of a contact with B-hat, and their estimated errors."""
    return solved(problem(10.3, loads=(2e4,), elements=12, ics=("Bhat",), **keys))


def test_mirrored_contact_has_mirrored_forces_within_the_estimates():
    (right, _), (left, _) = sideways(shift=0.04), sideways(shift=-0.04)
    assert right["F_y"] < -0.03 * right["load"]
    for name in ("F_y", "M_x", "s_centre", "position"):
        assert left[name] == pytest.approx(-right[name], rel=1e-4)
    assert right["M_x"] == pytest.approx(RADIUS * right["F_y"], rel=1e-9)
    assert left["p_max"] == pytest.approx(right["p_max"], rel=1e-4)


def test_position_at_a_lateral_force_is_independent_of_the_start():
    """The force that a shift gives puts the body there, to the pairing of strips, from there and from 0."""
    shifted, _ = sideways(shift=0.04)
    for start in (0.0, 0.04):
        result, errors = sideways(shift=start, lateral_force=shifted["F_y"])
        assert result["F_y"] == pytest.approx(shifted["F_y"], rel=1e-6)
        assert result["position"] == pytest.approx(0.04, rel=2e-2)
        assert result["p_max"] == pytest.approx(shifted["p_max"], rel=2e-3)
        assert 0 < errors["position"] < 0.1 * 0.04


def test_shifted_body_returns_without_a_lateral_force():
    assert sideways(shift=0.04, lateral_force=0.0)[0]["position"] == pytest.approx(0.0, abs=1e-4)
