"""The stiffness of a section at any wavenumber: K(k) = K0 + k K1 + k^2 K2, assembled once.

Displacements u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart
coordinate xi = R_roll theta and the strains are cylindrical: R_roll = infinity is the prismatic body.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, ElementTriP2

from femic.section import SectionMesh
from geometries.bodies import Body

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

QUADRATURE = 5  # order on curved cells


@dataclass(frozen=True, eq=False)
class SectionModel:
    """A meshed and assembled section: one factorisation per wavenumber, any load."""

    section: SectionMesh
    pattern: csc_matrix  # of the unknowns that are free
    parts: tuple[Array, Array, Array]  # data of K0, K1, K2 in it [N/mm^2, N/mm, N]
    free: NDArray[np.int64]

    @property
    def unknowns(self) -> int:
        """Amplitudes of the model, held ones included."""
        return 3 * int(self.section.mesh.doflocs.shape[1])

    def solved(self, k: float, forces: Array) -> tuple[Array, float]:
        """Amplitudes (unknowns, n) under forces (unknowns, n) at one wavenumber, relative residual."""
        data = self.parts[0] + k * self.parts[1] + k * k * self.parts[2]
        matrix = csc_matrix((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)
        factor = splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        u, f = np.zeros_like(forces), np.ascontiguousarray(forces[self.free])
        u[self.free] = factor.solve(f)
        return u, float(np.linalg.norm(matrix @ u[self.free] - f) / np.linalg.norm(f))


def assemble(section: SectionMesh) -> SectionModel:
    """K0, K1, K2 of the section, held at the far arc and at the hub."""
    basis = Basis(section.mesh, ElementTriP2(), intorder=QUADRATURE)
    local = _cell_matrices(section.body, basis)  # (3, cells, 18, 18)
    n = 3 * basis.N
    unknowns = (3 * basis.element_dofs.T[:, :, None] + np.arange(3)).reshape(len(local[0]), -1)
    rows, columns = np.broadcast_arrays(unknowns[:, :, None], unknowns[:, None, :])
    free = np.flatnonzero(~_held(section, basis).ravel())
    number = np.full(n, -1)
    number[free] = np.arange(len(free))
    kept = (number[rows] >= 0) & (number[columns] >= 0)
    place = number[columns[kept]] * len(free) + number[rows[kept]]
    entries, at = np.unique(place, return_inverse=True)
    starts = np.searchsorted(entries, np.arange(len(free) + 1) * len(free))
    k0, k1, k2 = (
        np.asarray(np.bincount(at, part[kept], minlength=len(entries)), dtype=float) for part in local
    )
    pattern = csc_matrix((k0, entries % len(free), starts), shape=(len(free), len(free)))
    return SectionModel(section, pattern, (k0, k1, k2), free)


def _cell_matrices(body: Body, basis: Basis) -> tuple[Array, Array, Array]:
    """Cell matrices of K0, K1, K2, (cells, 18, 18) each, from strains B0 + k B1 at the Gauss points."""
    constant, linear = _strains(body, basis)
    lame, G = body.material.lame, body.material.G
    normal = np.ones((3, 3)) * lame + 2 * G * np.eye(3)
    stress = np.zeros((6, 6))
    stress[:3, :3], stress[3:, 3:] = normal, G * np.eye(3)
    dx = basis.dx * _stretch(body, basis)

    def product(left: Array, right: Array) -> Array:
        return np.einsum("aceq,ab,bdeq,eq->ecd", left, stress, right, dx, optimize=True)

    mixed = product(constant, linear)
    return product(constant, constant), mixed + np.swapaxes(mixed, 1, 2), product(linear, linear)


def _stretch(body: Body, basis: Basis) -> Array:
    """Distance from the axis over R_roll, (cells, points); 1 on prismatic bodies."""
    z = np.asarray(basis.global_coordinates())[1]
    return np.asarray(1 - body.side * z / body.rolling_radius)


def _strains(body: Body, basis: Basis) -> tuple[Array, Array]:
    """Strains xx, yy, zz, yz, xz, xy of unit amplitudes U, V, W per node, (6, 18, cells, q): 1 and k."""
    stretch = _stretch(body, basis)
    bend = body.side / (body.rolling_radius * stretch)
    shape = (6, 6, 3, *stretch.shape)  # (strain, node, amplitude, cells, points)
    constant, linear = np.zeros(shape), np.zeros(shape)
    for node in range(6):
        field = basis.basis[node][0]
        phi, (dy, dz) = np.broadcast_to(np.asarray(field), stretch.shape), field.grad
        constant[0, node, 2] = -bend * phi
        constant[1, node, 1] = constant[5, node, 0] = constant[3, node, 2] = dy
        constant[2, node, 2] = constant[3, node, 1] = dz
        constant[4, node, 0] = dz + bend * phi
        linear[0, node, 0] = phi / stretch
        linear[4, node, 2] = linear[5, node, 1] = -phi / stretch
    return constant.reshape(6, 18, *stretch.shape), linear.reshape(6, 18, *stretch.shape)


def _held(section: SectionMesh, basis: Basis) -> Mask:
    """Amplitudes (nodes, 3) held by the far arc and the hub."""
    body, mesh = section.body, section.mesh
    y, z = mesh.p
    held = np.zeros((basis.N, 3), dtype=bool)
    for chosen in (
        np.hypot(y, z) > (1 - 1e-6) * body.domain.far_radius,
        body.side * z > (1 - 1e-6) * body.depth,
    ):
        facets = mesh.boundary_facets()
        on = facets[np.all(chosen[mesh.facets[:, facets]], axis=0)]
        held[basis.get_dofs(on).flatten()] = True
    return held
