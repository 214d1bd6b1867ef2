"""Gmsh extrudes or revolves the section of a body and fills it with graded tetrahedra.

Only x >= 0 is meshed, and only y >= 0 where the section is its own mirror image. The curves of Gmsh may
deviate a little from the true contour; `femic.reference.solid.mesh` moves the nodes onto it.
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from femic.reference.meshing.cell_size import Cells, distance, set_cell_size, size_about_axis
from femic.reference.meshing.collected import collected
from femic.reference.meshing.gmsh_session import gmsh_session
from femic.reference.meshing.outline import add_section
from geometries.arrays import Array, Indices
from geometries.bodies import Body, Domain

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
    if not body.reaches_hub and BENT_RATIO * body.domain.far_radius < body.rolling_radius < np.inf:
        return _bent(body, cells, focus, half_section)
    with gmsh_session() as gmsh:
        _add_volume(gmsh, body, half_section)
        _set_cell_size(gmsh, body, cells, focus)
        gmsh.model.mesh.generate(3)
        return _collect(gmsh, body)


def _bent(body: Body, cells: Cells, focus: Focus, half_section: bool) -> Tetrahedra:
    """The mesh of the prismatic body, bent: Gmsh does not mesh surfaces that turn by tiny angles."""
    domain = Domain(body.domain.far_radius, body.xi_end)
    straight = replace(body, domain=domain, rolling_radius=np.inf, hub_radius=None)
    straight_focus = Focus(body.surface.to_chart(focus.centres), body.surface.to_chart(focus.points))
    straight_mesh = fill(straight, cells, straight_focus, half_section=half_section)
    return replace(straight_mesh, points=body.surface.to_global(straight_mesh.points))


def _add_volume(gmsh: ModuleType, body: Body, half_section: bool) -> None:
    """Add the section to Gmsh's model, extruded or revolved."""
    occ = gmsh.model.occ
    section = [(2, add_section(gmsh, body, half_section=half_section)[0])]
    if np.isinf(body.rolling_radius):
        occ.extrude(section, body.xi_end, 0, 0)
    else:
        angle = -body.side * body.xi_end / body.rolling_radius  # towards +x
        turned = occ.revolve(section, 0, 0, body.side * body.rolling_radius, 0, 1, 0, angle)
        occ.convertToNURBS([(dim, tag) for dim, tag in turned if dim == 3])  # meshed 15 times faster
    occ.synchronize()


def _set_cell_size(gmsh: ModuleType, body: Body, cells: Cells, focus: Focus) -> None:
    """Set the size of cells by the distances from the focus, and the meshing algorithm."""
    r, d = (distance(gmsh, points) for points in (focus.centres, focus.points))
    size = f"sqrt({cells.smallest:.17g}^2+({cells.line_growth:.17g}*F{r})^2+({cells.growth:.17g}*F{d})^2)"
    set_cell_size(gmsh, [size, size_about_axis(body)] if body.rolling_radius < np.inf else [size])
    gmsh.option.setNumber("Mesh.Algorithm3D", DELAUNAY_3D)


def _collect(gmsh: ModuleType, body: Body) -> Tetrahedra:
    """The tetrahedra of Gmsh's model; raises Failure where it has other cells."""
    faces = [tag for _, tag in gmsh.model.getEntities(2) if _on_contact_surface(gmsh, tag, body)]
    return Tetrahedra(*collected(gmsh, 3, faces))


def _on_contact_surface(gmsh: ModuleType, tag: int, body: Body) -> bool:
    """Whether a boundary face lies on the contact surface, by its middle, and not on a cut or far face."""
    low, high = (np.array(bound) for bound in gmsh.model.getParametrizationBounds(2, tag))
    middle = np.array(gmsh.model.getValue(2, tag, (low + high) / 2)).reshape(3, 1)
    xi, y, z = body.surface.to_chart(middle)
    inside_length = 1e-6 < xi[0] / body.xi_end < 1 - 1e-6
    s = body.contour.nearest(np.stack([y, z]), body.s_range)
    gap = np.linalg.norm(body.contour.position(s) - [y, z])
    return bool(inside_length and gap < 1e-3 * body.domain.far_radius)
