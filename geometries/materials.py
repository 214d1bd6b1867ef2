"""Isotropic linear elastic materials, and the elastic constants of one body and of both combined."""

import math
from dataclasses import dataclass

from geometries.arrays import Array
from geometries.errors import WrongInput, require_numbers


@dataclass(frozen=True)
class Material:
    """Young's modulus E [MPa] and Poisson's ratio nu."""

    E: float
    nu: float

    def __post_init__(self) -> None:
        require_numbers(self)
        if not 0 < self.E < math.inf:
            raise WrongInput(f"E = {self.E!r}: Young's modulus must be positive and finite [MPa]")
        if not 0 <= self.nu <= 0.5:
            raise WrongInput(f"nu = {self.nu!r}: Poisson's ratio must lie in 0 ... 0.5")

    @property
    def G(self) -> float:
        """Shear modulus [MPa]."""
        return self.E / (2 * (1 + self.nu))

    @property
    def lame(self) -> float:
        """First Lamé parameter [MPa]; infinite at nu = 0.5."""
        if self.nu == 0.5:
            return float("inf")
        return self.E * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))


@dataclass(frozen=True)
class ElasticConstants:
    """The constants of the ICs of half-spaces, one body or both; arrays where they vary from point to point.

    The ICs are integrals times `factor` / (2 pi G), with a factor of 1 for one body and of 2 for both. The
    mismatch constant `mismatch_k`, the K of [BVSV], scales xn, nx, sn, ns.
    """

    G: float | Array
    nu: float | Array
    mismatch_k: float | Array
    factor: int


def one_body(material: Material, side: int) -> ElasticConstants:
    """Return the constants of one body; the side is +1 for the upper one, -1 for the lower one.

    Its mismatch term side (1 - 2 nu) / (4 pi G) is K / (2 pi G) with K = side (1 - 2 nu) / 2.
    """
    return ElasticConstants(material.G, material.nu, side * (1 - 2 * material.nu) / 2, 1)


def both_bodies(upper: Material, lower: Material) -> ElasticConstants:
    """Return the combined constants: 1/G and nu/G are means, K/G a quarter of the difference (1 - 2 nu)/G."""
    G = 2 / (1 / upper.G + 1 / lower.G)
    nu = G * (upper.nu / upper.G + lower.nu / lower.G) / 2
    mismatch_k = G * ((1 - 2 * upper.nu) / upper.G - (1 - 2 * lower.nu) / lower.G) / 4
    return ElasticConstants(G, nu, mismatch_k, 2)
