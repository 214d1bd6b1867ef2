"""Line loads in plane strain: half-plane (Flamant), cylindrical cavity and solid cylinder of radius 1.

ICs per unit force per length [mm^2/N] between two lines on the surface; shape (2, 2, ...), directions s, n;
displacement, traction. n points into the body of the cavity and out of the solid cylinder, as from a lower
into an upper body. Each IC is determined up to a rigid motion. The formulas fix it for the half-plane (zero
at the distance `s_0`) and for the cavity (the logarithm is zero at a chord of one radius). The support of the
solid cylinder is not specified, so that only self-balanced loads have a meaning.

In these cases B is exact: with the half-plane at the distance of the chord, 2 R sin(alpha / 2), the cavity is
B with A_sn, A_ns times (pi - |alpha|) / pi; the solid cylinder is the same with the sign of its side, plus a
uniform radial displacement. Theory: docs/theory/ics.md.
"""

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.materials import Material


def half_plane_ics(material: Material, side: int, s: ArrayLike, s_0: float) -> Array:
    """ICs of Flamant's half-plane at distance s [mm] from the load; nn and ss are zero at s_0 [mm].

    In mm^2/N, shape (2, 2, *s.shape). Raises WrongInput where s is 0 or not finite.
    """
    s = _nonzero(s, "s")
    along = (1 - material.nu) / (np.pi * material.G) * np.log(s_0 / np.abs(s))
    across = -side * np.sign(s) * (1 - 2 * material.nu) / (4 * material.G)
    return np.array([[along, across], [-across, along]])


def cavity_ics(material: Material, alpha: ArrayLike) -> Array:
    """ICs of a cylindrical cavity at the angle alpha [rad] from the load.

    In mm^2/N, shape (2, 2, *alpha.shape). Raises WrongInput where alpha is 0 or not finite.
    """
    return _circle(material, alpha, +1)


def solid_cylinder_ics(material: Material, alpha: ArrayLike) -> Array:
    """ICs of a solid cylinder at the angle alpha [rad] from the load.

    In mm^2/N, shape (2, 2, *alpha.shape). Raises WrongInput where alpha is 0 or not finite.
    """
    ics = _circle(material, alpha, -1)
    ics[1, 1] -= (1 - material.nu) / (2 * np.pi * material.G)
    return ics


def _circle(material: Material, alpha: ArrayLike, side: int) -> Array:
    """The formula of the cavity for a body of either side."""
    wrapped = _wrapped(_nonzero(alpha, "alpha"))
    cos, sin = np.cos(wrapped), np.sin(wrapped)
    F = side * (wrapped - np.pi * np.sign(wrapped)) / 2 * (2 - 4 * material.nu)
    log_term = 4 * (1 - material.nu) * np.log(2 * np.abs(np.sin(wrapped / 2)))  # (kappa + 1) ln(chord)
    along, across = F * sin - log_term * cos, F * cos + log_term * sin
    return np.array([[along, across], [-across, along]]) / (4 * np.pi * material.G)


def _wrapped(alpha: Array) -> Array:
    """Angles wrapped to -pi ... pi; those that lie there already do not change."""
    return np.where(np.abs(alpha) <= np.pi, alpha, np.remainder(alpha + np.pi, 2 * np.pi) - np.pi)


def _nonzero(distance: ArrayLike, name: str) -> Array:
    """Distances as an array; raises WrongInput where one is 0 or not finite."""
    distance = np.asarray(distance, dtype=float)
    if not np.all(np.isfinite(distance) & (distance != 0)):
        raise WrongInput(
            f"{name}: must be finite and not 0, where the displacement of a line load is infinite"
        )
    return distance
