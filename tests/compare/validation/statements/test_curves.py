"""Components along lines, their errors and panels, on hand-made curves; cases of criteria."""

from types import SimpleNamespace

import numpy as np
import pytest

from compare.validation.statements import curves
from compare.validation.statements.curves import ACROSS, CONCAVE, CONVEX, THROUGH, Curve, find_line
from compare.validation.statements.runs import GEOMETRIES
from geometries.patches import N, X
from tests.compare.validation.statements.handmade import Runs, made, times, with_c, without_c

FIRST, SECOND = GEOMETRIES


def test_errors_are_largest_on_the_lines_of_a_curve():
    def c(of):
        out = of.a.copy()
        out[N, N] += np.where(of.points.x == 1.6, 1e-6, 0)
        return out

    results = made(FIRST, c)
    errors = {on: Curve(results, "lower", "nn", on).error("A") for on in (THROUGH, "x", ACROSS, "s", None)}
    assert errors[THROUGH] == errors["x"] == 0
    assert errors[ACROSS] == errors["s"] == errors[None] > 0
    with pytest.raises(ValueError, match="empty"):
        Curve(results, "lower", "nn", "nowhere").error("A")


def test_the_peak_of_one_line_is_not_the_scale_of_another():
    """C_xx is 0.8 of A_xx on the line along s only: a quarter of C there.

    As an error, a fifth of A_xx there over the largest C_xx four elements away, on another line.
    """
    results = made(FIRST, times("A", (X, X), lambda of: np.where(of.on(ACROSS), 0.8, 1)))
    across = Curve(results, "lower", "xx", ACROSS)
    assert across.share("A") == pytest.approx(0.25)
    a = np.abs(Curve(results, "lower", "xx").variant("A"))
    far = np.hypot(results.points.x, results.points.s) >= 1.6
    on_line = results.lines[ACROSS]
    largest = np.max(np.where(np.arange(len(a)) < on_line.start, a, 0.8 * a)[far])
    expected = 0.2 * np.max(a[on_line]) / largest
    assert across.error("A") == pytest.approx(expected)
    assert expected < 0.25


def test_a_panel_can_begin_away_from_the_load():
    results = made(FIRST, times("A", None, 1))
    curve = Curve(results, "lower", "nn", THROUGH)
    for beyond in (0.0, 1.0):
        c, a = curve.panel("A", beyond=beyond).curves
        x, values = c.points
        assert (x[0], x[-1]) == (pytest.approx(beyond, abs=0.05), pytest.approx(2.5))
        np.testing.assert_array_equal(values, curve.variant("C")[-len(x) :])
        assert np.shape(c.band) == x.shape == a.points[0].shape


def test_without_curvature_along_x_a_wheel_is_its_section():
    results = made(SECOND, times("A", None, 1))
    rail, same = curves.prismatic_ics(results, "Bhat", CONVEX), results.approximations["Bhat", CONVEX]
    np.testing.assert_allclose(rail, same, rtol=0, atol=1e-15 * np.max(rail))
    through = results.lines[THROUGH]
    wheel = curves.prismatic_ics(results, "Bhat", CONCAVE)[..., through]
    np.testing.assert_array_equal(wheel, results.approximations["A", CONCAVE][..., through])  # alpha is 0
    both = curves.prismatic_ics(results, "Bhat", "combined")
    parts = [curves.prismatic_ics(results, "Bhat", body) for body in (CONVEX, CONCAVE)]
    np.testing.assert_allclose(both, sum(parts), rtol=0, atol=1e-15 * np.max(both))


# --- places, units, cases -------------------------------------------------------------------------------


def linear_in(of):
    """C 2e-6 + 1e-7 x mm/N off the line along s, 3e-6 - 1e-7 s on it: linear along every line."""
    return np.where(of.on(ACROSS), 3e-6 - 1e-7 * of.points.s, 2e-6 + 1e-7 * of.points.x) + 0 * of.a


def test_a_value_at_a_place_lies_between_the_points_along_the_line():
    """Dimensionless: times E = 210 GPa of the lower body and the reference length of 10 mm."""
    results = with_c(without_c(FIRST, upper_E=70e3), linear_in)
    assert curves.unit(results) == pytest.approx(2.1e6)
    places = ((THROUGH, 10.03, 3.003e-6), (THROUGH, -7.0, 1.3e-6), (ACROSS, 4.21, 2.579e-6))
    for line, coordinate, value in places:
        assert Curve(results, CONVEX, "sn", line).at("C", coordinate) == pytest.approx(2.1e6 * value)
    both = Curve(results, "combined", "sn", THROUGH).at("C", 0.0)
    assert both == pytest.approx(2.1e6 * 4e-6)


def test_sizes_count_whatever_their_sign():
    """C is 1.6 of A: A misses 3/8 of C, by 0.6 A."""
    results = made(FIRST, times("A", (N, N), 1.6))
    everywhere, across = (Curve(results, "lower", "nn", on) for on in (None, ACROSS))
    assert across.relative("A", 5.0) == pytest.approx(3 / 8)
    assert everywhere.error("A") == pytest.approx(3 / 8)
    assert across.share("A") == pytest.approx(3 / 8)
    assert everywhere.largest("A") == pytest.approx(0.6 * np.max(np.abs(everywhere.variant("A"))))
    assert curves.rms(np.array([3.0, -4.0, 0.0, 0.0])) == 2.5


def test_a_panel_is_dimensionless_in_both_directions():
    """Lengths over 10 mm, ICs and estimates times E L; one side of the load."""
    results = made(FIRST, linear_in, estimate=0.01)
    line = find_line(results, ACROSS)
    more = {"other": np.arange(len(line.s), dtype=float)}
    panel = Curve(results, CONCAVE, "sn", ACROSS).panel("A", more=more)
    shown = {curve.label: curve for curve in panel.curves}
    assert set(shown) == {"C", "A", "other"}
    at, c = shown["C"].points
    assert (at[0], at[-1]) == (0, pytest.approx(2.5))
    np.testing.assert_allclose(c, 2.1e6 * (3e-6 - 1e-6 * at), rtol=1e-12)
    np.testing.assert_array_equal(shown["other"].points[1], more["other"][line.s >= 0])
    largest_nn = np.max(np.abs(Curve(results, CONCAVE, "nn").variant("A")))
    np.testing.assert_allclose(shown["C"].band, 0.01 * largest_nn, rtol=1e-12)
    assert shown["A"].band is None


def test_cases_are_named_by_geometry_body_and_component():
    runs = Runs({FIRST: 1.0, SECOND: 10.0})
    tenths = {"lower": 0.1, "upper": 0.2, "combined": 0.3}
    per_body = curves.per_body(lambda results, body: results + tenths[body])(runs)
    assert per_body == {f"{g}, {b}": n + t for g, n in runs.geometries.items() for b, t in tenths.items()}
    alone = curves.per_geometry(lambda results, _: results, curves.ALONE)(runs)
    assert list(alone) == [f"{g}, {b}" for g in GEOMETRIES for b in (CONVEX, CONCAVE)]
    of_components = curves.per_geometry(lambda r, b, c: r + tenths[b] + len(c), tenths, ("nn", "sn"))(runs)
    assert len(of_components) == 12
    assert of_components["geometry2, upper, sn"] == 12.2
    assert curves.second_minus_first(lambda results: results**2)(runs) == {"both": 99.0}
    assert curves.side_by_side(lambda results: [results, -results])(runs) == [1, 10, -1, -10]
    plain_and_fitted = SimpleNamespace(geometry=lambda _: "plain", fitted=lambda _: "fitted")
    for by_fit, kind in ({}, "plain"), ({"fitted": True}, "fitted"):
        measure = curves.per_geometry(lambda results: results, **by_fit)
        assert set(measure(plain_and_fitted).values()) == {kind}
