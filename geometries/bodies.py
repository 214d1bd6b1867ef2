"""Bodies: a contact contour, the far arc that closes its section, a length and a material."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.materials import Material

UPPER, LOWER = +1, -1


@dataclass(frozen=True)
class Domain:
    """How much of a body is modelled: clamped at the far arc and at both ends, free elsewhere.

    far_radius [mm] is the radius of the far arc about the contact centre, half_length [mm] the
    extent along +x and along -x.
    """

    far_radius: float
    half_length: float

    def __post_init__(self) -> None:
        if not (self.far_radius > 0 and self.half_length > 0):
            raise WrongInput(
                f"far_radius = {self.far_radius!r}, half_length = {self.half_length!r}: must be positive [mm]"
            )

    def scaled(self, factor: float) -> "Domain":
        """The same domain, `factor` times as large."""
        return Domain(factor * self.far_radius, factor * self.half_length)


@dataclass(frozen=True)
class PrismaticBody:
    """A body that does not change along x. side +1: upper, fills n > 0; -1: lower."""

    side: int
    contour: Contour
    material: Material
    domain: Domain

    @property
    def s_range(self) -> tuple[float, float]:
        """Arc lengths at which the contour meets the far arc."""
        return far_end(self.contour, self.domain, -1), far_end(self.contour, self.domain, +1)


def far_end(contour: Contour, domain: Domain, direction: int) -> float:
    """Arc length [mm] at which the contour meets the far arc, growing s for direction +1."""
    joint = contour.limits[1 if direction > 0 else 0]
    if np.hypot(*contour.position(joint)) >= domain.far_radius:
        raise WrongInput(
            f"far_radius = {domain.far_radius:g} mm: the curved part of the contour, which ends at "
            f"s = {joint:g} mm, must lie inside the far arc; enlarge far_radius"
        )

    def beyond(s: float) -> float:
        return float(np.hypot(*contour.position(s))) - domain.far_radius

    return float(brentq(beyond, joint, joint + direction * 2 * domain.far_radius, xtol=1e-12))
