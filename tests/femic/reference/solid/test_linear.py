"""Linear solvers: non-convergence is an error, and multigrid does not slow down with the mesh."""

import numpy as np
import pytest

from femic.reference.accuracy import NotConverged
from femic.reference.solid import linear
from femic.reference.solid.engine import patch_load, raw_ics, solve
from femic.reference.symmetry import held_by_symmetry
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
