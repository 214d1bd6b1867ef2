"""The size of the cells of a section.

A displacement is disturbed at the ends of the loaded strips, at joints (where the curvature jumps), and where
the contour turns on a small radius. Away from a disturbance it is smooth on the scale of the distance from
it: cells in proportion to that distance, with polynomials of fourth degree on them, need few unknowns. The
corners of an outline disturb as joints do, and cells are not longer than the section is wide (a web).
"""

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from scipy.spatial import cKDTree

from femic.reference.meshing.cell_size import Cells, distance, set_cell_size, size_about_axis
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.contours import Contour
from geometries.outlines import SectionOutline, corner_turns, widths

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
    disturbances += _turns(contour, ends, growth)
    widest = float(np.max(np.ptp(strips, axis=1)))
    if size.wave < growth * widest / 2:
        disturbances.append((_between(strips, size.wave), size.wave))
    places = [(contour.position(s), h0) for s, h0 in disturbances]
    if body.outline is not None:
        places += _of_outline(contour, body.outline, ends, size.cells)
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


def _of_outline(
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


def _turns(contour: Contour, ends: Array, growth: float) -> list[tuple[Array, float]]:
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
