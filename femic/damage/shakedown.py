"""The shakedown map: the largest Hertz pressure over the yield stress in shear, by utilised friction.

Beyond the limit each passage shears the surface or a layer under it a little further (ratchetting); below it
residual stresses, once built up, keep all further passages elastic. The field of stresses that travels along
x has one component that residual stresses cannot oppose, as those do not depend on x: the shear tau_xz
parallel to the surface. Its largest value over all places bounds the pressure,

    p_0 / k <= 1 / max |tau_xz / p_0|,

from above. In line contact the bound is reached (Johnson 1985, Contact Mechanics, section 9.2; Johnson and
Jefferis 1963); in point contact it is that of a layer that moves as a whole (Ponter, Hearle and Johnson 1985,
Journal of the Mechanics and Physics of Solids 33, 339-362), and other mechanisms may come somewhat before it.
Without friction it is 4.00 for lines and 4.68 for circles, as published; where friction is large, it is the
shear on the surface, p_0 / k = 1 / mu.

Limits: half-spaces, Hertz pressure, full slip along x at mu = utilised friction (a partly sticking contact
has larger shear at its trailing side for the same force); elastic, perfectly plastic, or with kinematic
hardening; small strains.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import RectBivariateSpline

from femic.contact.exact.positive import require_positive
from geometries.arrays import Array
from geometries.errors import WrongInput

LINE = 0.0  # aspect a / b of a line contact, which is endless along s
SHALLOWEST, DEEPEST, REACH = 0.1, 1.6, 1.2  # of places, in half-lengths a
PLACES, FINER = (49, 37), 12  # along x and z; finer places between them, by splines
NODES = 24, 48  # radii and angles of the quadrature over half of an ellipse
SHORTEST, LONGEST = 0.2, 5.0  # aspects a / b of ellipses; 0.2 is line contact to 1 %


@dataclass(frozen=True)
class Shakedown:
    """A contact in the shakedown map: p_0/k, utilised friction, the limit of p_0/k there.

    `load_factor` is the limit over p_0/k: below 1 the contact ratchets.
    """

    pressure_ratio: float
    utilised: float
    limit: float

    @property
    def load_factor(self) -> float:
        """How much larger pressures could be."""
        return self.limit / self.pressure_ratio


def shakedown(p_max: float, yield_shear: float, utilised: float, aspect: float = 1.0) -> Shakedown:
    """Return a contact of a largest pressure [MPa] in the shakedown map.

    `yield_shear` k [MPa] is the yield stress in shear, by Mises that in tension over sqrt 3; `aspect` is a/b,
    half-length along x over half-width, 0: line contact. Raises WrongInput for values that are not positive.
    """
    require_positive("p_max", p_max)
    require_positive("yield_shear", yield_shear)
    return Shakedown(float(p_max / yield_shear), utilised, float(shakedown_limit(utilised, aspect)))


def shakedown_limit(utilised: ArrayLike, aspect: float = 1.0) -> Array:
    """Return the limit of p_0/k at utilised friction [-], of its shape; `aspect` a/b, 0: line contact."""
    mu = np.asarray(utilised, dtype=float)
    if not (np.all(mu >= 0) and np.all(np.isfinite(mu))):
        raise WrongInput(f"utilised = {utilised!r}: friction must be zero or positive, and finite")
    if aspect != LINE and not SHORTEST <= aspect <= LONGEST:
        raise WrongInput(f"aspect = {aspect!r}: a/b from {SHORTEST} to {LONGEST}, or 0 for line contact")
    normal, tangential = _shears(aspect)
    largest = [np.max(np.abs(normal + one * tangential)) for one in mu.ravel()]
    below_the_surface = np.reshape(largest, mu.shape)
    return np.asarray(1 / np.maximum(below_the_surface, mu))


@lru_cache(maxsize=32)
def _shears(aspect: float) -> tuple[Array, Array]:
    """Return tau_xz / p_0 by pressure, and by traction of p_0 = 1, on fine places below the surface."""
    x, z = np.linspace(-REACH, REACH, PLACES[0]), np.linspace(SHALLOWEST, DEEPEST, PLACES[1])
    fields = (
        line_shears(x[:, None], z) if aspect == LINE else ellipse_shears(x[:, None], z[None, :], 1 / aspect)
    )
    fine = [np.linspace(at[0], at[-1], FINER * (len(at) - 1) + 1) for at in (x, z)]
    normal, tangential = (RectBivariateSpline(x, z, field)(*fine) for field in fields)
    return normal, tangential


def line_shears(x: Array, z: Array) -> tuple[Array, Array]:
    """Return tau_xz below a line contact of half-length 1: by a pressure and by a traction, p_0 = 1 each.

    At x and depths z > 0, of their joint shape. Johnson (1985), equations 4.49 and 7.8: that by traction is
    sigma_x by pressure.
    """
    squares = 1 - x**2 + z**2
    root = np.sqrt(squares**2 + 4 * x**2 * z**2)
    m = np.sqrt((root + squares) / 2)
    n = np.sign(x) * np.sqrt(np.maximum(root - squares, 0) / 2)
    ratio = (z**2 + n**2) / (m**2 + n**2)
    by_pressure = -n * (m**2 - z**2) / (m**2 + n**2)
    return by_pressure, -(m * (1 + ratio) - 2 * z)


def ellipse_shears(x: Array, z: Array, b: float) -> tuple[Array, Array]:
    """Return tau_xz in the plane s = 0 below an ellipse of half-length 1 and half-width b, p_0 = 1 each.

    By pressure and by traction along x, both of Hertz's form, at x and depths z > 0, of their joint shape.
    Sums of Boussinesq's and Cerruti's shear, 3/(2 pi) x z^2 / r^5 and 3/(2 pi) x^2 z / r^5 (Johnson 1985,
    sections 3.2 and 3.6), over the ellipse: Gauss-Legendre in theta, radius sin theta, and equal angles.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES[0])
    theta = np.pi / 4 * (nodes + 1)
    angle = np.pi * (np.arange(NODES[1]) + 0.5) / NODES[1]
    radius, area = np.sin(theta), np.pi / 4 * weights * np.sin(theta) * np.cos(theta) ** 2
    forces = b * area[:, None] * np.full(NODES[1], 2 * np.pi / NODES[1])
    x_load, s_load = radius[:, None] * np.cos(angle), b * radius[:, None] * np.sin(angle)
    by_pressure, by_traction = np.zeros(np.broadcast_shapes(x.shape, z.shape)), 0.0
    for force, at_x, at_s in zip(forces.ravel(), x_load.ravel(), s_load.ravel(), strict=True):
        lag = x - at_x
        kernel = 3 * force / (2 * np.pi) * lag * z / (lag**2 + at_s**2 + z**2) ** 2.5
        by_pressure = by_pressure - kernel * z
        by_traction = by_traction - kernel * lag
    return by_pressure, np.asarray(by_traction)
