"""Which wavenumbers are solved: as many as smooth, sharp and periodic responses need, and no more."""

import numpy as np
import pytest

from femic.accuracy import NotConverged
from femic.harmonic.wavenumbers import Axis, sampled

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


def interpolated(found, at):
    even, odd = found.axis.interpolation(found.k, at)
    values = [np.tensordot(m, found.responses, axes=1) for m in (even, odd)]
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
def test_as_accurate_as_asked_and_each_wavenumber_solved_once(accuracy):
    """Displacements at some x by a sum over all k, against the sum of the responses themselves."""
    solve = Solver(smooth)
    found = sampled(AXIS, solve, ODD, 0.2, accuracy)
    assert len(solve.asked) == len(set(solve.asked)) == len(found.k)
    at = np.linspace(0, 25, 200_001)
    off = interpolated(found, at)[:, 0, 0] - [smooth(v)[0, 0] for v in at]
    weight = np.sinc(at * 0.2 / np.pi) / np.pi * at[1]
    for x in (0.0, 0.3, 4.0):
        assert abs(np.sum(off * weight * np.cos(at * x))) < accuracy


def test_wavenumbers_gather_where_the_response_is_sharp():
    def peak(k):
        return np.array([[1 / (1 + ((k - 1) / 0.05) ** 2)], [0.0]])

    found = sampled(AXIS, Solver(peak), ODD, 0.2, 1e-5)
    t = np.arcsinh(np.array([0.7, 1.3, AXIS.k_max]) / AXIS.scale)
    near = np.mean(np.abs(found.k - 1) < 0.3)
    assert near > 4 * (t[1] - t[0]) / t[2]
    at = np.linspace(0.5, 1.5, 500)
    np.testing.assert_allclose(interpolated(found, at)[:, 0, 0], [peak(v)[0, 0] for v in at], atol=1e-3)


def test_sparser_leaves_out_the_last_ones_and_is_worse():
    found = sampled(AXIS, Solver(smooth), ODD, 0.2, 1e-5)
    sparser = found.sparser
    assert set(sparser.k) < set(found.k)
    assert sparser.k[0] == 0
    assert sparser.k[-1] == found.k[-1]
    at = np.geomspace(1e-3, 20.0, 300)
    truth = np.array([smooth(v) for v in at])
    wrong = [np.max(np.abs(interpolated(one, at) - truth)) for one in (found, sparser)]
    assert wrong[1] > 8 * wrong[0]


@pytest.mark.parametrize("radius", [1.0, 20.0, 500.0, 1e6])
def test_a_ring_is_solved_at_its_orders_only(radius):
    """m = 0 and 1 stand for themselves, however far from the others."""

    def response(k):
        free = 7.0 if k * radius < 1.5 else 0.0
        return smooth(k) + free

    found = sampled(Axis(1e-3, 25.0, radius), Solver(response), ODD, 0.2, 1e-6)
    orders = found.k * radius
    np.testing.assert_allclose(orders, np.round(orders), atol=1e-6)
    assert set(np.round(orders[:3])) == {0, 1, 2}
    assert found.k[-1] == pytest.approx(np.floor(25.0 * radius) / radius)
    at = np.unique(np.round(np.append([0, 1, 2], np.geomspace(2, 20 * radius, 200)))) / radius
    truth = np.array([response(v) for v in at])
    np.testing.assert_allclose(interpolated(found, at), truth, atol=1e-3)


def test_a_response_that_is_never_smooth_is_refused_with_what_to_try():
    rng = np.random.default_rng(1)
    noise = Solver(lambda _: rng.normal(size=(2, 1)))
    with pytest.raises(NotConverged, match=r"more than 1000 wavenumbers .* larger engine.tolerance"):
        sampled(AXIS, noise, ODD, 0.2, 1e-9)
