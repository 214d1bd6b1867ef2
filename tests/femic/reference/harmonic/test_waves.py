"""Wavenumbers: sums that come out in closed form, and the half-space that they must add up to."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.reference.harmonic.waves import (
    SINES,
    Axis,
    half_space_response,
    integral,
    orders,
    spectrum,
    synthesis_weights,
    tail,
    taper,
)
from geometries.materials import Material, both_bodies, one_body
from geometries.patches import Patch

SOLID = HalfSpace(both_bodies(Material(210e3, 0.28), Material(97e3, 0.36)))
PATCH = Patch(0.2, 0.15)
WAVES = ((2, 2, "cos"), (1, 1, "cos"), (0, 0, "cos"), (0, 1, "sin"), (0, 2, "sin"), (1, 2, "cos"))
X = np.array([0.0, 0.3, 1.6, 6.0, 25.0])


def a_of(x, s):
    return SOLID.ics(PATCH, x, np.full_like(x, s)) / PATCH.area


# --- sums ------------------------------------------------------------------------------------------


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


def test_the_taper_falls_from_1_to_0_without_a_kink():
    k = np.linspace(0, 1.2, 10_001)
    share = taper(k)
    np.testing.assert_array_equal(share[k <= 1 / 1.5**2], 1.0)
    np.testing.assert_array_equal(share[k >= 1], 0.0)
    assert np.all(np.diff(share) <= 0)
    assert np.max(np.abs(np.diff(share, 2))) < 40 * (k[1] - k[0]) ** 2  # curvature of 10 x^3 ... over 0.56^2
    assert np.max(np.abs(np.diff(share, 3))) < 1200 * (k[1] - k[0]) ** 3


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
