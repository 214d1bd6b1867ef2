from functools import cache

import numpy as np
import pytest
import scipy
from profile_samples import sample

from geometries.errors import WrongInput
from geometries.profiles.pieces import ArcPiece, Outline, PolynomialPiece, arc_above, arc_below, line
from geometries.profiles.placement import contour_at
from geometries.profiles.standards import STANDARDS, RailHead, standard_profile

GAP = {"S1002": 2e-4}  # mm: the standard gives 9 or 10 digits, and zone C loses 6 of them
OUTLINES = {name: entry.outline for name, entry in STANDARDS.items()}
each = pytest.mark.parametrize("name", STANDARDS)


@cache
def samples(outline):
    """Arc lengths 4 um apart or less, and a tree of the points there."""
    s = np.linspace(0, outline.length, 40_001)
    return s, scipy.spatial.cKDTree(outline.position(s).T)


def distances(outline, points):
    """Distances of points (2, n) from an outline along its normal: to 0.2 nm, (4 um / 2)^2 / (2 * 12 mm)."""
    s, tree = samples(outline)
    at = s[tree.query(points.T)[1]]
    delta, off = outline.inclination(at), points - outline.position(at)
    return off[0] * np.sin(delta) + off[1] * np.cos(delta)


def lateral_at(outline, z):
    """Lateral positions at which an outline has the height z, in order."""
    s = np.linspace(0, outline.length, 20_001)
    above = outline.position(s)[1] > z
    return [
        float(
            outline.position(scipy.optimize.brentq(lambda t: outline.position(t)[1] - z, s[k], s[k + 1]))[0]
        )
        for k in np.flatnonzero(above[1:] != above[:-1])
    ]


# --- pieces ----------------------------------------------------------------------------------------


def test_arcs_keep_their_distance_from_the_centre_on_its_side_and_lines_have_no_curvature():
    centre, radius, y = (1.3, -2.0), 13.0, (-7.0, 11.5)
    for arc, side in ((arc_above(centre, radius, y), 1), (arc_below(centre, radius, y), -1)):
        points = arc.position(np.linspace(0, arc.length, 41))
        np.testing.assert_allclose(np.hypot(points[0] - 1.3, points[1] + 2.0), radius, rtol=1e-14)
        np.testing.assert_allclose(points[0][[0, -1]], y, rtol=1e-14)
        assert np.all(side * (points[1] + 2.0) > 0)
    piece = line((-1.0, 2.0), (2.0, -2.0))
    at = piece.position(np.array([0.0, 2.5, 5.0]))
    np.testing.assert_allclose(at, [[-1, 0.5, 2], [2, 0, -2]], atol=1e-15)
    assert (piece.length, piece.curvature(1.0)) == (5.0, 0.0)


def test_arc_mirrored_twice_is_the_same_arc():
    arc = ArcPiece((3.0, -1.0), 0.2, 1 / 9, 7.0)
    s = np.linspace(0, 7, 15)
    np.testing.assert_allclose(arc.mirrored.position(7 - s), arc.position(s) * [[-1], [1]], atol=1e-14)
    np.testing.assert_allclose(arc.mirrored.mirrored.position(s), arc.position(s), atol=1e-14)


def test_polynomial_is_run_through_by_arc_length():
    piece = PolynomialPiece((0.5, -1.0, 0.25, 0.125), (1.0, 3.5))
    s = np.linspace(0, piece.length, 50)
    y, z = piece.position(s)
    np.testing.assert_allclose(z, 0.5 - y + y**2 / 4 + y**3 / 8, rtol=0, atol=1e-13)
    slope = -1 + y / 2 + 3 * y**2 / 8
    np.testing.assert_allclose(piece.inclination(s), -np.arctan(slope), rtol=0, atol=1e-13)
    length = scipy.integrate.quad(lambda u: np.hypot(1, -1 + u / 2 + 3 * u**2 / 8), 1.0, 3.5, epsabs=1e-13)[0]
    assert piece.length == pytest.approx(length, rel=1e-13)


def test_coefficients_whose_terms_cancel_keep_their_digits():
    """(y - 30)^7 about y = 0 has terms of 2e10; near y = 30 its values are below 1."""
    coefficients = np.polynomial.polynomial.polyfromroots([30.0] * 7)
    piece = PolynomialPiece(tuple(coefficients), (29.2, 30.8))
    y, z = piece.position(np.linspace(0, piece.length, 30))
    np.testing.assert_allclose(z, (y - 30) ** 7, rtol=0, atol=1e-14)


# --- all standards ---------------------------------------------------------------------------------


@each
def test_pieces_meet_with_the_same_tangent(name):
    distance, turn = OUTLINES[name].gaps
    assert np.max(distance) < GAP.get(name, 1e-6)
    assert np.max(np.abs(turn)) < 1e-5  # rad; S1002: 4e-6 at the ends of zone C


@each
def test_derivative_of_position_is_the_unit_tangent_and_that_of_inclination_the_curvature(name):
    outline, h = OUTLINES[name], 1e-3
    s = np.linspace(2 * h, outline.length - 2 * h, 3000)
    s = s[np.min(np.abs(s[:, None] - outline.joints), axis=1) > 2 * h]

    def derivative(value):
        near, wide = ((value(s + k * h) - value(s - k * h)) / (2 * k * h) for k in (1, 2))
        return (4 * near - wide) / 3

    delta = outline.inclination(s)
    np.testing.assert_allclose(derivative(outline.position), [np.cos(delta), -np.sin(delta)], atol=1e-9)
    np.testing.assert_allclose(derivative(outline.inclination), outline.curvature(s), atol=1e-9)


@each
def test_points_go_from_the_gauge_side_to_the_field_side_with_all_joints_among_them(name):
    profile, outline = standard_profile(name, spacing=0.37), OUTLINES[name]
    steps = np.hypot(*np.diff(profile.points, axis=1))
    assert profile.kind == STANDARDS[name].kind
    assert np.all(np.diff(profile.points[0]) > 0)
    assert np.max(steps) <= 0.37 + GAP.get(name, 1e-6)
    joints = outline.position(outline.joints)
    apart = scipy.spatial.cKDTree(profile.points.T).query(joints.T)[0]
    assert np.max(apart) < GAP.get(name, 1e-6)
    assert STANDARDS[name].source in profile.notes[0]


@each
def test_rail_heads_are_symmetric_and_wheels_hang_down_at_the_gauge_side(name):
    """The top of a rail and the running point of a wheel are the origin."""
    outline = OUTLINES[name]
    points = outline.position(s := np.linspace(0, outline.length, 20_001))
    if STANDARDS[name].kind == "wheel":
        assert points[0, np.argmin(points[1])] < -50
        np.testing.assert_allclose(np.min(np.hypot(*points)), 0, atol=0.005)  # the nearest sample
    else:
        assert np.max(points[1]) == pytest.approx(0, abs=1e-6)
        mirrored = outline.position(outline.length - s) * [[-1], [1]]
        np.testing.assert_allclose(points, mirrored, rtol=0, atol=1e-12)


def test_unknown_names_and_spacings_are_refused():
    with pytest.raises(WrongInput, match="'60E9': not among the standard ones, S1002, 60E1"):
        standard_profile("60E9")
    with pytest.raises(WrongInput, match=r"spacing = 0\.0"):
        standard_profile("60E1", spacing=0.0)


# --- numbers of the standards that their definitions leave over --------------------------------------


@pytest.mark.parametrize(
    ("name", "width", "depth", "rounding"),
    # EN 13674-1 gives the width where the corner becomes the side; joints are rounded to 0.001 mm (the depth
    # follows 10 times as much), those of GB/T 2585 to 0.1 mm
    [("60E1", 72.0, 14.3, 0.001), ("54E1", 70.0, 14.1, 0.001), ("CHN60", 70.8, 14.2, 0.05)],
)
def test_corners_of_rails_end_at_the_width_and_depth_of_the_drawing(name, width, depth, rounding):
    outline = OUTLINES[name]
    y, z = outline.position(outline.joints[-2])
    assert 2 * y == pytest.approx(width, abs=rounding)
    assert -z == pytest.approx(depth, abs=max(rounding, 0.01))


@pytest.mark.parametrize(
    ("name", "head_height", "under_slope", "width"),
    [("60E1", 51.0, 1 / 2.75, 74.3), ("54E1", 49.4, 1 / 2.75, 72.2), ("CHN60", 48.5, 1 / 3, 73.0)],
)
def test_sides_meet_the_lower_faces_of_the_head_at_its_largest_width(name, head_height, under_slope, width):
    outline = OUTLINES[name]
    y, z = outline.position(outline.length)
    dy, dz = np.cos(outline.inclination(outline.length)), -np.sin(outline.inclination(outline.length))
    along = (-head_height + under_slope * y - z) / (dz - under_slope * dy)
    assert 2 * (y + along * dy) == pytest.approx(width, abs=0.05)  # given to 0.1 mm
    assert along > 1.5  # the outline ends above the rounding of the edge


def test_s1002_has_the_flange_of_its_name_and_the_slope_of_its_tread():
    outline = OUTLINES["S1002"]
    s = np.linspace(0, outline.length, 50_001)
    assert np.min(outline.position(s)[1]) == pytest.approx(-28, abs=1e-6)
    at_gauge_height = lateral_at(outline, -10.0)
    # thickness 10 mm below the running circle
    assert 70 + at_gauge_height[-1] == pytest.approx(32.5, abs=1e-3)
    assert np.min(outline.inclination(s)) == pytest.approx(-np.radians(70), abs=1e-9)  # the face rises
    assert outline.inclination(outline.length) == pytest.approx(-np.arctan(1 / 15), abs=1e-8)
    assert lateral_at(outline, 0.0)[0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(("name", "slope"), [("cone-1-20", 1 / 20), ("cone-1-40", 1 / 40)])
def test_cones_have_their_slope_on_all_of_the_tread_and_the_flange_of_s1002(name, slope):
    outline = OUTLINES[name]
    s = np.linspace(0, outline.length, 2001)
    y, z = outline.position(s)
    np.testing.assert_allclose(z[y > -24], slope * y[y > -24], rtol=0, atol=1e-9)
    tip = y < -39
    np.testing.assert_allclose(distances(OUTLINES["S1002"], np.stack([y, z])[:, tip]), 0, atol=1e-6)


def test_a_file_of_s1002_is_this_one():
    points = sample("MBench_S1002_v3.prw") * [[-1], [1]]
    assert points.shape[1] > 300
    assert np.max(np.abs(distances(OUTLINES["S1002"], points))) < 1e-6  # mm: y is given to 1e-6


def fitted(outline, points):
    """Rigid motion (turn, y, z) of points onto an outline, and their distances from it."""

    def off(motion):
        cos, sin = np.cos(motion[0]), np.sin(motion[0])
        return distances(outline, np.array([[cos, -sin], [sin, cos]]) @ points + motion[1:, None])

    fit = scipy.optimize.least_squares(off, [-0.02, 7.0, 0.0], x_scale=[0.01, 1, 1], xtol=1e-14)
    return fit.x, off(fit.x)


def test_a_file_of_uic60_is_60e1_canted_by_1_to_40_but_for_the_joint_of_its_first_two_arcs():
    """In the file the crown ends at 10.5 mm instead of 10.228 mm from the middle (20.456 in the drawing)."""
    points = sample("MBench_UIC60_v3.prr")
    points = points[:, points[1] > -30]  # the edge is not rounded in the file
    motion, off = fitted(OUTLINES["60E1"], points)
    assert np.tan(-motion[0]) == pytest.approx(1 / 40, rel=1e-4)
    assert np.max(np.abs(off)) < 24e-3
    shoulder_centre = 220 / 300 * 10.5
    corner_centre = 36 - 13 / np.hypot(1, 1 / 20)
    joint = shoulder_centre + 80 / 67 * (corner_centre - shoulder_centre)  # so that the head is 72 mm wide
    like_file = Outline(RailHead((300.0, 80.0, 13.0), (10.5, joint), -34.0).pieces())
    motion, off = fitted(like_file, points)
    assert np.tan(-motion[0]) == pytest.approx(1 / 40, rel=1e-4)
    assert np.max(np.abs(off)) < 1e-3


# --- as contours -----------------------------------------------------------------------------------


def test_exact_contours_know_where_their_curvature_jumps():
    outline = OUTLINES["60E1"]
    centre = float(outline.joints[3] + 20.0)  # on the shoulder, 20 mm from the start of the crown
    contour = contour_at(outline, centre)
    np.testing.assert_allclose(contour.joints[1:-1], outline.joints[2:-2] - centre, atol=1e-9)
    for joint in contour.joints[1:-1]:
        before, after = contour.curvature(np.array([joint - 1e-6, joint + 1e-6]))
        assert abs(after - before) > 1e-3
    assert np.degrees(np.abs(contour.inclination(np.array(contour.limits)))) == pytest.approx(85, abs=1e-6)
