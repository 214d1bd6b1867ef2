"""The defect of reciprocity of a raw matrix: the largest one, and the largest away from joints."""

from dataclasses import dataclass

import numpy as np

from femic.contact.operators.dense import Asymmetry, reciprocity_defects
from geometries.arrays import Array
from geometries.contours import Contour
from geometries.grids import Grid

ON_EDGE = 1e-3  # share of a strip: joints closer than that to its edge are on the edge, as in meshes


@dataclass(frozen=True)
class Reciprocity:
    """Largest |C(I, J) - C(J, I)^T|: of all pairs of strips, of those without joints.

    Each is a share of the largest value of its component; `component` is the worst one.

    Displacements are read at centres, loads act on whole elements. The average over an element differs from
    the value at its centre by the curvature of the field across it. At a joint it differs by more: the local
    directions s and n rotate along the arc and are constant along the flank.
    """

    worst: float  # of all pairs of strips
    component: str
    strips: tuple[int, int]  # the pair that has it
    at_joints: tuple[int, ...]  # strips that contain a joint
    elsewhere: float | None  # largest defect of pairs of strips without joints; None if there are none


def reciprocity(ics: Array, contour: Contour, grid: Grid) -> Reciprocity:
    """Return the reciprocity of a raw matrix (n_x, n_s, n_s, 3, 3)."""
    defects = np.max(reciprocity_defects(ics), axis=(2, 3))  # (n_s, n_s)
    first, second = np.unravel_index(np.argmax(defects), defects.shape)
    distances = np.abs(grid.strips[:, None] - np.array(contour.joints))  # (n_s, n_joints)
    has_joint = np.any(distances <= (0.5 + ON_EDGE) * grid.ds, axis=1)
    defects_without_joints = defects[np.ix_(~has_joint, ~has_joint)]
    return Reciprocity(
        float(np.max(defects)),
        Asymmetry.of(ics).component,
        (int(first), int(second)),
        tuple(int(strip) for strip in np.flatnonzero(has_joint)),
        float(np.max(defects_without_joints)) if defects_without_joints.size else None,
    )
