"""The measures of `femic validate` on hand-made curves, whose numbers are known."""

from dataclasses import dataclass

import numpy as np
import pytest

from compare.pipeline import Results, approximated, scene_points
from compare.scenes.load import load_scene
from compare.validation import coupling, direct, program
from compare.validation.curves import CONCAVE, CONVEX, error
from compare.validation.runs import GEOMETRIES, NINE
from femic.models import Points
from femic.reference import Estimated, Reference

X, S, N = range(3)


@dataclass
class Of:
    """What a hand-made C is made of: a body, its A and B-hat [mm/N], and the points."""

    body: str
    a: np.ndarray
    b_hat: np.ndarray
    points: Points


def made(name, c, *, effective=None):
    """Results of a geometry whose C of a body is `c` of what it may be made of."""
    variants = ["A", "B", "Bbar", "Bhat", "mix"]
    asked = {"components": list(NINE), "variants": variants, "engine": {"check": False}}
    scene = load_scene(name, asked | (effective or {}))
    points, lines = scene_points(scene)
    approximations, seconds = approximated(scene, points)
    references = {}
    for body in ("lower", "upper"):
        ic = c(Of(body, approximations["A", body], approximations["Bhat", body], points))
        zero = np.zeros_like(ic)
        known = Estimated(ic, zero, zero, zero)
        references[body] = Reference(known, ic, np.zeros((4, 4)), None, None, scene.bodies[body], {})
    return Results(scene, points, lines, references, {}, approximations, seconds)


@dataclass
class Made:
    """What statements ask for, hand-made."""

    results: dict
    flat_wheel: Results | None = None

    def geometry(self, name):
        return self.results[name]

    fitted = geometry
    other_nu = geometry

    def not_revolved(self):
        return self.flat_wheel


def of_both(c):
    return Made({name: made(name, c) for name in GEOMETRIES})


def test_a_c_that_is_a_follows_a_and_not_b_hat():
    runs = of_both(lambda of: of.a)
    values = direct.nn_follows(runs).values
    assert set(values["A lateral"].values()) == set(values["A along x"].values()) == {0.0}
    assert all(value > 0 for value in values["B lateral"].values())
    assert set(direct.xx_is_alike(runs).values["A"].values()) == {0.0}
    assert set(coupling.xn_without_fit(runs).values["A"].values()) == {0.0}


def test_how_much_faster_ss_falls():
    """C_ss is a share of A_ss beyond the load: 0.7 of the convex, 0.9 of the concave body."""
    shares = {CONVEX: 0.7, CONCAVE: 0.9}

    def c(of):
        out = of.a.copy()
        out[S, S] *= np.where(np.hypot(of.points.x, of.points.s) > 2, shares[of.body], 1)
        return out

    values = direct.ss_falls_faster(of_both(c)).values
    assert values["faster"]["geometry1, lower"] == pytest.approx(0.3)
    assert values["faster"]["geometry1, upper"] == pytest.approx(0.1)
    assert values["faster"]["geometry1, combined"] == pytest.approx(0.2)
    assert values["geometry"]["both"] == pytest.approx(0, abs=0.01)  # B of a wheel turns along x
    assert values["convex"]["geometry2"] == pytest.approx(0.2, abs=0.01)


def test_deviations_cancel_or_add():
    """Opposite ones of equal size cancel, alike ones add; one three times the other, opposite: a half."""

    def c(of):
        bump = np.exp(-(of.points.x**2) - of.points.s**2)
        sign = 1 if of.body == CONVEX else -1
        out = of.a + sign * bump
        out[X, X] += 2 * bump * (of.body == CONVEX)
        out[S, N] = of.a[S, N] + bump
        return out

    measured = direct.bodies_cancel_or_add(of_both(c)).values
    assert measured["cancel"]["geometry1, nn"] == pytest.approx(0, abs=1e-9)
    assert measured["cancel"]["geometry1, xx"] == pytest.approx(0.5)
    assert measured["add"]["geometry1, sn"] == pytest.approx(1)


def test_which_body_has_the_larger_xn():
    def c(of):
        out = of.a.copy()
        out[X, N] *= 3 if of.body == CONVEX else 1
        return out

    measured = coupling.xn_of_bodies(of_both(c)).values
    assert measured["in C"] == pytest.approx(dict.fromkeys(measured["in C"], 3.0), rel=1e-9)
    assert len(measured["in B"]) == 4
    assert measured["in B"]["geometry1, s = 0 mm"] == pytest.approx(1)  # there B is A
    assert measured["in B"]["geometry1, s = 1.6 mm"] > 1


def test_what_curvature_explains():
    """C_xn 1 on Geometry 1, 3 on Geometry 2, 2.5 if its wheel is not revolved: a quarter."""

    def times(factor):
        def c(of):
            out = of.a.copy()
            out[X, N] = factor * np.tanh(of.points.x)
            return out

        return c

    results = {name: made(name, times(factor)) for name, factor in zip(GEOMETRIES, (1, 3), strict=True)}
    runs = Made(results, made("geometry2", times(2.5)))
    measured = coupling.xn_of_geometries(runs).values
    assert measured["larger"]["both"] == pytest.approx(3)
    assert measured["curvature"]["both"] == pytest.approx(0.25)


FIT = {"combined": {"mismatch_k": {"far": 0.1, "r_inf": 20.0, "m": 1.0, "n": 2.0}}}


def test_sn_below_above_and_a_translation():
    """C_sn: half of A on the convex body, one and a half on the concave one; B-hat plus a translation."""

    def half(of):
        out = of.a.copy()
        out[S, N] *= 0.5 if of.body == CONVEX else 1.5
        return out

    r = made("geometry1", half)
    below, above = (coupling._above_a(r, body) for body in (CONVEX, CONCAVE))
    assert above == pytest.approx(-below)
    a = r.approximations["A", CONVEX][S, N][r.lines["x = 1.6 mm"]]
    s = r.points.s[r.lines["x = 1.6 mm"]]
    assert below == pytest.approx(-0.5 * np.mean(np.abs(a[s > 0])) / np.max(np.abs(a)))

    def lifted(of):
        out = of.b_hat.copy()
        out[S, N] -= 1e-6 * np.sin(r.scene.bodies["lower"].contour.inclination(of.points.s))
        return out

    assert coupling._translation(made("geometry1", lifted)) == pytest.approx(1)

    def bumped(of):
        out, joint = of.b_hat.copy(), r.scene.bodies["lower"].contour.joints[-1]
        out[S, N] += 1e-6 * np.exp(-20 * (np.abs(of.points.s) - 2 * joint) ** 2)
        return out

    assert coupling._furthest_misfit(made("geometry1", bumped)) == pytest.approx(2, abs=0.03)


def with_xn(values):
    """A, but xn of each body is given."""

    def c(of):
        out = of.a.copy()
        out[X, N] = values
        return out

    return c


def test_a_fit_that_is_too_large_near_the_load():
    """C_xn is B-hat-prime less a tenth of its maximum near the load, with its sign."""
    scene = {"effective": FIT, "variants": ["A", "B", "Bhat", "Bhat_prime", "mix"]}
    fitted = {}
    for name in GEOMETRIES:
        exact = made(name, lambda of: of.a, effective=scene)
        prime = exact.approximations["Bhat_prime", "combined"][X, N]
        near = np.hypot(exact.points.x, exact.points.s) < 4
        line_max = np.max(np.abs(prime))

        smaller = (prime - 0.1 * line_max * near * np.sign(prime)) / 2
        fitted[name] = made(name, with_xn(smaller), effective=scene)
    values = coupling.xn_of_fit(Made(fitted)).values
    assert all(value > 0.03 for value in values["too large"].values())
    assert values["geometry"]["both"] == pytest.approx(
        values["too large"]["geometry1"] - values["too large"]["geometry2"]
    )


def test_a_factor_that_is_right_is_a_gain():
    """C is B with the factor: it gains on B in every case, and the share counts that."""
    scene = made("geometry1", lambda of: of.a)
    with_factor = {body: coupling._with_factor(scene, "B", body) for body in (CONVEX, CONCAVE)}
    truth = {
        name: made(
            name,
            lambda of, name=name: coupling._with_factor(made(name, lambda of: of.a), "B", of.body),
        )
        for name in GEOMETRIES
    }
    measured = coupling.factor_of_the_cylinder(Made(truth))
    ratios = [value for case, value in measured.details.items() if case.endswith(", B")]
    np.testing.assert_allclose(ratios, 0, atol=1e-9)
    assert measured.values["gain"]["all"] >= 0.5
    assert not np.allclose(with_factor[CONVEX][S, N], scene.approximations["B", CONVEX][S, N])


def test_the_mix_is_measured_against_the_best_single_variant():
    runs = of_both(lambda of: 1.01 * of.b_hat)
    measured = program.mix_is_best(runs)
    assert measured.values["mean"]["geometry1, lower"] > 2  # B-hat is almost exact, the mix is not
    assert 0.001 < measured.details["mean error of B̂: geometry1, lower"] <= 0.01


def test_change_with_nu_is_a_share_of_the_first():
    one = of_both(lambda of: of.a)
    other = {name: made(name, lambda of: 1.03 * of.a) for name in GEOMETRIES}
    one.other_nu = other.__getitem__
    change = program.nu_matters(one).values["change"]
    assert change["geometry1, lower, nn"] == pytest.approx(0.03)


def test_errors_are_over_the_lines_asked_for():
    def c(of):
        out = of.a.copy()
        out[N, N] += np.where(of.points.x == 1.6, 1e-6, 0)
        return out

    results = made("geometry1", c)
    by_name = {line.name: [line] for line in results.scene.lines}
    assert error(results, "A", "lower", "nn", by_name["s = 0 mm"]) == 0
    assert error(results, "A", "lower", "nn", by_name["x = 1.6 mm"]) > 0
    with pytest.raises(ValueError, match="empty"):
        error(results, "A", "lower", "nn", [])
