"""A pin in a hole of a large plate in plane strain, frictionless, both of elastically similar materials.

The radii of pin and hole differ by a clearance that is small against them, while the contact may cover a
large angle. With theta the angle between load and observer, the line loads of `approx.cylinder` give the
difference of the radial displacements

    -1 / pi [2 cos(theta) ln(2 |sin(theta / 2)|) / E* + 1 / E'_pin],  E' = E / (1 - nu^2),

up to a rigid motion, if (1 - 2 nu) / G is the same for both (Dundurs' beta = 0, as for equal materials). Over
the contact the pressures have to make it C cos(angle) - clearance. With b = tan(half_angle / 2) they are
those of Persson, whatever the stiffness of the one and the other, and

    pi E* clearance / load = 1 / (b^2 (1 + b^2)) - m (1 - E* / E'_pin),
    m = (2 b^4 + ln(1 + b^2)) / (b^2 (1 + b^2)),

m load the integral of the pressure along the arc: apply 1 + d^2/d(angle)^2 to both sides, at angle 0.

Source: Persson (1964), On the stress distribution of cylindrical elastic bodies in contact, Chalmers;
Ciavarella and Decuzzi (2001), International Journal of Solids and Structures 38, 4507-4523. Their general
case, beta not 0, is an integral equation: `PinInHole` refuses it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from femic.contact.exact.hertz import combined_modulus, require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.materials import Material

LARGEST_BETA = 1e-6  # of Dundurs, that counts as 0
SMALLEST = 1e-9  # half-angle [rad] that is sought


@dataclass(frozen=True)
class PinInHole:
    """Materials of pin and hole, the radius [mm] of both, and by how much that of the pin is smaller [mm].

    Raises WrongInput where the materials are not elastically similar, for lengths that are not positive, and
    for a negative clearance.
    """

    pin: Material
    hole: Material
    radius: float
    clearance: float

    def __post_init__(self) -> None:
        if not 0 < self.radius < np.inf:
            raise WrongInput(f"radius = {self.radius!r}: must be a positive length [mm]")
        if not 0 <= self.clearance < np.inf:
            raise WrongInput(f"clearance = {self.clearance!r}: must be 0 or a positive length [mm]")
        if abs(self.beta) > LARGEST_BETA:
            raise WrongInput(
                f"materials: Dundurs' beta = {self.beta:.3g}, and the solution is that of beta = 0, such as "
                "of equal materials; (1 - 2 nu) / G must be the same for both"
            )

    @property
    def modulus(self) -> float:
        """Combined modulus E* [MPa]."""
        return combined_modulus(self.pin, self.hole)

    @property
    def beta(self) -> float:
        """Dundurs' second constant in plane strain: 0 of elastically similar materials."""
        differences = [(1 - 2 * material.nu) / material.G for material in (self.hole, self.pin)]
        return (differences[0] - differences[1]) * self.modulus / 4

    @property
    def largest_half_angle(self) -> float:
        """The half-angle [rad] of the contact without clearance, or under a load without end."""
        return float(brentq(self._clearance_ratio, 0.5, np.pi - 1e-3, xtol=1e-14))

    def half_angle(self, load: float) -> float:
        """Return half of the angle [rad] of the contact under a load per length [N/mm]."""
        require_positive("load", load)
        target = np.pi * self.modulus * self.clearance / load

        def excess(half_angle: float) -> float:
            return self._clearance_ratio(half_angle) - target

        return float(brentq(excess, SMALLEST, self.largest_half_angle + 1e-9, xtol=1e-12 * SMALLEST))

    def load(self, half_angle: float) -> float:
        """Load per length [N/mm] under which the contact has this half-angle [rad].

        Raises WrongInput for a half-angle that no load produces, and where there is no clearance: any load
        produces the same one.
        """
        if not (self.clearance > 0 and 0 < half_angle < self.largest_half_angle):
            raise WrongInput(
                f"half_angle = {half_angle!r}: must lie in 0 ... {self.largest_half_angle:.4g} rad, with a "
                f"clearance (now {self.clearance:g} mm)"
            )
        return np.pi * self.modulus * self.clearance / self._clearance_ratio(half_angle)

    def pressure(self, load: float, angle: ArrayLike) -> Array:
        """Pressure [MPa] at angles [rad] from the middle of the contact, shape of angle."""
        b, y = np.tan(self.half_angle(load) / 2), np.tan(np.asarray(angle) / 2)
        root, hypotenuse = np.sqrt(np.maximum(b**2 - y**2, 0)), np.sqrt(1 + b**2)
        per_load = 2 * root / (hypotenuse * (1 + y**2)) + np.arctanh(root / hypotenuse) / (b**2 * (1 + b**2))
        return np.asarray(load / (np.pi * self.radius) * per_load)

    def _clearance_ratio(self, half_angle: float) -> float:
        """Pi E* clearance / load of a half-angle [rad]; it falls as the angle grows."""
        squared = float(np.tan(half_angle / 2) ** 2)
        along_arc = (2 * squared**2 + np.log1p(squared)) / (squared * (1 + squared))  # m
        hole_share = 1 - self.modulus * (1 - self.pin.nu**2) / self.pin.E
        return float(1 / (squared * (1 + squared)) - along_arc * hole_share)
