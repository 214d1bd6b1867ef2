"""Stresses by second routes: a finite-element contact of `tall`, and tetrahedra under the same load."""

from itertools import combinations

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from femic.contact.finite_elements.coupling import on_upper
from femic.contact.finite_elements.meshed_contact import mesh_bodies, solved, supported_bodies
from femic.contact.finite_elements.result import hertz_patch
from femic.reference.meshing import Cells
from femic.reference.solid.fields import figure_grid, nodal_fields, stress
from femic.scenes.load import load_scene
from femic.stresses.engine import StressSettings, stress_field
from femic.stresses.field import von_mises
from femic.stresses.points import InnerPoints, SurfaceTractions, points_at
from geometries.patches import Grid, Patch
from tests.femic.reference.conftest import UNSYMMETRIC, request_for

LOAD, CELLS, ELEMENTS = 7.4e3, 15.0, 48  # N, along the shorter half-length, along x and s


@pytest.fixture(scope="module")
def contact():
    bodies = supported_bodies(load_scene("tall", {"contact": {"loads": [LOAD]}}).contact_problem)
    rough = solved(bodies, mesh_bodies(bodies, hertz_patch(bodies, LOAD), 8.0), LOAD)
    return solved(bodies, mesh_bodies(bodies, rough.patch, CELLS), LOAD, rough)


def strips_of(contact, side):
    """Arc lengths of the vertices of the zone on the contour of a body."""
    zone, undeformed = contact.pair, contact.bodies.undeformed
    if side == "lower":
        return zone.s
    points = np.stack([zone.x, zone.s])
    return on_upper(undeformed, points, undeformed.distance(*points))[1]


def tractions_on(contact, s):
    """Its pressures, linear between vertices at x, s (m,) of a quarter, on elements of a grid."""
    pressed = contact.p > 0
    a, b = (1.1 * np.max(along[pressed]) for along in (contact.pair.x, s))
    grid = Grid(ELEMENTS, ELEMENTS, 2 * a / ELEMENTS, 2 * b / ELEMENTS, 0.0)
    x = grid.dx * (np.arange(ELEMENTS) - (ELEMENTS - 1) / 2)
    quarter = np.meshgrid(np.abs(x), np.abs(grid.strips), indexing="ij")
    p = np.zeros((ELEMENTS, ELEMENTS, 3))
    p[..., 2] = LinearNDInterpolator(np.stack([contact.pair.x, s], axis=1), contact.p, 0.0)(*quarter)
    return SurfaceTractions(grid, p)


def cell_sizes(grid):
    """The longest edge of the cells around each node [mm], (n,)."""
    corners = grid.nodes[:, grid.cells[:4]]
    edges = [np.linalg.norm(corners[:, i] - corners[:, j], axis=0) for i, j in combinations(range(4), 2)]
    longest, sizes = np.max(edges, axis=0), np.zeros(grid.nodes.shape[1])
    for nodes in grid.cells:
        np.maximum.at(sizes, nodes, longest)
    return sizes


@pytest.mark.slow
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_deeper_than_two_cells_stresses_are_those_of_finite_elements(contact, side):
    """Von Mises stresses to 3 % of the largest; half-spaces are off by ten times that somewhere."""
    body, solid = getattr(contact.bodies, side), getattr(contact.meshes, side).solid
    u = getattr(contact.solution.state, f"u_{side}").reshape(-1, 3)
    grid, half_width = figure_grid(solid, whole=False), contact.s_range[1]
    of_elements = von_mises(stress(grid, body.material, u))
    x, y, z = grid.nodes
    near = np.flatnonzero((x < 1.2 * contact.a) & (np.hypot(y, z) < 2.5 * half_width))[::9]
    points = points_at(body, *grid.nodes[:, near])
    deep = np.flatnonzero((points.depth > 2 * cell_sizes(grid)[near]) & (points.depth < 2 * half_width))
    chosen = InnerPoints(points.x[deep], points.s[deep], points.depth[deep])
    field = stress_field(
        body, tractions_on(contact, strips_of(contact, side)), chosen, StressSettings(1.0, False)
    )
    expected = of_elements[near[deep]]
    assert len(deep) > 300
    assert expected.max() > 0.9 * of_elements.max()
    np.testing.assert_allclose(von_mises(field.stress), expected, atol=0.03 * expected.max())
    assert np.max(np.abs(von_mises(field.half_space) - expected)) > 0.2 * expected.max()


# ---- tetrahedra


PATCH = Patch(0.6, 0.9, 1.0)
TETRAHEDRA = Cells(0.12, 0.18, 0.12)
SHALLOWEST, FURTHEST = 1.0, 4.0  # mm; nearer the patch the tetrahedra are too large


@pytest.mark.slow
@pytest.mark.parametrize("direction", range(3))
@pytest.mark.parametrize("side", [-1, +1])
def test_both_engines_have_the_same_von_mises_stress(side, direction):
    """Within the errors of the tetrahedra, of 0.1 to 0.6 mm, whose means at nodes are compared."""
    request = request_for(UNSYMMETRIC, side=side, patch=PATCH, directions=(direction,), cells=TETRAHEDRA)
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
