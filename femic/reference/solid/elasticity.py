"""Isotropic linear elasticity on quadratic tetrahedra: the stiffness matrix in 3 x 3 blocks per node pair."""

from collections.abc import Iterator

import numpy as np
from scipy.sparse import bsr_matrix
from skfem import Basis, ElementTetP2, MeshTet2

from geometries.arrays import Array, Indices, Mask
from geometries.materials import Material

# Orders of quadrature rules with positive weights (rules of order 3 and 4 have negative ones). The first is
# exact for the stiffness of straight cells; the second reproduces constant strain on curved cells.
STRAIGHT_ORDER, CURVED_ORDER = 2, 5
CELLS_AT_ONCE = 10_000  # number of cells at a time, to bound memory


def stiffness(mesh: MeshTet2, material: Material) -> bsr_matrix:
    """Stiffness matrix [N/mm], shape (3 n_nodes, 3 n_nodes); unknowns are x, y, z node by node.

    Block (a, b) is the integral of lambda grad_a grad_b^T + G (grad_b grad_a^T + grad_a.grad_b 1).
    """
    nodes = mesh.dofs.element_dofs.T.astype(np.int64)  # (n_cells, 10)
    n_nodes = mesh.doflocs.shape[1]
    entries, entry_number = np.unique(
        (nodes[:, :, None] * n_nodes + nodes[:, None, :]).ravel(), return_inverse=True
    )
    entry_number = entry_number.reshape(len(nodes), -1)
    data = np.zeros((len(entries), 9))
    for cells, order in _chunks(mesh):
        basis = Basis(mesh, ElementTetP2(), elements=cells, intorder=order)
        blocks = _cell_blocks(basis, material).reshape(-1, 9)
        for component in range(9):
            data[:, component] += np.bincount(
                entry_number[cells].ravel(), blocks[:, component], minlength=len(entries)
            )
    rows = np.searchsorted(entries, np.arange(n_nodes + 1) * n_nodes)
    return bsr_matrix((data.reshape(-1, 3, 3), entries % n_nodes, rows), shape=(3 * n_nodes, 3 * n_nodes))


def _chunks(mesh: MeshTet2) -> Iterator[tuple[Indices, int]]:
    """Numbers of cells in portions, first straight then curved cells, with the order of their quadrature."""
    curved = is_curved(mesh)
    for is_chosen, order in ((~curved, STRAIGHT_ORDER), (curved, CURVED_ORDER)):
        cells = np.flatnonzero(is_chosen)
        for start in range(0, len(cells), CELLS_AT_ONCE):
            yield cells[start : start + CELLS_AT_ONCE], order


def is_curved(mesh: MeshTet2) -> Mask:
    """Whether a mid-side node of a cell lies off the middle of its edge, shape (n_cells,)."""
    middle = mesh.doflocs[:, mesh.edges].mean(axis=1)
    mid_nodes = mesh.doflocs[:, mesh.nvertices :]
    length = np.linalg.norm(np.ptp(mesh.doflocs[:, mesh.edges], axis=1), axis=0)
    bent = np.linalg.norm(mid_nodes - middle, axis=0) > 1e-10 * length
    return np.any(bent[mesh.t2e], axis=0)


def _cell_blocks(basis: Basis, material: Material) -> Array:
    """Stiffness blocks of the cells of a basis [N/mm], shape (n_cells, 10, 10, 3, 3)."""
    grad = np.stack([basis.basis[a][0].grad for a in range(basis.Nbfun)])  # (10, 3, n_cells, n_q)
    products = np.einsum("aieq,bjeq,eq->eabij", grad, grad, basis.dx, optimize=True)
    dot = np.einsum("eabkk->eab", products)[..., None, None]
    return material.lame * products + material.G * (np.swapaxes(products, -1, -2) + dot * np.eye(3))


def rigid_body_modes(nodes: Array) -> Array:
    """Three translations and three rotations about x, y, z through the origin, shape (3 n_nodes, 6)."""
    x, y, z = nodes
    zero = np.zeros_like(x)
    rotations = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]])  # (component, axis, node)
    translations = np.broadcast_to(np.eye(3)[:, :, None], rotations.shape)
    return np.moveaxis(np.concatenate([translations, rotations], axis=1), 2, 0).reshape(-1, 6)
