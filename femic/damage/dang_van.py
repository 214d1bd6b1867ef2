"""Dang Van's criterion of high-cycle fatigue: the equivalent stress of a point by its history of stresses.

Grains that yield a little shake down to an elastic cycle by residual stresses of their own: the stress
deviator then cycles about the centre of the smallest sphere that encloses its path. With tau_a(t) the largest
shear stress (Tresca) of the deviator less that centre, and sigma_h(t) the hydrostatic stress, the equivalent
stress is

    tau_eq = max over t of tau_a(t) + c sigma_h(t),

and fatigue is to be expected where it exceeds the fatigue limit in shear. The sphere is one in the norm (s :
s)^1/2 of deviators. Source: Dang Van, Griveau and Message (1989), On a new multiaxial fatigue limit
criterion, in Biaxial and Multiaxial Fatigue, EGF 3, 479-496; for wheels Ekberg, Kabo and Andersson (2002), as
in `femic.damage.fatigue`.

The weight c follows from limits in torsion tau_e and bending sigma_e of one steel, c = 3 (tau_e / sigma_e -
1/2); 1/3 is common for steels of wheels and rails. Limits: no crack growth, endless life, small plastic
strains of grains only; under large hydrostatic pressure, as below contacts, the linear term forgives much,
and authors differ on how far it holds (Desimone, Bernasconi and Beretta 2006, Wear 260, 567-572, take none of
it in compression: `compression` 0).

The smallest sphere is found in any dimension by Fischer, Gärtner and Kutz (2003), Fast
smallest-enclosing-ball computation in high dimensions, Algorithms - ESA 2003: the centre walks towards the
circumcentre of the support, the points on the sphere that hold it, until another point stops it; at the
circumcentre a point that it does not need is dropped. The radius falls in each step, and the end is exact but
for rounding: the centre is then a convex combination of points at the distance of the radius.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

# --- criterion ---


@dataclass(frozen=True)
class DangVan:
    """Weights of hydrostatic stress, c of tension, and of compression the share `compression` of c."""

    hydrostatic: Annotated[
        float, Field(ge=0, allow_inf_nan=False, description="weight c of tension; default: 1/3")
    ] = 1 / 3
    compression: Annotated[float, Field(ge=0, le=1, description="weight of compression, as a share of c")] = (
        1.0
    )

    def __post_init__(self) -> None:
        if not (self.hydrostatic >= 0 and np.isfinite(self.hydrostatic)):
            raise WrongInput(f"hydrostatic = {self.hydrostatic!r}: must be zero or positive, and finite")
        if not 0 <= self.compression <= 1:
            raise WrongInput(f"compression = {self.compression!r}: a share of the weight in tension, 0 ... 1")


# --- equivalent stress ---

SYMMETRY = 1e-9  # of stresses, as a share of the largest one


def equivalent_stress(stresses: Array, criterion: DangVan) -> Array:
    """Return Dang Van's equivalent stress of points [MPa], (...), over one cycle of stresses.

    `stresses` [MPa], (n_steps, ..., 3, 3). Residual stresses that stay are part of them; only their
    hydrostatic part matters. Raises WrongInput for other shapes, values that are not finite, and tensors
    that are not symmetric.
    """
    stresses = np.asarray(stresses, dtype=float)
    if stresses.ndim < 3 or stresses.shape[-2:] != (3, 3) or len(stresses) == 0:
        raise WrongInput(
            f"stresses of shape {stresses.shape}: (n_steps, ..., 3, 3); six components become tensors by "
            "femic.damage.dang_van.tensors"
        )
    if not np.all(np.isfinite(stresses)):
        raise WrongInput("stresses with values that are not finite: leave out points outside of the bodies")
    asymmetry = np.max(np.abs(stresses - np.swapaxes(stresses, -1, -2)), initial=0.0)
    if asymmetry > SYMMETRY * np.max(np.abs(stresses), initial=0.0):
        raise WrongInput(f"stresses that are not symmetric, by {asymmetry:.3g} MPa: give symmetric tensors")
    hydrostatic = np.trace(stresses, axis1=-2, axis2=-1) / 3  # (n_steps, ...)
    shear = shear_amplitudes(stresses - hydrostatic[..., None, None] * np.eye(3))
    weight = criterion.hydrostatic * np.where(hydrostatic < 0, criterion.compression, 1.0)
    return np.asarray(np.max(shear + weight * hydrostatic, axis=0))


def shear_amplitudes(deviators: Array) -> Array:
    """Return tau_a(t) [MPa], (n_steps, ...), of deviators s [MPa], (n_steps, ..., 3, 3).

    The sphere is found in vectors of five components with the norm (s : s)^1/2.
    """
    s = deviators
    vectors = np.stack(
        [
            np.sqrt(1.5) * s[..., 0, 0],
            (s[..., 1, 1] - s[..., 2, 2]) / np.sqrt(2),
            *(np.sqrt(2) * s[..., i, j] for i, j in ((0, 1), (1, 2), (0, 2))),
        ],
        axis=-1,
    )
    paths = np.moveaxis(vectors.reshape(len(s), -1, 5), 1, 0)  # (points, n_steps, 5)
    centres = np.array([smallest_hypersphere(path)[0] for path in paths]).reshape(-1, 5)
    first, second, *shears = np.moveaxis(centres, -1, 0)
    xx = first / np.sqrt(1.5)
    ss, nn = ((sign * np.sqrt(2) * second - xx) / 2 for sign in (1, -1))
    xs, sn, xn = (shear / np.sqrt(2) for shear in shears)
    middles = tensors(np.stack([xx, ss, nn, sn, xn, xs], axis=-1)).reshape(s.shape[1:])
    principal = np.linalg.eigvalsh(s - middles)
    return np.asarray((principal[..., 2] - principal[..., 0]) / 2)


def tensors(components: Array) -> Array:
    """Return tensors (..., 3, 3) of components (..., 6) in the order xx, ss, nn, sn, xn, xs."""
    components = np.asarray(components, dtype=float)
    if components.shape[-1:] != (6,):
        raise WrongInput(f"components of shape {components.shape}: six in the last axis, xx ss nn sn xn xs")
    order = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    return np.asarray(components[..., order])


# --- smallest enclosing sphere ---

ROUNDING = 1e-12  # of lengths, as a share of the size of the set
LESS_ACCURATE = (1e-10, 1e-8, 1e-6)  # where the walk goes round: smooth paths, nearly on one sphere
MOST_STEPS = 1000  # of the walk; some tens are usual


def smallest_hypersphere(points: Array) -> tuple[Array, float]:
    """Return centre (d,) and radius of the smallest sphere that encloses points, shape (n, d).

    Raises WrongInput for no points and for values that are not finite, Failure if the walk does not end.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or len(points) == 0 or not np.all(np.isfinite(points)):
        raise WrongInput(f"points of shape {points.shape}: one or more finite points, shape (n, d)")
    origin = points.mean(axis=0)
    for accuracy in (ROUNDING, *LESS_ACCURATE):
        if (centre := _find_centre(points - origin, accuracy)) is not None:
            return centre + origin, float(np.max(np.linalg.norm(points - origin - centre, axis=1)))
    raise Failure(
        f"smallest sphere about {len(points)} points: no end after {MOST_STEPS} steps; remove points that "
        "coincide"
    )


def _find_centre(points: Array, accuracy: float) -> Array | None:
    """Return the centre to an accuracy, a share of the size of the set; None if the walk does not end."""
    tolerance = accuracy * float(np.max(np.linalg.norm(points, axis=1)))
    centre = points[0]
    support = [int(np.argmax(np.linalg.norm(points - centre, axis=1)))]
    for _ in range(MOST_STEPS):
        target, shares = _circumcentre(points[support])
        if np.linalg.norm(target - centre) <= tolerance:
            if min(shares) >= 0:
                return target
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
