"""Estimates of numbers on three grids, and their floors: elements that could be in another state, scales."""

import numpy as np
import pytest

from approx.pair import Pair, Solid
from femic.contact.estimates import (
    AREA,
    BESIDE_FLOOR,
    GIVEN,
    LATERAL,
    LONGITUDINAL,
    MOST_ORDER,
    OF_EDGE,
    OF_FOLLOWERS,
    OF_SLIDING,
    OF_TURNING,
    PRESSURE,
    RELATED,
    ROUNDING,
    SAFETY,
    SLIDING,
    Kind,
    Measured,
    Places,
    Scale,
    SlipState,
    changes,
    errors,
    estimates,
    floors,
    floors_of_forces,
    from_grids,
    scales,
    vanishing_by_symmetry,
)
from femic.contact.exact.hertz import PointContact, combined_modulus
from femic.contact.friction.motion import LeadingEdge
from femic.contact.loading import Loading
from femic.contact.motions.none import SolvedContact
from femic.contact.pairs.pair_on_grid import PairContact, PairOnGrid
from femic.contact.pairs.quantities import numbers
from femic.contact.undeformed import Undeformed
from geometries.contours import arc, plane
from geometries.materials import Material
from geometries.patches import Grid
from geometries.surfaces import LOWER, UPPER, Surface

STEEL = Material(210e3, 0.3)
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


def test_floors_stay_and_no_estimate_is_zero_where_all_grids_agree():
    """By luck, as elements may be in the same state on all of them."""
    of = estimates(measured_numbers({"lateral": 0.01, "sliding": 0.03}), KINDS, NUMBERS, NUMBERS)
    assert of["F_y"] == pytest.approx(0.01 * FORCE, rel=1e-2)
    assert of["sliding"] == pytest.approx(0.03 + ROUNDING)
    assert all(value > 0 for value in of.values())
    area = Measured({"area": 10.0}, {}, {"area": 0.04})
    of = estimates(area, {"area": AREA}, {"area": 10.0}, {"area": 10.0})
    assert of["area"] == pytest.approx(0.4, rel=1e-3)


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


# ---- floors: borders, slip that vanishes within an element, edges


def ellipse(x, s):
    """Pressures of Hertz on semi-axes 5 and 4, shape (n_x, n_s)."""
    return 700.0 * np.sqrt(np.maximum(1 - (x[:, None] / 5) ** 2 - (s / 4) ** 2, 0.0))


SHAPE, FRICTION = (12, 10), 0.3
X_AT, S_AT = np.arange(12) - 5.7, np.arange(10) - 4.4
X, S = np.meshgrid(X_AT, S_AT, indexing="ij")
P = ellipse(X_AT, S_AT)


def tractions(stick, slip, filled=1.0, friction=FRICTION):
    """Pressures on an ellipse, with tangential tractions along x that fill this share of bounds."""
    p = np.stack([filled * friction * P, 0 * P, P], axis=-1)
    return SlipState(p, stick & (P > 0), np.where((stick | (P == 0))[..., None], 0.0, slip), friction)


def along_x(slip):
    return np.stack([slip + 0 * X, 0 * X], axis=-1)


def test_uniform_sliding_is_not_open_but_one_element_could_stick():
    """Less than an element that sticks is not seen: no grid knows the sliding share better."""
    whole = tractions(np.zeros(SHAPE, bool), along_x(1e-3))
    assert not whole.open.any()
    assert floors(whole)["sliding"] == pytest.approx(OF_SLIDING / (P > 0).sum())
    assert floors(whole)["force"] > 0  # the edge is


def test_sliding_elements_are_open_where_slip_turns():
    """Slip that grows with x vanishes between two elements: these and no others, and none sticks there."""
    turns = tractions(np.zeros(SHAPE, bool), along_x(1e-4 * X))
    expected = (np.abs(X) <= 1) & (P > 0)
    np.testing.assert_array_equal(turns.open, expected)
    np.testing.assert_array_equal(turns.turning, expected)
    share = expected.sum() / (P > 0).sum()
    at_random = OF_SLIDING * np.sqrt(expected.sum()) / (P > 0).sum()
    assert floors(turns)["sliding"] == pytest.approx(at_random + OF_TURNING * share)


def test_stick_slip_borders_are_open_on_both_sides_and_not_turning():
    part = tractions(X > 0, along_x(1e-3), filled=0.999)
    inside = P > 0
    beside = inside & (np.abs(X) < 1)
    assert np.all(part.open[beside & np.roll(inside, 1, 0) & np.roll(inside, -1, 0)])
    assert not part.turning[beside].any()


def test_sticking_elements_are_open_near_the_traction_bound_only():
    """Half of the bound: the edge could slide, where bounds vanish, and the middle not."""
    sticks = tractions(np.ones(SHAPE, bool), along_x(0.0), filled=0.5)
    assert np.all(sticks.open[sticks.at_edge])
    assert not sticks.open[np.hypot(X / 5, S / 4) < 0.4].any()


def test_frictionless_force_floors_come_from_the_edge_alone():
    none = floors(tractions(np.zeros(SHAPE, bool), along_x(0.0), friction=0.0))
    at_edge = tractions(np.zeros(SHAPE, bool), along_x(1.0)).at_edge
    assert none["force"] == pytest.approx(OF_EDGE * P[at_edge].sum() / P.sum())
    assert none["area"] > 0


def test_floors_fall_with_the_element_size():
    """Twice as many elements both ways: about half of the area at the edge and at borders."""
    x, s = (np.arange(24) - 11.4) / 2, (np.arange(20) - 8.8) / 2
    p = ellipse(x, s)[..., None] * [0.0, 0.0, 1.0]
    slip = np.broadcast_to(1e-4 * x[:, None, None] * [1.0, 0.0], (24, 20, 2))
    fine = floors(SlipState(p, p[..., 2] < 0, slip, FRICTION))
    coarse = floors(tractions(np.zeros(SHAPE, bool), along_x(1e-4 * X)))
    for name, value in fine.items():
        assert 0.2 * coarse[name] < value < 0.75 * coarse[name], name


def places(tilt=0.0, x=X_AT, y=S_AT, area=0.5):
    """Of a contour that inclines by tilt y."""
    return Places(x, y, -tilt * y**2 / 2, np.sin(tilt * y), np.cos(tilt * y), area)


def test_forces_are_scaled_by_friction_times_load_and_on_inclined_places_by_pressures_too():
    load = 0.5 * P.sum()
    level, inclined = scales(P, FRICTION, places()), scales(P, FRICTION, places(0.05))
    assert level["longitudinal"].changes == pytest.approx(FRICTION * load)
    assert level["lateral"].changes == pytest.approx(FRICTION * load)
    assert inclined["lateral"].changes > FRICTION * load
    assert inclined["about_z"].changes > level["about_z"].changes  # by the pressures' part
    assert scales(P, 0.0, places(0.05))["about_z"].changes > 0
    assert scales(P, 0.0, places())["lateral"].changes == pytest.approx(0.0, abs=1e-9 * load)
    assert all(scale.rounds > 0 for scale in scales(P, 0.0, places()).values())


def test_forces_are_scaled_by_the_friction_of_each_strip():
    of_strips = np.linspace(0.1, 0.5, 10)
    expected = 0.5 * np.sum(of_strips * P)
    assert scales(P, of_strips, places())["longitudinal"].changes == pytest.approx(expected)
    assert expected != pytest.approx(0.3 * 0.5 * P.sum(), rel=1e-3)


def test_distance_of_the_load_from_the_axis_does_not_enlarge_the_scale_about_x():
    """The load stays: only differences of levers count."""
    first, second = (scales(P, 0.0, places(y=S_AT + away))["about_x"] for away in (0.0, 100.0))
    assert second.changes == pytest.approx(first.changes)
    assert second.rounds > 10 * first.rounds


# ---- floors of forces and moments, each by its own levers

TURN = 0.15  # of the traction from element to element [rad]


def turning(depth, turn=TURN):
    """Sliding whose direction turns along x; at the leading edge tractions follow those behind."""
    angle = turn * X
    edge = LeadingEdge.find(FRICTION * P, depth)
    angle = np.take_along_axis(angle, edge.followed, axis=0)
    p = np.stack([FRICTION * P * np.cos(angle), FRICTION * P * np.sin(angle), P], axis=-1)
    slip = -1e-3 * np.stack([np.cos(angle), np.sin(angle)], axis=-1) * (P > 0)[..., None]
    return SlipState(p, np.zeros(SHAPE, bool), slip, FRICTION, edge.behind if depth else None)


def sums(state, at):
    return {name: float(np.sum(lever * state.p)) for name, lever in at.levers.items()}


@pytest.mark.parametrize("depth", [1, 2])
def test_the_turn_that_a_leading_edge_misses_is_in_the_floor_of_each_force(depth):
    """Beside a pole of slip the direction turns from element to element, and the last ones do not."""
    at = places()
    follows, own = turning(depth), turning(0)
    of, without = floors_of_forces(follows, at), floors_of_forces(own, at)
    missed = {name: abs(value - sums(own, at)[name]) for name, value in sums(follows, at).items()}
    for name in ("longitudinal", "lateral", "about_z"):
        assert missed[name] > 0.1 * without[name]  # it is no small part
        assert of[name] >= missed[name]
    # the direction turns on as it did: to the second order in the turn, 5 % of it
    assert of["lateral"] - without["lateral"] == pytest.approx(OF_FOLLOWERS * missed["lateral"], rel=0.3)


def test_sliding_in_one_direction_misses_no_turn():
    straight = turning(2, turn=0.0)
    np.testing.assert_allclose(straight.missed_turn, 0.0, atol=1e-12)


def test_an_element_counts_for_the_forces_that_it_contributes_to():
    """Tractions along x alone on level elements: the edge cuts F_x, and F_y not at all but by friction."""
    whole, sticking = tractions(np.zeros(SHAPE, bool), along_x(1e-3)), tractions(P > 0, along_x(0.0), 0.0)
    of, at_rest = (floors_of_forces(state, places()) for state in (whole, sticking))
    assert of["longitudinal"] > of["lateral"] > 0
    assert at_rest["longitudinal"] == at_rest["lateral"] == 0
    assert at_rest["centre"] > 0


def test_floors_of_forces_fall_faster_than_the_length_of_the_edge():
    """Elements are cut at random: forces of edge elements fall like h^2.5, their random sum like h^2."""

    def of_parts(parts):
        x, s = ((np.arange(n * parts) - middle * parts) / parts for n, middle in ((12, 5.7), (10, 4.4)))
        p = ellipse(x, s)[..., None] * [0.0, 0.0, 1.0]
        state = SlipState(p, p[..., 2] < 0, 0 * p[..., :2], 0.0)
        return floors_of_forces(state, places(0.05, x, s, 0.5 / parts**2))["lateral"]

    order = np.log2(of_parts(2) / of_parts(8)) / 2
    assert order == pytest.approx(2.0, abs=0.4)  # edges cut elements at random


def test_numbers_vanish_by_symmetry_of_all_elements_only():
    x, s = np.arange(12) - 5.5, np.arange(10) - 4.5
    p, at = ellipse(x, s)[..., None] * [0.0, 0.0, 1.0], places(0.05, x, s)
    all_but_levers_of_friction = {"longitudinal", "lateral", "about_x", "about_z", "centre"}
    assert vanishing_by_symmetry(p, at) == all_but_levers_of_friction
    by_chance = p.copy()
    by_chance[5, 2] *= 1.1  # two changes whose contributions to F_y cancel, not those of mirror images
    by_chance[5, 6] -= 0.1 * p[5, 2] * at.sin[2] / at.sin[6]
    sideways = float(np.sum(at.levers["lateral"] * by_chance))
    assert abs(sideways) < 1e-9 * float(np.sum(by_chance))
    assert not {"lateral", "about_x", "centre"} & vanishing_by_symmetry(by_chance, at)


@pytest.mark.parametrize("aspect", [0.05, 20.0])
def test_coarse_elements_along_one_direction_count_for_the_length_along_the_other(aspect):
    """Hertz, a circle with eight elements across one direction and 160 across the other."""
    exact = PointContact(1 / 500, 1 / 500, combined_modulus(STEEL, STEEL)).at_load(100.0)
    rail, wheel = Surface(LOWER, arc(500.0, 0.5, 0.5)), Surface(UPPER, plane(), 500.0)
    longer = 2 * exact.a / 8 * 1.05
    dx, ds = (longer, longer / aspect) if aspect > 1 else (longer * aspect, longer)
    grid = Grid(*(round(2 * 2 * exact.a / step / 8) * 8 for step in (dx, ds)), dx, ds)
    pair = Pair(Solid(STEEL, wheel), Solid(STEEL, rail))
    on_grid = PairOnGrid(pair, Undeformed(wheel, rail, (-5.0, 5.0), 0.0), grid)
    normal = on_grid.solve_in_place(on_grid.operator("A"), Loading(100.0))
    solved = SolvedContact(Loading(100.0), "A", PairContact(on_grid, normal))
    found, estimates = numbers(on_grid, normal), solved.estimated_errors()
    for name in ("a", "b"):
        assert abs(found[name] - getattr(exact, name)) <= estimates[name] <= 0.1 * exact.a, name
