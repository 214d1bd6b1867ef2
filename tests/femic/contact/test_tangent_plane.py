"""Distances over the tangent plane: of circles, spheres and cones, and beside those along normals."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from femic.contact.undeformed import Line, TangentPlane, Undeformed
from geometries.contours import Contour, arc
from geometries.errors import WrongInput
from geometries.surfaces import LOWER, UPPER, Surface

R_RAIL, R_GROOVE, R_ROLL = 10.0, 10.9, 30.0  # mm
X_AT, S_AT = np.array([0.0, 0.7, -2.5, 4.0])[:, None], np.array([-2.0, -0.3, 0.0, 0.9, 2.4])


def inclined(angle):
    """A straight contour through the origin."""
    return Contour(Line((0.0, 0.0), angle), (0.0, 0.0))


def plane_of(upper, lower, *, rolling_radius=np.inf, shift=0.0, at=None, s_range=(-14.0, 14.0)):
    surfaces = Surface(UPPER, upper, rolling_radius), Surface(LOWER, lower)
    return TangentPlane(Undeformed(*surfaces, s_range, shift), at)


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
def test_an_arc_in_an_arc(shift, approach):
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
    surfaces = arc(-R_ROLL, 1.3, 1.3), inclined(angle)
    touching = -R_ROLL * np.tan(angle)
    found = plane_of(*surfaces, rolling_radius=R_ROLL, s_range=(-40.0, 40.0))
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
