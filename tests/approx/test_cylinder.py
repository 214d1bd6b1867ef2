"""Line loads on circles against Fourier series and the half-plane."""

import numpy as np
import pytest

from approx.cylinder import cavity_ics, half_plane_ics, solid_cylinder_ics
from approx.forms import rotation_about_x
from approx.halfspace import HalfSpace
from geometries.errors import WrongInput
from geometries.materials import Material, one_body
from geometries.patches import Patch

STEEL = Material(210e3, 0.28)
MATERIALS = [STEEL, Material(1.0, 0.0), Material(3.0, 0.5)]
each_material = pytest.mark.parametrize("material", MATERIALS, ids=["steel", "cork", "rubber"])
ALPHA = np.array([1e-9, 0.03, 0.7, -1.9, 3.0, -3.14159, np.pi])
CIRCLES = {"cavity": (cavity_ics, +1), "solid": (solid_cylinder_ics, -1)}
each_circle = pytest.mark.parametrize(("ics", "side"), CIRCLES.values(), ids=CIRCLES)

# --- Fourier series --------------------------------------------------------------------------------
#
# Displacements r^p (U cos m theta, V sin m theta) in directions (n, s) that satisfy Navier's equations; on
# r = 1 a unit line load is 1 / (2 pi) + sum cos(m theta) / pi. Poisson's ratio 0.5 is left to the limit.


def stresses(p, m, nu):
    """rr, tt (cos) and rt (sin) on r = 1, each a row that acts on (U, V); G = 1."""
    lame = 2 * nu / (1 - 2 * nu)
    dilatation = lame * np.array([p + 1, m])
    rr, tt, rt = np.array([[2 * p, 0], [2, 2 * m], [-m, p - 1]])
    return rr + dilatation, tt + dilatation, rt


def shape_and_tractions(p, m, nu):
    """(U, V) in equilibrium, and its rr, rt."""
    rr, tt, rt = stresses(p, m, nu)
    balance = np.array([p * rr + m * rt - tt, (p + 1) * rt - m * tt])
    shape = np.linalg.svd(balance)[2][-1]
    assert np.allclose(balance @ shape, 0, atol=1e-12 * np.abs(balance).max())
    return shape, np.array([rr @ shape, rt @ shape])


def mode(m, nu, side):
    """Displacements (n, s) due to tractions cos(m theta) n and sin(m theta) s on r = 1, (2, 2)."""
    exponents = (-side * m - 1, -side * m + 1)  # decaying outwards for the cavity, regular in the solid
    shapes, tractions = zip(*(shape_and_tractions(p, m, nu) for p in exponents), strict=True)
    return np.array(shapes).T @ np.linalg.inv(-side * np.array(tractions).T)  # outward normal: -side n


def half_circle():
    """Nodes in 0 ... pi that crowd towards 0, where there is a logarithm, and weights."""
    u, weights = np.polynomial.legendre.leggauss(400)
    u = (u + 1) / 2
    return np.pi * u**3, 3 * np.pi * u**2 / 2 * weights


def coefficient(function, m, parity):
    """Fourier coefficient of a function of alpha, even (cos) or odd (sin)."""
    t, weights = half_circle()
    return 2 / np.pi * np.sum(weights * function(t) * (np.cos(m * t) if parity > 0 else np.sin(m * t)))


@each_circle
@pytest.mark.parametrize("m", [2, 3, 7])
@pytest.mark.parametrize("nu", [0.0, 0.28, 0.45])
def test_every_harmonic_is_that_of_the_series(ics, side, m, nu):
    """m >= 2: self-balanced, no rigid motion."""
    material = Material(2 * (1 + nu), nu)  # G = 1
    compliance = mode(m, nu, side) / np.pi  # rows n, s; loads cos n, sin s
    # a line load along s is a sum of cos(m theta) s, a quarter of a turn from sin(m theta) s
    expected = [[compliance[1, 1], compliance[1, 0]], [-compliance[0, 1], compliance[0, 0]]]
    for i, j in np.ndindex(2, 2):
        result = coefficient(lambda t, i=i, j=j: ics(material, t)[i, j], m, +1 if i == j else -1)
        assert result == pytest.approx(expected[i][j], rel=1e-8, abs=1e-11)


def test_uniform_pressure_widens_cavity_and_cylinder_by_lame_s_formula():
    for nu in (0.0, 0.28, 0.45):
        material = Material(2 * (1 + nu), nu)
        for (ics, _), expected in zip(CIRCLES.values(), (1 / 2, (1 - 2 * nu) / 2), strict=True):
            mean = coefficient(lambda t, ics=ics, material=material: ics(material, t)[1, 1], 0, +1) / 2
            assert 2 * np.pi * mean == pytest.approx(expected, rel=1e-8, abs=1e-9)


def test_a_loaded_cavity_is_kelvin_and_a_mode_that_fades():
    """m = 1, a force: Kelvin's line force and r^-2 carry cos(theta) n, up to a translation."""
    nu, kappa = 0.28, 3 - 4 * 0.28
    shape, tractions = shape_and_tractions(-2, 1, nu)
    # Kelvin, force pi along theta = 0: u_r = (1 - kappa ln r) cos, u_t = kappa ln r sin, over 8 (1 - nu)
    strain_rr, strain_tt, shear = np.array([-kappa, 1, kappa - 1]) / (8 * (1 - nu))
    kelvin_rr = 2 * strain_rr + 2 * nu / (1 - 2 * nu) * (strain_rr + strain_tt)
    carried = -np.array([tractions, [kelvin_rr, shear]]).T
    share, force = np.linalg.solve(carried, [1.0, 0.0])
    assert force == pytest.approx(1.0)  # cos(theta) n has the resultant pi
    material = Material(2 * (1 + nu), nu)
    u_n = np.pi * coefficient(lambda t: cavity_ics(material, t)[1, 1], 1, +1)
    u_s = np.pi * coefficient(lambda t: cavity_ics(material, t)[0, 1], 1, -1)
    expected = share * np.sum(shape) + force / (8 * (1 - nu))
    assert u_n + u_s == pytest.approx(expected, rel=1e-8)  # a translation adds (c, -c)


# --- half-plane --------------------------------------------------------------------------------------


@pytest.mark.parametrize("side", [+1, -1])
def test_half_plane_is_the_strip_limit_of_the_half_space(side):
    long_strip, s = Patch(1e7, 1e-4), np.array([0.3, -2.0])
    a = HalfSpace(one_body(STEEL, side)).ics(long_strip, 0.0, s)[1:, 1:] / (2 * long_strip.b)
    flamant = half_plane_ics(STEEL, side, s, 1.0)
    np.testing.assert_allclose(a[[0, 1], [1, 0]], flamant[[0, 1], [1, 0]], rtol=1e-6)
    rise = np.diff(a[[0, 1], [0, 1]], axis=-1)  # between the two observers: no constant
    np.testing.assert_allclose(rise, np.diff(flamant[[0, 1], [0, 1]], axis=-1), rtol=1e-6)
    assert not np.any(half_plane_ics(STEEL, side, [1.0, -1.0], 1.0)[[0, 1], [0, 1]])


@each_circle
@each_material
def test_close_to_the_load_a_circle_is_a_half_plane(ics, side, material):
    alpha = np.array([1e-8, -3e-6])
    circle, plane = ics(material, alpha), half_plane_ics(material, side, alpha, 1.0)
    uniform = np.array([0.0, (1 - material.nu) / (2 * np.pi * material.G) if side < 0 else 0.0])
    circle[[0, 1], [0, 1]] += uniform[:, None]
    np.testing.assert_allclose(circle, plane, atol=1e-4 / material.G)  # alpha ln(alpha)


# --- B's structure -------------------------------------------------------------------------------------


@each_circle
@each_material
def test_circles_equal_b_of_the_half_plane_at_the_chord_with_sn_fading(ics, side, material):
    """B = A R(alpha) in (s, n); A_sn, A_ns times (pi - |alpha|) / pi."""
    chord = 2 * np.sin(ALPHA / 2)
    a = half_plane_ics(material, side, chord, 1.0)
    a[[0, 1], [1, 0]] *= (np.pi - np.abs(ALPHA)) / np.pi
    rotation = rotation_about_x(ALPHA).matrix[1:, 1:]
    b = np.einsum("ikp,kjp->ijp", a, rotation)
    if side < 0:
        b[1, 1] -= (1 - material.nu) / (2 * np.pi * material.G)
    np.testing.assert_allclose(ics(material, ALPHA), b, atol=2e-14 / material.G)


@each_circle
def test_circles_are_reciprocal_periodic_and_odd_where_they_should_be(ics, side):  # noqa: ARG001
    at = ics(STEEL, ALPHA)
    np.testing.assert_array_equal(ics(STEEL, -ALPHA), np.swapaxes(at, 0, 1))
    np.testing.assert_array_equal(at[0, 1], -at[1, 0])
    once_round = ics(STEEL, ALPHA[1:] + 2 * np.pi)
    np.testing.assert_allclose(once_round, at[..., 1:], rtol=0, atol=1e-13 * np.max(at))


def test_tiny_angles_keep_their_digits():
    """ln(2 - 2 cos a) would be ln 0 at 1e-9; the next term is sin(a) F."""
    alpha = np.array([1e-9, 1e-200])
    nn = cavity_ics(STEEL, alpha)[1, 1] * np.pi * STEEL.G / (1 - STEEL.nu)
    next_term = np.pi * alpha * (1 - 2 * STEEL.nu) / (4 * (1 - STEEL.nu))
    np.testing.assert_allclose(nn, -np.log(alpha) - next_term, rtol=1e-14)


@pytest.mark.parametrize("alpha", [0.0, np.nan, [0.3, np.inf]])
def test_loaded_line_and_infinite_angles_are_refused(alpha):
    with pytest.raises(WrongInput, match="alpha: must be finite and not 0"):
        cavity_ics(STEEL, alpha)
