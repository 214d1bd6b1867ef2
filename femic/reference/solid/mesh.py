"""Second-order solid meshes whose surface nodes lie on the true contact surface, and their trace on it.

On the contact surface (xi, s) is a chart (`geometries.surfaces`) in which every curved facet is a
straight triangle with its mid-side nodes half way: on it fields are quadratic splines of (xi, s).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from skfem import Basis, ElementTetP2, ElementTriP2, MeshTet, MeshTet2, MeshTri

from femic.reference.meshing.cell_size import Cells
from femic.reference.meshing.collected import edge_numbers
from femic.reference.solid.tetrahedra import Focus, Tetrahedra, fill
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.errors import Failure


@dataclass(frozen=True, eq=False)
class Trace:
    """The contact surface in its chart (xi, s): quadratic triangles and the solid's nodes on it."""

    basis: Basis
    nodes: Indices  # (n,) number of each surface node among the nodes of the solid mesh

    def smallest(self, xi_range: tuple[float, float], s_range: tuple[float, float]) -> float:
        """Size of the smallest triangle near a rectangle [mm]: the root of twice its area."""
        corners = self.basis.mesh.p[:, self.basis.mesh.t]  # (2, 3, n_triangles)
        low, high = np.array([xi_range, s_range]).T[..., None]
        near = np.all((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low), axis=0)
        return float(np.sqrt(2 * self.basis.dx.sum(axis=1)[near].min()))

    def interpolation(self, xi: Array, s: Array) -> csr_matrix:
        """Matrix (n_points, n) that takes nodal values on the surface to the points (xi, s) [mm]."""
        return self.basis.probes(np.vstack([xi, s]))


@dataclass(frozen=True, eq=False)
class SolidMesh:
    """Half (x >= 0) or quarter (x, y >= 0) of a body in quadratic tetrahedra."""

    body: Body
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


@dataclass(frozen=True, eq=False)
class Near:
    """What lies within a distance [mm] of points (3, n) [mm]."""

    points: Array
    distance: float

    def beyond(self, at: Array) -> Mask:
        """Which of some points (3, m) lie farther away, (m,)."""
        return np.asarray(cKDTree(self.points.T).query(at.T)[0] > self.distance)


def solid_mesh(
    body: Body, cells: Cells, focus: Focus, *, half_section: bool, curved_within: float = np.inf
) -> SolidMesh:
    """Mesh a body with small cells around the focus; raises Failure where the mesh is faulty.

    Cells that would fold keep straight edges farther than `curved_within` [mm] from the centres of the focus.
    """
    linear = fill(body, cells, focus, half_section=half_section)
    near = None if np.isinf(curved_within) else Near(focus.centres, curved_within)
    return curved(body, linear, half_section=half_section, near=near)


def curved(body: Body, linear: Tetrahedra, *, half_section: bool, near: Near | None = None) -> SolidMesh:
    """Second-order mesh from tetrahedra; nodes near the contact surface are moved onto it.

    Edges stay straight that would fold a cell, unless they are `near` where cells are small; by default none
    does. Raises Failure where cells fold or the mesh misses a part of the surface.
    """
    on_surface = np.unique(linear.contact_triangles)
    chart = np.full((2, linear.points.shape[1]), np.nan)
    chart[:, on_surface] = _chart_of(body, linear.points[:, on_surface])
    points = linear.points.copy()
    points[:, on_surface] = body.surface.position(*chart[:, on_surface])
    mesh = MeshTet(points, np.ascontiguousarray(linear.cells))
    surface = MeshTri(
        np.ascontiguousarray(chart[:, on_surface]), np.searchsorted(on_surface, linear.contact_triangles)
    )
    edges = on_surface[surface.facets]  # (2, n_edges)
    mid_nodes = points.shape[1] + edge_numbers(mesh.edges, edges)
    second_order = MeshTet2.from_mesh(mesh)
    nodes = second_order.doflocs.copy()
    nodes[:, mid_nodes] = body.surface.position(*chart[:, edges].mean(axis=1))
    if near is not None:
        nodes = _unfolded(second_order, nodes, mid_nodes[near.beyond(nodes[:, mid_nodes])])
    trace = Trace(Basis(surface, ElementTriP2()), np.concatenate([on_surface, mid_nodes]))
    return _checked(SolidMesh(body, replace(second_order, doflocs=nodes), trace, half_section))


def _chart_of(body: Body, points: Array) -> Array:
    """Chart coordinates (xi, s) of points near the contact surface, exact on the model's ends."""
    xi, y, z = body.surface.to_chart(points)
    for end in (0.0, body.xi_end):
        xi = np.where(np.abs(xi - end) < 1e-9 * body.xi_end, end, xi)
    return np.stack([xi, body.contour.nearest(np.stack([y, z]), body.s_range)])


def _folded(mesh: MeshTet2) -> Indices:
    """The numbers of the cells that fold."""
    basis = Basis(mesh, ElementTetP2(), intorder=2)
    jacobian = basis.mapping.detDF(basis.X, None)
    return np.flatnonzero(np.any(jacobian <= 0, axis=1) & np.any(jacobian > 0, axis=1))


def _unfolded(straight: MeshTet2, nodes: Array, free: Indices) -> Array:
    """Nodes (3, n) [mm], of which `free` mid-side nodes are back on straight edges where cells fold.

    Neighbours may fold then, and have to follow: with all edges straight no cell folds.
    """
    nodes, bent = nodes.copy(), set(free.tolist())
    while bent:
        cells = _folded(replace(straight, doflocs=nodes))
        back = bent.intersection(straight.dofs.element_dofs[:, cells].ravel().tolist())
        if not back:
            break
        nodes[:, list(back)] = straight.doflocs[:, list(back)]
        bent -= back
    return nodes


def _checked(solid: SolidMesh) -> SolidMesh:
    """The mesh; raises Failure where curved cells fold or a part of the contact surface is missing."""
    folded = len(_folded(solid.mesh))
    if folded:
        raise Failure(
            f"{folded} cells fold when their edges are curved onto the contour: make the cells smaller"
        )
    start, end = solid.body.s_range
    whole = solid.body.xi_end * (end - (0.0 if solid.half_section else start))
    covered = float(solid.trace.basis.dx.sum())
    if not abs(covered - whole) < 1e-6 * whole:
        raise Failure(
            f"the surface mesh covers {covered:g} of {whole:g} mm^2: a fault of the mesher; try other cells"
        )
    return solid
