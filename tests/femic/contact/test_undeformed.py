"""Distances of surfaces, along normals and over the tangent plane: circles, parabolas, spheres, cones."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from femic.contact.undeformed import Line, TangentPlane, Undeformed
from geometries.contours import Contour, arc, ellipse, plane, through_points
from geometries.errors import WrongInput
from geometries.surfaces import LOWER, UPPER, Surface

# ---- along normals

X_AT, S_AT = np.array([0.0, 0.7, -2.5, 4.0])[:, None], np.array([-2.0, -0.3, 0.0, 0.9, 2.4])


NARROW = through_points(np.linspace(-3.0, 3.0, 31), -(np.linspace(-3.0, 3.0, 31) ** 2) / 20)


def surfaces(upper, lower, *, rolling_radius=np.inf, s_range=(-4.0, 4.0), shift=0.0):
    return Undeformed(Surface(UPPER, upper, rolling_radius), Surface(LOWER, lower), s_range, shift)


def test_a_plane_above_an_arc():
    """Along the normal of a circle of radius R: (R - R cos + raised) / cos."""
    angle = S_AT / 6.0
    scene = surfaces(plane(), arc(6.0, 0.9, 0.9))
    for approach in (0.0, 0.2, -0.1):
        expected = (6.0 * (1 - np.cos(angle)) - approach) / np.cos(angle)
        np.testing.assert_allclose(scene.distance(0.0, S_AT, approach), expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("approach", [0.0, 0.3, -0.05])
def test_an_arc_in_an_arc(approach):
    """Circles of radii 5.0 in 5.4 whose centres are 0.4 + approach apart: a ray from the inner centre."""
    apart, angle = 0.4 + approach, S_AT / 5.0
    expected = np.sqrt(5.4**2 - (apart * np.sin(angle)) ** 2) - apart * np.cos(angle) - 5.0
    bodies = Surface(UPPER, arc(5.4, 1.2, 1.2)), Surface(LOWER, arc(5.0, 1.0, 1.1))
    scene = Undeformed(*bodies, (-4.0, 4.0))  # without a shift
    np.testing.assert_allclose(scene.distance(0.0, S_AT, approach), expected, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize(
    ("upper", "radius", "expected"),
    [
        (arc(-6.0, 0.9, 0.9), np.inf, 6.0 - np.sqrt(36.0 - S_AT**2)),
        (plane(), 30.0, 30.0 - np.sqrt(900.0 - X_AT**2)),
        (arc(-30.0, 1.2, 1.2), 30.0, 30.0 - np.sqrt(900.0 - X_AT**2 - S_AT**2)),
        (arc(-4.0, 1.2, 1.2), 30.0, 30.0 - np.sqrt((26.0 + np.sqrt(16.0 - S_AT**2)) ** 2 - X_AT**2)),
    ],
    ids=["arc", "cylinder across", "sphere", "torus"],
)
def test_a_crown_above_a_plane(upper, radius, expected):
    """A crown of the upper body is a groove of the contour: its normal points into the body.

    The contour revolves about an axis at height 30: radius 30 - z; on a sphere z makes it round.
    """
    distance = surfaces(upper, plane(), rolling_radius=radius).distance(X_AT, S_AT)
    np.testing.assert_allclose(distance, expected + 0 * X_AT + 0 * S_AT, rtol=1e-11, atol=1e-14)


def test_a_groove_of_revolution_above_an_arc():
    """The points that the normals meet lie on the torus: its section's circle has the radius 5.4."""
    lower, radius = arc(5.0, 1.0, 1.1), 40.0
    distance = surfaces(arc(5.4, 1.2, 1.2), lower, rolling_radius=radius).distance(X_AT, S_AT, 0.1)
    (y, z), (sin, cos) = lower.position(S_AT), lower.normal(S_AT)
    y, z = y + distance * sin, z + distance * cos + 0.1  # in axes of the wheel
    z_of_contour = radius - np.hypot(radius - z, X_AT)
    np.testing.assert_allclose(np.hypot(y, 5.4 + z_of_contour), 5.4, rtol=1e-11)


@pytest.mark.parametrize("shift", [0.0, 0.35, -0.6])
def test_a_shifted_circle_in_a_circle(shift):
    """A circle of radius 5 in one of 9 shifted by c: their normals agree at sin(delta) = c / (9 - 5).

    The centre of the outer one lies then 4 cos(delta) below that of the inner one, where it was 4. Along s
    the outer one is ahead by 4 delta where both touch.
    """
    scene = surfaces(arc(9.0, 1.2, 1.2), arc(5.0, 1.2, 1.2), shift=-shift)
    delta = np.arcsin(shift / 4.0)
    at, raised = scene.touching
    assert at == pytest.approx(5.0 * delta, abs=2e-6)  # a minimum: half of the digits
    assert scene.upper_offset == pytest.approx(4.0 * delta, abs=2e-6)
    assert raised == pytest.approx(4.0 * (1 - np.cos(delta)), abs=1e-11)
    assert scene.distance(0.0, np.array([at])) == pytest.approx(0.0, abs=1e-10)
    assert np.all(scene.distance(X_AT, S_AT) >= -1e-12)
    apart = np.array([-shift, -4.0 * np.cos(delta)])  # of the centres, y and z
    normal = np.stack([np.sin(S_AT / 5.0), np.cos(S_AT / 5.0)])
    along, across = apart @ normal, apart[0] * normal[1] - apart[1] * normal[0]
    expected = np.sqrt(81.0 - across**2) + along - 5.0
    np.testing.assert_allclose(scene.distance(0.0, S_AT), expected, rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("higher", [-3.0, 3.0])
def test_of_two_bumps_the_higher_one_touches_first(higher):
    """Parabolas 0.3 (y -+ 3)^2, the other one 0.02 lower."""
    y = np.linspace(-6, 6, 241)
    z = -0.3 * np.minimum((y - higher) ** 2, (y + higher) ** 2 + 0.02 / 0.3)
    smooth = through_points(y, z)
    at, raised = surfaces(plane(), smooth, s_range=(-7.0, 7.0)).touching
    assert smooth.position(at)[0] == pytest.approx(higher, abs=1e-3)
    crown = z.max() - np.interp(0.0, y, z)  # contours are 0 at y = 0
    assert raised == pytest.approx(crown, abs=1e-6)


@pytest.mark.parametrize("end", [-1, 1])
def test_surfaces_may_touch_beside_the_end_of_the_range(end):
    """Circles of radius 5 in 5.4, the outer one moved by y: they touch at the angle asin(y / 0.4)."""
    at = 5.0 * np.arcsin(end * 0.2 / 0.4)
    s_range = sorted((at + end * 1e-3, -3.0 * end))
    scene = surfaces(arc(5.4, 1.2, 1.2), arc(5.0, 1.0, 1.1), s_range=tuple(s_range), shift=-end * 0.2)
    assert scene.touching[0] == pytest.approx(at, abs=1e-5)


@pytest.mark.parametrize("rolling_radius", [np.inf, 30.0])
def test_mirrored_surfaces_have_mirrored_distances(rolling_radius):
    lower, mirrored = ellipse(5.0, 6.0, 0.9, 0.5), ellipse(5.0, 6.0, 0.5, 0.9)
    upper, mirrored_upper = ellipse(5.6, 6.9, 1.0, 0.8), ellipse(5.6, 6.9, 0.8, 1.0)
    here = surfaces(upper, lower, rolling_radius=rolling_radius, shift=0.2)
    there = surfaces(mirrored_upper, mirrored, rolling_radius=rolling_radius, shift=-0.2)
    distances = here.distance(X_AT, S_AT, 0.05)
    np.testing.assert_allclose(there.distance(X_AT, -S_AT, 0.05), distances, rtol=1e-9, atol=1e-10)
    np.testing.assert_array_equal(here.distance(-X_AT, S_AT, 0.05), distances)
    assert here.touching[1] == pytest.approx(there.touching[1], abs=1e-12)


@pytest.mark.parametrize("clearance", [0.4, 1e-2, 1e-4])
def test_the_distance_falls_with_the_approach_as_the_upper_normal_says(clearance):
    """By n_uz / (n . n_u), n_u from the outer centre to the point met: where they conform by cos(delta)."""
    angle, step = S_AT / 5.0, 1e-5
    scene = surfaces(arc(5.0 + clearance, 1.2, 1.2), arc(5.0, 1.0, 1.1))
    falls = (scene.distance(0.0, S_AT, step) - scene.distance(0.0, S_AT, -step)) / (2 * step)
    end = 5.0 + scene.distance(0.0, S_AT)
    n_u = np.stack([end * np.sin(angle), end * np.cos(angle) + clearance]) / (5.0 + clearance)
    expected = -n_u[1] / (n_u[0] * np.sin(angle) + n_u[1] * np.cos(angle))
    np.testing.assert_allclose(falls, expected, rtol=1e-8)
    np.testing.assert_allclose(falls, -np.cos(angle), rtol=clearance * np.tan(0.5) + 1e-8)


def test_rays_past_the_ends_of_a_contour_or_a_wheel_meet_nothing():
    scene = surfaces(NARROW, arc(5.0, 1.0, 1.0), s_range=(-2.0, 2.0))
    past_ends = scene.distance(0.0, np.array([-4.9, -1.0, 0.0, 1.5, 4.9]))
    past_wheel = surfaces(plane(), plane(), rolling_radius=3.0).distance(np.array([-3.1, 2.9, 3.1]), 0.0)
    np.testing.assert_array_equal(np.isinf(past_ends), [True, False, False, False, True])
    np.testing.assert_array_equal(np.isinf(past_wheel), [True, False, True])
    # where nothing is opposite, heights are those of the lower surface
    assert scene.upper_height(4.9) == pytest.approx(-5 * (1 - np.cos(0.98)), abs=1e-3)


def test_rays_that_fall_behind_a_tilted_plane_do_not_meet_it_backwards():
    """A plane that rises by 0.42 rad above a circle: R / cos(delta + 0.42) - R where this is positive."""
    y, delta = np.linspace(-400.0, 400.0, 9), np.array([-0.42, 0.0, 0.8, 1.1, 1.2, 1.35])
    scene = surfaces(through_points(y, np.tan(0.42) * y), arc(5.0, 1.4, 1.4))
    cosine = np.cos(delta + 0.42)
    assert np.sum(cosine < 0) == 2
    expected = np.where(cosine > 0, 5.0 / cosine - 5.0, np.inf)
    np.testing.assert_allclose(scene.distance(0.0, 5.0 * delta), expected, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("shift", [0.0, 0.7, -1.2])
@pytest.mark.parametrize("radius", [np.inf, 300.0])
def test_the_upper_surface_is_as_high_as_a_ray_of_the_inner_circle_meets_the_outer_one(shift, radius):
    """Over its own crown: a wheel moved aside touches on larger circles about its axle."""
    r, R = 10.0, 12.0
    bodies = arc(R, 1.0, 1.0), arc(r, 1.0, 1.0)
    pair = surfaces(*bodies, rolling_radius=radius, s_range=(-7.0, 7.0), shift=shift)
    sin, cos = np.sin(S_AT / r), np.cos(S_AT / r)
    y, z = -shift, np.sqrt((R - r) ** 2 - shift**2)  # of the inner centre from the outer one
    along = -(y * sin + z * cos) + np.sqrt((y * sin + z * cos) ** 2 - (R - r) ** 2 + R**2)
    np.testing.assert_allclose(pair.upper_height(S_AT), z + along * cos - R, rtol=0, atol=1e-6)
    touching = pair.touching[0]
    assert pair.upper_height(touching) == pytest.approx(-R * (1 - np.cos(touching / r)), abs=1e-6)


def test_flanks_beyond_the_axle_are_not_met():
    """A steep roller of 20 mm in a groove: some circles have a radius of 0, or less than x."""
    scene = surfaces(arc(-30.0, 1.4, 1.4), arc(-40.0, 1.2, 1.2), rolling_radius=20.0, s_range=(-100.0, 100.0))
    x, s = np.array([0.0, 1.0, 5.0])[:, None], np.linspace(-100, 100, 2001)
    distance = scene.distance(x, s)
    assert distance[0, 1000] == pytest.approx(0.0, abs=1e-9)
    met = np.isfinite(distance)
    contour = scene.lower.contour
    z = contour.position(s)[1] - scene.touching[1] + distance * contour.normal(s)[1]  # over the crown
    assert np.all(z[met] < 20.0)
    assert not met[:, [0, -1]].any()


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"s_range": (1.0, 1.0)}, "s_range = .*: two finite arc lengths, the smaller one first"),
        ({"s_range": (2.0, -2.0)}, "s_range = .*: two finite arc lengths, the smaller one first"),
        ({"s_range": (0.0, np.inf)}, "s_range = .*: two finite arc lengths, the smaller one first"),
        ({"shift": 50.0}, "shift = 50 mm: no part of the upper contour lies above the lower"),
        (
            {"lower": Surface(LOWER, plane(), 30.0)},
            "rolling_radius = 30 of the lower body: it must be prismatic",
        ),
    ],
)
def test_bodies_that_do_not_fit_are_refused(keys, message):
    bodies = {"lower": Surface(LOWER, plane()), "s_range": (-4.0, 4.0)} | keys
    with pytest.raises(WrongInput, match=message):
        Undeformed(Surface(UPPER, NARROW), **bodies)


# ---- over the tangent plane

R_RAIL, R_GROOVE, R_ROLL = 10.0, 10.9, 30.0  # mm


def inclined(angle):
    """A straight contour through the origin."""
    return Contour(Line((0.0, 0.0), angle), (0.0, 0.0))


def plane_of(upper, lower, *, at=None, s_range=(-14.0, 14.0), **keys):
    return TangentPlane(surfaces(upper, lower, s_range=s_range, **keys), at)


def over(plane, y, z):
    """Coordinate and height over the plane of points (y, z) of the lower body's axes."""
    cos, sin = np.cos(plane.angle), np.sin(plane.angle)
    y_0, z_0 = plane.bodies.lower.contour.position(plane.place)
    return (y - y_0) * cos - (z - z_0) * sin, (y - y_0) * sin + (z - z_0) * cos


def arcs(shift=2e-1):
    """Circles of radii 10 in 10.9, whose flanks do not matter here."""
    return plane_of(arc(R_GROOVE, 1.3, 1.2), arc(R_RAIL, 1.2, 1.3), shift=shift)


def height_of_circle(plane, radius, y, z, s):
    """Height over the plane of the top of a circle about (y, z)."""
    along, across = over(plane, y, z)
    return across + np.sqrt(radius**2 - (s - along) ** 2)


# ---- closed forms


@pytest.mark.parametrize("approach", [0.0, 0.05, -0.3])
@pytest.mark.parametrize("shift", [0.0, 0.45, -0.6])
def test_an_arc_in_an_arc_over_the_plane(shift, approach):
    """Both are circles over any plane. They touch where their normals lie on the line of the centres."""
    plane = arcs(shift)
    apart = R_GROOVE - R_RAIL
    assert plane.angle == pytest.approx(-np.arcsin(shift / apart), abs=1e-6)
    centre = apart * np.cos(plane.angle) - R_GROOVE + plane.touching[1] - apart * np.cos(plane.angle)
    upper = height_of_circle(plane, R_GROOVE, shift, centre - approach, S_AT)
    lower = height_of_circle(plane, R_RAIL, 0.0, -R_RAIL, S_AT)
    np.testing.assert_allclose(plane.distance(0.0, S_AT, approach), upper - lower, atol=1e-11)
    assert plane.distance(0.0, 0.0) == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("angle", [0.0, 0.35, -0.7])
def test_a_sphere_above_an_inclined_plane(angle):
    """The distance along the normal of the plane is that of a sphere that touches it, at any angle."""
    bodies = arc(-R_ROLL, 1.3, 1.3), inclined(angle)
    touching = -R_ROLL * np.tan(angle)
    found = plane_of(*bodies, rolling_radius=R_ROLL, s_range=(-40.0, 40.0))
    assert found.angle == angle
    assert found.place == pytest.approx(touching, abs=1e-6)
    plane = replace(found, at=touching)
    expected = R_ROLL - np.sqrt(R_ROLL**2 - X_AT**2 - S_AT**2)
    np.testing.assert_allclose(plane.distance(X_AT, S_AT), expected, atol=1e-11)


@pytest.mark.parametrize("angle", [0.05, 0.6, -0.6])
def test_a_cone_on_a_cylinder(angle):
    """The cone is a quadric: a quadratic equation for its height at each (x, s)."""
    plane = plane_of(inclined(angle), arc(R_RAIL, 1.2, 1.2), rolling_radius=R_ROLL)
    assert plane.angle == pytest.approx(angle, abs=1e-6)
    cos, sin, tan = np.cos(plane.angle), np.sin(plane.angle), np.tan(angle)
    (y, z), axle = plane.lower.contour.position(S_AT), R_ROLL + plane.touching[1]
    # (axle - z - eta cos)^2 + x^2 = (R_ROLL + (y + eta sin) tan)^2
    a = cos**2 - sin**2 * tan**2
    b = -2 * ((axle - z) * cos + (R_ROLL + y * tan) * sin * tan)
    c = (axle - z) ** 2 + X_AT**2 - (R_ROLL + y * tan) ** 2
    cone = 2 * c / (-b + np.sqrt(b**2 - 4 * a * c))
    cylinder = height_of_circle(plane, R_RAIL, 0.0, -R_RAIL, S_AT)
    np.testing.assert_allclose(plane.distance(X_AT, S_AT), cone - cylinder, atol=1e-11)


# ---- beside the distance along normals


def test_concentric_arcs_are_farther_apart_along_the_normal_of_the_plane():
    """The distance along normals is g everywhere, over the plane g / cos(alpha) to the first order in g."""
    plane, gap = arcs(0.0), R_GROOVE - R_RAIL
    alpha = np.array([-0.5, -0.1, 0.0, 0.3])
    np.testing.assert_allclose(plane.bodies.distance(0.0, R_RAIL * alpha, -gap), gap, rtol=1e-11)
    s = R_RAIL * np.sin(alpha)
    expected = np.sqrt(R_GROOVE**2 - s**2) - np.sqrt(R_RAIL**2 - s**2)
    np.testing.assert_allclose(plane.distance(0.0, s, -gap), expected, rtol=1e-11)
    np.testing.assert_allclose(expected, gap / np.cos(alpha), rtol=0.06 * 0.5)
    assert expected[0] > 1.1 * gap


@pytest.mark.parametrize("shift", [0.0, 0.45])
def test_both_distances_agree_to_the_second_order_beside_the_touching_point(shift):
    """Their difference over the distance itself falls by 4 where the place is twice as near."""
    plane = arcs(shift)
    differences = []
    for alpha in (0.2, 0.1, 0.05):
        turned = plane.place + R_RAIL * np.array([-alpha, alpha])
        along_normals = plane.bodies.distance(0.0, turned)
        s = R_RAIL * np.sin([-alpha, alpha])
        differences.append(np.max(np.abs(plane.distance(0.0, s) / along_normals - 1)))
    assert 0.005 < differences[0] < 0.1
    for coarse, fine in pairwise(differences):
        assert coarse / fine == pytest.approx(4.0, rel=0.1)


# ---- places


def test_distance_ends_where_a_section_turns_beyond_the_normal():
    """A circle lies over its tangent plane as far as its radius; its flanks do not come back here."""
    at = -1.1 * R_RAIL
    plane = plane_of(arc(R_GROOVE, 1.4, 1.3), arc(R_RAIL, 1.4, 1.3), at=at)
    assert plane.angle == pytest.approx(-1.1)
    assert plane.s_range[1] == pytest.approx(R_RAIL, rel=1e-4)
    inside, outside = np.array([0.0, 0.99 * R_RAIL]), np.array([1.001 * R_RAIL, 12.0])
    assert np.all(np.isfinite(plane.distance(0.0, inside)))
    assert np.all(np.isinf(plane.distance(0.0, outside)))
    assert np.all(np.isnan(plane.lower_arc_length(outside)))
    narrow = plane_of(arc(-4.0, 1.4, 1.4), inclined(0.6), rolling_radius=R_ROLL)
    ends = narrow.distance(0.0, np.array([-3.9, 3.9, 9.0]))
    np.testing.assert_array_equal(np.isfinite(ends), [True, True, False])


def test_the_plane_has_places_of_the_lower_contour_up_to_its_ends():
    plane = arcs(0.45)
    for end, beyond in zip(plane.s_range, (-1e-9, 1e-9), strict=True):
        assert np.isfinite(plane.lower_arc_length(end))
        assert np.isnan(plane.lower_arc_length(end + beyond))


def test_arc_lengths_of_the_lower_contour_and_heights_over_the_origin():
    plane = arcs(0.45)
    alpha = np.array([-0.4, 0.0, 0.2])
    opposite = plane.lower_arc_length(R_RAIL * np.sin(alpha))
    np.testing.assert_allclose(opposite, plane.place + R_RAIL * alpha, atol=1e-10)
    expected = plane.bodies.lower.contour.position(plane.place)[1] - 3.0 * np.sin(plane.angle)
    assert plane.upper_height(3.0) == pytest.approx(expected - plane.touching[1])


def test_plane_moves_with_the_touching_point_and_may_be_at_another_place():
    plane = arcs(0.2)
    moved, direct = plane.moved_to(0.45), arcs(0.45)
    np.testing.assert_array_equal(moved.distance(X_AT, S_AT), direct.distance(X_AT, S_AT))
    beside = replace(plane, at=plane.place + 1.0)
    assert beside.angle == pytest.approx(plane.angle + 0.1)
    assert beside.distance(0.0, 0.0) > 1e-3
    with pytest.raises(WrongInput, match=r"tangent plane at s = 13 mm: the bodies are not opposite there"):
        plane_of(Contour(Line((0.0, 0.0), 0.0), (0.0, 0.0), (-5.0, 5.0)), arc(R_RAIL, 1.2, 1.2), at=13.0)
