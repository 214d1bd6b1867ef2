"""B-hat-prime fitted to ICs that are known: the parameters come back, whatever the units and the order."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from approx import calibration
from approx.calibration import EXPONENTS, FEWEST, R_INF_REACH, Target, fit, pointwise_k
from approx.effective import EffectiveProperties, Transition
from approx.pair import Pair, Solid
from geometries.contours import arc
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.patches import Patch, indices
from geometries.surfaces import LOWER, UPPER, Surface

STEEL, BRASS = Material(210e3, 0.28), Material(97e3, 0.36)
PATCH = Patch(0.2, 0.3)
CONTOUR = arc(10.0, 0.5, 0.6)
RAIL, WHEEL = Solid(STEEL, Surface(LOWER, CONTOUR)), Solid(BRASS, Surface(UPPER, CONTOUR, 300.0))
X = np.tile(np.linspace(0.5, 25.0, 26), 2)
S = np.repeat([0.0, 1.6], 26)

ALL_STARTS = {name: getattr(calibration, name) for name in ("START_GRID", "STARTS", "FINALISTS")}


def target(effective, solid=None, components=("xn",), *, x=X, s=S):
    """ICs that B-hat-prime is able to be, known exactly."""
    solid = solid or Pair(WHEEL, RAIL)
    ics = replace(solid, effective=effective).approximate("Bhat_prime", PATCH, (x, s))
    rows = [ics[indices(component)] for component in components]
    return Target(solid, PATCH, x, s, components, np.array(rows), np.ones(len(x)), np.zeros(1))


def logarithmic(low, high):
    return st.floats(np.log(low), np.log(high)).map(np.exp)


@settings(max_examples=3, deadline=None)
@given(
    far=st.floats(-4.9, 4.9).filter(lambda far: abs(far) > 0.05),
    r_inf=logarithmic(0.5, R_INF_REACH * 24.9),
    m=logarithmic(*EXPONENTS["m"]),
    n=logarithmic(*EXPONENTS["n"]),
    apart=st.booleans(),
)
def test_parameters_within_bounds_are_recovered(far, r_inf, m, n, apart):
    """Or few points lie in the transition, or do not determine all of it: then the curve comes back."""
    true = Transition(far, r_inf, m, n)
    solid = Pair(WHEEL, RAIL, curvature_apart=apart)
    result = fit(target(EffectiveProperties(mismatch_k=true), solid))
    assert result.worst[0] < 1e-6
    in_transition = np.sum(np.hypot(X, S) < r_inf)
    if in_transition >= FEWEST and all(parameter.deviation is not None for parameter in result.parameters):
        np.testing.assert_allclose(numbers(result.effective.mismatch_k), [far, r_inf, m, n], rtol=2e-3)


def numbers(transition):
    return [transition.far, transition.r_inf, transition.m, transition.n]


@pytest.mark.parametrize("solid", [pytest.param(RAIL, marks=pytest.mark.slow), WHEEL])
def test_g_and_nu_of_one_body_are_recovered(solid):
    true = EffectiveProperties(
        G=Transition(1.6 * solid.constants.G, 18.0, 1.4, 2.2), nu=Transition(0.11, 12.0, 0.8, 3.0)
    )
    result = fit(target(true, solid, ("nn", "xx", "ss", "xs")), ("G", "nu"))
    for name in ("G", "nu"):
        got, expected = (numbers(getattr(of, name)) for of in (result.effective, true))
        np.testing.assert_allclose(got, expected, rtol=1e-4)
    assert result.covariance.shape == (8, 8)


TRUE = Transition(-0.21, 17.0, 0.9, 3.1)


def disturbed(size=0.01, seed=0):
    """A target that no parameters reproduce."""
    exact = target(EffectiveProperties(mismatch_k=TRUE))
    noise = size * np.max(np.abs(exact.ics)) * np.random.default_rng(seed).normal(size=exact.ics.shape)
    return replace(exact, ics=exact.ics + noise)


@pytest.fixture(scope="module")
def _few_starts():
    """For fits that are compared with each other; that the best minimum is found, others see."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calibration, "START_GRID", (12, 6, 6))
        patch.setattr(calibration, "STARTS", 3)
        patch.setattr(calibration, "FINALISTS", 2)
        yield


@pytest.fixture
def _all_starts(monkeypatch):
    """As many starts as there are, also after a test with few."""
    for name, value in ALL_STARTS.items():
        monkeypatch.setattr(calibration, name, value)


@pytest.fixture(scope="module")
def fitted(_few_starts):
    return fit(disturbed())


def test_least_squares_are_least(fitted):
    data = disturbed()

    def cost(transition):
        return np.sum((data.bhat_prime(EffectiveProperties(mismatch_k=transition)) - data.ics) ** 2)

    best = fitted.effective.mismatch_k
    assert cost(best) < cost(TRUE) < cost(Transition(-0.21, 17.0, 1.5, 3.1))
    for name in ("far", "r_inf", "m", "n"):
        for factor in (0.99, 1.01):
            assert cost(best) < cost(replace(best, **{name: factor * getattr(best, name)}))
    scale = np.max(np.abs(data.ics))
    assert fitted.rms[0] == pytest.approx(np.sqrt(cost(best) / data.ics.size) / scale, rel=1e-9)


def test_the_order_of_the_points_does_not_matter(fitted):
    data = disturbed()
    order = np.random.default_rng(3).permutation(len(X))
    shuffled = replace(data, x=X[order], s=S[order], ics=data.ics[:, order])
    assert fit(shuffled).effective == fitted.effective


def test_units_do_not_matter(fitted):
    """Lengths in metres, moduli in Pa: the same fit, r_inf in metres."""
    data = disturbed()
    contour = arc(0.01, 0.5, 0.6)
    rail = Solid(Material(210e9, 0.28), Surface(LOWER, contour))
    wheel = Solid(Material(97e9, 0.36), Surface(UPPER, contour, 0.3))
    patch = Patch(0.2e-3, 0.3e-3)
    in_metres = Target(
        Pair(wheel, rail), patch, X / 1e3, S / 1e3, ("xn",), data.ics / 1e9, data.weights, np.zeros(1)
    )
    np.testing.assert_allclose(
        in_metres.bhat_prime(EffectiveProperties(mismatch_k=replace(TRUE, r_inf=0.017))) * 1e9,
        data.bhat_prime(EffectiveProperties(mismatch_k=TRUE)),
        rtol=1e-10,
    )
    got, expected = (numbers(one.effective.mismatch_k) for one in (fit(in_metres), fitted))
    np.testing.assert_allclose(got * np.array([1, 1e3, 1, 1]), expected, rtol=1e-5)


@pytest.mark.usefixtures("_few_starts")
def test_points_of_weight_0_do_not_count():
    data = disturbed()
    wrong = np.arange(len(X)) % 5 == 2
    spoiled = replace(data, ics=np.where(wrong, 7.0, data.ics), weights=np.where(wrong, 0.0, 1.0))
    only = replace(data, x=X[~wrong], s=S[~wrong], ics=data.ics[:, ~wrong], weights=np.ones(np.sum(~wrong)))
    assert fit(spoiled).effective == fit(only).effective


@pytest.mark.slow
@pytest.mark.usefixtures("_all_starts")
def test_deviations_match_the_scatter_of_fits_to_noise():
    """Noise drawn again and again: parameters scatter as the covariance says."""
    result = [fit(disturbed(0.003, seed)) for seed in range(40)]
    values = np.array([[p.value for p in one.parameters] for one in result])
    told = np.array([[p.deviation for p in one.parameters] for one in result], dtype=float)
    ratio = np.std(values, axis=0) / np.median(told, axis=0)
    assert np.all((ratio > 0.6) & (ratio < 1.6))


@pytest.mark.usefixtures("_all_starts")
def test_of_parameters_only_those_are_fitted_that_the_data_determine():
    """All of a transition amid the points; only the far value beyond it; none of a constant property."""
    amid = fit(target(EffectiveProperties(mismatch_k=Transition(-0.4, 14.0, 1.6, 4.0))))
    assert all(parameter.deviation is not None for parameter in amid.parameters)
    assert amid.effective.mismatch_k.r_inf == pytest.approx(14.0, rel=1e-5)
    x = np.linspace(20.0, 60.0, 30)
    beyond = fit(target(EffectiveProperties(mismatch_k=replace(TRUE, r_inf=10.0)), x=x, s=0 * x))
    assert beyond.parameters[0].value == pytest.approx(-0.21, rel=1e-6)
    assert sum(parameter.deviation is None for parameter in beyond.parameters) >= 2
    half_space = Pair(WHEEL, RAIL).constants.mismatch_k
    constant = fit(target(EffectiveProperties(mismatch_k=Transition(half_space, 9.0, 2.0, 3.0))))
    assert [parameter.note for parameter in constant.parameters] == ["not determined by the data"] * 4
    assert constant.effective.mismatch_k == Transition(half_space, float(np.max(np.hypot(X, S))), 1.0, 1.0)
    assert constant.covariance.shape == (0, 0)
    assert (beyond.worst[0] < 1e-6, constant.worst[0] < 1e-12) == (True, True)


@pytest.mark.usefixtures("_few_starts")
def test_errors_of_the_target_widen_the_deviations():
    exact = target(EffectiveProperties(mismatch_k=TRUE))
    known = 1e-4 * np.max(np.abs(exact.ics))
    vague, vaguer = (fit(replace(exact, error=np.full_like(exact.ics, k * known))) for k in (1, 3))
    ratio = [b.deviation / a.deviation for a, b in zip(vague.parameters, vaguer.parameters, strict=True)]
    np.testing.assert_allclose(ratio, 3.0, rtol=1e-3)


def test_k_point_by_point_is_the_curve():
    data = target(EffectiveProperties(mismatch_k=TRUE))
    half_space = data.solid.constants.mismatch_k
    np.testing.assert_allclose(pointwise_k(data)[0], TRUE.at(data.r, half_space), rtol=1e-9)


def test_k_point_by_point_on_a_prismatic_pair_has_a_closed_form():
    """K = -(C_xn + A_xs sin(alpha / 2)) pi G / (J_x cos(alpha / 2)), any C_xn."""
    flat_wheel = Solid(BRASS, Surface(UPPER, CONTOUR))
    pair = Pair(flat_wheel, RAIL)
    c = np.random.default_rng(2).normal(size=(1, len(X)))
    data = Target(pair, PATCH, X, S, ("xn",), c, np.ones(len(X)), np.zeros(1))
    constants = pair.constants
    a = pair.approximate("A", PATCH, (X, S))
    j_x = -a[0, 2] * np.pi * constants.G / constants.mismatch_k
    alpha = CONTOUR.inclination(S)
    expected = -(c[0] + a[0, 1] * np.sin(alpha / 2)) * np.pi * constants.G / (j_x * np.cos(alpha / 2))
    np.testing.assert_allclose(pointwise_k(data)[0], expected, rtol=1e-10)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ics": np.full((1, len(X)), np.nan)}, "ics: 52 of 52 not finite"),
        ({"x": np.where(X > 20, np.inf, X)}, "x: 12 of 52 not finite"),
        ({"error": np.array(np.nan)}, "error: 1 of 1 not finite"),
        ({"s": S[:-1]}, "s of shape"),
        ({"error": np.ones(7)}, "error of shape"),
        ({"weights": np.arange(len(X)) < FEWEST - 1}, "weights: 7 points count; give 8 or more"),
        ({"weights": -np.ones(len(X))}, "no weight below 0"),
        ({"x": np.full(len(X), 3.0), "s": np.full(len(X), 1.6)}, "points at different distances"),
        ({"x": 3 * np.cos(np.linspace(0, 1, 52)), "s": 3 * np.sin(np.linspace(0, 1, 52))}, "different dist"),
        ({"x": np.linspace(3.0, 4.0, 52), "s": 0 * S}, "furthest 1.5 times as far"),
        ({"x": np.linspace(0.0, 4.0, 52), "s": 0 * S}, "different distances above 0"),
        ({"ics": np.zeros((1, len(X)))}, "xn: all ICs are 0"),
    ],
)
def test_bad_data_are_refused(change, message):
    with pytest.raises(WrongInput, match=message):
        replace(target(EffectiveProperties(mismatch_k=TRUE)), **change)


@pytest.mark.parametrize(
    ("components", "properties", "message"),
    [
        (("nn",), ("mismatch_k",), "nn do not depend on mismatch_k"),
        (("xn",), ("E",), "properties = E: of mismatch_k, G, nu"),
        (("xn",), (), "properties = none"),
    ],
)
def test_properties_that_cannot_be_fitted_are_refused(components, properties, message):
    flat = Pair(Solid(BRASS, Surface(UPPER, arc(1e9, 0, 0))), Solid(STEEL, Surface(LOWER, arc(1e9, 0, 0))))
    data = target(EffectiveProperties(mismatch_k=TRUE), flat, components)
    with pytest.raises(WrongInput, match=message):
        fit(data, properties)
