"""Archard's law on a Winkler foundation: closed forms of arcs, areas, convergence, and the worn pair."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
import scipy
from worn_profiles import (
    TRACK,
    WHEELSET,
    WORN_AREA,
    WearLaw,
    all_contacts,
    contacts_at,
    sample_sections,
    shifts_in_curves,
    unworn,
    wear,
    worn_pair,
)

from geometries.errors import Failure, WrongInput
from geometries.profiles.files import read_profile
from geometries.profiles.preparation import first_crossing, prepare
from geometries.profiles.profile import Profile
from geometries.profiles.smoothing import chord_lengths
from geometries.profiles.standards import NAMED, WORN
from geometries.track.layout import TrackDimensions, WheelsetDimensions, lay_out

R_R, R_W = 80.0, 110.0
CHEAP = WearLaw(steps=45, straight_samples=40, curve_samples=20)
STRAIGHT = WearLaw(
    curving=0.0, steps=1, straight_samples=1, curve_samples=1, spread=0.01, lateral=(-0.01, 0.01)
)


@cache
def arcs():
    """A rail whose crown and a wheel whose groove are arcs, which touch at their tops without shift."""
    angle = np.linspace(-0.6, 0.6, 600)
    rail, wheel = (
        prepare(Profile(kind, radius * np.stack([np.sin(angle), np.cos(angle) - 1])))
        for kind, radius in (("rail", R_R), ("wheel", R_W))
    )
    gauge = 1435.0
    y_gauge = -np.sqrt(R_R**2 - (R_R - 8) ** 2)
    top = gauge / 2 - y_gauge  # of the rail in the track [mm]
    wheelset = WheelsetDimensions(2 * (top - 70.0), 460.0, -70.0)
    return lay_out((rail, rail), (wheel, wheel), TrackDimensions(gauge, 8.0, False), wheelset).left


def largest_difference(one, other):
    """Largest distance [mm] of points of two pairs."""
    return max(float(np.max(np.hypot(*(a - b)))) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("shift", [0.0, 2.5])
def test_arcs_overlap_by_the_area_of_two_circular_segments(shift):
    """Depth over the chord 2c of the overlap: d(u) = (c^2 - u^2) / 2 (1/R_r - 1/R_w), area 2/3 c^3 (...)."""
    overlap = 0.05
    rail, wheel = sample_sections(arcs(), 0.05)
    contacts = contacts_at(rail, wheel, np.array([shift]), overlap)
    curvature = 1 / R_R - 1 / R_W
    half = (1.5 * overlap / curvature) ** (1 / 3)
    inside = rail.graph.y[contacts.on_rail[0] > 0]
    angle = shift / (R_W - R_R)  # of the common normal, by which the touching point moves on the rail
    assert np.ptp(inside) == pytest.approx(2 * half * np.cos(angle), rel=0.02)
    assert np.max(contacts.on_rail) == pytest.approx(half**2 * curvature / 2, rel=0.02)
    assert contacts.on_rail[0] @ np.gradient(rail.graph.y) == pytest.approx(overlap, rel=1e-9)
    assert contacts.on_wheel[0] @ np.gradient(wheel.graph.y) == pytest.approx(overlap, rel=1e-3)
    assert contacts.lateral_shares[0] == pytest.approx(np.tan(angle), abs=2e-3)


def test_a_lateral_force_shifts_arcs_until_their_normal_has_its_direction():
    """The centres are R_w - R_r apart along the normal: shift = (R_w - R_r) sin delta."""
    rail, wheel = sample_sections(arcs(), 0.05)
    shares = np.array([0.02, 0.1])
    shifts = shifts_in_curves(rail, wheel, shares, 0.02)
    np.testing.assert_allclose(shifts, (R_W - R_R) * np.sin(np.arctan(shares)), rtol=5e-3)
    with pytest.raises(Failure, match="smaller range"):
        shifts_in_curves(rail, wheel, np.array([5.0]), 0.02)


def test_one_step_of_one_contact_wears_off_its_overlap():
    """The worn layer is the overlap, scaled to the worn area; rail downwards and wheel upwards."""
    side, area = arcs(), (0.02, 0.01)
    pair = wear(side, STRAIGHT, area, 0.05)
    rail, wheel = sample_sections(side, 0.05)
    half = (1.5 * STRAIGHT.overlap / (1 / R_R - 1 / R_W)) ** (1 / 3)
    for section, depth, worn, moved, sign, offset in (
        (rail, pair.rail_depth, area[0], pair.rail, -1, side.rail.offset),
        (wheel, pair.wheel_depth, area[1], pair.wheel, 1, side.wheel.offset),
    ):
        lateral = section.points[0] - side.rail.offset[0]
        expected = 0.75 * worn / half * np.maximum(1 - (lateral / half) ** 2, 0)
        np.testing.assert_allclose(depth, expected, atol=0.02 * np.max(expected))
        change = moved.points - (section.points - np.array(offset)[:, None])
        np.testing.assert_allclose(np.sign(change[1, depth > 1e-6]), sign)


def test_worn_areas_are_the_given_ones():
    """Layers between unworn and worn sections, by the polygon's area; thin ones in one step."""
    law = replace(CHEAP, steps=1)
    side, area = unworn().left, (0.3, 0.2)
    pair = wear(side, law, area)
    lengths = [chord_lengths(section.points) for section in sample_sections(side, 0.2)]
    for depth, s, worn in zip((pair.rail_depth, pair.wheel_depth), lengths, area, strict=True):
        assert scipy.integrate.trapezoid(depth, s) == pytest.approx(worn, rel=0.01)


def test_worn_profiles_converge_with_the_steps():
    """The error of explicit steps falls with their length: halved with twice as many."""
    law = replace(CHEAP, straight_samples=20, curve_samples=10)
    pairs = [wear(unworn().left, replace(law, steps=steps), (10.0, 10.0)) for steps in (10, 20, 40)]
    points = [(pair.rail.points, pair.wheel.points) for pair in pairs]
    first, second = (largest_difference(*two) for two in pairwise(points))
    assert second < 1e-3
    assert first / second == pytest.approx(2, abs=0.3)


@pytest.mark.slow
def test_worn_profiles_converge_with_the_samples_of_shifts():
    laws = [replace(CHEAP, straight_samples=n, curve_samples=n // 2) for n in (20, 40, 80, 160)]
    pairs = [wear(unworn().left, law, WORN_AREA) for law in laws]
    points = [(pair.rail.points, pair.wheel.points) for pair in pairs]
    differences = [largest_difference(*two) for two in pairwise(points)]
    assert differences[0] > 2 * differences[1] > 4 * differences[2]
    assert differences[2] < 1e-3


@pytest.mark.slow
def test_files_of_the_package_are_exactly_by_the_law():
    for profile in worn_pair():
        (entry,) = (entry for entry in WORN.values() if entry.kind == profile.kind)
        np.testing.assert_allclose(read_profile(entry.path).points, profile.points, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", WORN)
def test_worn_profiles_are_valid_and_smooth(name):
    """No crossing, order kept, no kinks: radii stay above 9 mm, the least unworn one is 12 mm."""
    curve = NAMED[name].outline
    points = curve.position(np.linspace(0, curve.length, 3000))
    assert first_crossing(points) is None
    assert curve.position(0.0)[0] < curve.position(curve.length)[0]
    assert np.max(np.abs(curve.curvature(np.linspace(0, curve.length, 20_000)))) < 1 / 9
    assert curve.kind == NAMED[name].kind


def test_flange_root_and_gauge_corner_conform():
    """With a lateral force of half the vertical one the overlap is wider and turns further than unworn."""
    names = (("60E1", "S1002"), ("60E1-worn", "S1002-worn"))
    contacts = []
    for rail, wheel in names:
        curves = NAMED[rail].outline, NAMED[wheel].outline
        left = lay_out((curves[0],) * 2, (curves[1],) * 2, TRACK, WHEELSET).left
        contacts.append(
            all_contacts(*sample_sections(left, 0.2), WearLaw(lateral=(0.45, 0.55), curve_samples=1))
        )
    unworn_contact, worn_contact = contacts
    assert worn_contact.turns[-1] > 1.5 * unworn_contact.turns[-1]
    widths = [np.ptp(each.rail.graph.y[each.on_rail[-1] > 0]) for each in contacts]
    assert widths[1] > 2 * widths[0]


def test_the_worn_tread_is_hollow_and_the_crown_flat():
    """The tread is worn where it rolls and not at the field side; the rail turns less across its crown."""
    s = np.linspace(0, 1, 5000)
    before, after = (
        np.interp([0.0, 50.0], *curve.position(curve.length * s))
        for curve in (NAMED["S1002"].outline, NAMED["S1002-worn"].outline)
    )
    assert after[0] - before[0] > 0.8
    assert after[1] == pytest.approx(before[1], abs=1e-3)
    turns = []
    for name in ("60E1", "60E1-worn"):
        curve = NAMED[name].outline
        y = curve.position(curve.length * s)[0]
        delta = curve.inclination(curve.length * s)
        turns.append(np.ptp(delta[np.abs(y) < 20]))
    assert turns[1] < 0.8 * turns[0]


@pytest.mark.parametrize("changed", [{"overlap": 0.0}, {"steps": 0}, {"curving": 1.5}, {"deviation": np.nan}])
def test_wrong_laws_are_refused(changed):
    with pytest.raises(WrongInput, match=next(iter(changed))):
        WearLaw(**changed)


def test_contacts_at_the_end_of_a_profile_are_refused():
    rail, wheel = sample_sections(arcs(), 0.2)
    with pytest.raises(Failure, match="end of a profile"):
        contacts_at(rail, wheel, np.array([25.0]), 0.4)
