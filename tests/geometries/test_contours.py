import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometries.contours import Contour, arc, ellipse, plane, through_points
from geometries.errors import WrongInput

C, Y_0 = 9.0, 1.3  # parameter of the catenary z = -C (cosh(y / C) - 1), and where its s = 0 lies
quiet = settings(deadline=None, max_examples=40, database=None)


def catenary(n):
    u = np.linspace(-1, 1, n)
    y = 8 * (u + 0.2 * u**2)  # unequal steps, unequal ends
    return through_points(y, -C * (np.cosh(y / C) - 1), Y_0)


SMOOTH = {
    "plane": plane(),
    "arc": arc(10.0, 0.45, 1.1),
    "groove": arc(-7.0, 0.9, 0.4),
    "ellipse": ellipse(12.97, 6.485, 1.3, 0.8),
    "ellipse 1:5": ellipse(1.0, 5.0, 1.5, 1.1),
    "ellipse 5:1": ellipse(5.0, 1.0, 1.1, 1.5),
    "spline": catenary(41),
}
CURVED = {name: contour for name, contour in SMOOTH.items() if name != "plane"}
each = pytest.mark.parametrize("contour", SMOOTH.values(), ids=SMOOTH)
each_curved = pytest.mark.parametrize("contour", CURVED.values(), ids=CURVED)


def away_from_joints(contour, distance):
    left, right = contour.limits
    s = np.linspace(left - 3.1, right + 2.3, 400)
    return s[np.min(np.abs(s - np.array(contour.limits)[:, None]), axis=0) > distance]


# --- arc length ------------------------------------------------------------------------------------


@each
def test_the_tangent_and_the_curvature_are_derivatives_of_position_and_inclination(contour):
    h = 1e-3
    s = away_from_joints(contour, 2 * h)

    def derivative(f):
        near, wide = ((f(s + k * h) - f(s - k * h)) / (2 * k * h) for k in (1, 2))
        return (4 * near - wide) / 3

    # fourth order in h / 0.2 mm (the sharpest crown): below 1e-8; inversion noise 1e-14 * 60 mm / h
    np.testing.assert_allclose(derivative(contour.position), contour.tangent(s), rtol=0, atol=3e-8)
    np.testing.assert_allclose(np.hypot(*contour.tangent(s)), 1, rtol=1e-15)
    # of a derivative that is 5 at the sharpest crown
    np.testing.assert_allclose(derivative(contour.inclination), contour.curvature(s), rtol=0, atol=3e-7)


@each
def test_tangent_and_normal_follow_the_inclination_and_the_normal_points_up(contour):
    s = np.linspace(-12.0, 15.0, 50).reshape(5, 10)
    tangent, normal, delta = contour.tangent(s), contour.normal(s), contour.inclination(s)
    rounding = {"rtol": 0, "atol": 1e-15}
    np.testing.assert_allclose(tangent, [np.cos(delta), -np.sin(delta)], **rounding)
    np.testing.assert_allclose(normal, [-tangent[1], tangent[0]], **rounding)  # a quarter turn from y to z
    assert np.all(normal[1] > 0)
    np.testing.assert_allclose(contour.position(0.0), 0, rtol=0, atol=1e-13)  # rounding of some mm


# --- joints and flanks -----------------------------------------------------------------------------


@each_curved
@pytest.mark.parametrize("step", [1e-3, 1e-6])
def test_position_and_inclination_are_continuous_at_the_joints(contour, step):
    joint = np.array(contour.joints)
    jump = contour.position(joint + step) - contour.position(joint - step)
    np.testing.assert_allclose(np.hypot(*jump), 2 * step, rtol=1e-2)  # the chord of 2 * step
    turn = contour.inclination(joint + step) - contour.inclination(joint - step)
    assert np.all(np.abs(turn) <= 6 * step)  # curvature below 1 / 0.2 mm: the crown of 1:5


@pytest.mark.parametrize(
    ("contour", "left", "right"),
    [
        (arc(10.0, 0.45, 1.1), -0.45, 1.1),
        (arc(-7.0, 0.9, 0.4), 0.9, -0.4),  # a groove rises away from the crown
        (ellipse(12.97, 6.485, 1.3, 0.8), -1.3, 0.8),
        (ellipse(1.0, 5.0, 1.5, 1.1), -1.5, 1.1),
        (ellipse(5.0, 1.0, 1.1, 1.5), -1.1, 1.5),
        (plane(), 0.0, 0.0),
    ],
)
def test_flanks_are_straight_with_the_inclination_asked_for(contour, left, right):
    s = np.array([0.0, 3.0, 40.0])
    # inversion of the arc length to 1e-14 of 60 mm, times a curvature below 5 / mm
    np.testing.assert_allclose(contour.inclination(contour.limits[0] - s), left, rtol=0, atol=1e-11)
    np.testing.assert_allclose(contour.inclination(contour.limits[1] + s), right, rtol=0, atol=1e-11)
    y, z = contour.position(contour.limits[1] + s)
    np.testing.assert_allclose(np.diff(z), -np.tan(right) * np.diff(y), rtol=1e-9, atol=1e-12)  # as above


def test_joints_are_where_the_flanks_begin_and_a_plane_has_none():
    assert arc(10.0, 0.45, 1.1).joints == (-4.5, 11.0)
    assert arc(-10.0, 0.45, 1.1).joints == (-4.5, 11.0)
    assert plane().joints == ()


# --- arcs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [10.0, -7.0])
def test_arc_keeps_its_distance_from_the_centre_below_or_above(radius):
    s = np.linspace(-0.4, 0.9, 30) * abs(radius)
    y, z = arc(radius, 0.5, 1.0).position(s)
    np.testing.assert_allclose(np.hypot(y, z + radius), abs(radius), rtol=1e-15 * 4)


def test_nearly_flat_arc_is_a_parabola_to_all_digits():
    s, radius = np.array([-3.0, 0.5, 2.0]), 1e9
    y, z = arc(radius, 1e-8, 1e-8).position(s)
    np.testing.assert_allclose(z, -(s**2) / (2 * radius), rtol=1e-15)  # next term: (s / R)^2 / 12
    np.testing.assert_allclose(y, s, rtol=1e-15)


# --- ellipses --------------------------------------------------------------------------------------

semi_axes = pytest.mark.parametrize(("b", "d"), [(5.0, 1.0), (1.0, 5.0), (13.7, 6.49), (6.985, 14.7)])


@semi_axes
def test_ellipse_satisfies_its_equation_and_is_inclined_perpendicularly_to_its_gradient(b, d):
    contour = ellipse(b, d, 1.4, 0.9)
    s = np.linspace(*contour.limits, 60)
    y, z = contour.position(s)
    np.testing.assert_allclose((y / b) ** 2 + (z / d + 1) ** 2, 1, rtol=1e-14)  # rounding
    # near a vertical flank dz/dy = -tan(delta) is steep, and z + d keeps 1e-16 * d of some mm
    np.testing.assert_allclose(np.tan(contour.inclination(s)), d**2 * y / (b**2 * (z + d)), rtol=1e-12)


@semi_axes
def test_joint_of_the_ellipse_lies_at_the_integral_of_its_arc_length(b, d):
    end = mpmath.atan2(b * mpmath.sin(0.9), d * mpmath.cos(0.9))
    length = mpmath.quad(lambda t: mpmath.hypot(b * mpmath.cos(t), d * mpmath.sin(t)), [0, end / 2, end])
    assert ellipse(b, d, 1.4, 0.9).limits[1] == pytest.approx(float(length), rel=1e-13)


@quiet
@given(b=st.floats(1, 5), d=st.floats(1, 5), at=st.floats(-1, 1))
def test_any_ellipse_to_aspect_five_inverts_its_arc_length(b, d, at):
    core = ellipse(b, d, 1.5, 1.5).core
    s = at * core.arc_length(np.array(np.pi / 2))
    # known to 1e-14 of the length that the table spans, the whole ellipse
    whole = core.arc_length(np.array(2 * np.pi))
    np.testing.assert_allclose(core.arc_length(core.angle(s)), s, rtol=0, atol=2e-14 * whole)


# --- splines ---------------------------------------------------------------------------------------


def catenary_errors(n):
    y = np.linspace(-3.0, 5.0, 1501)
    s = C * (np.sinh(y / C) - np.sinh(Y_0 / C))  # closed form of the arc length
    exact = np.stack([y - Y_0, -C * (np.cosh(y / C) - np.cosh(Y_0 / C))])
    contour = catenary(n)
    position = np.max(np.abs(contour.position(s) - exact))
    return position, np.max(np.abs(contour.inclination(s) - np.arctan(np.sinh(y / C))))


def test_spline_converges_to_the_curve_at_the_order_of_cubics():
    sizes = [21, 41, 81, 161, 321]
    errors = np.array([catenary_errors(n) for n in sizes])
    rates = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    # 4 and 3; the place of the centre between two points moves single errors by some ten percent
    np.testing.assert_allclose(rates, [4, 3], rtol=0, atol=0.3)
    assert np.all(errors[0] < (0.8 / C) ** 3)  # spacing 0.8 mm on a curve of radius C


def test_spline_passes_through_its_points_in_whichever_frame_they_are():
    y, z = np.array([-4.0, -2.5, 0.3, 2.0, 5.5]), np.array([-0.9, -0.2, 0.1, -0.3, -1.8])
    contour, shifted = through_points(y, z, 0.3), through_points(y + 70.0, z - 3.0, 70.3)
    s = contour.core.arc_length(contour.core.curve.x)
    np.testing.assert_allclose(contour.position(s), [y - 0.3, z - 0.1], rtol=0, atol=1e-12)  # rounding
    s = np.linspace(-4.0, 4.0, 20)
    np.testing.assert_allclose(shifted.position(s), contour.position(s), rtol=0, atol=1e-12)  # eps of 70 mm


@pytest.mark.parametrize("delta", [-0.7, 0.0, 1.2])
def test_spline_through_a_tilted_line_is_that_line(delta):
    at = np.array([-5.0, -1.0, 0.5, 3.0, 4.0])  # arc lengths of the points
    contour = through_points(at * np.cos(delta), -at * np.sin(delta), 2.2 * np.cos(delta))
    s = np.linspace(-11.0, 6.0, 30)  # beyond both ends as well; only rounding is left
    np.testing.assert_allclose(contour.inclination(s), delta, rtol=0, atol=1e-13)
    np.testing.assert_allclose(contour.position(s), [s * np.cos(delta), -s * np.sin(delta)], atol=1e-12)
    np.testing.assert_allclose(contour.extent, (-7.2, 1.8), rtol=1e-12)


def test_spline_answers_at_an_arc_length_of_rounding_size():
    contour = catenary(41)
    for s in np.geomspace(1e-17, 1e-3, 60):
        off = np.hypot(*(contour.position(s) - s * contour.tangent(0.0)))
        assert off <= s**2 / C + 1e-12  # half a curvature below 1 / C; 1e-14 of the curve's 17 mm


# --- symmetry --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("contour", "symmetric"),
    [
        (plane(), True),
        (arc(10.0, 0.5, 0.5), True),
        (arc(-10.0, 0.5, 0.5), True),
        (ellipse(3.0, 7.0, 0.9, 0.9), True),
        (arc(10.0, 0.4, 0.4 + 1e-6), False),
        (arc(10.0, 0.5, 0.501), False),
        (arc(-10.0, 0.45, 0.5), False),
        (ellipse(3.0, 7.0, 0.9, 0.8), False),
        (catenary(21), False),
        (Contour(arc(10.0, 0.5, 0.5).core, (-5.0, 5.0), (-8.0, 9.0)), False),
    ],
)
def test_equal_flanks_and_ends_make_a_symmetric_contour(contour, symmetric):
    assert contour.symmetric == symmetric


def test_spline_through_mirrored_points_is_symmetric():
    rng = np.random.default_rng(3)
    half = np.sort(rng.uniform(0.1, 5.0, (30, 6)), axis=1)
    y = np.concatenate([-half[:, ::-1], np.zeros((30, 1)), half], axis=1)
    assert all(through_points(row, -(row**2) / 20).symmetric for row in y)


# --- nearest ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [-0.02, 0.0, 0.03, 0.4, 5.0, 60.0])
@pytest.mark.parametrize("name", SMOOTH)
def test_nearest_is_the_foot_of_the_normal_near_a_contour_and_at_any_distance_outside(name, height):
    """Distances are 0.01 to 300 radii of curvature; normals do not meet where they diverge."""
    contour = SMOOTH[name]
    s = np.linspace(contour.limits[0] - 2.7, contour.limits[1] + 3.4, 301)
    points = contour.position(s) + (-height if name == "groove" else height) * contour.normal(s)
    result = contour.nearest(points, (s[0] - 1.0, s[-1] + 1.0))
    np.testing.assert_allclose(result, s, rtol=0, atol=1e-11)  # inversion: 1e-14 of 60 mm, both ways


@each
def test_no_point_of_the_contour_is_nearer_than_the_nearest(contour):
    """Anywhere, also inside of the evolute, where a point has several feet."""
    points = np.random.default_rng(4).uniform(-15, 15, (2, 400))
    samples = np.linspace(-40.0, 40.0, 6001)
    apart = points[:, None] - contour.position(samples)[:, :, None]
    nearest = points - contour.position(contour.nearest(points, (-40.0, 40.0)))
    assert np.all(np.hypot(*nearest) <= np.hypot(*apart).min(axis=0) + 1e-12)


def test_all_of_an_arc_is_nearest_to_its_centre():
    result = arc(10.0, 0.45, 1.1).nearest(np.array([[0.0], [-10.0]]), (-20.0, 20.0))
    assert -4.5 <= result[0] <= 11.0


def through(*y, y_centre=0.5):
    return through_points(y, np.zeros(len(y)), y_centre)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: through(0.0, 1.0, 2.5, 3.0, y_centre=9.5), r"9\.5"),
        (lambda: through(0.0, 1.0, 2.5), "3 points: at least 4"),
        (lambda: through(0.0, 1.0, np.nan, 3.0), "finite"),
        (lambda: through(0.0, 1.5, 1.25, 3.0), r"point 3: y = 1\.25 after 1\.5"),
        (lambda: through(0.0, 1.5, 2.5, 2.5), r"point 4: y = 2\.5 after 2\.5"),
        (lambda: arc(0.0, 0.3, 0.4), r"radius = 0\.0"),
        (lambda: arc(10.0, -0.3, 0.4), r"left flank inclination = -0\.3"),
        (lambda: ellipse(2.0, -1.0, 0.3, 0.4), r"d_el = -1\.0"),
        (lambda: ellipse(2.0, 1.0, 0.3, 1.6), r"right flank inclination = 1\.6"),
    ],
)
def test_impossible_contours_are_refused_with_the_value(make, message):
    with pytest.raises(WrongInput, match=message):
        make()
