"""Frictionless contact of two bodies: Hertz at small loads, ICs, estimates, extra gaps, forces, angles."""

from dataclasses import replace

import numpy as np
import pytest

from approx.pair import matrix
from femic.contact.lateral_force import contact_at_lateral_force
from femic.contact.loading import Loading
from femic.contact.motions.none import load_at_angle, solve_frictionless
from femic.contact.pairs.ics import GivenICs
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.quantities import numbers
from femic.contact.specification import extra_gap
from geometries.errors import Failure, WrongInput
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
    for name in ("a", "b", "p_max", "approach", "stiffness", "load"):
        value = getattr(expected, name)
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


def by_distances(**keys):
    """A conforming contact with the linear and the exact distance."""
    return [contacts_of(problem(10.2, loads=(2e4,), gap=gap, **keys))["Bhat"] for gap in ("linear", "exact")]


def test_problems_with_the_exact_distance_are_solved_with_it():
    linear, exact = by_distances()
    assert exact.normal.approach == pytest.approx(linear.displaced.normal.approach, rel=1e-4)
    assert exact.displaced is None
    assert np.isfinite(linear.estimated_errors()["p_max"])
    assert np.isnan(replace(linear, displaced=None).estimated_errors()["p_max"])


def test_estimates_contain_what_the_linearised_distance_does():
    """p_max and the width of a conforming contact by the exact distance, on elements too small to matter."""
    linear, exact = by_distances(elements=40)
    known, of_elements = linear.estimated_errors(), exact.estimated_errors()
    (by_linear, by_exact) = (numbers(each.on_grid, each.normal) for each in (linear, exact))
    for name in ("p_max", "b", "angle"):
        away = abs(by_linear[name] - by_exact[name])
        assert of_elements[name] < away <= known[name] < 3 * away, name


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


def with_gap(points, load=SMALL, **keys):
    """The contact with B-hat with an extra gap at points (x, s, gap), or (s, gap)."""
    gap = extra_gap(np.array(points))
    return contacts_of(problem(loads=(load,), ics=("Bhat",), extra_gap=gap, **keys))["Bhat"]


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
    contact = with_gap([*hollow, (-50.0, 0.0, 0.01), (50.0, 0.0, 0.01)], load=20.0, elements=12)
    left, right = contact.normal.patches
    assert left.s[1] < right.s[0]
    assert contact.normal.load == pytest.approx(20.0)


def test_bodies_that_are_not_opposite_or_do_not_touch_on_the_grid_are_refused():
    of = problem(loads=(1.0,), ics=("A",))
    beside_the_wheel = replace(pair_on_grid(of, Grid(8, 8, 0.1, 0.1)), grid=Grid(2, 8, 5 * ROLLING, 0.1))
    message = r"contact at 1 N: at a shift of 0 mm no part .* on s = -0\.4 \.\.\. 0\.4"
    with pytest.raises(WrongInput, match=message):
        beside_the_wheel.solve_in_place(beside_the_wheel.operator("A"), Loading(1.0))
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
    """The force that a shift gives puts the body there, to the pairing of strips; none puts it back."""
    shifted, _ = sideways(shift=0.04)
    result, errors = sideways(shift=0.0, lateral_force=shifted["F_y"])
    assert result["F_y"] == pytest.approx(shifted["F_y"], rel=1e-6)
    assert result["position"] == pytest.approx(0.04, rel=2e-2)
    assert result["p_max"] == pytest.approx(shifted["p_max"], rel=2e-3)
    assert 0 < errors["position"] < 0.1 * 0.04
    assert sideways(shift=0.04, lateral_force=0.0)[0]["position"] == pytest.approx(0.0, abs=1e-4)


# ---- loads at angles: a law in closed form, angles that no load has, what is called how often


def third_root(load):
    """Degrees that go like the third root of a load [N], as those of small patches do: 10 at 1 kN."""
    return load ** (1 / 3)


@pytest.mark.parametrize("accuracy", [0.05, 1e-3, 1e-9])
def test_a_load_is_the_third_power_of_its_angle(accuracy):
    """No contact is solved twice, those at the ends neither."""
    solved = []

    def angle(load):
        solved.append(load)
        return third_root(load)

    load = load_at_angle(angle, 23.0, (1e2, 1e6), accuracy)
    assert load == pytest.approx(23.0**3, rel=1.01 * accuracy)
    assert len(solved) == len(set(np.round(np.log(solved), 12)))


@pytest.mark.parametrize("end", [1e3, 1e6])
def test_the_angle_at_an_end_has_its_load(end):
    assert load_at_angle(third_root, third_root(end), (1e3, 1e6), 1e-3) == pytest.approx(end, rel=1e-12)


@pytest.mark.parametrize(("degrees", "loads"), [(5.0, (1e3, 1e6)), (120.0, (1e3, 1e6)), (11.0, (1e3, 1e3))])
def test_an_angle_that_no_load_has_is_a_failure_with_both_ends(degrees, loads):
    angles = [f"{third_root(load):.3g} under {load:.3g} N" for load in loads]
    with pytest.raises(Failure, match=f"the patch turns by {degrees:g} degrees") as failure:
        load_at_angle(third_root, degrees, loads, 1e-3)
    assert all(angle in str(failure.value) for angle in angles)
    assert "give an angle between" in str(failure.value)


# ---- the lateral position that a force asks for


@pytest.mark.parametrize(("force", "position"), [(-12.0, 3.0), (4.0, -1.0), (0.0, 0.0), (-8.0, 2.0)])
def test_the_position_of_a_spring_is_found_with_its_stiffness(force, position):
    contact, found, stiffness = contact_at_lateral_force(
        lambda y: (-4.0 * y, f"at {y:.6f}"), force, start=2.0, step=0.1, accuracy=1e-9
    )
    assert found == pytest.approx(position, abs=1e-8)
    assert contact == f"at {found:.6f}"
    assert stiffness == pytest.approx(4.0)


def test_a_force_that_is_not_reached_is_an_error_with_the_positions_tried():
    with pytest.raises(Failure, match=r"not reached with the upper body between -\d.* give a `shift`"):
        contact_at_lateral_force(lambda y: (1.0 / (1.0 + y * y), y), 3.0, start=0.5, step=1e-6, accuracy=1e-9)


# ---- gaps that are added: linear between their points, 0 beyond them

X_AT, S_AT = np.linspace(-3.0, 3.0, 7)[:, None], np.linspace(-4.4, 4.6, 10)[None]
LATTICE = np.array([(x, s) for x in (-4.0, -1.0, 5.0) for s in (-5.0, 0.5, 6.0)])


def linear_gap(x, s):
    """A gap that is linear: interpolation between any points gives it back."""
    return 0.3 + 0.02 * x - 0.05 * s


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9, (1e-6, 1.0)], ids=["nano", "one", "giga", "narrow band"])
@pytest.mark.parametrize("away", [0.0, 1e3])
def test_gap_is_linear_between_points_of_any_spacing(size, away):
    """About places that are a thousand spacings from the origin, too, and on a narrow band."""
    size_x, size_s = np.broadcast_to(size, 2)
    gap = extra_gap(np.column_stack([(LATTICE + away) * size, linear_gap(*LATTICE.T)]))
    result = gap.at(size_x * (X_AT + away), size_s * (S_AT + away))
    np.testing.assert_allclose(result, linear_gap(X_AT, S_AT), rtol=0, atol=1e-9)


def test_gap_on_a_grid_does_not_depend_on_the_order_of_its_points():
    """Each square of a grid has two diagonals: which one bounds triangles must not follow from the order."""
    chance = np.random.default_rng(3)
    x, s = (places.ravel() for places in np.meshgrid(np.linspace(-4, 4, 7), np.linspace(-3, 3, 5)))
    columns = np.column_stack([x, s, chance.uniform(-0.02, 0.02, x.size)])
    at = np.linspace(-4, 4, 33)[:, None], np.linspace(-3, 3, 29)
    for _ in range(5):
        other = extra_gap(chance.permutation(columns)).at(*at)
        np.testing.assert_array_equal(other, extra_gap(columns).at(*at))


def test_gap_is_zero_beyond_its_points():
    gap = extra_gap(np.column_stack([LATTICE, np.ones(len(LATTICE))]))
    np.testing.assert_array_equal(gap.at(np.array([[-4.1], [5.1]]), np.array([[0.0]])), 0.0)
    profile = extra_gap(np.array([(-1.0, 2.0), (1.0, 2.0)]))
    np.testing.assert_array_equal(profile.at(X_AT, np.array([[-1.01, 1.01]])), 0.0)


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_profile_is_the_same_at_all_x_in_all_formats(order):
    """As columns s, gap, at one x, or as a strip of points that is long along x."""
    s = np.array([-5.0, -1.0, 0.5, 6.0])
    rows = np.column_stack([s, np.abs(s)])[order]
    forms = (
        rows,
        np.column_stack([np.full(4, 2.0), rows]),
        np.concatenate([np.column_stack([np.full(4, x), rows]) for x in (-9.0, 9.0)]),
    )
    expected = np.interp(S_AT, s, np.abs(s)) + 0 * X_AT
    for columns in forms:
        np.testing.assert_allclose(extra_gap(columns).at(X_AT, S_AT), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("columns", "reason"),
    [
        ([(0.0, 1.0)], "one point: give two or more"),
        ([(2.0, 0.0, 1.0)], "one point: give two or more"),
        ([(1.0, 1.0, 1.0)] * 5, r"points 1 and 2 are at the same place \(1\): remove one"),
        ([(0.0, 1.0), (2.0, 1.0), (0.0, 3.0)], r"points 1 and 3 are at the same place \(0\)"),
        (
            [*((*place, 0.0) for place in LATTICE), (5.0, 6.0, 0.0)],
            r"points 9 and 10 .* \(5, 6\): remove one",
        ),
        ([(x, 2.0, 1.0) for x in range(4)], "4 points lie on one line that is not at a single x"),
        ([(x, 2.0 * x + 1, 1.0) for x in range(4)], "add points beside the line, or give columns s, gap"),
        ([(0.0, 0.0, 1.0), (1.0, 1.0, 1.0)], "2 points lie on one line"),
    ],
)
def test_points_without_a_unique_gap_between_them_are_refused(columns, reason):
    with pytest.raises(WrongInput, match=reason):
        extra_gap(np.array(columns))
