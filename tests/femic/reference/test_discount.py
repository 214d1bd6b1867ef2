"""The rigid-body discount: what it fits, what it must not touch."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.reference.discount import (
    ENTRIES,
    SourceRule,
    discount,
    fit_discount,
    generalized,
    motions,
    rigid_part,
)
from femic.reference.engine import Points
from geometries.contours import through_points
from geometries.materials import one_body
from geometries.patches import Load, Patch
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import PATCH, STEEL, SYMMETRIC, UNSYMMETRIC, request_for

REACH, ARM = 9.0, 4.0
RULE = SourceRule(PATCH.a, PATCH.b, REACH, ARM)
CENTRAL = tuple(Load(PATCH, j) for j in range(3))
OFF_CENTRE = tuple(Load(Patch(PATCH.a, PATCH.b, 2.5), j) for j in range(3))
RNG = np.random.default_rng(7)
CENTRAL_ENTRIES = {(0, 0), (1, 1), (2, 2), (1, 3), (3, 1)}
COUPLED_ENTRIES = CENTRAL_ENTRIES | {(2, 3), (3, 2), (1, 2), (2, 1)}


class Fit:
    """M of some displacements: it is what conditions make of them, whatever they are."""

    def __init__(self, contour, side, loads, rolling_radius=np.inf):
        self.body = request_for(contour, side=side, rolling_radius=rolling_radius).body
        self.conditions = RULE.conditions(self.body, loads)
        self.points = RULE.points(self.body)
        needed = dict.fromkeys([*loads, *(load for c in self.conditions for load in c.loads)])
        rng = np.random.default_rng(7)
        self.u = {load: 1e-6 * rng.normal(size=(3, len(self.points.x))) for load in needed}
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


@pytest.fixture(params=CASES.values(), ids=CASES)
def fit(request):
    return Fit(*request.param)


@pytest.mark.parametrize("y", [np.linspace(-12, 15, 28), np.linspace(-15, 12, 28)], ids=["right", "left"])
def test_rule_observes_three_elements_away_and_beside_moment_loads(y):
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
    forces = generalized(body, xi, s)
    assert forces.shape == (6, 3, 3)
    np.testing.assert_allclose(np.einsum("aip,a->ip", forces[:4], q), local, atol=1e-14)


WHEELS = [(20.0, UPPER), (60.0, LOWER), (500.0, UPPER), (500.0, LOWER), (1e6, UPPER)]
LAGS = np.array([0.0, -3.0, 8.0, 17.0, -25.0, 40.0, 50.0])
FAR = Points(np.repeat(LAGS, 5), np.tile([-11.0, -4.0, 0.0, 5.0, 9.0], len(LAGS)))


def some_m():
    """A compliance without motions along x that come with others."""
    m = RNG.normal(size=(4, 4))
    m[0, 1:] = m[1:, 0] = 0.0
    return m + m.T


def rigid_m(side, radius):
    """One that a rigid motion of a wheel has: its tilts are those of the axle."""
    m = some_m()
    m[3, 3] = side * m[1, 3] / radius
    m[2, 3] = m[3, 2] = side * m[1, 2] / radius
    return m


def wheel(radius, side, contour=UNSYMMETRIC):
    return request_for(contour, side=side, rolling_radius=radius).body


def discounts(m, body, s_load, points=FAR):
    """D of loads x, s, n, (3 loads, 3, n)."""
    return np.array([rigid_part(m, body, points, Load(Patch(1, 1, s_load), j)) for j in range(3)])


def misfit(body, s_load, u):
    """What the best translation and rotation leave of displacements (3, n), as a share of the largest."""
    xi = body.surface.chart_x(FAR.x, FAR.s, s_load)
    axes, place = body.surface.axes(xi, FAR.s), body.surface.position(xi, FAR.s)
    fields = [np.broadcast_to(e[:, None], place.shape) for e in np.eye(3)]
    fields += [np.cross(e, place, axisb=0, axisc=0) for e in np.eye(3)]
    columns = np.array([np.einsum("icp,cp->ip", axes, field).ravel() for field in fields]).T
    columns /= np.linalg.norm(columns, axis=0)
    left = u.ravel() - columns @ np.linalg.lstsq(columns, u.ravel(), rcond=None)[0]
    return np.abs(left).max() / np.abs(u).max()


@pytest.mark.parametrize("s_load", [0.0, 5.0])
@pytest.mark.parametrize(("radius", "side"), WHEELS)
def test_on_a_wheel_the_discount_is_a_rigid_motion_of_each_load(radius, side, s_load):
    body = wheel(radius, side)
    for u in discounts(rigid_m(side, radius), body, s_load):
        assert misfit(body, s_load, u) < 1e-13


@pytest.mark.parametrize("radius", [60.0, 500.0])
def test_rest_of_the_tilts_of_the_axle_is_rigid_up_to_a_translation_along_y(radius):
    """phi-phi of its own turns each section about its own contact centre, which a rigid turn moves."""
    m = np.zeros((4, 4))
    m[3, 3] = 1.0
    body = wheel(radius, UPPER)
    for direction in (1, 2):  # loads in the section
        u = discounts(m, body, 5.0)[direction]
        theta = body.surface.chart_x(FAR.x, FAR.s, 5.0) / radius
        moment = rigid_moment(body, 5.0, direction)
        along_y = moment * radius * (1 - np.cos(theta)) * body.surface.axes(0.0 * FAR.s, FAR.s)[:, 1]
        assert misfit(body, 5.0, u - along_y) < 1e-13 < misfit(body, 5.0, u)


def rigid_moment(body, s, direction):
    """About x, through the contact centre, of a unit load at x = 0."""
    (_, y, z), force = body.surface.position(0.0, s), body.surface.axes(0.0, s)[direction]
    return y * force[2] - z * force[1]


@pytest.mark.parametrize("entry", [(3, 3), (2, 3)], ids=["phi-phi", "z-phi"])
def test_turns_of_sections_are_those_of_the_prismatic_body_at_x_0(entry):
    m = np.zeros((4, 4))
    m[entry] = m[entry[::-1]] = 1.0
    bodies = wheel(60.0, UPPER), request_for(UNSYMMETRIC, side=UPPER).body
    s = FAR.s[FAR.x == 0]
    here, there = (generalized(bodies[1], 0 * s, at)[:4] for at in (s, np.full_like(s, 5.0)))
    by_definition = np.einsum("aip,ab,bjp->jip", here, m, there)  # Phi^T M Phi
    for body in bodies:
        np.testing.assert_allclose(discounts(m, body, 5.0)[..., FAR.x == 0], by_definition, atol=1e-13)
    assert np.abs(by_definition).max() > 1


def test_the_discount_at_the_contact_centre_is_that_of_the_theory():
    """D_xx = M_zz cos + (M_xx - M_zz) R(I) R(J) / R^2, D_nn = M_zz cos, D_xn = -D_nx = M_zz sin."""
    m, R = some_m(), 60.0
    body = wheel(R, UPPER, SYMMETRIC)
    for s_load, s in ((0.0, 0.0), (0.0, 7.0), (4.0, -7.0)):
        m[1, 3] = m[3, 1] = m[3, 3] = m[1, 2] = m[2, 1] = m[2, 3] = m[3, 2] = 0.0
        x = np.array([-20.0, 0.0, 13.0])
        theta = body.surface.chart_x(x, s, s_load) / R
        d = discounts(m, body, s_load, Points(x, np.full(3, s)))
        radii = body.surface.circle_radius(s) * body.surface.circle_radius(s_load) / R**2
        np.testing.assert_allclose(d[0, 0], m[2, 2] * np.cos(theta) + (m[0, 0] - m[2, 2]) * radii, rtol=1e-12)
        lean = np.cos(body.contour.inclination(np.array([s, s_load])))
        in_y = m[1, 1] * np.prod(np.sin(body.contour.inclination(np.array([s, s_load]))))
        np.testing.assert_allclose(d[2, 2], m[2, 2] * np.cos(theta) * np.prod(lean) + in_y, rtol=1e-12)
        np.testing.assert_allclose(d[2, 0], m[2, 2] * np.sin(theta) * lean[1], rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(d[0, 2], -m[2, 2] * np.sin(theta) * lean[0], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(("radius", "side"), [*WHEELS, (np.inf, LOWER)])
def test_rigid_part_is_reciprocal_between_any_two_positions(radius, side):
    m, body = some_m(), wheel(radius, side)

    def between(x, s, s_load):
        return discounts(m, body, s_load, Points(np.array([x]), np.array([s])))[..., 0]

    for x, s_i, s_j in zip(
        RNG.uniform(-50, 50, 9), RNG.uniform(-9, 9, 9), RNG.uniform(-9, 9, 9), strict=True
    ):
        there, back = between(x, s_i, s_j), between(-x, s_j, s_i)
        np.testing.assert_allclose(there, back.T, atol=1e-12 * np.abs(there).max())


def test_a_wheel_of_infinite_radius_is_prismatic():
    """The difference falls like 1 / R_roll."""
    m = some_m()
    limit = discounts(m, request_for(UNSYMMETRIC, side=UPPER).body, 4.0)
    far, further = (np.abs(discounts(m, wheel(R, UPPER), 4.0) - limit).max() for R in (1e6, 1e7))
    assert 1e-5 < far < 1e-2
    assert further == pytest.approx(far / 10, rel=0.01)


def test_m_is_symmetric_and_only_has_the_entries_of_the_theory(fit):
    np.testing.assert_array_equal(fit.m, fit.m.T)
    free = CENTRAL_ENTRIES if fit.body.contour.symmetric else COUPLED_ENTRIES
    if OFF_CENTRE[0] in fit.u:
        free = free | {(3, 3)}
    assert {(int(a), int(b)) for a, b in np.argwhere(fit.m != 0)} == free


def test_discounted_ics_meet_the_half_space_where_the_rule_says(fit):
    for j, load in enumerate(CENTRAL):
        if load in fit.u:
            assert fit.discounted(load)[j, 0] == pytest.approx(fit.half_space("A", load)[j, j, 0], rel=1e-10)
    u, a = fit.discounted(CENTRAL[1]), fit.half_space("A", CENTRAL[1])
    delta = fit.body.contour.inclination(fit.points.s)
    u_z = -np.sin(delta) * u[1] + np.cos(delta) * u[2]
    assert u_z[1] - u_z[2] == pytest.approx(a[2, 1, 1] - a[2, 1, 2], rel=1e-9)


@pytest.mark.parametrize("case", ["unsymmetric", "off centre, unsymmetric"])
def test_on_unsymmetric_sections_normal_loads_do_not_tilt_and_coupling_vanishes_near(case):
    fit = Fit(*CASES[case])
    u_s, u_n = (fit.u[load] - rigid_part(fit.m, fit.body, fit.points, load) for load in CENTRAL[1:])
    delta, largest = fit.body.contour.inclination(fit.points.s), np.abs(u_n).max()
    u_z = -np.sin(delta) * u_n[1] + np.cos(delta) * u_n[2]
    assert u_z[1] - u_z[2] == pytest.approx(0, abs=1e-9 * largest)
    assert u_n[1, 0] + u_s[2, 0] == pytest.approx(0, abs=1e-9 * largest)


@pytest.mark.parametrize("contour", [SYMMETRIC, UNSYMMETRIC], ids=["symmetric", "unsymmetric"])
def test_moment_loads_turn_as_b_hat_does(contour):
    """Of the one on a symmetric section; of the two on others by as much more as the other one less."""
    fit = Fit(contour, LOWER, OFF_CENTRE)
    outwards = []
    for side, (right, left) in ((1, (3, 4)), (-1, (5, 6))):
        load = RULE.moment_load(side)
        if load in fit.u:
            difference = fit.discounted(load)[2] - fit.half_space("Bhat", load)[2, 2]
            outwards.append(side * (difference[right] - difference[left]))
    assert len(outwards) == 2 - contour.symmetric
    assert sum(outwards) == pytest.approx(0, abs=1e-9 * np.abs(fit.u[RULE.moment_load()]).max())
    assert fit.points.s[3] - ARM == pytest.approx(ARM - fit.points.s[4])  # equally far on both sides


def test_rigid_compliance_of_the_support_has_no_effect(fit):
    """Softer supports add D of some M: the fit takes exactly that M out again."""
    support = np.where(fit.m != 0, RNG.normal(size=(4, 4)) * 1e-6, 0.0)
    support = support + support.T
    moved = {load: u + rigid_part(support, fit.body, fit.points, load) for load, u in fit.u.items()}
    np.testing.assert_allclose(fit.again(moved) - support, fit.m, atol=1e-10 * np.abs(support).max())


@pytest.mark.parametrize("contour", [SYMMETRIC, UNSYMMETRIC], ids=["symmetric", "unsymmetric"])
@pytest.mark.parametrize("radius", [np.inf, 60.0])
def test_entries_of_m_do_not_depend_on_what_else_is_asked(radius, contour):
    """Each entry that two questions determine is the same, whatever else they ask."""
    every = Fit(contour, UPPER, (*CENTRAL, *OFF_CENTRE), radius)
    for asked in (CENTRAL[:1], CENTRAL[1:2], CENTRAL[2:], CENTRAL, OFF_CENTRE[2:], OFF_CENTRE[:1]):
        m = fit_discount(every.body, RULE, RULE.conditions(every.body, asked), every.u)
        determined = m != 0
        np.testing.assert_allclose(m[determined], every.m[determined], rtol=1e-9)
        for load in asked:  # and nothing else matters for these loads
            parts = [rigid_part(one, every.body, every.points, load) for one in (m, every.m)]
            np.testing.assert_allclose(*parts, rtol=1e-9, atol=1e-12 * np.abs(parts[0]).max())


MOMENT, OTHER_MOMENT = RULE.moment_load(), RULE.moment_load(-1)
LOADS_NEEDED = [
    (SYMMETRIC, np.inf, CENTRAL[2], {CENTRAL[2]}),
    (SYMMETRIC, np.inf, CENTRAL[0], {CENTRAL[0]}),
    (UNSYMMETRIC, np.inf, CENTRAL[0], {CENTRAL[0]}),
    (UNSYMMETRIC, np.inf, CENTRAL[2], {CENTRAL[1], CENTRAL[2]}),
    (SYMMETRIC, np.inf, OFF_CENTRE[0], {CENTRAL[0]}),
    (SYMMETRIC, np.inf, OFF_CENTRE[2], {CENTRAL[1], CENTRAL[2], MOMENT}),
    (UNSYMMETRIC, np.inf, OFF_CENTRE[2], {CENTRAL[1], CENTRAL[2], MOMENT, OTHER_MOMENT}),
    (SYMMETRIC, 60.0, CENTRAL[2], {CENTRAL[2]}),
    (SYMMETRIC, 60.0, CENTRAL[1], {CENTRAL[1]}),
    (SYMMETRIC, 60.0, CENTRAL[0], {CENTRAL[0], CENTRAL[2]}),
    (UNSYMMETRIC, 60.0, CENTRAL[0], set(CENTRAL)),
    (SYMMETRIC, 60.0, OFF_CENTRE[0], {*CENTRAL, MOMENT}),
]


@pytest.mark.parametrize(("contour", "radius", "asked", "needed"), LOADS_NEEDED)
def test_no_more_loads_are_solved_for_m_than_it_needs(contour, radius, asked, needed):
    body = wheel(radius, UPPER, contour)
    fit = RULE.conditions(body, (asked,))
    assert {load for c in fit for load in c.loads} == needed
    beside_moment_loads = any(load.patch.s == ARM for load in needed)
    assert len(RULE.observers(body, fit).x) == (7 if beside_moment_loads else 3)


@pytest.mark.parametrize("body", [wheel(60.0, UPPER), wheel(np.inf, LOWER)], ids=["wheel", "rail"])
def test_motions_on_a_grid_and_of_some_entries_are_those_at_points_and_among_all(body):
    """Also in whole millimetres, and in any order; on a prismatic body they are the same at all x."""
    x, s = np.arange(1, 5), np.arange(-1, 3)
    every = motions(body, Points(x[:, None], s[None]), 0.4)
    all_x, all_s = (v.ravel().astype(float) for v in np.meshgrid(x, s, indexing="ij"))
    at_points = motions(body, Points(all_x, all_s), 0.4)
    np.testing.assert_allclose(every.reshape(at_points.shape), at_points, atol=1e-12)
    asked = ENTRIES[4], ENTRIES[2], ENTRIES[5]
    some = motions(body, Points(x[:, None], s[None]), 0.4, asked)
    np.testing.assert_array_equal(some, every[[4, 2, 5]])
    m = np.random.default_rng(1).normal(size=(4, 4))
    only = np.zeros((4, 4))
    for entry in asked:
        only[entry] = m[entry]
    np.testing.assert_allclose(discount(m, some, asked), discount(only, every), atol=1e-12)
    assert np.allclose(every, every[:, :, :, :1]) == np.isinf(body.rolling_radius)
