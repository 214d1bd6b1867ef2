"""The stiffness of a section at any wavenumber: K(k) = K0 + k K1 + k^2 K2, assembled once.

Displacements u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart
coordinate xi = R_roll theta and the strains are cylindrical: R_roll = infinity is the prismatic body.
Polynomials of fourth degree do not lock: Poisson's ratio may come close to 1/2 (M. Vogelius, Numer.
Math. 41, 1983, 39-53).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP4

from femic.harmonic.section import SectionMesh
from geometries.bodies import Body
from geometries.errors import Failure

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

QUADRATURE = 8  # order: of the products of shape functions


@dataclass(frozen=True, eq=False)
class SectionModel:
    """A meshed and assembled section."""

    section: SectionMesh
    parts: tuple[csc_matrix, csc_matrix, csc_matrix]  # K0, K1, K2 [N/mm^2, N/mm, N], one pattern
    supported: Mask  # (n_nodes, 3) amplitudes held by the far arc and the hub

    @property
    def unknowns(self) -> int:
        """Amplitudes of the model, held ones included."""
        return int(self.supported.size)

    def free_of(self, held: Mask) -> "FreeSystem":
        """The equations that are left where amplitudes (n_nodes, 3) are held."""
        free = np.flatnonzero(~held.ravel())
        numbered = self.parts[0].copy()
        numbered.data = np.arange(1.0, len(numbered.data) + 1)
        pattern = csc_matrix(numbered[free][:, free])
        chosen = pattern.data.astype(np.int64) - 1
        k0, k1, k2 = (part.data[chosen] for part in self.parts)
        return FreeSystem(free, pattern, (k0, k1, k2))


@dataclass(frozen=True, eq=False)
class FreeSystem:
    """What is to be solved at each wavenumber: one factorisation, any loads."""

    free: Indices
    pattern: csc_matrix
    parts: tuple[Array, Array, Array]  # data of K0, K1, K2 in it

    def solved(self, k: float, forces: Array) -> tuple[Array, float]:
        """Amplitudes (unknowns, n) under forces (unknowns, n) at one wavenumber, relative residual.

        The residual is that of one combination of all forces, with random signs.
        """
        data = self.parts[0] + k * self.parts[1] + k * k * self.parts[2]
        matrix = csc_matrix((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)
        factor = splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        u, f = np.zeros_like(forces), np.ascontiguousarray(forces[self.free])
        u[self.free] = factor.solve(f)
        signs = np.random.default_rng(0).choice([-1.0, 1.0], forces.shape[1])
        return u, float(
            np.linalg.norm(matrix @ (u[self.free] @ signs) - f @ signs) / np.linalg.norm(f @ signs)
        )


def assemble(section: SectionMesh) -> SectionModel:
    """K0, K1, K2 of the section, and its supports: far arc and hub."""
    basis = Basis(section.mesh, ElementTriP4(), intorder=QUADRATURE)
    _require_unfolded(basis)
    local = _cell_matrices(section.body, basis)  # (3, cells, 45, 45)
    n = 3 * basis.N
    unknowns = (3 * basis.element_dofs.T[:, :, None].astype(np.int64) + np.arange(3)).reshape(
        len(local[0]), -1
    )
    place = (unknowns[:, None, :] * n + unknowns[:, :, None]).ravel()
    entries, at = np.unique(place, return_inverse=True)
    starts = np.searchsorted(entries, np.arange(n + 1) * n)
    k0, k1, k2 = (
        csc_matrix((np.bincount(at, part.ravel(), len(entries)), entries % n, starts), shape=(n, n))
        for part in local
    )
    return SectionModel(section, (k0, k1, k2), _supported(section, basis))


def _require_unfolded(basis: Basis) -> None:
    """Raise Failure if a curved cell overlaps itself."""
    det = basis.mapping.detDF(basis.X)
    if np.any(np.min(det, axis=1) * np.max(det, axis=1) <= 0):
        raise Failure("cells of the section are too coarse for its contour: give a smaller engine.growth")


def _cell_matrices(body: Body, basis: Basis) -> tuple[Array, Array, Array]:
    """Cell matrices of K0, K1, K2, (cells, 45, 45) each, from strains B0 + k B1 at the Gauss points."""
    constant, linear = _strains(body, basis)  # (cells, 6 q, 45)
    lame, G = body.material.lame, body.material.G
    stress = np.zeros((6, 6))
    stress[:3, :3], stress[3:, 3:] = lame + 2 * G * np.eye(3), G * np.eye(3)
    dx = basis.dx * _stretch(body, basis)

    def product(left: Array, right: Array) -> Array:
        of_cell = (len(dx), -1, left.shape[-1])
        stresses = np.einsum("ab,ebqd,eq->eaqd", stress, right, dx, optimize=True)
        return left.reshape(of_cell).swapaxes(1, 2) @ stresses.reshape(of_cell)

    mixed = product(constant, linear)
    return product(constant, constant), mixed + np.swapaxes(mixed, 1, 2), product(linear, linear)


def _stretch(body: Body, basis: Basis) -> Array:
    """Distance from the axis over R_roll, (cells, points); 1 on prismatic bodies."""
    z = np.asarray(basis.global_coordinates())[1]
    return np.asarray(1 - body.side * z / body.rolling_radius)


def _strains(body: Body, basis: Basis) -> tuple[Array, Array]:
    """Strains xx, yy, zz, yz, xz, xy of unit amplitudes U, V, W per node, (cells, 6, q, 45): 1 and k."""
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
    """Amplitudes (nodes, 3) held by the far arc and the hub."""
    body, mesh = section.body, section.mesh
    y, z = mesh.p[:, : mesh.nvertices]
    held = np.zeros((basis.N, 3), dtype=bool)
    facets = mesh.boundary_facets()
    for chosen in (
        np.hypot(y, z) > (1 - 1e-6) * body.domain.far_radius,
        body.side * z > (1 - 1e-6) * body.depth,
    ):
        on = facets[np.all(chosen[mesh.facets[:, facets]], axis=0)]
        held[basis.get_dofs(on).flatten()] = True
    return held
