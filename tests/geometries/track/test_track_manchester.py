"""Measured profiles, and the Manchester benchmark: against polygons of the points of the files."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from track_sections import brute_gaps

from geometries.profiles.files import read_profile
from geometries.profiles.preparation import prepare
from geometries.profiles.profile import Profile
from geometries.track.conicity import equivalent_conicity
from geometries.track.layout import TrackDimensions, WheelsetDimensions, lay_out
from geometries.track.wheelset import over_shifts, settle
from tests.samples import SAMPLES

ROOT = Path(__file__).parents[3]
RAIL, WHEEL = SAMPLES / "MBench_UIC60_v3.prr", SAMPLES / "MBench_S1002_v3.prw"

pytestmark = pytest.mark.skipif(
    not (RAIL.exists() and WHEEL.exists()),
    reason=f"no profiles in {SAMPLES}; set FEMIC_PROFILES to their folder",
)


def points(path):
    """The rows of the spline block, z upwards; (2, n)."""
    block = path.read_text("utf-8").split("point.begin")[1].split("point.end")[0]
    rows = [line.split("!")[0].split() for line in block.splitlines()]
    y, z = np.array([row[:2] for row in rows if row], dtype=float).T
    return np.stack([y, -z])


@cache
def manchester():
    rail = prepare(Profile("rail", points(RAIL)))
    wheel = prepare(Profile("wheel", points(WHEEL) * [[-1.0], [1.0]]))  # the file asks for mirrored y
    return lay_out(
        (rail, rail),
        (wheel, wheel),
        TrackDimensions(1435.0, 14.0, False),
        WheelsetDimensions(1360.0, 460.0, -70.0),
    )


@pytest.mark.parametrize(
    "shift",
    [-5.9, *(pytest.param(shift, marks=pytest.mark.slow) for shift in (-3.0, 0.0, 1.1, 4.7, 5.0))],
)
def test_brute_force_finds_the_same_points(shift):
    layout = manchester()
    position = settle(layout, shift)
    for side, touches in (("left", position.left), ("right", position.right)):
        t, gaps = brute_gaps(layout, position, side, n=100001)
        assert np.min(gaps) == pytest.approx(0, abs=1e-6)  # 1.5 um of polygon, slopes up to 25 degrees
        # a gap of 1e-6 mm reaches sqrt(2e-6 * 1000 mm) where wheel and rail are nearly conformal
        assert t[np.argmin(gaps)] == pytest.approx(touches[0].s_rail, abs=0.05)


def test_rail_tops_and_gauge_are_in_place():
    layout = manchester()
    y, z = layout.left.rail.position(np.linspace(*layout.left.rail.limits, 100001))
    assert np.max(z) == pytest.approx(0, abs=1e-6)
    assert np.min(y[z > -14]) == pytest.approx(717.5, abs=1e-3)


@pytest.mark.slow  # jumps are those of test_track_shifts.py
def test_flange_and_tread_of_the_benchmark():
    """Beyond 4.8 mm the root of the flange touches; up to 6.3 mm the flange does not climb."""
    jumps = over_shifts(manchester(), [4.7, 5.0]).jumps
    (jump,) = jumps
    tread, root = jump.touches
    assert tread.angle < root.angle - 0.1
    assert settle(manchester(), 6.3).left[0].angle > 1.0


@pytest.mark.slow
def test_equivalent_conicity_is_that_of_new_profiles():
    """The brute force's rolling-radius differences give it within what polygons are worth."""
    layout = manchester()
    shifts = over_shifts(layout, np.linspace(-3.05, 3.05, 62))
    value = equivalent_conicity(*shifts.rolling_radius_differences(), 3.0).value
    brute = []
    for position in shifts.positions:
        radii = []
        for side, own, sign in (("left", layout.left, 1), ("right", layout.right, -1)):
            t, gaps = brute_gaps(layout, position, side)
            y = own.rail.position(t[np.argmin(gaps)])[0] - sign * position.shift
            wheel = own.wheel.position(np.linspace(*own.wheel.limits, 30001))
            # the axle is inclined by the roll: to first order the height over it
            radii.append(-np.interp(y + sign * position.roll * -position.height, *wheel))
        brute.append(radii[0] - radii[1])
    at = [position.shift for position in shifts.positions]
    assert value == pytest.approx(equivalent_conicity(at, brute, 3.0).value, rel=0.03)


WORN = SAMPLES / "site_b_hr.prr", SAMPLES / "worn_high_mileage.prw"


@pytest.mark.skipif(not all(path.exists() for path in WORN), reason=f"no worn pair in {SAMPLES}")
def test_a_worn_flange_that_is_steepest_at_its_root_is_no_climb():
    """It touches 28 mm below the rail top on a flank of 72.8 degrees; the polygons agree."""
    rail, wheel = (prepare(read_profile(path)) for path in WORN)
    layout = lay_out(
        (rail, rail),
        (wheel, wheel),
        TrackDimensions(1435.1, 15.875, False),
        WheelsetDimensions(1347.4, 444.0, 0.0),
    )
    position = settle(layout, -15.45, roll="about rails", within=0.5)
    touch = position.right[0]
    assert np.degrees(touch.angle) == pytest.approx(72.75, abs=0.1)
    assert "12.00 mm beyond the steepest part of its flange (78.6 degrees)" in position.notes[0]
    assert "climbs" not in position.notes[0]
    assert "28.2 mm below its top" in position.notes[1]
    t, gaps = brute_gaps(layout, position, "right", n=100001)
    assert np.min(gaps) == pytest.approx(0, abs=2e-6)  # 1.5 um of polygon on a slope of 73 degrees
    assert t[np.argmin(gaps)] == pytest.approx(touch.s_rail, abs=0.05)
