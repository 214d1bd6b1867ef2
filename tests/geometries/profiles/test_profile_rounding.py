"""What the last decimals of a file do: their steps, the noise of slope and curvature, and p_max."""

import numpy as np
import pytest
import scipy
from profile_texts import block_text, columns_text

from geometries.profiles.files import read_profile
from geometries.profiles.noise import curvature_noise, noise, peak_slope, profile_figure
from geometries.profiles.preparation import ROUNDING_RMS, Prepared, prepare
from geometries.profiles.profile import Profile
from geometries.profiles.smoothing import rms, smooth
from geometries.profiles.standards import standard
from geometries.profiles.text import steps_as_written

RNG = np.random.default_rng


def rounded(points, step, kind="rail"):
    return Profile(kind, np.round(points / step) * step, steps=np.full_like(points, step))


# --- the steps -------------------------------------------------------------------------------------

VALUES = RNG(1).uniform(-70, 70, 200).cumsum()


def written(form, values=VALUES):
    return [form.format(value) for value in values]


@pytest.mark.parametrize(
    ("tokens", "steps"),
    [
        (written("{:.2f}"), 1e-2),
        (written("{:.4f}000"), 1e-4),  # filled up with zeros
        (written("{:.3f}E+00"), 1e-3),
        (written("{:.3f}D-02"), 1e-5),
        ([f"{value:g}" for value in np.round(VALUES, 2)], 1e-2),  # zeros at the end left out
        (written("{:.2f}")[:100] + written("{:.4f}")[100:], [1e-2] * 90 + [np.nan] * 20 + [1e-4] * 90),
        (["0.123456", *written("{:.2f}")], 1e-2),  # one finer number
        ([t + "137" * (k % 5 == 0) for k, t in enumerate(written("{:.2f}"))], 1e-2),  # a few finer ones
        (["7", *written("{:.2f}")], 1e-2),  # one coarser number
        (written("{:.2f}", np.repeat(VALUES, 40)), 1e-2),  # level for 40 points
        (written("{:.2f}", np.arange(200) * 0.5), 0.0),  # equal steps are chosen, not rounded
        (written("{:.2f}", np.arange(200) * 0.503), 1e-2),
    ],
)
def test_steps_are_those_of_the_last_decimals_in_use(tokens, steps):
    found = steps_as_written(tokens, np.array([float(token.replace("D", "E")) for token in tokens]))
    expected = np.broadcast_to(steps, found.shape)
    known = np.isfinite(expected)
    np.testing.assert_allclose(found[known], expected[known], rtol=1e-12)


def test_numbers_of_seven_digits_have_steps_by_their_size():
    values = np.geomspace(0.011, 99, 400) * RNG(2).choice([-1, 1], 400)
    found = steps_as_written(written("{:.6E}", values), values)
    usual = 10.0 ** (np.floor(np.log10(np.abs(values))) - 6)
    off = np.round(np.log10(found / usual))
    assert np.mean(off == 0) > 0.85  # elsewhere the size changes nearby
    assert np.max(np.abs(off)) <= 1


@pytest.mark.parametrize(("unit", "length"), [("mm", 1.0), ("inch", 25.4), ("m", 1000.0)])
def test_steps_go_along_into_millimetres(tmp_path, unit, length):
    """Thousandths of the unit, 90 mm wide."""
    points = np.stack([np.linspace(-45, 45, 181), 5 * np.cos(np.linspace(-1, 1, 181))]) / length
    path = tmp_path / "s.txt"
    path.write_text(columns_text(points + 1e-4, row="{:.5f} {:.5f}"))
    profile = read_profile(path, "rail", axes="field up", unit=unit)
    assert profile.steps.shape == profile.points.shape
    np.testing.assert_allclose(profile.steps[1], 1e-5 * length, rtol=1e-12)
    assert np.all((profile.steps[0] == 0) | np.isclose(profile.steps[0], 1e-5 * length))


def test_steps_turn_with_the_points(tmp_path):
    """y with one decimal and z with three, turned by 30 degrees: rms errors along the axes mix."""
    y, z = np.linspace(-36, 36, 97) + 0.03 * RNG(3).uniform(-1, 1, 97), np.linspace(-1, 1, 97) ** 2 * 20
    text = "".join(f"{a:.1f} {b:.3f}\n" for a, b in zip(y, z, strict=True))
    path = tmp_path / "s.prr"
    path.write_text(
        block_text(np.zeros((2, 0)), rotate=-30, units_ang_f=180 / np.pi).replace(
            "point.begin\n", f"point.begin\n{text}"
        )
    )
    steps = read_profile(path, axes="down").steps
    cos, sin = np.cos(np.pi / 6) * np.array([0.1, 0.001]), np.sin(np.pi / 6) * np.array([0.1, 0.001])
    np.testing.assert_allclose(steps[0], np.hypot(cos[0], sin[1]), rtol=1e-12)
    np.testing.assert_allclose(steps[1], np.hypot(sin[0], cos[1]), rtol=1e-12)


# --- noise of slope and curvature ------------------------------------------------------------------


def circles(radius, spacing, step, length=120.0):
    """Arcs through the crown of circles of a radius, their points rounded, at random places of the grid."""
    for seed in range(6):
        rng = RNG(seed)
        delta = (np.arange(0, length, spacing) - length / 2 + rng.uniform(0, spacing)) / radius
        centre = rng.uniform(0, 1, (2, 1))
        turn = rng.uniform(0.1, 0.6)  # not level: errors of neighbours are independent
        yield rounded(radius * np.stack([np.sin(delta + turn), np.cos(delta + turn)]) + centre, step)


@pytest.mark.parametrize(("spacing", "step"), [(0.5, 0.01), (0.2, 0.001)])
def test_noise_of_a_curve_through_rounded_points_is_as_stated(spacing, step):
    """rms errors of curvature at points, and of slope, which count as curvature over a half width."""
    slopes, curvatures, stated, over = [], [], [], []
    for profile in circles(300.0, spacing, step):
        curve = prepare(profile)
        s = np.linspace(10, curve.length - 10, 4001)
        curvatures.append(curve.curvature(s) - 1 / 300)
        slope = curve.inclination(s) - s / 300
        slopes.append(slope - np.mean(slope))
        stated.append(curvature_noise(curve, 60.0, 0.0, 0.0))
        over.append(curvature_noise(curve, 60.0, 50.0))
    # 6 x 200 points or more, whose errors are nearly independent: 2 to 4 % by chance
    assert rms(curvatures) == pytest.approx(rms(stated), rel=0.1)
    assert rms(slopes) / 50 == pytest.approx(rms(over), rel=0.1)


@pytest.mark.parametrize("length", [0.6, 1.5])
def test_noise_after_smoothing_is_as_stated(length):
    slopes, curvatures = [], []
    for profile in circles(300.0, 0.2, 0.01):
        spline, _, how = smooth(profile.points, lambda _: length, "fixed")
        t = np.linspace(*spline.x[[0, -1]], 4001)[400:-400]
        (dy, dz), (ddy, ddz) = (spline(t, order).T for order in (1, 2))
        curvatures.append((dz * ddy - dy * ddz) / np.hypot(dy, dz) ** 3 - 1 / 300)
        slope = np.arctan2(-dz, dy) - t / 300
        slopes.append(slope - np.mean(slope))
    curve = with_smoothing(prepare(profile), how)
    # 6 x 100 mm, 200 waves or more of 2 pi times the smoothing length: 10 % by chance
    assert rms(curvatures) == pytest.approx(curvature_noise(curve, 60.0, 0.0), rel=0.2)
    assert rms(slopes) / 50 == pytest.approx(curvature_noise(curve, 60.0, 50.0), rel=0.2)


def with_smoothing(curve, how):
    parts = {name: getattr(curve, name) for name in Prepared.__dataclass_fields__}
    return Prepared(**(parts | {"smoothing": how}))


def test_a_patch_feels_less_than_a_point_and_exact_curves_nothing():
    profile = next(circles(300.0, 0.5, 0.01))
    curve = prepare(profile)
    felt = [curvature_noise(curve, 60.0, half_width) for half_width in (0.0, 0.1, 1.0, 5.0)]
    assert felt == sorted(felt, reverse=True)
    assert curvature_noise(curve, 60.0, 5.0, element=2.0) == pytest.approx(felt[-1] / 4, rel=0.05)
    assert peak_slope(standard("S1002").outline, 60.0, 5.0) == 0
    assert peak_slope(prepare(Profile("rail", profile.points)), 60.0, 5.0) == 0  # not read from decimals


def test_the_peak_is_the_largest_of_as_many_values_as_points_on_the_patch():
    """95 of 100 draws of 21 normal errors have their largest below it: 0.5 % by chance among 20000."""
    curve = prepare(next(circles(300.0, 0.5, 0.01)))
    largest = np.abs(RNG(4).standard_normal((20000, 21))).max(axis=1)
    share = peak_slope(curve, 60.0, 5.0) / (5.0 * curvature_noise(curve, 60.0, 5.0))
    assert share == pytest.approx(np.quantile(largest, 0.95), rel=0.01)


def test_what_smoothing_takes_from_a_jump_of_the_curvature_is_in_the_slope():
    """A line and an arc of 13 mm without errors: the slope lost at the joint."""
    delta = np.concatenate([np.zeros(200), np.arange(0, 1.2, 0.1 / 13)])
    y = np.concatenate([np.arange(-20, 0, 0.1), 13 * np.sin(delta[200:])])
    points = np.stack([y, 13 * (np.cos(delta) - 1)])
    for length in (0.4, 0.8):
        spline, _, how = smooth(points, lambda _, length=length: length, "fixed")
        t = np.linspace(*spline.x[[0, -1]], 8001)
        dy, dz = spline(t, 1).T
        exact = np.maximum(t - 20, 0) / 13
        lost = np.max(np.abs(np.arctan2(-dz, dy) - exact)[1000:-1000])
        curve = with_smoothing(prepare(Profile("rail", points)), how)
        assert lost == pytest.approx(length / 3 / 13, rel=0.01)  # jump times length / 3
        # the spline through the points overshoots the jump by an eighth, which counts twice
        assert peak_slope(curve, 20.0, 3.0) == pytest.approx(lost, rel=0.3)
    # evenly growing curvature
    even = prepare(Profile("rail", np.stack([y, np.linspace(-4, 4, len(y)) ** 3])))
    lost = peak_slope(with_smoothing(even, how), 20.0, 1.0)
    assert lost < 0.1 * 0.8 / 3 * np.ptp(even.curvature(np.array([19.2, 20.8])))


# --- p_max -----------------------------------------------------------------------------------------


def line_contact(gap, ds, load):
    """Pressures (n,) over E* under a load per length over E*, frictionless, of a half-plane with a gap (n,).

    Constant pressure in each element, (2 / pi) int -ln|x| for its displacements (Johnson, 2.4); the elements
    in contact are sought in turns.
    """
    n = len(gap)
    ends = (np.arange(n + 1) - 0.5) * ds
    integral = ends * np.log(np.abs(ends)) - ends
    matrix = scipy.linalg.toeplitz(-2 / np.pi * np.diff(integral))
    touches = np.ones(n, dtype=bool)
    for _ in range(200):
        m = np.count_nonzero(touches)
        system = np.block(
            [[matrix[np.ix_(touches, touches)], -np.ones((m, 1))], [np.full((1, m), ds), np.zeros((1, 1))]]
        )
        *p, approach = np.linalg.solve(system, np.append(-gap[touches], load))
        pressure = np.zeros(n)
        pressure[touches] = p
        if np.any(pressure < 0):
            touches &= pressure >= 0
            continue
        inside = ~touches & (matrix @ pressure + gap - approach < -1e-13)
        if not np.any(inside):
            return pressure
        touches |= inside
    raise AssertionError("no contact found")


def p_max_error(curve, at, exact_height, half_width, side=1):
    """Error of p_max / E* and 1/2 peak_slope about an arc length; a parabola of radius 300 mm presses.

    `side` is -1 where the curve is the upper body.
    """
    ds, load = half_width / 10, np.pi * half_width**2 / 300 / 4
    y = (np.arange(50) + 0.5) * ds - 2.5 * half_width
    place = curve.position(at)[0]
    s = np.linspace(at - 4 * half_width - 1, at + 4 * half_width + 1, 4001)
    bumps = side * (np.interp(y + place, *curve.position(s)) - exact_height(y + place))
    pressed, unrounded = (line_contact(y**2 / 600 - own, ds, load) for own in (bumps, 0 * bumps))
    return abs(pressed.max() - unrounded.max()), peak_slope(curve, at, half_width, ds) / 2


def test_the_line_contact_of_these_tests_is_that_of_hertz():
    ds = 0.02
    s = (np.arange(200) + 0.5) * ds - 2
    pressure = line_contact(s**2 / 600, ds, np.pi / 300 / 4)
    assert pressure.max() == pytest.approx(1 / 600, rel=2e-3)  # b = 1: p_max / E* = b / 2R; elements b / 50


@pytest.mark.parametrize(
    ("spacing", "step", "half_width"),
    [(0.5, 0.01, 5.0), (0.5, 0.001, 1.0), (0.1, 0.001, 3.0), (1.3, 0.01, 3.0)],
)
def test_p_max_of_rounded_cones_errs_by_less_than_stated_in_95_of_100(spacing, step, half_width):
    """40 cones at random places of the grid, of inclinations that are no multiples of the steps."""
    found = []
    for seed in range(40):
        rng = RNG(seed)
        slope, offset = rng.uniform(0.045, 0.055), rng.uniform(0, 1)
        y = np.arange(-45, 45, spacing) + rng.uniform(0, spacing)
        curve = prepare(rounded(np.stack([y, slope * y + offset]), step))
        at = curve.length / 2 + rng.uniform(-5, 5)
        found.append(p_max_error(curve, at, lambda y, m=slope, c=offset: m * y + c, half_width))
    errors, stated = np.transpose(found)
    # with a share of 95 % held there are 35 or more among 40 in 98 of 100 draws; the draws are fixed
    assert np.count_nonzero(errors <= stated) >= 36
    assert np.median(stated / errors) < 5


@pytest.mark.parametrize(("spacing", "step"), [(0.2, 0.01), (0.7, 0.01), (0.5, 0.001)])
def test_p_max_after_smoothing_errs_by_less_than_stated(spacing, step):
    """The tread of S1002 smoothed by the rms error of rounding, half width 4 mm."""
    outline = standard("S1002").outline
    s = np.linspace(0, outline.length, 100001)
    exact = outline.position(s)
    tread = exact[0] > -30
    found = []
    for seed in range(6):
        places = np.arange(RNG(seed).uniform(0, spacing), outline.length, spacing)
        curve = prepare(rounded(outline.position(places), step, "wheel"), step * ROUNDING_RMS)
        for at in RNG(seed + 99).uniform(80, 115, 6):
            found.append(p_max_error(curve, at, lambda y: np.interp(y, *exact[:, tread]), 4.0, -1))
    errors, stated = np.transpose(found)
    assert np.mean(errors <= stated) >= 0.95
    assert np.median(stated / errors) < 10


# --- what is said ----------------------------------------------------------------------------------


def cone_text(decimals, spacing=0.5):
    """A cone 1:20 behind a flange, as it may stand in a file."""
    y = np.arange(-70, 60, spacing) + 0.13
    z = 0.05 * y - 27 * np.exp(-(((y + 52) / 12) ** 4))
    return columns_text(np.stack([y, z]), row=f"{{:.{decimals}f}} {{:.{decimals}f}}")


def cone(folder, decimals, tolerance=0.0):
    path = folder / "cone.txt"
    path.write_text(cone_text(decimals))
    return prepare(read_profile(path, "wheel"), tolerance)


@pytest.mark.parametrize(("decimals", "said"), [(2, True), (3, True), (5, False)])
def test_rounding_is_said_with_the_tolerance_to_take(tmp_path, decimals, said):
    raw = cone(tmp_path, decimals)
    text = noise(profile_figure(raw))
    if not said:
        assert text == ""
        return
    step = 10.0**-decimals
    assert f"written in steps of {step:g} mm, 0.5 mm apart" in text
    tolerance = float(text.split("tolerance of ")[1].split(" mm")[0])
    assert tolerance == pytest.approx(step * ROUNDING_RMS, rel=0.1)  # one digit is given
    smoothed = cone(tmp_path, decimals, tolerance)
    assert noise(profile_figure(smoothed)) == ""
    tread = np.linspace(90, 150, 601)  # straight
    assert rms(raw.curvature(tread)) > 3 * rms(smoothed.curvature(tread))


@pytest.mark.parametrize("spacing", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("step", [0.01, 0.001])
def test_the_tolerance_to_take_brings_s1002_back(spacing, step):
    """Curvature of the tread to less than half of that of a railhead, 1/300; radii of 12 mm and more stay.

    Errors of the curvature are sigma sqrt(h / (18 L^5)) at L of 0.3 to 0.9 mm: 1/1000 at most.
    """
    outline = standard("S1002").outline
    s = np.arange(0.3 * spacing, outline.length, spacing)
    profile = rounded(outline.position(s), step, "wheel")
    curve = prepare(profile, step * ROUNDING_RMS)
    at = np.linspace(1, curve.length - 1, 4001)
    places = at + 0.3 * spacing
    apart = np.min(np.abs(places[:, None] - np.array(outline.joints)), axis=1)
    far = apart > 4 * curve.smoothing.length  # jumps of the curvature are rounded
    errors = curve.curvature(at) - outline.curvature(np.minimum(places, outline.length))
    tread = curve.position(at)[0] > -20
    assert rms(errors[far & tread]) < 1 / 600
    assert rms(errors[far & ~tread]) < 0.05 / 12
    assert rms(prepare(profile).curvature(at[tread])) > 2 * rms(errors[far & tread])
    off = curve.position(at) - outline.position(np.minimum(places, outline.length))
    delta = outline.inclination(np.minimum(places, outline.length))
    assert np.max(np.abs(off[0] * np.sin(delta) + off[1] * np.cos(delta))) < 2 * step


def test_a_corner_that_keeps_a_curve_from_being_smoothed_asks_for_a_larger_tolerance(tmp_path):
    """A chamfer of 45 degrees at the end: the curve has the tolerance, and noise nearly as before."""
    points = np.stack([np.arange(-40, 40, 0.25) + 0.1, -((np.arange(-40, 40, 0.25)) ** 2) / 600])
    corner = np.concatenate([points, points[:, -1:] + [[0.3, 0.6], [-0.3, -0.6]]], axis=1)
    said = []
    for each in (points, corner):
        path = tmp_path / "s.txt"
        path.write_text(columns_text(each, row="{:.2f} {:.2f}"))
        profile = read_profile(path, "rail", axes="field up")
        said.append(noise(profile_figure(prepare(profile, 0.003))))
    assert said[0] == ""
    assert said[1].endswith("Use a tolerance of 0.009 mm.")
