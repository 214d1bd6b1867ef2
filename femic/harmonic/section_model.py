"""The stiffness of a section at any wavenumber: K(k) = K0 + k K1 + k^2 K2, assembled once.

Displacements u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart
coordinate xi = R_roll theta and the strains are cylindrical. R_roll = infinity gives the prismatic body.
Polynomials of fourth degree do not lock: Poisson's ratio may come close to 1/2 (M. Vogelius, Numer.
Math. 41, 1983, 39-53).
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu
from skfem import Basis, ElementTriP4

from femic.accuracy import NotConverged
from femic.harmonic.section import SectionMesh
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.errors import Failure

QUADRATURE_ORDER = 8  # the order of products of two shape functions
# A tenth of the tightest tolerance. The relative error of the displacements is a quarter of the residual or
# less (measured by a step of iterative refinement). Rounding leaves residuals of 1e-14 at large k, and of
# 5e-12 at k = 0 and nu = 0.28. They grow in proportion to 1 / (1 - 2 nu): 3e-9 at nu = 0.4999, and there 1e-7
# under a patch of aspect 0.01 (144 000 unknowns).
LARGEST_RESIDUAL = 1e-5


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

    def free_of(self, held: Mask) -> "FreeSystem":
        """The equations of the free amplitudes, where those marked in `held` (n_nodes, 3) are 0."""
        free = np.flatnonzero(~held.ravel())
        numbered_entries = self.parts[0].copy()
        numbered_entries.data = np.arange(1.0, len(numbered_entries.data) + 1)
        pattern = csc_matrix(numbered_entries[free][:, free])
        entries = pattern.data.astype(np.int64) - 1
        k0, k1, k2 = (part.data[entries] for part in self.parts)
        return FreeSystem(free, pattern, (k0, k1, k2))


@dataclass(frozen=True, eq=False)
class FreeSystem:
    """The equations of the free amplitudes: at each wavenumber one factorisation serves all loads."""

    free: Indices
    pattern: csc_matrix
    parts: tuple[Array, Array, Array]  # data of K0, K1, K2 in this pattern

    def solved(self, k: float, forces: Array) -> tuple[Array, float]:
        """Amplitudes (unknowns, n) under forces (unknowns, n) at one wavenumber, and their residual.

        The residual ||K u - f|| / ||f|| is that of all columns at once, each divided by the norm of its force
        and multiplied by a random factor of size 1 to 2. It takes one product with K; the division keeps
        large columns from hiding small ones, the factors keep two columns from cancelling. Raises
        NotConverged where K(k) has no factors, and where the residual is above `LARGEST_RESIDUAL` or no
        number.
        """
        matrix = self._matrix(k)
        f = np.ascontiguousarray(forces[self.free])
        u = np.zeros_like(forces)
        u[self.free] = _factor(matrix, k).solve(f)
        column_weights = _random_factors(forces.shape[1]) / np.linalg.norm(f, axis=0)
        residual = float(np.linalg.norm(matrix @ (u[self.free] @ column_weights) - f @ column_weights))
        if not residual <= LARGEST_RESIDUAL:
            raise NotConverged(
                _not_solved(
                    k,
                    len(self.free),
                    f"the residual is {residual:.1e} of the forces, {LARGEST_RESIDUAL:.0e} allowed",
                )
            )
        return u, residual

    def _matrix(self, k: float) -> csc_matrix:
        """K(k) of the free amplitudes."""
        data = self.parts[0] + k * self.parts[1] + k * k * self.parts[2]
        return csc_matrix((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)


def _factor(matrix: csc_matrix, k: float) -> SuperLU:
    """The LU factors of K(k); raises NotConverged where SuperLU finds none."""
    try:
        return splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError as error:  # SuperLU met a pivot that is 0
        raise NotConverged(_not_solved(k, matrix.shape[0], str(error))) from error


def _random_factors(n: int) -> Array:
    """Repeatable random numbers of size 1 to 2 and either sign, shape (n,)."""
    generator = np.random.default_rng(0)
    return generator.uniform(1.0, 2.0, n) * generator.choice([-1.0, 1.0], n)


def _not_solved(k: float, unknowns: int, reason: str) -> str:
    """The message of an error at a wavenumber [1/mm]."""
    return (
        f"section at the wavenumber k = {k:.4g} 1/mm, {unknowns:,} unknowns: not solved: {reason}. Likely "
        "cause: a Poisson's ratio too close to 0.5, cells that are strongly distorted or of very different "
        "sizes, or moduli or lengths beyond what numbers can hold. Try a smaller nu, a smaller "
        "`growth`, or lengths and moduli of usual size"
    )


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
    return SectionModel(section, (k0, k1, k2), _supported(section, basis))


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


def _supported(section: SectionMesh, basis: Basis) -> Mask:
    """Which amplitudes the far arc and the hub hold, shape (n_nodes, 3)."""
    body, mesh = section.body, section.mesh
    y, z = mesh.p[:, : mesh.nvertices]
    held = np.zeros((basis.N, 3), dtype=bool)
    facets = mesh.boundary_facets()
    for vertices in (
        np.hypot(y, z) > (1 - 1e-6) * body.domain.far_radius,
        body.side * z > (1 - 1e-6) * body.depth,
    ):
        held_facets = facets[np.all(vertices[mesh.facets[:, facets]], axis=0)]
        held[basis.get_dofs(held_facets).flatten()] = True
    return held
