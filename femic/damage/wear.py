"""Wear depths and volumes of a rolling contact, along s and per rolled distance.

A particle of either surface passes all elements of its strip, each in the rolled distance dx, so a contact
wears the same depth off both surfaces where laws are the same: the sum over x of rate dx. It is the depth
that the rail loses by one passage of a wheel, and the wheel in one revolution, since each place of its
circumference passes once. The rail loses it over all of the rolled length; per metre rolled a wheel loses
depth / (2 pi R(s)). Volumes per rolled distance are the same for both. Particles of the wheel pass in
1 + xi times the distance; this is left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from femic.contact.exact.positive import require_positive
from femic.damage.laws import WearLaw
from femic.damage.sliding import Sliding
from geometries.arrays import Array
from geometries.errors import WrongInput

MM_PER_M = 1000.0


def depth(sliding: Sliding, law: WearLaw) -> Array:
    """Return the depth [mm] that strips lose per passage (rail) or revolution (wheel), shape (n_s,)."""
    return np.asarray(np.sum(law.rate(sliding), axis=0) * sliding.grid.dx)


def section_area(sliding: Sliding, law: WearLaw) -> float:
    """Return the area of its section that a rail loses per passage, a wheel per revolution [mm^2].

    It is also the worn volume per rolled distance [mm^3/mm], of rail or wheel.
    """
    return float(np.sum(depth(sliding, law)) * sliding.grid.ds)


def wheel_depth_per_metre(depths: ArrayLike, radii: ArrayLike) -> Array:
    """Return the depth [mm] that a wheel loses per metre rolled, by that per revolution [mm], of their shape.

    `radii` [mm] are those of its rolling circles, finite.
    """
    circles = np.asarray(radii, dtype=float)
    if not (np.all(circles > 0) and np.all(np.isfinite(circles))):
        raise WrongInput(
            f"radii = {radii!r}: circles of a wheel must be positive and finite; a prismatic body has no "
            "revolutions"
        )
    return np.asarray(MM_PER_M * np.asarray(depths, dtype=float) / (2 * np.pi * circles))


@dataclass(frozen=True)
class SectionLoss:
    """The British Rail function: area that a wheel's section loses per kilometre, by T-gamma as a whole.

    By Pearce and Sherratt (1991), Wear 144, 343-351, with T-gamma in N, of longitudinal and lateral creepage,
    and the wheel's diameter D in mm, the loss [mm^2/km] is `mild` T / D below the first of `transitions` [N],
    `severe` / D between both, and (`catastrophic` T - `offset`) / D from the second one on. From memory of
    secondary sources: verify the numbers. It is continuous at 100 N, and jumps at 200 N from 25 to 84 over D.

    Limits: wheels of British vehicles of the 1980s, dry, measured over fleets; the whole contact, whatever
    its area. In terms of energy its mild regime is pi/4 1e-3 mm^3/J.
    """

    mild: float = 0.25
    severe: float = 25.0
    catastrophic: float = 1.19
    offset: float = 154.0
    transitions: tuple[float, float] = (100.0, 200.0)

    def __post_init__(self) -> None:
        for name in ("mild", "severe", "catastrophic", "offset"):
            require_positive(name, getattr(self, name))
        if not 0 < self.transitions[0] < self.transitions[1]:
            raise WrongInput(
                f"transitions = {self.transitions!r}: two positive T-gamma, the smaller one first"
            )

    def per_kilometre(self, t_gamma: ArrayLike, diameter: float) -> Array:
        """Return the loss of area [mm^2/km] at T-gamma [N], shape of these; `diameter` [mm] of the wheel."""
        require_positive("diameter", diameter)
        t = np.asarray(t_gamma, dtype=float)
        if not np.all(t >= 0):
            raise WrongInput(f"t_gamma = {t_gamma!r}: must be zero or positive [N]; take the size of shares")
        beyond = self.catastrophic * t - self.offset
        by_regime = np.select(
            [t < self.transitions[0], t < self.transitions[1]], [self.mild * t, self.severe], beyond
        )
        return np.asarray(by_regime / diameter)


def regimes(sliding: Sliding, limits: tuple[float, ...]) -> Array:
    """Return the share of the work of friction below, between and beyond power densities [W/mm^2], growing.

    Shape (number of limits + 1,), sum 1; all 0 without work. It says how much of a result depends on the
    coefficient of which regime.
    """
    if list(limits) != sorted(limits) or not all(limit > 0 for limit in limits):
        raise WrongInput(f"limits = {limits!r}: positive power densities [W/mm^2], growing")
    regime = np.digitize(sliding.power_density, limits)
    work = np.bincount(regime.ravel(), sliding.work.ravel(), len(limits) + 1)
    total = float(work.sum())
    return np.asarray(work / total if total > 0 else work)
