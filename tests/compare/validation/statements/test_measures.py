"""The measures of statements about ICs on hand-made curves, whose numbers are known."""

import numpy as np
import pytest

from compare.validation.statements import coupling_components as coupling
from compare.validation.statements import curves, engines_and_limits
from compare.validation.statements.curves import ACROSS, CONCAVE, CONVEX, INDEPENDENT, THROUGH, Curve
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.runs import GEOMETRIES
from geometries.patches import N, S, X
from tests.compare.validation.statements.handmade import (
    Runs,
    made,
    runs_of,
    times,
    with_c,
)

FIRST, SECOND = GEOMETRIES


# --- 6 to 8, 13, 21: xn ---------------------------------------------------------------------------------


def test_xn_of_prismatic_variants_is_compared_by_rms_beside_the_load():
    results = made(FIRST, times("A", None, 1))
    line = results.lines["s = 1.6 mm"]
    for variant in ("B", "Bhat"):  # prismatic: the variant itself
        sizes = [curves.rms(results.approximations[variant, b][X, N, line]) for b in (CONCAVE, CONVEX)]
        assert coupling.concave_over_convex(variant)(results) == pytest.approx(sizes[0] / sizes[1])
    assert coupling.concave_over_convex("B")(made(SECOND, times("A", None, 1))) > 1


def test_the_term_of_curvature_has_its_sign():
    """On s = 0 it is what B-hat of the revolved wheel has more than that of its section, to (x / R)^2."""
    wheel = made(SECOND, times("A", None, 1))
    line = wheel.lines[THROUGH]
    more = wheel.approximations["Bhat", CONCAVE] - curves.prismatic_ics(wheel, "Bhat", CONCAVE)
    term = coupling.curvature_term(Runs({SECOND: wheel}))
    x = np.abs(wheel.points.x[line])
    expected = curves.unit(wheel) * more[X, N, line]
    np.testing.assert_allclose(term[x > 1], expected[x > 1], rtol=0.01)


# --- 9, 10: sn ------------------------------------------------------------------------------------------


def test_a_right_factor_leaves_no_error():
    """C is B with the factor: without it something is missed, with it nothing."""

    def c(of):
        return coupling.ics_with_factor(with_c(of.results, lambda of: of.a), "B", of.body)

    runs = runs_of(c)
    ratios = coupling.errors_with_factor(runs)
    np.testing.assert_allclose([v for case, v in ratios.items() if case.endswith(", B")], 0, atol=1e-9)
    (gain,) = STATEMENTS[10].criteria
    assert gain.measure(runs)["all"] == np.mean([v <= 0.9 for v in ratios.values()])


@pytest.mark.parametrize("sign", [1, -1])
def test_the_largest_misfit_counts_whatever_its_sign(sign):
    """B-hat less or more by a bump at s = 7.5 mm."""

    def c(of):
        out = of.by("Bhat").copy()
        out[S, N] += sign * 1e-6 * np.exp(-((of.points.s - 7.5) ** 2)) * of.on(ACROSS)
        return out

    joint = 10 * np.radians(25.5)
    assert coupling.furthest_misfit(made(FIRST, c)) == pytest.approx(7.5 / joint, rel=0.01)


# --- 11, 12: choices ------------------------------------------------------------------------------------


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
    assert engines_and_limits.mix_over_best(np.max)(results, CONVEX) == pytest.approx(0.25 / worst)
    assert engines_and_limits.mix_over_best(np.mean)(results, CONVEX) == pytest.approx(
        (1 / 4 + 1 / 9) / 6 / mean
    )
