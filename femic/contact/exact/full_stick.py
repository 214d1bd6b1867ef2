"""Full stick: dissimilar bodies pressed together with so much friction that nothing slips, in closed form.

Where (1 - 2 nu) / G differ, pressures also move the two surfaces over each other. Without slip each particle
keeps the tangential displacement that it has on entering the contact, so the history counts: here the load
grows from 0, with a gap curvature r^2 / 2, and contacts of all sizes are alike. From one size to the next the
bodies approach as on a flat punch without slip, and the tractions are sums of those of punches. In terms of

    beta = K / (1 - nu) with combined constants (Dundurs' second constant), epsilon = artanh(beta) / pi,

of E* = G / (1 - nu), and of the half-width or radius a:

- along a line, load per length P = pi E* curvature a^2 / (4 J),
  J = integral over t = 0 ... 1 of t cos(L(t)) / sqrt(1 - t^2), L(t) = epsilon ln((1 + t) / (1 - t));
- axisymmetric, P = 2/3 E* curvature a^3 artanh(beta) / (beta I) at the approach curvature a^2 / (2 I),
  I = integral over t = 0 ... 1 of t cos(L(t)).

Without mismatch J = 1 and I = 1/2: Hertz. Tractions of the punches: along a line p + i q is proportional to
exp(i L(x / a)) / sqrt(a^2 - x^2). Axisymmetric p and q are Hankel transforms of the cosine transform of phi
and of the sine transform of psi, and phi + i psi is proportional to exp(i L(t / a)). That the surfaces touch
where the contact grows to gives I and J. Of a punch on one body that is rigid,
artanh(beta) / beta = (1 - nu) ln(3 - 4 nu) / (1 - 2 nu) with the nu of the other one.

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

from femic.contact.exact.hertz import LineContact
from femic.contact.exact.positive import require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput

Complex = NDArray[np.complex128]

LARGEST_BETA = 0.5  # of nu = 0 against a rigid body
NODES = 80  # of the rule for tractions
LEAST = 1e-6  # distance from the middle, over the size, up to which q is linear


@dataclass(frozen=True)
class StickingLine:
    """Cylinders that touch along x, of relative curvature along s, with mismatch beta.

    Raises WrongInput for |beta| beyond 0.5.
    """

    surfaces: LineContact
    beta: float

    def __post_init__(self) -> None:
        _check_beta(self.beta)

    @cached_property
    def load_ratio(self) -> float:
        """The load over that of Hertz at the same half-width."""
        epsilon = _epsilon(self.beta)
        # t = tanh(v), by parts
        integral, _ = quad(lambda v: np.sin(2 * epsilon * v) / np.cosh(v), 0, 40)
        return float(1 / (1 - 2 * epsilon * integral))

    def half_width(self, load: float) -> float:
        """Return half of the width [mm] of the contact under a load per length [N/mm]."""
        return self.surfaces.half_width(load / self.load_ratio)

    def tractions(self, load: float, s: ArrayLike) -> tuple[Array, Array]:
        """Pressure p and traction q along +s on the upper body [MPa] at s [mm], shape of s each."""
        a, epsilon = self.half_width(load), _epsilon(self.beta)
        s = np.asarray(s, dtype=float)
        ratio = np.clip(np.abs(s) / a, 1e-12, 1 - 1e-15)
        z = np.sqrt((1 - ratio) / (1 + ratio))  # exp(-v)
        # of punches from |s| to a: integral of exp(2 i epsilon v) / sinh(v) over larger v
        punches = 2 * z ** (1 - 2j * epsilon) * (_remainder(2 * epsilon, z**2, 2) + np.arctanh(z) / z)
        both = _turn(epsilon, ratio) * np.sqrt(1 - ratio**2) + 2j * epsilon * ratio * punches
        scale = self.surfaces.modulus * self.surfaces.curvature * a / 2 * self.load_ratio
        both = np.where(np.abs(s) < a, scale * np.cosh(np.pi * epsilon) * both, 0)
        return both.real, np.sign(s) * both.imag


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
        _check_beta(self.beta)

    @cached_property
    def approach_ratio(self) -> float:
        """The approach over that of Hertz at the same radius."""
        epsilon = _epsilon(self.beta)
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
        a, epsilon = self.radius(load), _epsilon(self.beta)
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
    rest = y ** (1 - 1j * epsilon) * _remainder(epsilon, y, 1) - y ** (-1j * epsilon) * np.log1p(-y)
    # integral of exp(2 i epsilon v) / sinh(v)^2 over larger v, by parts
    return (1 - 2j * epsilon * (1 / t - 1)) * _turn(epsilon, t) + 4 * epsilon**2 * rest


def _turn(epsilon: float, ratio: Array) -> Complex:
    """exp(i epsilon ln((1 + ratio) / (1 - ratio)))."""
    return np.exp(2j * epsilon * np.arctanh(ratio))


def _remainder(eta: float, z: Array, power: int) -> Complex:
    """Integral of (u^(-i eta) - 1) / (1 - z u^power) over u = 0 ... 1, shape of z."""
    u, steps = _crowding_nodes()
    return np.asarray((u ** (-1j * eta) - 1) / (1 - z[..., None] * u**power) @ steps)


def _crowding_nodes() -> tuple[Array, Array]:
    """Nodes and weights over 0 ... 1 that crowd at both ends, where integrands are not smooth."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    x = (nodes + 1) / 2
    return x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3), 70 * (x * (1 - x)) ** 3 * weights


def _epsilon(beta: float) -> float:
    return float(np.arctanh(beta) / np.pi)


def _check_beta(beta: float) -> None:
    """Raise WrongInput for a mismatch that no two bodies have."""
    if not abs(beta) <= LARGEST_BETA:
        raise WrongInput(f"beta = {beta!r}: must lie in -0.5 ... 0.5")
