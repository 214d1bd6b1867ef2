"""A gap [mm] that is added to the undeformed distance: a profile over s, or known at points of the surface.

It is linear between the points, and 0 beyond them.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from geometries.arrays import Array
from geometries.errors import WrongInput

ON_A_LINE = 1e-9  # width of points over their length below which they lie on one line


@dataclass(frozen=True, eq=False)
class Profile:
    """A gap over s, the same at all x."""

    s: Array  # growing
    gap: Array

    def at(self, x: Array, s: Array) -> Array:
        """Return the gap at places (x, s) [mm], shape broadcast(x, s)."""
        return np.interp(
            np.broadcast_to(s, np.broadcast_shapes(x.shape, s.shape)), self.s, self.gap, 0.0, 0.0
        )


@dataclass(frozen=True, eq=False)
class Scattered:
    """A gap at points (x, s), which are not all on one line."""

    places: Array  # (n, 2)
    gap: Array

    def at(self, x: Array, s: Array) -> Array:
        """Return the gap at places (x, s) [mm], shape broadcast(x, s)."""
        middle = self.places.mean(axis=0)
        size = np.ptp(self.places, axis=0).max()  # triangles need lengths of about 1
        between = scipy.interpolate.LinearNDInterpolator(
            (self.places - middle) / size, self.gap, fill_value=0.0
        )
        return np.asarray(between((x - middle[0]) / size, (s - middle[1]) / size))


ExtraGap = Profile | Scattered


def extra_gap(columns: Array) -> ExtraGap:
    """Return the gap of columns s, gap or x, s, gap, shape (n, 2) or (n, 3) [mm].

    Points of one x are a profile: s and the gap alone matter. Raises WrongInput for points at the same place,
    for others on one line, and for too few.
    """
    places, gap = columns[:, :-1], columns[:, -1]
    widths = np.ptp(places, axis=0)
    if places.shape[1] == 1 or widths[0] <= ON_A_LINE * widths[1]:
        return _profile(places[:, -1:], gap)
    _require_apart(places)
    across = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    if len(places) < 3 or across[1] <= ON_A_LINE * across[0]:
        raise WrongInput(
            f"{len(places)} points on one line, not at one x: give points beside it, too, or columns s, "
            "gap of a profile that is the same at all x"
        )
    order = np.lexsort(places.T)  # triangles of points on a grid depend on their order
    return Scattered(places[order], gap[order])


def _profile(places: Array, gap: Array) -> Profile:
    """Return the profile of points at s, shape (n, 1)."""
    if len(places) < 2:
        raise WrongInput("one point: give two or more")
    _require_apart(places)
    order = np.argsort(places[:, 0])
    return Profile(places[order, 0], gap[order])


def _require_apart(places: Array) -> None:
    """Raise WrongInput for two points at the same place."""
    order = np.lexsort(places.T)
    same = np.flatnonzero(np.all(np.diff(places[order], axis=0) == 0, axis=1))
    if len(same):
        first, second = sorted(int(k) + 1 for k in order[same[0] : same[0] + 2])
        where = ", ".join(f"{place:g}" for place in places[first - 1])
        raise WrongInput(f"points {first} and {second} are at the same place ({where}): remove one")
