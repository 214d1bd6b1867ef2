"""Fourth-order meshes of a section, fine at the loaded strips, nodes on the true contour and far arc.

On each edge of the contact contour a field is a polynomial of fourth degree in the arc length s, because the
nodes of the edge lie evenly in s.

A displacement is disturbed at the ends of the loaded strips, at joints (where the curvature jumps), and where
the contour turns on a small radius. Away from a disturbance it is smooth on the scale of the distance from
it: cells in proportion to that distance, with polynomials of fourth degree on them, need few unknowns. The
corners of an outline disturb as joints do, and cells are not longer than the section is wide (a web).

The stiffness of the cells at any wavenumber, K(k) = K0 + k K1 + k^2 K2, is computed once. Displacements are
u_x = U sin(k x), u_y = V cos(k x), u_z = W cos(k x); on a body of revolution x is the chart coordinate xi =
R_roll theta and the strains are cylindrical. R_roll = infinity gives the prismatic body. Polynomials of
fourth degree do not lock: Poisson's ratio may come close to 1/2 (M. Vogelius, Numer. Math. 41, 1983, 39-53).
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from skfem import Basis, ElementTriP4, MeshTri, MeshTri2

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
from geometries.errors import Failure
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
    if fit := size.fit_cells:
        s = _between(fit.strips, fit.h0)
        field = distance(gmsh, np.stack([0 * s, *contour.position(s)]))
        slowly = f"sqrt({fit.h0:.17g}^2+({fit.growth:.17g}*F{field})^2)"
        formulas.append(f"max({slowly},{growth:.17g}*(F{field}-{fit.behind:.17g}))")
    if body.rolling_radius < np.inf:
        beyond_local = f"{growth:.17g}*(F{fields[0]}-{LOCAL_RADII * body.rolling_radius:.17g})"
        formulas.append(f"max({size_about_axis(body)},{beyond_local})")
    set_cell_size(gmsh, formulas)


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
    def unknowns(self) -> int:
        """Number of amplitudes, held ones included."""
        return 3 * int(self.mesh.doflocs.shape[1])

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
    strips, fit_cells = size.strips, size.fit_cells
    apart = CLOSE_ENDS * float(np.min(np.diff(strips)))
    reserved = np.array([*body.contour.joints, *body.s_range, *([0.0] if half_section else [])])
    ends = np.sort(np.abs(strips).ravel() if half_section else strips.ravel())
    ends = ends[np.append(True, np.diff(ends) > apart)]
    breaks = ends[np.all(np.abs(ends[:, None] - reserved) > apart, axis=1)]
    if half_section:
        fit_cells = fit_cells and replace(fit_cells, strips=_both_sides(fit_cells.strips))
        size = replace(size, strips=_both_sides(strips), fit_cells=fit_cells)
    with gmsh_session() as gmsh:
        _, curves = add_section(gmsh, body, half_section=half_section, breaks=breaks.tolist())
        gmsh.model.occ.synchronize()
        set_section_size(gmsh, body, size)
        points, triangles, on_contour = _triangulate(gmsh, curves)
    return _curved(body, points, triangles, on_contour, half_section)


def _both_sides(strips: Array) -> Array:
    """Strips (n, 2) and their mirror images, shape (2 n, 2)."""
    return np.vstack([strips, -strips[:, ::-1]])


def _triangulate(gmsh: ModuleType, curves: list[int]) -> tuple[Array, Indices, Indices]:
    """The triangulation of Gmsh's frontal algorithm, or of Delaunay's if that has fewer slivers.

    Returns points (y, z) (2, n) [mm], triangles (3, m) and edges of the contour (2, n_edges). Where cells
    grow about as fast as the distance, the frontal algorithm may stop half way without an error.
    """
    found = []
    for algorithm in (FRONTAL, DELAUNAY):
        gmsh.option.setNumber("Mesh.Algorithm", algorithm)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(2)
        points, triangles, on_contour = collect_cells(gmsh, 2, curves)
        points = np.ascontiguousarray(points[1:])
        slivers = int(np.sum(shapes(points[:, triangles]) < SLIVER_SHAPE))
        found.append((slivers, (points, triangles, on_contour)))
        if not slivers:
            break
    return min(found, key=lambda one: one[0])[1]


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
        y, z = mesh.p[:, mesh.facets[:, on_arc]]
        start, end = np.arctan2(y, body.side * z)  # from the depth
        angle = start + np.arange(ELEMENT_DEGREE + 1)[:, None] / ELEMENT_DEGREE * (end - start)
        radius = np.mean(np.hypot(y, z), axis=0)
        places = np.stack([radius * np.sin(angle), body.side * radius * np.cos(angle)])
        _bend(mesh, on_arc, places, moved)
    nodes = _edge_nodes(mesh, edges)
    nodes = np.where(starts < ends, nodes, nodes[::-1])
    order = np.append(nodes[:-1].T.ravel(), nodes[-1, -1])
    knots = np.append(np.minimum(starts, ends), max(starts[-1], ends[-1]))
    return SectionMesh(body, replace(mesh, doflocs=moved), knots, order, half_section)


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


# --- stiffness ---

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

    All three are sums of the integrals over a cell of products of phi / stretch, d phi / dy and d phi / dz,
    phi a shape function; the stretch is the distance from the axis over R_roll, 1 on prismatic bodies. Raises
    Failure where cells are too coarse for the contour.
    """
    body, basis = section.body, Basis(section.mesh, ElementTriP4(), intorder=QUADRATURE_ORDER)
    det = basis.mapping.detDF(basis.X)
    if np.any(np.min(det, axis=1) * np.max(det, axis=1) <= 0):
        raise Failure("cells of the section are too coarse for its contour: give a smaller `growth`")
    z = np.asarray(basis.global_coordinates())[1]
    stretch = 1 - body.side * z / body.rolling_radius  # (cells, points)
    values = np.empty((basis.Nbfun, 3, *stretch.shape))
    for node in range(basis.Nbfun):
        field = basis.basis[node][0]
        values[node] = field / stretch, *field.grad
    cells, points = stretch.shape
    flat = np.ascontiguousarray(values.transpose(2, 0, 1, 3)).reshape(cells, -1, points)
    products = (flat * (basis.dx * stretch)[:, None]) @ flat.swapaxes(1, 2)
    products = products.reshape(cells, basis.Nbfun, 3, basis.Nbfun, 3).transpose(0, 1, 3, 2, 4)
    lame, G = body.material.lame, body.material.G
    stiffness = np.zeros((6, 6))  # stresses by strains [MPa]
    stiffness[:3, :3], stiffness[3:, 3:] = lame + 2 * G * np.eye(3), G * np.eye(3)

    def virtual_work(strains: Array, others: Array) -> Array:
        """Matrices of the stresses by some strains in other ones, shape (cells, 45, 45)."""
        factors = np.einsum("acf,ab,bdg->fgcd", strains, stiffness, others).reshape(9, 9)
        by_node = (products.reshape(-1, 9) @ factors).reshape(*products.shape[:3], 3, 3)
        return by_node.swapaxes(2, 3).reshape(len(products), 3 * basis.Nbfun, -1)

    constant, linear = _strains(body.side / body.rolling_radius)
    mixed = virtual_work(constant, linear)
    matrices = (
        virtual_work(constant, constant),
        mixed + np.swapaxes(mixed, 1, 2),
        virtual_work(linear, linear),
    )
    return SectionModel(section, basis.element_dofs.T.astype(np.int64), matrices)


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
