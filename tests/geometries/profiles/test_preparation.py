import numpy as np
import pytest
import scipy
from profile_samples import sample

from geometries import contours
from geometries.errors import Failure, WrongInput
from geometries.profiles.noise import profile_figure
from geometries.profiles.placement import arc_length_at, contour_at
from geometries.profiles.preparation import prepare, sampled
from geometries.profiles.profile import Profile
from geometries.profiles.smoothing import Fit, by_cross_validation, rms, smooth, with_rms
from geometries.profiles.standards import standard, standard_profile

UM = 1e-3  # mm


def rail(points):
    return Profile("rail", np.asarray(points, dtype=float), "test", ("read from nothing",))


def on_arc(radius, ends, spacing, noise=0.0, seed=0):
    """Points of a circular arc between two inclinations, with errors of exactly that rms along the normal."""
    delta = np.linspace(*ends, round(radius * np.ptp(ends) / spacing) + 1)
    off = np.random.default_rng(seed).standard_normal(len(delta))
    off *= noise / rms(off)
    return rail((radius + off) * np.stack([np.sin(delta), np.cos(delta)]))


def on_ellipse(spacing, noise=0.0, seed=0):
    """Points of an ellipse at equal steps of the eccentric angle, so at unequal distances; errors along z."""
    phi = np.linspace(-1.2, 1.4, round(26 / spacing) + 1)
    off = noise * np.random.default_rng(seed).standard_normal(len(phi))
    return rail([13.0 * np.sin(phi), 6.5 * np.cos(phi) + off])


ELLIPSE = contours.Ellipse(13.0, 6.5)
FIRST = float(ELLIPSE.arc_length(np.array(-1.2)))
SHAPES = {  # points at a spacing; position, inclination and curvature at arc lengths; least orders
    "arc": (
        lambda spacing: on_arc(13.0, (-0.7, 1.2), spacing),
        lambda s: 13.0 * np.stack([np.sin(s / 13.0 - 0.7), np.cos(s / 13.0 - 0.7)]),
        lambda s: s / 13.0 - 0.7,
        lambda s: np.full_like(s, 1 / 13.0),
        (3.7, 2.7, 1.7),
    ),
    "ellipse": (
        on_ellipse,
        lambda s: ELLIPSE.position(FIRST + s) + np.array([[0.0], [6.5]]),
        lambda s: ELLIPSE.inclination(FIRST + s),
        lambda s: ELLIPSE.curvature(FIRST + s),
        (3.6, 2.6, 1.6),  # radii from 3 mm on: 0.8 mm is coarse
    ),
}


def turned(points, angle, shift=(0.0, 0.0)):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]]) @ points + np.array(shift)[:, None]


# --- through the points ----------------------------------------------------------------------------

SPACINGS = [0.8, 0.4, 0.2, 0.1]


@pytest.mark.parametrize(
    ("sample_at", "position", "inclination", "curvature", "orders"), SHAPES.values(), ids=SHAPES
)
def test_curves_through_points_converge_at_the_orders_of_cubic_splines(
    sample_at, position, inclination, curvature, orders
):
    errors = []
    for spacing in SPACINGS:
        curve = prepare(sample_at(spacing))
        s = np.linspace(0, curve.length, 1999)
        pairs = (
            (curve.position(s), position(s)),
            (curve.inclination(s), inclination(s)),
            (curve.curvature(s), curvature(s)),
        )
        errors.append([np.max(np.abs(found - exact)) for found, exact in pairs])
    assert np.all(np.polyfit(np.log(SPACINGS), np.log(errors), 1)[0] > orders)


def test_curve_without_smoothing_goes_through_its_points_and_says_so():
    profile = on_arc(9.0, (-0.5, 0.8), 0.7, noise=0.05)
    curve = prepare(profile)
    np.testing.assert_allclose(curve.position(curve.places), profile.points, rtol=0, atol=1e-12)
    np.testing.assert_allclose(curve.residual, 0, atol=1e-12)
    assert curve.notes[0] == "read from nothing"
    assert "through all" in curve.notes[-1]


def test_undercut_face_where_y_falls_again_is_followed():
    """An arc of 260 degrees: y falls at both ends, and the inclination exceeds 90 degrees there."""
    curve = prepare(on_arc(5.0, (np.radians(-130), np.radians(130)), 0.1))
    s = np.linspace(0, curve.length, 997)
    delta = np.radians(-130) + s / 5.0
    np.testing.assert_allclose(curve.position(s), 5 * np.stack([np.sin(delta), np.cos(delta)]), atol=2e-6)
    np.testing.assert_allclose(curve.inclination(s), delta, rtol=0, atol=1e-4)
    assert np.min(np.diff(curve.position(s)[0])) < 0


def test_resampling_keeps_the_shape_with_an_error_of_fourth_order():
    profile = on_ellipse(0.3)
    curve, errors = prepare(profile), []
    for spacing in SPACINGS:
        again = sampled(curve, spacing)
        assert (again.kind, again.notes[: len(curve.notes)]) == ("rail", curve.notes)
        steps = np.hypot(*np.diff(again.points, axis=1))
        assert np.all(steps <= spacing)
        assert np.ptp(steps) < 0.02 * spacing**2  # chords of equal arcs, radii from 3 to 26 mm
        np.testing.assert_allclose(again.points[:, [0, -1]], profile.points[:, [0, -1]], rtol=0, atol=1e-12)
        s = np.linspace(0, curve.length, 1501)
        resampled = prepare(again)
        errors.append(
            np.max(np.abs(resampled.position(s * resampled.length / curve.length) - curve.position(s)))
        )
    assert np.polyfit(np.log(SPACINGS), np.log(errors), 1)[0] > 3.5


def test_repeated_points_are_left_out_and_counted():
    profile = on_arc(9.0, (-0.5, 0.8), 0.7)
    twice = rail(np.repeat(profile.points, [1, 3] + [1] * (profile.points.shape[1] - 2), axis=1))
    curve = prepare(twice)
    assert "2 repeated points" in curve.notes[1]
    np.testing.assert_array_equal(curve.points, profile.points)


# --- near the points -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("noise", "tolerance"), [(1 * UM, 1 * UM), (1 * UM, 5 * UM), (20 * UM, 20 * UM), (20 * UM, 30 * UM)]
)
def test_rms_distance_of_the_points_is_the_tolerance(noise, tolerance):
    curve = prepare(on_ellipse(0.2, noise), tolerance)
    assert rms(curve.residual) == pytest.approx(tolerance, rel=1e-4)
    feet = curve.position(curve.places)
    delta = curve.inclination(curve.places)
    along = (curve.points - feet)[0] * np.cos(delta) - (curve.points - feet)[1] * np.sin(delta)
    assert np.max(np.abs(along[1:-1])) < 0.1 * UM  # at their feet; the ends may lie beyond the curve


def test_curve_minimises_the_sum_of_squares_that_it_is_said_to_minimise():
    """By a dense least-squares problem whose rows are points and third differences."""
    profile = on_arc(13.0, (-0.3, 0.5), 0.4, noise=0.01)
    t = 13.0 * np.linspace(0, 0.8, profile.points.shape[1])
    fit, length = Fit.prepare(profile.points, t, 15), 1.3
    weight = length**6 / (t[-1] / len(t))
    h = t[-1] / 15
    rows = [fit.values.toarray(), np.sqrt(weight / h**5) * np.diff(np.eye(20), 3, axis=0)]
    right = np.concatenate([profile.points.T, np.zeros((17, 2))])
    coefficients = np.linalg.lstsq(np.concatenate(rows), right, rcond=None)[0]
    at = np.linspace(0, t[-1], 50)
    expected = scipy.interpolate.BSpline(fit.knots, coefficients, 5)(at)
    np.testing.assert_allclose(fit.curve(length)(at), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("length", [0.2, 1.0, 4.0])
def test_freedom_is_the_trace_of_the_map_from_points_to_the_curve(length):
    t = np.sort(np.random.default_rng(2).uniform(0, 12, 45))
    t[0], t[-1] = 0.0, 12.0
    unit = np.eye(45)
    trace = 0.0
    for k in range(45):
        fit = Fit.prepare(np.stack([unit[k], unit[k]]), t, 30)
        trace += fit.curve(length)(t[k])[0]
    assert fit.freedom(length) == pytest.approx(trace, rel=1e-9)


def test_arcs_stay_arcs_up_to_their_ends_however_much_is_smoothed():
    """Even where rms distances of 20 um are allowed and the points are exact."""
    curve = prepare(on_arc(13.0, (-1.0, 1.2), 0.2), 20 * UM)
    s = np.linspace(0, curve.length, 500)
    np.testing.assert_allclose(curve.curvature(s) * 13.0, 1, rtol=0, atol=1e-4)
    assert rms(curve.residual) < 0.01 * UM
    assert curve.smoothing.freedom < 4  # a place (two numbers) and a turn


def test_noise_of_the_points_becomes_noise_of_the_curvature_as_stated():
    """sigma sqrt(h / (18 length^5)), here over 8 arcs of 120 mm with radius 300 mm: some 240 waves."""
    sigma, errors = 5 * UM, []
    for seed in range(8):
        points = on_arc(300.0, (-0.2, 0.2), 0.4, sigma, seed).points
        curve, _, smoothing = smooth(points, lambda _: 2.0, "fixed")
        t = np.linspace(*curve.x[[0, -1]], 1000)[100:-100]
        (dy, dz), (ddy, ddz) = (curve(t, order).T for order in (1, 2))
        errors.append((dz * ddy - dy * ddz) / np.hypot(dy, dz) ** 3 - 1 / 300)
    assert rms(errors) == pytest.approx(smoothing.curvature_noise(sigma), rel=0.15)


def test_noise_of_an_arc_changes_its_curvature_after_smoothing_by_less_than_one_tenth_percent_per_um():
    """Radius 13 mm, 31 mm long, points 0.2 mm apart, tolerance = noise. Unsmoothed: 1000 times as much."""
    smoothed, raw, noise = [], [], 20 * UM
    for seed in range(5):
        profile = on_arc(13.0, (-1.2, 1.2), 0.2, noise, seed)
        for errors, curve in ((smoothed, prepare(profile, noise)), (raw, prepare(profile))):
            errors.append(13.0 * curve.curvature(np.linspace(0, curve.length, 800)) - 1)
    assert np.max(np.abs(smoothed)) < 1e-3 * noise / UM
    assert rms(raw) > 1000 * rms(smoothed)


def test_cross_validation_finds_nearly_the_best_smoothing_and_the_noise():
    exact = standard("60E1").outline
    rng = np.random.default_rng(5)
    s = np.arange(30.0, 95.0, 0.2)
    delta = exact.inclination(s)
    points = exact.position(s) + 10 * UM * rng.standard_normal(len(s)) * np.stack(
        [np.sin(delta), np.cos(delta)]
    )
    t = s - s[0]
    fit = Fit.prepare(points, t, 320)

    def error(length):
        off = fit.curve(length)(t).T - exact.position(s)
        return rms(off[0] * np.sin(delta) + off[1] * np.cos(delta))

    lengths = np.geomspace(*fit.lengths, 60)
    chosen = by_cross_validation(fit)
    assert error(chosen) < 1.2 * min(error(length) for length in lengths)
    n = len(t)
    estimated = rms(fit.distances(chosen)) / np.sqrt(1 - fit.freedom(chosen) / n)
    assert estimated == pytest.approx(10 * UM, rel=0.15)  # of 325 points


def test_a_tolerance_that_no_smooth_curve_reaches_is_refused_with_the_nearest():
    profile = on_arc(13.0, (-1.0, 1.0), 0.2, noise=0.05)
    fit = Fit.prepare(profile.points, 13.0 * np.linspace(0, 2, profile.points.shape[1]), 10)
    with pytest.raises(
        Failure, match=r"tolerance = 1e-05 mm: the nearest smooth curve has an rms distance of 0\.0"
    ):
        with_rms(1e-5)(fit)


@pytest.mark.parametrize("tolerance", [0.0, 1 * UM, pytest.param("cross-validation", marks=pytest.mark.slow)])
def test_line_stays_a_line(tolerance):
    y = np.linspace(-20, 20, 101)
    curve = prepare(rail([y, 0.3 * y]), tolerance)
    assert curve.length == pytest.approx(40 * np.hypot(1, 0.3), rel=1e-9)
    np.testing.assert_allclose(
        curve.inclination(np.linspace(0, curve.length, 50)), -np.arctan(0.3), atol=1e-12
    )


def test_a_right_angle_smoothed_by_1_mm_is_refused_for_its_loops_and_by_20_um_is_rounded():
    y, z = np.linspace(-20, 20, 101), -0.3 * np.arange(1, 40)
    corner = rail([np.append(y, np.full(39, 20.0)), np.append(np.zeros(101), z)])
    with pytest.raises(Failure, match="it has loops; give a smaller tolerance"):
        prepare(corner, 1.0)
    curve = prepare(corner, 20 * UM)
    assert curve.length < 40 + 0.3 * 39


@pytest.mark.parametrize("spacing", [0.03, 0.2])
def test_points_closer_than_their_errors_are_smoothed_too(spacing):
    """Their order along the curve is not that of the file then."""
    rng = np.random.default_rng(3)
    exact = on_arc(13.0, (-1.0, 1.0), spacing).points
    curve = prepare(rail(exact + 20 * UM * rng.standard_normal(exact.shape)), 22 * UM)
    s = np.linspace(0, curve.length, 300)
    np.testing.assert_allclose(np.hypot(*curve.position(s)), 13.0, rtol=0, atol=20 * UM)
    np.testing.assert_allclose(13.0 * curve.curvature(s), 1, rtol=0, atol=0.05)


# --- symmetries ------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [0.0, 5 * UM, "cross-validation"])
def test_preparation_commutes_with_motions_and_mirror_images(tolerance):
    points = on_arc(13.0, (-0.4, 1.1), 0.25, noise=5 * UM).points
    curve = prepare(rail(points), tolerance)
    s = np.linspace(0, curve.length, 301)
    moved = prepare(rail(turned(points, 0.3, (40.0, -7.0))), tolerance)
    mirrored = prepare(rail(points[:, ::-1] * [[-1], [1]]), tolerance)
    # rounding of 50 mm, and the smoothing length, found to 1e-6 (0.01 by cross-validation)
    close = {"rtol": 0, "atol": 1e-8 if tolerance != "cross-validation" else 2e-7}
    assert moved.length == pytest.approx(curve.length, abs=1e-7)
    expected = turned(curve.position(s), 0.3, (40.0, -7.0))
    np.testing.assert_allclose(moved.position(np.minimum(s, moved.length)), expected, **close)
    s_mirrored = np.clip(mirrored.length - s, 0, mirrored.length)
    np.testing.assert_allclose(mirrored.position(s_mirrored) * [[-1], [1]], curve.position(s), **close)
    np.testing.assert_allclose(mirrored.curvature(s_mirrored), curve.curvature(s), rtol=0, atol=1e-6)


# --- contours --------------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [0.0, 0.01 * UM])
def test_contour_of_a_sampled_arc_is_the_arc(tolerance):
    curve = prepare(on_arc(10.0, (-0.6, 1.2), 0.1), tolerance)
    contour = contour_at(curve, arc_length_at(curve, 0.0))
    exact = contours.arc(10.0, 0.6, 1.2)
    s = np.linspace(-20, 30, 501)  # far beyond both ends too
    np.testing.assert_allclose(contour.position(0.0), 0, atol=1e-12)
    np.testing.assert_allclose(contour.inclination(s), exact.inclination(s), rtol=0, atol=1e-4)
    np.testing.assert_allclose(contour.position(s), exact.position(s), rtol=0, atol=3e-3)  # 20 mm * 1e-4
    np.testing.assert_allclose(contour.limits, exact.limits, rtol=0, atol=1e-4)
    assert contour.extent == contour.limits


def test_turned_contour_is_the_rigidly_turned_one_and_begins_flat():
    curve = prepare(standard_profile("60E1", 0.2))
    centre = arc_length_at(curve, 31.0)  # in the gauge corner of the field side
    turn = float(curve.inclination(centre))
    contour = contour_at(curve, centre, turn=turn)
    assert contour.inclination(0.0) == pytest.approx(0, abs=1e-12)
    s = np.linspace(*contour.limits, 400)
    expected = turned(curve.position(centre + s) - curve.position(centre)[:, None], turn)
    np.testing.assert_allclose(contour.position(s), expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(contour.curvature(s), curve.curvature(centre + s), rtol=0, atol=1e-11)
    h = 1e-4
    inner = s[10:-10]
    derivative = (contour.position(inner + h) - contour.position(inner - h)) / (2 * h)
    np.testing.assert_allclose(derivative, contour.tangent(inner), rtol=0, atol=1e-7)  # h^2 / 6 * jumps


def test_contour_ends_where_the_curve_is_steeper_than_85_degrees():
    curve = prepare(on_arc(5.0, (np.radians(-130), np.radians(120)), 0.05))
    contour = contour_at(curve, curve.length * 130 / 250)
    np.testing.assert_allclose(
        np.degrees(contour.inclination(np.array(contour.limits))), [-85, 85], atol=1e-3
    )
    np.testing.assert_allclose(contour.limits, 5.0 * np.radians([-85, 85]), rtol=0, atol=1e-4)
    flatter = contour_at(curve, curve.length * 130 / 250, steepest=np.radians(40))
    np.testing.assert_allclose(flatter.limits, 5.0 * np.radians([-40, 40]), rtol=0, atol=1e-4)


def test_contour_through_points_and_contour_at_agree_where_y_grows():
    profile = on_arc(13.0, (-0.7, 1.2), 0.3, noise=0.01)
    curve = prepare(profile)
    contour = contour_at(curve, arc_length_at(curve, 1.0))
    direct = contours.through_points(*profile.points, y_centre=1.0)
    s = np.linspace(*direct.limits, 300)
    np.testing.assert_allclose(contour.position(s), direct.position(s), rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda curve: arc_length_at(curve, 4.5), r"y = 4\.5 mm: .*arc lengths of its points: \d"),
        (lambda curve: arc_length_at(curve, 7.0), "none"),
        (lambda curve: contour_at(curve, 5.0 * np.radians(250)), "inclination there is 120"),
        (lambda curve: contour_at(curve, 30.0), r"centre = 30 mm: must lie between 0 and"),
        (lambda curve: curve.position(30.0), r"s = 30 mm: must lie in 0 \.\.\. 22"),
    ],
)
def test_places_and_centres_that_are_not_unique_or_not_there_are_refused(ask, message):
    with pytest.raises(WrongInput, match=message):
        ask(prepare(on_arc(5.0, (np.radians(-130), np.radians(130)), 0.1)))


@pytest.mark.parametrize(
    ("name", "y"),
    [pytest.param("site_b_hr.prr", 0.0, marks=pytest.mark.slow), ("worn_high_mileage.prw", 60.0)],
)
def test_measured_profiles_become_contours_near_their_points(name, y):
    """A rail with an undercut face, and a wheel."""
    points = sample(name)[:, :: 1 if name.endswith("prr") else -1]
    curve = prepare(Profile("rail", points), 20 * UM)
    assert rms(curve.residual) == pytest.approx(20 * UM, rel=1e-3)  # ends that lie beyond the curve
    s = np.linspace(0, curve.length, 200_001)  # 1 um apart
    off = scipy.spatial.cKDTree(curve.position(s).T).query(points.T)[0]
    np.testing.assert_allclose(off[1:-1], np.abs(curve.residual)[1:-1], rtol=0, atol=1 * UM)
    places = s[np.abs(curve.position(s)[0] - y) < 0.01]
    top = places[np.argmax(curve.position(places)[1])]
    contour = contour_at(curve, float(top))
    assert contour.limits[0] < -20
    assert contour.limits[1] > 20


# --- figures ---------------------------------------------------------------------------------------


def test_figure_has_all_of_the_profile_and_its_parts_agree():
    curve = prepare(on_arc(13.0, (-1.0, 1.1), 0.2, noise=5 * UM), 5 * UM)
    figure = profile_figure(curve, spacing=0.25)
    assert np.max(np.diff(figure.s)) <= 0.25
    delta = curve.inclination(figure.places)
    rebuilt = curve.position(figure.places) + figure.residual * np.stack([np.sin(delta), np.cos(delta)])
    np.testing.assert_allclose(rebuilt, figure.points, rtol=0, atol=0.03)  # ends beyond the curve
    np.testing.assert_allclose(rebuilt[:, 1:-1], figure.points[:, 1:-1], rtol=0, atol=0.1 * UM)
    np.testing.assert_allclose(
        np.gradient(figure.inclination, figure.s)[2:-2], figure.curvature[2:-2], atol=2e-3
    )
    np.testing.assert_array_equal(figure.curve, curve.position(figure.s))
    assert 0 < figure.curvature_noise < 0.1 / 13
    assert "5 µm" in figure.notes[-1]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: prepare(rail([[0, 1, 2], [0, 0, 0]])), "3 points: at least 8 different"),
        (lambda: prepare(rail(np.full((2, 20), 3.0))), "1 points: at least 8 different"),
        (lambda: prepare(rail([[0.0, np.nan] * 8, [0.0] * 16])), "must be finite"),
        (lambda: prepare(on_arc(9, (0, 1), 0.1), -1.0), r"tolerance = -1\.0"),
        (lambda: prepare(on_arc(9, (0, 1), 0.1), "gcv"), "tolerance = 'gcv'.*cross-validation"),
        (lambda: sampled(prepare(on_arc(9, (0, 1), 0.1)), np.nan), "spacing = nan"),
    ],
)
def test_input_without_a_curve_is_refused_with_the_value(make, message):
    with pytest.raises(WrongInput, match=message):
        make()
