"""The analytic cases of `femic extremes`: their places and ranges, and formulas in many digits by hand."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from compare.validation.extremes import analytic
from compare.validation.extremes.analytic import HalfSpaces, RotatedElements
from geometries.surfaces import LOWER, UPPER

ROUNDING = 5e-15  # some twenty roundings


def test_places_are_in_half_sides_of_the_patch_and_bodies_are_unlike(monkeypatch):
    """b = 2 mm, a = 6 mm: at half of a and twice b; the upper body has half the ratio and its own E."""
    places, bodies = [], []
    integrals, one_body = analytic.exact_integrals, analytic.one_body
    monkeypatch.setattr(analytic, "exact_integrals", lambda *of: places.append(of) or integrals(*of))
    monkeypatch.setattr(analytic, "one_body", lambda *of: bodies.append(of[:2]) or one_body(*of))
    assert HalfSpaces(nu=0.4, size=2.0, aspect=3.0, x=0.5, s=-2.0, ratio=10.0).error() < 1e-14
    ((patch, x, s),) = places
    assert (patch.a, patch.b, x, s) == (6.0, 2.0, 3.0, -4.0)
    of_both = [(material.E, material.nu, side) for material, side in bodies]
    assert of_both == [(2.1e6, 0.2, UPPER), (210e3, 0.4, LOWER)]


VALUES = {  # of a case, and the range that is tried, for the name of a parameter
    "ν": (lambda case: case.nu, (0.0, 0.5)),
    "patch aspect a/b": (lambda case: case.aspect, (1e-6, 1e6)),
    "distance / patch": (lambda case: np.hypot(case.x, case.s), (0.0, np.sqrt(2) * 1e10)),
    "flank inclination": (lambda case: case.flank, (0.0, 89.9)),
    "R_roll": (lambda case: case.rolling_radius, (25.0, np.inf)),
    "modulus ratio": (lambda case: case.ratio, (1e-6, 1e6)),
}


@pytest.fixture(scope="module")
def cases():
    """The cases whose error is computed, corners and drawn ones, by parameter."""
    computed, by_name = [], {}
    with pytest.MonkeyPatch.context() as patch:
        for kind in (HalfSpaces, RotatedElements):
            patch.setattr(kind, "error", lambda self: computed.append(self) or 0.0)
        for row in analytic.limits():
            by_name[row.name] = []
            for reached in row.reached:
                computed.clear()
                assert re.fullmatch(r"\d+ (corners|drawn)", reached(None).at)
                by_name[row.name].append(list(computed))
    return by_name


def test_corners_are_the_ends_of_the_ranges_and_drawn_cases_lie_between(cases):
    assert list(cases) == list(VALUES)
    for name, (value, (low, high)) in VALUES.items():
        corners, drawn = ([value(case) for case in some] for some in cases[name])
        assert max(corners) == pytest.approx(high)
        if name != "flank inclination":  # flat is no corner
            assert min(corners) == pytest.approx(low)
        assert len(drawn) == 150
        assert low <= min(drawn) < max(drawn) <= high
        assert len(set(drawn)) > 20


def test_places_at_corners_are_on_edges_and_axes_and_next_to_them(cases):
    by_aspect = cases["patch aspect a/b"][0]
    assert [case.x for case in by_aspect] == [0.0, 1.0, 1 + 1e-12] * 2
    assert {(case.x, case.s) for case in cases["distance / patch"][0]} == {
        (x, s) for x in (0.0, 1.0, 1e10) for s in (0.0, 1.0, 1e10)
    }


def test_places_are_drawn_on_either_side_of_both_axes(cases):
    for name in ("ν", "patch aspect a/b", "distance / patch", "modulus ratio"):
        quadrants = {(case.x > 0, case.s > 0) for case in cases[name][1]}
        assert len(quadrants) == 4, name
    flanks, wheels = cases["flank inclination"][1], cases["R_roll"][1]
    assert {case.side for case in flanks} == {UPPER, LOWER}
    assert {case.rolling_radius for case in flanks} == {np.inf}
    assert {case.side for case in wheels} == {UPPER}
    assert max(case.rolling_radius for case in wheels) > 1e9


def test_vanishing_components_must_be_0():
    assert analytic._relative(0.0, [analytic.mpmath.mpf(0)] * 2) == 0
    assert analytic._relative(1e-300, [analytic.mpmath.mpf(0)] * 2) == np.inf
    halves = [analytic.mpmath.mpf(3), analytic.mpmath.mpf(-1)]
    assert analytic._relative(2.4, halves) == pytest.approx(0.1)  # 0.4 of 3 + 1


def test_the_worst_of_several_cases_has_their_mean_seconds():
    cases = [SimpleNamespace(error=lambda value=value: value) for value in (1.0, 3.0, 2.0)]
    worst = analytic._worst("three", cases)
    assert (worst.at, worst.error, worst.estimate, worst.exact) == ("three", 3.0, None, "300 digits")
    assert 0 <= worst.seconds < 0.1


def test_distances_are_drawn_by_decades():
    case = analytic._at_distance(3.0, 2.0)
    assert np.hypot(case.x, case.s) == pytest.approx(1000)
    assert np.arctan2(case.s, case.x) == pytest.approx(2.0)
    assert [analytic._or_zero(v) for v in (1e-61, -1e-61, 1e-59, -2.0)] == [0, 0, 1e-59, -2.0]


@pytest.mark.parametrize("side", [UPPER, LOWER])
def test_rotations_in_many_digits_are_products_of_rotations(side):
    """R_x(a) R_y(0) R_x(-b) is R_x(a - b); of a quarter turn about y, x goes to -side z."""
    about_x = np.array(analytic.rotation(0.7, 0.3, 0.0, side).tolist(), dtype=float)
    c, s = np.cos(0.4), np.sin(0.4)
    np.testing.assert_allclose(about_x, [[1, 0, 0], [0, c, -s], [0, s, c]], atol=1e-15)
    quarter = np.array(analytic.rotation(0.0, 0.0, np.pi / 2, side).tolist(), dtype=float)
    np.testing.assert_allclose(quarter, [[0, 0, side], [0, 1, 0], [-side, 0, 0]], atol=1e-15)


@pytest.mark.parametrize("side", [UPPER, LOWER])
def test_a_in_many_digits_agrees_with_a_point_load(side):
    """2 pi G u of integrals that are those of a unit load at x = 3, s = 4: by hand, with nu = 0.3."""
    material = analytic.Material(2.6, 0.3)  # G = 1
    r = 5.0
    integrals = [9 / r**3, 16 / r**3, 12 / r**3, 3 / r**2, 4 / r**2]
    a = 2 * np.pi * np.array(analytic.one_body(material, side, integrals), dtype=float)
    expected = [
        [0.7 / r + 0.3 * 9 / r**3, 0.3 * 12 / r**3, -side * 0.2 * 3 / r**2],
        [0.3 * 12 / r**3, 0.7 / r + 0.3 * 16 / r**3, -side * 0.2 * 4 / r**2],
        [side * 0.2 * 3 / r**2, side * 0.2 * 4 / r**2, 0.7 / r],
    ]
    np.testing.assert_allclose(a, expected, rtol=1e-14)


@pytest.mark.parametrize(
    "case",
    [
        *(HalfSpaces(nu=0.5), HalfSpaces(aspect=3.0), HalfSpaces(ratio=20.0), HalfSpaces(size=2.0)),
        HalfSpaces(x=1e8, s=-3e8),
    ],
)
def test_a_wrong_digit_is_detected_in_any_case(case, monkeypatch):
    assert case.error() < ROUNDING
    right = analytic.Pair.approximate
    monkeypatch.setattr(analytic.Pair, "approximate", lambda *of: right(*of) * (1 + 1e-13))
    assert case.error() == pytest.approx(1e-13, rel=0.1)


@pytest.mark.parametrize("radius", [np.inf, 400.0])
@pytest.mark.parametrize("side", [UPPER, LOWER])
def test_rotations_of_surfaces_are_right_to_all_digits_and_wrong_ones_are_detected(side, radius, monkeypatch):
    case = RotatedElements(30.0, radius, side=side)
    assert case.error() < 1e-14
    right = analytic.rotation
    monkeypatch.setattr(analytic, "rotation", lambda i, j, theta, side: right(i + 1e-6, j, theta, side))
    assert 1e-7 < case.error() < 1.001e-6
