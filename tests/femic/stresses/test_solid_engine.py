"""Stresses by the harmonic engine and by tetrahedra: the same load on the same section."""

import numpy as np
import pytest

from femic.reference.solid.fields import nodal_fields
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import von_mises
from femic.stresses.points import SurfaceTractions, points_at
from geometries.patches import Grid, Patch
from tests.femic.reference.conftest import COARSE, UNSYMMETRIC, request_for

PATCH = Patch(0.6, 0.9, 1.0)
CELLS = COARSE.scaled(0.6)
SHALLOWEST, FURTHEST = 1.0, 4.0  # mm; nearer the patch the tetrahedra are too large


@pytest.mark.slow
@pytest.mark.parametrize("direction", range(3))
@pytest.mark.parametrize("side", [-1, +1])
def test_both_engines_have_the_same_von_mises_stress(side, direction):
    """Within the errors of the tetrahedra, of 0.1 to 0.6 mm, whose means at nodes are compared."""
    request = request_for(UNSYMMETRIC, side=side, patch=PATCH, directions=(direction,), cells=CELLS)
    _, field = next(nodal_fields(request))
    nodes = field.grid.nodes
    x, y, z = nodes - np.array([[0.0], *request.body.contour.position(PATCH.s)[:, None]])
    distance = np.sqrt(x**2 + y**2 + z**2)
    depth = side * np.einsum("cn,cn->n", np.stack([y, z]), request.body.contour.normal(PATCH.s)[:, None])
    chosen = np.flatnonzero((depth > SHALLOWEST) & (distance < FURTHEST))[::7]
    p = np.zeros((5, 8, 3))
    p[..., direction] = side / PATCH.area  # a unit force on this body, along the direction
    grid = Grid(5, 8, 2 * PATCH.a / 5, 2 * PATCH.b / 8, PATCH.s)
    points = points_at(request.body, *nodes[:, chosen])
    result = stress_field(
        request.body, SurfaceTractions(grid, p), points, StressSettings(0.7, estimated=False)
    )
    expected = field.von_mises[chosen]
    assert len(chosen) > 20
    np.testing.assert_allclose(von_mises(result.stress), expected, atol=0.05 * np.max(expected))
