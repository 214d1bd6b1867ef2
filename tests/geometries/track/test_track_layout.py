from itertools import product

import numpy as np
import pytest
from track_sections import (
    BACKS,
    DEPTH,
    GAUGE,
    TRACK,
    WHEELSET,
    flanged,
    rail_points,
    rail_through,
    wheel_points,
    wheel_through,
)

from geometries.errors import WrongInput
from geometries.profiles.preparation import prepare
from geometries.profiles.profile import Profile
from geometries.track.layout import TrackDimensions, WheelsetDimensions, lay_out, place_rail

RAIL = rail_through(rail_points(tilt=0.03))
WHEEL = prepare(Profile("wheel", wheel_points(), "tyre"))


DEPTHS, INCLINATIONS = (5.0, 14.0, 19.0, 21.5), (False, 0.0, 1 / 40, 1 / 20)  # undercut below 20 mm
NOT_SLOW = {(5.0, 1 / 20), (21.5, False)}


@pytest.mark.parametrize(
    ("depth", "inclination"),
    [
        pytest.param(*case, marks=[] if case in NOT_SLOW else pytest.mark.slow)
        for case in product(DEPTHS, INCLINATIONS)
    ],
)
def test_the_gauge_is_the_least_y_down_to_its_depth(depth, inclination):
    rail = place_rail(rail_through(rail_points()), TrackDimensions(GAUGE, depth, inclination))
    t = np.linspace(*rail.limits, 200001)
    y, z = rail.position(t)
    # 0.5 um of arc length: at 5 mm of depth y changes less than the arc length does
    assert np.max(z) == pytest.approx(0, abs=1e-9)
    gauge_side = (z >= -depth) & (t < t[np.argmax(z)])
    assert np.min(y[gauge_side]) == pytest.approx(GAUGE / 2, abs=1e-3 if depth < 19 else 1e-4)
    assert np.min(y[gauge_side]) >= GAUGE / 2 - 1e-9


def test_an_inclined_rail_leans_to_the_middle_of_the_track():
    upright = place_rail(rail_through(rail_points()), TrackDimensions(GAUGE, DEPTH, 0.0))
    inclined = place_rail(rail_through(rail_points()), TrackDimensions(GAUGE, DEPTH, 1 / 20))
    # the top of an ellipse of semi-axes a, c under a slope p: x = a^2 p / sqrt(a^2 p^2 + c^2) to the field
    x = 36**2 / 20 / np.hypot(36 / 20, 20)
    t = np.linspace(*upright.limits, 20001)
    assert inclined.angle == pytest.approx(np.arctan(1 / 20))
    top = t[np.argmax(inclined.position(t)[1])]
    assert inclined.curve.position(top)[0] == pytest.approx(x, abs=0.01)


@pytest.mark.parametrize("radii", [460.0, (461.5, 458.0)])
def test_tape_circle_and_flange_backs_have_their_places(radii):
    layout = lay_out((RAIL, RAIL), (WHEEL, WHEEL), TRACK, WheelsetDimensions(BACKS, radii, (-70.0, -71.0)))
    for side, radius, back in zip(
        (layout.left, layout.right), np.broadcast_to(radii, 2), (-70, -71), strict=True
    ):
        t = side.wheel_samples.t
        y, _ = side.wheel.curve.position(t)
        axle_y, axle_z = side.wheel.position(t)
        np.testing.assert_allclose(axle_y - y, BACKS / 2 - back, rtol=0, atol=1e-12)
        assert np.interp(BACKS / 2 + 70, axle_y, axle_z) == pytest.approx(-radius, abs=1e-6)
    assert layout.nominal_radius == tuple(np.broadcast_to(radii, 2))


def test_a_steep_end_is_the_flange_back_and_noted():
    face = np.stack([np.full(60, -69.0), wheel_points()[1, 0] + np.linspace(40, 0.6, 60)])
    points = np.concatenate([face, wheel_points()], axis=1)
    given = WheelsetDimensions(BACKS, 460.0, -69.0)
    found = lay_out((RAIL, RAIL), (wheel_through(points),) * 2, TRACK, WheelsetDimensions(BACKS, 460.0))
    same = lay_out((RAIL, RAIL), (wheel_through(points),) * 2, TRACK, given)
    assert len(found.notes) == 2
    assert "left: the flange back is the least y" in found.notes[0]
    assert same.notes == ()
    # a spline overshoots at the edge of the face by hundredths of a millimetre
    assert found.left.wheel.offset[0] == pytest.approx(same.left.wheel.offset[0], abs=0.2)


def test_the_field_face_of_a_wheel_is_not_its_flange():
    """A rim that rises at the field side steeper than the flange."""
    y, z = wheel_points()
    rim = np.stack([y, z + 30 * np.maximum(y - 54, 0) ** 2])
    plain = lay_out((RAIL, RAIL), (WHEEL, WHEEL), TRACK, WHEELSET)
    layout = lay_out((RAIL, RAIL), (wheel_through(rim),) * 2, TRACK, WHEELSET)
    assert layout.left.steepest == pytest.approx(plain.left.steepest, abs=0.05)


def test_the_steepest_part_of_the_flange_is_that_of_the_formula():
    """The slope 18 / (11 cosh^2 u) of the flange and 0.05 of the tread; the tip side is 1e-3 rad less."""
    side = flanged().left
    y = float(side.wheel.curve.position(side.steepest)[0])
    assert -46 < y < -44
    slope = 18 / 11 / np.cosh((y + 44) / 11) ** 2 + 0.05 + 2e-4 * y
    fine = np.linspace(-46, -42, 4001)
    largest = np.max(18 / 11 / np.cosh((fine + 44) / 11) ** 2 + 0.05 + 2e-4 * fine)
    assert np.arctan(largest) - np.arctan(slope) == pytest.approx(1e-3, abs=1e-4)


DIMENSIONS = {"gauge": GAUGE, "gauge_depth": DEPTH, "rail_inclination": False}
AXLE = {"flange_back_distance": BACKS, "nominal_radius": 460.0}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: lay_out((RAIL, WHEEL), (WHEEL, WHEEL), TRACK, WHEELSET),
            "tyre: is a wheel, but a rail is needed",
        ),
        (
            lambda: lay_out((RAIL, RAIL), (WHEEL, WHEEL), TrackDimensions(GAUGE, 40.0, False), WHEELSET),
            "gauge_depth = 40 mm, but the rail profile ends",
        ),
        (
            lambda: lay_out((RAIL, RAIL), (WHEEL, WHEEL), TRACK, WheelsetDimensions(BACKS, 460.0, 60.0)),
            "tape circle at y = 130 mm",
        ),
        (
            lambda: lay_out((RAIL, RAIL), (WHEEL, WHEEL), TRACK, WheelsetDimensions(BACKS, 460.0)),
            r"wheel\.flange_back is not given, .* y = -69 mm .*\. Give the y of the flange back",
        ),
        (lambda: TrackDimensions(**DIMENSIONS | {"gauge": -1.0}), "gauge"),
        (lambda: TrackDimensions(**DIMENSIONS | {"gauge_depth": 0.0}), "gauge_depth"),
        (lambda: TrackDimensions(**DIMENSIONS | {"rail_inclination": True}), "rail_inclination"),
        (lambda: TrackDimensions(**DIMENSIONS | {"rail_inclination": 40}), "rail_inclination"),
        (lambda: WheelsetDimensions(**AXLE | {"flange_back_distance": np.nan}), "flange_back_distance"),
        (lambda: WheelsetDimensions(**AXLE | {"nominal_radius": (460.0, 0.0)}), "nominal_radius"),
        (lambda: WheelsetDimensions(**AXLE | {"tape_circle": -70.0}), "tape_circle"),
    ],
)
def test_wrong_sections_and_dimensions_are_refused(make, message):
    with pytest.raises(WrongInput, match=message):
        make()
