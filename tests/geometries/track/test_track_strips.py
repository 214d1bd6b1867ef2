import numpy as np
import pytest
from track_sections import (
    HALF_ANGLE,
    TRACK,
    WHEELSET,
    Circles,
    brute_gaps,
    flanged,
    rail_points,
    rail_through,
    symmetric,
    wheel_points,
    wheel_through,
)

from geometries.errors import Failure, WrongInput
from geometries.track.layout import lay_out
from geometries.track.strips import distances, strips
from geometries.track.touching import wheel_graphs
from geometries.track.wheelset import curves_in_place, settle

CIRCLES = Circles()


def lens(R_r, R_w, apart):
    """Half-chord and area between two arcs of which the one of R_r rises by `apart` above that of R_w."""
    d = R_w - R_r + apart  # distance of the centres: the smaller circle is moved out by `apart`
    x = (R_w**2 - R_r**2 - d**2) / (2 * d)  # of the chord from the centre of R_r, towards the touching point
    half = np.sqrt(R_r**2 - x**2)
    inner = R_r**2 * np.arctan2(half, x) - x * half
    outer = R_w**2 * np.arctan2(half, x + d) - (x + d) * half
    return half, x, inner - outer


@pytest.mark.parametrize("approach", [1e-8, 1e-6, 0.01, 0.2])
@pytest.mark.parametrize("shift", [0.0, 3.0])
def test_two_circles_overlap_in_a_lens(approach, shift):
    """The centres of the circles, R_w - R_r apart along the common normal, come together by the approach."""
    layout = CIRCLES.layout()
    position = settle(layout, shift)
    touch = position.left[0]
    apart = (CIRCLES.R_w - CIRCLES.R_r) * np.array([-np.sin(touch.angle), np.cos(touch.angle)])
    apart += [0, approach]  # from the centre of the wheel's arc to that of the rail's
    half, x, area = lens(CIRCLES.R_r, CIRCLES.R_w, np.hypot(*apart) - (CIRCLES.R_w - CIRCLES.R_r))
    tilt, opening = np.arctan2(-apart[0], apart[1]), np.arctan2(half, x)
    (strip,) = strips(layout, position, "left", approach)
    expected = CIRCLES.R_r * (HALF_ANGLE - tilt + np.array([-opening, opening]))
    # rounding of 1e-13 mm of the heights over slopes of half / R_r
    tolerance = 1e-8 + 1e-10 / opening
    np.testing.assert_allclose(strip.s_rail, expected, rtol=0, atol=tolerance)
    # the area is a difference of segments of 1e5 mm^2 in the closed form
    assert strip.area == pytest.approx(area, rel=1e-5, abs=2e-9)
    assert strip.depth == pytest.approx(approach, rel=2e-3)
    assert strip.depth >= approach * (1 - 1e-9)
    assert len(strip.touches) == 1
    assert not strip.merged


def test_distances_of_two_circles_along_the_normals_of_the_first():
    """The wheel's arc has its centre at e from that of the rail: where the rays of the rail meet R_w."""
    layout = CIRCLES.layout()
    position = settle(layout, 2.0)
    touch = position.right[0]
    s = touch.s_rail + np.linspace(-20, 20, 41)
    e = (CIRCLES.R_w - CIRCLES.R_r) * np.array([np.sin(touch.angle), -np.cos(touch.angle)])
    n = np.array([np.sin(s / CIRCLES.R_r - HALF_ANGLE), np.cos(s / CIRCLES.R_r - HALF_ANGLE)])
    along = e @ n
    expected = along + np.sqrt(along**2 - e @ e + CIRCLES.R_w**2) - CIRCLES.R_r
    np.testing.assert_allclose(distances(layout, position, "right", s), expected, rtol=0, atol=1e-10)
    assert np.argmin(np.abs(expected)) == 20


def test_distances_are_never_negative_and_nan_beside_the_wheel():
    layout = flanged()
    position = settle(layout, 1.0)
    t = layout.left.rail_graphs[0].t
    away = distances(layout, position, "left", t)
    assert np.nanmin(away) >= -1e-9
    assert np.isnan(distances(layout, position, "left", np.array([layout.left.rail.limits[1]]))).all()
    assert distances(layout, position, "left", t[100:103].reshape(3, 1)).shape == (3, 1)


def test_distances_lead_to_points_of_the_wheel():
    layout = flanged()
    position = settle(layout, 8.6)
    rail, wheel = curves_in_place(layout, position, "left")
    touch = position.left[0]
    s = touch.s_rail + np.linspace(-2, 2, 9)
    ty, tz = rail.tangent(s)
    ends = rail.position(s) + distances(layout, position, "left", s) * np.stack([-tz, ty])
    polygon = wheel.position(touch.s_wheel + np.linspace(-6, 6, 30001))
    for end in ends.T:
        assert np.min(np.hypot(*(polygon - end[:, None]))) < 2e-4  # half of the step of the polygon


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize(
    ("shift", "approach"),
    [
        (7.5, 0.4),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in ((7.5, 0.05), (7.5, 1.5), (-8.4, 0.1))),
    ],
)
def test_strips_are_where_a_dense_search_finds_overlaps(shift, approach, side):
    layout = symmetric()
    position = settle(layout, shift)
    found = strips(layout, position, side, approach)
    t, gaps = brute_gaps(layout, position, side)
    closed = np.concatenate([[False], gaps < approach, [False]])
    edges = np.flatnonzero(np.diff(closed.astype(int))).reshape(-1, 2) - [0, 1]
    step = t[1] - t[0]
    np.testing.assert_allclose([strip.s_rail for strip in found], t[edges], rtol=0, atol=1.5 * step)
    own = layout.left if side == "left" else layout.right
    y = own.rail.position(t)[0]
    areas = [np.trapezoid((approach - gaps)[a : b + 1], y[a : b + 1]) for a, b in edges]
    np.testing.assert_allclose([strip.area for strip in found], areas, rtol=2e-3)
    for strip, (a, b) in zip(found, edges, strict=True):
        assert strip.depth == pytest.approx(np.max((approach - gaps)[a : b + 1]), abs=1e-5 + approach / 50)
        np.testing.assert_allclose(strip.y, own.rail.position(np.array(strip.s_rail))[0], rtol=0, atol=1e-9)


def test_strips_of_tread_and_flange_are_one_or_two_and_merge():
    layout = symmetric()
    position = settle(layout, 7.5, within=0.5)
    tread, flange = position.left
    one = strips(layout, position, "left", 0.9 * flange.gap)
    two = strips(layout, position, "left", 1.1 * flange.gap)
    assert [len(strip.touches) for strip in one] == [1]
    assert [len(strip.touches) for strip in two] == [1, 1]
    assert two[0].touches[0].s_rail == pytest.approx(flange.s_rail, abs=1e-9)
    assert two[1].touches[0].s_rail == pytest.approx(tread.s_rail, abs=1e-9)
    rail, _ = curves_in_place(layout, position, "left")
    between = np.linspace(flange.s_rail, tread.s_rail, 4001)
    t, gaps = brute_gaps(layout, position, "left")
    saddle = np.max(gaps[(t > between[0]) & (t < between[-1])])
    assert len(strips(layout, position, "left", 0.99 * saddle)) == 2
    (merged,) = strips(layout, position, "left", 1.01 * saddle)
    assert merged.merged
    assert len(merged.touches) == 2
    assert rail.position(merged.s_rail[0])[0] == pytest.approx(merged.y[0])


def test_of_two_surfaces_of_a_wheel_above_each_other_the_lower_one_counts():
    """A rim that folds back over the tread: its upper surface is no part of the gap."""
    y, z = wheel_points()
    fold = np.array(
        [[60, 8], [59, 14], [50, 17], [30, 18], [-10, 18], [-20, 20], [-18, 24], [20, 26], [60, 27]]
    ).T
    layouts = [
        lay_out((rail,) * 2, (wheel_through(points),) * 2, TRACK, WHEELSET)
        for rail in [rail_through(rail_points())]
        for points in (np.stack([y, z]), np.concatenate([np.stack([y, z]), fold], axis=1))
    ]
    plain, folded = (settle(layout, 2.0) for layout in layouts)
    assert len(wheel_graphs(layouts[1].left, 0.0, 0.0)) == 2
    assert folded.height == pytest.approx(plain.height, abs=1e-9)
    (one,), (other,) = (
        strips(layout, position, "left", 0.1)
        for layout, position in zip(layouts, (plain, folded), strict=True)
    )
    np.testing.assert_allclose(one.s_rail, other.s_rail, rtol=0, atol=1e-7)
    assert one.area == pytest.approx(other.area, rel=1e-8)


def test_what_cannot_be_a_strip_is_refused():
    layout = symmetric()
    position = settle(layout, 0.0)
    for approach in (0.0, -0.1, np.nan):
        with pytest.raises(WrongInput, match="approach"):
            strips(layout, position, "left", approach)
    with pytest.raises(WrongInput, match="side"):
        strips(layout, position, "middle", 0.1)
    with pytest.raises(Failure, match="reaches the end of a profile"):
        strips(layout, position, "left", 60.0)
