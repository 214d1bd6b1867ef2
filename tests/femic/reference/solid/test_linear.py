"""Linear solvers: non-convergence is an error, and multigrid does not slow down with the mesh."""

import numpy as np
import pytest

from femic.reference.engine import Points
from femic.reference.job import NotConverged
from femic.reference.solid import engine, linear
from femic.reference.solid.engine import from_vertices, patch_load, raw_ics, solve
from femic.reference.solid.linear import rigid_body_modes
from femic.reference.symmetry import Parity, held_by_symmetry
from geometries.patches import Load
from tests.femic.reference.conftest import COARSE, PATCH, SYMMETRIC, request_for


def test_no_convergence_is_an_error_with_residual_and_remedy(monkeypatch):
    monkeypatch.setattr(linear, "MAX_ITERATIONS", 2)
    with pytest.raises(NotConverged, match=r"residual .* after 2 iterations.*Try"):
        raw_ics(request_for(SYMMETRIC))


def test_iterations_hardly_grow_with_the_mesh():
    coarse, fine = (raw_ics(request_for(SYMMETRIC, cells=COARSE.scaled(f))).cost for f in (1.6, 0.7))
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
