"""Wavenumbers: as many as responses need, sums in closed form, and the half-space that they add up to."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.harmonic.waves import (
    SINES,
    Axis,
    half_space_response,
    integral,
    orders,
    sample,
    spectrum,
    synthesis_weights,
    tail,
)
from femic.reference.job import NotConverged
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch

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
        errors.append(np.max(np.abs(even @ smooth(k)[0, 0] - smooth(at)[0, 0])))
    assert np.all(-np.diff(np.log2(errors)) > 5)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-5, 1e-7])
def test_samples_reach_the_accuracy_and_solve_each_wavenumber_once(accuracy):
    """Displacements at some x by a sum over all k, against the sum of the responses themselves."""
    solve = Solver(smooth)
    result = sample(AXIS, solve, ODD, 0.2, accuracy)
    assert len(solve.asked) == len(set(solve.asked)) == len(result.k)
    at = np.linspace(0, 25, 200_001)
    off = interpolated(result, at)[:, 0, 0] - smooth(at)[0, 0]
    weight = np.sinc(at * 0.2 / np.pi) / np.pi * at[1]
    for x in (0.0, 0.3, 4.0):
        assert abs(np.sum(off * weight * np.cos(at * x))) < accuracy


def test_accuracy_may_differ_from_entry_to_entry():
    """What is asked of an entry that is 0 everywhere costs nothing."""

    def solved(even, odd):
        return set(sample(AXIS, Solver(smooth), ODD, 0.2, np.array([[even], [odd]])).k)

    one, other = solved(1e-5, 1e-1), solved(1e-1, 1e-5)
    assert one | other <= solved(1e-5, 1e-5)
    assert len(solved(1e-1, 1e-1)) < min(len(one), len(other))


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
    m = result.k * radius
    np.testing.assert_allclose(m, np.round(m), atol=1e-6)
    assert set(np.round(m[:3])) == {0, 1, 2}
    assert set(result.axis.first()) <= set(result.sparser.k)  # adjacent orders have no middles
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
    solved = set(np.round(Axis(scale, 25.0, radius).first() * radius))
    assert set(range(fewest)) <= solved
    assert (set(range(8)) <= solved) == (fewest == 8)


def test_middle_of_an_interval_is_in_t_and_on_a_ring_an_order():
    low, high = 0.01, 3.0
    t = np.arcsinh(np.array([low, AXIS.between(low, high), high]) / AXIS.scale)
    assert t[1] == pytest.approx((t[0] + t[2]) / 2)
    ring = Axis(1e-3, 25.0, 10.0)
    assert ring.between(0.3, 0.4) is None
    assert ring.between(0.3, 0.5) == pytest.approx(0.4)
    assert ring.between(0.0, 0.2) == pytest.approx(0.1)
    assert 0.4 <= ring.between(0.3, 9.0) <= 8.9
    for radius in (10.0, 460.0, 0.7):  # orders over some radii, times these, are below the orders by rounding
        ring = Axis(1e-3, 25.0, radius)
        for order in range(1, 200):
            between = ring.between((order - 1) / radius, (order + 1) / radius)
            assert between == pytest.approx(order / radius, rel=1e-12)


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


# --- sums over all wavenumbers ---------------------------------------------------------------------------

SOLID = HalfSpace(both_bodies(Material(210e3, 0.28), Material(97e3, 0.36)))
PATCH = Patch(0.2, 0.15)
WAVES = ((2, 2, "cos"), (1, 1, "cos"), (0, 0, "cos"), (0, 1, "sin"), (0, 2, "sin"), (1, 2, "cos"))
X = np.array([0.0, 0.3, 1.6, 6.0, 25.0])


def a_of(x, s):
    return SOLID.ics(PATCH, x, np.full_like(x, s)) / PATCH.area


def summed(over, f, x, a=0.0):
    """The sum over wavenumbers of f(k) cos(k x) sin(k a) / (k a)."""
    return f(over.k) @ over.shares(a, np.atleast_1d(x))[0]


def synthesis(response, direction, over, a, xi):
    """Displacements (3, n) at xi due to a unit load in a direction from its responses (3, len(k))."""
    even, odd = over.shares(a, xi)
    return np.where(SINES[:, direction, None], response @ odd, response @ even)


@pytest.mark.parametrize("k_max", [80.0, 3e4, 3e7])
@pytest.mark.parametrize("x", [0.0, 0.1, 3.0, 200.0, 1e4])
def test_the_integral_is_right_near_and_far_with_the_same_wavenumbers(x, k_max):
    over = integral(k_max)
    got = summed(over, lambda k: np.exp(-k), x)
    assert got == pytest.approx(1 / (np.pi * (1 + x * x)), rel=1e-9, abs=1e-12)  # e^-35 is tapered
    assert len(over.k) < 1200


@pytest.mark.parametrize("a", [1e-4, 0.02, 0.7, 25.0])
@pytest.mark.parametrize("x", [0.0, 0.3, 6.0, 400.0])
def test_a_patch_of_any_length_gives_the_mean_over_it(x, a):
    """The mean of 1 / (pi (1 + x^2)) is a difference of arc tangents, of 0.5 ln(1 + x^2) the odd one."""
    over = integral(80.0)
    even, odd = over.shares(a, np.array([x]))
    f = np.exp(-over.k)
    low, high = x - a, x + a
    expected = np.arctan2(high - low, 1 + low * high) / (2 * np.pi * a)
    assert f @ even == pytest.approx(expected, rel=1e-9, abs=1e-12)
    expected = np.log1p((high - low) * (high + low) / (1 + low * low)) / (4 * np.pi * a)
    assert f @ odd == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("over", [integral(30.0), spectrum(30.0, 200.0), orders(30.0, 20.0)])
def test_error_at_the_largest_wavenumbers_has_no_effect_far_away(over):
    """Abruptly ended it would be 1 / (pi x) far away, and with the weight of a patch up to 1 / (pi k a x)."""
    x = np.array([2.0, 4.0, 8.0])
    even, odd = over.shares(1e-6, x)
    constant = np.where(over.k < 0, 0.0, 1.0)
    steps = (over.k / 30.0) ** 4  # is not seen below
    assert np.all(np.abs(constant @ even) < 3e-3 / (np.pi * x))
    assert np.all(np.abs(steps @ odd) < 2e-2 / (np.pi * x))
    halved = np.abs(constant @ even) * x
    assert np.all(halved[1:] < halved[:-1] / 4)  # like 1 / x^3, then x


def test_orders_of_a_ring_add_up_to_a_periodic_sum():
    radius, x = 5.0, 3.0
    got = summed(orders(40.0, radius), lambda k: np.exp(-k), x)
    images = x + 2 * np.pi * radius * np.arange(-20000, 20001)
    assert got == pytest.approx(np.sum(1 / (np.pi * (1 + images**2))), rel=1e-5)  # 1 / 20000 of images left


@pytest.mark.parametrize("radius", [5.0, 60.0, 1000.0])
@pytest.mark.parametrize("x", [0.0, 2.0, 15.0])
def test_a_sum_over_low_orders_and_an_integral_give_the_sum_over_all(radius, x):
    """Of a function as sharp as it gets, with a peak at order 1."""
    few, all_of_them = spectrum(40.0, radius), orders(40.0, radius)
    sums = [
        summed(over, lambda k: np.exp(-k) + 0.1 / (1 + (k * radius - 1) ** 2), x)
        for over in (few, all_of_them)
    ]
    assert sums[0] == pytest.approx(sums[1], rel=1e-9)
    if radius == 1000.0:
        assert len(few.k) < len(all_of_them.k) / 10


def test_weights_of_solved_wavenumbers_add_up_to_the_synthesis():
    """Responses known between the solved wavenumbers, too: what the weights leave of them."""
    axis = Axis(0.05, 30.0)
    k, over, xi = (
        axis.scale * np.sinh(np.linspace(0, 7.2, 60)),
        integral(30.0),
        np.array([0.0, 0.4, 3.0]),
    )
    even, odd = synthesis_weights(axis, k, over, over.shares(0.2, xi))
    for direction in range(3):
        response = np.stack([k * np.exp(-k) if sine else np.exp(-k * k) for sine in SINES[:, direction]])
        at = np.stack(
            [over.k * np.exp(-over.k) if sine else np.exp(-(over.k**2)) for sine in SINES[:, direction]]
        )
        expected = synthesis(at, direction, over, 0.2, xi)
        got = [row @ (odd if sine else even) for row, sine in zip(response, SINES[:, direction], strict=True)]
        np.testing.assert_allclose(got, expected, rtol=0, atol=1e-6)


# --- the half-space --------------------------------------------------------------------------------


@pytest.mark.parametrize("s", [0.0, 0.1, -0.4, 2.0])
@pytest.mark.parametrize("k", [0.03, 1.0, 9.0])
def test_responses_are_the_transforms_of_a_line_load_s_displacements(k, s):
    """A thin patch along x is a point of it: its A, transformed by a trapezium rule, faded out far away."""
    got = half_space_response(SOLID, PATCH.b, s, np.array([k]))[..., 0]
    on_load = half_space_response(SOLID, PATCH.b, 0.0, np.array([k]))[2, 2, 0]
    thin = Patch(1e-6, PATCH.b)
    x = np.append(0.0, np.geomspace(1e-9, 400 / k, 200_001))
    at = SOLID.ics(thin, x, np.full_like(x, s)) / thin.area * np.exp(-((k * x / 150) ** 4))
    for i, j, wave in WAVES:
        expected = 2 * np.trapezoid(at[i, j] * (np.cos(k * x) if wave == "cos" else np.sin(k * x)), x)
        assert got[i, j] == pytest.approx(expected, rel=1e-5, abs=1e-8 * on_load)


@pytest.mark.parametrize("s", [0.0, 0.1, 0.4, -1.6])
def test_all_wavenumbers_add_up_to_a(s):
    """The tail beyond k falls to nothing: about like 1 / k^2 on the strip, exponentially beside it."""
    scale = np.abs(a_of(X, s)[2, 2])
    shares = [np.max(np.abs(tail(SOLID, PATCH, k, X)(s)) / scale) for k in (20.0, 80.0, 320.0)]
    assert shares[0] < 0.2
    if abs(s) > PATCH.b:
        assert shares[1] < 1e-6
    else:
        assert shares[0] > 4 * shares[1] > 16 * shares[2]  # sin(k a) lets it swing


def test_the_tail_completes_what_is_below_it():
    k_max, s = 15.0, 0.2
    over = integral(k_max)
    response = half_space_response(SOLID, PATCH.b, s, over.k)
    below = np.stack([synthesis(response[:, j], j, over, PATCH.a, X) for j in range(3)], axis=1)
    whole = below + tail(SOLID, PATCH, k_max, X)(s)
    np.testing.assert_allclose(whole, a_of(X, s), rtol=0, atol=1e-12 * np.max(whole))


def test_one_body_has_the_tail_of_its_side():
    bodies = (HalfSpace(one_body(Material(210e3, 0.28), side)) for side in (1, -1))
    upper, lower = (tail(body, PATCH, 20.0, X)(0.0) for body in bodies)
    np.testing.assert_allclose(upper[0, 2], -lower[0, 2], rtol=1e-12)
    np.testing.assert_allclose(upper[2, 2], lower[2, 2], rtol=1e-12)
