"""Second-order meshes of a section, graded from the loaded strips to the far arc, nodes on the true contour.

On the contact contour a field is a quadratic spline of the arc length s: vertices and mid-side nodes lie at
known s, the latter half way.
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from skfem import MeshTri, MeshTri2

from femic.cell_size import Cells, distance, set_cell_size
from femic.edges import edge_numbers
from femic.gmsh_session import gmsh_session
from femic.outline import add_section
from geometries.bodies import Body
from geometries.errors import Failure

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TRIANGLE = 2  # Gmsh's number of the 3-node triangle
DISTANCE_SAMPLES = 200  # points per curve for distances from a strip


@dataclass(frozen=True, eq=False)
class SectionMesh:
    """A section in quadratic triangles; its contact contour in edges of growing s."""

    body: Body
    mesh: MeshTri2
    knots: Array  # (n_edges + 1,) arc length of the vertices on the contour
    contour_nodes: Indices  # (2 n_edges + 1,) nodes on the contour: vertex, mid-side, vertex, ...

    def interpolation(self, s: Array) -> csr_matrix:
        """Matrix (len(s), n_nodes) from nodal values to points of the contour."""
        edge = np.clip(np.searchsorted(self.knots, s, side="right") - 1, 0, len(self.knots) - 2)
        start, end = self.knots[edge], self.knots[edge + 1]
        t = (s - start) / (end - start)
        shapes = np.stack([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)])
        columns = self.contour_nodes[2 * edge + np.arange(3)[:, None]]
        rows = np.broadcast_to(np.arange(len(s)), shapes.shape)
        shape = (len(s), self.mesh.doflocs.shape[1])
        return csr_matrix((shapes.ravel(), (rows.ravel(), columns.ravel())), shape=shape)


def section_mesh(body: Body, cells: Cells, strips: Array) -> SectionMesh:
    """Mesh the section of a body; `strips`: (n, 2) ends of the loaded strips [mm], vertices lie there.

    Cell size h = sqrt(smallest^2 + (growth r)^2), r the distance from the nearest strip.
    """
    with gmsh_session() as gmsh:
        surface, curves = add_section(gmsh, body, half_section=False, breaks=np.unique(strips).tolist())
        gmsh.model.occ.synchronize()
        _set_cell_size(gmsh, body, cells, strips)
        gmsh.model.mesh.generate(2)
        points, triangles, on_contour = _collect(gmsh, surface, curves)
    return _curved(body, points, triangles, on_contour)


def _set_cell_size(gmsh: ModuleType, body: Body, cells: Cells, strips: Array) -> None:
    s = np.unique(np.linspace(strips[:, 0], strips[:, 1], DISTANCE_SAMPLES))
    d = distance(gmsh, np.stack([0 * s, *body.contour.position(s)]))
    set_cell_size(gmsh, body, f"sqrt({cells.smallest:.17g}^2+({cells.growth:.17g}*F{d})^2)")


def _collect(gmsh: ModuleType, surface: int, curves: list[int]) -> tuple[Array, Indices, Indices]:
    """Points (y, z), triangles and edges of the contour, points that no triangle uses left out."""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    types, _, nodes = gmsh.model.mesh.getElements(2, surface)
    if list(types) != [TRIANGLE]:
        raise Failure(f"Gmsh left cells of types {list(types)} where triangles were expected")
    used, flat = np.unique(nodes[0], return_inverse=True)
    order = np.argsort(tags)
    points = xyz.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)], 1:].T
    edges = [np.searchsorted(used, gmsh.model.mesh.getElements(1, curve)[2][0]) for curve in curves]
    return np.ascontiguousarray(points), flat.reshape(-1, 3).T, np.concatenate(edges).reshape(-1, 2).T


def _curved(body: Body, points: Array, triangles: Indices, on_contour: Indices) -> SectionMesh:
    """Second order; vertices and mid-side nodes of the contour on it, the latter at the middle of s."""
    vertices = np.unique(on_contour)
    s = np.full(points.shape[1], np.nan)
    s[vertices] = body.contour.nearest(points[:, vertices], body.s_range)
    points[:, vertices] = body.contour.position(s[vertices])
    mesh = MeshTri(points, np.ascontiguousarray(triangles))
    second = MeshTri2.from_mesh(mesh)
    edges = on_contour[:, np.argsort(s[on_contour].mean(axis=0))]
    ends = np.sort(s[edges], axis=0)
    number = edge_numbers(mesh.facets, edges)
    nodes = second.doflocs.copy()
    nodes[:, points.shape[1] + number] = body.contour.position(ends.mean(axis=0))
    left = edges[np.argmin(s[edges], axis=0), np.arange(edges.shape[1])]
    last = edges[np.argmax(s[edges[:, -1]]), -1]
    order = np.append(np.stack([left, points.shape[1] + number]).T.ravel(), last)
    return SectionMesh(body, replace(second, doflocs=nodes), np.append(ends[0], ends[1, -1]), order)
