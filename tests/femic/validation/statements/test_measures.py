"""The measures of statements about ICs on hand-made curves, whose numbers are known."""

from dataclasses import replace

import numpy as np
import pytest

from femic.validation.statements import bodies, choices, curvature, curves, nn, sn, tangential, xn
from femic.validation.statements.curves import ACROSS, CONCAVE, CONVEX, INDEPENDENT, THROUGH, Curve
from femic.validation.statements.runs import GEOMETRIES
from geometries.patches import N, S, X
from tests.femic.validation.statements.handmade import (
    Runs,
    between,
    by_body,
    by_geometry,
    made,
    runs_of,
    times,
    with_c,
)

FIRST, SECOND = GEOMETRIES


# --- 1, 16: nn ------------------------------------------------------------------------------------------


def test_how_much_better_b_is():
    """A quarter of the way from B to A: a third of A's distance."""
    results = made(SECOND, between("B", "A", 0.25))
    assert nn.b_over_a(results) == pytest.approx(1 / 3)
    wrong = made(FIRST, times("A", (N, N), lambda of: np.where(of.on(ACROSS), 1.5, 1.25)))
    ratio = curves.across_over_along("nn")(wrong, "combined")
    a = Curve(wrong, "combined", "nn").variant("A")
    across, along = (np.max(np.abs(a[wrong.lines[name]])) for name in (ACROSS, THROUGH))
    assert ratio == pytest.approx(2 * across / along)


def test_what_a_misses_grows_with_the_distance():
    """C_nn is A / (1 + s / 50): A misses s / 50 of it, 0.2 at 10 mm, 0.1 at 5 mm."""
    results = made(FIRST, times("A", (N, N), lambda of: 1 / (1 + np.abs(of.points.s) / 50)))
    assert nn.relative_error_across("A")(results) == pytest.approx(0.2, rel=0.01)
    assert nn.growth_with_distance(results) == pytest.approx(0.1, rel=0.01)


# --- 3, 4: ss, xs ---------------------------------------------------------------------------------------


def test_how_much_faster_ss_falls():
    """C_ss is a share of A_ss beyond the load: 0.7 of the convex, 0.9 of the concave body."""

    def share(of):
        return np.where(np.hypot(of.points.x, of.points.s) > 2, by_body(0.7, 0.9)(of), 1)

    runs = runs_of(times("A", (S, S), share))
    first = runs.geometry(FIRST)
    assert [tangential.deficit(first, body) for body in curves.BODIES] == pytest.approx([0.2, 0.3, 0.1])
    assert tangential.convex_less_concave(runs)[SECOND] == pytest.approx(0.2, abs=0.01)  # a wheel's B turns


def test_absolute_deviations_of_xs_are_compared():
    """C_xs is 1.3 and 1.1 times A_xs: 3 times as far; as shares of C it would be 2.5 times."""
    runs = runs_of(times("A", (X, S), by_body(1.3, 1.1)))
    assert tangential.convex_over_concave(runs.geometry(FIRST)) == pytest.approx(3)
    exchanged = runs_of(times("A", (X, S), by_body(1.1, 1.3)))
    assert tangential.convex_over_concave(exchanged.geometry(FIRST)) == pytest.approx(1 / 3)
    assert tangential.sizes_in_xs(runs)[f"largest |C_xs - A_xs| E L: {FIRST}, {CONVEX}"] > 0


# --- 5, 17 to 19: bodies --------------------------------------------------------------------------------


def test_deviations_cancel_or_add():
    """Opposite ones of equal size cancel, alike ones add; one three times the other, opposite: a half."""

    def c(of):
        sign = by_body(1, -1)(of)
        out = of.a + sign * of.bump
        out[X, X] += 2 * of.bump * (of.body == CONVEX)
        out[S, N] = of.a[S, N] + of.bump
        return out

    results = made(FIRST, c)
    kept = [bodies.remaining_share(results, component) for component in ("nn", "xx", "sn")]
    assert kept == pytest.approx([0, 0.5, 1], abs=1e-9)
    assert bodies.alignment_in_ss(results, "along x") == pytest.approx(-1)
    assert bodies.alignment_in_ss(made(FIRST, lambda of: of.a + of.bump), "along s") == pytest.approx(1)


def test_distance_from_the_half_space_near_the_load_and_far():
    """C is off by a share of A_nn, 0.04 times the distance in mm: 0.04 at 1 mm, 0.1 at 2.5, 0.8 at 20 mm."""

    def c(of):
        return of.a + 0.04 * np.hypot(of.points.x, of.points.s) * of.a[N, N]

    results = made(FIRST, c)
    r = np.hypot(results.points.x, results.points.s)
    assert bodies.deviation_at_load(results, CONVEX, "xn") == pytest.approx(0.04, rel=0.1)
    near, far = np.max(r[r <= 2.5]), np.max(r[r <= 20])
    assert bodies.near_over_far(results, CONVEX, "sn") == pytest.approx(near / far)


def test_rotations_are_those_of_the_discount():
    results = made(FIRST, times("A", None, 1), rotation={CONVEX: -3e-9, CONCAVE: 1e-9})
    assert bodies.convex_share(results) == pytest.approx(0.75)
    assert bodies.rotation(results, CONVEX) == -3e-9


# --- 6 to 8, 13, 21: xn ---------------------------------------------------------------------------------


def test_which_body_has_the_larger_xn():
    results = made(FIRST, times("A", (X, N), by_body(3, 1)))
    assert xn.convex_over_concave_c(results) == pytest.approx(3)
    line = results.lines["s = 1.6 mm"]
    for variant in ("B", "Bhat"):  # prismatic: the variant itself
        sizes = [curves.rms(results.approximations[variant, b][X, N, line]) for b in (CONCAVE, CONVEX)]
        assert xn.concave_over_convex(variant)(results) == pytest.approx(sizes[0] / sizes[1])
    assert xn.concave_over_convex("B")(made(SECOND, times("A", None, 1))) > 1


def test_a_fit_that_is_too_large_near_the_load():
    """C_xn is B-hat-prime less a tenth of its largest near the load, with its sign."""

    def smaller(of):
        fit = of.half_by("Bhat_prime").copy()
        size = np.max(np.abs(of.results.approximations["Bhat_prime", "combined"][X, N])) / 2
        near = np.abs(of.points.x) < 4
        fit[X, N] -= 0.1 * size * near * np.tanh(1e6 * of.points.x) * np.sign(fit[X, N] * of.points.x)
        return fit

    results = made(FIRST, smaller, fitted=True)
    assert xn.excess(results) == pytest.approx(0.1, rel=0.35)
    exact = made(FIRST, lambda of: of.half_by("Bhat_prime"), fitted=True)
    assert xn.excess(exact) == pytest.approx(0, abs=1e-12)
    assert Curve(exact, *xn.XN, "x").error("Bhat_prime") == pytest.approx(0, abs=1e-12)


def test_what_curvature_explains():
    """C_xn 1 on Geometry 1, 3 on Geometry 2, 2.5 if its wheel is not revolved: a quarter."""

    def factor(size):
        return lambda of: np.full_like(of.a, size(of)) * np.tanh(of.points.x)

    runs = replace(runs_of(factor(by_geometry(1, 3))), prismatic=made(SECOND, factor(by_geometry(0, 2.5))))
    assert curvature.second_over_first(runs)["both"] == pytest.approx(3)
    assert curvature.curvature_share(runs)["both"] == pytest.approx(0.25)


def test_the_term_of_curvature_has_its_sign():
    """On s = 0 it is what B-hat of the revolved wheel has more than that of its section, to (x / R)^2."""
    wheel = made(SECOND, times("A", None, 1))
    line = wheel.lines[THROUGH]
    more = wheel.approximations["Bhat", CONCAVE] - curves.not_revolved(wheel, "Bhat", CONCAVE)
    term = curvature._term(Runs({SECOND: wheel}))
    x = np.abs(wheel.points.x[line])
    expected = curves.unit(wheel) * more[X, N, line]
    np.testing.assert_allclose(term[x > 1], expected[x > 1], rtol=0.01)


def test_what_is_closer_to_c_has_the_smaller_error():
    """C is a quarter of the way from A to the prismatic B-hat: A is a third as far off."""
    results = made(SECOND, lambda of: 0.75 * of.a + 0.25 * of.prismatic("Bhat"))
    for body in curves.BODIES:
        assert xn.a_over("Bhat")(results, body) == pytest.approx(1 / 3)
    errors = xn.xn_errors(Runs(dict.fromkeys(GEOMETRIES, results)))
    of_a, of_b_hat = (errors[f"error of {v}: {SECOND}, {CONCAVE}"] for v in ("A", "B̂, not revolved"))
    assert of_a == pytest.approx(of_b_hat / 3)


# --- 9, 10: sn ------------------------------------------------------------------------------------------


def test_sn_below_above_and_a_translation():
    """C_sn: half of A on the convex body, one and a half on the concave one; B-hat plus a translation."""
    results = made(FIRST, times("A", (S, N), by_body(0.5, 1.5)))
    below, above = (sn.mean_deviation_from_a(results, body) for body in (CONVEX, CONCAVE))
    assert above == pytest.approx(-below)
    part = results.lines[ACROSS]
    a, s = results.approximations["A", CONVEX][S, N][part], results.points.s[part]
    assert below == pytest.approx(-0.5 * np.mean(np.abs(a[s > 0])) / np.max(np.abs(a)))

    def lifted(of):
        out = of.by("Bhat").copy()
        lean = np.sin(of.results.scene.bodies[CONVEX].contour.inclination(of.points.s))
        out[S, N] += 1e-6 * (lean + 0.5 * np.cos(of.points.s))  # the second one is even: no translation
        return out

    lifted_results = made(FIRST, lifted)
    lean = np.sin(lifted_results.scene.bodies[CONVEX].contour.inclination(s))
    even = 0.5 * np.cos(s)
    assert sn.translation(lifted_results) == pytest.approx(lean @ lean / (lean @ lean + even @ even))


def test_sn_within_the_arc_is_judged_there():
    """Off beyond the joint only: nothing. Off by 1.2 times within: the same share of the largest."""

    def off(inside):
        def c(of):
            out = of.by("B").copy()
            joint = of.results.scene.bodies[CONVEX].contour.joints[-1]
            out[S, N] *= np.where((np.abs(of.points.s) <= joint) == inside, 1.2, 1)
            return out

        return made(FIRST, c)

    assert sn.within_arc(off(inside=False), "B") < 1e-15
    assert 0.05 < sn.within_arc(off(inside=True), "B") <= 0.2 / 1.2


def test_a_factor_that_is_right_is_a_gain():
    """C is B with the factor: without it something is missed, with it nothing."""

    def c(of):
        return sn.with_factor(with_c(of.results, lambda of: of.a), "B", of.body)

    runs = runs_of(c)
    ratios = sn.errors_with_factor(runs)
    np.testing.assert_allclose([v for case, v in ratios.items() if case.endswith(", B")], 0, atol=1e-9)
    assert sn.gain_share(runs)["all"] == np.mean([v <= 0.9 for v in ratios.values()])


@pytest.mark.parametrize("sign", [1, -1])
def test_the_largest_misfit_counts_whatever_its_sign(sign):
    """B-hat less or more by a bump at s = 7.5 mm."""

    def c(of):
        out = of.by("Bhat").copy()
        out[S, N] += sign * 1e-6 * np.exp(-((of.points.s - 7.5) ** 2)) * of.on(ACROSS)
        return out

    joint = 10 * np.radians(25.5)
    assert sn.furthest_misfit(made(FIRST, c)) == pytest.approx(7.5 / joint, rel=0.01)
    runs = runs_of(c)
    (flank,) = (criterion for criterion in sn.STATEMENTS[0].criteria if criterion.name == "flank")
    assert flank.measure(runs) == {FIRST: sn.furthest_misfit(runs.geometry(FIRST))}


# --- 11, 12: choices ------------------------------------------------------------------------------------


def test_nu_changes_errors_not_c():
    """C and all variants 3 % larger: C changes, the errors do not."""
    one = made(FIRST, between("A", "B", 0.3))
    larger = {key: 1.03 * ic for key, ic in one.approximations.items()}
    other = with_c(replace(one, approximations=larger), between("A", "B", 0.3))
    assert choices.error_change(one, other, CONVEX, "sn") == pytest.approx(0, abs=1e-12)
    assert choices.regret(one, other, CONVEX, "sn") == pytest.approx(0, abs=1e-12)
    of_b = made(FIRST, between("A", "B", 1.0))
    assert choices.regret(one, of_b, CONVEX, "sn") == pytest.approx(Curve(of_b, CONVEX, "sn").error("A"))


def test_the_mix_is_measured_by_its_worst_and_its_mean_component():
    """C is the mix, but C_nn is 0.8 of it and C_xx 0.9: errors of the mix are 1/4 and 1/9, else 0."""

    def c(of):
        out = of.by("mix").copy()
        out[N, N] *= 0.8
        out[X, X] *= 0.9
        return out

    results = made(FIRST, c)
    singles = [[Curve(results, CONVEX, i).error(v) for i in INDEPENDENT] for v in ("A", "B", "Bbar", "Bhat")]
    worst, mean = min(max(of) for of in singles), min(sum(of) / 6 for of in singles)
    assert choices.mix_over_best(results, CONVEX, np.max) == pytest.approx(0.25 / worst)
    assert choices.mix_over_best(results, CONVEX, np.mean) == pytest.approx((1 / 4 + 1 / 9) / 6 / mean)
