"""How reciprocal a raw matrix is: where it is worst, and away from the joints of its contour."""

from dataclasses import dataclass

import numpy as np

from contact.grid_operator import reciprocity_defects
from geometries.arrays import Array
from geometries.contours import Contour
from geometries.grids import Grid

ON_EDGE = 1e-3  # of a strip: joints that close to its edge are on it, as in meshes


@dataclass(frozen=True)
class Reciprocity:
    """Largest |C(I, J) - C(J, I)^T| over the largest C_nn: of all pairs of strips, of those without joints.

    Displacements are read at centres, loads act on whole elements. The average over an element differs from
    its centre by the curvature of the field across it; at a joint the local directions s and n, which turn
    on an arc, suddenly do not, and it differs by more.
    """

    worst: float
    strips: tuple[int, int]  # where
    at_joints: tuple[int, ...]  # strips that contain a joint
    elsewhere: float | None  # largest defect of pairs without any of these; None if there are none


def reciprocity(ics: Array, contour: Contour, grid: Grid) -> Reciprocity:
    """Of a raw matrix (n_x, n_s, n_s, 3, 3)."""
    defects = reciprocity_defects(ics)
    first, second = np.unravel_index(np.argmax(defects), defects.shape)
    apart = np.abs(grid.strips[:, None] - np.array(contour.joints))  # (n_s, n_joints)
    holds = np.any(apart <= (0.5 + ON_EDGE) * grid.ds, axis=1)
    smooth = defects[np.ix_(~holds, ~holds)]
    return Reciprocity(
        float(np.max(defects)),
        (int(first), int(second)),
        tuple(int(strip) for strip in np.flatnonzero(holds)),
        float(np.max(smooth)) if smooth.size else None,
    )


def described(one: Reciprocity, grid: Grid) -> str:
    """For the report: how large, where, and how large elsewhere."""
    first, second = sorted(one.strips)
    where = f"{one.worst:.1e} (strips {first} and {second}, s = {grid.strips[first]:.3g}, "
    where += f"{grid.strips[second]:.3g} mm)"
    if not one.at_joints:
        return where
    elsewhere = "" if one.elsewhere is None else f"; {one.elsewhere:.1e} without these"
    return f"{where}; joints in strips {', '.join(map(str, one.at_joints))}{elsewhere}"
