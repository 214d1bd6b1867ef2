"""Forces and moments of the tractions of a contact, about its centre, and its centre of pressure.

All are those on the upper body, in global axes. Theory: docs/theory/contact.md.
"""

from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array
from geometries.contours import Contour
from geometries.patches import N, S, X


@dataclass(frozen=True, eq=False)
class Resultant:
    """Force [N] and moment about the contact centre (0, 0, 0) [N mm] on the upper body, shape (3,) each."""

    force: Array
    moment: Array


def resultant(tractions: Array, contour: Contour, x: Array, s: Array, area: float) -> Resultant:
    """Return the resultant of tractions (n_x, n_s, 3) [MPa] along x, s, n on elements of a lower contour.

    `x` (n_x,) and `s` (n_s,) are the centres of elements, `area` is that of an element [mm^2].
    """
    sin, cos = contour.normal(s)
    y, z = contour.position(s)
    f_x, f_y, f_z = in_global_axes(area * tractions, sin, cos)
    x = x[:, None]
    moments = y * f_z - z * f_y, z * f_x - x * f_z, x * f_y - y * f_x
    force, moment = (np.array([np.sum(part) for part in parts]) for parts in ((f_x, f_y, f_z), moments))
    return Resultant(force, moment)


def in_global_axes(tractions: Array, sin: Array, cos: Array) -> tuple[Array, Array, Array]:
    """Components along x, y, z of tractions (n_x, n_s, 3), by sine and cosine of the inclination (n_s,)."""
    p_x, p_s, p_n = (tractions[..., direction] for direction in (X, S, N))
    return p_x, p_s * cos + p_n * sin, p_n * cos - p_s * sin


def centre_of_pressure(p: Array, s: Array) -> float:
    """Return the mean arc length [mm] of pressures (n_x, n_s) [MPa] on strips at s (n_s,)."""
    return float(np.sum(p * s) / np.sum(p))
