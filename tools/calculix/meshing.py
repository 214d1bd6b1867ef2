"""Bodies in second-order tetrahedra by Gmsh, with the faces on which loads and contacts act.

A body is meshed at x >= 0, extruded from its section and, if it is one of revolution, bent about its axle.
Nodes of its contact surface lie on the true contour, mid-side nodes half way in (xi, s), those of the far arc
on the far arc. The edges of a loaded patch are edges of the mesh.
"""

from dataclasses import dataclass
from types import ModuleType

import numpy as np

from femic.reference.meshing import add_section, collect_cells, distance, gmsh_session, set_cell_size
from geometries.arrays import Array, Indices, Mask
from geometries.bodies import Body
from geometries.errors import Failure

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # mid-side nodes of C3D10, in CalculiX's order
ON_PLANE = 1e-6  # mm
MOST_TRIES = 20  # to straighten cells that fold
AT_CROWN, AWAY = 0.4, 0.5  # largest cell: over the least radius of the contour, and over the distance from it


@dataclass(frozen=True)
class Fineness:
    """Target size of cells: sqrt(smallest^2 + (growth d)^2) [mm], d from the nearest of points (3, n)."""

    smallest: float
    growth: float
    points: Array


@dataclass(frozen=True)
class Rectangle:
    """A part of the contact surface, 0 <= xi <= length and s_start <= s <= s_end [mm]."""

    length: float
    s_start: float
    s_end: float


@dataclass(frozen=True, eq=False)
class Mesh:
    """Nodes [mm] (n, 3), cells (m, 10), faces on the contact surface (k, 6), and xi, s of all nodes there.

    `chart` (n, 2) is NaN at the other nodes.
    """

    body: Body
    nodes: Array
    cells: Indices
    surface: Indices
    chart: Array
    supported: Mask  # (n,): on far arc, hub, and the end along x
    symmetric: Mask  # (n,): in the plane x = 0

    def faces_in(self, part: Rectangle) -> Indices:
        """The faces on a rectangle of the contact surface, (k, 6)."""
        xi, s = self.chart[self.surface[:, :3]].mean(axis=1).T
        return self.surface[(xi < part.length) & (s > part.s_start) & (s < part.s_end)]

    def interpolation(self, xi: float, s: float) -> tuple[Indices, Array]:
        """Nodes (6,) and weights (6,) of a quadratic field at a point of the contact surface."""
        corners = self.chart[self.surface[:, :3]]  # (k, 3, 2)
        sides = corners[:, 1:] - corners[:, :1]
        apart = np.array([xi, s]) - corners[:, 0]
        two = np.linalg.solve(np.swapaxes(sides, 1, 2), apart[..., None])[..., 0]
        areas = np.column_stack([1 - two.sum(axis=1), two])
        best = int(np.argmax(areas.min(axis=1)))
        if areas[best].min() < -1e-6:
            raise Failure(f"the point xi = {xi:g}, s = {s:g} mm is on no face of the contact surface")
        return self.surface[best], quadratic(areas[best])


def quadratic(areas: Array) -> Array:
    """Shape functions of a triangle of 6 nodes at area coordinates (..., 3), shape (..., 6)."""
    a, b, c = np.moveaxis(areas, -1, 0)
    corners = [along * (2 * along - 1) for along in (a, b, c)]
    return np.stack([*corners, 4 * a * b, 4 * b * c, 4 * c * a], axis=-1)


def mesh(body: Body, fineness: Fineness, patch: Rectangle) -> Mesh:
    """Mesh a body in a finite domain; the edges of a patch are edges of cells. Raises Failure."""
    with gmsh_session() as gmsh:
        breaks = [patch.s_start, patch.s_end]
        section, _ = add_section(gmsh, body, half_section=False, breaks=breaks)
        start = gmsh.model.occ.extrude([(2, section)], patch.length, 0, 0)
        gmsh.model.occ.extrude(start[:1], body.xi_end - patch.length, 0, 0)
        gmsh.model.occ.synchronize()
        _set_sizes(gmsh, body, fineness)
        gmsh.model.mesh.generate(3)
        faces = [tag for _, tag in gmsh.model.getEntities(2) if _on_contour(gmsh, tag, body)]
        points, cells, triangles = collect_cells(gmsh, 3, faces)
    return second_order(body, points.T, cells.T, triangles.T)


def _set_sizes(gmsh: ModuleType, body: Body, fineness: Fineness) -> None:
    """Set the size of cells: small at the points, and not too large for the contour to curve them."""
    straight = body.surface.to_chart(fineness.points)
    near = distance(gmsh, straight)
    samples = np.linspace(*body.s_range, 400)
    sharpest = float(np.max(np.abs(body.contour.curvature(samples))))
    size = f"sqrt({fineness.smallest:.17g}^2+({fineness.growth:.17g}*F{near})^2)"
    sizes = [size] if sharpest == 0 else [size, f"{AT_CROWN / sharpest:.17g}+{AWAY:g}*sqrt(y^2+z^2)"]
    set_cell_size(gmsh, sizes)
    gmsh.option.setNumber("Mesh.Algorithm3D", 1)


def second_order(body: Body, points: Array, cells: Indices, triangles: Indices) -> Mesh:
    """Return the mesh of straight tetrahedra (m, 4), with mid-side nodes, on the true surface, and bent.

    `triangles` (k, 3) are their faces on the contact surface.
    """
    edges = np.sort(cells[:, EDGES].reshape(-1, 2), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    straight = np.vstack([points, points[unique].mean(axis=1)])
    middle = len(points) + number.reshape(-1, len(EDGES))
    chart = np.full((len(straight), 2), np.nan)
    corners = np.unique(triangles)
    chart[corners, 0] = points[corners, 0]
    chart[corners, 1] = body.contour.nearest(points[corners, 1:].T, body.s_range)
    sides = np.sort(triangles[:, EDGES[:3]].reshape(-1, 2), axis=1)
    keys = unique @ [len(points), 1]
    on_sides = np.searchsorted(keys, sides @ [len(points), 1])
    chart[len(points) + on_sides] = chart[sides].mean(axis=1)
    on_surface = np.isfinite(chart[:, 1])
    straight[on_surface, 1:] = body.contour.position(chart[on_surface, 1]).T
    far = body.domain.far_radius
    on_arc = np.hypot(*points[:, 1:].T) > (1 - ON_PLANE) * far
    both = len(points) + np.flatnonzero(_all(on_arc, unique) & ~on_surface[len(points) :])
    straight[both, 1:] *= far / np.hypot(*straight[both, 1:].T)[:, None]
    cells = np.hstack([cells, middle])
    straight = _unfolded(straight, cells, unique)
    xi = straight[:, 0]
    section = np.any(body.on_supports(*straight[:, 1:].T), axis=0)
    surface = np.hstack([triangles, len(points) + on_sides.reshape(-1, 3)])
    return Mesh(
        body,
        body.surface.to_global(straight.T).T,
        cells,
        surface,
        chart,
        section | (xi > body.xi_end - ON_PLANE),
        np.abs(xi) < ON_PLANE,
    )


def _unfolded(nodes: Array, cells: Indices, edges: Indices) -> Array:
    """Nodes (n, 3) [mm], of which those amid `edges` (k, 2) are back on straight edges where cells fold."""
    n_corners = len(nodes) - len(edges)
    for _ in range(MOST_TRIES):
        folded = cells[np.any(jacobians(nodes[cells]) <= 0, axis=1)]
        if not len(folded):
            return nodes
        back = np.unique(folded[:, 4:])
        nodes = nodes.copy()
        nodes[back] = nodes[edges[back - n_corners]].mean(axis=1)
    raise Failure(f"{len(folded)} cells fold: make them smaller")


def jacobians(of_cells: Array) -> Array:
    """Determinants (m, 14) of the map from the unit tetrahedron, at nodes and Gauss points of (m, 10, 3)."""
    corners = np.eye(4)
    middles = (corners[[i for i, _ in EDGES]] + corners[[j for _, j in EDGES]]) / 2
    inner = np.full((4, 4), 0.1381966) + np.eye(4) * 0.4472136  # Gauss points of C3D10
    slopes = []
    for at in np.vstack([corners, middles, inner]):
        by_area = np.zeros((10, 4))  # derivatives by the four volume coordinates
        by_area[range(4), range(4)] = 4 * at - 1
        for k, (i, j) in enumerate(EDGES, 4):
            by_area[k, i], by_area[k, j] = 4 * at[j], 4 * at[i]
        slopes.append(by_area[:, 1:] - by_area[:, :1])
    return np.linalg.det(np.einsum("gad,mac->mgdc", np.array(slopes), of_cells))


def _all(of_nodes: Mask, cells: Indices) -> Mask:
    return np.asarray(np.all(of_nodes[cells], axis=1))


def _on_contour(gmsh: ModuleType, face: int, body: Body) -> bool:
    """Whether a boundary face lies on the contact surface: its middle does, and is no end of the body."""
    low, high = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, face))
    xi, y, z = gmsh.model.getValue(2, face, (low + high) / 2)
    s = body.contour.nearest(np.array([[y], [z]]), body.s_range)
    gap = float(np.linalg.norm(body.contour.position(s)[:, 0] - [y, z]))
    inner = len(gmsh.model.getAdjacencies(2, face)[0]) > 1
    return not inner and ON_PLANE < xi < body.xi_end - ON_PLANE and gap < 1e-3
