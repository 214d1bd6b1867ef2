"""Displacements from responses: what is beyond the largest wavenumber."""

from dataclasses import replace

import numpy as np

from approx.halfspace import HalfSpace
from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.synthesis import displacements
from femic.reference.harmonic.waves import tail
from geometries.materials import one_body
from tests.femic.reference.small_model import BODY, TASK


def test_displacements_without_responses_are_the_tail_of_the_half_space():
    """Component i under load j is that of the half-space: C_xn and C_nx differ in sign."""
    request = TASK.request
    solved = solve(request, workers=2)
    silent = replace(solved.samples, responses=np.zeros_like(solved.samples.responses))
    u = displacements(replace(solved, samples=silent), request.loads, request.points).u
    half_space, patch = HalfSpace(one_body(BODY.material, BODY.side)), request.loads[0].patch
    for point, (x, s) in enumerate(zip(request.points.x, request.points.s, strict=True)):
        beyond = tail(half_space, patch, request.k_max, np.array([x]))(s)[..., 0]
        for load, of_load in zip(request.loads, u, strict=True):
            np.testing.assert_allclose(of_load[:, point], beyond[:, load.direction], rtol=1e-9, atol=1e-18)
    assert np.max(np.abs(u[2, 0])) > 1e-3 * np.max(np.abs(u[2, 2]))  # x under n is not nothing
