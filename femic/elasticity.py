"""Isotropic linear elasticity on quadratic tetrahedra: the stiffness in 3 x 3 blocks per node pair."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_matrix
from skfem import Basis, ElementTetP2, MeshTet2

from geometries.materials import Material

Array = NDArray[np.float64]
QUADRATURE_ORDER = 2  # exact on straight cells; the rules of order 3 and 4 have negative weights
CHUNK = 20_000  # cells at a time, to bound memory


def stiffness(mesh: MeshTet2, material: Material) -> bsr_matrix:
    """Stiffness [N/mm], unknowns node by node in x, y, z; shape (3 n_nodes, 3 n_nodes).

    Block (a, b) is the integral of lambda grad_a grad_b^T + G (grad_b grad_a^T + grad_a.grad_b 1).
    """
    basis = Basis(mesh, ElementTetP2(), intorder=QUADRATURE_ORDER)
    n = basis.N
    nodes = basis.element_dofs.T.astype(np.int64)  # (n_cells, 10)
    keys = (nodes[:, :, None] * n + nodes[:, None, :]).ravel()
    entries, place = np.unique(keys, return_inverse=True)
    data = np.zeros((len(entries), 9))
    per_cell = nodes.shape[1] ** 2
    for start in range(0, len(nodes), CHUNK):
        cells = slice(start, start + CHUNK)
        where = place[start * per_cell : (start + CHUNK) * per_cell]
        blocks = _cell_blocks(basis, cells, material).reshape(-1, 9)
        for k in range(9):
            data[:, k] += np.bincount(where, blocks[:, k], minlength=len(entries))
    rows = np.searchsorted(entries, np.arange(n + 1) * n)
    return bsr_matrix((data.reshape(-1, 3, 3), entries % n, rows), shape=(3 * n, 3 * n))


def _cell_blocks(basis: Basis, cells: slice, material: Material) -> Array:
    """Blocks of a range of cells, shape (n_cells, 10, 10, 3, 3)."""
    grad = np.stack([basis.basis[a][0].grad[:, cells] for a in range(basis.Nbfun)])  # (10, 3, n_cells, n_q)
    products = np.einsum("aieq,bjeq,eq->eabij", grad, grad, basis.dx[cells], optimize=True)
    dot = np.einsum("eabkk->eab", products)[..., None, None]
    return np.asarray(
        material.lame * products + material.G * (np.swapaxes(products, -1, -2) + dot * np.eye(3))
    )


def rigid_body_modes(nodes: Array) -> Array:
    """Three translations, three rotations about x, y, z through the origin, shape (3 n_nodes, 6)."""
    x, y, z = nodes
    zero = np.zeros_like(x)
    rotations = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]])  # (component, axis, node)
    translations = np.broadcast_to(np.eye(3)[:, :, None], rotations.shape)
    return np.moveaxis(np.concatenate([translations, rotations], axis=1), 2, 0).reshape(-1, 6)
