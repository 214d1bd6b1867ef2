"""Elements at leading edges against plain loops over runs of elements in contact."""

from itertools import groupby

import numpy as np
import pytest

from femic.contact.friction.motion import LEAST_PER_DEPTH, LeadingEdge


def runs(column):
    """(first, last) elements of all runs with bounds."""
    for positive, places in groupby(range(len(column)), lambda place: column[place] > 0):
        numbers = list(places)
        if positive:
            yield numbers[0], numbers[-1]


def followed_by_loops(bound, depth):
    followed = np.repeat(np.arange(len(bound))[:, None], bound.shape[1], axis=1)
    for column in range(bound.shape[1]):
        for first, last in runs(bound[:, column]):
            following = min(depth, (last - first + 1) // LEAST_PER_DEPTH)
            for place in range(last - following + 1, last + 1):
                followed[place, column] = last - following
    return followed


def many_runs(seed):
    """Bounds in rows with runs of all lengths, some of them at the ends of the grid."""
    random = np.random.default_rng(seed)
    bound = random.uniform(0.5, 2.0, (60, 12))
    bound[random.random(bound.shape) < 0.08] = 0.0
    bound[:, 0], bound[:, 1] = 0.0, 1.0
    return bound


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_the_last_elements_of_each_run_follow_the_one_behind_them(seed, depth):
    bound = many_runs(seed)
    lengths = {last - first + 1 for column in bound.T for first, last in runs(column)}
    assert {1, 2, 3, 6, 7, 60} <= lengths
    assert any(2 * LEAST_PER_DEPTH <= length < 60 for length in lengths)
    given = bound.copy()
    edge = LeadingEdge.find(given, depth)
    np.testing.assert_array_equal(given, bound)
    expected = followed_by_loops(bound, depth)
    np.testing.assert_array_equal(edge.followed, expected)
    assert (np.count_nonzero(edge.followed != np.arange(60)[:, None]) > 0) == (depth > 0)
    rows, columns = np.nonzero(bound)
    of_followed = bound[edge.followed[rows, columns], columns]
    np.testing.assert_allclose(edge.ratio[rows, columns], bound[rows, columns] / of_followed)
    assert np.all(edge.ratio[bound == 0] == 0)


@pytest.mark.parametrize(("length", "following"), [(1, 0), (5, 0), (6, 1), (11, 1), (12, 2), (40, 2)])
def test_in_short_runs_fewer_elements_follow(length, following):
    bound = np.zeros((length + 5, 1))
    bound[2 : 2 + length] = 1.0
    moved = np.arange(length + 5) - LeadingEdge.find(bound).followed[:, 0]
    expected = np.zeros(length + 5)
    expected[2 + length - following : 2 + length] = np.arange(1, following + 1)
    np.testing.assert_array_equal(moved, expected)


def test_tractions_take_the_same_share_of_their_bounds():
    bound = many_runs(4)
    edge = LeadingEdge.find(bound, 2)
    p = np.random.default_rng(0).normal(size=(*bound.shape, 2))
    spread = edge.spread(p)
    np.testing.assert_array_equal(spread[edge.free], p[edge.free])
    assert np.all(spread[bound == 0] == 0)
    rows, columns = np.nonzero((bound > 0) & ~edge.free)
    assert len(rows) > 10
    for row, column in zip(rows, columns, strict=True):
        behind = edge.followed[row, column]
        share = spread[behind, column] / bound[behind, column]
        np.testing.assert_allclose(spread[row, column], share * bound[row, column])


def test_free_are_elements_with_bounds_that_follow_no_other():
    bound = many_runs(5)
    expected = (bound > 0) & (followed_by_loops(bound, 2) == np.arange(60)[:, None])
    np.testing.assert_array_equal(LeadingEdge.find(bound, 2).free, expected)
    np.testing.assert_array_equal(LeadingEdge.find(bound, 0).free, bound > 0)
    assert not np.any(LeadingEdge.find(np.zeros((4, 3)), 2).free)
