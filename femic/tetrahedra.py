"""Gmsh extrudes the section of a body along x and fills it with graded tetrahedra.

Only x >= 0 is meshed, and only y >= 0 where the symmetry of section and load allows it. The curves
that Gmsh sees may deviate a little from the true contour; `femic.mesh` moves the nodes onto it.
"""

from dataclasses import dataclass
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from femic.gmsh_session import gmsh_session
from geometries.bodies import PrismaticBody
from geometries.contours import Contour
from geometries.errors import Failure

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SAMPLES_PER_CURVE = 81
HXT = 10  # Gmsh's fastest tetrahedral mesher
TETRAHEDRON = 4  # Gmsh's number of the 4-node tetrahedron


@dataclass(frozen=True)
class Cells:
    """Target cell size h = sqrt(smallest^2 + (line_growth r)^2 + (growth d)^2).

    r is the distance from the patch centre, d from the nearest line where results are read.
    """

    smallest: float
    growth: float
    line_growth: float

    def scaled(self, factor: float) -> "Cells":
        """Cells `factor` times as large everywhere."""
        return Cells(factor * self.smallest, factor * self.growth, factor * self.line_growth)


@dataclass(frozen=True)
class Tetrahedra:
    """First-order tetrahedra, with the triangles that lie on the contact surface."""

    points: Array  # (3, n_points)
    cells: Indices  # (4, n_cells)
    contact_triangles: Indices  # (3, n_triangles)


def extrude(body: PrismaticBody, cells: Cells, focus: Array, *, half_section: bool) -> Tetrahedra:
    """Mesh x >= 0 of a body (y >= 0 too for `half_section`).

    `focus` (3, n): the patch centre first, then points along the lines where results are read.
    """
    with gmsh_session() as gmsh:
        _add_volume(gmsh, body, half_section)
        _set_cell_size(gmsh, cells, focus)
        gmsh.model.mesh.generate(3)
        return _collect(gmsh, body)


def _add_volume(gmsh: ModuleType, body: PrismaticBody, half_section: bool) -> None:
    occ = gmsh.model.occ
    s_left, s_right = body.s_range
    far_pole = occ.addPoint(0, 0, body.side * body.domain.far_radius)
    centre = occ.addPoint(0, 0, 0)
    ends, curves = _add_contour(gmsh, body.contour, 0.0 if half_section else s_left, s_right)
    right = occ.addCircleArc(ends[1], centre, far_pole)
    left = occ.addLine(far_pole, ends[0]) if half_section else occ.addCircleArc(far_pole, centre, ends[0])
    section = occ.addPlaneSurface([occ.addCurveLoop([*curves, right, left])])
    occ.extrude([(2, section)], body.domain.half_length, 0, 0)
    occ.synchronize()


def _add_contour(
    gmsh: ModuleType, contour: Contour, s_start: float, s_end: float
) -> tuple[tuple[int, int], list[int]]:
    """Curves along the contour, one per smooth piece; returns the end points' and curves' tags."""
    breaks = [s_start, *(s for s in contour.joints if s_start < s < s_end), s_end]
    tags = [gmsh.model.occ.addPoint(0, *contour.position(s)) for s in breaks]
    curves = [
        _add_piece(gmsh, contour, np.linspace(breaks[k], breaks[k + 1], SAMPLES_PER_CURVE), tags[k : k + 2])
        for k in range(len(breaks) - 1)
    ]
    return (tags[0], tags[-1]), curves


def _add_piece(gmsh: ModuleType, contour: Contour, s: Array, ends: list[int]) -> int:
    occ = gmsh.model.occ
    if np.ptp(contour.inclination(s)) < 1e-12:
        return int(occ.addLine(*ends))
    inner = [occ.addPoint(0, y, z) for y, z in contour.position(s[1:-1]).T]
    return int(occ.addSpline([ends[0], *inner, ends[1]]))


def _set_cell_size(gmsh: ModuleType, cells: Cells, focus: Array) -> None:
    field = gmsh.model.mesh.field
    tags = [gmsh.model.occ.addPoint(*point) for point in focus.T]
    gmsh.model.occ.synchronize()
    to_lines = field.add("Distance")
    field.setNumbers(to_lines, "PointsList", tags)
    size = field.add("MathEval")
    r_squared = "+".join(f"({axis}-({at:.17g}))^2" for axis, at in zip("xyz", focus[:, 0], strict=True))
    field.setString(
        size,
        "F",
        f"sqrt({cells.smallest:.17g}^2+({cells.line_growth:.17g})^2*({r_squared})"
        f"+({cells.growth:.17g}*F{to_lines})^2)",
    )
    field.setAsBackgroundMesh(size)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
    gmsh.option.setNumber("Mesh.Algorithm3D", HXT)


def _collect(gmsh: ModuleType, body: PrismaticBody) -> Tetrahedra:
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    types, _, nodes = gmsh.model.mesh.getElements(3)
    if list(types) != [TETRAHEDRON]:
        raise Failure(f"Gmsh left cells of types {list(types)} where tetrahedra were expected")
    used, flat = np.unique(nodes[0], return_inverse=True)
    order = np.argsort(tags)
    points = xyz.reshape(-1, 3)[order[np.searchsorted(tags, used, sorter=order)]].T
    triangles = [
        np.searchsorted(used, gmsh.model.mesh.getElements(2, tag)[2][0])
        for _, tag in gmsh.model.getEntities(2)
        if _on_contact_surface(gmsh, tag, body)
    ]
    return Tetrahedra(points, flat.reshape(-1, 4).T, np.concatenate(triangles).reshape(-1, 3).T)


def _on_contact_surface(gmsh: ModuleType, tag: int, body: PrismaticBody) -> bool:
    """Whether the middle of a boundary face lies on the contour rather than on a cut or far face."""
    low, high = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, tag))
    x, y, z = gmsh.model.getValue(2, tag, (low + high) / 2)
    inside_length = 0 < x < body.domain.half_length
    s = body.contour.nearest(np.array([[y], [z]]), body.s_range)
    gap = np.linalg.norm(body.contour.position(s)[:, 0] - [y, z])
    return bool(inside_length and gap < 1e-3 * body.domain.far_radius)
