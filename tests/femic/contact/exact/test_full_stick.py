"""Full stick by half-space ICs of the tractions, by elements that stick one after the other, and as Hertz."""

import numpy as np
import pytest
from scipy.integrate import quad

from approx.halfspace import HalfSpace
from femic.contact.exact.friction import StickingPoint
from femic.contact.exact.hertz import PointContact, combined_modulus
from geometries.errors import WrongInput
from geometries.materials import ElasticConstants, Material, both_bodies
from geometries.patches import N, Patch, X

NU, CURVATURE, LOAD = 0.2, 0.05, 800.0
BETAS = [0.5, -0.35, 0.1]
each_beta = pytest.mark.parametrize("beta", BETAS)


def bodies(beta, nu=NU):
    """Half-spaces of a mismatch, with E* = 1000 MPa."""
    return HalfSpace(ElasticConstants(1000.0 * (1 - nu), nu, beta * (1 - nu), 2))


def point(beta):
    return StickingPoint(CURVATURE, 1000.0, beta)


@pytest.mark.parametrize(("beta", "nu"), [(0.5, 0.0), (-0.35, 0.4)])
def test_the_tractions_of_a_point_press_without_slip(beta, nu):
    """The gap is closed, and the tangential displacement is that of all sizes: proportional to r^2."""
    contact, n = point(beta), 100
    a = contact.radius(LOAD)
    middles = a * ((np.arange(n) + 0.5) / n * 2 - 1)
    x, s = (grid.ravel() for grid in np.meshgrid(middles, middles, indexing="ij"))
    r = np.hypot(x, s)
    radii, places = np.unique(np.round(r, 9), return_inverse=True)
    p, q = (values[places] for values in contact.tractions(LOAD, radii))
    tractions = np.stack([q * x / r, q * s / r, p])
    at = a * np.array([0.05, 0.2, 0.4, 0.6, 0.8])
    space, patch = bodies(beta, nu), Patch(a / n, a / n)
    u = np.array([np.einsum("ijk,jk->i", space.ics(patch, x_at - x, -s), tractions) for x_at in at])
    approach = contact.approach(LOAD)
    np.testing.assert_allclose(u[:, N] + CURVATURE * at**2 / 2, approach, rtol=2e-3)
    coefficient = u[-1, X] / at[-1] ** 2
    assert np.sign(coefficient) == -np.sign(beta)  # inwards for K > 0
    np.testing.assert_allclose(u[:, X], coefficient * at**2, atol=1e-3 * approach)
    assert not np.any(contact.tractions(LOAD, 1.01 * a))


@each_beta
def test_tractions_of_a_point_carry_the_load(beta):
    contact = point(beta)
    a = contact.radius(LOAD)
    t = (np.arange(400) + 0.5) / 400
    r = a * (1 - t**2)
    p, q = contact.tractions(LOAD, r)
    assert np.sum(2 * np.pi * r * p * 2 * t * a) / 400 == pytest.approx(LOAD, rel=1e-5)
    assert np.all(np.sign(q[r < 0.99 * a]) == np.sign(beta))


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.49])
def test_rigid_punch_agrees_with_mossakovskii(nu):
    """Load per approach of any indenter is the stiffness of a flat one: 4 G a ln(3 - 4 nu) / (1 - 2 nu)."""
    G = 3.0
    contact = StickingPoint(CURVATURE, 2 * G / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu)))
    loads = LOAD * np.array([1 - 1e-5, 1 + 1e-5])
    stiffness = np.diff(loads)[0] / np.diff([contact.approach(load) for load in loads])[0]
    expected = 4 * G * contact.radius(LOAD) * np.log(3 - 4 * nu) / (1 - 2 * nu)
    assert stiffness == pytest.approx(expected, rel=1e-6)


@each_beta
def test_the_integrals_are_those_by_parts(beta):
    epsilon = np.arctanh(beta) / np.pi

    def turned(t):
        return np.cos(epsilon * np.log((1 + t) / (1 - t)))

    of_point, _ = quad(lambda angle: np.sin(angle) * np.cos(angle) * turned(np.sin(angle)), 0, np.pi / 2)
    assert point(beta).approach_ratio == pytest.approx(1 / (2 * of_point), rel=1e-7)


def test_beta_is_that_of_the_combined_constants():
    soft, stiff = Material(1000.0, 0.1), Material(70e3, 0.3)
    constants = both_bodies(soft, stiff)
    differences = [(1 - 2 * material.nu) / material.G for material in (soft, stiff)]
    dundurs = (differences[0] - differences[1]) * combined_modulus(soft, stiff) / 4
    assert constants.mismatch_k / (1 - constants.nu) == pytest.approx(dundurs, rel=1e-12)


def test_no_mismatch_gives_hertz():
    hertz, contact = PointContact(CURVATURE, CURVATURE, 1000.0).at_load(LOAD), point(0.0)
    assert contact.radius(LOAD) == pytest.approx(hertz.a, rel=1e-12)
    assert contact.approach(LOAD) == pytest.approx(hertz.approach, rel=1e-12)
    r = hertz.a * np.array([0.0, 0.3, 0.99, 1.2])
    p, q = contact.tractions(LOAD, r)
    np.testing.assert_allclose(p, hertz.pressure(r, 0.0), rtol=1e-10)
    assert not np.any(q)


def test_exchanged_bodies_reverse_the_tangential_tractions():
    (p, q), (p_other, q_other) = (point(beta).tractions(LOAD, [0.1, 0.5, 1.0]) for beta in (0.4, -0.4))
    np.testing.assert_allclose(p, p_other, rtol=1e-12)
    np.testing.assert_allclose(q, -q_other, rtol=1e-12)


def test_tractions_are_smooth_in_the_middle():
    """q is r ln(r), and 0 in the centre itself."""
    p, q = point(0.4).tractions(LOAD, [0.0, 1e-8, 1e-4])
    np.testing.assert_allclose(p, p[0], rtol=1e-3)
    assert not q[0]
    assert 0 < q[1] < q[2] < 1e-3 * p[0]


def test_input_outside_the_validity_is_refused():
    with pytest.raises(WrongInput, match=r"beta = 0\.6: must lie in -0\.5 \.\.\. 0\.5"):
        point(0.6)
    with pytest.raises(WrongInput, match=r"curvature = 0\.0: must be positive"):
        StickingPoint(0.0, 1000.0, 0.1)
    with pytest.raises(WrongInput, match=r"load = -1\.0: must be positive"):
        point(0.1).radius(-1.0)
