"""Meshes: nodes on the true contour, the chart, the volume, cells that would fold."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree
from skfem import Basis, ElementTriP2, MeshTet, MeshTet2, MeshTri

from femic.reference.engine import Points
from femic.reference.meshing import Cells
from femic.reference.solid.engine import build_mesh
from femic.reference.solid.mesh import Focus, Trace, _folded, curved, fill, unfold
from tests.femic.reference.conftest import COARSE, SMALL, SYMMETRIC, request_for


@pytest.mark.parametrize("side", [-1, 1])
def test_rounding_of_the_mesher_does_not_move_the_ends_of_the_chart(side):
    """Points at x = 0 and at the end lie in a triangle, whichever way the mesher rounds."""
    body = request_for(SYMMETRIC, domain=SMALL.scaled(0.5)).body
    centre = np.zeros((3, 1))
    linear = fill(body, COARSE.scaled(4), Focus(centre, centre), half_section=True)
    rounded = linear.points.copy()
    rounded[0, np.isin(rounded[0], [0.0, body.xi_end])] += side * 1e-12
    trace = curved(body, replace(linear, points=rounded), half_section=True).trace
    assert (trace.basis.mesh.p[0].min(), trace.basis.mesh.p[0].max()) == (0.0, body.xi_end)
    ends = trace.interpolation(np.array([0.0, body.xi_end]), np.array([1.0, 2.0]))
    np.testing.assert_allclose(ends.sum(axis=1), 1, rtol=1e-12)


def test_size_of_a_triangle_is_the_leg_of_the_right_one_of_its_area():
    grid = MeshTri.init_tensor(np.array([0.0, 1.0, 2.0, 5.0]), np.array([0.0, 2.0, 4.0, 8.0]))
    trace = Trace(Basis(grid, ElementTriP2()), np.arange(0))
    assert trace.smallest((0.2, 0.4), (0.5, 1.0)) == pytest.approx(np.sqrt(1 * 2))  # half of a cell 1 x 2
    assert trace.smallest((0.0, 5.0), (0.0, 8.0)) == pytest.approx(np.sqrt(1 * 2))
    assert trace.smallest((3.0, 4.0), (5.0, 6.0)) == pytest.approx(np.sqrt(3 * 4))  # far from small ones


def test_cells_are_small_at_the_patch_and_along_the_lines():
    cells, x = Cells(0.2, 0.4, 0.1), np.linspace(0, 12, 60)
    line = Points(x, np.full_like(x, 1.0))
    focus = np.vstack([x, SYMMETRIC.position(line.s)])
    solid = build_mesh(request_for(SYMMETRIC, points=line, cells=cells))
    p, t = solid.mesh.p, solid.mesh.t
    centre = p[:, t].mean(axis=1)
    size = np.mean(np.linalg.norm(p[:, t[0]] - p[:, t[1:]].transpose(1, 0, 2), axis=1), axis=0)
    r = np.linalg.norm(centre, axis=0)
    d = cKDTree(focus.T).query(centre.T)[0]
    target = np.sqrt(cells.smallest**2 + (cells.line_growth * r) ** 2 + (cells.growth * d) ** 2)
    # Gmsh meets a target size on average only: edges come out up to a third longer
    assert 0.9 < np.median(size / target) < 1.4
    along = (d < 0.3) & (r > 3)
    assert np.median(size[along]) < 0.6 * np.median(size[(d > 2) & (np.abs(r - np.median(r[along])) < 1)])


# --- cells that would fold far from a patch keep straight edges, and only these ---


@pytest.mark.parametrize(
    ("by", "loose", "straightened"),
    [(0.6, [0, 1], True), (0.1, [0], False), (0.6, [1], False)],
    ids=["folds", "does not fold", "must be curved"],
)
def test_a_cell_that_folds_gets_its_edge_back_unless_it_must_be_curved(by, loose, straightened):
    """A box of five tetrahedra, a mid-side node moved along its edge. The mesh may be refused then."""
    box = MeshTet2.from_mesh(MeshTet.init_tensor(*[np.array([0.0, side]) for side in (1.0, 1.3, 0.8)]))
    nodes, ends = box.doflocs.copy(), box.edges[:, 0]
    nodes[:, box.nvertices] += by * (nodes[:, ends[1]] - nodes[:, ends[0]])
    assert (len(_folded(MeshTet2(nodes, box.t))) > 0) == (by == 0.6)
    result = unfold(box, nodes.copy(), box.nvertices + np.array(loose))
    np.testing.assert_array_equal(result, box.doflocs if straightened else nodes)
