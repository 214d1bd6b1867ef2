"""Elements that could be in another state: borders, slip that vanishes within an element, edges; scales."""

import numpy as np
import pytest

from femic.contact.estimates import (
    OF_EDGE,
    OF_FOLLOWERS,
    OF_SLIDING,
    OF_TURNING,
    Places,
    SlipState,
    floors,
    floors_of_forces,
    scales,
    vanishing_by_symmetry,
)
from femic.contact.friction.motion import LeadingEdge

SHAPE = (12, 10)
X, S = np.meshgrid(np.arange(12) - 5.7, np.arange(10) - 4.4, indexing="ij")
P = np.sqrt(np.maximum(1 - (X / 5) ** 2 - (S / 4) ** 2, 0.0)) * 700.0
FRICTION = 0.3


def tractions(stick, slip, filled=1.0, friction=FRICTION):
    """Pressures on an ellipse, with tangential tractions along x that fill this share of bounds."""
    p = np.stack([filled * friction * P, 0 * P, P], axis=-1)
    return SlipState(p, stick & (P > 0), np.where((stick | (P == 0))[..., None], 0.0, slip), friction)


def along_x(slip):
    return np.stack([slip + 0 * X, 0 * X], axis=-1)


def test_uniform_sliding_is_not_open():
    whole = tractions(np.zeros(SHAPE, bool), along_x(1e-3))
    assert not whole.open.any()
    assert floors(whole)["sliding"] == 0
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
    x, s = np.meshgrid((np.arange(24) - 11.4) / 2, (np.arange(20) - 8.8) / 2, indexing="ij")
    p = np.sqrt(np.maximum(1 - (x / 5) ** 2 - (s / 4) ** 2, 0.0))
    fine = SlipState(
        np.stack([0 * p, 0 * p, p], axis=-1), p < 0, np.stack([1e-4 * x, 0 * x], axis=-1), FRICTION
    )
    coarse = floors(tractions(np.zeros(SHAPE, bool), along_x(1e-4 * X)))
    for name, value in floors(fine).items():
        assert 0.2 * coarse[name] < value < 0.75 * coarse[name], name


def places(tilt=0.0, x=None):
    y = np.arange(10) - 4.4
    tilts = tilt * y
    return Places(
        np.arange(12) - 5.7 if x is None else x, y, -tilt * y**2 / 2, np.sin(tilts), np.cos(tilts), 0.5
    )


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
    of_strips = np.linspace(0.1, 0.5, P.shape[1])
    expected = 0.5 * sum(of_strips[j] * P[:, j].sum() for j in range(P.shape[1]))
    assert scales(P, of_strips, places())["longitudinal"].changes == pytest.approx(expected)
    assert expected != pytest.approx(0.3 * 0.5 * P.sum(), rel=1e-3)


def test_distance_of_the_load_from_the_axis_does_not_enlarge_the_scale_about_x():
    """The load stays: only differences of levers count."""
    here, there = places(), places()
    there = Places(there.x, there.y + 100.0, there.z, there.sin, there.cos, there.area)
    first, second = (scales(P, 0.0, at)["about_x"] for at in (here, there))
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
    whole = tractions(np.zeros(SHAPE, bool), along_x(1e-3))
    of, at_rest = (
        floors_of_forces(whole, places()),
        floors_of_forces(tractions(P > 0, along_x(0.0), 0.0), places()),
    )
    assert of["longitudinal"] > of["lateral"] > 0
    assert at_rest["longitudinal"] == at_rest["lateral"] == 0
    assert at_rest["centre"] > 0


def test_floors_of_forces_fall_faster_than_the_length_of_the_edge():
    """Elements are cut at random: forces of edge elements fall like h^2.5, their random sum like h^2."""

    def of_half_elements(parts):
        n_x, n_s = 12 * parts, 10 * parts
        x, s = (np.arange(n_x) - 5.7 * parts) / parts, (np.arange(n_s) - 4.4 * parts) / parts
        p = np.sqrt(np.maximum(1 - (x[:, None] / 5) ** 2 - (s / 4) ** 2, 0.0))
        none = np.zeros((n_x, n_s, 2))
        tilts = 0.05 * s
        at = Places(x, s, -0.025 * s**2, np.sin(tilts), np.cos(tilts), 0.5 / parts**2)
        state = SlipState(p[..., None] * [0.0, 0.0, 1.0], p < 0, none, 0.0)
        return floors_of_forces(state, at)["lateral"]

    order = np.log2(of_half_elements(2) / of_half_elements(8)) / 2
    assert order == pytest.approx(2.0, abs=0.4)  # edges cut elements at random


def test_numbers_vanish_by_symmetry_of_all_elements_only():
    s = np.arange(10) - 4.5
    x = np.arange(12) - 5.5
    p = np.sqrt(np.maximum(1 - (x[:, None] / 5) ** 2 - (s / 4) ** 2, 0.0))[..., None] * [0.0, 0.0, 700.0]
    tilts = 0.05 * s
    at = Places(x, s, -0.025 * s**2, np.sin(tilts), np.cos(tilts), 0.5)
    all_but_levers_of_friction = {"longitudinal", "lateral", "about_x", "about_z", "centre"}
    assert vanishing_by_symmetry(p, at) == all_but_levers_of_friction
    by_chance = p.copy()
    by_chance[5, 2] *= 1.1  # two changes whose contributions to F_y cancel, not those of mirror images
    by_chance[5, 6] -= 0.1 * p[5, 2] * np.sin(tilts[2]) / np.sin(tilts[6])
    sideways = float(np.sum(at.levers["lateral"] * by_chance))
    assert abs(sideways) < 1e-9 * float(np.sum(by_chance))
    assert not {"lateral", "about_x", "centre"} & vanishing_by_symmetry(by_chance, at)
