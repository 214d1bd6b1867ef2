"""Approximations as convolutions against the same ICs as a dense matrix."""

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.pair import Pair, Solid, matrix
from approx.variants import VARIANTS
from femic.contact.operators.approximations import (
    approximate_matrix,
    approximate_operator,
    half_space_operator,
)
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.dense import GridOperator
from geometries.contours import arc, ellipse, plane
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface
from tests.approx.new_forms import register

STEEL, BRASS = Material(210e3, 0.28), Material(100e3, 0.35)
GRID = Grid(6, 9, 0.4, 0.9, 0.5)  # over the crown and both flanks of the contours
RAIL, WHEEL = arc(5.0, 0.5, 0.7), ellipse(6.0, 8.0, 0.6, 0.4)
OF_PAIR = EffectiveProperties(mismatch_k=Transition(0.2, 6.0, 0.8, 1.5))
OF_RAIL = EffectiveProperties(nu=Transition(0.35, 5.0, 1.0, 2.0), mismatch_k=Transition(-0.1, 4.0, 1.0, 1.0))
OF_WHEEL = EffectiveProperties(G=Transition(50e3, 3.0, 1.2, 0.7))
TRACTIONS = np.random.default_rng(0).normal(size=(GRID.n_x, GRID.n_s, 3))


def pair(upper=(BRASS, WHEEL), lower=(STEEL, RAIL), of_bodies=(None, None), effective=None):
    bodies = [
        Solid(material, Surface(side, contour), own)
        for side, (material, contour), own in zip((UPPER, LOWER), (upper, lower), of_bodies, strict=True)
    ]
    return Pair(*bodies, effective)


PAIRS = {
    "equal": pair((STEEL, RAIL)),
    "materials": pair((BRASS, RAIL)),
    "contours": pair((STEEL, WHEEL)),
    "both": pair(),
    "plane": pair((BRASS, plane())),
}
WITH_EFFECTIVE = {
    "of the pair": pair(effective=OF_PAIR),
    "of equal contours": pair((BRASS, RAIL), effective=OF_PAIR),
    "of both bodies": pair(of_bodies=(OF_WHEEL, OF_RAIL)),
    "of bodies with equal contours": pair((BRASS, RAIL), of_bodies=(OF_WHEEL, OF_RAIL)),
    "of pair and bodies": pair(of_bodies=(OF_WHEEL, OF_RAIL), effective=OF_PAIR),
}


def assert_dense(variant, bodies, directions):
    """The operator is that of the matrix, to rounding of its largest components."""
    ics = matrix(variant, bodies, GRID)[..., directions, :][..., directions]
    tractions = TRACTIONS[..., directions]
    expected = GridOperator.from_ics(ics, directions)(tractions)
    u = approximate_operator(variant, bodies, GRID, directions)(tractions)
    np.testing.assert_allclose(u, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))


@pytest.mark.parametrize("bodies", PAIRS.values(), ids=PAIRS)
@pytest.mark.parametrize("variant", sorted(set(VARIANTS) - {"Bhat_prime"}))
def test_operator_agrees_with_the_dense_matrix(variant, bodies):
    assert_dense(variant, bodies, (X, S, N))


EXCHANGED = ["Bhat+sn:B", "B+xs:A", "mix+nn:A", "Bhat+xn:Bhat_prime_or_A+ss:B"]


@pytest.mark.parametrize("bodies", (PAIRS | WITH_EFFECTIVE).values(), ids=PAIRS | WITH_EFFECTIVE)
@pytest.mark.parametrize("variant", EXCHANGED)
def test_operator_agrees_with_the_dense_matrix_with_exchanged_components(variant, bodies):
    assert_dense(variant, bodies, (X, S, N))


@pytest.mark.parametrize("bodies", WITH_EFFECTIVE.values(), ids=WITH_EFFECTIVE)
def test_operator_agrees_with_the_dense_matrix_with_an_effective_component(bodies):
    assert_dense("Bhat+sn:Bhat_prime", bodies, (X, S, N))


@pytest.mark.parametrize("bodies", (PAIRS | WITH_EFFECTIVE).values(), ids=PAIRS | WITH_EFFECTIVE)
@pytest.mark.parametrize(
    ("variant", "kind"),
    [
        ("Btilde", Convolution),
        ("Bhat+sn:Btilde", Convolution),
        ("Bfaded", GridOperator),
        ("Alength", GridOperator),
        ("Bhat+ss:Bprime_or_Bfaded", GridOperator),
        ("mix+ss:Bfaded", GridOperator),
    ],
)
def test_new_forms_have_operators(variant, kind, bodies, monkeypatch):
    """Those with shares of the rotation are convolutions, others dense between strips."""
    register(monkeypatch)
    for directions in ((X, S, N), (N, X)):
        assert isinstance(approximate_operator(variant, bodies, GRID, directions), kind)
        assert_dense(variant, bodies, directions)


@pytest.mark.parametrize("bodies", WITH_EFFECTIVE.values(), ids=WITH_EFFECTIVE)
@pytest.mark.parametrize("variant", ["Btilde_prime", "Btilde_prime+sn:Bfaded"])
def test_new_forms_of_effective_properties_have_operators(variant, bodies, monkeypatch):
    register(monkeypatch)
    assert_dense(variant, bodies, (X, S, N))


@pytest.mark.parametrize("n_x", [1, 2, 5])
def test_form_that_is_not_symmetric_in_x_is_refused_beyond_one_row(n_x, monkeypatch):
    register(monkeypatch)
    grid = Grid(n_x, 3, 0.4, 0.9)
    if n_x == 1:
        assert isinstance(approximate_operator("Askew", pair(), grid), GridOperator)
    else:
        with pytest.raises(WrongInput, match="variant = 'Askew': its ICs at -x are not those at x"):
            approximate_operator("Askew", pair(), grid)


@pytest.mark.parametrize("bodies", (PAIRS | WITH_EFFECTIVE).values(), ids=PAIRS | WITH_EFFECTIVE)
@pytest.mark.parametrize("variant", ["A", "Bhat", "mix", "B+xs:A"])
def test_the_matrix_has_the_ics_of_the_operator(variant, bodies):
    ics = approximate_matrix(variant, bodies, GRID, upper_offset=0.3)
    expected = approximate_operator(variant, bodies, GRID, upper_offset=0.3)(TRACTIONS)
    tolerance = 1e-14 * np.max(np.abs(expected))
    np.testing.assert_allclose(GridOperator.from_ics(ics)(TRACTIONS), expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("bodies", (PAIRS | WITH_EFFECTIVE).values(), ids=PAIRS | WITH_EFFECTIVE)
def test_half_spaces_have_the_operator_of_a(bodies):
    operator = half_space_operator(bodies, GRID, (N, X))
    expected = approximate_operator("A", bodies, GRID, (N, X))(TRACTIONS[..., (N, X)])
    np.testing.assert_array_equal(operator(TRACTIONS[..., (N, X)]), expected)


@pytest.mark.parametrize("directions", [(X, S, N), (N,), (N, X)])
@pytest.mark.parametrize("bodies", PAIRS.values(), ids=PAIRS)
@pytest.mark.parametrize("variant", ["A", "B", "Bbar", "Bhat", "mix"])
def test_operator_is_the_same_dense_between_strips(variant, bodies, directions):
    fast = approximate_operator(variant, bodies, GRID, directions, upper_offset=0.3)
    of_strips = GridOperator.from_convolution(fast)
    p = TRACTIONS[..., directions]
    np.testing.assert_allclose(of_strips(p), fast(p), rtol=0, atol=1e-14 * np.max(np.abs(fast(p))))
    assert of_strips.directions == directions


@pytest.mark.parametrize("directions", [(N,), (X, S), (S, N), (N, X)])
@pytest.mark.parametrize("variant", ["A", "B", "Bhat", "mix"])
def test_restricted_operator_agrees_in_any_order_of_directions(variant, directions):
    assert_dense(variant, pair(), directions)


@pytest.mark.parametrize("bodies", WITH_EFFECTIVE.values(), ids=WITH_EFFECTIVE)
@pytest.mark.parametrize("variant", ["Bhat_prime", "mix"])
def test_operator_agrees_with_the_dense_matrix_with_effective_properties(variant, bodies):
    assert_dense(variant, bodies, (X, S, N))


def test_one_body_of_the_pair_alone_may_have_effective_properties():
    """Of the mix only: B-hat-prime needs them of both."""
    assert_dense("mix", pair(of_bodies=(OF_WHEEL, None)), (X, S, N))
    with pytest.raises(WrongInput, match="effective properties: B-hat-prime needs"):
        approximate_operator("Bhat_prime", pair(of_bodies=(OF_WHEEL, None)), GRID)


def test_an_unknown_variant_is_named_with_the_known_ones():
    with pytest.raises(WrongInput, match="variant = 'C': one of A, B, Bbar, Bhat"):
        approximate_operator("C", pair(), GRID)


@pytest.mark.parametrize(("variant", "symmetric"), [("A", True), ("Bhat", True), ("mix", True), ("B", False)])
def test_work_is_reciprocal_where_the_variant_is(variant, symmetric):
    """p1 S p2 = p2 S p1."""
    other = np.roll(TRACTIONS, (2, 3, 1), axis=(0, 1, 2))
    operator = approximate_operator(variant, pair(), GRID)
    there, back = np.vdot(TRACTIONS, operator(other)), np.vdot(other, operator(TRACTIONS))
    size = np.linalg.norm(TRACTIONS) * np.linalg.norm(operator(other))
    assert (abs(there - back) < 1e-13 * size) == symmetric


@pytest.mark.parametrize("variant", ["B", "Bbar", "Bhat", "mix"])
def test_nn_is_reciprocal_for_all_variants(variant):
    """Of B, too: A_nn cos(alpha) - A_ns sin(alpha) is even. Frictionless contact needs no more."""
    p, other = TRACTIONS[..., 2:], TRACTIONS[..., :1]
    operator = approximate_operator(variant, pair(), GRID, (N,))
    assert np.vdot(p, operator(other)) == pytest.approx(np.vdot(other, operator(p)), rel=1e-11, abs=0)


def test_nn_of_b_and_b_bar_are_the_same_and_differ_from_b_hat_and_a():
    p = np.abs(TRACTIONS[..., 2:])
    of = {
        variant: approximate_operator(variant, pair(), GRID, (N,))(p)
        for variant in ("B", "Bbar", "Bhat", "A")
    }
    np.testing.assert_allclose(of["B"], of["Bbar"], rtol=1e-13)
    for variant in ("Bhat", "A"):
        assert np.max(np.abs(of[variant] - of["B"])) > 0.01 * np.max(of["B"])


def coarsening_defect(variant, bodies, grid, directions=(X, S, N)):
    """Largest defect of the coarsened operator over the largest displacement, of smooth tractions."""
    operator = approximate_operator(variant, bodies, grid, directions)
    middles = grid.strips.reshape(-1, 2).mean(axis=1)
    x = 2 * grid.dx * np.arange(grid.n_x // 2)[:, None]
    waves = [np.cos(0.7 * x + 0.4 * middles + shift) for shift in directions]
    tractions = np.stack(waves, axis=-1)
    fine = operator(tractions.repeat(2, axis=0).repeat(2, axis=1))
    mean = fine.reshape(grid.n_x // 2, 2, grid.n_s // 2, 2, len(directions)).mean(axis=(1, 3))
    return np.max(np.abs(operator.coarsened()(tractions) - mean)) / np.max(np.abs(mean))


@pytest.mark.parametrize("variant", ["B", "Bbar", "Bhat", "mix"])
def test_coarsened_approximations_are_means_to_second_order_in_the_strip_width(variant):
    """Factors are averaged; on an arc, because at the end of an arc the curvature jumps."""
    bodies = pair((BRASS, arc(5.5, 1.2, 1.2)), (STEEL, arc(5.0, 1.2, 1.2)))
    defects = [coarsening_defect(variant, bodies, Grid(n, 2 * n, 3.2 / n, 8.0 / n)) for n in (8, 16, 32)]
    assert defects[0] < 0.05
    assert np.all(np.log2(np.divide(defects[:-1], defects[1:])) > 1.6)  # element^2 ln(element)


@pytest.mark.parametrize("radius", [40.0, 400.0])
@pytest.mark.parametrize("upper", [STEEL, Material(90e3, 0.0), Material(1.0, 0.5)])
def test_the_curvature_of_a_wheel_along_x_changes_nn_by_the_angle_times_its_coupling(upper, radius):
    """A bound that grows with the angle, not with its square: xn of the wheel, rotated, is part of nn."""
    grid = Grid(12, 5, 0.8, 0.5)
    wheel, rail = Solid(upper, Surface(UPPER, WHEEL, radius)), Solid(STEEL, Surface(LOWER, RAIL))
    exact = matrix("Bhat", Pair(wheel, rail), grid)[..., N, N]
    prismatic = matrix("Bhat", pair((upper, WHEEL), (STEEL, RAIL)), grid)[..., N, N]
    inclination = WHEEL.inclination(grid.strips)
    theta, alpha = grid.lags[:, None, None] / radius, np.abs(inclination[:, None] - inclination)
    bound = theta * ((1 - 2 * upper.nu) / (2 - 2 * upper.nu) + alpha + theta)
    change = np.abs(exact / prismatic - 1)
    assert np.all(change <= bound + 1e-12)
    assert np.max(change[1:] / bound[1:]) > 0.4


def test_curvature_without_coupling_changes_nn_by_less_than_the_square_of_the_angle():
    wheel = Solid(Material(1.0, 0.5), Surface(UPPER, plane(), 40.0))
    rail = Solid(Material(3.0, 0.5), Surface(LOWER, plane()))
    grid = Grid(12, 5, 0.8, 0.5)
    exact = matrix("Bhat", Pair(wheel, rail), grid)[..., N, N]
    change = exact / matrix("A", Pair(wheel, rail), grid)[..., N, N] - 1
    theta = grid.lags[:, None, None] / 40.0
    assert np.all(np.abs(change) <= theta**2 + 1e-12)
    assert np.max(np.abs(change)[1:] / theta[1:] ** 2) > 0.2


class MovedContour:
    """A contour whose arc length 0 lies at another arc length of a contour."""

    def __init__(self, contour, s):
        self.contour, self.s = contour, s

    def inclination(self, s):
        return self.contour.inclination(s + self.s)

    def position(self, s):
        origin = self.contour.position(self.s)
        return self.contour.position(s + self.s) - origin.reshape(2, *[1] * np.ndim(s))


@pytest.mark.parametrize("variant", ["B", "Bhat", "Bfaded"])
def test_an_upper_body_that_lies_aside_rotates_with_its_own_inclinations(variant, monkeypatch):
    register(monkeypatch)
    grid, offset = Grid(5, 4, 0.4, 0.9, 1.0), 5.0
    wheel, rail = ellipse(13.0, 7.0, 1.0, 1.0), ellipse(12.0, 6.5, 1.0, 1.0)
    lower = Solid(Material(70e3, 0.33), Surface(LOWER, rail))
    of_both, moved = (
        Pair(Solid(Material(210e3, 0.28), Surface(UPPER, contour)), lower)
        for contour in (wheel, MovedContour(wheel, offset))
    )
    aside = approximate_operator(variant, of_both, grid, upper_offset=offset)
    tractions = np.random.default_rng(0).normal(size=(5, 4, 3))
    expected = GridOperator.from_ics(matrix(variant, moved, grid))(tractions)
    np.testing.assert_allclose(aside(tractions), expected, atol=1e-13 * np.max(np.abs(expected)))
    assert np.max(np.abs(approximate_operator(variant, of_both, grid)(tractions) - expected)) > 1e-4 * np.max(
        expected
    )
