"""What the sampling and the errors of a profile's points do to C, after preparation."""

from functools import cache

import numpy as np
import pytest

import femic
from geometries.profiles.preparation import prepare, sampled
from geometries.profiles.profile import Profile
from geometries.profiles.smoothing import rms

STEEL = femic.Material(E=210e3, nu=0.28)
RADIUS, FLANK = 13.0, 60.0  # mm, degrees
UM = 1e-3  # mm


def ics_of(contour):
    """C_nn and C_sn of a body under a load on a 60-degree arc, on a line along s, by direction."""
    ics = femic.compute_ics(
        femic.Pair(femic.Body(femic.plane(), STEEL), femic.Body(contour, STEEL), reference_length=4.0),
        femic.Patch(a=0.5, b=0.5, s=3.0),
        [femic.line_along_s(x=1.6, reach=10.0, points=81)],
        ["C"],
        bodies=["lower"],
        components=["nn", "sn"],
        options=femic.Options(tolerance=0.05),
    )
    return ics.ic.sel(variant="C", body="lower", j="n")


@cache
def exact():
    return ics_of(femic.arc(RADIUS, FLANK))


def points_on_arc(spacing, noise=0.0):
    """Points at that spacing, with errors of that rms along the normal."""
    end = np.radians(FLANK)
    delta = np.linspace(-end, end, 2 * round(RADIUS * end / spacing) + 1)
    off = np.random.default_rng(0).standard_normal(len(delta))
    off *= noise / rms(off)
    crown = np.array([[0.0], [RADIUS]])
    return Profile("rail", (RADIUS + off) * np.stack([np.sin(delta), np.cos(delta)]) - crown)


def changes(prepared):
    """Largest changes of C_nn and C_sn from those of the exact arc, as shares of their largest values."""
    ics = ics_of(femic.through_points(*sampled(prepared, 0.25).points))
    differences = abs(ics - exact()).max("point") / abs(exact()).max("point")
    return differences.sel(i=["n", "s"]).values


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
def test_noise_of_one_um_changes_c_a_hundred_times_as_much_without_smoothing():
    points = points_on_arc(0.2, 1 * UM)
    assert np.all(changes(prepare(points)) > 100 * changes(prepare(points, 1 * UM)))
