"""Elements that could be in another state: borders, slip that vanishes within an element, edges; scales."""

import numpy as np
import pytest

from femic.contact.error_floors import OF_EDGE, OF_SLIDING, OF_TURNING, Places, SlipState, floors, scales

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
    assert floors(turns)["sliding"] == pytest.approx((OF_SLIDING + OF_TURNING) * share)


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
        assert 0.3 * coarse[name] < value < 0.75 * coarse[name], name


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
