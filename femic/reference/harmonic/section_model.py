"""The stiffness of a section's cells at any wavenumber: K(k) = K0 + k K1 + k^2 K2, computed once.

Displacements u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart
coordinate xi = R_roll theta and the strains are cylindrical. R_roll = infinity gives the prismatic body.
Polynomials of fourth degree do not lock: Poisson's ratio may come close to 1/2 (M. Vogelius, Numer.
Math. 41, 1983, 39-53).
"""

from dataclasses import dataclass

import numpy as np
from skfem import Basis, ElementTriP4

from femic.reference.harmonic.section import SectionMesh
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.errors import Failure

QUADRATURE_ORDER = 8  # the order of products of two shape functions


@dataclass(frozen=True, eq=False)
class SectionModel:
    """A meshed section and the matrices of its cells: parts of K0, K1, K2 [N/mm^2, N/mm, N].

    Amplitude 3 n + c is the component c of node n; a cell has 15 nodes.
    """

    section: SectionMesh
    cells: Indices  # nodes of each cell (cells, 15), its corners first
    cell_matrices: tuple[Array, Array, Array]  # (cells, 45, 45)


def assemble(section: SectionMesh) -> SectionModel:
    """The cell matrices of a section.

    Raises Failure where cells are too coarse for the contour.
    """
    basis = Basis(section.mesh, ElementTriP4(), intorder=QUADRATURE_ORDER)
    _require_unfolded(basis)
    return SectionModel(section, basis.element_dofs.T.astype(np.int64), _cell_matrices(section.body, basis))


def _require_unfolded(basis: Basis) -> None:
    """Raise Failure if a curved cell overlaps itself."""
    det = basis.mapping.detDF(basis.X)
    if np.any(np.min(det, axis=1) * np.max(det, axis=1) <= 0):
        raise Failure("cells of the section are too coarse for its contour: give a smaller `growth`")


def _cell_matrices(body: Body, basis: Basis) -> tuple[Array, Array, Array]:
    """Cell matrices of K0, K1, K2, shape (cells, 45, 45) each, from strains B0 + k B1 at the Gauss points."""
    constant, linear = _strains(body, basis)  # (cells, 6, q, 45)
    lame, G = body.material.lame, body.material.G
    stress = np.zeros((6, 6))
    stress[:3, :3], stress[3:, 3:] = lame + 2 * G * np.eye(3), G * np.eye(3)
    dx = (basis.dx * _stretch(body, basis))[:, None, :, None]

    def virtual_work(strains: Array, *others: Array) -> list[Array]:
        stresses = (stress @ strains.reshape(len(strains), 6, -1)).reshape(strains.shape) * dx
        flat = stresses.reshape(len(strains), -1, strains.shape[-1])
        return [other.reshape(flat.shape).swapaxes(1, 2) @ flat for other in others]

    (static,) = virtual_work(constant, constant)
    mixed, quadratic = virtual_work(linear, constant, linear)
    return static, mixed + np.swapaxes(mixed, 1, 2), quadratic


def _stretch(body: Body, basis: Basis) -> Array:
    """Distance of Gauss points from the axis over R_roll, shape (cells, points); 1 on prismatic bodies."""
    z = np.asarray(basis.global_coordinates())[1]
    return np.asarray(1 - body.side * z / body.rolling_radius)


def _strains(body: Body, basis: Basis) -> tuple[Array, Array]:
    """Matrices B0 and B1 of the strains B0 + k B1 due to unit amplitudes U, V, W per node.

    The strains are xx, yy, zz, yz, xz, xy at the Gauss points; each matrix has shape (cells, 6, points, 45),
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
