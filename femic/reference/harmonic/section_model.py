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
XX, YY, ZZ, YZ, XZ, XY = range(6)  # strains
U, V, W = range(3)  # amplitudes of a node
PHI, DY, DZ = range(3)  # phi / stretch, d phi / dy, d phi / dz


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
    """Cell matrices of K0, K1, K2, shape (cells, 45, 45) each.

    All three are sums of the integrals over a cell of products of phi / stretch, d phi / dy and d phi / dz,
    phi a shape function.
    """
    products = _products(body, basis)
    constant, linear = _strains(body.side / body.rolling_radius)

    def virtual_work(strains: Array, others: Array) -> Array:
        """Matrices of the stresses by some strains in other ones, shape (cells, 45, 45)."""
        factors = np.einsum("acf,ab,bdg->fgcd", strains, _stiffness(body), others).reshape(9, 9)
        by_node = (products.reshape(-1, 9) @ factors).reshape(*products.shape[:3], 3, 3)
        return by_node.swapaxes(2, 3).reshape(len(products), 3 * basis.Nbfun, -1)

    mixed = virtual_work(constant, linear)
    return virtual_work(constant, constant), mixed + np.swapaxes(mixed, 1, 2), virtual_work(linear, linear)


def _products(body: Body, basis: Basis) -> Array:
    """Integrals of products of phi / stretch, d phi / dy, d phi / dz, shape (cells, node, node, 3, 3)."""
    stretch = _stretch(body, basis)
    values = np.empty((basis.Nbfun, 3, *stretch.shape))
    for node in range(basis.Nbfun):
        field = basis.basis[node][0]
        values[node] = field / stretch, *field.grad
    cells, points = stretch.shape
    flat = np.ascontiguousarray(values.transpose(2, 0, 1, 3)).reshape(cells, -1, points)
    products = (flat * (basis.dx * stretch)[:, None]) @ flat.swapaxes(1, 2)
    return products.reshape(cells, basis.Nbfun, 3, basis.Nbfun, 3).transpose(0, 1, 3, 2, 4)


def _stiffness(body: Body) -> Array:
    """Stresses by strains [MPa], shape (6, 6)."""
    lame, G = body.material.lame, body.material.G
    stiffness = np.zeros((6, 6))
    stiffness[:3, :3], stiffness[3:, 3:] = lame + 2 * G * np.eye(3), G * np.eye(3)
    return stiffness


def _stretch(body: Body, basis: Basis) -> Array:
    """Distance of Gauss points from the axis over R_roll, shape (cells, points); 1 on prismatic bodies."""
    z = np.asarray(basis.global_coordinates())[1]
    return np.asarray(1 - body.side * z / body.rolling_radius)


def _strains(bend: float) -> tuple[Array, Array]:
    """The strains B0 + k B1 by the amplitudes U, V, W of a node, shape (strain, amplitude, product) each.

    The last axis counts phi / stretch, d phi / dy, d phi / dz. `bend` [1/mm] is 1 / R_roll, with the sign of
    the axle's side.
    """
    constant, linear = np.zeros((2, 6, 3, 3))
    constant[YY, V, DY] = constant[ZZ, W, DZ] = constant[YZ, V, DZ] = constant[YZ, W, DY] = 1
    constant[XZ, U, DZ] = constant[XY, U, DY] = 1
    constant[XX, W, PHI], constant[XZ, U, PHI] = -bend, bend
    linear[XX, U, PHI], linear[XZ, W, PHI], linear[XY, V, PHI] = 1, -1, -1
    return constant, linear
