"""The rigid-body discount: what it fits, what it must not touch."""

import numpy as np
import pytest

from approx.variants import approximate
from femic.discount import discount_points, fit_discount, loads_needed, rigid_part, wrench
from femic.solid import raw_ics
from geometries.bodies import LOWER, UPPER
from geometries.materials import one_body
from geometries.patches import Patch
from tests.femic.conftest import PATCH, STEEL, SYMMETRIC, UNSYMMETRIC, request_for

REACH = 9.0
ALL = (0, 1, 2)
RNG = np.random.default_rng(7)


def fitted(contour, side):
    points = discount_points(PATCH, REACH)
    request = request_for(contour, side=side, points=points)
    raw = raw_ics(request).ic
    return request.body, points, raw, fit_discount(request.body, PATCH, points, raw, ALL)


@pytest.fixture(scope="module", params=[(SYMMETRIC, LOWER), (SYMMETRIC, UPPER), (UNSYMMETRIC, LOWER)])
def fit(request):
    return fitted(*request.param)


def test_displacements_of_a_wrench_are_rigid():
    """Phi(I)^T q is the translation plus the rotation about x of the point, seen in its local frame."""
    s = np.array([-7.0, 0.4, 5.0])
    q = np.array([0.3, -0.2, 0.5, 0.1])
    y, z = UNSYMMETRIC.position(s)
    u = q[:3, None] + np.stack([np.zeros_like(y), -q[3] * z, q[3] * y])  # t + phi e_x x r
    delta = UNSYMMETRIC.inclination(s)
    local = [u[0], u[1] * np.cos(delta) - u[2] * np.sin(delta), u[1] * np.sin(delta) + u[2] * np.cos(delta)]
    np.testing.assert_allclose(np.einsum("aip,a->ip", wrench(UNSYMMETRIC, s), q), local, atol=1e-14)


def test_rigid_part_is_reciprocal_between_any_two_positions():
    m = RNG.normal(size=(4, 4))
    m = m + m.T
    for s_i, s_j in RNG.uniform(-9, 9, size=(5, 2)):
        there = rigid_part(m, UNSYMMETRIC, np.array([s_i]), s_j)[..., 0]
        back = rigid_part(m, UNSYMMETRIC, np.array([s_j]), s_i)[..., 0]
        np.testing.assert_allclose(there, back.T, atol=1e-12)


def test_m_is_symmetric_and_only_has_the_entries_of_the_design(fit):
    body, *_, m = fit
    np.testing.assert_array_equal(m, m.T)
    free = {(0, 0), (1, 1), (2, 2), (1, 3), (3, 1)}
    if not body.contour.symmetric:
        free |= {(2, 3), (3, 2), (1, 2), (2, 1)}
    assert {(int(a), int(b)) for a, b in np.argwhere(m != 0)} == free


def test_discounted_ics_meet_the_half_space_where_the_design_says(fit):
    body, points, raw, m = fit
    ic = raw - rigid_part(m, body.contour, points.s, 0.0)
    a = approximate("A", one_body(STEEL, body.side), body.contour, PATCH, (points.x, points.s)) / PATCH.area
    np.testing.assert_allclose(np.diagonal(ic[..., 0]), np.diagonal(a[..., 0]), rtol=1e-10)
    delta = body.contour.inclination(points.s)
    u_z = -np.sin(delta) * ic[1, 1] + np.cos(delta) * ic[2, 1]
    assert u_z[1] - u_z[2] == pytest.approx(a[2, 1, 1] - a[2, 1, 2], rel=1e-9)


def test_a_rigid_compliance_of_the_support_leaves_no_trace(fit):
    """Softer supports add D of some M: the fit takes exactly that M out again."""
    body, points, raw, m = fit
    support = np.where(m != 0, RNG.normal(size=(4, 4)) * 1e-6, 0.0)
    support = support + support.T
    moved = raw + rigid_part(support, body.contour, points.s, 0.0)
    again = fit_discount(body, PATCH, points, moved, ALL)
    np.testing.assert_allclose(again - support, m, atol=1e-10 * np.abs(support).max())


def test_only_what_was_solved_is_fitted():
    body, points, raw, m = fitted(SYMMETRIC, LOWER)
    only_n = raw.copy()
    only_n[:, :2] = np.nan
    m_n = fit_discount(body, PATCH, points, only_n, (2,))
    assert m_n[2, 2] == pytest.approx(m[2, 2])
    assert np.count_nonzero(m_n) == 1


def test_unsymmetric_sections_need_s_and_n_together():
    assert loads_needed(UNSYMMETRIC, (2,)) == (1, 2)
    assert loads_needed(UNSYMMETRIC, (0,)) == (0,)
    assert loads_needed(SYMMETRIC, (2,)) == (2,)


def test_off_centre_loads_are_refused():
    body, points, raw, _ = fitted(SYMMETRIC, LOWER)
    with pytest.raises(ValueError, match=r"patch\.s = 1 mm"):
        fit_discount(body, Patch(0.2, 0.3, s=1.0), points, raw, ALL)
