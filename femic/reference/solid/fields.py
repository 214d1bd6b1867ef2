"""Displacements and stresses at the nodes of a body, for pictures and for programs that read VTK files.

The field of a load is the sum of parts with a parity. On the mirror images of the model each part follows
from its parity. The only module that loads meshio, which writes fields as binary VTK files (.vtu); ParaView
and PyVista open them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from skfem import ElementTetP2
from skfem.quadrature import get_quadrature

from femic.cache.files import replacing
from femic.reference.engine import Request
from femic.reference.solid.engine import Field, assemble, build_mesh, solve
from femic.reference.solid.linear import CELLS_AT_ONCE
from femic.reference.solid.mesh import SolidMesh
from femic.reference.symmetry import Y, on_plane
from geometries.arrays import Array, Indices, Mask
from geometries.materials import Material
from geometries.patches import Load, X

# --- fields at the nodes ---

P2 = ElementTetP2()


@dataclass(frozen=True, eq=False)
class VolumeGrid:
    """Quadratic tetrahedra of a model and of its mirror images, joined on the planes of symmetry."""

    nodes: Array  # (3, n_nodes) [mm]
    cells: Indices  # (10, n_cells): vertices, then the edges' mid-side nodes as scikit-fem orders them
    source: Indices  # (n_nodes,) the model's node that each node is, or of which it is an image
    image: Mask  # (2, n_nodes) whether each node is an image in x, in y


@dataclass(frozen=True, eq=False)
class NodalField:
    """The field of one unit total load at the nodes of a grid."""

    grid: VolumeGrid
    displacement: Array  # (n_nodes, 3), components x, y, z [mm/N]
    von_mises: Array  # (n_nodes,) [MPa/N]


def nodal_fields(request: Request) -> Iterator[tuple[Load, NodalField]]:
    """Solve the loads of a request, and yield each with its field on the whole body."""
    model = assemble(build_mesh(request))
    grid = figure_grid(model.solid)
    for load, field in solve(model, request.loads, request.solver).items():
        u = displacement(grid, field)
        yield load, NodalField(grid, u, von_mises(stress(grid, request.body.material, u)))


def figure_grid(solid: SolidMesh, *, whole: bool = True) -> VolumeGrid:
    """The model's nodes and cells, with their mirror images for the `whole` body.

    Nodes on a plane of symmetry belong to both.
    """
    n_nodes = solid.nodes.shape[1]
    cells = solid.mesh.dofs.element_dofs.astype(np.int64)
    grid = VolumeGrid(solid.nodes, cells, np.arange(n_nodes), np.zeros((2, n_nodes), dtype=bool))
    planes = (X, Y) if solid.half_section else (X,)
    for mirrored in planes if whole else ():
        doubled = ~on_plane(grid.nodes, mirrored)
        n_nodes = len(doubled)
        node_of_image = np.where(doubled, n_nodes - 1 + np.cumsum(doubled), np.arange(n_nodes))
        signs, image = np.ones((3, 1)), grid.image[:, doubled]
        signs[mirrored], image[mirrored] = -1, True
        grid = VolumeGrid(
            np.hstack([grid.nodes, signs * grid.nodes[:, doubled]]),
            np.hstack([grid.cells, node_of_image[grid.cells]]),
            np.append(grid.source, grid.source[doubled]),
            np.hstack([grid.image, image]),
        )
    return grid


def displacement(grid: VolumeGrid, field: Field) -> Array:
    """Displacements [mm/N] of the nodes of a grid, shape (n_nodes, 3)."""
    u = np.zeros((len(grid.source), 3))
    for parity, solution in field:
        in_x, in_y = (
            np.where(image[:, None], parity.signs(mirrored), 1.0)
            for mirrored, image in zip((X, Y), grid.image, strict=True)
        )
        u += in_x * in_y * solution.displacement[grid.source]
    return u


def stress(grid: VolumeGrid, material: Material, u: Array) -> Array:
    """Stresses [MPa per unit of load] at the nodes, shape (n_nodes, 3, 3), from displacements (n_nodes, 3).

    In each cell the stresses at four Gauss points, where quadratic cells are most accurate, are
    continued linearly to the nodes. A node has the mean over its cells, weighted with their volumes.
    """
    n_nodes = grid.nodes.shape[1]
    total, volume = np.zeros((9, n_nodes)), np.zeros(n_nodes)
    for start in range(0, grid.cells.shape[1], CELLS_AT_ONCE):
        cells = grid.cells[:, start : start + CELLS_AT_ONCE]
        sigma, cell_volume = _cell_stress(grid.nodes[:, cells], material, u[cells])
        volume += np.bincount(cells.ravel(), np.tile(cell_volume, len(cells)), minlength=n_nodes)
        for number, component in enumerate(
            (cell_volume[:, None, None, None] * sigma).reshape(*sigma.shape[:2], 9).T
        ):
            total[number] += np.bincount(cells.ravel(), component.ravel(), minlength=n_nodes)
    return np.asarray((total / volume).T.reshape(n_nodes, 3, 3))


def _cell_stress(nodes: Array, material: Material, u: Array) -> tuple[Array, Array]:
    """Stresses at the nodes of cells, shape (n_cells, 10, 3, 3), and the volumes of the cells [mm^3].

    They follow from the nodes (3, 10, n_cells) [mm] and the displacements u (10, n_cells, 3).
    """
    gauss_points, weights = get_quadrature(P2, 2)  # four Gauss points
    slopes = np.stack([P2.lbasis(gauss_points, a)[1] for a in range(10)])  # (10, 3, 4)
    jacobian = np.einsum("iae,ajq->eqij", nodes, slopes, optimize=True)
    gradient = np.einsum("aei,ajq->eqij", u, slopes, optimize=True) @ np.linalg.inv(jacobian)
    strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2
    trace = np.einsum("eqkk->eq", strain)[..., None, None]
    sigma = material.lame * trace * np.eye(3) + 2 * material.G * strain
    # linear functions
    at_nodes, at_points = (
        np.column_stack([np.ones(len(points)), points]) for points in (P2.doflocs, gauss_points.T)
    )
    continued = np.einsum("aq,eqij->eaij", at_nodes @ np.linalg.inv(at_points), sigma, optimize=True)
    return continued, np.abs(np.linalg.det(jacobian)) @ weights


def von_mises(sigma: Array) -> Array:
    """Von Mises stress of stresses (n, 3, 3): sqrt(3/2) times the norm of their deviators, shape (n,)."""
    mean = np.einsum("nkk->n", sigma)[:, None, None] / 3
    return np.sqrt(1.5) * np.linalg.norm(sigma - mean * np.eye(3), axis=(1, 2))


# --- VTK files ---

# scikit-fem numbers the mid-side nodes as VTK does: edges 01, 12, 02, 03, 13, 23.
# VTK expects vertex 3 on one side of the face 0, 1, 2. In cells that are inside out, vertices 1 and 2 are
# swapped; this is the order of their nodes:
TURNED = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]


def write_vtu(field: NodalField, path: Path) -> Path:
    """Write quadratic tetrahedra with "displacement" [mm/N] and "von_mises" [MPa/N]; returns the path."""
    import meshio

    grid = field.grid
    origin, *ends = np.moveaxis(grid.nodes[:, grid.cells[:4]], 1, 0)
    edges = np.stack([end - origin for end in ends])  # (3 edges, 3 components, n_cells)
    inside_out = np.linalg.det(np.moveaxis(edges, 2, 0)) < 0
    cells = np.where(inside_out, grid.cells[TURNED], grid.cells)
    values = {"displacement": field.displacement, "von_mises": field.von_mises}
    mesh = meshio.Mesh(grid.nodes.T, [("tetra10", cells.T)], point_data=values)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as unfinished:
        mesh.write(unfinished, file_format="vtu", binary=True)
    return path
