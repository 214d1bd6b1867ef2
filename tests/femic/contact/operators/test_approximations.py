"""Approximations as convolutions against the same ICs as a dense matrix, and ICs of wheels that roll."""

from itertools import product

import numpy as np
import pytest

from approx.effective import EffectiveProperties, Transition
from approx.pair import Pair, Solid, matrix
from approx.variants import VARIANTS
from femic.contact.operators.approximations import (
    approximate_matrix,
    approximate_operator,
    half_space_operator,
    rolled,
)
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.dense import GridOperator
from geometries.contours import arc, ellipse, plane
from geometries.errors import WrongInput
from geometries.materials import Material
from geometries.patches import Grid, N, S, X
from geometries.surfaces import LOWER, UPPER, Surface
from tests.approx.new_forms import register
from tests.femic.contact.problems import BRASS, STEEL

GRID = Grid(6, 9, 0.4, 0.9, 0.5)  # over the crown and both flanks of the contours
RAIL, WHEEL = arc(5.0, 0.5, 0.7), ellipse(6.0, 8.0, 0.6, 0.4)
OF_PAIR = EffectiveProperties(mismatch_k=Transition(0.2, 6.0, 0.8, 1.5))
OF_RAIL = EffectiveProperties(nu=Transition(0.35, 5.0, 1.0, 2.0), mismatch_k=Transition(-0.1, 4.0, 1.0, 1.0))
OF_WHEEL = EffectiveProperties(G=Transition(50e3, 3.0, 1.2, 0.7))
TRACTIONS = np.random.default_rng(0).normal(size=(GRID.n_x, GRID.n_s, 3))


def pair(upper=(BRASS, WHEEL), lower=(STEEL, RAIL), of_bodies=(None, None), effective=None, radius=np.inf):
    return Pair(
        Solid(upper[0], Surface(UPPER, upper[1], radius), of_bodies[0]),
        Solid(lower[0], Surface(LOWER, lower[1]), of_bodies[1]),
        effective,
    )


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

ALL = PAIRS | WITH_EFFECTIVE
each_pair = pytest.mark.parametrize("bodies", ALL.values(), ids=ALL)


def assert_dense(variant, bodies, directions=(X, S, N)):
    """The operator is that of the matrix, to rounding of its largest components."""
    ics = matrix(variant, bodies, GRID)[..., directions, :][..., directions]
    tractions = TRACTIONS[..., directions]
    expected = GridOperator.from_ics(ics, directions)(tractions)
    u = approximate_operator(variant, bodies, GRID, directions)(tractions)
    np.testing.assert_allclose(u, expected, rtol=0, atol=1e-13 * np.max(np.abs(expected)))


CASES = [
    *product(sorted(set(VARIANTS) - {"Bhat_prime"}), PAIRS),
    *product(["Bhat+sn:B", "B+xs:A", "mix+nn:A", "Bhat+xn:Bhat_prime_or_A+ss:B"], ALL),
    *product(["Bhat_prime", "mix", "Bhat+sn:Bhat_prime"], WITH_EFFECTIVE),
]


@pytest.mark.parametrize(("variant", "bodies"), CASES)
def test_operator_agrees_with_the_dense_matrix(variant, bodies):
    assert_dense(variant, ALL[bodies])


CONVOLUTIONS = "Btilde", "Bhat+sn:Btilde", "Btilde_prime"
DENSE = "Bfaded", "Alength", "Bhat+ss:Bprime_or_Bfaded", "mix+ss:Bfaded", "Btilde_prime+sn:Bfaded"
NEW = [
    (variant, kind, bodies)
    for variants, kind in ((CONVOLUTIONS, Convolution), (DENSE, GridOperator))
    for variant in variants
    for bodies in (WITH_EFFECTIVE if variant.startswith("Btilde_prime") else ALL)
]


@pytest.mark.parametrize(("variant", "kind", "bodies"), NEW)
def test_new_forms_have_operators(variant, kind, bodies, monkeypatch):
    """Those with shares of the rotation are convolutions, others dense between strips."""
    register(monkeypatch)
    for directions in ((X, S, N), (N, X)):
        assert isinstance(approximate_operator(variant, ALL[bodies], GRID, directions), kind)
        assert_dense(variant, ALL[bodies], directions)


@pytest.mark.parametrize("n_x", [1, 2, 5])
def test_form_that_is_not_symmetric_in_x_is_refused_beyond_one_row(n_x, monkeypatch):
    register(monkeypatch)
    grid = Grid(n_x, 3, 0.4, 0.9)
    if n_x == 1:
        assert isinstance(approximate_operator("Askew", pair(), grid), GridOperator)
    else:
        with pytest.raises(WrongInput, match="variant = 'Askew': its ICs at -x are not those at x"):
            approximate_operator("Askew", pair(), grid)


@each_pair
@pytest.mark.parametrize("variant", ["A", "B", "Bbar", "Bhat", "mix", "B+xs:A"])
def test_matrix_and_operator_between_strips_have_the_ics_of_the_operator(variant, bodies):
    ics = approximate_matrix(variant, bodies, GRID, upper_offset=0.3)
    for directions in ((X, S, N), (N, X)):
        operator = approximate_operator(variant, bodies, GRID, directions, upper_offset=0.3)
        p, part = TRACTIONS[..., directions], ics[..., directions, :][..., directions]
        expected, between_strips = operator(p), GridOperator.from_convolution(operator)
        assert between_strips.directions == directions
        for other in (GridOperator.from_ics(part, directions), between_strips):
            np.testing.assert_allclose(other(p), expected, rtol=0, atol=1e-14 * np.max(np.abs(expected)))


@each_pair
def test_half_spaces_have_the_operator_of_a(bodies):
    p = TRACTIONS[..., (N, X)]
    expected = approximate_operator("A", bodies, GRID, (N, X))(p)
    np.testing.assert_array_equal(half_space_operator(bodies, GRID, (N, X))(p), expected)


@pytest.mark.parametrize("directions", [(N,), (X, S), (S, N), (N, X)])
@pytest.mark.parametrize("variant", ["A", "B", "Bhat", "mix"])
def test_restricted_operator_agrees_in_any_order_of_directions(variant, directions):
    assert_dense(variant, pair(), directions)


def test_one_body_of_the_pair_alone_may_have_effective_properties():
    """Of the mix only: B-hat-prime needs them of both."""
    assert_dense("mix", pair(of_bodies=(OF_WHEEL, None)), (X, S, N))
    with pytest.raises(WrongInput, match="effective properties: B-hat-prime needs"):
        approximate_operator("Bhat_prime", pair(of_bodies=(OF_WHEEL, None)), GRID)


def test_an_unknown_variant_is_named_with_the_known_ones():
    with pytest.raises(WrongInput, match="variant = 'C': one of A, B, Bbar, Bhat"):
        approximate_operator("C", pair(), GRID)


@pytest.mark.parametrize(
    ("variant", "directions", "reciprocal"),
    [
        *((variant, (X, S, N), variant != "B") for variant in ("A", "B", "Bhat", "mix")),
        *((variant, (N,), True) for variant in ("B", "Bbar", "Bhat", "mix")),
    ],
)
def test_work_is_reciprocal_where_the_variant_is(variant, directions, reciprocal):
    """p1 S p2 = p2 S p1. By nn of B, too: A_nn cos(alpha) - A_ns sin(alpha) is even."""
    p, other = (of[..., directions] for of in (TRACTIONS, np.roll(TRACTIONS, (2, 3, 1), axis=(0, 1, 2))))
    operator = approximate_operator(variant, pair(), GRID, directions)
    there, back = np.vdot(p, operator(other)), np.vdot(other, operator(p))
    size = np.linalg.norm(p) * np.linalg.norm(operator(other))
    assert (abs(there - back) < 1e-13 * size) == reciprocal


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
@pytest.mark.parametrize(
    ("upper", "contours"),
    [
        *((of, (WHEEL, RAIL)) for of in (STEEL, Material(90e3, 0.0), Material(1.0, 0.5))),
        (Material(1.0, 0.5), (plane(), plane())),
    ],
    ids=["steel", "nu = 0", "nu = 0.5", "nu = 0.5 on planes"],
)
def test_the_curvature_of_a_wheel_along_x_changes_nn_by_the_angle_times_its_coupling(upper, contours, radius):
    """A bound that grows with the angle, not with its square: xn of the wheel, rotated, is part of nn.

    Without coupling, and without inclinations, with its square.
    """
    grid = Grid(12, 5, 0.8, 0.5)
    curved, prismatic = (
        matrix("Bhat", pair((upper, contours[0]), (STEEL, contours[1]), radius=of), grid)[..., N, N]
        for of in (radius, np.inf)
    )
    inclination = contours[0].inclination(grid.strips)
    theta, alpha = grid.lags[:, None, None] / radius, np.abs(inclination[:, None] - inclination)
    bound = theta * ((1 - 2 * upper.nu) / (2 - 2 * upper.nu) + alpha + theta)
    change = np.abs(curved / prismatic - 1)
    assert np.all(change <= bound + 1e-12)
    assert np.max(change[1:] / bound[1:]) > 0.4


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


# ---- a wheel that is moved as a rigid body does not slip by that, but by its wheel's turn

ROLLER = Surface(UPPER, arc(10.2, 1.2, 1.2), 300.0)
LENGTH = 12.0  # mm along x


def moved(n_x, motion):
    """ICs of a wheel whose points move by motion(points (3, n)) for any load, in local directions."""
    grid = Grid(n_x, 5, LENGTH / n_x, 2.0, 1.0)
    ics = np.zeros((n_x, 5, 5, 3, 3))
    for strip, s in enumerate(grid.strips):
        xi = grid.lags * ROLLER.rolling_radius / ROLLER.circle_radius(s)
        along = motion(ROLLER.position(xi, np.full(n_x, s)))
        local = np.einsum("ikn,kn->ni", ROLLER.axes(xi, np.full(n_x, s)), along)
        ics[:, strip] = local[:, None, :, None]
    return ics, grid


def raised_points(points):
    return np.stack([np.zeros(points.shape[1]), np.zeros(points.shape[1]), np.ones(points.shape[1])])


def spun_points(points):
    x, _, z = points
    return np.stack([z - ROLLER.rolling_radius, np.zeros_like(x), -x]) / ROLLER.rolling_radius


def slip_along_x(ics, grid):
    """-du/dx, between elements."""
    return -np.diff(ics[..., X, 0], axis=0) / grid.dx


def test_a_wheel_raised_as_a_rigid_body_slips_by_less_than_the_square_of_an_element():
    errors = []
    for n_x in (12, 24, 48):
        ics, grid = moved(n_x, raised_points)
        slip = slip_along_x(rolled(ics, ROLLER, grid), grid)
        assert np.max(np.abs(slip_along_x(ics, grid))) > 0.9 / 310  # that of the ICs as they are: 1 / R
        errors.append(np.max(np.abs(slip)))
    assert errors[0] < 1e-4 / 300
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2, 2], abs=0.05)


def test_a_wheel_spun_about_its_axle_does_not_slip_by_its_displacements():
    ics, grid = moved(24, spun_points)
    assert np.min(np.abs(ics[..., X, 0])) > 0.9
    assert np.max(np.abs(slip_along_x(rolled(ics, ROLLER, grid), grid))) < 1e-12


def test_other_directions_and_prismatic_bodies_stay():
    ics, grid = moved(12, raised_points)
    ics += np.random.default_rng(0).normal(size=ics.shape)
    unchanged = ics.copy()
    result = rolled(ics, ROLLER, grid)
    np.testing.assert_array_equal(ics, unchanged)
    np.testing.assert_array_equal(result[..., (S, N), :], ics[..., (S, N), :])
    np.testing.assert_array_equal(result[0], ics[0])
    assert np.max(np.abs(result - ics)) > 0.01
    for surface in (Surface(UPPER, arc(10.2, 1.2, 1.2)), Surface(LOWER, arc(10.0, 1.2, 1.2))):
        np.testing.assert_array_equal(rolled(ics, surface, grid), ics)


def test_slip_by_height_is_over_the_radius_of_its_own_circle():
    """Of a height that grows in proportion to x, at the observer's place: x^2 / 2 over R."""
    grid = Grid(30, 4, 0.4, 1.5, 2.0)
    delta = ROLLER.contour.inclination(grid.strips)
    ics = np.zeros((30, 4, 4, 3, 3))
    x = grid.lags[:, None, None, None]
    ics[..., N, :] = x * np.cos(delta)[:, None, None]
    ics[..., S, :] = -x * np.sin(delta)[:, None, None]
    lost = -rolled(ics, ROLLER, grid)[..., X, :]
    radius = 300.0 - ROLLER.contour.position(grid.strips)[1]
    np.testing.assert_allclose(
        lost, np.broadcast_to(x**2 / 2 / radius[:, None, None], lost.shape), rtol=1e-12
    )
