"""The solid engine: equilibrium, reciprocity, symmetries, units, invariances."""

from dataclasses import replace

import numpy as np
import pytest

from femic.elasticity import stiffness
from femic.solid import (
    Points,
    build_mesh,
    directions_of,
    local_axes,
    observe,
    patch_load,
    raw_ics,
    solve,
)
from femic.symmetry import held_by_symmetry
from geometries.bodies import LOWER, UPPER, Domain
from geometries.contours import arc, through_points
from geometries.materials import Material
from geometries.patches import Patch
from tests.femic.conftest import PATCH, SMALL, STEEL, SYMMETRIC, UNSYMMETRIC, request_for

EVEN_IN_X = np.array([[1, -1, -1], [-1, 1, 1], [-1, 1, 1]])  # [i, j]: parity of component i under load j
# the solver stops at a relative residual of 1e-9; displacements are then known to about 1e-8
SOLVED = 1e-7


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_patch_load_carries_unit_force_and_its_moments(half_model, direction):
    patch = Patch(0.3, 0.5, s=1.0)
    solid = half_model.solid
    force = patch_load(solid, patch, direction)
    s, w = np.polynomial.legendre.leggauss(20)
    s, w = patch.s + patch.b * s, w / 4  # half of the patch is modelled: x >= 0
    axes = local_axes(solid.body.contour, s)[direction]
    np.testing.assert_allclose(force.sum(axis=0), axes @ w, atol=1e-13)
    points = np.vstack([np.full_like(s, patch.a / 2), solid.body.contour.position(s)])
    moments = np.cross(points.T, axes.T).T @ w
    by_nodes = np.cross(solid.nodes.T, force).sum(axis=0)
    # nodes lie on the arc, facets between them deviate from it by h^4 terms of order 1e-6 here
    np.testing.assert_allclose(by_nodes, moments, atol=2e-6)


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_reactions_balance_the_load(half_model, direction):
    solution = solve(half_model, PATCH, (direction,), "multigrid")[direction]
    nodes, load = half_model.solid.nodes, patch_load(half_model.solid, PATCH, direction)
    reaction = (half_model.stiffness @ solution.displacement.ravel()).reshape(-1, 3) - load
    held = half_model.clamped[:, None] | held_by_symmetry(nodes, direction, half_section=False)
    assert np.abs(reaction[~held]).max() < 1e-9  # equilibrium where nothing is held, in N per 1 N
    on_held = np.where(held, reaction, 0)
    np.testing.assert_allclose(on_held.sum(axis=0), -load.sum(axis=0), atol=1e-6)
    moments = np.cross(nodes.T, on_held).sum(axis=0) + np.cross(nodes.T, load).sum(axis=0)
    np.testing.assert_allclose(moments, 0, atol=1e-6 * SMALL.far_radius)


def test_raw_reciprocity_between_two_load_positions(half_model):
    here, there = Patch(0.3, 0.5, s=0.0), Patch(0.4, 0.25, s=2.5)
    works = np.array([[_work(half_model, p, q) for q in (here, there)] for p in (here, there)])
    # work of the load p on the displacements of q, all direction pairs: Maxwell-Betti
    scale = np.abs(works).max()
    np.testing.assert_allclose(works[0, 1], works[1, 0].T, atol=SOLVED * scale)


def _work(model, observer, load):
    """Work of unit loads on `observer` (even part in x) on the displacements of loads on `load`."""
    solutions = solve(model, load, (1, 2), "multigrid")
    forces = [patch_load(model.solid, observer, i) for i in (1, 2)]
    return np.array([[np.sum(f * solutions[j].displacement) for j in (1, 2)] for f in forces])


def test_parity_in_x_of_the_observed_displacements():
    ic = raw_ics(request_for(UNSYMMETRIC)).ic
    np.testing.assert_allclose(ic[..., 1], EVEN_IN_X * ic[..., 0], rtol=1e-12)
    assert np.all(np.abs(ic[..., 0]) > 0)


def test_parity_in_s_of_a_symmetric_section_is_that_of_x_and_s_swapped():
    ic = raw_ics(request_for(SYMMETRIC)).ic
    even_in_s = EVEN_IN_X[np.ix_([1, 0, 2], [1, 0, 2])]
    np.testing.assert_allclose(ic[..., 4], even_in_s * ic[..., 0], rtol=1e-12)


def test_half_and_quarter_models_agree():
    """A patch moved by nothing to speak of needs the half model: a second route to the same ICs."""
    domain, points = Domain(20.0, 20.0), Points(np.array([1.5, 3.0]), np.array([0.8, -2.0]))
    fine = replace(request_for(SYMMETRIC).cells, smallest=0.1, growth=0.2, line_growth=0.1)
    quarter = raw_ics(request_for(SYMMETRIC, domain=domain, points=points, cells=fine))
    moved = replace(PATCH, s=1e-9)
    half = raw_ics(request_for(SYMMETRIC, domain=domain, points=points, cells=fine, patch=moved))
    assert half.cost.cells > 1.5 * quarter.cost.cells
    # two different meshes: each is good to about 1 % of the largest component here
    np.testing.assert_allclose(half.ic, quarter.ic, atol=0.01 * np.abs(quarter.ic).max())


def test_load_on_the_mirrored_section_gives_the_mirrored_displacements():
    y = np.linspace(-12, 12, 41)
    z = -(y**2) / 30 - 0.03 * y - 0.0005 * y**3
    here, mirrored = through_points(y, z), through_points(y, z[::-1])
    points = Points(np.array([1.5, 0.0]), np.array([0.8, -2.0]))
    ic = raw_ics(request_for(here, points=points)).ic
    seen = raw_ics(request_for(mirrored, points=Points(points.x, -points.s))).ic
    flips = np.array([1, -1, 1])
    # not the same mesh: coarse cells at the lines are good to 2 % of the largest component
    np.testing.assert_allclose(seen, flips[:, None, None] * flips[:, None] * ic, atol=0.02 * np.abs(ic).max())


def test_ics_fall_with_the_modulus():
    one = raw_ics(request_for(UNSYMMETRIC)).ic
    softer = raw_ics(request_for(UNSYMMETRIC, material=Material(STEEL.E / 7, STEEL.nu))).ic
    np.testing.assert_allclose(softer, 7 * one, rtol=1e-5, atol=SOLVED * np.abs(softer).max())


@pytest.mark.parametrize("k", [1e-3, 25.4])
def test_the_unit_of_length_does_not_matter(k):
    """Lengths times k: displacements per unit force fall by k; in m and N/m^2 instead of mm and MPa too."""
    one = request_for(UNSYMMETRIC)
    other = request_for(
        arc(8.0 * k, np.radians(20), np.radians(35)),
        patch=Patch(k * PATCH.a, k * PATCH.b),
        domain=SMALL.scaled(k),
        cells=replace(one.cells, smallest=k * one.cells.smallest),
        points=Points(k * one.points.x, k * one.points.s),
    )
    ic = raw_ics(one).ic
    # rounding may flip a few cells: the mesh error of these coarse cells is some percent
    np.testing.assert_allclose(k * raw_ics(other).ic, ic, atol=0.02 * np.abs(ic).max())


def test_solvers_agree():
    pytest.importorskip("pypardiso")
    iterated, direct = (raw_ics(request_for(UNSYMMETRIC, solver=name)) for name in ("multigrid", "direct"))
    np.testing.assert_allclose(iterated.ic, direct.ic, atol=SOLVED * np.abs(direct.ic).max())
    assert max(direct.cost.iterations) == 0 < min(iterated.cost.iterations)


def test_only_the_requested_load_is_solved():
    result = raw_ics(request_for(SYMMETRIC, directions=directions_of(["nn", "xn"])))
    assert len(result.cost.iterations) == 1
    assert np.all(np.isnan(result.ic[:, :2]))
    assert np.all(np.isfinite(result.ic[:, 2]))


@pytest.mark.parametrize("side", [LOWER, UPPER])
def test_a_normal_load_pushes_its_own_element_along_itself(side):
    at_patch = Points(np.zeros(1), np.zeros(1))
    ic = raw_ics(request_for(UNSYMMETRIC, side=side, points=at_patch)).ic[..., 0]
    assert np.all(np.diag(ic) > 0)


def test_observers_interpolate_a_quadratic_field_exactly(half_model):
    """The trace is quadratic in (x, s): a field that is so too comes back to rounding."""
    trace = half_model.solid.trace
    x, s = trace.basis.doflocs
    u = np.zeros((half_model.solid.nodes.shape[1], 3))
    u[trace.nodes, 0] = x**2 - 3 * x * s + 2 * s**2 + x
    points = Points(np.array([0.7, 3.1]), np.array([-1.3, 2.2]))
    solution = replace(solve(half_model, PATCH, (0,), "multigrid")[0], displacement=u)
    seen = observe(half_model, solution, 0, points)[0]
    expected = points.x**2 - 3 * points.x * points.s + 2 * points.s**2 + points.x
    np.testing.assert_allclose(seen, expected, rtol=1e-10)


def test_mesh_is_repeatable():
    first, second = (build_mesh(request_for(UNSYMMETRIC)).nodes for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_stiffness_is_assembled_once_for_all_directions(monkeypatch):
    calls = []
    monkeypatch.setattr("femic.solid.stiffness", lambda *a: calls.append(1) or stiffness(*a))
    raw_ics(request_for(SYMMETRIC))
    assert len(calls) == 1
