"""Edges of patches whose gaps are known beyond them."""

import numpy as np
import pytest

from femic.contact.patch import ACCURACY, ALONE, BESIDE, ENDS, MARGIN, extents, near_ends


def flat_ended(low, high, n, power=1.5):
    """Contact on elements from `low` to `high`, in elements of a line; gaps grow as distance^power."""
    at = np.arange(n)
    beyond = np.maximum(np.maximum(low - at, at - high), 0.0)
    return beyond == 0, 0.03 * beyond**power


@pytest.mark.parametrize("low", [5.0, 5.1, 5.5, 5.999])
@pytest.mark.parametrize("high", [11.0, 11.3, 11.9])
def test_edges_are_exact_where_gaps_grow_as_distance_to_three_halves(low, high):
    """A rectangle: on the lines beside its corners nothing else touches."""
    contact_x, gap_x = flat_ended(low, high, 17)
    contact_s, gap_s = flat_ended(3.4, 20.25, 26)
    (extent,) = extents(np.outer(contact_x, contact_s), gap_x[:, None] + gap_s)
    assert extent.x == pytest.approx((low, high), abs=1e-12)
    assert extent.s == pytest.approx((3.4, 20.25), abs=1e-12)
    np.testing.assert_array_equal(extent.elements, np.outer(contact_x, contact_s))


def test_edges_are_exact_for_any_size_of_the_gaps():
    contact_x, gap_x = flat_ended(4.2, 9.7, 15)
    contact_s, gap_s = flat_ended(3.1, 6.6, 11)
    for scale in (1e-12, 1e6):
        (extent,) = extents(np.outer(contact_x, contact_s), scale * (gap_x[:, None] + gap_s))
        assert extent.x == pytest.approx((4.2, 9.7), abs=1e-10)


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


def test_patches_are_listed_from_left_to_right():
    ranges = [(40.3, 52.8), (4.4, 12.1), (22.6, 29.0)]
    result = extents(*separate(*ranges))
    assert [extent.s for extent in result] == [pytest.approx(each, abs=1e-10) for each in sorted(ranges)]
    assert sum(extent.elements for extent in result).max() == 1


def test_patches_are_sorted_along_s_and_not_along_x():
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


def test_all_near_ends_are_named_and_no_contact_has_none():
    assert near_ends(np.ones((9, 9), dtype=bool)) == ENDS
    assert near_ends(np.zeros((9, 9), dtype=bool)) == ()
    assert extents(np.zeros((9, 9), dtype=bool), np.ones((9, 9))) == []


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
