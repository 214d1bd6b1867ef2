"""Indices of rolling contact fatigue from pressure, utilised friction and T-gamma.

Surface and subsurface index are those of Ekberg, Kabo and Andersson (2002), Fatigue & Fracture of Engineering
Materials & Structures 25, 899-909. In terms of load F_n and semi-axes a, b of a Hertz contact they are

    FI_surf = mu - 2 pi a b k / (3 F_n),   FI_sub = F_n / (4 pi a b) (1 + mu^2) + c_DV sigma_h,res,

with mu the utilised friction, k the yield stress in shear. With p_0 = 3 F_n / (2 pi a b) these are mu - k/p_0
and p_0/6 (1 + mu^2) + c_DV sigma_h,res, which is how they are computed here, so that contacts that are not
Hertz's have them, too: by their largest pressure.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from femic.contact.exact.positive import require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput


def surface_index(p_max: ArrayLike, utilised: ArrayLike, yield_shear: float) -> Array:
    """Return FI_surf [-] at largest pressures [MPa] and utilised friction [-], of their joint shape.

    Above 0 the surface is beyond its shakedown limit and cracks start by ratchetting. `yield_shear` k [MPa]
    is that of the hardened surface. Limits: full slip; Hertz pressure; where utilised friction is below about
    0.3, shakedown is lost below the surface first (`femic.damage.shakedown`), which this index does not see.
    """
    require_positive("yield_shear", yield_shear)
    p, mu = _pressures(p_max), _frictions(utilised)
    return np.asarray(mu - yield_shear / p)


@dataclass(frozen=True)
class Subsurface:
    """What the subsurface index needs of a material.

    `hydrostatic` c_DV [-] weighs hydrostatic stress, 1/3 by default as in `femic.damage.dang_van`; `residual`
    [MPa] is the hydrostatic residual stress, positive in tension.
    """

    hydrostatic: float = 1 / 3
    residual: float = 0.0

    def __post_init__(self) -> None:
        if not (self.hydrostatic >= 0 and np.isfinite(self.hydrostatic)):
            raise WrongInput(f"hydrostatic = {self.hydrostatic!r}: must be zero or positive, and finite")
        if not np.isfinite(self.residual):
            raise WrongInput(f"residual = {self.residual!r}: must be finite [MPa]")


def subsurface_index(p_max: ArrayLike, utilised: ArrayLike, material: Subsurface) -> Array:
    """Return FI_sub [MPa] at largest pressures [MPa] and utilised friction, of their joint shape.

    By its authors an approximation of the largest equivalent stress of Dang Van below a Hertz contact; how
    good it is has not been checked here. Fatigue is to be expected where it exceeds the fatigue limit in
    shear of the steel with its defects. Where stresses are known, `femic.damage.equivalent_stress` gives the
    equivalent stress.
    """
    p, mu = _pressures(p_max), _frictions(utilised)
    return np.asarray(p / 6 * (1 + mu**2) + material.hydrostatic * material.residual)


@dataclass(frozen=True)
class RailDamage:
    """Damage of a rail by rolling contact fatigue per passage of an axle, as a function of T-gamma.

    By Burstow (2004), Whole Life Rail Model application and development: continued development of an RCF
    damage parameter, RSSB; from memory, so verify. Damage is 0 up to `onset` [N], rises linearly to `largest`
    [1/passage] at `peak` [N], and falls linearly to 0 at `balance` [N], where wear takes off what cracks
    grow; it goes on below 0, where wear removes earlier damage. At a sum of 1 cracks are visible: 100 000
    axles at the peak.

    Limits: rail grade 220/260 in British curves, T-gamma of longitudinal and lateral creepage, counted where
    the longitudinal force on the rail points against the rolling direction; not for wheels.
    """

    onset: float = 15.0
    peak: float = 65.0
    balance: float = 175.0
    largest: float = 1e-5

    def __post_init__(self) -> None:
        for name in ("onset", "peak", "balance", "largest"):
            require_positive(name, getattr(self, name))
        if not self.onset < self.peak < self.balance:
            raise WrongInput(
                f"onset, peak, balance = {self.onset:g}, {self.peak:g}, {self.balance:g} N: must grow"
            )

    def per_passage(self, t_gamma: ArrayLike) -> Array:
        """Return the damage per passage [-] at T-gamma [N], shape of these."""
        t = np.asarray(t_gamma, dtype=float)
        if not np.all(t >= 0):
            raise WrongInput(f"t_gamma = {t_gamma!r}: must be zero or positive [N]; take the size of shares")
        rising = (t - self.onset) / (self.peak - self.onset)
        falling = (self.balance - t) / (self.balance - self.peak)
        return np.asarray(self.largest * np.where(t < self.peak, np.maximum(rising, 0.0), falling))


def _pressures(p_max: ArrayLike) -> Array:
    """Return pressures as an array; raises WrongInput unless they are positive."""
    p = np.asarray(p_max, dtype=float)
    if not (np.all(p > 0) and np.all(np.isfinite(p))):
        raise WrongInput(f"p_max = {p_max!r}: must be positive and finite [MPa]")
    return p


def _frictions(utilised: ArrayLike) -> Array:
    """Return utilised friction as an array; raises WrongInput unless it is zero or positive."""
    mu = np.asarray(utilised, dtype=float)
    if not (np.all(mu >= 0) and np.all(np.isfinite(mu))):
        raise WrongInput(f"utilised = {utilised!r}: friction must be zero or positive, and finite")
    return mu
