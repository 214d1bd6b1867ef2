"""The rigid-body discount: what it fits, what it must not touch."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.discount import DiscountRule, conditions, fit_discount, observers, rigid_part, wrench
from femic.models import Points
from femic.solid.engine import raw_ics
from geometries.contours import through_points
from geometries.materials import one_body
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.conftest import PATCH, STEEL, SYMMETRIC, UNSYMMETRIC, request_for

REACH, ARM = 9.0, 4.0
RULE = DiscountRule(PATCH.a, PATCH.b, REACH, ARM)
CENTRAL = tuple(Load(PATCH, j) for j in range(3))
OFF_CENTRE = tuple(Load(Patch(PATCH.a, PATCH.b, 2.5), j) for j in range(3))
RNG = np.random.default_rng(7)
CENTRAL_ENTRIES = {(0, 0), (1, 1), (2, 2), (1, 3), (3, 1)}
COUPLED_ENTRIES = CENTRAL_ENTRIES | {(2, 3), (3, 2), (1, 2), (2, 1)}


class Fit:
    """M of a coarse model, and what it was fitted from."""

    def __init__(self, contour, side, loads, **changes):
        self.body = request_for(contour, side=side, **changes).body
        self.conditions = conditions(self.body, RULE, loads)
        self.points = RULE.points(self.body)
        needed = tuple(dict.fromkeys([*loads, *(load for c in self.conditions for load in c.loads)]))
        request = request_for(contour, side=side, points=self.points, **changes)
        raw = raw_ics(type(request)(self.body, needed, self.points, request.cells, "multigrid"))
        self.u = dict(zip(needed, raw.u, strict=True))
        self.m = self.again(self.u)

    def again(self, u):
        return fit_discount(self.body, RULE, self.conditions, u)

    def discounted(self, load):
        return self.u[load] - rigid_part(self.m, self.body, self.points, load)

    def half_space(self, variant, load):
        solid, at = HalfSpace(one_body(STEEL, self.body.side)), (self.points.x, self.points.s)
        return approximate(variant, solid, self.body.surface, load.patch, at) / load.patch.area


CASES = {
    "symmetric": (SYMMETRIC, LOWER, CENTRAL),
    "upper": (SYMMETRIC, UPPER, CENTRAL),
    "unsymmetric": (UNSYMMETRIC, LOWER, CENTRAL),
    "off centre": (SYMMETRIC, UPPER, OFF_CENTRE),
    "off centre, unsymmetric": (UNSYMMETRIC, UPPER, OFF_CENTRE),
    "revolved": (SYMMETRIC, UPPER, OFF_CENTRE, 60.0),
}


@pytest.fixture(scope="module", params=CASES.values(), ids=CASES)
def fit(request):
    contour, side, loads, *radius = request.param
    return Fit(contour, side, loads, **({"rolling_radius": radius[0]} if radius else {}))


@pytest.mark.parametrize("y", [np.linspace(-12, 15, 28), np.linspace(-15, 12, 28)], ids=["right", "left"])
def test_the_rule_looks_three_elements_away_and_on_both_sides_of_moment_loads(y):
    contour = through_points(y, -(y**2) / 40)  # longer on one side
    points = RULE.points(request_for(contour).body)
    np.testing.assert_allclose(points.x, [3 * 2 * PATCH.a, 0, 0, 0, 0, 0, 0], rtol=1e-14)
    low, high = contour.extent
    beside = min(-low, high) - ARM  # less than REACH: both loads have the same, within the contour
    assert 0 < beside < REACH
    around = [ARM + beside, ARM - beside, -ARM + beside, -ARM - beside]
    np.testing.assert_allclose(points.s, [0, REACH, -REACH, *around], rtol=1e-12)


@pytest.mark.parametrize("rolling_radius", [np.inf, 60.0])
def test_displacements_of_a_wrench_are_rigid(rolling_radius):
    """Phi(I)^T q is the translation plus the rotation about x of the point, seen in its local frame."""
    body = request_for(UNSYMMETRIC, side=UPPER, rolling_radius=rolling_radius).body
    xi, s = np.array([0.0, 3.0, -8.0]), np.array([-7.0, 0.4, 5.0])
    q = np.array([0.3, -0.2, 0.5, 0.1])
    position = body.surface.position(xi, s)
    u = q[:3, None] + np.cross([q[3], 0, 0], position.T).T  # t + phi e_x x r
    delta, theta = UNSYMMETRIC.inclination(s), xi / rolling_radius
    across = u[1], np.cos(theta) * u[2] - np.sin(theta) * u[0]  # in the observer's section
    local = [
        np.cos(theta) * u[0] + np.sin(theta) * u[2],
        across[0] * np.cos(delta) - across[1] * np.sin(delta),
        across[0] * np.sin(delta) + across[1] * np.cos(delta),
    ]
    np.testing.assert_allclose(np.einsum("aip,a->ip", wrench(body, xi, s), q), local, atol=1e-14)


def test_rigid_part_is_reciprocal_between_any_two_positions():
    m = RNG.normal(size=(4, 4))
    m = m + m.T

    def between(body, x, s, s_load):
        points, patch = Points(np.array([x]), np.array([s])), Patch(1, 1, s_load)
        return np.array([rigid_part(m, body, points, Load(patch, j))[:, 0] for j in range(3)])

    prismatic = request_for(UNSYMMETRIC).body
    wheel = request_for(UNSYMMETRIC, side=UPPER, rolling_radius=60.0).body
    for body in (prismatic, wheel):
        for s_i, s_j, x in RNG.uniform(-9, 9, size=(5, 3)):
            there, back = between(body, x, s_i, s_j), between(body, -x, s_j, s_i)
            np.testing.assert_allclose(there, back.T, atol=1e-12)


def test_the_rigid_part_is_seen_by_observers_where_they_are():
    """On a wheel the angle between them is their distance over the mean radius, half of it to each."""
    m = RNG.normal(size=(4, 4))
    m = m + m.T
    body = request_for(UNSYMMETRIC, side=UPPER, rolling_radius=60.0).body
    points, load = Points(np.array([3.0, -8.0]), np.array([-7.0, 5.0])), Load(Patch(1, 1, 2.5), 1)
    radii = body.surface.circle_radius(points.s), body.surface.circle_radius(load.patch.s)
    xi = body.rolling_radius * points.x / np.mean(np.broadcast_arrays(*radii), axis=0)
    moved = m @ wrench(body, -xi / 2, np.full(2, load.patch.s))[:, load.direction]
    expected = np.einsum("aip,ap->ip", wrench(body, xi / 2, points.s), moved)
    np.testing.assert_allclose(rigid_part(m, body, points, load), expected, rtol=1e-12)


def test_m_is_symmetric_and_only_has_the_entries_of_the_design(fit):
    np.testing.assert_array_equal(fit.m, fit.m.T)
    free = CENTRAL_ENTRIES if fit.body.contour.symmetric else COUPLED_ENTRIES
    if OFF_CENTRE[0] in fit.u:
        free = free | {(3, 3)}
    assert {(int(a), int(b)) for a, b in np.argwhere(fit.m != 0)} == free


def test_discounted_ics_meet_the_half_space_where_the_design_says(fit):
    for j, load in enumerate(CENTRAL):
        if load in fit.u:
            assert fit.discounted(load)[j, 0] == pytest.approx(fit.half_space("A", load)[j, j, 0], rel=1e-10)
    u, a = fit.discounted(CENTRAL[1]), fit.half_space("A", CENTRAL[1])
    delta = fit.body.contour.inclination(fit.points.s)
    u_z = -np.sin(delta) * u[1] + np.cos(delta) * u[2]
    assert u_z[1] - u_z[2] == pytest.approx(a[2, 1, 1] - a[2, 1, 2], rel=1e-9)


def test_the_moment_load_turns_as_b_hat_does():
    fit = Fit(SYMMETRIC, LOWER, OFF_CENTRE)
    load = RULE.moment_load()
    c, b_hat = fit.discounted(load)[2], fit.half_space("Bhat", load)[2, 2]
    assert fit.points.s[3] - ARM == pytest.approx(ARM - fit.points.s[4])  # equally far on both sides
    assert c[3] - c[4] == pytest.approx(b_hat[3] - b_hat[4], rel=1e-9)


def test_without_symmetry_moment_loads_on_both_sides_turn_as_b_hat_does():
    fit = Fit(UNSYMMETRIC, LOWER, OFF_CENTRE)
    outwards = []
    for side, (right, left) in ((1, (3, 4)), (-1, (5, 6))):
        load = RULE.moment_load(side)
        difference = fit.discounted(load)[2] - fit.half_space("Bhat", load)[2, 2]
        outwards.append(side * (difference[right] - difference[left]))
    assert outwards[0] == pytest.approx(-outwards[1], rel=1e-6)


def test_a_rigid_compliance_of_the_support_leaves_no_trace(fit):
    """Softer supports add D of some M: the fit takes exactly that M out again."""
    support = np.where(fit.m != 0, RNG.normal(size=(4, 4)) * 1e-6, 0.0)
    support = support + support.T
    moved = {load: u + rigid_part(support, fit.body, fit.points, load) for load, u in fit.u.items()}
    np.testing.assert_allclose(fit.again(moved) - support, fit.m, atol=1e-10 * np.abs(support).max())


def test_off_centre_loads_share_the_m_of_a_central_one():
    """At s = 0 M reproduces the procedure for a single load: only phi-phi is new."""
    central, off_centre = (Fit(UNSYMMETRIC, LOWER, loads) for loads in (CENTRAL, (*CENTRAL, *OFF_CENTRE)))
    same_model = central.again(off_centre.u)
    without = off_centre.m.copy()
    without[3, 3] = 0.0
    np.testing.assert_allclose(without, same_model, rtol=1e-9)
    for load in CENTRAL:  # a load at s = 0 has no moment
        rigid = [rigid_part(m, central.body, central.points, load) for m in (off_centre.m, same_model)]
        np.testing.assert_allclose(*rigid, rtol=1e-9, atol=1e-12 * np.abs(rigid[0]).max())


def test_only_what_was_asked_is_fitted():
    fit = Fit(SYMMETRIC, LOWER, (CENTRAL[2],))
    assert np.count_nonzero(fit.m) == 1
    assert list(fit.u) == [CENTRAL[2]]


LOADS_NEEDED = [
    (SYMMETRIC, CENTRAL[2], {CENTRAL[2]}),
    (SYMMETRIC, CENTRAL[0], {CENTRAL[0]}),
    (UNSYMMETRIC, CENTRAL[0], {CENTRAL[0]}),
    (UNSYMMETRIC, CENTRAL[2], {CENTRAL[1], CENTRAL[2]}),
    (SYMMETRIC, OFF_CENTRE[0], {CENTRAL[0]}),
    (SYMMETRIC, OFF_CENTRE[2], {CENTRAL[1], CENTRAL[2], RULE.moment_load()}),
    (
        UNSYMMETRIC,
        OFF_CENTRE[2],
        {CENTRAL[1], CENTRAL[2], RULE.moment_load(), RULE.moment_load(-1)},
    ),
]


@pytest.mark.parametrize(("contour", "asked", "needed"), LOADS_NEEDED)
def test_no_more_loads_are_solved_for_m_than_it_needs(contour, asked, needed):
    body = request_for(contour).body
    fit = conditions(body, RULE, (asked,))
    assert {load for c in fit for load in c.loads} == needed
    beside_moment_loads = any(load.patch.s == ARM for load in needed)
    assert len(observers(body, RULE, fit).x) == (7 if beside_moment_loads else 3)
