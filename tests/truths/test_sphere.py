"""The solution of the sphere: Navier, tractions, Betti's theorem, and the limits of its series."""

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from geometries.materials import Material, one_body
from geometries.patches import Patch
from tests.truths.derivatives import gradient
from tests.truths.sphere import (
    DEGREES,
    TERMS,
    coefficients,
    compliance,
    frames,
    green,
    regular_solutions,
    sphere_ics,
    sums,
    swelling,
)

STEEL = Material(210e3, 0.28)
SOFT = Material(2.56, 0.28)  # G = 1
PATCH = Patch(0.2, 0.3)
NUS = pytest.mark.parametrize("nu", [0.0, 0.28, 0.5])
SIDES = pytest.mark.parametrize("side", [+1, -1])

# --- one degree ------------------------------------------------------------------------------------


def harmonic(n, x):
    """(x + i y)^n: value and gradient of the real part."""
    z = x[0] + 1j * x[1]
    return np.real(z**n), np.real(n * z ** (n - 1) * np.array([1, 1j, 0]))


def field(n, nu, which, x):
    """Regular solution 0 or 1 of degree n, of which the surface has U, V."""
    U, V = (row[which] for row in regular_solutions(n, nu)[:2])
    phi, grad = harmonic(n, x)
    return V * (x @ x) ** which * grad + (U - n * V) * phi * x


@NUS
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("n", [2, 3, 7])
def test_regular_solutions_obey_navier(n, which, nu):
    x = np.array([0.5, -0.3, 0.6])
    second = gradient(lambda y: gradient(lambda w: field(n, nu, which, w), y), x)  # u_i,jk
    laplacian, grad_div = np.einsum("ijj->i", second), np.einsum("jji->i", second)
    residual = (1 - 2 * nu) * laplacian + grad_div
    assert np.max(np.abs(residual)) < 1e-7 * n**2


@pytest.mark.parametrize("nu", [0.0, 0.28, 0.4])
@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("n", [2, 3, 7])
def test_tractions_follow_from_displacements(n, which, nu):
    x = np.array([0.64, -0.48, 0.6])
    strain = gradient(lambda y: field(n, nu, which, y), x)
    stress = strain + strain.T + 2 * nu / (1 - 2 * nu) * np.trace(strain) * np.eye(3)
    T_r, T_t = (row[which] for row in regular_solutions(n, nu)[2:])
    phi, grad = harmonic(n, x)
    np.testing.assert_allclose(stress @ x, T_r * phi * x + T_t * (grad - n * phi * x), rtol=1e-8, atol=1e-8)


@NUS
def test_compliance_turns_tractions_into_displacements(nu):
    """Stress diag(-1, -1, 2) is of degree 2: traction 2 Y r + grad Y, displacement half of it."""
    for n in (2.0, 5.0, 40.0):
        U, V, T_r, T_t = (np.array(row) for row in regular_solutions(n, nu))
        np.testing.assert_allclose(compliance(n, nu) @ [T_r, T_t], [U, V], rtol=1e-12)
    np.testing.assert_allclose(compliance(2.0, nu) @ [2, 1], [1, 0.5], rtol=1e-14)


@NUS
def test_compliance_of_large_degree_approaches_the_half_space(nu):
    """Sinusoidal tractions of wave number n; what pulls upwards pushes the surface aside."""
    n = 1e6
    C = compliance(n, nu) * [[n, 1], [n**2, n]]  # T_t and V of the unit vector grad Y / n
    coupling = -(1 - 2 * nu) / 2
    np.testing.assert_allclose(C, [[1 - nu, coupling], [coupling, 1 - nu]], rtol=0, atol=5 / n)


# --- point loads -----------------------------------------------------------------------------------


def scattered(count, seed):
    """Frames at random points of the sphere."""
    lon, height = np.random.default_rng(seed).uniform(-1, 1, (2, count))
    return frames(np.pi * lon, np.arcsin(height))


def test_load_and_observer_may_be_exchanged():
    here, there = scattered(50, 1), scattered(50, 2)
    u, back = green(STEEL, 7.0, here, there), green(STEEL, 7.0, there, here)
    np.testing.assert_allclose(u, np.swapaxes(back, -1, -2), rtol=0, atol=1e-12 * np.max(u))


def over_sphere(load):
    """Points of the unit sphere, weights, global displacements due to global forces at the load."""
    t, w = np.polynomial.legendre.leggauss(100)
    theta = np.pi * ((1 + t) / 2) ** 2  # the kernels times sin(theta) behave like theta ln(theta)
    weights = np.pi * (1 + t) / 2 * w * np.sin(theta) * 2 * np.pi / 16
    theta, phi = np.broadcast_arrays(theta[:, None], np.arange(16) * 2 * np.pi / 16)
    r = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1) @ load
    observers = frames(np.arctan2(r[..., 0], r[..., 2]), np.arcsin(r[..., 1]))
    u = np.swapaxes(observers, -1, -2) @ green(SOFT, 1.0, observers, load) @ load
    return r, np.broadcast_to(weights[:, None], theta.shape), u


LOAD = frames(0.7, -0.4)


def test_no_rigid_motion_is_left():
    r, weights, u = over_sphere(LOAD)
    np.testing.assert_allclose(np.einsum("tp,tpij->ij", weights, u), 0, atol=1e-9)
    moments = np.cross(r[..., None, :], np.swapaxes(u, -1, -2))
    np.testing.assert_allclose(np.einsum("tp,tpji->ij", weights, moments), 0, atol=1e-9)


def test_work_of_a_constant_stress_and_of_a_twist_equals_work_of_the_force():
    """(M x) x x has degree 2 and on the unit sphere with G = 1 the traction of its displacement."""
    stress = np.array([[1.3, -0.4, 0.8], [-0.4, 0.5, 0.2], [0.8, 0.2, -0.6]])
    strain = ((1 + SOFT.nu) * stress - SOFT.nu * np.trace(stress) * np.eye(3)) / SOFT.E
    M = np.array([[1.0, 0.3, -0.5], [0.3, -0.2, 0.7], [-0.5, 0.7, -0.8]])
    r, weights, u = over_sphere(LOAD)
    for traction, work in (
        (r @ stress, strain @ LOAD[2]),
        (np.cross(r @ M, r), np.cross(M @ LOAD[2], LOAD[2])),
    ):
        found = np.einsum("tp,tpi,tpij->j", weights, traction, u)
        np.testing.assert_allclose(found, work, rtol=0, atol=1e-8)


# --- sums over the degrees -------------------------------------------------------------------------

ANGLES = np.array([1e-4, 1e-3, 0.01, 0.1, 0.5, 1.5, 2.8, np.pi])


@NUS
def test_more_degrees_and_more_terms_change_nothing(nu):
    material = Material(2 * (1 + nu), nu)
    at, load = frames(0.3 * ANGLES, ANGLES), frames(0.0, 0.0)
    u = green(material, 1.0, at, load)
    for degrees, terms in ((2 * DEGREES, TERMS), (DEGREES, TERMS + 2), (2 * DEGREES, TERMS - 2)):
        change = np.max(
            np.abs(green(material, 1.0, at, load, degrees=degrees, terms=terms) - u), axis=(-2, -1)
        )
        assert np.all(change * ANGLES < 1e-10)  # of 1 / (4 pi angle)


def cut_off(mu, nu, degrees):
    """The plain sums with a smooth cut-off in n: converge faster than any power."""
    n = np.arange(2.0, degrees)
    C = np.zeros((4, degrees))
    C[0, 0], C[:, 2:] = swelling(nu), coefficients(n, nu)
    C *= np.exp(-36 * (np.arange(degrees) / degrees) ** 8)
    P, above = np.array([1 + 0 * mu, 0 * mu, 0 * mu]), np.array([mu, 1 + 0 * mu, 0 * mu])
    total = np.zeros((3, 4, len(mu)))  # P, P', P''
    for k in range(degrees):
        total += C[:, k, None] * P[:, None]
        rising = (2 * k + 3) * np.array([mu * above[0] / (k + 2), above[0], above[1]])
        P, above = above, rising + np.array([-(k + 1) / (k + 2), 1, 1])[:, None] * P
    return total


@NUS
def test_closed_sums_equal_the_plain_series(nu):
    theta = np.array([0.05, 0.1, 0.5, 1.0, 2.0, 3.0])
    closed, plain = sums(2 * np.sin(theta / 2), nu, DEGREES, TERMS), cut_off(np.cos(theta), nu, 4000)
    error = np.abs(closed - plain) * theta
    assert np.max(error[0, 0]) < 1e-10
    assert np.max(error[1, 1] * np.sin(theta)) < 1e-10
    assert np.max(error[1, 2:]) < 1e-10
    assert np.max(error[2, 2:] * np.sin(theta) ** 2) < 1e-9  # plain sum: rounding of n^2 P_n


# --- patches ---------------------------------------------------------------------------------------

X, S = np.array([0.0, 1.5, -3.0, 2.0, 6.0, -8.0]), np.array([2.0, 0.0, 1.0, -5.0, 7.0, -4.0])


def without_rigid_motion(u):
    """What the three translations and three turns of a plane leave of displacements (3, n)."""
    one, zero = np.ones_like(X), np.zeros_like(X)
    motions = [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
    turns = [[zero, zero, S], [zero, zero, -X], [-S, X, zero]]
    basis = np.reshape(motions + turns, (6, -1)).T
    return u.ravel() - basis @ np.linalg.lstsq(basis, u.ravel())[0]


@SIDES
def test_a_large_sphere_is_a_half_space_to_1_over_radius(side):
    a = HalfSpace(one_body(STEEL, side)).ics(PATCH, X, S) / PATCH.area
    radii = np.array([1e3, 1e4, 1e5])
    for j in range(3):
        rest = [without_rigid_motion((sphere_ics(STEEL, R, side, PATCH, X, S) - a)[:, j]) for R in radii]
        norms = np.linalg.norm(rest, axis=1)
        np.testing.assert_allclose(np.diff(np.log10(norms)), -1, rtol=0, atol=0.02)
        assert norms[0] < 0.02 * np.linalg.norm(a[:, j])


def test_mirror_images_in_the_equator_the_meridian_and_the_tangent_plane():
    below = sphere_ics(STEEL, 9.0, -1, PATCH, X, S)
    for side, x, s, mirror in ((-1, -X, S, [-1, 1, 1]), (-1, X, -S, [1, -1, 1]), (+1, X, S, [1, 1, -1])):
        mirrored = np.einsum("i,ijp,j->ijp", mirror, below, mirror)
        found = sphere_ics(STEEL, 9.0, side, PATCH, x, s)
        np.testing.assert_allclose(found, mirrored, atol=1e-12 * below.max())


def test_paths_over_the_pole_and_along_the_parallel_meet():
    s, R = np.array([3.0, 0.5, 12.0]), 9.0
    half_round = np.pi * R * (1 + np.cos(s / R)) / 2
    along = sphere_ics(STEEL, R, -1, PATCH, half_round, s)
    over = sphere_ics(STEEL, R, -1, PATCH, 0 * s, np.pi * R - s)
    turned = np.array([-1, -1, 1])[:, None, None]
    np.testing.assert_allclose(along, turned * over, atol=1e-10 * np.max(np.abs(over)))


def test_square_patch_is_symmetric_in_equator_and_meridian():
    patch, r, swap = Patch(0.2, 0.2), np.array([1.0, 7.0, 20.0]), [1, 0, 2]
    north = sphere_ics(STEEL, 9.0, -1, patch, 0 * r, r)
    east = sphere_ics(STEEL, 9.0, -1, patch, r, 0 * r)
    # the square is one of arc lengths along x, narrower to the north: to (b / R)^2
    np.testing.assert_allclose(north[swap][:, swap], east, rtol=0, atol=1e-4 * east[2, 2, 0])


def test_patch_is_resolved_by_its_points():
    x, s = np.array([0.6, 0.0, 1.0]), np.array([0.0, 0.8, 1.0])
    ics, finer = sphere_ics(STEEL, 50.0, -1, PATCH, x, s), sphere_ics(STEEL, 50.0, -1, PATCH, x, s, nodes=24)
    np.testing.assert_allclose(ics, finer, rtol=0, atol=1e-7 * np.max(finer))
