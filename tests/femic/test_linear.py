"""Linear solvers: non-convergence is an error, and multigrid does not slow down with the mesh."""

import numpy as np
import pytest

from femic import linear
from femic.linear import NotConverged
from femic.solid import raw_ics
from tests.femic.conftest import COARSE, SYMMETRIC, request_for


def test_no_convergence_is_an_error_with_residual_and_remedy(monkeypatch):
    monkeypatch.setattr(linear, "MAX_ITERATIONS", 2)
    with pytest.raises(NotConverged, match=r"residual .* after 2 iterations.*Try"):
        raw_ics(request_for(SYMMETRIC))


def test_iterations_hardly_grow_with_the_mesh():
    coarse, fine = (raw_ics(request_for(SYMMETRIC, cells=COARSE.scaled(f))).cost for f in (1.0, 0.5))
    assert fine.unknowns > 4 * coarse.unknowns
    assert max(fine.iterations) < 1.5 * max(coarse.iterations)


def test_reported_residual_is_small():
    cost = raw_ics(request_for(SYMMETRIC)).cost
    assert 0 < cost.residual < 2e-9
    assert np.isfinite(cost.peak_memory)
