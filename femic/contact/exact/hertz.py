"""Hertz: frictionless contact of half-spaces with quadratic gaps, at a point or along a line.

The undeformed gap is curvature_x x^2 / 2 + curvature_s s^2 / 2. Displacements under the pressures of an
ellipse are elliptic integrals; Carlson's symmetric ones hold for circles, too. Source: Johnson (1985),
Contact Mechanics, chapters 3 and 4.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.materials import Material

MOST_SLENDER = 1e8  # largest ratio of the semi-axes that is sought


def combined_modulus(upper: Material, lower: Material) -> float:
    """E* [MPa]: 1/E* = (1 - nu^2)/E of the upper body + the same of the lower one."""
    return 1 / sum((1 - material.nu**2) / material.E for material in (upper, lower))


@dataclass(frozen=True)
class PointContact:
    """Two surfaces of relative curvatures [1/mm] along x and s, with the combined modulus E* [MPa]."""

    curvature_x: float
    curvature_s: float
    modulus: float

    def __post_init__(self) -> None:
        for name in ("curvature_x", "curvature_s", "modulus"):
            require_positive(name, getattr(self, name))

    def at_load(self, load: float) -> "LoadedPoint":
        """Return the contact under a load [N]."""
        require_positive("load", load)
        slender, integral = self.slenderness, elliprd(0, self.slenderness**2, 1)
        a = (load * integral / (np.pi * self.modulus * self.curvature_x)) ** (1 / 3)
        return LoadedPoint(self, load, float(a), float(slender * a))

    def at_approach(self, approach: float) -> "LoadedPoint":
        """Return the contact at an approach [mm]: it grows as load^(2/3)."""
        require_positive("approach", approach)
        return self.at_load((approach / self.at_load(1.0).approach) ** 1.5)

    @cached_property
    def slenderness(self) -> float:
        """The ratio b / a of the semi-axes along s and x."""

        def excess(log_ratio: float) -> float:
            squared = np.exp(2 * log_ratio)
            ratio = elliprd(0, squared, 1) / elliprd(0, 1, squared)
            return float(np.log(ratio * self.curvature_s / self.curvature_x))

        bound = np.log(MOST_SLENDER)
        return float(np.exp(brentq(excess, -bound, bound, xtol=1e-15, rtol=1e-14)))


@dataclass(frozen=True)
class LoadedPoint:
    """The contact of an ellipse: load [N], semi-axes a along x and b along s [mm]."""

    surfaces: PointContact
    load: float
    a: float
    b: float

    @property
    def p_max(self) -> float:
        """Largest pressure [MPa], in the centre."""
        return 3 * self.load / (2 * np.pi * self.a * self.b)

    @property
    def approach(self) -> float:
        """How much nearer distant points of the two bodies come [mm]."""
        integral = float(elliprf(0, self.a**2, self.b**2))
        return 3 * self.load / (2 * np.pi * self.surfaces.modulus) * integral

    @property
    def stiffness(self) -> float:
        """Derivative of the load by the approach [N/mm]."""
        return 1.5 * self.load / self.approach

    @property
    def energy(self) -> float:
        """Elastic energy [N mm]: the integral of the load over the approach."""
        return 0.4 * self.load * self.approach

    def pressure(self, x: ArrayLike, s: ArrayLike) -> Array:
        """Pressure [MPa] at (x, s) [mm], shape broadcast(x, s)."""
        inside = 1 - (np.asarray(x) / self.a) ** 2 - (np.asarray(s) / self.b) ** 2
        return np.asarray(self.p_max * np.sqrt(np.maximum(inside, 0)))


@dataclass(frozen=True)
class LineContact:
    """Two surfaces of relative curvature [1/mm] along s, endless along x, with the modulus E* [MPa]."""

    curvature: float
    modulus: float

    def __post_init__(self) -> None:
        require_positive("curvature", self.curvature)
        require_positive("modulus", self.modulus)

    def half_width(self, load: float) -> float:
        """Return half of the width [mm] of the contact under a load per length [N/mm]."""
        require_positive("load", load)
        return float(np.sqrt(4 * load / (np.pi * self.modulus * self.curvature)))

    def p_max(self, load: float) -> float:
        """Return largest pressure [MPa] under a load per length [N/mm]."""
        return 2 * load / (np.pi * self.half_width(load))

    def pressure(self, load: float, s: ArrayLike) -> Array:
        """Pressure [MPa] at s [mm], shape of s."""
        inside = 1 - (np.asarray(s) / self.half_width(load)) ** 2
        return np.asarray(self.p_max(load) * np.sqrt(np.maximum(inside, 0)))

    def gap(self, load: float, s: ArrayLike) -> Array:
        """Gap [mm] of the deformed surfaces at s [mm], shape of s: 0 in contact."""
        half_width = self.half_width(load)
        ratio = np.maximum(np.abs(s) / half_width, 1)
        grown = ratio * np.sqrt(ratio**2 - 1) - np.arccosh(ratio)
        return np.asarray(self.curvature * half_width**2 / 2 * grown)


def require_positive(name: str, value: float) -> None:
    """Raise WrongInput for what is not a positive number."""
    if not 0 < value < np.inf:
        raise WrongInput(f"{name} = {value!r}: must be positive and finite")
