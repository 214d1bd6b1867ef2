"""Cattaneo and Mindlin: a Hertz contact that is shifted by a growing tangential force at a constant load.

In the middle of the contact the surfaces stick, around it they slip. The traction is that of sliding,
friction p_n, less the same of a smaller Hertz contact: its size is k times the contact's, of the same shape,

    k = (1 - F / (f N))^(1/3) at a point,  k = (1 - F / (f N))^(1/2) along a line.

Displacements u = upper - lower under the pressures p_max sqrt(1 - (x/a)^2 - (s/b)^2) as tractions along x
are, in the ellipse, a constant less a quadratic form, and the smaller ellipse removes the same quadratic
form: the surfaces shift as a whole where they stick. By half-space ICs in polar coordinates that shift is,
along x,

    (1 - k^2) 3 f N / (2 pi G) integral of ((1 - nu) + nu cos(t)^2) / sqrt(b^2 cos(t)^2 + a^2 sin(t)^2),

over t = 0 ... pi/2, in elliptic integrals; of a circle 3 f N (2 - nu) / (8 G a) (1 - k^2). Along s, sin(t)^2.

Exact in two dimensions and, at a point, for nu = 0. Otherwise it neglects the displacements across the
force in the slip zone: there the slip of a circle is off the direction of the traction by about
nu / (4 - 2 nu) rad (Johnson). Tractions of the exact solution differ by little, most of it across the force
(Munisamy, Hills and Nowell 1994, Journal of Applied Mechanics 61, 278-283): compare at 1 %. Normal and
tangential problem are apart only for equal (1 - 2 nu) / G of both bodies (K = 0).

Sources: Cattaneo (1938), Rendiconti dell'Accademia dei Lincei 27, 342-348; Mindlin (1949), Journal of Applied
Mechanics 16, 259-268; Deresiewicz (1957), Journal of Applied Mechanics 24, 623-624; Vermeulen and Johnson
(1964), the same 31, 338-340; Johnson (1985), Contact Mechanics, section 7.2.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import elliprd, elliprf

from femic.contact.exact.hertz import LineContact, LoadedPoint
from femic.contact.exact.positive import require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import S, X


@dataclass(frozen=True)
class ShiftedPoint:
    """A contact of Hertz under a tangential force [N] on the upper body, in direction 0 (x) or 1 (s).

    `nu` is the combined one; the combined G is (1 - nu) E*. Raises WrongInput for a friction that is not
    positive, a force of friction load or more, another direction, and nu beyond 0 ... 0.5.
    """

    normal: LoadedPoint
    nu: float
    friction: float
    force: float
    direction: int = X

    def __post_init__(self) -> None:
        _check(self.nu, self.friction, self.force, self.normal.load, self.direction)

    @property
    def G(self) -> float:
        """Combined shear modulus [MPa]."""
        return (1 - self.nu) * self.normal.surfaces.modulus

    @property
    def stick_ratio(self) -> float:
        """The size k of the ellipse that sticks, as a share of that of the contact."""
        return _sticking(self.friction, self.force, self.normal.load) ** (1 / 3)

    @property
    def stick_semi_axes(self) -> tuple[float, float]:
        """Semi-axes [mm] of the ellipse that sticks, along x and s."""
        return self.stick_ratio * self.normal.a, self.stick_ratio * self.normal.b

    @property
    def shift(self) -> float:
        """Displacement [mm] upper - lower, along the force, where the surfaces stick.

        By as much the distant points of the upper body move the other way, over those of the lower one.
        """
        lost = 1 - self.stick_ratio**2
        return float(np.sign(self.force)) * self.friction * self.normal.load * lost * self._compliance

    @property
    def stiffness(self) -> float:
        """Derivative of the force by the shift [N/mm]; largest without a force, 0 where all slips."""
        return 1.5 * self.stick_ratio / self._compliance

    def traction(self, x: ArrayLike, s: ArrayLike) -> Array:
        """Traction [MPa] along the force at (x, s) [mm], shape broadcast(x, s)."""
        k = self.stick_ratio
        reduced = k * self.normal.pressure(np.asarray(x) / k, np.asarray(s) / k)
        return np.asarray(np.sign(self.force) * self.friction * (self.normal.pressure(x, s) - reduced))

    @property
    def _compliance(self) -> float:
        """Shift over force [mm/N] of tractions that are distributed as the pressures are."""
        along, across = self.normal.a, self.normal.b
        if self.direction == S:
            along, across = across, along
        integral = elliprf(0, along**2, across**2)
        of_cosines = along**2 * elliprd(0, across**2, along**2) / 3
        return float(3 / (2 * np.pi * self.G) * ((1 - self.nu) * integral + self.nu * of_cosines))


@dataclass(frozen=True)
class ShiftedLine:
    """A contact of Hertz along x under a load and a tangential force on the upper body, per length [N/mm].

    The force acts in direction 1 (s, across the line, in plane strain) or 0 (x, along the line). The shift of
    distant points is infinite. Raises WrongInput as `ShiftedPoint` does.
    """

    surfaces: LineContact
    load: float
    nu: float
    friction: float
    force: float
    direction: int = S

    def __post_init__(self) -> None:
        _check(self.nu, self.friction, self.force, self.load, self.direction)

    @property
    def stick_half_width(self) -> float:
        """Half of the width [mm] that sticks."""
        return self.surfaces.half_width(self._reduced_load)

    def traction(self, s: ArrayLike) -> Array:
        """Traction [MPa] along the force at s [mm], shape of s."""
        reduced = self.surfaces.pressure(self._reduced_load, s)
        return np.asarray(
            np.sign(self.force) * self.friction * (self.surfaces.pressure(self.load, s) - reduced)
        )

    def slip(self, s: ArrayLike) -> Array:
        """Slip [mm] of the upper surface over the lower one since the force was 0, at s [mm] in the contact.

        Against the traction; 0 where the surfaces stick. Shape of s.
        """
        grown = self.surfaces.gap(self._reduced_load, s)  # in one direction as in the other: ln|s|
        ratio = 1.0 if self.direction == S else 1 / (1 - self.nu)
        return np.asarray(-np.sign(self.force) * self.friction * ratio * grown)

    @property
    def _reduced_load(self) -> float:
        return self.load * _sticking(self.friction, self.force, self.load)


def _sticking(friction: float, force: float, load: float) -> float:
    """Return the share of friction load that a force leaves."""
    return 1 - abs(force) / (friction * load)


def _check(nu: float, friction: float, force: float, load: float, direction: int) -> None:
    """Raise WrongInput for what the solution does not hold for."""
    if not 0 <= nu <= 0.5:
        raise WrongInput(f"nu = {nu!r}: must lie in 0 ... 0.5")
    require_positive("friction", friction)
    require_positive("load", load)
    if not abs(force) < friction * load:
        raise WrongInput(f"force = {force!r}: must be below friction * load = {friction * load:g}")
    if direction not in (X, S):
        raise WrongInput(f"direction = {direction!r}: must be {X} (x) or {S} (s)")
