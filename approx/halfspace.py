"""A: influence coefficients of elastic half-spaces, and A' with properties that vary with distance."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from approx.effective import EffectiveProperties
from approx.kernels import checked_lengths, over_hat, over_hat_lags, over_lags, over_rectangle
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.materials import ElasticConstants
from geometries.patches import Patch


@dataclass(frozen=True)
class Element:
    """A distribution of traction: the integrals of the kernels over it, at points and at lags of a grid."""

    at_points: Callable[[Patch, Array, Array], Array]
    at_lags: Callable[[Patch, int, int], Array]


ELEMENTS: Mapping[str, Element] = MappingProxyType(
    {
        "uniform": Element(over_rectangle, over_lags),  # over the element
        "bilinear": Element(over_hat, over_hat_lags),  # a hat of peak 1 over 2 x 2 elements
    }
)


@dataclass(frozen=True)
class HalfSpace:
    """One body or both as half-spaces: elastic constants, distribution of traction, effective properties."""

    constants: ElasticConstants
    element: str = "uniform"
    effective: EffectiveProperties | None = None

    def __post_init__(self) -> None:
        if self.element not in ELEMENTS:
            raise WrongInput(f"element = {self.element!r}: one of {', '.join(ELEMENTS)}")

    def ics(self, patch: Patch, x: ArrayLike, s: ArrayLike) -> Array:
        """A per unit pressure [mm/MPa] at observers (x, s) [mm] relative to the patch centre.

        Shape (3, 3, *broadcast(x, s).shape): displacement i due to traction j, directions x, s, n.
        Relative errors are below 1e-14 everywhere (bilinear: benchmarks/analytic.py); zeros of
        symmetry are exact.
        Raises WrongInput for points that are not finite or do not broadcast. Source: [BVSV] section 2,
        Kalker (1990).
        """
        return ics_from_integrals(self.constants, self._integrals(patch, *observers(x, s)))

    def effective_ics(self, patch: Patch, x: ArrayLike, s: ArrayLike) -> Array:
        """A' [mm/MPa], with the arguments and the shape of `ics`.

        Raises WrongInput also where no effective properties are given.
        """
        if self.effective is None:
            raise WrongInput("effective properties: B-hat-prime needs some (far, r_inf, m, n)")
        x, s = observers(x, s)
        constants = self.effective.at(np.hypot(x, s), self.constants)
        return ics_from_integrals(constants, self._integrals(patch, x, s))

    def lags(self, patch: Patch, n_x: int, n_s: int) -> Array:
        """A at the lags (2 a k, 2 b l) of a grid of such elements, shape (3, 3, n_x, n_s) [mm/MPa].

        k = 0 ... n_x - 1, l = 0 ... n_s - 1; negative lags by the parity of the components.
        """
        if not (n_x >= 1 and n_s >= 1):
            raise WrongInput(f"n_x = {n_x!r}, n_s = {n_s!r}: at least one lag each")
        checked_lengths(patch, np.array(2 * n_x * patch.a), np.array(2 * n_s * patch.b))
        return ics_from_integrals(self.constants, ELEMENTS[self.element].at_lags(patch, n_x, n_s))

    def _integrals(self, patch: Patch, x: Array, s: Array) -> Array:
        """Integrals of the kernels [mm], shape (5, *x.shape)."""
        checked_lengths(patch, x, s)
        return ELEMENTS[self.element].at_points(patch, x, s)


def ics_from_integrals(constants: ElasticConstants, integrals: Array) -> Array:
    """ICs [mm/MPa], shape (3, 3, ...), from I_xx, I_ss, I_xs, J_x, J_s [mm] (5, ...): docs/theory/ics.md."""
    scale = constants.factor / (2 * np.pi * constants.G)
    I_xx, I_ss, I_xs, J_x, J_s = integrals
    nn = scale * (1 - constants.nu) * (I_xx + I_ss)
    ics = np.empty((3, 3, *nn.shape))
    ics[0, 0] = nn + scale * constants.nu * I_xx
    ics[1, 1] = nn + scale * constants.nu * I_ss
    ics[0, 1] = ics[1, 0] = scale * constants.nu * I_xs
    ics[2, 0] = scale * constants.mismatch_k * J_x
    ics[2, 1] = scale * constants.mismatch_k * J_s
    ics[:2, 2] = -ics[2, :2]
    ics[2, 2] = nn
    return ics


def observers(x: ArrayLike, s: ArrayLike) -> tuple[Array, Array]:
    """Coordinates as arrays of one shape; raises WrongInput if they do not broadcast or are not finite."""
    try:
        x, s = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(s, dtype=float))
    except (TypeError, ValueError) as error:
        raise WrongInput(f"points x, s: must be numbers whose shapes broadcast ({error})") from error
    for name, values in (("x", x), ("s", s)):
        bad = values[~np.isfinite(values)]
        if bad.size:
            raise WrongInput(
                f"points: {name} = {bad.flat[0]} at {bad.size} of {values.size}: must be finite [mm]"
            )
    return x, s
