"""Which wavenumbers are solved: as many as smooth, sharp and periodic responses need, and no more."""

import numpy as np
import pytest

from femic.reference.harmonic.waves import Axis, sample
from femic.reference.job import NotConverged

AXIS = Axis(1e-3, 25.0)
ODD = np.array([[False], [True]])


def smooth(k):
    """An even and an odd response, shape (2, 1): constant below a scale, then logarithmic, then gone."""
    even = np.exp(-1.6 * np.hypot(k, 1e-3)) / (1 + (k / 1e-3) ** 2) ** 0.05
    return np.array([[even], [k * np.exp(-k)]])


class Solver:
    """Responses of a function, and at which wavenumbers they were asked for."""

    def __init__(self, response):
        self.response, self.asked = response, []

    def __call__(self, k):
        self.asked += k
        return [self.response(value) for value in k]


def interpolated(result, at):
    even, odd = result.axis.interpolation(result.k, at)
    values = [np.tensordot(m, result.responses, axes=1) for m in (even, odd)]
    return np.where(ODD, values[1], values[0])


@pytest.mark.parametrize("degree", [0, 2, 4])
def test_polynomials_of_t_are_met_exactly(degree):
    k = AXIS.first()
    at = np.geomspace(1e-5, 25.0, 200)
    even, odd = AXIS.interpolation(k, at)
    t, t_at = (np.arcsinh(v / AXIS.scale) for v in (k, at))
    np.testing.assert_allclose(even @ t**degree, t_at**degree, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(odd @ t ** (degree + 1), t_at ** (degree + 1), rtol=1e-8, atol=1e-8)


def test_interpolation_between_wavenumbers_is_of_sixth_order():
    at, errors = np.geomspace(1e-4, 20.0, 500), []
    end = np.arcsinh(AXIS.k_max / AXIS.scale)
    for n in (30, 60, 120):
        k = AXIS.scale * np.sinh(np.linspace(0, end, n))
        even, _ = AXIS.interpolation(k, at)
        errors.append(np.max(np.abs(even @ [smooth(v)[0, 0] for v in k] - [smooth(v)[0, 0] for v in at])))
    assert np.all(-np.diff(np.log2(errors)) > 5)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5, 1e-7])
def test_samples_reach_the_accuracy_and_solve_each_wavenumber_once(accuracy):
    """Displacements at some x by a sum over all k, against the sum of the responses themselves."""
    solve = Solver(smooth)
    result = sample(AXIS, solve, ODD, 0.2, accuracy)
    assert len(solve.asked) == len(set(solve.asked)) == len(result.k)
    at = np.linspace(0, 25, 200_001)
    off = interpolated(result, at)[:, 0, 0] - [smooth(v)[0, 0] for v in at]
    weight = np.sinc(at * 0.2 / np.pi) / np.pi * at[1]
    for x in (0.0, 0.3, 4.0):
        assert abs(np.sum(off * weight * np.cos(at * x))) < accuracy


def test_wavenumbers_gather_where_the_response_is_sharp():
    def peak(k):
        return np.array([[1 / (1 + ((k - 1) / 0.05) ** 2)], [0.0]])

    result = sample(AXIS, Solver(peak), ODD, 0.2, 1e-5)
    t = np.arcsinh(np.array([0.7, 1.3, AXIS.k_max]) / AXIS.scale)
    near = np.mean(np.abs(result.k - 1) < 0.3)
    assert near > 4 * (t[1] - t[0]) / t[2]
    at = np.linspace(0.5, 1.5, 500)
    np.testing.assert_allclose(interpolated(result, at)[:, 0, 0], [peak(v)[0, 0] for v in at], atol=1e-3)


def test_sparser_leaves_out_the_last_ones_and_is_worse():
    result = sample(AXIS, Solver(smooth), ODD, 0.2, 1e-5)
    sparser = result.sparser
    assert set(sparser.k) < set(result.k)
    assert sparser.k[0] == 0
    assert sparser.k[-1] == result.k[-1]
    at = np.geomspace(1e-3, 20.0, 300)
    truth = np.array([smooth(v) for v in at])
    wrong = [np.max(np.abs(interpolated(one, at) - truth)) for one in (result, sparser)]
    assert wrong[1] > 8 * wrong[0]


@pytest.mark.parametrize("radius", [1.0, 20.0, 500.0, 1e6])
def test_a_ring_is_solved_at_its_orders_only(radius):
    """m = 0 and 1 stand for themselves, however far from the others."""

    def response(k):
        free = 7.0 if k * radius < 1.5 else 0.0
        return smooth(k) + free

    result = sample(Axis(1e-3, 25.0, radius), Solver(response), ODD, 0.2, 1e-6)
    orders = result.k * radius
    np.testing.assert_allclose(orders, np.round(orders), atol=1e-6)
    assert set(np.round(orders[:3])) == {0, 1, 2}
    assert result.k[-1] == pytest.approx(np.floor(25.0 * radius) / radius)
    at = np.unique(np.round(np.append([0, 1, 2], np.geomspace(2, 20 * radius, 200)))) / radius
    truth = np.array([response(v) for v in at])
    np.testing.assert_allclose(interpolated(result, at), truth, atol=1e-3)


def test_response_that_is_never_smooth_raises_with_remedies():
    rng = np.random.default_rng(1)
    noise = Solver(lambda _: rng.normal(size=(2, 1)))
    with pytest.raises(NotConverged, match=r"more than 1000 wavenumbers .* larger `tolerance`"):
        sample(AXIS, noise, ODD, 0.2, 1e-9)


# --- which are solved, and which came last ---------------------------------------------------------------


@pytest.mark.parametrize("axis", [AXIS, Axis(1e-3, 25.0, 40.0), Axis(0.3, 2.0)])
def test_first_wavenumbers_are_even_in_t_and_close_enough_for_the_spline(axis):
    k = axis.first()
    t = np.arcsinh(k / axis.scale)
    assert k[0] == 0
    if np.isinf(axis.radius):
        assert k[-1] == pytest.approx(axis.k_max)
        np.testing.assert_allclose(np.diff(t), t[-1] / (len(k) - 1))
        assert len(k) == max(int(np.ceil(t[-1] / 1.2)), 5) + 1
    else:
        assert set(np.round(k * axis.radius)) >= set(range(8))


@pytest.mark.parametrize(("scale", "fewest"), [(0.05, 3), (0.049, 8)])
def test_a_large_ring_needs_few_of_its_lowest_orders(scale, fewest):
    """Large: its order 1 lies below the scale."""
    radius = 1 / 0.0499
    orders = np.round(Axis(scale, 25.0, radius).first() * radius)
    assert set(range(fewest)) <= set(orders)
    assert (set(range(8)) <= set(orders)) == (fewest == 8)


def test_middle_of_an_interval_is_in_t_and_on_a_ring_an_order():
    low, high = 0.01, 3.0
    t = np.arcsinh(np.array([low, AXIS.between(low, high), high]) / AXIS.scale)
    assert t[1] == pytest.approx((t[0] + t[2]) / 2)
    ring = Axis(1e-3, 25.0, 10.0)
    assert ring.between(0.3, 0.4) is None
    assert ring.between(0.3, 0.5) == pytest.approx(0.4)
    assert ring.between(0.0, 0.2) == pytest.approx(0.1)
    assert 0.4 <= ring.between(0.3, 9.0) <= 8.9


@pytest.mark.parametrize("radius", [np.inf, 40.0])
def test_at_the_solved_wavenumbers_nothing_is_interpolated(radius):
    axis = Axis(1e-3, 25.0, radius)
    k = axis.first()
    even, odd = axis.interpolation(k, k)
    np.testing.assert_allclose(even, np.eye(len(k)), atol=1e-9)
    np.testing.assert_allclose(odd, np.eye(len(k)), atol=1e-9)


def test_orders_0_and_1_of_a_ring_do_not_affect_other_orders():
    axis = Axis(1e-3, 25.0, 40.0)
    k = axis.first()
    at = np.arange(2, 900) / 40.0
    matrix, same = axis.interpolation(k, at)
    assert np.all(matrix[:, :2] == 0)
    np.testing.assert_array_equal(matrix, same)
    np.testing.assert_allclose(matrix @ np.ones(len(k)), 1, rtol=1e-9)


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-6])
def test_last_marks_middles_of_intervals_that_were_not_halved(accuracy):
    """Each lies in the middle of its neighbours; each other one is a first one, or next to a last one."""
    result = sample(AXIS, Solver(smooth), ODD, 0.2, accuracy)
    first = AXIS.first()
    assert np.any(result.last)
    for n in np.flatnonzero(result.last):
        assert result.k[n] not in first
        assert not result.last[n - 1]
        assert not result.last[n + 1]
        assert result.k[n] == pytest.approx(AXIS.between(result.k[n - 1], result.k[n + 1]))
    for n in np.flatnonzero(~result.last)[1:-1]:
        assert result.last[n - 1]
        assert result.last[n + 1]
    if accuracy == 1e-6:
        assert np.sum(~result.last) > len(first)


NARROW = Axis(0.3, 40.0)
A_LOAD = 0.2


@pytest.mark.parametrize("interval", [0, 2, -1])
@pytest.mark.parametrize(("share", "rounds"), [(0.99, 1), (1.01, 2)])
def test_intervals_are_halved_only_where_their_error_in_displacements_is_too_large(interval, share, rounds):
    """Wrong in its middle by w: off by w (high - low) / pi, less where the patch is longer than the wave.

    An interval of half the length of a spline of fifth degree is 64 times as accurate.
    """
    first, accuracy = NARROW.first(), 1e-3
    low, high = first[interval if interval >= 0 else -2], first[interval + 1 if interval >= 0 else -1]
    middle = NARROW.between(low, high)
    allowed = 64 * accuracy * np.pi / (high - low) * max(1.0, middle * A_LOAD)

    def response(k):
        return np.array([[share * allowed if k == middle else 0.0], [0.0]])

    solve = Solver(response)
    calls = []
    result = sample(NARROW, lambda k: calls.append(len(k)) or solve(k), ODD, A_LOAD, accuracy)
    assert (len(calls) > 2) == (rounds == 2)
    if rounds == 1:
        assert len(result.k) == 2 * len(first) - 1
    else:
        assert calls[2] == 2


def test_accuracy_may_differ_from_entry_to_entry():
    """What is asked of an entry that is 0 everywhere costs nothing."""
    one = sample(AXIS, Solver(smooth), ODD, 0.2, np.array([[1e-5], [1e-1]]))
    other = sample(AXIS, Solver(smooth), ODD, 0.2, np.array([[1e-1], [1e-5]]))
    both = sample(AXIS, Solver(smooth), ODD, 0.2, 1e-5)
    assert set(one.k) <= set(both.k)
    assert set(other.k) <= set(both.k)
    assert len(sample(AXIS, Solver(smooth), ODD, 0.2, 1e-1).k) < min(len(one.k), len(other.k))


@pytest.mark.parametrize("radius", [1.0, 20.0, 500.0])
def test_adjacent_orders_are_not_marked_as_last(radius):
    """m = 0, 1, 2 of a ring have no middles: the sparser ones have them, too, as all first ones."""
    axis = Axis(1e-3, 25.0, radius)
    result = sample(axis, Solver(smooth), ODD, 0.2, 1e-6)
    assert np.any(result.last)
    assert set(axis.first()) <= set(result.sparser.k)
