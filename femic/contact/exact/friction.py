"""Closed forms of contact with friction: tractive rolling, shifted Hertz contacts, and full stick.

**Carter**: steady tractive rolling of long cylinders of elastically similar materials, in plane strain. They
roll towards +x, across the line on which they touch, with the creepage xi = omega R / V - 1, positive where
the upper one is driven. Per rolled distance the upper surface slips over the lower one by

    slip = -xi - du/dx, u = upper - lower,

and the traction on the upper body, of size friction p_n at most, opposes that. Over the width 2 c that begins
at the leading edge x = a both stick, with c / a = sqrt(1 - F / (f P)). The traction is that of sliding less
the same of a Hertz contact of half-width c about a - c, whose displacements differ from those of sliding by a
constant slope there:

    xi = f curvature (a - c), curvature = 1/R_upper + 1/R_lower.

Source: Carter (1926), Proceedings of the Royal Society A 112, 151-157; Johnson (1985), Contact Mechanics,
section 8.3. Normal and tangential problem are apart only for equal (1 - 2 nu) / G of both bodies (K = 0).

**Cattaneo and Mindlin**: a Hertz contact that is shifted by a growing tangential force at a constant load. In
the middle of the contact the surfaces stick, around it they slip. The traction is that of sliding, friction
p_n, less the same of a smaller Hertz contact: its size is k times the contact's, of the same shape,

    k = (1 - F / (f N))^(1/3).

Displacements u = upper - lower under the pressures p_max sqrt(1 - (x/a)^2 - (s/b)^2) as tractions along x
are, in the ellipse, a constant less a quadratic form, and the smaller ellipse removes the same quadratic
form: the surfaces shift as a whole where they stick. By half-space ICs in polar coordinates that shift is,
along x,

    (1 - k^2) 3 f N / (2 pi G) integral of ((1 - nu) + nu cos(t)^2) / sqrt(b^2 cos(t)^2 + a^2 sin(t)^2),

over t = 0 ... pi/2, in elliptic integrals; of a circle 3 f N (2 - nu) / (8 G a) (1 - k^2). Along s, sin(t)^2.

Exact for nu = 0. Otherwise it neglects the displacements across the force
in the slip zone: there the slip of a circle is off the direction of the traction by about nu / (4 - 2 nu) rad
(Johnson). Tractions of the exact solution differ by little, most of it across the force (Munisamy, Hills and
Nowell 1994, Journal of Applied Mechanics 61, 278-283): compare at 1 %. Normal and tangential problem are
apart only for equal (1 - 2 nu) / G of both bodies (K = 0).

Sources: Cattaneo (1938), Rendiconti dell'Accademia dei Lincei 27, 342-348; Mindlin (1949), Journal of Applied
Mechanics 16, 259-268; Deresiewicz (1957), Journal of Applied Mechanics 24, 623-624; Vermeulen and Johnson
(1964), the same 31, 338-340; Johnson (1985), Contact Mechanics, section 7.2.

**Full stick**: dissimilar bodies pressed together with so much friction that nothing slips. Where (1 - 2 nu)
/ G differ, pressures also move the two surfaces over each other. Without slip each particle keeps the
tangential displacement that it has on entering the contact, so the history counts: here the load grows from
0, with a gap curvature r^2 / 2, and contacts of all sizes are alike. From one size to the next the bodies
approach as on a flat punch without slip, and the tractions are sums of those of punches. In terms of

    beta = K / (1 - nu) with combined constants (Dundurs' second constant), epsilon = artanh(beta) / pi,

of E* = G / (1 - nu), and of the radius a:

    P = 2/3 E* curvature a^3 artanh(beta) / (beta I) at the approach curvature a^2 / (2 I),
    I = integral over t = 0 ... 1 of t cos(L(t)), L(t) = epsilon ln((1 + t) / (1 - t)).

Without mismatch I = 1/2: Hertz. Tractions of the punches, p and q, are Hankel transforms of the cosine
transform of phi and of the sine transform of psi, and phi + i psi is proportional to exp(i L(t / a)). That
the surfaces touch where the contact grows to gives I. Of a punch on one body that is rigid, artanh(beta) /
beta = (1 - nu) ln(3 - 4 nu) / (1 - 2 nu) with the nu of the other one.

The traction q on the upper body points outwards for K > 0. It needs a friction of |q| / p, which grows
without bound towards the edge: any friction leaves a ring of slip there. Still nearer to the edge, as near as
about exp(-pi / (2 epsilon)) of the size, p and q change signs, which no real contact does.

Sources: Mossakovskii (1963), Journal of Applied Mathematics and Mechanics 27, 630-643; Spence (1968),
Proceedings of the Royal Society A 305, 55-80; Johnson (1985), Contact Mechanics, section 5.4.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import quad
from scipy.special import elliprd, elliprf

from femic.contact.exact.hertz import LineContact, LoadedPoint, require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import S, X

# --- tractive rolling: Carter ---


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


# --- shifted Hertz contacts: Cattaneo and Mindlin ---


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
        if not 0 <= self.nu <= 0.5:
            raise WrongInput(f"nu = {self.nu!r}: must lie in 0 ... 0.5")
        require_positive("friction", self.friction)
        largest = self.friction * self.normal.load
        if not abs(self.force) < largest:
            raise WrongInput(f"force = {self.force!r}: must be below friction * load = {largest:g}")
        if self.direction not in (X, S):
            raise WrongInput(f"direction = {self.direction!r}: must be {X} (x) or {S} (s)")

    @property
    def G(self) -> float:
        """Combined shear modulus [MPa]."""
        return (1 - self.nu) * self.normal.surfaces.modulus

    @property
    def stick_ratio(self) -> float:
        """The size k of the ellipse that sticks, as a share of that of the contact."""
        return (1 - abs(self.force) / (self.friction * self.normal.load)) ** (1 / 3)

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
        cosine_part = along**2 * elliprd(0, across**2, along**2) / 3
        return float(3 / (2 * np.pi * self.G) * ((1 - self.nu) * integral + self.nu * cosine_part))


# --- full stick: Mossakovskii and Spence ---

Complex = NDArray[np.complex128]

LARGEST_BETA = 0.5  # of nu = 0 against a rigid body
NODES = 80  # of the rule for tractions
LEAST = 1e-6  # distance from the middle, over the size, up to which q is linear


@dataclass(frozen=True)
class StickingPoint:
    """Surfaces of one relative curvature [1/mm] in all directions, with E* [MPa] and mismatch beta.

    Raises WrongInput for what is not positive, and |beta| beyond 0.5.
    """

    curvature: float
    modulus: float
    beta: float

    def __post_init__(self) -> None:
        require_positive("curvature", self.curvature)
        require_positive("modulus", self.modulus)
        if not abs(self.beta) <= LARGEST_BETA:
            raise WrongInput(f"beta = {self.beta!r}: must lie in -0.5 ... 0.5")

    @cached_property
    def approach_ratio(self) -> float:
        """The approach over that of Hertz at the same radius."""
        epsilon = np.arctanh(self.beta) / np.pi
        # t = tanh(v), by parts
        integral, _ = quad(lambda v: np.sin(2 * epsilon * v) / np.cosh(v) ** 2, 0, 40)
        return float(1 / (1 - 2 * epsilon * integral))

    @property
    def punch_ratio(self) -> float:
        """The stiffness of a flat punch without slip over that of one without friction."""
        return float(np.arctanh(self.beta) / self.beta) if self.beta else 1.0

    @property
    def load_ratio(self) -> float:
        """The load over that of Hertz at the same radius."""
        return self.approach_ratio * self.punch_ratio

    def radius(self, load: float) -> float:
        """Radius [mm] of the contact under a load [N]."""
        require_positive("load", load)
        return float((3 * load / (4 * self.modulus * self.curvature * self.load_ratio)) ** (1 / 3))

    def approach(self, load: float) -> float:
        """Return how much nearer distant points of the two bodies come [mm] under a load [N]."""
        return self.curvature * self.radius(load) ** 2 * self.approach_ratio

    def tractions(self, load: float, r: ArrayLike) -> tuple[Array, Array]:
        """Pressure p and outward traction q on the upper body [MPa] at r [mm], shape of r each.

        p is the integral of -phi'(t) / sqrt(t^2 - r^2) over t = r ... a, q that of -psi'(t) t / r / the same.
        """
        a, epsilon = self.radius(load), np.arctanh(self.beta) / np.pi
        outward = np.abs(np.asarray(r, dtype=float)) / a
        ratio = np.clip(outward, LEAST, 1 - 1e-15)[..., None]
        share, steps = _crowding_nodes()  # of sqrt(t^2 - r^2)
        root = np.sqrt(1 - ratio**2)
        t = np.minimum(np.hypot(ratio, root * share), 1 - 1e-15)
        slopes = _slopes(epsilon, t)
        scale = 2 * self.modulus * self.curvature * a / np.pi * self.approach_ratio
        inside = np.where(outward < 1, scale * np.cosh(np.pi * epsilon), 0)
        p = np.sum(root * steps * slopes.real, axis=-1)
        q = np.sum(root * steps * slopes.imag * t / ratio, axis=-1)
        return inside * p, inside * q * np.minimum(outward / LEAST, 1)


def _slopes(epsilon: float, t: Array) -> Complex:
    """-(phi' + i psi') / t of all punches from t to 1, up to a factor: 1 without mismatch."""
    y = (1 - t) / (1 + t)  # exp(-2 v)
    rest = y ** (1 - 1j * epsilon) * _remainder(epsilon, y) - y ** (-1j * epsilon) * np.log1p(-y)
    # integral of exp(2 i epsilon v) / sinh(v)^2 over larger v, by parts
    turn = np.exp(2j * epsilon * np.arctanh(t))
    return np.asarray((1 - 2j * epsilon * (1 / t - 1)) * turn + 4 * epsilon**2 * rest)


def _remainder(eta: float, z: Array) -> Complex:
    """Integral of (u^(-i eta) - 1) / (1 - z u) over u = 0 ... 1, shape of z."""
    u, steps = _crowding_nodes()
    return np.asarray((u ** (-1j * eta) - 1) / (1 - z[..., None] * u) @ steps)


def _crowding_nodes() -> tuple[Array, Array]:
    """Nodes and weights over 0 ... 1 that crowd at both ends, where integrands are not smooth."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    x = (nodes + 1) / 2
    return x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3), 70 * (x * (1 - x)) ** 3 * weights
