import re
from functools import cache

import numpy as np
import pytest
from track_sections import (
    BACKS,
    HALF_ANGLE,
    TRACK,
    WHEELSET,
    Circles,
    Cone,
    brute_gaps,
    flanged,
    rail_points,
    rail_through,
    symmetric,
    wheel_points,
    wheel_through,
)
from worn_profiles import unworn

from geometries.errors import Failure, WrongInput
from geometries.profiles.preparation import Prepared
from geometries.track import wheelset
from geometries.track.curves import Graph, Samples, graphs
from geometries.track.en_15302 import CASES, WHEELS
from geometries.track.layout import lay_out
from geometries.track.touching import gap_minima, refined, refined_near
from geometries.track.wheelset import curves_in_place, settle, settle_wheel

CONE, CIRCLES = Cone(), Circles()
# -9.1 and 8.6 on a flange
SHIFTS = (
    -9.1,
    0.9,
    *(pytest.param(shift, marks=pytest.mark.slow) for shift in (-1.7, 0.0, 5.2, 8.6)),
)


# --- closed forms ----------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [-6.0, 0.0, 2.5, 7.0])
def test_cones_on_arcs_have_their_closed_form(shift):
    """The normals of both cones meet the centres of the rails: m sin(roll) = tan(gamma) * shift."""
    cone = CONE
    position = settle(cone.layout(), shift)
    t, m = np.tan(cone.gamma), cone.m
    along = shift * np.cos(position.roll) + (position.height + cone.R_r) * np.sin(position.roll)
    assert m * np.sin(position.roll) == pytest.approx(t * along, abs=1e-10)
    assert position.rolling_radius_difference == pytest.approx(2 * t * along, abs=1e-9)
    assert position.rolling_radius_difference == pytest.approx(2 * m * np.sin(position.roll), abs=1e-9)
    assert position.left[0].angle == pytest.approx(cone.gamma + position.roll, abs=1e-12)
    assert position.right[0].angle == pytest.approx(cone.gamma - position.roll, abs=1e-12)
    point = [m - cone.R_r * np.sin(position.left[0].angle), cone.R_r * (np.cos(position.left[0].angle) - 1)]
    np.testing.assert_allclose(position.left[0].point, point, rtol=0, atol=1e-9)
    if shift == 0:  # the radius at half-distance b is r_0 - tan(gamma) (b - tape circle)
        b = m - cone.R_r * np.sin(cone.gamma)
        radius = cone.r_0 - t * (b - BACKS / 2 - 70)
        assert position.roll == pytest.approx(0, abs=1e-14)
        assert position.left[0].radius == pytest.approx(radius, abs=1e-10)
        assert position.height == pytest.approx(radius + point[1], abs=1e-10)


@pytest.mark.parametrize("shift", [-5.0, -1.3, 0.0, 2.0, 6.4])
@pytest.mark.parametrize("circles", [CIRCLES, Circles(R_w=330.0, R_r=290.0, gamma=0.025, r_0=420.0)])
def test_arcs_on_arcs_agree_with_the_linkage_of_their_centres(circles, shift):
    roll, height, left, right = circles.linkage(shift)
    position = settle(circles.layout(), shift)
    # fsolve ends at 1e-12 of the height
    assert position.roll == pytest.approx(roll, abs=1e-12)
    assert position.height == pytest.approx(height, abs=1e-10)
    assert position.left[0].angle == pytest.approx(left, abs=1e-11)
    assert position.right[0].angle == pytest.approx(right, abs=1e-11)
    for touch, angle, turn in ((position.left[0], left, roll), (position.right[0], right, -roll)):
        radius = circles.r_0 + circles.R_w * (np.cos(circles.gamma) - np.cos(angle - turn))
        assert touch.radius == pytest.approx(radius, abs=1e-9)
        assert touch.s_rail == pytest.approx(circles.R_r * (HALF_ANGLE - angle), abs=1e-8)
        assert touch.s_wheel == pytest.approx(circles.R_w * (HALF_ANGLE - angle + turn), abs=1e-8)
        # second derivatives of polynomials 0.05 mm long: rounding of 1e-14 mm over (0.05 mm)^2
        assert touch.curvature_rail == pytest.approx(1 / circles.R_r, abs=2e-11)
        assert touch.curvature_wheel == pytest.approx(1 / circles.R_w, abs=2e-11)


def test_derivatives_of_arcs_on_arcs():
    """Roll and contact angle per shift, to first order (docs/theory/wheel-on-rail.md)."""
    c, h = CIRCLES, 1e-2
    t, s = np.tan(c.gamma), np.sin(c.gamma)
    plus, minus = (settle(c.layout(), shift) for shift in (h, -h))
    roll = t / (c.b - c.r_0 * t)
    angle = (np.cos(c.gamma) + roll * (c.b * s + c.r_0 * np.cos(c.gamma) + c.R_w)) / (c.R_w - c.R_r)
    # third derivatives are of the order 1 / R_w^2: h^2 / R_w^2 = 4e-10; 1e-10 mm / h
    assert (plus.roll - minus.roll) / (2 * h) == pytest.approx(roll, rel=1e-7)
    assert (plus.left[0].angle - minus.left[0].angle) / (2 * h) == pytest.approx(angle, rel=1e-7)


@pytest.mark.parametrize("shift", [-3.0, 4.5])
def test_without_roll_cones_have_their_angle(shift):
    cone = CONE
    position = settle(cone.layout(), shift, roll=0.0)
    assert position.rolling_radius_difference == pytest.approx(2 * np.tan(cone.gamma) * shift, abs=1e-9)
    assert np.subtract(*position.heights) == pytest.approx(2 * np.tan(cone.gamma) * shift, abs=1e-9)
    assert position.left[0].angle == pytest.approx(cone.gamma, abs=1e-12)


@pytest.mark.parametrize(
    "shift", [*(pytest.param(shift, marks=pytest.mark.slow) for shift in (-6.0, 5.0)), 8.3]
)
def test_shifts_at_the_rails_lead_to_the_position_of_the_shift_of_the_axle(shift):
    layout = flanged()
    at_rails = settle(layout, shift, roll="about rails")
    at_axle = settle(layout, at_rails.shift)
    assert at_rails.shift == pytest.approx(shift - 460 * np.sin(at_rails.roll), abs=1e-12)
    assert at_axle.shift_at_rails == pytest.approx(shift, abs=1e-9)
    assert at_rails.shift_at_rails == pytest.approx(at_rails.given_shift, abs=1e-12)
    assert at_axle.roll == pytest.approx(at_rails.roll, abs=1e-11)
    assert at_axle.left[0].angle == pytest.approx(at_rails.left[0].angle, abs=1e-9)


def test_a_steep_flange_is_reached_by_shifts_at_the_rails():
    """At 75 degrees heights fall with the shift of the axle: another position has the same with less roll."""
    y, z = wheel_points()
    steep = wheel_through(np.stack([y, z - 24 * (1 - np.tanh((y + 44) / 11))]))
    rail = rail_through(rail_points())
    layout = lay_out((rail, rail), (steep, steep), TRACK, WHEELSET)
    flange, farther = (settle(layout, shift, roll="about rails") for shift in (8.0, 8.5))
    assert 75 < np.degrees(flange.left[0].angle) < np.degrees(farther.left[0].angle) < 77
    assert farther.shift < flange.shift  # the axle goes back
    tread = settle(layout, flange.shift)
    assert tread.left[0].angle < 0.2
    assert tread.roll < flange.roll


@pytest.mark.parametrize(
    ("place", "error", "message"),
    [
        (lambda layout: settle(layout, np.nan), WrongInput, "shift"),
        (lambda layout: settle(layout, 0.0, roll="about bogie"), WrongInput, "about axle"),
        (lambda layout: settle(layout, 0.0, yaw=0.01), WrongInput, "ahead of the section through the axle"),
        (lambda layout: settle(layout, 150.0), Failure, r"does not lie above the rail|least at y"),
        (lambda layout: settle_wheel(layout, "left", np.nan), WrongInput, "lateral"),
        (lambda layout: settle_wheel(layout, "left", 0.0, roll=np.inf), WrongInput, "roll"),
        (lambda layout: settle_wheel(layout, "middle", 0.0), WrongInput, "side"),
    ],
)
def test_impossible_places_are_refused(place, error, message):
    with pytest.raises(error, match=message):
        place(symmetric())


# --- any sections ----------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", SHIFTS)
def test_brute_force_finds_the_same_points(shift):
    """On polygons of 30001 points: gaps of 4 um^2 / 8 R, so 1e-7 mm where R is 20 mm; points to 0.02 mm."""
    layout = flanged()
    position = settle(layout, shift)
    for side, touches in (("left", position.left), ("right", position.right)):
        t, gaps = brute_gaps(layout, position, side)
        assert np.min(gaps) == pytest.approx(0, abs=2e-7)
        assert t[np.argmin(gaps)] == pytest.approx(touches[0].s_rail, abs=0.02)


@pytest.mark.parametrize("shift", SHIFTS)
def test_touching_points_have_one_place_and_one_normal(shift):
    layout = flanged()
    position = settle(layout, shift, within=0.5)
    for side, own in (("left", layout.left), ("right", layout.right)):
        touches = getattr(position, side)
        rail, wheel = curves_in_place(layout, position, side)
        for touch in touches:
            apart = wheel.position(touch.s_wheel) - rail.position(touch.s_rail)
            np.testing.assert_allclose(apart, [0, touch.gap], rtol=0, atol=1e-9)
            normals = rail.tangent(touch.s_rail), wheel.tangent(touch.s_wheel)
            assert np.linalg.det(normals) == pytest.approx(0, abs=1e-8)
        first = touches[0]
        assert first.gap == pytest.approx(0, abs=1e-9)
        # places 760 mm from the middle are rounded to 1e-13
        np.testing.assert_allclose(first.on_rail, rail.curve.position(first.s_rail), rtol=0, atol=1e-12)
        np.testing.assert_allclose(first.on_wheel, wheel.curve.position(first.s_wheel), rtol=0, atol=1e-12)
        assert first.radius == pytest.approx(-float(own.wheel.position(first.s_wheel)[1]))


@pytest.mark.parametrize(
    "shift", [1.9, *(pytest.param(shift, marks=pytest.mark.slow) for shift in (0.7, 4.9)), 8.3]
)
def test_swapped_sections_mirror_the_positions(shift):
    """Left and right profiles exchanged: the position of the other shift."""
    one = settle(flanged((0.0, 0.02), (0.05, 0.04)), shift)
    other = settle(flanged((0.02, 0.0), (0.04, 0.05)), -shift)
    assert one.rolling_radius_difference == pytest.approx(-other.rolling_radius_difference, abs=1e-9)
    assert one.roll == pytest.approx(-other.roll, abs=1e-13)
    assert one.height == pytest.approx(other.height, abs=1e-10)
    assert one.left[0].angle == pytest.approx(other.right[0].angle, abs=1e-11)
    assert one.right[0].s_rail == pytest.approx(other.left[0].s_rail, abs=1e-8)


@pytest.mark.parametrize("shift", [pytest.param(-3.3, marks=pytest.mark.slow), 8.9])
def test_origins_of_the_profiles_do_not_matter(shift):
    one = settle(flanged(), shift)
    other = settle(flanged(offset=(31.7, -8.1, -12.9, 5.3)), shift)
    assert one.roll == pytest.approx(other.roll, abs=1e-12)
    assert one.height == pytest.approx(other.height, abs=1e-9)
    for side in ("left", "right"):
        (a, *_), (b, *_) = getattr(one, side), getattr(other, side)
        assert a.radius == pytest.approx(b.radius, abs=1e-8)
        assert a.angle == pytest.approx(b.angle, abs=1e-9)
        np.testing.assert_allclose(b.on_rail - a.on_rail, [31.7, -8.1], rtol=0, atol=1e-8)
        np.testing.assert_allclose(b.on_wheel - a.on_wheel, [-12.9, 5.3], rtol=0, atol=1e-8)


# --- flange ----------------------------------------------------------------------------------------


def test_a_wheelset_is_lifted_onto_its_flange_and_beyond_its_steepest_part():
    layout = symmetric()
    positions = [settle(layout, shift) for shift in (7.0, 8.0, 9.5)]
    angles = np.degrees([position.left[0].angle for position in positions])
    assert np.all(np.diff(angles) > 0)
    assert angles[0] < 4
    assert angles[1] > 50  # on the flange
    # rolling without end, the wheelset rises by tan(angle) per shift of the flange over the rail
    first, last = positions[1].left[0], positions[2].left[0]
    risen = positions[2].heights[0] - positions[1].heights[0]
    assert risen > np.tan(first.angle) * 1.5 > 1
    assert last.s_wheel < first.s_wheel  # from the root of the flange towards its tip
    assert not any(position.notes for position in positions)
    for shift, name in ((10.0, "left"), (-10.0, "right")):
        (note,) = settle(layout, shift).notes
        assert re.search(rf"the {name} wheel touches 1\.\d+ mm beyond the steepest part .* at 59\.", note)
        assert "angle falls as it climbs" in note


@pytest.mark.parametrize("shift", [8.5, 9.3, 10.5, 16.0])
def test_how_the_angle_changes_as_a_wheel_climbs(shift):
    """Without roll by k_r k_w / (k_r - k_w) / cos(delta): it falls where the wheel is convex, k_w < 0."""
    layout, h = symmetric(), 1e-4
    less, at, more = (settle(layout, shift + step, roll=0.0) for step in (-h, 0.0, h))
    touch = at.left[0]
    rail, wheel = touch.curvature_rail, touch.curvature_wheel
    rate = (more.left[0].angle - less.left[0].angle) / (2 * h)
    # h^2 / 6 of the third derivative over the first, which is 0 at the steepest part: curvatures of 0.1 / mm
    assert rail * wheel / (rail - wheel) / np.cos(touch.angle) == pytest.approx(rate, rel=1e-5, abs=1e-8)
    climbs = any("falls as it climbs" in note for note in at.notes)
    assert climbs == (rate < 0)


@cache
def with_a_tip(root_bend=0.0):
    """Flanges whose tips are round, at y = -63; `root_bend` makes the part above the root the steepest."""
    y, z = wheel_points(end=90.0)
    z = z + 0.05 * np.maximum(-62 - y, 0) ** 2 + root_bend * np.exp(-(((y + 38) / 2.5) ** 2)) * (y + 38)
    wheel, rail = wheel_through(np.stack([y, z])), rail_through(rail_points())
    return lay_out((rail, rail), (wheel, wheel), TRACK, WHEELSET)


def test_a_wheel_that_stands_on_the_tip_of_its_flange_has_climbed():
    layout = with_a_tip()
    held = settle(layout, 42.0, roll="about rails")
    assert 0 < held.left[0].angle < np.radians(20)
    assert "beyond the steepest part" in held.notes[0]
    for roll in ("about rails", 0.0):
        with pytest.raises(Failure, match=r"= 72 mm: the left wheel has climbed the rail.* of -\d+\.\d+ deg"):
            settle(layout, 72.0, roll=roll)
    with pytest.raises(Failure, match=r"lateral = 72 mm: the right wheel has climbed"):
        settle_wheel(layout, "right", 72.0)


def test_a_flange_that_is_steepest_at_its_root_touches_lower_and_is_no_climb():
    """The steepest part is 1 mm above the touching point, where the wheel is not convex: nothing climbs."""
    layout = with_a_tip(root_bend=1.2)
    side, position = layout.left, settle(layout, 8.0, roll="about rails")
    touch = position.left[0]
    assert touch.s_wheel < side.steepest - 1
    largest = side.wheel.at(side.steepest)
    assert np.degrees(touch.angle) < np.degrees(np.arctan2(largest.t_z, largest.t_y)) - 3
    (note,) = position.notes
    assert "beyond the steepest part" in note
    assert ("falls as it climbs" in note) == (touch.curvature_wheel < 0)


def test_touching_points_near_the_end_of_a_profile_or_far_below_the_top_are_noted():
    rail, wheel = rail_points(), wheel_points()
    touch = settle(symmetric(), 0.0).left[0]
    cut = rail_through(rail[:, rail[0] < touch.on_rail[0] + 1.5])
    whole, tread = rail_through(rail), wheel_through(wheel)
    layout = lay_out((cut, whole), (tread, tread), TRACK, WHEELSET)
    (note,) = settle(layout, 0.0, roll=0.0).notes
    away = layout.left.rail.limits[1] - settle(layout, 0.0, roll=0.0).left[0].s_rail
    assert note.startswith(f"the left wheel touches {away:.2f} mm from the end of the profile of the rail")
    assert 0 < away < 3
    deep = rail_through(np.stack([rail[0], rail[1]]) * [[1.0], [1.6]])  # flanks reach 32 mm down
    position = settle(lay_out((deep, deep), (tread, tread), TRACK, WHEELSET), 9.0, roll="about rails")
    assert not position.notes


# --- one wheel -------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [-8.6, 2.3, 8.4])
@pytest.mark.parametrize("side", ["left", "right"])
def test_one_wheel_at_the_place_of_a_wheelset_touches_as_it_does(side, shift):
    """The lowest point of the tape circle in the track, by the formula of the page, gives `lateral`."""
    layout = flanged()
    both, sign = settle(layout, shift), 1 if side == "left" else -1
    roll = sign * both.roll
    eta, zeta = BACKS / 2 + 70, -460.0
    lateral = sign * both.shift + eta * np.cos(roll) - zeta * np.sin(roll) - eta
    one = settle_wheel(layout, side, lateral, roll=roll, within=0.5)
    (touch, *_), (expected, *_) = getattr(one, side), getattr(both, side)
    assert one.shift == pytest.approx(both.shift, abs=1e-12)
    assert one.shift_at_rails == pytest.approx(both.shift_at_rails, abs=1e-12)
    assert one.pose(side) == pytest.approx(both.pose(side), abs=1e-11)
    for name in ("s_rail", "s_wheel", "angle", "radius", "gap", "curvature_rail", "curvature_wheel"):
        assert getattr(touch, name) == pytest.approx(getattr(expected, name), abs=1e-9)
    assert getattr(one, "right" if side == "left" else "left") == ()


@pytest.mark.parametrize("roll", [-0.02, 0.0, 0.013])
@pytest.mark.parametrize("side", ["left", "right"])
def test_one_cone_on_an_arc_has_its_closed_form(side, roll):
    """The normal of the cone, turned by the roll, passes through the centre of the arc."""
    cone, lateral = CONE, 3.7
    position = settle_wheel(cone.layout(), side, lateral, roll=roll)
    (touch,) = getattr(position, side)
    angle = cone.gamma + roll
    assert touch.angle == pytest.approx(angle, abs=1e-12)
    point = np.array([cone.m - cone.R_r * np.sin(angle), cone.R_r * (np.cos(angle) - 1)])
    np.testing.assert_allclose(touch.point, point, rtol=0, atol=1e-9)
    # from the tape point, which lies at its nominal place and `lateral` aside, along the tread
    tape_y = BACKS / 2 + 70 + lateral
    along = (point[0] - tape_y) / np.cos(angle)
    assert touch.radius == pytest.approx(cone.r_0 - along * np.sin(cone.gamma), abs=1e-9)
    assert position.pose(side)[1] == pytest.approx(roll)


def test_flange_and_tread_are_both_reported():
    """The second one within a distance, that of the parallel tangents, and not below it."""
    layout = symmetric()
    tread, flange = settle(layout, 7.5, within=0.5).left
    assert tread.angle < 0.1
    assert flange.angle > 0.9
    assert flange.distance == pytest.approx(flange.gap * np.cos(flange.angle), rel=1e-12)
    at, below = (1 + 1e-9) * flange.distance, (1 - 1e-9) * flange.distance
    assert len(settle(layout, 7.5, within=at).left) == 2
    assert len(settle(layout, 7.5, within=below).left) == 1
    assert len(settle(layout, 7.5, within=0.0).left) == 1


# --- the search ------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [41, 81, 161])
def test_heights_between_samples_have_an_error_of_fourth_order(n):
    """Cubic Hermite interpolation of cosh: h^4 / 384 * max cosh, and nearly that in the middle."""
    y = np.linspace(-1, 2, n)
    graph = Graph(y, y, np.cosh(y), np.sinh(y))
    middle = (y[1:] + y[:-1]) / 2
    errors = graph.heights(middle) - np.cosh(middle)
    np.testing.assert_allclose(-errors, (3 / (n - 1)) ** 4 / 384 * np.cosh(middle), rtol=2e-3, atol=1e-14)
    np.testing.assert_allclose(graph.heights(y), np.cosh(y), rtol=1e-15)


def test_parts_of_a_curve_that_turn_back_or_are_steep_are_no_graphs():
    t = np.linspace(0, 1.9 * np.pi, 400)  # over the top, back below, and up again
    circle = Samples(t, np.stack([-np.cos(t), np.sin(t)]), np.stack([np.sin(t), np.cos(t)]))
    (top,) = graphs(circle)
    assert np.all(np.diff(top.y) > 0)
    assert top.t[0] == pytest.approx(np.radians(5), abs=0.02)
    assert top.t[-1] == pytest.approx(np.radians(175), abs=0.02)


class Kinked:
    """A rail with an edge at the top, y = 0, and a smooth bump 1 mm below it."""

    def __init__(self):
        self.y = np.linspace(-24, 40, 64001)
        speed = np.hypot(1, self.slopes(self.y)[0])
        self.t = np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(self.y))])
        self.length, self.jumps = float(self.t[-1]), (float(self.t[24000]),)

    def slopes(self, y):
        """First and second derivative of z."""
        u = (y - 25) / 3
        bump = 15 * np.exp(-(u**2))
        return -0.6 * np.sign(y) - 2 / 3 * u * bump, (4 * u**2 - 2) / 9 * bump

    def position(self, t):
        y = np.interp(t, self.t, self.y)
        return np.array([y, -0.6 * np.abs(y) + 15 * np.exp(-(((y - 25) / 3) ** 2))])

    def inclination(self, t):
        return -np.arctan(self.slopes(np.interp(t, self.t, self.y))[0])

    def curvature(self, t):
        first, second = self.slopes(np.interp(t, self.t, self.y))
        return -second / (1 + first**2) ** 1.5


def test_an_edge_is_refused_even_if_a_smooth_point_is_near_and_so_is_the_end_of_a_profile():
    """A rail with an edge at its top; one cut off on the gauge side of its touching point."""
    flat, wheel = wheel_through(wheel_points(cone=0.0, hollow=0.0)), wheel_through(wheel_points())
    edge, cut = Kinked(), rail_through(rail_points()[:, :170])
    for within in (0.0, 50.0):
        with pytest.raises(Failure, match="kinks; smooth the profiles"):
            settle(lay_out((edge, edge), (flat, flat), TRACK, WHEELSET), 0.0, roll=0.0, within=within)
    with pytest.raises(Failure, match=r"least at y = .* where a profile ends"):
        settle(lay_out((cut, cut), (wheel, wheel), TRACK, WHEELSET), 0.0)


def test_a_bracket_beside_its_minimum_is_widened():
    """Samples that are level to their rounding may point a step too far."""
    layout = symmetric()
    position = settle(layout, 1.0)
    rail, wheel = curves_in_place(layout, position, "left")
    touch = position.left[0]
    bracket = touch.s_rail + 0.01, touch.s_rail + 0.09
    assert refined(rail, wheel, bracket, touch.s_wheel) is None
    assert refined_near(rail, wheel, bracket, touch.s_wheel).t_rail == pytest.approx(touch.s_rail, abs=1e-8)
    far = touch.s_rail + 5, touch.s_rail + 5.08
    assert refined_near(rail, wheel, far, touch.s_wheel + 5) is None


def test_a_shift_asks_for_no_point_of_a_slow_curve_and_searches_twice(monkeypatch):
    """Exact points of a spline take a millisecond each. Two searches a side: at 0, and at the roll found."""
    layout, searches = flanged(), []
    for name in ("position", "inclination", "curvature"):
        monkeypatch.setattr(Prepared, name, None)
    monkeypatch.setattr(wheelset, "gap_minima", lambda *given: searches.append(given) or gap_minima(*given))
    for shift in (-3.0, 0.4, 5.0, 8.4):
        searches.clear()
        settle(layout, shift, roll="about rails")
        assert len(searches) <= (4 if abs(shift) < 7 else 12)  # on the flange another point comes to touch


def test_pieces_of_a_standard_that_do_not_meet_are_no_kink():
    """S1002 has a step of 1.2e-4 mm where its flange root begins; 60E1 has the same radius, 13 mm, there."""
    side = unworn().right
    assert side.step == pytest.approx(1.18e-4, rel=0.01)
    minimum = gap_minima(side, 6.259430050435454, 0.0007352744131311587)[0]
    rail, wheel = side.rail.at(minimum.t_rail), side.wheel.at(minimum.t_wheel)
    assert np.arctan2(rail.t_z, rail.t_y) > 0.6
    assert minimum.t_wheel > side.wheel.curve.jumps[4]
    assert np.hypot(rail.t_y, rail.t_z) == pytest.approx(np.hypot(wheel.t_y, wheel.t_z))


def test_heights_that_jump_with_the_roll_have_a_roll():
    """Wheel A of EN 15302 at 6.45 mm: its pieces are 6e-4 mm apart, where a touching point passes."""
    position = settle(CASES["E1"].layout, 6.45)
    assert position.heights[0] == pytest.approx(position.heights[1], abs=1e-3)
    assert position.left[0].gap == 0 == position.right[0].gap


def test_an_edge_between_pieces_of_a_standard_touches():
    """Wheel I: 0.2 degrees at y = -29.9231. The rail touches it with angles between those of the pieces."""
    layout, wheel = CASES["E4"].layout, WHEELS["I"]
    joint = wheel.jumps[4]
    before, after = (-float(wheel.inclination(joint + step)) for step in (-1e-9, 1e-9))
    angle = (before + after) / 2
    # the edge lies on the rail's arc of 13 mm about y = -19.63949 mm where that has the angle between
    on_arc = layout.left.rail.offset[0] - 19.63949 - 13 * np.sin(angle)
    touch = settle(layout, on_arc - (750 - 29.9231), roll=0.0).left[0]
    assert touch.s_wheel == pytest.approx(joint, abs=1e-5)
    assert touch.angle == pytest.approx(angle, abs=1e-5)
    assert before < angle < after


# --- the page of the theory ------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [0.5, 8.7])
def test_the_slope_of_the_height_by_the_roll(shift):
    """The formula of the page against differences of heights, on tread and flange."""
    layout, h = flanged(), 1e-5
    roll = settle(layout, shift).roll
    at, more, less = (settle(layout, shift, roll=roll + step) for step in (0, h, -h))
    y, z = at.left[0].point
    slope = -((y - shift) + (z - at.heights[0]) * np.tan(at.left[0].angle))
    # second order in h times the radius 460 mm over curvatures of 10 mm
    assert (more.heights[0] - less.heights[0]) / (2 * h) == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize("shift", [0.5, 8.7])
def test_the_position_of_a_wheel_in_the_track(shift):
    layout = flanged()
    position = settle(layout, shift)
    for side, own, sign in (("left", layout.left, 1), ("right", layout.right, -1)):
        touch = getattr(position, side)[0]
        eta, zeta = own.wheel.position(touch.s_wheel)
        c, s = np.cos(sign * position.roll), np.sin(sign * position.roll)
        point = [sign * shift, position.height] + np.array([[c, -s], [s, c]]) @ [eta, zeta]
        np.testing.assert_allclose(point, touch.point, rtol=0, atol=1e-9)
        assert touch.radius == -zeta
