"""Isotropic linear elasticity on quadratic tetrahedra: the stiffness in 3 x 3 blocks per node pair."""

from collections.abc import Iterator

import numpy as np
from scipy.sparse import bsr_matrix
from skfem import Basis, ElementTetP2, MeshTet2

from geometries.arrays import Array, Indices, Mask
from geometries.materials import Material

# Rules with positive weights: exact for the stiffness of straight cells, and exact enough on curved
# ones that constant strain is reproduced there (rules of order 3 and 4 have negative weights).
STRAIGHT_ORDER, CURVED_ORDER = 2, 5
CHUNK = 10_000  # cells at a time, to bound memory


def stiffness(mesh: MeshTet2, material: Material) -> bsr_matrix:
    """Stiffness [N/mm], unknowns node by node in x, y, z; shape (3 n_nodes, 3 n_nodes).

    Block (a, b) is the integral of lambda grad_a grad_b^T + G (grad_b grad_a^T + grad_a.grad_b 1).
    """
    nodes = mesh.dofs.element_dofs.T.astype(np.int64)  # (n_cells, 10)
    n = mesh.doflocs.shape[1]
    entries, place = np.unique((nodes[:, :, None] * n + nodes[:, None, :]).ravel(), return_inverse=True)
    place = place.reshape(len(nodes), -1)
    data = np.zeros((len(entries), 9))
    for cells, order in _chunks(mesh):
        basis = Basis(mesh, ElementTetP2(), elements=cells, intorder=order)
        blocks = _cell_blocks(basis, material).reshape(-1, 9)
        for k in range(9):
            data[:, k] += np.bincount(place[cells].ravel(), blocks[:, k], minlength=len(entries))
    rows = np.searchsorted(entries, np.arange(n + 1) * n)
    return bsr_matrix((data.reshape(-1, 3, 3), entries % n, rows), shape=(3 * n, 3 * n))


def _chunks(mesh: MeshTet2) -> Iterator[tuple[Indices, int]]:
    """Cells in portions, straight and curved ones apart, with the order of their quadrature."""
    curved = is_curved(mesh)
    for chosen, order in ((~curved, STRAIGHT_ORDER), (curved, CURVED_ORDER)):
        cells = np.flatnonzero(chosen)
        for start in range(0, len(cells), CHUNK):
            yield cells[start : start + CHUNK], order


def is_curved(mesh: MeshTet2) -> Mask:
    """Whether a mid-side node of a cell lies off the middle of its edge, shape (n_cells,)."""
    middle = mesh.doflocs[:, mesh.edges].mean(axis=1)
    mid_nodes = mesh.doflocs[:, mesh.nvertices :]
    length = np.linalg.norm(np.ptp(mesh.doflocs[:, mesh.edges], axis=1), axis=0)
    bent = np.linalg.norm(mid_nodes - middle, axis=0) > 1e-10 * length
    return np.any(bent[mesh.t2e], axis=0)


def _cell_blocks(basis: Basis, material: Material) -> Array:
    """Blocks of the cells of a basis, shape (n_cells, 10, 10, 3, 3)."""
    grad = np.stack([basis.basis[a][0].grad for a in range(basis.Nbfun)])  # (10, 3, n_cells, n_q)
    products = np.einsum("aieq,bjeq,eq->eabij", grad, grad, basis.dx, optimize=True)
    dot = np.einsum("eabkk->eab", products)[..., None, None]
    return material.lame * products + material.G * (np.swapaxes(products, -1, -2) + dot * np.eye(3))


def rigid_body_modes(nodes: Array) -> Array:
    """Three translations, three rotations about x, y, z through the origin, shape (3 n_nodes, 6)."""
    x, y, z = nodes
    zero = np.zeros_like(x)
    rotations = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]])  # (component, axis, node)
    translations = np.broadcast_to(np.eye(3)[:, :, None], rotations.shape)
    return np.moveaxis(np.concatenate([translations, rotations], axis=1), 2, 0).reshape(-1, 6)
