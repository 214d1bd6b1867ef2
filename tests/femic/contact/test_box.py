"""Boxes: room around a contact, parts of fields, and when a contact is confined."""

import numpy as np
import pytest

from femic.contact.patch import ROOM, STEP, Box


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


def test_a_whole_grid_is_a_box():
    assert Box.whole((4, 5, 3)) == Box((0, 4), (0, 5))
    assert Box.whole((4, 5)).shape == (4, 5)
    assert Box((4, 8), (2, 6)).coarsened == Box((2, 4), (1, 3))


@pytest.mark.parametrize(
    ("place", "confined"),
    [
        ((10, 10), True),
        ((9, 10), False),
        ((17, 10), True),
        ((18, 10), False),
        ((12, 8), True),  # the grid ends there, too
        ((12, 0), True),
        ((12, 17), True),
        ((12, 18), False),
        ((30, 40), False),  # outside
    ],
)
def test_a_contact_is_confined_with_a_margin_to_ends_that_are_not_the_grids(place, confined):
    box = Box((8, 20), (0, 20))
    assert box.confines(touching(place), 2) is confined
