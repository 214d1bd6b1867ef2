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

from dataclasses import dataclass, replace
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

    @classmethod
    def of_limits(cls, torsion: float, bending: float) -> "DangVan":
        """Return the criterion of a steel by its fatigue limits [MPa] in torsion and bending, reversed."""
        if not 0 < bending / 2 <= torsion < np.inf:
            raise WrongInput(
                f"fatigue limits {torsion!r} in torsion, {bending!r} MPa in bending: both positive, torsion "
                "half of bending or more"
            )
        return cls(3 * (torsion / bending - 0.5))


# --- equivalent stress ---

SYMMETRY = 1e-9  # of stresses, as a share of the largest one


@dataclass(frozen=True, eq=False)
class EquivalentStress:
    """Equivalent stresses of points [MPa], (...), the steps at which they occur, and their parts there.

    `shear` is tau_a [MPa], `hydrostatic` is sigma_h [MPa], each (...).
    """

    value: Array
    step: Array
    shear: Array
    hydrostatic: Array


def equivalent_stress(stresses: Array, criterion: DangVan) -> EquivalentStress:
    """Return Dang Van's equivalent stress of points over one cycle of stresses [MPa], (n_steps, ..., 3, 3).

    Residual stresses that stay are part of the stresses; of them only the hydrostatic one matters. Raises
    WrongInput for other shapes, values that are not finite, and tensors that are not symmetric.
    """
    stresses = _checked(stresses)
    hydrostatic = np.trace(stresses, axis1=-2, axis2=-1) / 3  # (n_steps, ...)
    deviators = stresses - hydrostatic[..., None, None] * np.eye(3)
    shear = shear_amplitudes(deviators)
    weight = criterion.hydrostatic * np.where(hydrostatic < 0, criterion.compression, 1.0)
    equivalent = shear + weight * hydrostatic
    step = np.argmax(equivalent, axis=0)
    value, at_shear, at_hydrostatic = (
        np.take_along_axis(part, step[None], axis=0)[0] for part in (equivalent, shear, hydrostatic)
    )
    return EquivalentStress(value, step, at_shear, at_hydrostatic)


def shear_amplitudes(deviators: Array) -> Array:
    """Return tau_a(t) [MPa], (n_steps, ...), of deviators [MPa], (n_steps, ..., 3, 3)."""
    n_steps = len(deviators)
    paths = np.moveaxis(_coordinates(deviators).reshape(n_steps, -1, 5), 1, 0)  # (points, n_steps, 5)
    centres = np.array([smallest_hypersphere(path).centre for path in paths]).reshape(-1, 5)
    cycles = deviators - _deviator(centres).reshape(deviators.shape[1:])
    principal = np.linalg.eigvalsh(cycles)
    return np.asarray((principal[..., 2] - principal[..., 0]) / 2)


def tensors(components: Array) -> Array:
    """Return tensors (..., 3, 3) of components (..., 6) in the order xx, ss, nn, sn, xn, xs."""
    components = np.asarray(components, dtype=float)
    if components.shape[-1:] != (6,):
        raise WrongInput(f"components of shape {components.shape}: six in the last axis, xx ss nn sn xn xs")
    order = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    return np.asarray(components[..., order])


def _coordinates(deviators: Array) -> Array:
    """Return deviators (..., 3, 3) as vectors (..., 5) with the same norm and inner products."""
    s = deviators
    return np.stack(
        [
            np.sqrt(1.5) * s[..., 0, 0],
            (s[..., 1, 1] - s[..., 2, 2]) / np.sqrt(2),
            *(np.sqrt(2) * s[..., i, j] for i, j in ((0, 1), (1, 2), (0, 2))),
        ],
        axis=-1,
    )


def _deviator(vectors: Array) -> Array:
    """Return the deviators (..., 3, 3) of vectors (..., 5)."""
    first, second, *shears = np.moveaxis(vectors, -1, 0)
    xx = first / np.sqrt(1.5)
    ss, nn = (-xx + sign * np.sqrt(2) * second for sign in (1, -1))
    xs, sn, xn = (shear / np.sqrt(2) for shear in shears)
    return tensors(np.stack([xx, ss / 2, nn / 2, sn, xn, xs], axis=-1))


def _checked(stresses: Array) -> Array:
    """Return stresses as an array; raises WrongInput for wrong ones."""
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
    return stresses


# --- smallest enclosing sphere ---

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
