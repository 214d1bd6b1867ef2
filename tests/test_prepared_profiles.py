"""What the sampling and the errors of a profile's points do to C, after preparation."""

from functools import cache

import numpy as np
import pytest

import femic
from geometries.contours import arc
from geometries.profiles.preparation import prepare, sampled
from geometries.profiles.profile import Profile
from geometries.profiles.smoothing import rms
from geometries.profiles.standards import standard

STEEL = femic.Material(E=210e3, nu=0.28)
RADIUS, FLANK = 13.0, 60.0  # mm, degrees
UM = 1e-3  # mm


def ics_of(contour, patch_s=3.0, reference_length=4.0, reach=10.0):
    """C_nn and C_sn of a body under a load on its contour, on a line along s, by direction."""
    ics = femic.compute_ics(
        femic.Pair(femic.Body(femic.plane(), STEEL), femic.Body(contour, STEEL), {}, False, reference_length),
        femic.Patch(a=0.5, b=0.5, s=patch_s),
        [femic.line_along_s(x=1.6, reach=reach, points=81)],
        ["C"],
        bodies=["lower"],
        components=["nn", "sn"],
        options=femic.Options(tolerance=0.05),
    )
    return ics.ic.sel(variant="C", body="lower", j="n")


def points_along(outline, s, noise):
    """Points of an outline at arc lengths, with errors of that rms along the normal."""
    delta = outline.inclination(s)
    normal = np.stack([np.sin(delta), np.cos(delta)])
    off = np.random.default_rng(0).standard_normal(len(s))
    return Profile("rail", outline.position(s) + noise / rms(off) * off * normal)


def points_on_arc(spacing, noise=0.0):
    """Points at that spacing, with errors of that rms."""
    end = RADIUS * np.radians(FLANK)
    return points_along(arc(RADIUS, 1.5, 1.5), np.linspace(-end, end, 2 * round(end / spacing) + 1), noise)


def points_on_60e1(spacing, noise=0.0):
    """Points of a rail head 60E1 up to 70 degrees, with errors of that rms."""
    outline = standard("60E1").outline
    ends = outline.joints[[1, -2]] + [4, -4]
    return points_along(outline, np.linspace(*ends, round(np.ptp(ends) / spacing) + 1), noise)


def ics_at_gauge_corner(prepared, spacing=0.2):
    """C_nn and C_sn of a rail head under a load where the radius changes from 80 to 13 mm."""
    contour = femic.through_points(*sampled(prepared, spacing).points, y_centre=24.0)
    return ics_of(contour, patch_s=2.0, reference_length=2.5, reach=6.0)


@cache
def exact():
    return ics_of(femic.arc(RADIUS, FLANK))


@cache
def exact_at_gauge_corner():
    return ics_at_gauge_corner(prepare(points_on_60e1(0.02)), 0.05)


def changes(prepared):
    """Largest changes of C_nn and C_sn from those of the exact arc, as shares of their largest values."""
    ics = ics_of(femic.through_points(*sampled(prepared, 0.25).points))
    differences = abs(ics - exact()).max("point") / abs(exact()).max("point")
    return differences.sel(i=["n", "s"]).values


def changes_at_gauge_corner(prepared):
    """Largest changes of C_nn and C_sn from those of the exact head, as shares of the largest C_nn."""
    largest = abs(exact_at_gauge_corner().sel(i="n")).max("point")
    differences = abs(ics_at_gauge_corner(prepared) - exact_at_gauge_corner()).max("point")
    return (differences / largest).sel(i=["n", "s"]).values


@pytest.mark.slow  # 20 s a case
def test_c_of_a_sampled_arc_converges_to_that_of_the_arc_with_the_curvature_or_faster():
    """Errors of 1e-4 (nn) and 2e-3 (sn) at a spacing of a quarter of the radius."""
    spacings = [3.4, 1.7, 0.85]
    errors = np.array([changes(prepare(points_on_arc(spacing))) for spacing in spacings])
    orders = np.polyfit(np.log(spacings), np.log(errors), 1)[0]
    assert np.all(orders > 1.8)  # curvature: 2
    assert np.all(errors[0] < [5e-4, 5e-3])


@pytest.mark.slow  # 20 s a case
@pytest.mark.parametrize("noise", [1 * UM, 5 * UM, 20 * UM])
def test_noise_changes_c_after_smoothing_by_less_than_a_ten_thousandth_per_um(noise):
    """C_nn by less than 2e-5 a um, C_sn by less than 1e-4 a um: points 0.2 mm apart, tolerance = noise."""
    assert np.all(changes(prepare(points_on_arc(0.2, noise), noise)) < np.array([2e-5, 1e-4]) * noise / UM)


@pytest.mark.slow  # 20 s
def test_without_smoothing_noise_costs_a_hundred_times_as_much_and_three_times_where_the_radius_jumps():
    """Of 1 um on an arc, and of 5 um on a head."""
    points = points_on_arc(0.2, 1 * UM)
    assert np.all(changes(prepare(points)) > 100 * changes(prepare(points, 1 * UM)))
    points = points_on_60e1(0.2, 5 * UM)
    rough, smooth = (changes_at_gauge_corner(prepare(points, *tolerance)) for tolerance in ((), (5 * UM,)))
    assert np.all(rough > 3 * smooth)


@pytest.mark.slow  # 10 s a case
@pytest.mark.parametrize(
    ("noise", "nn", "sn"), [(1 * UM, 1e-3, 0.012), (5 * UM, 3e-3, 0.016), (20 * UM, 5e-3, 0.024)]
)
def test_where_the_radius_jumps_from_80_to_13_mm_smoothing_costs_more(noise, nn, sn):
    """Waves of 3 to 8 mm are smoothed away, and the jump with them. C_sn itself is 0.11 of C_nn there."""
    assert np.all(changes_at_gauge_corner(prepare(points_on_60e1(0.2, noise), noise)) < [nn, sn])
