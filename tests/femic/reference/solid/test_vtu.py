"""Files of fields: what is written comes back, in the order of nodes that VTK defines."""

import numpy as np
import pytest

from femic.reference.solid.engine import build_mesh
from femic.reference.solid.fields import NodalField, figure_grid, write_vtu
from geometries.contours import plane
from geometries.surfaces import UPPER
from tests.femic.reference.conftest import UNSYMMETRIC, request_for

QUADRATIC_TETRAHEDRON = 24
VTK_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]  # of vtkQuadraticTetra, nodes 4 to 9


def field_on(contour, **named):
    grid = figure_grid(build_mesh(request_for(contour, **named)))
    x, y, z = grid.nodes
    return NodalField(grid, np.stack([x**2, y - z, x * y / 7], axis=1), np.abs(x) + y**2)


@pytest.fixture(scope="module")
def straight():
    return field_on(plane())


def read(path):
    pyvista = pytest.importorskip("pyvista")
    return pyvista.read(path)


def test_nodes_and_values_come_back_exactly(tmp_path):
    field = field_on(UNSYMMETRIC, side=UPPER)
    path = write_vtu(field, tmp_path / "new" / "folder" / "upper_n.vtu")
    grid = read(path)
    np.testing.assert_array_equal(grid.points, field.grid.nodes.T)
    np.testing.assert_array_equal(grid["displacement"], field.displacement)
    np.testing.assert_array_equal(grid["von_mises"], field.von_mises)
    assert set(grid.celltypes) == {QUADRATIC_TETRAHEDRON}
    assert grid.n_cells == field.grid.cells.shape[1]


def test_mid_side_nodes_lie_in_the_middle_of_their_edges(straight, tmp_path):
    grid = read(write_vtu(straight, tmp_path / "flat.vtu"))
    nodes = grid.points[grid.cells_dict[QUADRATIC_TETRAHEDRON]]  # (n_cells, 10, 3)
    middles = np.stack([nodes[:, edge].mean(axis=1) for edge in VTK_EDGES], axis=1)
    np.testing.assert_allclose(nodes[:, 4:], middles, atol=1e-10)


def test_no_cell_is_inside_out(straight, tmp_path):
    """The mesh has cells of both kinds, and mirror images turn them."""
    grid = read(write_vtu(straight, tmp_path / "flat.vtu"))
    a, b, c, d = np.moveaxis(grid.points[grid.cells_dict[QUADRATIC_TETRAHEDRON][:, :4]], 1, 0)
    volumes = np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) / 6
    assert volumes.min() > 0
    x_low, x_high, y_low, y_high, z_low, _ = grid.bounds
    assert volumes.sum() == pytest.approx(np.pi / 4 * (x_high - x_low) * (y_high - y_low) * -z_low, rel=0.05)
