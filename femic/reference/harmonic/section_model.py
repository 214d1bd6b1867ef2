"""The stiffness of a section at any wavenumber: K(k) = K0 + k K1 + k^2 K2, assembled once.

Displacements u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart
coordinate xi = R_roll theta and the strains are cylindrical. R_roll = infinity gives the prismatic body.
Polynomials of fourth degree do not lock: Poisson's ratio may come close to 1/2 (M. Vogelius, Numer.
Math. 41, 1983, 39-53).
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP4

from femic.reference.harmonic.equations import Stiffness
from femic.reference.harmonic.section import SectionMesh
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.errors import Failure

QUADRATURE_ORDER = 8  # the order of products of two shape functions


@dataclass(frozen=True, eq=False)
class SectionModel:
    """A meshed and assembled section.

    `amplitudes` are the numbers of all amplitudes in an order of elimination with little fill, those of the
    last nodes at the end: the rows and columns of the stiffness. Amplitude 3 n + c is the component c of node
    n.
    """

    section: SectionMesh
    amplitudes: Indices  # (unknowns,)
    stiffness: Stiffness  # K0, K1, K2 [N/mm^2, N/mm, N]


def assemble(section: SectionMesh, last: Mask | None = None) -> SectionModel:
    """Assemble K0, K1, K2 of a section; nodes marked in `last` (n_nodes,) are eliminated last.

    Raises Failure where cells are too coarse for the contour.
    """
    basis = Basis(section.mesh, ElementTriP4(), intorder=QUADRATURE_ORDER)
    _require_unfolded(basis)
    last_nodes = np.flatnonzero(np.zeros(basis.N, dtype=bool) if last is None else last)
    order, blocks = _ordered_blocks(basis.element_dofs.T.astype(np.int64), int(basis.N), last_nodes)
    return SectionModel(
        section,
        (3 * order[:, None] + np.arange(3)).ravel(),
        blocks.stiffness(_cell_matrices(section.body, basis)),
    )


@dataclass(frozen=True, eq=False)
class _Blocks:
    """The places of the blocks (3, 3) of pairs of nodes among the entries of a matrix, column by column.

    Entry (a, b) of a block lies `to_next` b + a behind its first one.
    """

    of_cells: Indices  # numbers of the blocks of each cell, (cells, 15, 15)
    row: Indices  # node of each block's rows, (n,)
    first: Indices  # place of its first entry, (n,)
    to_next: Indices  # number of entries of each of its columns, (n,)
    starts: Indices  # place of the first entry of each column of the matrix, and of the end

    @classmethod
    def of(cls, of_cells: Indices, row: Indices, column: Indices, n_nodes: int) -> "_Blocks":
        """The places of blocks that are sorted by column, then by row."""
        node_starts = np.searchsorted(column, np.arange(n_nodes + 1))
        heights = 3 * np.diff(node_starts)
        starts = 9 * node_starts[:-1, None] + heights[:, None] * np.arange(3)
        first = 9 * node_starts[column] + 3 * (np.arange(len(row)) - node_starts[column])
        return cls(of_cells, row, first, heights[column], np.append(starts.ravel(), 9 * len(row)))

    def stiffness(self, cell_matrices: tuple[Array, Array, Array]) -> Stiffness:
        """The sums of cell matrices, (cells, 45, 45) each."""
        a, b = np.arange(3)[:, None], np.arange(3)
        places = self.first[:, None, None] + self.to_next[:, None, None] * b + a  # (n, 3, 3)
        indices = np.empty(places.size, dtype=np.int32)
        indices[places] = 3 * self.row[:, None, None] + a
        entry_places = np.swapaxes(places[self.of_cells], 2, 3).ravel()  # as (cells, 15, 3, 15, 3)
        k0, k1, k2 = (
            np.bincount(entry_places, part.ravel(), places.size).astype(float, copy=False)
            for part in cell_matrices
        )
        n = len(self.starts) - 1
        pattern = csc_matrix((np.ones(places.size), indices, self.starts.astype(np.int32)), shape=(n, n))
        return Stiffness(pattern, (k0, k1, k2))


def _ordered_blocks(cells: Indices, n_nodes: int, last: Indices) -> tuple[Indices, _Blocks]:
    """An order of elimination of the nodes of cells (n, 15), some of them last, and the blocks in it."""
    columns_and_rows = (cells[:, None, :] * n_nodes + cells[:, :, None]).ravel()
    pairs, pair_of_cells = np.unique(columns_and_rows, return_inverse=True)
    place = _places(pairs, n_nodes, last)
    column, row = place[np.stack(np.divmod(pairs, n_nodes))]
    sorted_pairs = np.lexsort((row, column))
    number = np.empty_like(sorted_pairs)
    number[sorted_pairs] = np.arange(len(pairs))
    of_cells = number[pair_of_cells].reshape(len(cells), 15, 15)
    return np.argsort(place), _Blocks.of(of_cells, row[sorted_pairs], column[sorted_pairs], n_nodes)


def _places(pairs: Indices, n_nodes: int, last: Indices) -> Indices:
    """Places of the nodes in an order by minimum degree, the last ones behind all others, shape (n_nodes,).

    `pairs` are column * n_nodes + row of the entries of a matrix of the nodes. What is eliminated before the
    last nodes joins them all: so they are taken as joined from the start.
    """
    joined = (last[:, None] * n_nodes + last).ravel()
    column, row = np.divmod(np.union1d(pairs, joined), n_nodes)
    values = np.where(column == row, float(n_nodes), -1.0)
    starts = np.searchsorted(column, np.arange(n_nodes + 1))
    graph = csc_matrix((values, row, starts), shape=(n_nodes, n_nodes))
    elimination = splu(
        graph, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    ).perm_c.astype(np.int64)
    elimination[last] += n_nodes
    return np.argsort(np.argsort(elimination))


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
