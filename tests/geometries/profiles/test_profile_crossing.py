import time
from itertools import combinations

import numpy as np
import pytest
from profile_texts import rail

from geometries.profiles.preparation import SelfIntersection, first_crossing


def brute_force(points):
    """Every pair of segments, by the parameters at which their lines meet."""
    pairs = []
    for a, b in combinations(range(points.shape[1] - 1), 2):
        if b - a == 1:
            continue
        p, r = points[:, a], points[:, b]
        try:
            u, v = np.linalg.solve(np.stack([points[:, a + 1] - p, r - points[:, b + 1]], axis=1), r - p)
        except np.linalg.LinAlgError:  # parallel
            continue
        if 0 <= u <= 1 and 0 <= v <= 1:
            pairs.append((a, b))
    return pairs


def random_walk(seed):
    rng = np.random.default_rng(seed)
    steps = rng.standard_normal((2, 3 + seed % 23))
    steps[0] += 1.1
    return np.cumsum(steps, axis=1)


def test_crossings_are_those_of_brute_force():
    expected = [brute_force(random_walk(seed)) for seed in range(60)]
    assert 10 <= sum(map(bool, expected)) <= 45
    for seed, pairs in enumerate(expected):
        assert first_crossing(random_walk(seed)) == (pairs[0] if pairs else None), seed


def test_touching_counts_as_crossing():
    assert first_crossing(np.array([[0, 4, 4, 2, 2.0], [0, 0, 2, 2, 0]])) == (0, 3)  # a T
    assert first_crossing(np.array([[0, 4, 4, 3, 3, 2.0], [0, 0, 1, 1, 0, 0]])) is not None  # along a line
    assert first_crossing(np.array([[0, 4, 4, 2, 2.0], [0, 0, 2, 2, 1e-9]])) is None


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e6])
def test_one_crossing_among_100000_segments_is_found_fast(scale):
    points = scale * rail(100_001)
    start = time.process_time()
    assert first_crossing(points) is None
    # the last segment goes back over the first face
    spur = np.concatenate([points, points[:, 1000:1001] + scale * np.array([[-1.0], [0.0]])], axis=1)
    crossing = first_crossing(spur)
    assert crossing is not None
    assert crossing[1] == 100_000
    assert time.process_time() - start < 10  # 0.5 s; every pair would take hours


ZIGZAG, TURN = np.arange(100_000) % 2, np.arange(100_000) / 100_000
SCRIBBLES = {
    "random": (np.random.default_rng(1).random((2, 100_000)), True),
    "to and fro": (np.stack([ZIGZAG, 1e-4 * TURN]), False),
    "fan": (ZIGZAG * np.stack([np.cos(TURN), np.sin(TURN)]), True),
}


@pytest.mark.parametrize(("points", "crossing"), SCRIBBLES.values(), ids=SCRIBBLES)
def test_entangled_points_end_fast(points, crossing):
    start = time.process_time()
    assert (first_crossing(points) is not None) == crossing
    assert time.process_time() - start < 20  # 1 s


def test_what_cannot_be_looked_at_is_not_taken_for_a_contour_without_crossings():
    # parallel segments, each to the right of the one before, joined behind: their boxes overlap, they do not
    n = 30_000
    k = np.arange(n)
    start, end = np.stack([k * 1e-3, k * 1e-3 + 100]), np.stack([k * 1e-3 + 100, k * 1e-3])
    points = np.empty((2, 2 * n))
    points[:, 0::4], points[:, 1::4] = start[:, ::2], end[:, ::2]
    points[:, 2::4], points[:, 3::4] = end[:, 1::2], start[:, 1::2]
    begin = time.process_time()
    with pytest.raises(SelfIntersection):
        first_crossing(points)
    assert time.process_time() - begin < 10
