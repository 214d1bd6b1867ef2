"""The stiffness of a section at any wavenumber: K(k) = K0 + k K1 + k^2 K2, assembled once.

Displacements u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart
coordinate xi = R_roll theta and the strains are cylindrical. R_roll = infinity gives the prismatic body.
Polynomials of fourth degree do not lock: Poisson's ratio may come close to 1/2 (M. Vogelius, Numer.
Math. 41, 1983, 39-53).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP4

from femic.harmonic.equations import FreeSystem, Stiffness
from femic.harmonic.section import SectionMesh
from femic.symmetry import held_by_supports
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.errors import Failure

QUADRATURE_ORDER = 8  # the order of products of two shape functions


@dataclass(frozen=True, eq=False)
class SectionModel:
    """A meshed and assembled section."""

    section: SectionMesh
    parts: tuple[csc_matrix, csc_matrix, csc_matrix]  # K0, K1, K2 [N/mm^2, N/mm, N], of one sparsity pattern
    supported: Mask  # (n_nodes, 3) amplitudes held by the far arc and the hub

    @property
    def unknowns(self) -> int:
        """Number of amplitudes of the model, held ones included."""
        return int(self.supported.size)

    @cached_property
    def order(self) -> Indices:
        """Numbers of the nodes in an order of elimination with little fill, by minimum degree."""
        nodes = csc_matrix(self.parts[0][::3, ::3])
        nodes.data = np.where(nodes.indices == _columns(nodes), float(nodes.shape[0]), -1.0)
        factors = splu(
            nodes, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        return np.argsort(factors.perm_c)

    def free_of(self, held: Mask) -> FreeSystem:
        """The equations of the free amplitudes, where those marked in `held` (n_nodes, 3) are 0."""
        unknowns = (3 * self.order[:, None] + np.arange(3)).ravel()
        free = unknowns[~held.ravel()[unknowns]]
        numbered_entries = self.parts[0].copy()
        numbered_entries.data = np.arange(1.0, len(numbered_entries.data) + 1)
        pattern = csc_matrix(numbered_entries[free][:, free])
        pattern.sort_indices()  # or SuperLU sorts them, and all wavenumbers share them
        entries = pattern.data.astype(np.int64) - 1
        k0, k1, k2 = (part.data[entries] for part in self.parts)
        return FreeSystem(free, Stiffness(pattern, (k0, k1, k2)))


def _columns(matrix: csc_matrix) -> Indices:
    """The column of each entry."""
    return np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))


def assemble(section: SectionMesh) -> SectionModel:
    """Assemble K0, K1, K2 of a section; the far arc and the hub are its supports.

    Raises Failure where cells are too coarse for the contour.
    """
    basis = Basis(section.mesh, ElementTriP4(), intorder=QUADRATURE_ORDER)
    _require_unfolded(basis)
    cell_matrices = _cell_matrices(section.body, basis)  # (3, cells, 45, 45)
    n = 3 * basis.N
    unknowns = (3 * basis.element_dofs.T[:, :, None].astype(np.int64) + np.arange(3)).reshape(
        len(cell_matrices[0]), -1
    )
    positions = (unknowns[:, None, :] * n + unknowns[:, :, None]).ravel()
    entries, entry_numbers = np.unique(positions, return_inverse=True)
    starts = np.searchsorted(entries, np.arange(n + 1) * n)
    k0, k1, k2 = (
        csc_matrix(
            (np.bincount(entry_numbers, part.ravel(), len(entries)), entries % n, starts), shape=(n, n)
        )
        for part in cell_matrices
    )
    y, z = section.mesh.p[:, : section.mesh.nvertices]
    return SectionModel(section, (k0, k1, k2), held_by_supports(section.body, section.mesh, y, z))


def _require_unfolded(basis: Basis) -> None:
    """Raise Failure if a curved cell overlaps itself."""
    det = basis.mapping.detDF(basis.X)
    if np.any(np.min(det, axis=1) * np.max(det, axis=1) <= 0):
        raise Failure("cells of the section are too coarse for its contour: give a smaller `growth`")


def _cell_matrices(body: Body, basis: Basis) -> tuple[Array, Array, Array]:
    """Cell matrices of K0, K1, K2, shape (cells, 45, 45) each, from strains B0 + k B1 at the Gauss points."""
    constant, linear = _strains(body, basis)  # (cells, 6 q, 45)
    lame, G = body.material.lame, body.material.G
    stress = np.zeros((6, 6))
    stress[:3, :3], stress[3:, 3:] = lame + 2 * G * np.eye(3), G * np.eye(3)
    dx = basis.dx * _stretch(body, basis)

    def product(left: Array, right: Array) -> Array:
        cell_shape = (len(dx), -1, left.shape[-1])
        stresses = np.einsum("ab,ebqd,eq->eaqd", stress, right, dx, optimize=True)
        return left.reshape(cell_shape).swapaxes(1, 2) @ stresses.reshape(cell_shape)

    mixed = product(constant, linear)
    return product(constant, constant), mixed + np.swapaxes(mixed, 1, 2), product(linear, linear)


def _stretch(body: Body, basis: Basis) -> Array:
    """Distance of Gauss points from the axis over R_roll, shape (cells, points); 1 on prismatic bodies."""
    z = np.asarray(basis.global_coordinates())[1]
    return np.asarray(1 - body.side * z / body.rolling_radius)


def _strains(body: Body, basis: Basis) -> tuple[Array, Array]:
    """Matrices B0 and B1 of the strains B0 + k B1 due to unit amplitudes U, V, W per node.

    The strains are xx, yy, zz, yz, xz, xy at the Gauss points; each matrix has shape (cells, 6 points, 45),
    45 the amplitudes of a cell.
    """
    stretch = _stretch(body, basis)
    bend = body.side / (body.rolling_radius * stretch)
    cells, points = stretch.shape
    constant, linear = np.zeros((2, cells, 6, points, basis.Nbfun, 3))
    for node in range(basis.Nbfun):
        field = basis.basis[node][0]
        phi, (dy, dz) = np.broadcast_to(np.asarray(field), stretch.shape), field.grad
        constant[:, 0, :, node, 2] = -bend * phi
        constant[:, 1, :, node, 1] = constant[:, 5, :, node, 0] = constant[:, 3, :, node, 2] = dy
        constant[:, 2, :, node, 2] = constant[:, 3, :, node, 1] = dz
        constant[:, 4, :, node, 0] = dz + bend * phi
        linear[:, 0, :, node, 0] = phi / stretch
        linear[:, 4, :, node, 2] = linear[:, 5, :, node, 1] = -phi / stretch
    shape = (cells, 6, points, 3 * basis.Nbfun)
    return constant.reshape(shape), linear.reshape(shape)
