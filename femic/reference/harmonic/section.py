"""Fourth-order meshes of a section, fine at the loaded strips, nodes on the true contour and far arc.

On each edge of the contact contour a field is a polynomial of fourth degree in the arc length s, because the
nodes of the edge lie evenly in s.

A displacement is disturbed at the ends of the loaded strips, at joints (where the curvature jumps), and where
the contour turns on a small radius. Away from a disturbance it is smooth on the scale of the distance from
it: cells in proportion to that distance, with polynomials of fourth degree on them, need few unknowns. The
corners of an outline disturb as joints do, and cells are not longer than the section is wide (a web).
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from skfem import ElementTriP4, MeshTri, MeshTri2

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
from femic.reference.symmetry import boundary_facets_on, held_by_supports
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.contours import Contour
from geometries.outlines import SectionOutline, corner_turns, widths

# --- the size of cells ---

JOINT_SHARE = 0.2  # cell at a joint over the cell that the distance from the nearest strip gives there
CELL_TURN = 0.5  # rad, largest turn of the contour within a cell
LOCAL_RADII = 2.0  # rolling radii from the load beyond which little of its field is left
CONTOUR_SAMPLES = 2001  # points of the contour where its curvature is taken
CORNER_TURN = 0.2  # rad, least turn of an outline that counts as a corner
WIDTHS = 200  # number of places per size of an outline where the width of the section is taken


@dataclass(frozen=True, eq=False)
class FitCells:
    """Smaller cells of size h0 [mm] on the strips (n, 2) [mm] where M is fitted, and slow growth around.

    At a distance of `behind` [mm] the growth of the other cells takes over.
    """

    strips: Array
    h0: float
    growth: float
    behind: float


@dataclass(frozen=True, eq=False)
class SectionSize:
    """Cells of the least of the sizes sqrt(h0^2 + (growth r)^2), r the distance from each disturbance.

    h0 is `cells.smallest` at the ends of `strips` (n, 2) [mm] and follows the disturbance elsewhere. On the
    strips themselves cells are not larger than `wave` [mm], and as small as `fit_cells` says on other ones.
    """

    cells: Cells
    strips: Array
    wave: float = np.inf
    fit_cells: FitCells | None = None

    def with_mirror_image(self) -> "SectionSize":
        """The same size for the strips and their mirror images at -s."""
        fit_cells = self.fit_cells and replace(self.fit_cells, strips=_both_sides(self.fit_cells.strips))
        return replace(self, strips=_both_sides(self.strips), fit_cells=fit_cells)


def _both_sides(strips: Array) -> Array:
    """Strips (n, 2) and their mirror images, shape (2 n, 2)."""
    return np.vstack([strips, -strips[:, ::-1]])


def set_section_size(gmsh: ModuleType, body: Body, size: SectionSize) -> None:
    """Set the size of cells as the background field of Gmsh's model."""
    contour, cells, growth, strips = body.contour, size.cells, size.cells.growth, size.strips
    ends = np.unique(strips)
    disturbances = [(ends, cells.smallest)]
    for joint in contour.joints:
        gap = max(float(np.min(np.abs(ends - joint))), cells.smallest / growth)
        disturbances.append((np.array([joint]), max(JOINT_SHARE * growth * gap, cells.smallest)))
    disturbances += _turn_sizes(contour, ends, growth)
    widest = float(np.max(np.ptp(strips, axis=1)))
    if size.wave < growth * widest / 2:
        disturbances.append((_between(strips, size.wave), size.wave))
    places = [(contour.position(s), h0) for s, h0 in disturbances]
    if body.outline is not None:
        places += _outline_sizes(contour, body.outline, ends, size.cells)
    fields = [distance(gmsh, np.stack([0 * y, y, z])) for (y, z), _ in places]
    formulas = [
        f"sqrt({h0:.17g}^2+({growth:.17g}*F{field})^2)" for field, (_, h0) in zip(fields, places, strict=True)
    ]
    if size.fit_cells:
        formulas.append(_fit_size(gmsh, contour, size.fit_cells, growth))
    if body.rolling_radius < np.inf:
        beyond_local = f"{growth:.17g}*(F{fields[0]}-{LOCAL_RADII * body.rolling_radius:.17g})"
        formulas.append(f"max({size_about_axis(body)},{beyond_local})")
    set_cell_size(gmsh, formulas)


def _fit_size(gmsh: ModuleType, contour: Contour, fit_cells: FitCells, growth: float) -> str:
    """Return the formula for the size of cells around the strips where M is fitted."""
    s = _between(fit_cells.strips, fit_cells.h0)
    field = distance(gmsh, np.stack([0 * s, *contour.position(s)]))
    slowly = f"sqrt({fit_cells.h0:.17g}^2+({fit_cells.growth:.17g}*F{field})^2)"
    return f"max({slowly},{growth:.17g}*(F{field}-{fit_cells.behind:.17g}))"


def _outline_sizes(
    contour: Contour, outline: SectionOutline, ends: Array, cells: Cells
) -> list[tuple[Array, float]]:
    """Return points (2, n) [mm] where the section is narrow, and its corners, for the cells they need.

    They are grouped by the size of the cells [mm], a power of two. `ends` are those of the strips.
    """
    boundary = outline.closed(contour)
    places, width = widths(boundary, outline.size / WIDTHS)
    corners = boundary[:, corner_turns(boundary) > CORNER_TURN]
    points = np.hstack([places, corners])
    gap = cKDTree(contour.position(ends).T).query(points.T)[0]
    by_distance = np.maximum(cells.growth * gap, cells.smallest)
    size = np.append(width, JOINT_SHARE * by_distance[len(width) :])
    octave = np.floor(np.log2(np.maximum(size, cells.smallest)))
    refined = size < by_distance
    return [(points[:, refined & (octave == power)], float(2**power)) for power in np.unique(octave[refined])]


def _turn_sizes(contour: Contour, ends: Array, growth: float) -> list[tuple[Array, float]]:
    """Return arc lengths [mm] where the contour's radius needs smaller cells than the distance of the strips.

    They are grouped by the size of the cells [mm], a power of two.
    """
    if not contour.joints:
        return []
    s = np.linspace(*contour.limits, CONTOUR_SAMPLES)
    curvature = np.abs(np.gradient(contour.inclination(s), s))
    size = CELL_TURN / np.maximum(curvature, CELL_TURN / np.ptp(s))
    strip_distance = np.min(np.abs(s[:, None] - ends), axis=1)
    octave = np.floor(np.log2(size))
    refined = size < growth * strip_distance
    return [(s[refined & (octave == power)], float(2**power)) for power in np.unique(octave[refined])]


def _between(strips: Array, spacing: float) -> Array:
    """Arc lengths on strips with spacings of at most `spacing` [mm], shape (n,)."""
    n = int(np.ceil(float(np.max(np.ptp(strips, axis=1))) / spacing)) + 1
    return np.unique(np.linspace(strips[:, 0], strips[:, 1], n))


# --- the mesh ---

FRONTAL, DELAUNAY = 6, 5  # Gmsh's numbers of its algorithms
SLIVER_SHAPE = 0.25  # cells whose `shapes` value is below this are slivers
ELEMENT_DEGREE = 4
CLOSE_ENDS = 1e-3  # ends of strips that are closer than this share of the narrowest strip count as one
INNER_NODES = slice(-3, None)  # the nodes of a cell that are not on its edges
LAGRANGE = BarycentricInterpolator(np.arange(ELEMENT_DEGREE + 1) / ELEMENT_DEGREE, np.eye(ELEMENT_DEGREE + 1))


@dataclass(repr=False)
class MeshTri4(MeshTri2):  # type: ignore[misc]
    """Triangles whose geometry is of fourth degree, as the fields on them; vertices in growing order."""

    elem: type = ElementTriP4
    sort_t: bool = True


@dataclass(frozen=True, eq=False)
class SectionMesh:
    """A section, or its half y >= 0, in quartic triangles; the edges on its contour are sorted by s."""

    body: Body
    mesh: MeshTri4
    knots: Array  # (n_edges + 1,) arc length of the vertices on the contour
    contour_nodes: Indices  # (4 n_edges + 1,) nodes on the contour in order, evenly between knots
    half_section: bool

    @property
    def supported(self) -> Mask:
        """Amplitudes that the far arc and the hub hold, shape (n_nodes, 3)."""
        y, z = self.mesh.p[:, : self.mesh.nvertices]
        return held_by_supports(self.body, self.mesh, y, z)

    def interpolation(self, s: Array) -> csr_matrix:
        """Matrix (len(s), n_nodes) that takes nodal values to the contour at arc lengths s [mm]."""
        edge = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.knots) - 2)
        start, end = self.knots[edge], self.knots[edge + 1]
        shapes = LAGRANGE((s - start) / (end - start)).T
        columns = self.contour_nodes[ELEMENT_DEGREE * edge + np.arange(ELEMENT_DEGREE + 1)[:, None]]
        rows = np.broadcast_to(np.arange(len(s)), shapes.shape)
        shape = (len(s), self.mesh.doflocs.shape[1])
        return csr_matrix((shapes.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def section_mesh(body: Body, size: SectionSize, *, half_section: bool = False) -> SectionMesh:
    """Mesh the section of a body, or only its half y >= 0 (`half_section`).

    There is a vertex at each end of a strip, or close to it (`CLOSE_ENDS`). Raises Failure where Gmsh cannot
    mesh the section.
    """
    apart = CLOSE_ENDS * float(np.min(np.diff(size.strips)))
    ends = np.abs(size.strips) if half_section else size.strips
    reserved = [*body.contour.joints, *body.s_range, *([0.0] if half_section else [])]
    breaks = _distinct(ends.ravel(), np.array(reserved), apart)
    with gmsh_session() as gmsh:
        _, curves = add_section(gmsh, body, half_section=half_section, breaks=breaks.tolist())
        gmsh.model.occ.synchronize()
        set_section_size(gmsh, body, size.with_mirror_image() if half_section else size)
        points, triangles, on_contour = _triangles(gmsh, curves)
    return _curved(body, points, triangles, on_contour, half_section)


def _distinct(s: Array, reserved: Array, apart: float) -> Array:
    """The values s in growing order, without those that nearly repeat another one or a reserved one."""
    s = np.sort(s)
    s = s[np.append(True, np.diff(s) > apart)]
    return s[np.all(np.abs(s[:, None] - reserved) > apart, axis=1)]


def _triangles(gmsh: ModuleType, curves: list[int]) -> tuple[Array, Indices, Indices]:
    """The triangulation of Gmsh's frontal algorithm, or of Delaunay's if that has fewer slivers.

    Its arrays are points (y, z) (2, n) [mm], triangles (3, m) and edges of the contour (2, n_edges). Where
    cells grow about as fast as the distance, the frontal algorithm may stop half way without an error.
    """
    frontal = _generated(gmsh, curves, FRONTAL)
    if not _slivers(frontal):
        return frontal
    return min(frontal, _generated(gmsh, curves, DELAUNAY), key=_slivers)


def _generated(gmsh: ModuleType, curves: list[int], algorithm: int) -> tuple[Array, Indices, Indices]:
    """The triangulation (see `_triangles`) that one of Gmsh's algorithms makes."""
    gmsh.option.setNumber("Mesh.Algorithm", algorithm)
    gmsh.model.mesh.clear()
    gmsh.model.mesh.generate(2)
    points, triangles, on_contour = collect_cells(gmsh, 2, curves)
    return np.ascontiguousarray(points[1:]), triangles, on_contour


def _slivers(triangulation: tuple[Array, Indices, Indices]) -> int:
    """Number of slivers among the cells."""
    points, triangles, _ = triangulation
    return int(np.sum(shapes(points[:, triangles]) < SLIVER_SHAPE))


def shapes(corners: Array) -> Array:
    """Shape values of triangles with corners (2, 3, n): 4 sqrt(3) area / sum of squared edges, shape (n,).

    The value is 1 for equal edges and 0 for a triangle without an area.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    (dy, next_dy, _), (dz, next_dz, _) = edges
    twice_area = np.abs(dy * next_dz - dz * next_dy)
    return np.asarray(2 * np.sqrt(3) * twice_area / np.sum(edges**2, axis=(0, 1)))


def _curved(
    body: Body, points: Array, triangles: Indices, on_contour: Indices, half_section: bool
) -> SectionMesh:
    """The mesh of fourth order whose nodes on the contact contour lie on the true contour, evenly in s.

    Nodes on the far arc lie on a circle, however large its cells are.
    """
    vertices = np.unique(on_contour)
    s = np.full(points.shape[1], np.nan)
    s[vertices] = body.contour.nearest(points[:, vertices], body.s_range)
    if half_section:
        s[vertices] = np.maximum(s[vertices], 0.0)
    points[:, vertices] = body.contour.position(s[vertices])
    mesh = MeshTri4.from_mesh(MeshTri(points, np.ascontiguousarray(triangles)))
    edges = edge_numbers(mesh.facets, on_contour)
    edges = edges[np.argsort(s[mesh.facets[:, edges]].mean(axis=0))]
    starts, ends = s[mesh.facets[:, edges]]  # an edge runs from its vertex of lower number
    moved = mesh.doflocs.copy()
    _bend(mesh, edges, body.contour.position(np.linspace(starts, ends, ELEMENT_DEGREE + 1)), moved)
    if body.outline is None:
        far_arc, *_ = body.on_supports(*mesh.p[:, : mesh.nvertices])
        on_arc = boundary_facets_on(mesh, far_arc)
        _bend(mesh, on_arc, _along_far_arc(mesh.p[:, mesh.facets[:, on_arc]], body.side), moved)
    nodes = _edge_nodes(mesh, edges)
    nodes = np.where(starts < ends, nodes, nodes[::-1])
    order = np.append(nodes[:-1].T.ravel(), nodes[-1, -1])
    knots = np.append(np.minimum(starts, ends), max(starts[-1], ends[-1]))
    return SectionMesh(body, replace(mesh, doflocs=moved), knots, order, half_section)


def _along_far_arc(ends: Array, side: int) -> Array:
    """Places (2, node, edge) [mm] evenly along the arcs between the `ends` (2, 2, edge) of edges."""
    (y, z), shares = ends, np.arange(ELEMENT_DEGREE + 1)[:, None] / ELEMENT_DEGREE
    start, end = np.arctan2(y, side * z)  # from the depth
    angle = start + shares * (end - start)
    radius = np.mean(np.hypot(y, z), axis=0)
    return np.stack([radius * np.sin(angle), side * radius * np.cos(angle)])


def _edge_nodes(mesh: MeshTri4, edges: Indices) -> Indices:
    """The nodes of edges in their order along each of them, (node, edge)."""
    return np.vstack([mesh.facets[:1, edges], mesh.dofs.facet_dofs[:, edges], mesh.facets[1:, edges]])


def _bend(mesh: MeshTri4, edges: Indices, places: Array, moved: Array) -> None:
    """Move the nodes of boundary edges to their `places` (2, node, edge) [mm].

    The inner nodes of their cells are moved with them, less the further away. `moved` (2, n_nodes) holds the
    coordinates of all nodes and is changed.
    """
    nodes = _edge_nodes(mesh, edges)
    bulge = places - mesh.doflocs[:, nodes]
    moved[:, nodes[1:-1]] += bulge[:, 1:-1]
    cells = mesh.f2t[0, edges]
    y, z = ElementTriP4.doflocs[INNER_NODES].T
    corners = np.stack([1 - y - z, y, z])  # barycentric coordinates
    for local, (a, b) in enumerate(((0, 1), (1, 2), (0, 2))):
        on_this_edge = mesh.t2f[local, cells] == edges
        weight = corners[a] + corners[b]
        edge_shapes = LAGRANGE(corners[b] / weight)  # (inner node, node of the edge)
        displacement = np.einsum("i,in,cne->cie", weight**2, edge_shapes, bulge[..., on_this_edge])
        moved[:, mesh.dofs.interior_dofs[:, cells[on_this_edge]]] += displacement
