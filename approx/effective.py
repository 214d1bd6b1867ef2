"""Effective elastic properties that vary with the distance from the loaded element: A' of B-hat-prime."""

from dataclasses import dataclass, replace

import numpy as np

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.materials import ElasticConstants


@dataclass(frozen=True)
class Transition:
    """Transition of a property from its value in the half-space, at the load, to `far` at `r_inf` [mm].

    f(r) = f0 + (far - f0) [(1 - rho) rho^m + rho (1 - (1 - rho)^n)], rho = min(1, r / r_inf). Source: [BVSV]
    section 4, which prints m twice where two exponents are defined.
    """

    far: float
    r_inf: float
    m: float
    n: float

    def __post_init__(self) -> None:
        if not np.isfinite(self.far):
            raise WrongInput(f"far = {self.far!r}: must be a finite number")
        for name, value in (("r_inf", self.r_inf), ("m", self.m), ("n", self.n)):
            if not 0 < value < np.inf:
                raise WrongInput(f"{name} = {value!r}: must be positive and finite")

    def at(self, r: Array, f0: float | Array) -> Array:
        """Return the property at distances r [mm], shape of r; f0 is its value in the half-space."""
        rho = np.minimum(1, r / self.r_inf)
        share = (1 - rho) * rho**self.m + rho * (1 - (1 - rho) ** self.n)
        return np.asarray(f0 + (self.far - f0) * share)


@dataclass(frozen=True)
class EffectiveProperties:
    """The transitions of G [MPa], nu and K; None stands for the constant value of the half-space.

    K of a body keeps its value where its nu varies.
    """

    G: Transition | None = None
    nu: Transition | None = None
    mismatch_k: Transition | None = None

    def __post_init__(self) -> None:
        if self.G and not self.G.far > 0:
            raise WrongInput(f"effective G at r_inf and beyond = {self.G.far!r}: must be positive [MPa]")
        if self.nu and not 0 <= self.nu.far <= 0.5:
            raise WrongInput(f"effective nu far away = {self.nu.far!r}: must lie in 0 ... 0.5")

    def at(self, r: Array, constants: ElasticConstants) -> ElasticConstants:
        """Return the constants at distances r [mm] from the load."""
        varying = {
            name: transition.at(r, getattr(constants, name))
            for name in ("G", "nu", "mismatch_k")
            if (transition := getattr(self, name)) is not None
        }
        return replace(constants, **varying)
