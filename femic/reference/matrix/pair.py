"""C of a pair of bodies: the sum of their columns, less the approach of the pair.

The subtracted approach moves the bodies like the approach of a contact: along z, without rotation, with
components along the normals of the lower body. So the tractions of a contact do not depend on it. The
separate M_zz of each body would not serve: C - A at the load contains the local effect of curvature, which
makes M_zz of a convex and of a concave body large and of opposite signs. They cancel only along the same
normals.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from femic.reference.estimate import EstimatedICs, total
from femic.reference.matrix.reference import MatrixReference
from geometries.arrays import Array
from geometries.contours import Contour


def pair_column(
    references: Mapping[str, MatrixReference],
    contour: Contour,
    strip: int,
    columns: Mapping[str, EstimatedICs] | None = None,
) -> EstimatedICs:
    """Return the summed C of bodies due to unit total loads on a strip [mm/N], arrays (3, 3, n_x, n_s).

    `contour` belongs to the lower body, on which the strips of the pair lie. `columns` of the bodies need not
    be computed again.
    """
    lower = references["lower"].job.grid
    columns = columns or {name: reference.column(strip) for name, reference in references.items()}
    estimated = total(list(columns.values()))
    paired = np.sum([reference.paired_column(strip) for reference in references.values()], axis=0)
    moved = vertical(contour, lower.strips)  # (n_s, 3)
    approach = sum(reference.approach() for reference in references.values())
    rigid = approach * np.einsum("ai,j->ija", moved, moved[strip])
    return replace(estimated, ic=paired - rigid[:, :, None])


def vertical(contour: Contour, s: Array) -> Array:
    """Return the x, s, n components of a unit displacement along z at arc lengths s [mm], (n_s, 3)."""
    sin, cos = contour.normal(s)
    return np.stack([np.zeros_like(sin), -sin, cos], axis=-1)
