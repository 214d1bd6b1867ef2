"""Where measures begin and end, and the numbers beside the statements, on hand-made curves."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from compare.report.looks import label_looks
from compare.validation.statements import coupling_components as coupling
from compare.validation.statements import direct_components as direct
from compare.validation.statements import engines_and_limits, finite_elements, random_contacts
from compare.validation.statements.curves import ACROSS, ALONE, BESIDE, CONCAVE, CONVEX, Curve
from compare.validation.statements.page import STATEMENTS
from compare.validation.statements.random_contacts import GridComparison
from compare.validation.statements.runs import GEOMETRIES
from geometries.patches import N, S
from tests.compare.validation.statements.handmade import (
    Runs,
    by_body,
    made,
    runs_of,
    times,
    with_c,
    without_c,
)
from tests.compare.validation.statements.makers import NN, SN, SS, XN, XS, fitted, term, turned
from tests.compare.validation.statements.mutations import CRITERIA

FIRST, SECOND = GEOMETRIES


def distance(of):
    return np.hypot(of.points.x, of.points.s)


# --- where they begin and end ---------------------------------------------------------------------------


def test_nn_is_compared_at_plus_10_mm():
    """C_nn is A / (1 + t / 50), t along the line: at 10 mm A misses 0.2 of it, not so at -10 mm."""
    results = made(
        FIRST, times("A", NN, lambda of: 1 / (1 + np.where(of.on(ACROSS), of.points.s, of.points.x) / 50))
    )
    assert direct.nn_error("A")(results) == pytest.approx(0.2, rel=1e-3)
    assert direct.nn_error("A", at=direct.HALF_WAY)(results) == pytest.approx(0.1, rel=1e-3)
    assert direct.nn_error("A", BESIDE)(results) == pytest.approx(0.2, rel=1e-3)


def test_ss_is_compared_a_reference_length_away():
    """C_ss is (1 - x / 100) B_ss: a tenth less at 10 mm."""
    results = made(FIRST, times("B", SS, lambda of: 1 - of.points.x / 100))
    assert direct.deficit(results, CONCAVE) == pytest.approx(0.1, rel=1e-3)


def test_the_half_space_is_compared_on_s_0_within_1_mm():
    """|C - A| / A_nn is 0.3 up to 1 mm from the load on s = 0, 0.9 elsewhere."""

    def c(of):
        near = (np.abs(of.points.x) <= 1 + 1e-9) & (of.points.s == 0)
        return of.a - np.where(near, 0.3, 0.9) * of.a[NN]

    assert direct.deviation_at_load(made(FIRST, c), "combined", "xx") == pytest.approx(0.3)


def test_near_is_up_to_2_5_mm_and_far_from_10_to_20_mm():
    """|C - A| / A_nn is 1 near, 5 between, 2 far and 7 beyond: a half."""

    def c(of):
        steps = np.select([distance(of) <= lim for lim in (2.5, 9.99, 20.0)], [1.0, 5.0, 2.0], 7.0)
        return of.a - steps * of.a[NN]

    assert direct.near_over_far(made(FIRST, c), CONVEX, "sn") == pytest.approx(0.5)


def test_a_fit_is_too_large_between_the_patch_and_3_mm():
    """C_xn is 0.8 of the fit there and twice the fit elsewhere, on every line."""

    def near(points):
        return (np.abs(points.x) > 0.2) & (np.abs(points.x) <= 3.0)

    results = fitted(lambda of: np.where(near(of.points), 0.8, 2.0))().geometry(FIRST)
    along_x = results.points.s != results.points.s[results.lines[ACROSS]][0]
    on_lines = np.ones_like(along_x)
    on_lines[results.lines[ACROSS]] = False
    fit = np.abs(results.approximations["Bhat_prime", "combined"][XN])[on_lines]
    is_near = near(results.points)[on_lines]
    expected = np.mean(0.2 * fit[is_near]) / np.max(np.where(is_near, 0.8, 2.0) * fit)
    assert coupling.fit_excess(results) == pytest.approx(expected)
    runs = Runs({FIRST: results, SECOND: fitted(1.0)().geometry(SECOND)})
    assert CRITERIA[7, "geometry"].measure(runs) == {"both": pytest.approx(expected)}


def test_xn_of_both_bodies_is_compared_beside_the_load_only():
    """On the other lines the concave body has nine times as much."""

    def size(of):
        return np.where(of.on(BESIDE), by_body(2, 1)(of), by_body(1, 9)(of))

    results = made(FIRST, times("A", XN, size))
    assert coupling.c_xn_rms(results, CONVEX) / coupling.c_xn_rms(results, CONCAVE) == pytest.approx(2)


def test_a_is_compared_with_prismatic_variants_off_s_0_only():
    """C_xn is a third of the way from A to B there; on s = 0 something else, as large on either."""

    def c(of):
        out = of.a + (of.prismatic("B") - of.a) / 3
        out[XN] += np.where(of.points.s == 0, 1e-9 * np.sign(of.points.x), 0)
        return out

    assert coupling.a_over_prismatic("B")(made(SECOND, c), CONCAVE) == pytest.approx(0.5)


def test_an_arc_ends_where_the_first_of_both_bodies_has_its_joint():
    """Geometry 2: at 10.1 mm times 60 degrees of the wheel, before 10 mm times 65 degrees of the rail."""
    wheel, rail = 10.1 * np.radians(60), 10 * np.radians(65)
    assert wheel < rail

    def off(low, high):
        def factor(of):
            return np.where((np.abs(of.points.s) > low) & (np.abs(of.points.s) <= high), 1.5, 1)

        return coupling.error_within_arc(made(SECOND, times("B", SN, factor)), "B")

    assert off(wheel, rail) < 1e-15
    assert off(wheel - 0.4, wheel) > 1e-3


def test_gains_are_errors_at_least_a_tenth_smaller(monkeypatch):
    """Of four cases two gain; up to six of eight gains are inconsistent."""
    monkeypatch.setattr(coupling, "errors_with_factor", lambda _: {"a": 0.9, "b": 0.901, "c": 0.5, "d": 2.0})
    (criterion,) = STATEMENTS[10].criteria
    assert criterion.measure(None) == {"all": 0.5}
    for gains, met in ((5, True), (6, False)):
        ratios = {str(k): 0.1 if k < gains else 1.0 for k in range(8)}
        monkeypatch.setattr(coupling, "errors_with_factor", lambda _, ratios=ratios: ratios)
        assert criterion.met(criterion.measure(None)["all"]) == met


@pytest.mark.parametrize(
    ("name", "variant"),
    [
        (GEOMETRIES[0], "B"),
        (GEOMETRIES[1], "Bhat"),
        pytest.param(GEOMETRIES[0], "Bhat", marks=pytest.mark.slow),
        pytest.param(GEOMETRIES[1], "B", marks=pytest.mark.slow),
    ],
)
def test_the_larger_xn_of_prismatic_variants_is_inverse_to_the_modulus(variant, name):
    """ICs are: whatever the ratio of equal materials, twice the modulus of the concave body halves it."""
    ratio = coupling.concave_over_convex(variant)
    equal = ratio(made(name, times("A", None, 1)))
    criterion = CRITERIA[6, {"B": "in B", "Bhat": "in B̂"}[variant]]
    for value in (0.99, 1.01):
        computed = ratio(with_c(without_c(name, upper_E=210e3 * equal / value), times("A", None, 1)))
        assert computed == pytest.approx(value)
        assert criterion.met(computed) == (value > 1)


@pytest.mark.parametrize(("body", "normal"), [(CONVEX, -1), (CONCAVE, 1)])
def test_the_factor_is_on_sn_and_ns_of_a_and_vanishes_opposite(body, normal):
    """B = A R_x(alpha), B-hat = R_x(alpha/2) A R_x(alpha/2), entry by entry; both bodies add up."""
    results = made(FIRST, times("A", None, 1))
    a = results.approximations["A", body].copy()
    assert np.sign(a[S, N, results.lines[ACROSS]][-1]) == -normal
    alpha = np.clip(results.points.s, -np.radians(255), np.radians(255)) / 10
    share = 1 - np.abs(alpha) / np.pi
    ss, sn_, ns, n_n = a[SS], share * a[SN], share * a[N, S], a[NN]
    b = -ss * np.sin(alpha) + sn_ * np.cos(alpha)
    cos, sin = np.cos(alpha / 2), np.sin(alpha / 2)
    b_hat = cos * (-ss * sin + sn_ * cos) - sin * (-ns * sin + n_n * cos)
    for variant, expected in (("B", b), ("Bhat", b_hat)):
        computed = coupling.ics_with_factor(results, variant, body)[SN]
        np.testing.assert_allclose(computed, expected, rtol=0, atol=1e-13 * np.max(np.abs(a)))
        both = coupling.ics_with_factor(results, variant, "combined")
        parts = sum(coupling.ics_with_factor(results, variant, one) for one in ALONE)
        np.testing.assert_allclose(both, parts, rtol=0, atol=1e-15 * np.max(np.abs(a)))


# --- details --------------------------------------------------------------------------------------------


def test_rotations_are_dimensionless():
    """1e-9 rad/N times 210 GPa times (10 mm)^2."""
    rotations = STATEMENTS[19].details(turned(-2e-9, 1e-9)())
    of_both = {"lower": -0.042, "upper": 0.021}
    assert rotations == pytest.approx(
        {f"rotation · E L²: {g}, {b}": n for g in GEOMETRIES for b, n in of_both.items()}
    )


def test_sizes_in_xs_are_dimensionless():
    runs = runs_of(times("A", XS, by_body(1.5, 0.8)))
    sizes = STATEMENTS[4].details(runs)
    for name in GEOMETRIES:
        for body, share in ((CONVEX, 0.5), (CONCAVE, 0.2)):
            a = np.max(np.abs(runs.geometry(name).approximations["A", body][XS]))
            assert sizes[f"largest |C_xs - A_xs| E L: {name}, {body}"] == pytest.approx(share * 2.1e6 * a)


def test_the_term_of_curvature_is_due_to_point_loads_away_from_the_load():
    """A_xx + A_nn on s = 0 are (2 - nu) / 2 pi G x; alpha is -x / 500 mm; here it is twice the change."""
    details = coupling.curvature_details(term(2.0)())
    for x in (8.0, 16.0):
        expected = 10 * 1.3 * (2 - 0.3) / np.pi / x * np.sin(x / 500) / 2  # E L / (2 pi G) = L (1 + nu) / pi
        assert details[f"-½ (A_xx + A_nn) sin α_x: x = {x:g} mm"] == pytest.approx(expected, rel=1e-3)
        assert details[f"C_xn less C_xn not revolved: x = {x:g} mm"] == pytest.approx(expected / 2, rel=1e-3)


def test_errors_of_xn_are_listed_with_curvature_along_x_and_without():
    """C of the wheel is B-hat with it: that has no error; the others have what is between them and it."""
    results = made(SECOND, times("Bhat", None, 1))
    errors = coupling.xn_errors(Runs(dict.fromkeys(GEOMETRIES, results)))
    assert len(errors) == 5 * 6
    assert errors[f"error of B̂: {SECOND}, {CONCAVE}"] == 0
    prismatic = errors[f"error of B̂, not revolved: {SECOND}, {CONCAVE}"]
    assert prismatic > 1e-3
    assert errors[f"error of B̂, not revolved: {SECOND}, {CONVEX}"] == pytest.approx(0, abs=1e-12)
    for variant in "AB":
        of_wheel = errors[f"error of {variant}: {SECOND}, {CONCAVE}"]
        assert of_wheel == Curve(results, CONCAVE, "xn").error(variant) > 0


def test_mean_errors_are_listed_for_all_variants_that_exist():
    """C is A / 1.2; the fit is of both bodies together only."""
    runs = Runs({name: made(name, times("A", None, 1 / 1.2), fitted=True) for name in GEOMETRIES})
    errors = engines_and_limits.mean_errors(runs)
    for body in ALONE:
        assert errors[f"mean error of A: {FIRST}, {body}"] == pytest.approx(0.2)
        assert f"mean error of B̂′: {SECOND}, {body}" not in errors
    assert errors[f"mean error of B̂′: {SECOND}, combined"] > 0
    assert len(errors) == 2 * (6 + 5 + 5)


# --- what is drawn ----------------------------------------------------------------------------------------


def curves_in(panel):
    return {curve.label: curve.points for curve in panel.curves}


def test_coverage_is_drawn_over_multiples_of_the_estimate(monkeypatch):
    """Errors of 1 estimated as 2 are within half of their estimates, those estimated as 0.8 within 1.25."""
    names = ("p_max", "F_x")
    of_size = [
        GridComparison(*(dict.fromkeys(names, value) for value in (1.0, 0.0, 0.0, size)), "mixed")
        for size in (2.0, 0.8)
    ]
    monkeypatch.setattr(random_contacts, "STUDIES", ["rolling"])
    runs = SimpleNamespace(once=lambda *_: of_size)
    (panel,) = random_contacts.STATEMENTS[0].panels(runs)
    drawn = curves_in(panel)
    assert set(drawn) == {"p_max", "F_x"}
    multiples, shares = drawn["p_max"]
    np.testing.assert_array_equal(shares, (multiples >= 0.5) / 2 + (multiples >= 1.25) / 2)
    looks = {curve.label: curve.look for curve in panel.curves}
    assert looks["F_x"] == label_looks(random_contacts.SHOWN)["F_x"]  # as where others are drawn, too


def test_pressures_with_ics_are_drawn_where_finite_elements_have_theirs():
    s, s_fe = np.linspace(-2.0, 2.0, 9), np.linspace(-1.0, 1.0, 5)
    p = {"C": 100 - 10 * s, "A": 90 + 0 * s, "Bbar": np.nan * s}
    dataset = xr.Dataset(
        {
            "p": (("case", "ics", "s"), [list(p.values())]),
            "p_fe": (("case", "s_fe"), [101 - 10 * s_fe]),
        },
        coords={
            "case": ("case", [58e3], {"units": "N"}),
            "ics": list(p),
            "s": (("case", "s"), [s]),
            "s_fe": (("case", "s_fe"), [s_fe]),
        },
    )
    runs = SimpleNamespace(fe_contact=lambda _: dataset)
    (panel,) = STATEMENTS[23].panels(runs)
    drawn = curves_in(panel)
    assert panel.title == "tall, 58000 N"
    assert set(drawn) == {"C", "A", "FE"}
    for label, values in (("C", 100 - 10 * s_fe), ("A", 90 + 0 * s_fe), ("FE", 101 - 10 * s_fe)):
        np.testing.assert_allclose(drawn[label], [s_fe, values])


def test_approaches_are_drawn_over_elements_with_the_estimate_of_c():
    def contact(_, changes):
        n = changes["elements"]
        values = {"approach": ("ics", [n, 2.0 * n]), "estimate_approach": ("ics", [np.nan, 1.0 / n])}
        return xr.Dataset(values, coords={"ics": ["Bhat", "C"]}).expand_dims("case")

    (panel,) = STATEMENTS[24].panels(SimpleNamespace(contact=contact))
    c, b_hat = panel.curves
    np.testing.assert_array_equal(
        c.points, [finite_elements.ELEMENTS, 2.0 * np.array(finite_elements.ELEMENTS)]
    )
    np.testing.assert_array_equal(b_hat.points[1], finite_elements.ELEMENTS)
    np.testing.assert_array_equal(c.band, 1 / np.array(finite_elements.ELEMENTS))
    assert b_hat.band is None
