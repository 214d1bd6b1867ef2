"""Stresses inside half-spaces: point loads, quadrature, equilibrium, Hertz, the staircase of elements."""

from dataclasses import replace

import numpy as np
import pytest

from approx.halfspace import HalfSpace
from femic.stresses.field import tresca
from femic.stresses.half_space import fields, half_space_field, hooke_stress, lattice_corners
from femic.stresses.points import InnerPoints, SurfaceTractions
from geometries.errors import WrongInput
from geometries.materials import Material, one_body
from geometries.patches import Patch
from tests.femic.stresses.samples import (
    SIDES,
    STEEL,
    flat,
    grid_of,
    section_points,
    tractions_of,
    unsymmetric,
)

A, B = 0.3, 0.2
TRACTION = np.array([0.7, -0.4, 1.3])
NU = (0.0, 0.28, 0.49)


def patch_fields(material, x, traction=TRACTION):
    """Fields of one rectangle at points (n, 3)."""
    corners = lattice_corners(np.array([-A, A]), np.array([-B, B]), traction[None, None])
    return fields(material, corners, *np.asarray(x, dtype=float).T)


def point_load(material, force, x):
    """Displacements (n, 3) at points (n, 3) under a force at the origin: Boussinesq, Cerruti.

    Johnson (1985), equations 3.18 and 3.75; z is the depth.
    """
    R, nu, z = np.linalg.norm(x, axis=-1), material.nu, x[..., 2]
    u = np.zeros_like(x)
    near = R + z
    for d in (0, 1):
        along, across = x[..., d], x[..., 1 - d]
        one = 1 / R + along**2 / R**3 + (1 - 2 * nu) * (1 / near - along**2 / (R * near**2))
        other = along * across * (1 / R**3 - (1 - 2 * nu) / (R * near**2))
        down = along * (z / R**3 + (1 - 2 * nu) / (R * near))
        u[..., d] += force[d] * one
        u[..., 1 - d] += force[d] * other
        u[..., 2] += force[d] * down
        u[..., d] += force[2] * along * (z / R**3 - (1 - 2 * nu) / (R * near))
    u[..., 2] += force[2] * (z**2 / R**3 + 2 * (1 - nu) / R)
    return u / (4 * np.pi * material.G)


def slopes(function, x, step):
    """Central differences of function at points (n, 3): (n, ..., 3)."""
    steps = step * np.eye(3)
    return np.stack([(function(x + e) - function(x - e)) / (2 * step) for e in steps], axis=-1)


def scattered(n=8, least_depth=0.15):
    x = np.random.default_rng(3).uniform(-1, 1, (n, 3))
    x[:, 2] = least_depth + np.abs(x[:, 2])
    return x


@pytest.mark.parametrize("nu", NU)
def test_stresses_are_in_equilibrium_and_hooke_s_of_the_displacements(nu):
    """Central differences of step h err by h^2 times the third derivative: 1e-5 of the largest slope."""
    material, x = Material(1e3, nu), scattered()
    stress = patch_fields(material, x)[1]
    gradient = slopes(lambda y: patch_fields(material, y)[0], x, 1e-4)
    np.testing.assert_allclose(hooke_stress(material, gradient), stress, atol=1e-5 * np.max(np.abs(stress)))
    change = slopes(lambda y: patch_fields(material, y)[1], x, 1e-4)
    assert np.max(np.abs(np.einsum("nabb->na", change))) < 1e-5 * np.max(np.abs(change))


@pytest.mark.parametrize("nu", NU)
def test_a_patch_is_the_sum_of_point_loads_at_any_depth(nu):
    """Gauss quadrature of 24 x 24 points is exact to 1e-9 at depths of half a side and more."""
    material, x = Material(1e3, nu), scattered()
    nodes, weights = np.polynomial.legendre.leggauss(24)
    u, stress = patch_fields(material, x)
    expected, gradient = np.zeros_like(x), np.zeros((len(x), 3, 3))
    for xi, w_x in zip(A * nodes, A * weights, strict=True):
        for eta, w_y in zip(B * nodes, B * weights, strict=True):
            apart, force = x - [xi, eta, 0], w_x * w_y * TRACTION
            expected += point_load(material, force, apart)
            gradient += slopes(lambda y, f=force: point_load(material, f, y), apart, 1e-4)
    np.testing.assert_allclose(u, expected, atol=1e-8 * np.max(np.abs(u)))
    np.testing.assert_allclose(stress, hooke_stress(material, gradient), atol=1e-5 * np.max(np.abs(stress)))


def test_far_away_a_patch_is_a_point_load():
    """Its second moments give a relative difference of (A / r)^2 = 1e-4."""
    x = 30 * scattered()
    force = 4 * A * B * TRACTION
    u, stress = patch_fields(STEEL, x)
    np.testing.assert_allclose(u, point_load(STEEL, force, x), atol=3e-4 * np.max(np.abs(u)))
    gradient = slopes(lambda y: point_load(STEEL, force, y), x, 1e-3)
    np.testing.assert_allclose(
        stress, hooke_stress(STEEL, gradient), rtol=1e-3, atol=1e-4 * np.max(np.abs(stress))
    )


def test_tractions_on_the_surface_are_those_of_the_patch_and_0_beside_it():
    inside, beside = (
        [[0.1, -0.05, 0.0], [-0.29, 0.19, 0.0]],
        [[0.4, 0.1, 0.0], [0.2, -0.3, 0.0], [-0.5, 0.4, 0.0]],
    )
    np.testing.assert_allclose(patch_fields(STEEL, inside)[1][..., 2], [-TRACTION] * 2, rtol=1e-12)
    assert np.max(np.abs(patch_fields(STEEL, beside)[1][..., 2])) < 1e-14


@pytest.mark.parametrize("side", SIDES)
def test_displacements_of_the_surface_are_the_ics_of_the_half_space(side):
    """On the element, beside it, on its edges' lines, and far away, where sums over corners lose digits."""
    grid = grid_of(1, 1, A, B)
    x, s = np.array([0.1, 0.7, -A, 5.0, 0.9, 40.0]), np.array([0.05, -0.4, 0.8, B, 0.2, -30.0])
    tractions = SurfaceTractions(grid, TRACTION[None, None])
    field = half_space_field(flat(side), tractions, InnerPoints(x, s, 0 * x), between_centres=False)
    a = HalfSpace(one_body(STEEL, side)).ics(Patch(A, B), x, s)
    expected = side * np.einsum("ijn,j->ni", a, TRACTION)  # the lower body gets the opposite
    np.testing.assert_allclose(field.u, expected, rtol=1e-9, atol=1e-12 * np.max(np.abs(expected)))


def test_the_lower_body_is_the_upper_one_upside_down():
    """A reflection in the surface: pressure stays, tractions along x and s change their sign."""
    grid, points = grid_of(5, 4, 1.0, 0.7), section_points([-0.4, 0.2], [0.0, 0.3, 1.0], x=0.1)
    tractions = unsymmetric(grid, 1.0, 0.7)
    other = replace(tractions, p=tractions.p * [-1, -1, 1])
    upper, lower = half_space_field(flat(+1), tractions, points), half_space_field(flat(-1), other, points)
    mirror = np.array([1, 1, -1])
    np.testing.assert_allclose(lower.u, upper.u * mirror, rtol=1e-12)
    np.testing.assert_allclose(lower.stress, upper.stress * np.outer(mirror, mirror), rtol=1e-12)


@pytest.mark.parametrize("side", SIDES)
def test_both_bodies_have_minus_the_tractions_on_their_surfaces(side):
    grid = grid_of(6, 4, 1.0, 0.7)
    tractions = unsymmetric(grid, 1.0, 0.7)
    points = InnerPoints(tractions.x[:, None], grid.strips, np.zeros(()))
    field = half_space_field(flat(side), tractions, points)
    np.testing.assert_allclose(field.stress[..., 2], -tractions.p, atol=1e-12)


# --- Hertz -------------------------------------------------------------------------------------------

NU_HERTZ = Material(210e3, 0.3)


def hertz(n_x, n_s, a=1.0):
    grid = grid_of(n_x, n_s, a, a)
    return tractions_of(grid, lambda x, s: (0, 0, np.sqrt(np.maximum(a**2 - x**2 - s**2, 0)) / a))


def test_below_the_middle_of_a_circular_contact():
    """Johnson (1985), equations 3.45; elements of a / 20 at the edge of the contact leave 2e-3 of p_max."""
    depth = np.linspace(0.0, 2.0, 41)
    field = half_space_field(flat(-1, material=NU_HERTZ), hertz(44, 38), InnerPoints(0.0, 0.0, depth))
    ratio = np.maximum(depth, 1e-12)
    along_n = -1 / (1 + depth**2)
    across = -1.3 * (1 - depth * np.arctan(1 / ratio)) + 0.5 / (1 + depth**2)
    expected = np.stack([across, across, along_n], axis=-1)[..., None, :] * np.eye(3)
    np.testing.assert_allclose(field.stress, expected, atol=2e-3)
    shear = tresca(field.stress) / 2
    assert np.max(shear) == pytest.approx(0.310, abs=2e-3)
    assert depth[np.argmax(shear)] == pytest.approx(0.48, abs=0.051)


def test_on_the_surface_of_a_circular_contact_also_between_the_centres_of_elements():
    """Johnson (1985), equations 3.42: radial, inside; waves of the uniform elements would be 0.1 p_max."""
    r = np.linspace(0.05, 0.85, 37)
    field = half_space_field(flat(+1, material=NU_HERTZ), hertz(44, 38), InnerPoints(0 * r + 0.013, r, 0 * r))
    root = np.sqrt(1 - r**2)
    radial = 0.4 / 3 * (1 - root**3) / r**2 - root
    np.testing.assert_allclose(field.stress[:, 1, 1], radial, atol=8e-3)


def huber(r, z):
    """sigma_nn and the size of sigma_rn over p_max below a circle of radius 1: Huber (1904), Johnson 3.4."""
    apart = r**2 + z**2 - 1
    u = (apart + np.sqrt(apart**2 + 4 * z**2)) / 2
    along_n = -((z / np.sqrt(u)) ** 3) * u / (u**2 + z**2)
    return along_n, r * z**2 / (u**2 + z**2) * np.sqrt(u) / (1 + u)


def inside_of_circle(n=80):
    random = np.random.default_rng(4)
    r, angle = 0.7 * np.sqrt(random.uniform(0, 1, n)), random.uniform(0, 2 * np.pi, n)
    return r, r * np.cos(angle), r * np.sin(angle)


def below_circle(tractions, x, s, depth):
    return half_space_field(flat(-1, material=NU_HERTZ), tractions, InnerPoints(x, s, depth + 0 * x)).stress


SIDE = 2 / 30  # longest of the elements of `hertz(36, 30)`


@pytest.mark.parametrize("ratio", [0.35, 0.5, 0.75, 1.0, 1.4])
def test_stresses_do_not_jump_at_any_depth(ratio):
    """From one depth to another stresses move by their slopes, 3 p_max per mm at most."""
    _, x, s = inside_of_circle()
    depths, step = ratio * SIDE, 1e-5 * SIDE
    above, below = (below_circle(hertz(36, 30), x, s, depths + sign * step) for sign in (-1, 1))
    assert np.max(np.abs(below - above)) < 3 * 2 * step


@pytest.mark.parametrize("ratio", [0.4, 0.6, 0.8, 1.0, 1.3])
def test_stresses_off_the_axis_converge_to_huber_s_where_waves_of_elements_end(ratio):
    """At depths of a share of an element: with the order 3/2 or more, of the root of tractions at edges."""
    r, x, s = inside_of_circle()
    errors = []
    for n in (1, 3):
        depth = ratio * SIDE / n
        stress = below_circle(hertz(36 * n, 30 * n), x, s, depth)
        along_n, shear = huber(r, depth)
        off = stress[:, 2, 2] - along_n, np.hypot(stress[:, 0, 2], stress[:, 1, 2]) - shear
        errors.append(np.sqrt(np.mean(np.square(off))))
    assert errors[0] < 4e-3
    assert errors[1] < errors[0] / 3**1.5


def test_below_the_middle_of_a_line_contact():
    """The largest shear is 0.300 p_max at a depth of 0.786 half-widths (Johnson, section 4.1).

    Its ends, 600 half-widths away, leave (1 - 2 nu) / 2 / 600 of p_max in stresses along s.
    """
    grid = grid_of(7, 60, 600.0, 1.0)
    edges = np.linspace(-1, 1, 61)
    means = np.diff(edges * np.sqrt(1 - edges**2) + np.arcsin(edges)) / 2 / grid.ds
    tractions = tractions_of(grid, lambda x, s: (0 * s, 0 * s, means + 0 * x))
    depth = np.linspace(0.1, 2.0, 96)
    field = half_space_field(
        flat(-1, material=NU_HERTZ), tractions, InnerPoints(0.0, 0.0, depth), between_centres=False
    )
    root = np.sqrt(1 + depth**2)
    across, along_n = -((1 + 2 * depth**2) / root - 2 * depth), -1 / root
    np.testing.assert_allclose(field.stress[:, 1, 1], across, atol=2e-3)
    np.testing.assert_allclose(field.stress[:, 2, 2], along_n, atol=2e-3)
    np.testing.assert_allclose(field.stress[:, 0, 0], 0.3 * (across + along_n), atol=2e-3)
    shear = (field.stress[:, 1, 1] - field.stress[:, 2, 2]) / 2
    assert np.max(shear) == pytest.approx(0.300, abs=1e-3)
    assert depth[np.argmax(shear)] == pytest.approx(0.786, abs=0.02)


def test_an_incompressible_material_is_refused():
    with pytest.raises(WrongInput, match="nu"):
        half_space_field(flat(-1, material=Material(1.0, 0.5)), hertz(4, 3), InnerPoints(0.0, 0.0, [1.0]))


# ---- the staircase of uniform elements


COUNTS = np.array([12, 36, 108])  # along x, and 10 / 12 of them along s: all have the same middles


def smooth(x, s):
    """Tractions that vary in both directions and fall smoothly to 0 at |x| = 2, |s| = 3."""
    p = np.maximum(1 - (x / 2) ** 2, 0) ** 3 * np.maximum(1 - (s / 3) ** 2, 0) ** 3
    return p * (1 + x - 0.4 * s), p * (0.5 - x + 0.7 * s), p * (1 + 0.6 * x - 0.3 * s)


def below_a_middle(side, n_x, depth, function=smooth):
    grid = grid_of(n_x, 10 * n_x // 12, 2.0, 3.0)
    points = InnerPoints(np.array([-0.5]), np.array([0.9]), np.array([depth]))
    return half_space_field(flat(side), tractions_of(grid, function), points).stress[0]


@pytest.mark.parametrize("side", SIDES)
def test_stresses_of_the_surface_are_of_second_order(side):
    """Without the staircase they are of first order; the truth is that of elements three times as fine."""
    truth = below_a_middle(side, 324, 0.0)
    errors = [np.max(np.abs(below_a_middle(side, n, 0.0) - truth)) for n in COUNTS]
    rates = -np.diff(np.log(errors)) / np.log(3)
    assert np.all(rates > 1.8), rates
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("depth", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("side", SIDES)
def test_steady_tractions_have_the_stresses_of_finer_elements_at_any_depth(side, depth):
    """No curvature: only the jumps at the ends of the grid differ, like h^2; without the staircase 0.28."""

    def steady(x, s):
        shape = 1 + 0 * (x + s)
        return shape * (x - s), shape * (0.3 * x + s), shape * (2 + 0.5 * x - s)

    coarse, fine = (below_a_middle(side, n, depth, steady) for n in (12, 36))
    np.testing.assert_allclose(coarse, fine, atol=0.015)
