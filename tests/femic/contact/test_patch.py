"""Patches: edges whose gaps are known beyond them, boxes of elements, and forces and moments."""

import numpy as np
import pytest

from femic.contact import patch as patch_module
from femic.contact.patch import (
    ACCURACY,
    ALONE,
    BESIDE,
    ENDS,
    MARGIN,
    ROOM,
    STEP,
    Box,
    centre_of_pressure,
    extents,
    near_ends,
    resultant,
    section_at,
)
from geometries.contours import arc, ellipse

# ---- edges


def flat_ended(low, high, n, power=1.5):
    """Contact on elements from `low` to `high`, in elements of a line; gaps grow as distance^power."""
    at = np.arange(n)
    beyond = np.maximum(np.maximum(low - at, at - high), 0.0)
    return beyond == 0, 0.03 * beyond**power


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e6])
@pytest.mark.parametrize("low", [5.0, 5.1, 5.5, 5.999])
@pytest.mark.parametrize("high", [11.0, 11.3, 11.9])
def test_edges_are_exact_where_gaps_of_any_size_grow_as_distance_to_three_halves(low, high, scale):
    """A rectangle: on the lines beside its corners nothing else touches."""
    contact_x, gap_x = flat_ended(low, high, 17)
    contact_s, gap_s = flat_ended(3.4, 20.25, 26)
    (extent,) = extents(np.outer(contact_x, contact_s), scale * (gap_x[:, None] + gap_s))
    assert extent.x == pytest.approx((low, high), abs=1e-12)
    assert extent.s == pytest.approx((3.4, 20.25), abs=1e-12)
    np.testing.assert_array_equal(extent.elements, np.outer(contact_x, contact_s))


def test_a_patch_is_as_long_as_its_longest_lines():
    """A rhombus, whose lines have different ends."""
    i, j = np.arange(21)[:, None], np.arange(31)
    distance = np.abs(i - 10.2) / 5.6 + np.abs(j - 14.7) / 8.3 - 1
    (extent,) = extents(distance < 0, np.maximum(distance, 0) ** 1.5)
    through = [np.min(np.abs(np.arange(n) - c)) for n, c in ((21, 10.2), (31, 14.7))]  # beside the tips
    half_x, half_s = 5.6 * (1 - through[1] / 8.3), 8.3 * (1 - through[0] / 5.6)
    assert extent.x == pytest.approx((10.2 - half_x, 10.2 + half_x), abs=1e-9)
    assert extent.s == pytest.approx((14.7 - half_s, 14.7 + half_s), abs=1e-9)


def separate(*ranges, n_x=15, n_s=60):
    """Patches side by side along s, each (low, high) there, 4.2 ... 9.6 along x."""
    contact_x, gap_x = flat_ended(4.2, 9.6, n_x)
    lines = [flat_ended(low, high, n_s) for low, high in ranges]
    contact_s = np.any([contact for contact, _ in lines], axis=0)
    gap_s = np.min([gap for _, gap in lines], axis=0)
    return np.outer(contact_x, contact_s), gap_x[:, None] + gap_s


def test_gaps_that_grow_by_rounding_only_do_not_tell_an_edge():
    contact, gap = np.zeros((9, 20), dtype=bool), np.full((9, 20), 3.0)
    contact[3:6, 8:12] = True
    gap[:, 14:] = np.nextafter(3.0, 4.0)
    (extent,) = extents(contact, np.where(contact, 0.0, gap))
    assert extent.s == (7.5, 11.5)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 6])
def test_a_patch_is_at_least_half_as_long_as_its_elements(n):
    """Where gaps grow as if the contact had ended before them, readings from both sides pass each other."""
    along_x, along_s = np.isin(np.arange(20), np.arange(7, 7 + n)), np.isin(np.arange(24), np.arange(5, 15))
    contact = np.outer(along_x, along_s)
    at = np.arange(20)
    beyond = np.maximum(7 - at, at - (6 + n))
    gap = np.where(contact, 0.0, np.where(beyond > 0, 1.0 + 1e-3 * beyond, 1.0)[:, None] + 0.1)
    (extent,) = extents(contact, gap)
    low, high = extent.x
    assert high - low >= 0.5 * n
    assert (low + high) / 2 == pytest.approx(7 + (n - 1) / 2)
    assert extent.accuracy_x >= 0.25 * (n == 1)


def test_patches_are_sorted_along_s_and_not_along_x():
    ranges = [(40.3, 52.8), (4.4, 12.1), (22.6, 29.0)]
    result = extents(*separate(*ranges))
    assert [extent.s for extent in result] == [pytest.approx(each, abs=1e-10) for each in sorted(ranges)]
    assert sum(extent.elements for extent in result).max() == 1
    contact = np.zeros((20, 30), dtype=bool)
    contact[4:6, 20:23] = contact[12:15, 5:9] = True
    first, second = extents(contact, np.where(contact, 0.0, 1.0))
    assert first.s[0] < second.s[0]
    assert first.x[0] > second.x[0]


def test_edge_between_near_patches_is_the_element_edge():
    """Of gaps that do not grow over three elements nothing can be read."""
    for right in (15.0, 16.0):  # two and three elements between both
        first, second = extents(*separate((4.4, 12.0), (right, 22.3)))
        assert first.s == pytest.approx((4.4, 12.5), abs=1e-10)
        assert second.s == pytest.approx((right - 0.5, 22.3), abs=1e-10)


def test_elements_that_touch_at_a_corner_are_one_patch():
    contact = np.zeros((12, 12), dtype=bool)
    contact[4:6, 4:6] = contact[6:8, 6:8] = True
    assert len(extents(contact, np.where(contact, 0.0, 1.0))) == 1
    contact[6, 6] = False
    assert len(extents(contact, np.where(contact, 0.0, 1.0))) == 2


def test_an_edge_stays_within_its_first_element_without_contact():
    """Where gaps beyond do not grow as they should: half an element inwards, one outwards."""
    contact = np.zeros((9, 12), dtype=bool)
    contact[3:6, 4:8] = True
    cases = {(1.0, 1e3, 1.001e3): 6.5, (1e-9, 1e-9, 1.0): 8.0, (1.0, 2.0, np.inf): 7.5}
    for gaps, edge in cases.items():
        gap = np.where(contact, 0.0, 1.0) * np.ones((9, 1))
        gap[:, 8:11] = np.where(contact[:, 7:8], gaps, 1.0)
        assert extents(contact, gap)[0].s[1] == pytest.approx(edge, abs=0.01)


def test_edge_at_the_end_of_the_grid_is_the_element_edge():
    contact, gap = flat_ended(4.0, 8.2, 11)
    (extent,) = extents(np.outer(contact, contact), gap[:, None] + gap)
    assert extent.x == pytest.approx((4.0, 8.5), abs=1e-12)


@pytest.mark.parametrize("room", [0, 1, 2, 3, 4])
@pytest.mark.parametrize(("end", "axis", "far"), [(0, 0, False), (1, 0, True), (2, 1, False), (3, 1, True)])
def test_margin_of_three_elements_is_required_at_each_end(end, axis, far, room):
    contact = np.zeros((20, 30), dtype=bool)
    contact[8:11, 9:17] = True
    n = contact.shape[axis]
    strip = [slice(8, 11), slice(9, 17)]
    strip[axis] = slice(10, n - room) if far else slice(room, 10)
    contact[tuple(strip)] = True
    assert near_ends(contact) == ((ENDS[end],) if room < MARGIN else ())
    assert near_ends(np.ones((9, 9), dtype=bool)) == ENDS
    nothing = np.zeros((9, 9), dtype=bool)
    assert (near_ends(nothing), extents(nothing, np.ones((9, 9)))) == ((), [])


def test_readings_from_gaps_alone_are_less_accurate_than_two_that_agree():
    """Seven elements are too few for a reading from pressures; on twenty Hertz's agree with gaps."""

    def line(low, high, n):
        at = np.arange(n)
        half, middle = (high - low) / 2, (low + high) / 2
        p = np.sqrt(np.maximum(1 - ((at - middle) / half) ** 2, 0.0))
        return p, 0.03 * np.maximum(np.abs(at - middle) - half, 0.0) ** 1.5

    (short_p, short_gap), (long_p, long_gap) = line(5.2, 12.3, 18), line(5.2, 24.7, 30)
    (extent,) = extents(np.outer(short_p, long_p), short_gap[:, None] + long_gap)
    assert extent.accuracy_x == ALONE
    assert ACCURACY <= extent.accuracy_s < 2 * ACCURACY


def test_an_edge_beside_another_patch_is_known_to_an_element():
    """Between two patches gaps grow and fall again: one end of each has another beside it."""
    ranges = (4.3, 20.2), (26.4, 44.3)
    contact, gap = separate(*ranges)
    at = np.arange(contact.shape[1])
    hertz = sum(np.sqrt(np.maximum((at - low) * (high - at), 0.0)) for low, high in ranges)
    for extent in extents(contact * hertz, gap):
        assert extent.accuracy_s > BESIDE / 2  # the mean of both ends
        assert extent.accuracy_x == ALONE


# ---- boxes: room around a contact, parts of fields, and when a contact is confined


def touching(*places, shape=(40, 50)):
    contact = np.zeros(shape, bool)
    for place in places:
        contact[place] = True
    return contact


def test_a_box_has_room_on_all_sides_and_ends_at_multiples_of_elements():
    box = Box.around(touching((17, 21), (22, 20)))
    assert box == Box((8, 32), (16, 32))
    for (first, last), (low, high) in zip((box.x, box.s), ((17, 22), (20, 21)), strict=True):
        assert low - first >= ROOM
        assert last - 1 - high >= ROOM
        assert first % STEP == last % STEP == 0


@pytest.mark.parametrize("place", [(0, 0), (39, 49), (3, 47)])
def test_a_box_ends_with_the_grid(place):
    box = Box.around(touching(place))
    assert 0 <= box.x[0] <= place[0] < box.x[1] <= 40
    assert 0 <= box.s[0] <= place[1] < box.s[1] <= 50


def test_values_of_a_box_are_put_back_where_they_were():
    box, values = Box((3, 9), (2, 7)), np.random.default_rng(0).normal(size=(10, 9, 3))
    part = box.crop(values)
    assert part.shape == (6, 5, 3)
    np.testing.assert_array_equal(part[2, 1], values[5, 3])
    back = box.embed(part, values.shape)
    np.testing.assert_array_equal(box.crop(back), part)
    assert np.sum(np.abs(back)) == pytest.approx(np.sum(np.abs(part)))
    assert box.embed(part[..., 0] > 0, values.shape[:2]).dtype == bool
    np.testing.assert_array_equal(values[:, box.strips], values[:, 2:7])
    assert Box.whole((4, 5, 3)) == Box((0, 4), (0, 5))
    assert Box((4, 8), (2, 6)).coarsened == Box((2, 4), (1, 3))


@pytest.mark.parametrize(
    ("confined", "places"),
    [
        (True, [(10, 10), (17, 10), (12, 8), (12, 0), (12, 17)]),  # at s = 0 the grid ends, too
        (False, [(9, 10), (18, 10), (12, 18), (30, 40)]),  # the last one is outside
    ],
)
def test_a_contact_is_confined_with_a_margin_to_ends_that_are_not_the_grids(confined, places):
    for place in places:
        assert Box((8, 20), (0, 20)).confines(touching(place), 2) is confined, place


# ---- forces and moments: one traction after the other, an arc's centre

X_AT = np.array([-1.0, 0.5, 2.0])
S_AT = np.array([-3.0, -1.0, 0.5, 4.0, 5.0])
AREA = 0.7
PRESSURES = [0.0, 0.0, 1.0]  # along n
CONTOUR = ellipse(9.0, 14.0, 0.6, 1.0)


@pytest.mark.parametrize("direction", range(3))
@pytest.mark.parametrize("place", [(0, 3), (2, 1)])
def test_one_traction_is_a_force_at_its_place(direction, place):
    """r x f, with the local directions (1, 0, 0), (0, cos, -sin), (0, sin, cos) in global axes."""
    tractions = np.zeros((3, 5, 3))
    tractions[*place, direction] = 2.0
    x, s = X_AT[place[0]], S_AT[place[1]]
    sin, cos = np.sin(CONTOUR.inclination(s)), np.cos(CONTOUR.inclination(s))
    axes = np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])
    total = resultant(tractions, section_at(CONTOUR, S_AT), X_AT, AREA)
    np.testing.assert_allclose(total.force, 2.0 * AREA * axes[direction], atol=1e-14)
    moment = np.cross([x, *CONTOUR.position(s)], 2.0 * AREA * axes[direction])
    np.testing.assert_allclose(total.moment, moment, atol=1e-12)


def test_pressures_on_an_arc_pass_through_its_centre():
    """It is R below the contact centre: M_x = R F_y. M_z = 0 where pressures are even in x."""
    x, s = np.array([-1.0, 1.0]), np.linspace(-4, 6, 11)
    p = np.random.default_rng(1).uniform(0, 5, 11) * np.ones((2, 1))
    total = resultant(p[..., None] * PRESSURES, section_at(arc(10.0, 0.9, 0.9), s), x, AREA)
    assert total.moment[0] == pytest.approx(10.0 * total.force[1], rel=1e-12)
    assert abs(total.force[1]) > 0.05 * total.force[2]
    np.testing.assert_allclose(total.moment[1:], 0.0, atol=1e-10)
    assert total.force[0] == 0.0


def test_the_moment_about_z_has_the_part_of_pressures_on_inclined_places():
    """Pressures that are odd in x have no force along z on a slope, but turn about z."""
    p, x, s = np.array([[-1.0], [1.0]]), np.array([-2.0, 2.0]), np.array([5.0])
    total = resultant(p[..., None] * PRESSURES, section_at(arc(10.0, 0.9, 0.9), s), x, AREA)
    assert total.moment[2] == pytest.approx(4.0 * AREA * np.sin(0.5))
    assert total.force[2] == pytest.approx(0.0, abs=1e-14)


def test_centre_of_pressure_is_the_mean_arc_length():
    p = np.array([[1.0, 0.0, 3.0], [1.0, 0.0, 0.0]])
    assert centre_of_pressure(p, np.array([-1.0, 0.0, 4.0])) == pytest.approx(10 / 5)


def test_an_edge_is_read_where_squared_pressures_fall_in_a_straight_line():
    """49^2, 61^2, 71^2 are equally far apart: no bend, to the last digit; 0 is 61^2 / 1320 elements on."""
    inside = np.array([1.0, 30.0, 49.0, 61.0, 71.0])
    assert patch_module._from_pressures(inside) == pytest.approx(61**2 / 1320 - 3, rel=1e-14)
