"""C of a pair of bodies: the sum of their columns, less the approach of the pair.

The approach that is subtracted moves the bodies as that of a contact does: along z, without a turn, and read
along the lower normals. So no traction of a contact depends on it. Each body's own M_zz would not do: those
of a convex and a concave body are large and of opposite signs, because C - A at the load has the local effect
of curvature in it, and cancel only if both are read along the same normals.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from femic.reference.estimate import EstimatedICs, total
from femic.reference.matrix.reference import MatrixReference
from geometries.arrays import Array
from geometries.contours import Contour


def pair_column(references: Mapping[str, MatrixReference], contour: Contour, strip: int) -> EstimatedICs:
    """C of bodies together due to unit total loads on a strip [mm/N], arrays (3, 3, n_x, n_s).

    `contour` is that of the lower body, on which the strips of the pair lie.
    """
    lower = references["lower"].job.grid
    estimated = total([reference.column(strip) for reference in references.values()])
    paired = np.sum([reference.paired_column(strip) for reference in references.values()], axis=0)
    moved = vertical(contour, lower.strips)  # (n_s, 3)
    approach = sum(reference.approach() for reference in references.values())
    rigid = approach * np.einsum("ai,j->ija", moved, moved[strip])
    return replace(estimated, ic=paired - rigid[:, :, None])


def vertical(contour: Contour, s: Array) -> Array:
    """Components along x, s, n of a unit displacement along z at arc lengths s [mm], shape (n_s, 3)."""
    sin, cos = contour.normal(s)
    return np.stack([np.zeros_like(sin), -sin, cos], axis=-1)
