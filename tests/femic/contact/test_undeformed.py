"""Distances of surfaces against the geometry of circles, parabolas and planes."""

from dataclasses import replace

import numpy as np
import pytest

from femic.contact.undeformed import Undeformed
from geometries.contours import arc, ellipse, plane, through_points
from geometries.errors import WrongInput
from geometries.surfaces import LOWER, UPPER, Surface

X_AT, S_AT = np.array([0.0, 0.7, -2.5, 4.0])[:, None], np.array([-2.0, -0.3, 0.0, 0.9, 2.4])


def surfaces(upper, lower, *, rolling_radius=np.inf, s_range=(-4.0, 4.0), shift=0.0):
    return Undeformed(Surface(UPPER, upper, rolling_radius), Surface(LOWER, lower), s_range, shift)


def test_a_plane_above_an_arc():
    """Along the normal of a circle of radius R: (R - R cos + raised) / cos."""
    angle = S_AT / 6.0
    scene = surfaces(plane(), arc(6.0, 0.9, 0.9))
    for approach in (0.0, 0.2, -0.1):
        expected = (6.0 * (1 - np.cos(angle)) - approach) / np.cos(angle)
        np.testing.assert_allclose(scene.distance(0.0, S_AT, approach), expected, rtol=1e-12, atol=1e-14)


def test_an_arc_above_a_plane_is_crowned_towards_it():
    """A crown of the upper body is a groove of the contour: its normal points into the body."""
    scene = surfaces(arc(-6.0, 0.9, 0.9), plane())
    expected = 6.0 - np.sqrt(36.0 - S_AT**2)
    np.testing.assert_allclose(scene.distance(X_AT, S_AT), expected + 0 * X_AT, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("approach", [0.0, 0.3, -0.05])
def test_an_arc_in_an_arc(approach):
    """Circles of radii 5.0 in 5.4 whose centres are 0.4 + approach apart: a ray from the inner centre."""
    apart, angle = 0.4 + approach, S_AT / 5.0
    expected = np.sqrt(5.4**2 - (apart * np.sin(angle)) ** 2) - apart * np.cos(angle) - 5.0
    scene = surfaces(arc(5.4, 1.2, 1.2), arc(5.0, 1.0, 1.1))
    np.testing.assert_allclose(scene.distance(0.0, S_AT, approach), expected, rtol=1e-11, atol=1e-13)


def test_a_cylinder_across_a_plane():
    scene = surfaces(plane(), plane(), rolling_radius=30.0)
    expected = 30.0 - np.sqrt(900.0 - X_AT**2)
    np.testing.assert_allclose(scene.distance(X_AT, S_AT), expected + 0 * S_AT, rtol=1e-12, atol=1e-15)


def test_a_sphere_and_a_torus_above_a_plane():
    """The upper contour revolves about an axis at height 30: radius 30 - z; on a sphere z makes it round."""
    for crown, expected in (
        (30.0, 30.0 - np.sqrt(900.0 - X_AT**2 - S_AT**2)),
        (4.0, 30.0 - np.sqrt((26.0 + np.sqrt(16.0 - S_AT**2)) ** 2 - X_AT**2)),
    ):
        scene = surfaces(arc(-crown, 1.2, 1.2), plane(), rolling_radius=30.0)
        np.testing.assert_allclose(scene.distance(X_AT, S_AT), expected, rtol=1e-11, atol=1e-14)


def test_a_groove_of_revolution_above_an_arc():
    """The points that the normals meet lie on the torus: its section's circle has the radius 5.4."""
    lower, radius = arc(5.0, 1.0, 1.1), 40.0
    distance = surfaces(arc(5.4, 1.2, 1.2), lower, rolling_radius=radius).distance(X_AT, S_AT, 0.1)
    (y, z), (sin, cos) = lower.position(S_AT), lower.normal(S_AT)
    y, z = y + distance * sin, z + distance * cos + 0.1  # in axes of the wheel
    z_of_contour = radius - np.hypot(radius - z, X_AT)
    np.testing.assert_allclose(np.hypot(y, 5.4 + z_of_contour), 5.4, rtol=1e-11)


@pytest.mark.parametrize("shift", [0.0, 0.35, -0.6])
def test_the_first_touching_point_of_a_shifted_circle(shift):
    """A circle of radius 5 in one of 9 shifted by c: their normals agree at sin(delta) = c / (9 - 5).

    The centre of the outer one lies then 4 cos(delta) below that of the inner one, where it was 4.
    """
    scene = surfaces(arc(9.0, 1.2, 1.2), arc(5.0, 1.2, 1.2), shift=-shift)
    delta = np.arcsin(shift / 4.0)
    at, raised = scene.touching
    assert at == pytest.approx(5.0 * delta, abs=2e-6)  # a minimum: half of the digits
    assert raised == pytest.approx(4.0 * (1 - np.cos(delta)), abs=1e-11)
    at_touching = scene.distance(0.0, np.array([at]))
    assert at_touching == pytest.approx(0.0, abs=1e-10)
    assert np.all(scene.distance(X_AT, S_AT) >= -1e-12)


def test_shifted_surfaces_are_as_far_apart_as_circles_are():
    apart = np.array([-0.35, -4.0 * np.cos(np.arcsin(0.35 / 4.0))])  # of the centres, y and z
    normal = np.stack([np.sin(S_AT / 5.0), np.cos(S_AT / 5.0)])
    along, across = apart @ normal, apart[0] * normal[1] - apart[1] * normal[0]
    scene = surfaces(arc(9.0, 1.2, 1.2), arc(5.0, 1.2, 1.2), shift=-0.35)
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


def descent(scene, x, s):
    step = 1e-5
    return (scene.distance(x, s, step) - scene.distance(x, s, -step)) / (2 * step)


def test_the_distance_falls_with_the_approach_as_the_upper_normal_says():
    """By n_uz / (n . n_u): circles 5 in 5.4, n_u from the outer centre to the point that the ray meets."""
    angle = S_AT / 5.0
    scene = surfaces(arc(5.4, 1.2, 1.2), arc(5.0, 1.0, 1.1))
    end = 5.0 + scene.distance(0.0, S_AT)
    n_u = np.stack([end * np.sin(angle), end * np.cos(angle) + 0.4]) / 5.4
    expected = -n_u[1] / (n_u[0] * np.sin(angle) + n_u[1] * np.cos(angle))
    np.testing.assert_allclose(descent(scene, 0.0, S_AT), expected, rtol=1e-8)


def test_distance_falls_by_cos_delta_times_the_approach_where_surfaces_conform():
    for clearance in (1e-2, 1e-4):
        scene = surfaces(arc(5.0 + clearance, 1.2, 1.2), arc(5.0, 1.0, 1.1))
        np.testing.assert_allclose(
            descent(scene, 0.0, S_AT), -np.cos(S_AT / 5.0), rtol=clearance * np.tan(0.5) + 1e-8
        )


def test_rays_past_the_ends_of_a_contour_meet_nothing():
    y = np.linspace(-3.0, 3.0, 31)
    cut = through_points(y, -(y**2) / 20)
    scene = surfaces(cut, arc(5.0, 1.0, 1.0), s_range=(-2.0, 2.0))
    distances = scene.distance(0.0, np.array([-4.9, -1.0, 0.0, 1.5, 4.9]))
    np.testing.assert_array_equal(np.isinf(distances), [True, False, False, False, True])


def test_rays_before_and_behind_a_wheel_meet_nothing():
    distances = surfaces(plane(), plane(), rolling_radius=3.0).distance(np.array([-3.1, 2.9, 3.1]), 0.0)
    np.testing.assert_array_equal(np.isinf(distances), [True, False, True])


def test_rays_that_fall_behind_a_tilted_plane_do_not_meet_it_backwards():
    """A plane that rises by 0.42 rad above a circle: R / cos(delta + 0.42) - R where this is positive."""
    y, delta = np.linspace(-400.0, 400.0, 9), np.array([-0.42, 0.0, 0.8, 1.1, 1.2, 1.35])
    scene = surfaces(through_points(y, np.tan(0.42) * y), arc(5.0, 1.4, 1.4))
    cosine = np.cos(delta + 0.42)
    assert np.sum(cosine < 0) == 2
    expected = np.where(cosine > 0, 5.0 / cosine - 5.0, np.inf)
    np.testing.assert_allclose(scene.distance(0.0, 5.0 * delta), expected, rtol=1e-9, atol=1e-10)


def test_a_lower_surface_of_revolution_is_refused():
    with pytest.raises(WrongInput, match="rolling_radius = 30 of the lower body: it must be prismatic"):
        Undeformed(Surface(UPPER, plane()), Surface(LOWER, plane(), 30.0), (-1.0, 1.0))


@pytest.mark.parametrize("s_range", [(1.0, 1.0), (2.0, -2.0), (0.0, np.inf)])
def test_a_range_needs_two_ends(s_range):
    with pytest.raises(WrongInput, match=r"s_range = .*: two finite arc lengths, the smaller one first"):
        surfaces(plane(), plane(), s_range=s_range)


def test_an_upper_contour_beside_the_lower_one_is_refused():
    y = np.linspace(-3.0, 3.0, 31)
    with pytest.raises(WrongInput, match="shift = 50 mm: no part of the upper contour lies above the lower"):
        surfaces(through_points(y, -(y**2) / 20), plane(), shift=50.0)


def test_the_upper_arc_length_runs_ahead_where_a_shifted_groove_touches():
    """A circle in a circle: both touch where their normals have the angle asin(shift / (R - r))."""
    r, R, shift = 10.0, 12.0, 0.7
    pair = Undeformed(
        Surface(UPPER, arc(R, 1.0, 1.0)), Surface(LOWER, arc(r, 1.0, 1.0)), (-9.0, 9.0), shift=shift
    )
    angle = -np.arcsin(shift / (R - r))
    assert pair.touching[0] == pytest.approx(r * angle, abs=1e-6)
    assert pair.upper_offset == pytest.approx((R - r) * angle, abs=1e-6)
    assert replace(pair, shift=0.0).upper_offset == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("shift", [0.0, 0.7, -1.2])
@pytest.mark.parametrize("radius", [np.inf, 300.0])
def test_the_upper_surface_is_as_high_as_a_ray_of_the_inner_circle_meets_the_outer_one(shift, radius):
    """Over its own crown: a wheel moved aside touches on larger circles about its axle."""
    r, R = 10.0, 12.0
    groove, rail = arc(R, 1.0, 1.0), arc(r, 1.0, 1.0)
    pair = surfaces(groove, rail, rolling_radius=radius, s_range=(-7.0, 7.0), shift=shift)
    sin, cos = np.sin(S_AT / r), np.cos(S_AT / r)
    y, z = -shift, np.sqrt((R - r) ** 2 - shift**2)  # of the inner centre from the outer one
    along = -(y * sin + z * cos) + np.sqrt((y * sin + z * cos) ** 2 - (R - r) ** 2 + R**2)
    np.testing.assert_allclose(pair.upper_height(S_AT), z + along * cos - R, rtol=0, atol=1e-6)
    touching = pair.touching[0]
    assert pair.upper_height(touching) == pytest.approx(-R * (1 - np.cos(touching / r)), abs=1e-6)


def test_height_is_that_of_the_lower_surface_where_nothing_is_opposite():
    y = np.linspace(-3.0, 3.0, 61)
    narrow = surfaces(through_points(y, -(y**2) / 24), arc(10.0, 0.6, 0.6))
    assert np.isinf(narrow.distance(0.0, 5.0))
    assert narrow.upper_height(5.0) == pytest.approx(-10 * (1 - np.cos(0.5)), abs=1e-3)


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
