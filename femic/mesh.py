"""Second-order solid meshes whose nodes lie on the true contour, and the trace on it.

On the contact surface the arc length s and x are a chart in which every curved facet is a straight
triangle with its mid-side nodes half way: fields on the surface are quadratic splines of (x, s).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from skfem import Basis, ElementTetP2, ElementTriP2, MeshTet, MeshTet2, MeshTri

from femic.tetrahedra import Cells, Tetrahedra, extrude
from geometries.bodies import PrismaticBody
from geometries.errors import Failure

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Trace:
    """The contact surface in its chart (x, s): quadratic triangles and the solid's nodes on it."""

    basis: Basis
    nodes: Indices  # (n,) the solid mesh's node of each surface node

    def interpolation(self, x: Array, s: Array) -> csr_matrix:
        """Matrix (n_points, n) that takes nodal values on the surface to the points (x, s) [mm]."""
        return self.basis.probes(np.vstack([x, s]))


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """Half (x >= 0) or quarter (x, y >= 0) of a body in quadratic tetrahedra."""

    body: PrismaticBody
    mesh: MeshTet2
    trace: Trace
    half_section: bool

    @property
    def nodes(self) -> Array:
        """Coordinates of vertices, then mid-side nodes [mm], shape (3, n_nodes)."""
        return np.asarray(self.mesh.doflocs)

    @property
    def n_vertices(self) -> int:
        """Number of vertices; they come first among the nodes."""
        return int(self.mesh.nvertices)


def solid_mesh(body: PrismaticBody, cells: Cells, focus: Array, *, half_section: bool) -> SolidMesh:
    """Mesh a body with cells refined around `focus` (3, n), the patch centre first."""
    linear = extrude(body, cells, focus, half_section=half_section)
    on_surface = np.unique(linear.contact_triangles)
    s = np.full(linear.points.shape[1], np.nan)
    s[on_surface] = body.contour.nearest(linear.points[1:, on_surface], body.s_range)
    points = linear.points.copy()
    points[1:, on_surface] = body.contour.position(s[on_surface])
    mesh = MeshTet(points, np.ascontiguousarray(linear.cells))
    edges = mesh_edges(mesh, surface_edges(linear))
    curved = MeshTet2.from_mesh(mesh)
    nodes = curved.doflocs.copy()
    nodes[1:, points.shape[1] + edges] = body.contour.position(s[mesh.edges[:, edges]].mean(axis=0))
    trace = _trace(mesh, linear, points[0], s)
    return _checked(SolidMesh(body, replace(curved, doflocs=nodes), trace, half_section))


def surface_edges(linear: Tetrahedra) -> Indices:
    """Edges of the contact triangles as vertex pairs in order, shape (2, n_edges)."""
    t = linear.contact_triangles
    pairs = np.hstack([t[[0, 1]], t[[1, 2]], t[[0, 2]]])
    return np.unique(np.sort(pairs, axis=0), axis=1)


def mesh_edges(mesh: MeshTet, pairs: Indices) -> Indices:
    """Numbers of the mesh's edges with the given vertex pairs, shape (n_edges,)."""
    n = mesh.p.shape[1]
    keys = np.sort(mesh.edges, axis=0).astype(np.int64).T @ [n, 1]
    order = np.argsort(keys)
    return order[np.searchsorted(keys, np.sort(pairs, axis=0).T @ [n, 1], sorter=order)]


def _trace(mesh: MeshTet, linear: Tetrahedra, x: Array, s: Array) -> Trace:
    vertices, triangles = np.unique(linear.contact_triangles, return_inverse=True)
    chart = MeshTri(
        np.vstack([x[vertices], s[vertices]]),
        np.ascontiguousarray(triangles.reshape(linear.contact_triangles.shape)),
    )
    mid_nodes = mesh.p.shape[1] + mesh_edges(mesh, vertices[chart.facets])
    return Trace(Basis(chart, ElementTriP2()), np.concatenate([vertices, mid_nodes]))


def _checked(solid: SolidMesh) -> SolidMesh:
    """Refuse meshes with cells turned inside out where their edges were curved."""
    basis = Basis(solid.mesh, ElementTetP2(), intorder=2)
    jacobian = basis.mapping.detDF(basis.X, None)
    folded = int(np.sum(np.any(jacobian <= 0, axis=1) & np.any(jacobian > 0, axis=1)))
    if folded:
        raise Failure(
            f"{folded} cells fold when their edges are curved onto the contour: make the cells smaller"
        )
    return solid
