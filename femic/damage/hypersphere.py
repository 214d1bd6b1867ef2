"""The smallest sphere that encloses points in any dimension.

By Fischer, Gärtner and Kutz (2003), Fast smallest-enclosing-ball computation in high dimensions, Algorithms -
ESA 2003: the centre walks towards the circumcentre of the support, the points on the sphere that hold it,
until another point stops it; at the circumcentre a point that it does not need is dropped. The radius falls
in each step, and the end is exact but for rounding: the centre is then a convex combination of points at the
distance of the radius.
"""

from dataclasses import dataclass, replace

import numpy as np

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

ROUNDING = 1e-12  # of lengths, as a share of the size of the set
LESS_ACCURATE = (1e-10, 1e-8, 1e-6)  # where the walk goes round: smooth paths, nearly on one sphere
MOST_STEPS = 1000  # of the walk; some tens are usual


@dataclass(frozen=True, eq=False)
class Hypersphere:
    """A sphere: centre, shape (d,), radius, and the numbers of the points on it that determine it."""

    centre: Array
    radius: float
    support: tuple[int, ...]


def smallest_hypersphere(points: Array) -> Hypersphere:
    """Return the smallest sphere that encloses points, shape (n, d).

    Raises WrongInput for no points and for values that are not finite, Failure if the walk does not end.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or len(points) == 0 or not np.all(np.isfinite(points)):
        raise WrongInput(f"points of shape {points.shape}: one or more finite points, shape (n, d)")
    origin = points.mean(axis=0)
    for accuracy in (ROUNDING, *LESS_ACCURATE):
        if sphere := _walk(points - origin, accuracy):
            return replace(sphere, centre=sphere.centre + origin)
    raise Failure(
        f"smallest sphere about {len(points)} points: no end after {MOST_STEPS} steps; remove points that "
        "coincide"
    )


def _walk(points: Array, accuracy: float) -> Hypersphere | None:
    """Return the sphere to an accuracy, a share of the size of the set; None if the walk does not end."""
    tolerance = accuracy * float(np.max(np.linalg.norm(points, axis=1)))
    centre = points[0]
    support = [int(np.argmax(np.linalg.norm(points - centre, axis=1)))]
    for _ in range(MOST_STEPS):
        target, shares = _circumcentre(points[support])
        if np.linalg.norm(target - centre) <= tolerance:
            if min(shares) >= 0:
                radius = float(np.max(np.linalg.norm(points - target, axis=1)))
                return Hypersphere(target, radius, tuple(sorted(support)))
            support.pop(int(np.argmin(shares)))
            continue
        reach, stop = _first_stop(points, centre, target - centre, support, accuracy)
        centre = centre + reach * (target - centre)
        if stop is not None:
            support.append(stop)
    return None


def _circumcentre(support: Array) -> tuple[Array, Array]:
    """Return the circumcentre of points (m, d) in their affine hull, and the share of each in it, sum 1."""
    edges = support[1:] - support[0]
    if len(edges) == 0:
        return support[0], np.ones(1)
    # by the edges themselves: with their products, neighbours on a smooth path would be dependent to rounding
    to_centre = np.linalg.lstsq(2 * edges, np.sum(edges**2, axis=1), rcond=None)[0]
    others = np.linalg.lstsq(edges.T, to_centre, rcond=None)[0]
    return support[0] + to_centre, np.concatenate([[1 - others.sum()], others])


def _first_stop(
    points: Array, centre: Array, step: Array, support: list[int], accuracy: float
) -> tuple[float, int | None]:
    """Return the share of a step of the centre at which a point is first on the sphere, and which; 1: none.

    The sphere goes through the support. A point beside it meets the sphere when it is as far from the centre
    as the support is.
    """
    anchor = points[support[0]]
    lags = points - anchor
    falls = lags @ step  # points with a positive one come no nearer to the sphere
    slack = np.sum((anchor - centre) ** 2) - np.sum((points - centre) ** 2, axis=1)
    meets = falls < -accuracy * np.linalg.norm(step) * np.max(np.linalg.norm(lags, axis=1))
    meets[support] = False
    shares = np.full(len(points), np.inf)
    shares[meets] = np.maximum(slack[meets], 0.0) / (-2 * falls[meets])
    first = int(np.argmin(shares))
    return (float(shares[first]), first) if shares[first] < 1 else (1.0, None)
