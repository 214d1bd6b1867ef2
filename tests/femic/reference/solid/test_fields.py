"""Fields on the whole body: mirror images, stresses against closed forms, and their files."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial import cKDTree

from femic.reference.engine import Points
from femic.reference.meshing import Cells
from femic.reference.solid.engine import assemble, build_mesh, observe, solve
from femic.reference.solid.fields import (
    NodalField,
    displacement,
    figure_grid,
    nodal_fields,
    stress,
    von_mises,
    write_vtu,
)
from femic.reference.solid.linear import is_curved
from femic.reference.symmetry import Y, on_plane
from geometries.contours import plane
from geometries.patches import Load, Patch, X
from geometries.surfaces import LOWER, UPPER
from tests.femic.reference.conftest import STEEL, SYMMETRIC, UNSYMMETRIC, request_for

CENTRED, ASIDE = Patch(0.3, 0.5), Patch(0.3, 0.5, s=1.2)
STRAIN = np.array([[1.0, 0.3, -0.2], [0.1, -0.7, 0.4], [0.5, -0.6, 0.8]])  # a gradient, with a rigid turn


@pytest.fixture(scope="module", params=[pytest.param("quarter", marks=pytest.mark.slow), "half", "wheel"])
def model(request):
    if request.param == "wheel":
        return assemble(build_mesh(request_for(SYMMETRIC, side=UPPER, rolling_radius=60.0)))
    return assemble(build_mesh(request_for(SYMMETRIC if request.param == "quarter" else UNSYMMETRIC)))


@pytest.fixture(scope="module")
def fields(model):
    loads = [Load(patch, direction) for patch in (CENTRED, ASIDE) for direction in (0, 1, 2)]
    return solve(model, loads, "auto")


@pytest.fixture(scope="module")
def flat():
    return figure_grid(build_mesh(request_for(plane())))


def simple_chart(solid, grid):
    """Numbers of the nodes on the contact surface near the patch, images included, and their (xi, s)."""
    chart = np.full((2, solid.nodes.shape[1]), np.nan)
    chart[:, solid.trace.nodes] = solid.trace.basis.doflocs
    chart = np.where(grid.image, -1, 1) * chart[:, grid.source]
    near = np.flatnonzero(np.all(np.abs(chart) < 6.0, axis=0))
    return near, chart[:, near]


def test_images_of_surface_nodes_lie_on_the_surface(model):
    solid, grid = model.solid, figure_grid(model.solid)
    near, chart = simple_chart(solid, grid)
    assert np.all(np.any(chart < -0.1, axis=1))
    np.testing.assert_allclose(grid.nodes[:, near], solid.body.surface.position(*chart), atol=1e-12 * 40)


@pytest.mark.parametrize("patch", [CENTRED, ASIDE], ids=["centred", "aside"])
def test_displacements_are_those_that_observers_see(model, fields, patch):
    solid, grid = model.solid, figure_grid(model.solid)
    near, (xi, s) = simple_chart(solid, grid)
    x = xi / solid.body.surface.chart_x(1.0, s, patch.s)
    for direction in (0, 1, 2):
        load = Load(patch, direction)
        u = displacement(grid, fields[load])
        seen = observe(model, load, fields[load], Points(x, s))
        local = np.einsum("icp,pc->ip", solid.body.surface.axes(xi, s), u[near])
        np.testing.assert_allclose(local, seen, atol=1e-9 * np.abs(seen).max())


def test_no_node_is_there_twice(model, fields):
    """So fields are continuous where a body meets its image. The modelled part alone has its own nodes."""
    solid = model.solid
    part, whole = figure_grid(solid, whole=False), figure_grid(solid)
    apart = cKDTree(whole.nodes.T).query(whole.nodes.T, k=2)[0][:, 1]
    assert apart.min() > 0.01
    assert whole.cells.shape[1] == (4 if solid.half_section else 2) * part.cells.shape[1]
    assert set(whole.cells.ravel()) == set(range(whole.nodes.shape[1]))
    ((_, solution),) = fields[Load(CENTRED, 1)]
    np.testing.assert_array_equal(displacement(part, fields[Load(CENTRED, 1)]), solution.displacement)


def test_on_a_plane_of_symmetry_a_field_equals_its_image(model, fields):
    grid = figure_grid(model.solid)
    planes = [(X, grid.image[0])] + ([(Y, grid.image[1])] if model.solid.half_section else [])
    for (load, field), (mirrored, image) in product(fields.items(), planes):
        on = on_plane(grid.nodes, mirrored)
        assert not np.any(image[on])
        flipped = replace(grid, image=grid.image ^ (on & (np.arange(2)[:, None] == mirrored)))
        u, other = displacement(grid, field), displacement(flipped, field)
        np.testing.assert_allclose(other, u, atol=1e-12 * np.abs(u).max(), err_msg=str(load))


@pytest.mark.parametrize("side", [LOWER, UPPER])
def test_a_linear_displacement_has_its_exact_stress_on_curved_cells(side):
    solid = build_mesh(request_for(UNSYMMETRIC, side=side))
    assert np.any(is_curved(solid.mesh))
    grid = figure_grid(solid)
    sigma = stress(grid, STEEL, (STRAIN @ grid.nodes).T)
    strain = (STRAIN + STRAIN.T) / 2
    exact = STEEL.lame * np.trace(strain) * np.eye(3) + 2 * STEEL.G * strain
    np.testing.assert_allclose(sigma, np.broadcast_to(exact, sigma.shape), atol=1e-9 * STEEL.E)
    s = exact
    formula = (s[0, 0] - s[1, 1]) ** 2 + (s[1, 1] - s[2, 2]) ** 2 + (s[2, 2] - s[0, 0]) ** 2
    formula = np.sqrt(formula / 2 + 3 * (s[0, 1] ** 2 + s[1, 2] ** 2 + s[2, 0] ** 2))
    np.testing.assert_allclose(von_mises(sigma), formula, rtol=1e-9)


def test_a_quadratic_displacement_has_its_exact_stress_on_straight_cells(flat):
    x, y, z = flat.nodes
    u = np.stack([x**2 - y * z, 3 * x * y + z**2, 2 * z**2 - x * z], axis=1)
    zero = np.zeros_like(x)
    gradient = np.array([[2 * x, -z, -y], [3 * y, 3 * x, 2 * z], [-z, zero, 4 * z - x]])
    strain = np.moveaxis(gradient + np.swapaxes(gradient, 0, 1), 2, 0) / 2
    trace = np.einsum("nkk->n", strain)[:, None, None]
    exact = STEEL.lame * trace * np.eye(3) + 2 * STEEL.G * strain
    result = stress(flat, STEEL, u)
    np.testing.assert_allclose(result, exact, atol=1e-9 * np.abs(exact).max())


def test_stress_below_a_uniform_pressure_is_that_of_boussinesq():
    cells = Cells(0.06, 0.3, 0.15)
    points = Points(np.array([0.5]), np.array([0.5]))
    asked = request_for(plane(), directions=(2,), cells=cells, points=points)
    ((_, field),) = nodal_fields(asked)
    x, y, z = field.grid.nodes
    on_axis = (np.hypot(x, y) < 1e-9) & (z < -0.1) & (z > -1.5)
    assert np.sum(on_axis) > 10
    exact = np.array([boussinesq_von_mises(CENTRED, depth) for depth in -z[on_axis]])
    # cells of about a fifth of the patch's half-side: a few percent
    np.testing.assert_allclose(field.von_mises[on_axis], exact, rtol=0.05)
    np.testing.assert_allclose(field.von_mises[on_axis].mean(), exact.mean(), rtol=0.01)


def boussinesq_von_mises(patch, z):
    """Von Mises stress at depth z below the centre of a unit load, uniform over a rectangle.

    Principal stresses of the point load as in K. L. Johnson, Contact Mechanics, eqs 3.19; nu is STEEL's.
    """
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x, y = np.meshgrid(patch.a * nodes, patch.b * nodes, indexing="ij")
    share = np.outer(weights, weights) / 4
    r2, rho = x**2 + y**2, np.sqrt(x**2 + y**2 + z**2)
    lateral = (1 - 2 * STEEL.nu) / r2
    along = [
        lateral * ((1 - z / rho) * (p**2 - q**2) / r2 + z * q**2 / rho**3) - 3 * z * p**2 / rho**5
        for p, q in ((x, y), (y, x))
    ]
    principal = [np.sum(share * part) / (2 * np.pi) for part in (*along, -3 * z**3 / rho**5)]
    return np.sqrt(1.5) * np.linalg.norm(principal - np.mean(principal))


# --- files ---------------------------------------------------------------------------------------------

QUADRATIC_TETRAHEDRON = 24
VTK_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]  # of vtkQuadraticTetra, nodes 4 to 9


def written(grid, path):
    """A field on a grid, and what PyVista reads of its file."""
    pyvista = pytest.importorskip("pyvista")
    x, y, z = grid.nodes
    field = NodalField(grid, np.stack([x**2, y - z, x * y / 7], axis=1), np.abs(x) + y**2)
    return field, pyvista.read(write_vtu(field, path))


def test_nodes_and_values_come_back_exactly(tmp_path):
    grid = figure_grid(build_mesh(request_for(UNSYMMETRIC, side=UPPER)))
    field, read = written(grid, tmp_path / "new" / "folder" / "upper_n.vtu")
    np.testing.assert_array_equal(read.points, grid.nodes.T)
    np.testing.assert_array_equal(read["displacement"], field.displacement)
    np.testing.assert_array_equal(read["von_mises"], field.von_mises)
    assert set(read.celltypes) == {QUADRATIC_TETRAHEDRON}
    assert read.n_cells == grid.cells.shape[1]


def test_cells_have_the_order_of_nodes_that_vtk_defines(flat, tmp_path):
    """Mid-side nodes lie in the middle of their edges; no cell is inside out, as mirror images turn them."""
    _, read = written(flat, tmp_path / "flat.vtu")
    nodes = read.points[read.cells_dict[QUADRATIC_TETRAHEDRON]]  # (n_cells, 10, 3)
    middles = np.stack([nodes[:, edge].mean(axis=1) for edge in VTK_EDGES], axis=1)
    np.testing.assert_allclose(nodes[:, 4:], middles, atol=1e-10)
    a, b, c, d = np.moveaxis(nodes[:, :4], 1, 0)
    volumes = np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) / 6
    assert volumes.min() > 0
    x_low, x_high, y_low, y_high, z_low, _ = read.bounds
    assert volumes.sum() == pytest.approx(np.pi / 4 * (x_high - x_low) * (y_high - y_low) * -z_low, rel=0.05)
