"""The stiffness on a curved mesh and its solvers: kernel, energy, residuals, iterations, errors."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import Basis, ElementTetP2

from femic.reference.engine import Points
from femic.reference.job import NotConverged
from femic.reference.solid import engine, linear
from femic.reference.solid.engine import from_vertices, patch_load, raw_ics, solve
from femic.reference.solid.linear import is_curved, rigid_body_modes, stiffness
from femic.reference.symmetry import Parity, held_by_symmetry
from geometries.patches import Load
from tests.femic.reference.conftest import COARSE, PATCH, STEEL, SYMMETRIC, request_for

STRAINS = np.array([[1.0, 0.3, -0.2], [0.1, -0.7, 0.4], [0.5, 0.2, 0.6]])


def test_the_stiffness_is_symmetric_and_rigid_body_modes_are_its_kernel(half_model):
    assert 0.01 < np.mean(is_curved(half_model.solid.mesh)) < 0.5
    K, modes = half_model.stiffness, rigid_body_modes(half_model.solid.nodes)
    assert np.abs(K - K.T).max() < 1e-13 * np.abs(K).max()
    # rounding: forces of a mode are sums of about 30 terms of the size |K| |mode|
    scale = np.abs(K).max() * np.abs(modes).max(axis=0)
    assert np.all(np.abs(K @ modes).max(axis=0) < 1e-12 * scale)
    assert np.linalg.matrix_rank(modes) == 6


def test_constant_strain_is_in_equilibrium_inside_and_has_the_energy_of_the_material_law(half_model):
    mesh = half_model.solid.mesh
    u = (STRAINS @ half_model.solid.nodes).T.ravel()
    forces = (half_model.stiffness @ u).reshape(-1, 3)
    inside = np.ones(len(forces), dtype=bool)
    inside[mesh.dofs.get_facet_dofs(mesh.boundary_facets()).flatten()] = False
    # 1e-12: rounding; the quadrature of curved cells integrates constant stress exactly
    assert np.abs(forces[inside]).max() < 1e-12 * np.abs(forces).max()
    strain = (STRAINS + STRAINS.T) / 2
    density = STEEL.lame / 2 * np.trace(strain) ** 2 + STEEL.G * np.sum(strain**2)
    volume = Basis(mesh, ElementTetP2(), intorder=5).dx.sum()
    assert u @ stiffness(mesh, STEEL) @ u / 2 == pytest.approx(density * volume, rel=1e-11)


def test_no_convergence_is_an_error_with_residual_and_remedy(monkeypatch):
    monkeypatch.setattr(linear, "MAX_ITERATIONS", 2)
    with pytest.raises(NotConverged, match=r"residual .* after 2 iterations.*Try"):
        raw_ics(request_for(SYMMETRIC))


def test_iterations_hardly_grow_with_the_mesh():
    cells = replace(COARSE, growth=0.3, line_growth=0.2)
    coarse, fine = (raw_ics(request_for(SYMMETRIC, cells=cells.scaled(f))).cost for f in (1.6, 0.7))
    assert fine.unknowns > 4 * coarse.unknowns
    assert max(fine.iterations) < 1.5 * max(coarse.iterations)


def test_the_cycle_of_multigrid_is_symmetric_and_positive(half_model):
    held = half_model.supported | held_by_symmetry(half_model.solid.nodes, Parity(+1, 0))
    modes = rigid_body_modes(half_model.solid.nodes)
    matrix, cycle = linear.multigrid(
        linear.System(half_model.stiffness, held, modes, from_vertices(half_model.solid))
    )
    u, v = np.random.default_rng(0).normal(size=(2, matrix.shape[0]))
    assert u @ (cycle @ v) == pytest.approx(v @ (cycle @ u), rel=1e-9)
    assert u @ (cycle @ u) > 0


@pytest.mark.parametrize("direction", [0, 1, 2])
def test_the_residual_leaves_no_error_of_the_displacements_at_points(half_model, direction, monkeypatch):
    load = Load(PATCH, direction)
    points = Points(np.linspace(0, 5, 26), np.linspace(-1, 4, 26))
    u = []
    for residual in (engine.RESIDUAL, 1e-12):
        monkeypatch.setattr(engine, "RESIDUAL", residual)
        u.append(engine.observe(half_model, load, solve(half_model, (load,), "multigrid")[load], points))
    np.testing.assert_allclose(u[0], u[1], rtol=0, atol=1e-8 * np.abs(u[1]).max())


@pytest.mark.parametrize("direction", [0, 2])
def test_the_reported_residual_is_that_of_the_returned_field(half_model, direction):
    load = Load(PATCH, direction)
    ((parity, solution),) = solve(half_model, (load,), "multigrid")[load]
    force = patch_load(half_model.solid, load, parity)
    held = half_model.supported | held_by_symmetry(half_model.solid.nodes, parity)
    rest = force - (half_model.stiffness @ solution.displacement.ravel()).reshape(-1, 3)
    residual = np.linalg.norm(rest[~held]) / np.linalg.norm(force[~held])
    assert residual == pytest.approx(solution.residual, rel=1e-3)
    assert np.all(solution.displacement[held] == 0)
