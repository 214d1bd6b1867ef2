"""The solution of the hollow cylinder: Navier, boundary conditions, Lame, and the cavity of the theory."""

import numpy as np
import pytest

from geometries.materials import Material
from tests.truths.derivatives import gradient
from tests.truths.hollow_cylinder import (
    amplitudes,
    cavity_compliance,
    compliance,
    line_load_ics,
    pressure,
    solutions,
    twist,
)

STEEL = Material(210e3, 0.28)
R_I, R_O, B = 10.0, 17.0, 1.0
EVERYWHERE = np.pi * R_I * np.array([-1.0, -0.6, -0.2, -0.01, 0.0, 0.005, 0.07, 0.3, 0.999])
NUS = pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
ORDERS = pytest.mark.parametrize("m", [1, 2, 3, 8])


def kappa_of(nu):
    return 3 - 4 * nu


# --- one order -------------------------------------------------------------------------------------


def field(m, nu, load, x):
    """Displacement (along the radius cos(delta), sin(delta)) of order m in Cartesian coordinates."""
    r, delta = np.hypot(*x), np.arctan2(x[1], x[0])
    U, V = solutions(m, kappa_of(nu), r, 1.7)[:2] @ amplitudes(m, kappa_of(nu), 1.7)[:, load]
    radial, tangential = np.array([x[0], x[1]]) / r, np.array([-x[1], x[0]]) / r
    return U * np.cos(m * delta) * radial + V * np.sin(m * delta) * tangential


@NUS
@pytest.mark.parametrize("load", [0, 1])
@ORDERS
def test_displacements_obey_navier(m, load, nu):
    x = np.array([1.2, 0.5])
    second = gradient(lambda y: gradient(lambda w: field(m, nu, load, w), y), x)
    laplacian, grad_div = np.einsum("ijj->i", second), np.einsum("jji->i", second)
    residual = (1 - 2 * nu) * laplacian + grad_div
    assert np.max(np.abs(residual)) < 1e-6 * np.max(np.abs(second))


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.4])
@pytest.mark.parametrize("load", [0, 1])
@ORDERS
def test_traction_at_the_cavity_is_the_load(m, load, nu):
    n = np.array([0.8, 0.6])
    strain = gradient(lambda y: field(m, nu, load, y), n)
    stress = (strain + strain.T) / 2 + nu / (1 - 2 * nu) * np.trace(strain) * np.eye(2)  # 2 G = 1
    traction = -stress @ n
    delta = np.arctan2(n[1], n[0])
    expected = [np.cos(m * delta) * n, np.sin(m * delta) * np.array([-n[1], n[0]])][load]
    np.testing.assert_allclose(traction, expected, rtol=0, atol=1e-7)


@ORDERS
def test_outer_surface_is_fixed_and_inner_surface_has_the_symmetric_compliance(m):
    C = compliance(m, kappa_of(0.28), 1.7)
    for load in (0, 1):
        np.testing.assert_allclose(field(m, 0.28, load, np.array([1.7 * 0.6, 1.7 * 0.8])), 0, atol=1e-14)
        assert field(m, 0.28, load, np.array([1.0, 0.0]))[0] == pytest.approx(C[0, load], rel=1e-13)
    assert C[0, 1] == pytest.approx(C[1, 0], rel=1e-12)
    assert np.all(np.linalg.eigvalsh(C) > 0)


@pytest.mark.parametrize("m", [2, 5, 1000])
def test_far_wall_leaves_the_compliance_of_the_cavity(m):
    C = compliance(m, kappa_of(0.28), 1e3)
    np.testing.assert_allclose(C, cavity_compliance(m, kappa_of(0.28)), rtol=1e-4 / m, atol=1e-15)


def test_thin_wall_is_a_layer_in_uniform_strain():
    """Clamped layer of thickness h: u_n = h (1 - 2 nu) / (2 G (1 - nu)), u_s = h / G per traction."""
    h, nu = 1e-5, STEEL.nu
    layer = np.array([h * (1 - 2 * nu) / (1 - nu) / 2 / STEEL.G, h / STEEL.G])
    assert [pressure(STEEL, 1.0, 1 + h), twist(STEEL, 1.0, 1 + h)] == pytest.approx(layer, rel=1e-4)
    result = np.diag(compliance(3, kappa_of(nu), 1 + h)) / (2 * STEEL.G)
    assert result == pytest.approx(layer, rel=1e-4)


# --- uniform tractions -----------------------------------------------------------------------------


@pytest.mark.parametrize("r_o", [10.5, 17.0, 1e4])
def test_strip_all_round_the_cavity_is_a_uniform_traction(r_o):
    ics = line_load_ics(STEEL, R_I, r_o, np.pi * R_I, EVERYWHERE)
    uniform = np.diag([twist(STEEL, R_I, r_o), pressure(STEEL, R_I, r_o)]) / (2 * np.pi * R_I)
    np.testing.assert_allclose(ics, uniform[..., None] + 0 * ics, rtol=0, atol=1e-13 * np.max(ics))


def test_pressure_matches_lame():
    """u = A r + B / r at rest at r_o, radial stress E A / ((1 + nu)(1 - 2 nu)) - 2 G B / r^2 = -1 at r_i."""
    E, nu, G = STEEL.E, STEEL.nu, STEEL.G
    equations = [[R_O, 1 / R_O], [E / (1 + nu) / (1 - 2 * nu), -2 * G / R_I**2]]
    result = np.array([R_I, 1 / R_I]) @ np.linalg.solve(equations, [0, -1])
    assert pressure(STEEL, R_I, R_O) == pytest.approx(result, rel=1e-13)
    assert pressure(Material(9.0, 0.5), R_I, R_O) == 0


# --- line loads ------------------------------------------------------------------------------------


@pytest.mark.parametrize("r_o", [10.5, 17.0])
def test_strip_is_the_sum_of_its_orders(r_o):
    m, kappa, beta = np.arange(1, 20001), kappa_of(STEEL.nu), B / R_I
    C = np.array([compliance(k, kappa, r_o / R_I) for k in m[:400]])
    C = np.concatenate([C, np.moveaxis(cavity_compliance(m[400:], kappa), -1, 0)])
    loads = np.sinc(m * beta / np.pi) / (2 * np.pi * STEEL.G)
    angles = np.multiply.outer(m, EVERYWHERE / R_I)
    cos, sin = (np.einsum("m,mij,mp->ijp", loads, C, f(angles)) for f in (np.cos, np.sin))
    uniform = np.array([twist(STEEL, R_I, r_o), pressure(STEEL, R_I, r_o)]) / (2 * np.pi * R_I)
    expected = [[cos[1, 1] + uniform[0], sin[1, 0]], [-sin[0, 1], cos[0, 0] + uniform[1]]]
    result = line_load_ics(STEEL, R_I, r_o, B, EVERYWHERE)
    # the next orders: 1 / (beta m^2) over the distance of 0.06 to the edge
    np.testing.assert_allclose(result, expected, rtol=0, atol=1e-6 * np.max(result))


def test_exchanging_load_and_observer_mirrors_s_and_a_full_turn_changes_nothing():
    ics, mirrored, again = (
        line_load_ics(STEEL, R_I, R_O, B, s) for s in (EVERYWHERE, -EVERYWHERE, EVERYWHERE + 2 * np.pi * R_I)
    )
    rounding = {"rtol": 0, "atol": 1e-13 * np.max(ics)}
    np.testing.assert_allclose(mirrored, np.swapaxes(ics, 0, 1), **rounding)
    np.testing.assert_allclose(ics[0, 1], -ics[1, 0], **rounding)
    np.testing.assert_allclose(again, ics, **rounding)


def of_theory(alpha, nu):
    """Cavity in infinite space under a line load, times 4 pi G: directions s, n."""
    kappa, F, L = kappa_of(nu), (alpha - np.pi * np.sign(alpha)) / 2, np.log(2 - 2 * np.cos(alpha))
    nn = (kappa - 1) * np.sin(alpha) * F - (kappa + 1) / 2 * np.cos(alpha) * L
    sn = (kappa - 1) * np.cos(alpha) * F + (kappa + 1) / 2 * np.sin(alpha) * L
    return np.array([[nn, sn], [-sn, nn]])


def without_rigid_motion(u, alpha):
    """What the two translations and the turn leave of displacements (s, n)."""
    cos, sin, one = np.cos(alpha), np.sin(alpha), np.ones_like(alpha)
    basis = np.array([[-sin, cos], [cos, sin], [one, 0 * one]]).reshape(3, -1).T
    return u.ravel() - basis @ np.linalg.lstsq(basis, u.ravel())[0]


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.45])
@pytest.mark.parametrize("load", [0, 1])
def test_far_wall_leaves_the_cavity_functions_of_the_theory(load, nu):
    material, alpha = Material(210e3, nu), np.array([-2.9, -1.0, -0.2, 0.1, 0.6, 1.7, 3.1])
    defects = []
    for r_o in (1e3, 1e4, 1e5):
        ics = 4 * np.pi * material.G * line_load_ics(material, R_I, r_o, 1e-4, alpha * R_I)
        defects.append(np.linalg.norm(without_rigid_motion((ics - of_theory(alpha, nu))[:, load], alpha)))
    np.testing.assert_allclose(np.diff(np.log10(defects)), -2, rtol=0, atol=0.02)
    assert defects[-1] < 1e-6


def test_next_to_the_load_the_wall_is_the_half_space_of_an_upper_body():
    """Flamant: nn = -(1 - nu) / (pi G) ln|s|, sn = -(1 - 2 nu) / (4 G) sgn s."""
    G, nu = STEEL.G, STEEL.nu
    s = 1e-3 * np.array([-3.0, -1.0, 1.0, 3.0])
    ics = line_load_ics(STEEL, R_I, R_O, 1e-6, s)
    log = -(1 - nu) / (np.pi * G) * np.log(3)
    for i in (0, 1):
        assert ics[i, i, 3] - ics[i, i, 2] == pytest.approx(log, rel=1e-3)
    np.testing.assert_allclose(ics[0, 1], -np.sign(s) * (1 - 2 * nu) / (4 * G), rtol=0.01)
