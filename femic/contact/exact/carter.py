"""Carter: steady tractive rolling of long cylinders of elastically similar materials, in plane strain.

The cylinders roll towards +x, across the line on which they touch, with the creepage xi = omega R / V - 1,
positive where the upper one is driven. Per rolled distance the upper surface slips over the lower one by

    slip = -xi - du/dx, u = upper - lower,

and the traction on the upper body, of size friction p_n at most, opposes that. Over the width 2 c that begins
at the leading edge x = a both stick, with c / a = sqrt(1 - F / (f P)). The traction is that of sliding less
the same of a Hertz contact of half-width c about a - c, whose displacements differ from those of sliding by a
constant slope there:

    xi = f curvature (a - c), curvature = 1/R_upper + 1/R_lower.

Source: Carter (1926), Proceedings of the Royal Society A 112, 151-157; Johnson (1985), Contact Mechanics,
section 8.3. Normal and tangential problem are apart only for equal (1 - 2 nu) / G of both bodies (K = 0).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from femic.contact.exact.hertz import LineContact
from femic.contact.exact.positive import require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput


@dataclass(frozen=True)
class TractiveRolling:
    """Cylinders that roll over each other under a load per length [N/mm], with friction and creepage [-].

    `surfaces` are those of Hertz; their curvature lies along x here. Raises WrongInput for a load or friction
    that is not positive, and for a creepage that is not finite.
    """

    surfaces: LineContact
    load: float
    friction: float
    creepage: float

    def __post_init__(self) -> None:
        require_positive("load", self.load)
        require_positive("friction", self.friction)
        if not np.isfinite(self.creepage):
            raise WrongInput(f"creepage = {self.creepage!r}: must be finite")

    @classmethod
    def at_force(cls, surfaces: LineContact, load: float, friction: float, force: float) -> Self:
        """Return the rolling that goes with a tangential force per length [N/mm] on the upper body.

        Raises WrongInput for a force of friction load or more: no or any creepage beyond goes with it.
        """
        sliding = cls(surfaces, load, friction, 0.0)
        if not abs(force) < friction * load:
            raise WrongInput(f"force = {force!r}: must be below friction * load = {friction * load:g} [N/mm]")
        creepage = sliding.largest_creepage * (1 - np.sqrt(1 - abs(force) / (friction * load)))
        return cls(surfaces, load, friction, float(np.sign(force) * creepage))

    @property
    def half_width(self) -> float:
        """Half of the width [mm] of the contact."""
        return self.surfaces.half_width(self.load)

    @property
    def largest_creepage(self) -> float:
        """Creepage from which on all of the contact slips."""
        return self.friction * self.surfaces.curvature * self.half_width

    @property
    def stick_half_width(self) -> float:
        """Half of the width [mm] that sticks; 0 where all slips."""
        return self.half_width * max(1 - abs(self.creepage) / self.largest_creepage, 0.0)

    @property
    def stick_start(self) -> float:
        """The x [mm] up to which the contact slips, from the trailing edge; it sticks from there to +a."""
        return self.half_width - 2 * self.stick_half_width

    @property
    def force(self) -> float:
        """Tangential force per length [N/mm] on the upper body."""
        sliding = 1 - (self.stick_half_width / self.half_width) ** 2
        return float(np.sign(self.creepage)) * self.friction * self.load * sliding

    def traction(self, x: ArrayLike) -> Array:
        """Traction p_x [MPa] on the upper body at x [mm], shape of x."""
        x = np.asarray(x, dtype=float)
        p_max = self.surfaces.p_max(self.load)
        a, c = self.half_width, self.stick_half_width
        inner = np.sqrt(np.maximum(c**2 - (x - a + c) ** 2, 0)) / a
        outer = np.sqrt(np.maximum(a**2 - x**2, 0)) / a
        return np.asarray(np.sign(self.creepage) * self.friction * p_max * (outer - inner))

    def slip(self, x: ArrayLike) -> Array:
        """Slip of the upper surface over the lower one per rolled distance [-] at x [mm], shape of x.

        It is 0 where the contact sticks; ahead of the contact and behind it there is no slip, and nan.
        """
        x = np.asarray(x, dtype=float)
        c, direction = self.stick_half_width, np.sign(self.creepage)
        off_centre = self.half_width - c - x  # to the trailing side of the middle of the stick zone
        grown = np.sqrt(np.maximum(off_centre**2 - c**2, 0))
        slope = self.friction * self.surfaces.curvature * grown
        beyond = max(abs(self.creepage) - self.largest_creepage, 0.0)
        slips = np.where(x < self.stick_start, slope + beyond, 0.0)
        return np.asarray(np.where(np.abs(x) <= self.half_width, -direction * slips, np.nan))
