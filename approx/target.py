"""The target of a fit of effective properties: ICs at points, with weights and errors."""

from dataclasses import dataclass, replace

import numpy as np

from approx.effective import EffectiveProperties, Transition
from approx.pair import Pair, Solid
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Patch, places

FEWEST = 8  # least number of points
SPREAD = 1.5  # least ratio of the largest to the smallest distance


@dataclass(frozen=True, eq=False)
class Target:
    """ICs that B-hat-prime is to reproduce.

    `ics` (n_components, n) are ICs per unit pressure [mm/MPa] of `components` such as "xn" at observers
    (x, s) [mm], (n,) each, with x from the load and s from the contact centre; `error` [mm/MPa] is their
    error, of a shape that broadcasts to theirs. Deviations are multiplied by `weights` (n,). `solid` is a
    body or a pair without effective properties.

    Raises WrongInput for shapes that do not fit, values that are not finite, weights below 0, fewer than
    `FEWEST` points that count, points at one distance only, and components that are 0 at all of them.
    """

    solid: Solid | Pair
    patch: Patch
    x: Array
    s: Array
    components: tuple[str, ...]
    ics: Array
    weights: Array
    error: Array

    def __post_init__(self) -> None:
        self._check_arrays()
        self._check_distances()
        for component, values in zip(self.components, self.ics, strict=True):
            if not np.any(values[self.weights > 0]):
                raise WrongInput(f"{component}: all of its ICs are 0; choose other points or components")

    def _check_arrays(self) -> None:
        """Raise WrongInput for shapes that do not fit and values that are not finite."""
        points_shape = np.shape(self.x)
        for name, shape in {
            "s": points_shape,
            "weights": points_shape,
            "ics": (len(self.components), *points_shape),
        }.items():
            actual_shape = np.shape(getattr(self, name))
            if actual_shape != shape:
                raise WrongInput(f"{name} of shape {actual_shape}: {shape} is needed")
        try:
            np.broadcast_to(self.error, np.shape(self.ics))
        except ValueError as error:
            raise WrongInput(
                f"error of shape {np.shape(self.error)}: {np.shape(self.ics)} is needed"
            ) from error
        for name in ("x", "s", "ics", "weights", "error"):
            values = np.asarray(getattr(self, name))
            if not np.all(np.isfinite(values)):
                raise WrongInput(f"{name}: {np.sum(~np.isfinite(values))} of {values.size} not finite")

    def _check_distances(self) -> None:
        """Raise WrongInput for weights below 0, too few points, and points at one distance only."""
        counted = int(np.sum(self.weights > 0))
        if np.any(self.weights < 0) or counted < FEWEST:
            raise WrongInput(f"weights: {counted} points count; give {FEWEST} or more, no weight below 0")
        distances = np.sort(self.r[self.weights > 0])
        nearest, eighth, furthest = distances[[0, FEWEST - 1, -1]]
        if nearest == 0 or eighth < (1 + 1e-6) * nearest or furthest < SPREAD * nearest:
            raise WrongInput(
                f"points lie {nearest:g} ... {furthest:g} mm from the load, {FEWEST} of them up to "
                f"{eighth:g} mm: a property that varies with the distance needs points at different "
                f"distances above 0, the furthest {SPREAD:g} times as far as the nearest or more"
            )

    @property
    def r(self) -> Array:
        """Distances from the load [mm], shape (n,)."""
        return np.hypot(self.x, self.s - self.patch.s)

    @property
    def scales(self) -> Array:
        """Largest |IC| of each component [mm/MPa], shape (n_components, 1)."""
        return np.max(np.abs(self.ics[:, self.weights > 0]), axis=1, keepdims=True)

    @property
    def apart(self) -> Array:
        """The part of B-hat-prime [mm/MPa] that effective properties leave alone, shape of `ics`.

        It is due to the curvature of wheels along x, or 0.
        """
        solid = self.solid
        if not (isinstance(solid, Pair) and solid.curvature_apart):
            return np.zeros(np.shape(self.ics))
        return self._components(solid.curvature(self.patch, (self.x, self.s)))

    def bhat_prime(self, effective: EffectiveProperties) -> Array:
        """B-hat-prime with effective properties at the same points [mm/MPa], shape of `ics`."""
        solid = replace(self.solid, effective=effective)
        return self._components(solid.approximate("Bhat_prime", self.patch, (self.x, self.s)))

    def approximate(self, variant: str) -> Array:
        """A variant without effective properties at the same points [mm/MPa], shape of `ics`."""
        return self._components(self.solid.approximate(variant, self.patch, (self.x, self.s)))

    def _components(self, ics: Array) -> Array:
        """The components of the target, (n_components, n), among all ICs (3, 3, n)."""
        return np.asarray(ics[places(self.components)])


def octave_weights(r: Array) -> Array:
    """Return weights (n,) [-] for which evenly spaced points count alike per octave of their distances (n,).

    Their squares are proportional to 1 / r; the weight of the nearest point is 1.
    """
    return np.asarray(np.sqrt(np.min(r) / r))


def pointwise_k(target: Target) -> Array:
    """K [-] with which B-hat-prime equals the target, (n_components, n); NaN where K has no effect."""
    r_min = float(np.min(target.r[target.r > 0]))

    def with_k(value: float) -> Array:
        return target.bhat_prime(EffectiveProperties(mismatch_k=Transition(value, r_min, 1.0, 1.0)))

    at_zero, slope = with_k(0.0), with_k(1.0) - with_k(0.0)
    return (target.ics - at_zero) / np.where(slope == 0, np.nan, slope)
