"""Line loads in plane strain: half-plane (Flamant), cylindrical cavity and solid cylinder of radius 1.

ICs per unit force per length [mm^2/N] between two lines on the surface; shape (2, 2, ...), directions
s, n; displacement, traction. n points into the body of the cavity and out of the solid cylinder, as
from a lower into an upper body. Each holds up to a rigid motion: the half-plane and the cavity as
fixed by the formula (zero at the distance `s_0`, and zero of the logarithm at a chord of one radius), the
solid cylinder with a support that is not specified, so that only self-balanced loads have a meaning.

They are where B is exact: with the half-plane at the distance of the chord, 2 R sin(alpha / 2), cavity =
B with A_sn, A_ns times (pi - |alpha|) / pi, and the solid cylinder the same with its side, plus a
uniform radial displacement. Source: design section 3.
"""

import numpy as np
from numpy.typing import ArrayLike

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.materials import Material


def half_plane_ics(material: Material, side: int, s: ArrayLike, s_0: float) -> Array:
    """Flamant's half-plane: observer at distance s [mm] from the load, nn and ss zero at s_0 [mm]."""
    s = _apart(s, "s")
    along = (1 - material.nu) / (np.pi * material.G) * np.log(s_0 / np.abs(s))
    across = -side * np.sign(s) * (1 - 2 * material.nu) / (4 * material.G)
    return np.array([[along, across], [-across, along]])


def cavity_ics(material: Material, alpha: ArrayLike) -> Array:
    """A cylindrical cavity: observer at the angle alpha [rad] from the load."""
    return _circle(material, alpha, +1)


def solid_cylinder_ics(material: Material, alpha: ArrayLike) -> Array:
    """A solid cylinder: observer at the angle alpha [rad] from the load."""
    out = _circle(material, alpha, -1)
    out[1, 1] -= (1 - material.nu) / (2 * np.pi * material.G)
    return out


def _circle(material: Material, alpha: ArrayLike, side: int) -> Array:
    wrapped = _wrapped(_apart(alpha, "alpha"))
    cos, sin = np.cos(wrapped), np.sin(wrapped)
    F = side * (wrapped - np.pi * np.sign(wrapped)) / 2 * (2 - 4 * material.nu)
    log = 4 * (1 - material.nu) * np.log(2 * np.abs(np.sin(wrapped / 2)))  # (kappa + 1) ln(chord)
    along, across = F * sin - log * cos, F * cos + log * sin
    return np.array([[along, across], [-across, along]]) / (4 * np.pi * material.G)


def _wrapped(alpha: Array) -> Array:
    """The same angle within -pi ... pi, to the last digit where it lies there already."""
    return np.where(np.abs(alpha) <= np.pi, alpha, np.remainder(alpha + np.pi, 2 * np.pi) - np.pi)


def _apart(distance: ArrayLike, name: str) -> Array:
    distance = np.asarray(distance, dtype=float)
    if not np.all(np.isfinite(distance) & (distance != 0)):
        raise WrongInput(
            f"{name}: must be finite and not 0, where the displacement of a line load is infinite"
        )
    return distance
