"""Displacements and stresses at the nodes of a body, for pictures and for programs that read VTK files.

On the modelled part the parts of a field add up to it; its mirror images follow from their parities.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from skfem import ElementTetP2
from skfem.quadrature import get_quadrature

from femic.solid.elasticity import CHUNK
from femic.solid.engine import Field, assemble, build_mesh, solve
from femic.solid.mesh import SolidMesh
from femic.solid.request import SolidRequest
from femic.symmetry import Y, on_plane
from geometries.arrays import Array, Indices, Mask
from geometries.materials import Material
from geometries.patches import Load, X

P2 = ElementTetP2()


@dataclass(frozen=True, eq=False)
class Grid:
    """Quadratic tetrahedra of a model and of its mirror images, joined on the planes of symmetry."""

    nodes: Array  # (3, n_nodes) [mm]
    cells: Indices  # (10, n_cells): vertices, then the edges' mid-side nodes as scikit-fem orders them
    source: Indices  # (n_nodes,) the model's node that each one is, or is an image of
    image: Mask  # (2, n_nodes) whether it is an image in x, in y


@dataclass(frozen=True, eq=False)
class NodalField:
    """What one unit total load does at the nodes of a grid."""

    grid: Grid
    displacement: Array  # (n_nodes, 3), components x, y, z [mm/N]
    von_mises: Array  # (n_nodes,) [MPa/N]


def nodal_fields(request: SolidRequest, *, whole: bool = True) -> Iterator[tuple[Load, NodalField]]:
    """Solve the request's loads: the fields on the whole body, or on the part of it that is modelled."""
    model = assemble(build_mesh(request))
    grid = grid_of(model.solid, whole=whole)
    for load, field in solve(model, request.loads, request.solver).items():
        u = displacement(grid, field)
        yield load, NodalField(grid, u, von_mises(stress(grid, request.body.material, u)))


def grid_of(solid: SolidMesh, *, whole: bool = True) -> Grid:
    """The model's nodes and cells, with their mirror images for the `whole` body."""
    n = solid.nodes.shape[1]
    cells = solid.mesh.dofs.element_dofs.astype(np.int64)
    grid = Grid(solid.nodes, cells, np.arange(n), np.zeros((2, n), dtype=bool))
    for mirrored in (X, Y) if solid.half_section else (X,):
        grid = _with_image(grid, mirrored) if whole else grid
    return grid


def _with_image(grid: Grid, mirrored: int) -> Grid:
    """The grid and its mirror image, which share the nodes on the plane of symmetry."""
    doubled = ~on_plane(grid.nodes, mirrored)
    n = len(doubled)
    node_of_image = np.where(doubled, n - 1 + np.cumsum(doubled), np.arange(n))
    signs, image = np.ones((3, 1)), grid.image[:, doubled]
    signs[mirrored], image[mirrored] = -1, True
    return Grid(
        np.hstack([grid.nodes, signs * grid.nodes[:, doubled]]),
        np.hstack([grid.cells, node_of_image[grid.cells]]),
        np.append(grid.source, grid.source[doubled]),
        np.hstack([grid.image, image]),
    )


def displacement(grid: Grid, field: Field) -> Array:
    """Displacements [mm/N] of the grid's nodes, shape (n_nodes, 3)."""
    u = np.zeros((len(grid.source), 3))
    for parity, solution in field:
        in_x, in_y = (
            np.where(image[:, None], parity.signs(mirrored), 1.0)
            for mirrored, image in zip((X, Y), grid.image, strict=True)
        )
        u += in_x * in_y * solution.displacement[grid.source]
    return u


def stress(grid: Grid, material: Material, u: Array) -> Array:
    """Stresses [MPa per unit of load] at the nodes, shape (n_nodes, 3, 3), from displacements (n_nodes, 3).

    In each cell the stresses at four Gauss points, where those of quadratic cells are best, are
    continued linearly to its nodes. A node has the mean of its cells, weighted with their volumes.
    """
    n = grid.nodes.shape[1]
    total, volume = np.zeros((9, n)), np.zeros(n)
    for start in range(0, grid.cells.shape[1], CHUNK):
        cells = grid.cells[:, start : start + CHUNK]
        sigma, size = _cell_stress(grid.nodes[:, cells], material, u[cells])
        volume += np.bincount(cells.ravel(), np.tile(size, len(cells)), minlength=n)
        for k, component in enumerate((size[:, None, None, None] * sigma).reshape(*sigma.shape[:2], 9).T):
            total[k] += np.bincount(cells.ravel(), component.ravel(), minlength=n)
    return np.asarray((total / volume).T.reshape(n, 3, 3))


def _cell_stress(nodes: Array, material: Material, u: Array) -> tuple[Array, Array]:
    """Stresses at the nodes of cells, shape (n_cells, 10, 3, 3), and volumes.

    Both from nodes (3, 10, n_cells) and displacements u (10, n_cells, 3).
    """
    at, weights = get_quadrature(P2, 2)  # four Gauss points
    slopes = np.stack([P2.lbasis(at, a)[1] for a in range(10)])  # (10, 3, 4)
    jacobian = np.einsum("iae,ajq->eqij", nodes, slopes, optimize=True)
    gradient = np.einsum("aei,ajq->eqij", u, slopes, optimize=True) @ np.linalg.inv(jacobian)
    strain = (gradient + np.swapaxes(gradient, -1, -2)) / 2
    trace = np.einsum("eqkk->eq", strain)[..., None, None]
    sigma = material.lame * trace * np.eye(3) + 2 * material.G * strain
    continued = np.einsum("aq,eqij->eaij", _continuation(at), sigma, optimize=True)
    return continued, np.abs(np.linalg.det(jacobian)) @ weights


def _continuation(at: Array) -> Array:
    """Matrix (10, 4) that takes the values of a linear function at four points to the cell's nodes."""
    linear = [np.column_stack([np.ones(len(points)), points]) for points in (P2.doflocs, at.T)]
    return linear[0] @ np.linalg.inv(linear[1])


def von_mises(sigma: Array) -> Array:
    """Von Mises stress of stresses (n, 3, 3): sqrt(3/2) times the norm of their deviators, shape (n,)."""
    mean = np.einsum("nkk->n", sigma)[:, None, None] / 3
    return np.sqrt(1.5) * np.linalg.norm(sigma - mean * np.eye(3), axis=(1, 2))
