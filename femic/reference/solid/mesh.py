"""Second-order solid meshes whose surface nodes lie on the true contact surface, and their trace on it.

Gmsh extrudes or revolves the section of a body and fills it with graded tetrahedra. Only x >= 0 is meshed,
and only y >= 0 where the section is its own mirror image. The curves of Gmsh may deviate a little from the
true contour; the nodes are moved onto it.

On the contact surface (xi, s) is a chart (`geometries.surfaces`) in which every curved facet is a
straight triangle with its mid-side nodes half way: on it fields are quadratic splines of (xi, s).
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from skfem import Basis, ElementTetP2, ElementTriP2, MeshTet, MeshTet2, MeshTri

from femic.reference.meshing import (
    Cells,
    add_section,
    collect_cells,
    distance,
    edge_numbers,
    gmsh_session,
    set_cell_size,
    size_about_axis,
)
from geometries.arrays import Array, Indices
from geometries.bodies import Body, Domain
from geometries.errors import Failure

# --- tetrahedra by Gmsh ---

BENT_RATIO = 20  # rolling over far radius, beyond which bending distorts the cells by at most 5 %
DELAUNAY_3D = 1  # Gmsh's number of this algorithm; HXT is no faster here, and crashes on some coarse meshes


@dataclass(frozen=True)
class Focus:
    """Where cells are small: patch centres and points where displacements are read [mm], (3, n) each."""

    centres: Array
    points: Array


@dataclass(frozen=True)
class Tetrahedra:
    """First-order tetrahedra, and their faces on the contact surface."""

    points: Array  # (3, n_points) [mm]
    cells: Indices  # (4, n_cells)
    contact_triangles: Indices  # (3, n_triangles)


def fill(body: Body, cells: Cells, focus: Focus, *, half_section: bool) -> Tetrahedra:
    """Mesh x >= 0 of a body (only y >= 0 of it for `half_section`); raises Failure where Gmsh cannot."""
    surface = body.surface
    if not body.reaches_hub and BENT_RATIO * body.domain.far_radius < body.rolling_radius < np.inf:
        # Gmsh does not mesh surfaces that turn by tiny angles: the mesh of the prismatic body is bent.
        domain = Domain(body.domain.far_radius, body.xi_end)
        straight = replace(body, domain=domain, rolling_radius=np.inf, hub_radius=None)
        straight_focus = Focus(surface.to_chart(focus.centres), surface.to_chart(focus.points))
        mesh = fill(straight, cells, straight_focus, half_section=half_section)
        return replace(mesh, points=surface.to_global(mesh.points))
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ
        section = [(2, add_section(gmsh, body, half_section=half_section)[0])]
        if np.isinf(body.rolling_radius):
            occ.extrude(section, body.xi_end, 0, 0)
        else:
            angle = -body.side * body.xi_end / body.rolling_radius  # towards +x
            turned = occ.revolve(section, 0, 0, body.side * body.rolling_radius, 0, 1, 0, angle)
            occ.convertToNURBS([(dim, tag) for dim, tag in turned if dim == 3])  # meshed 15 times faster
        occ.synchronize()
        r, d = (distance(gmsh, points) for points in (focus.centres, focus.points))
        size = f"sqrt({cells.smallest:.17g}^2+({cells.line_growth:.17g}*F{r})^2+({cells.growth:.17g}*F{d})^2)"
        set_cell_size(gmsh, [size, size_about_axis(body)] if body.rolling_radius < np.inf else [size])
        gmsh.option.setNumber("Mesh.Algorithm3D", DELAUNAY_3D)
        gmsh.model.mesh.generate(3)
        return _collect(gmsh, body)


def _collect(gmsh: ModuleType, body: Body) -> Tetrahedra:
    """The tetrahedra of Gmsh's model; raises Failure where it has other cells."""
    faces = [tag for _, tag in gmsh.model.getEntities(2) if _on_contact_surface(gmsh, tag, body)]
    return Tetrahedra(*collect_cells(gmsh, 3, faces))


def _on_contact_surface(gmsh: ModuleType, tag: int, body: Body) -> bool:
    """Whether a boundary face lies on the contact surface, by its middle, and not on a cut or far face."""
    low, high = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, tag))
    middle = np.array(gmsh.model.getValue(2, tag, (low + high) / 2)).reshape(3, 1)
    xi, y, z = body.surface.to_chart(middle)
    inside_length = 1e-6 < xi[0] / body.xi_end < 1 - 1e-6
    s = body.contour.nearest(np.stack([y, z]), body.s_range)
    gap = np.linalg.norm(body.contour.position(s) - [y, z])
    return bool(inside_length and gap < 1e-3 * body.domain.far_radius)


# --- the mesh on the true surface ---


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


def solid_mesh(
    body: Body, cells: Cells, focus: Focus, *, half_section: bool, curved_within: float = np.inf
) -> SolidMesh:
    """Mesh a body with small cells around the focus; raises Failure where the mesh is faulty.

    Cells that would fold keep straight edges farther than `curved_within` [mm] from the centres of the focus.
    """
    linear = fill(body, cells, focus, half_section=half_section)
    return curved(body, linear, focus.centres, half_section=half_section, curved_within=curved_within)


def curved(
    body: Body,
    linear: Tetrahedra,
    centres: Array | None = None,
    *,
    half_section: bool,
    curved_within: float = np.inf,
) -> SolidMesh:
    """Second-order mesh from tetrahedra; nodes near the contact surface are moved onto it.

    Edges that would fold a cell stay straight, farther than `curved_within` [mm] from some `centres`. Raises
    Failure where cells fold or the mesh misses a part of the surface.
    """
    on_surface = np.unique(linear.contact_triangles)
    xi, y, z = body.surface.to_chart(linear.points[:, on_surface])
    for end in (0.0, body.xi_end):  # exact on the model's ends
        xi = np.where(np.abs(xi - end) < 1e-9 * body.xi_end, end, xi)
    chart = np.full((2, linear.points.shape[1]), np.nan)
    chart[:, on_surface] = xi, body.contour.nearest(np.stack([y, z]), body.s_range)
    points = linear.points.copy()
    points[:, on_surface] = body.surface.position(*chart[:, on_surface])
    linear_mesh = MeshTet(points, np.ascontiguousarray(linear.cells))
    surface = MeshTri(
        np.ascontiguousarray(chart[:, on_surface]), np.searchsorted(on_surface, linear.contact_triangles)
    )
    edges = on_surface[surface.facets]  # (2, n_edges)
    mid_nodes = points.shape[1] + edge_numbers(linear_mesh.edges, edges)
    second_order = MeshTet2.from_mesh(linear_mesh)
    nodes = second_order.doflocs.copy()
    nodes[:, mid_nodes] = body.surface.position(*chart[:, edges].mean(axis=1))
    if centres is not None and np.isfinite(curved_within):
        gap = cKDTree(centres.T).query(nodes[:, mid_nodes].T)[0]
        nodes = unfold(second_order, nodes, mid_nodes[gap > curved_within])
    trace = Trace(Basis(surface, ElementTriP2()), np.concatenate([on_surface, mid_nodes]))
    mesh = replace(second_order, doflocs=nodes)
    if n := len(_folded(mesh)):
        raise Failure(f"{n} cells fold when their edges are curved onto the contour: make the cells smaller")
    start, end = body.s_range
    whole = body.xi_end * (end - (0.0 if half_section else start))
    covered = float(trace.basis.dx.sum())
    if not abs(covered - whole) < 1e-6 * whole:
        raise Failure(
            f"the surface mesh covers {covered:g} of {whole:g} mm^2. This is an error of the mesher; try "
            "different cells"
        )
    return SolidMesh(body, mesh, trace, half_section)


def _folded(mesh: MeshTet2) -> Indices:
    """The numbers of the cells that fold."""
    basis = Basis(mesh, ElementTetP2(), intorder=2)
    jacobian = basis.mapping.detDF(basis.X, None)
    return np.flatnonzero(np.any(jacobian <= 0, axis=1) & np.any(jacobian > 0, axis=1))


def unfold(straight: MeshTet2, nodes: Array, free: Indices) -> Array:
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
