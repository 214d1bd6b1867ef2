"""Where and how two bodies touch first: curvatures, the contact of Hertz, and a first guess of its size."""

import numpy as np

from femic.contact.exact.hertz import LoadedPoint, PointContact, combined_modulus
from femic.contact.loading import Loading
from femic.contact.pairs.pair_on_grid import PairOnGrid
from geometries.arrays import Array

LEAST_CURVATURE = 1e-4  # relative, of bodies with which grids are tried first [1/mm]
MOST_UNLIKE = 1e8  # ratio of these
STEP = 1e-3  # over which curvatures are taken, as a share of the contours and of the rolling radius


def hertz(bodies: PairOnGrid, loading: Loading) -> LoadedPoint:
    """Return the ellipse of Hertz of the curvatures where the bodies touch first, without an extra gap."""
    modulus = combined_modulus(bodies.pair.upper.material, bodies.pair.lower.material)
    point = PointContact(*_curvatures(bodies), modulus)
    return point.at_load(loading.load) if loading.load else point.at_approach(loading.approach or 0.0)


def distances_nearby(bodies: PairOnGrid) -> tuple[float, Array]:
    """Return a short step [mm], and the distances of the bodies so far beside the place of first contact.

    Shape (3,) [mm]: along s to both sides, and along x. Infinite where a contour ends there.
    """
    undeformed, (start, end) = bodies.undeformed, bodies.undeformed.s_range
    touching, step = undeformed.touching[0], STEP * min(end - start, undeformed.upper.rolling_radius)
    across = undeformed.distance(0.0, touching + step * np.array([-1.0, 1.0]))
    return step, np.append(across, undeformed.distance(step, touching))


def _curvatures(bodies: PairOnGrid) -> tuple[float, float]:
    """Return relative curvatures [1/mm] along x and s at first contact, at least `LEAST_CURVATURE`.

    Their ratio is within the limits of an ellipse of Hertz.
    """
    step, apart = distances_nearby(bodies)
    before, behind, ahead = np.where(np.isfinite(apart), apart, 0.0)
    of_x, of_s = (max(float(rise) / step**2, LEAST_CURVATURE) for rise in (2 * ahead, before + behind))
    least = max(of_x, of_s) / MOST_UNLIKE
    return max(of_x, least), max(of_s, least)
