"""Shakedown, T-gamma, and the index of surface fatigue of a contact.

**Shakedown map**: the largest Hertz pressure over the yield stress in shear, by utilised friction. Beyond the
limit each passage shears the surface or a layer under it a little further (ratchetting); below it residual
stresses, once built up, keep all further passages elastic (Melan's theorem; elastic, perfectly plastic,
Mises). Stresses that travel along x meet residual stresses that do not depend on x. The limit here,

    p_0 / k = 1 / max |tau_xz / p_0|,

is that of residual stresses without the shear tau_xz parallel to the surface, over the plane s = 0.

- Lines: they cannot have such a shear, so this is the limit (Johnson 1985, Contact Mechanics, section 9.2;
  Johnson and Jefferis 1963): 4.00 without friction.
- Ellipses whose track stays where it is may have one, which what lies beside the track balances: the limit
  here is a lower bound. A shear halves its range over x at best, which gives an upper bound. Without
  friction both are the same, 4.68 for circles (Ponter, Hearle and Johnson 1985, Journal of the Mechanics and
  Physics of Solids 33, 339-362). For circles the other residual stresses reach the lower bound, to 1 %; for
  a/b = 2 those found reach 5.35 of 5.78 without friction, 4.45 of 4.46 at 0.2.
- Where wheels run at scattered places, residual stresses do not depend on s either, so that no shear of this
  kind is left: there the limit is an upper bound.

Where friction is large, the shear on the surface decides, p_0 / k = 1 / mu, in all cases.

Limits: half-spaces, Hertz pressure, full slip along x at mu = utilised friction (a partly sticking contact
has larger shear at its trailing side for the same force); small strains. Hardening only raises limits.

**T-gamma**: the work of friction per rolled distance as forces times creepages, with and without spin. The
rigid slip w of a contact is split into a mean motion, a rotation about the normal, and a rest,

    w = w_0 + omega (-(s - s_0), x - x_0) + rest,

by least squares weighted with pressures; (x_0, s_0) is the centre of pressure. On a plane the rest vanishes,
-w_0x and w_0s are the longitudinal and lateral creepages of that point, and omega the spin. In conforming
contacts heights, and the rolling of inclined places, turn the slip further. With T_x, T_s and M_n, the forces
and the moment about the normal through the centre of pressure, friction takes per rolled distance

    -T_x w_0x - T_s w_0s - M_n omega - sum p_t . rest + pressures,

where the last is the work that pressures do on the distance of the surfaces (`femic.contact.rolling`).
Engineers mostly count the first two (Pearce and Sherratt 1991, Wear 144, 343-351), or three.

**Surface index**: that of Ekberg, Kabo and Andersson (2002), Fatigue & Fracture of Engineering Materials &
Structures 25, 899-909, in terms of load F_n and semi-axes a, b of a Hertz contact

    FI_surf = mu - 2 pi a b k / (3 F_n),

with mu the utilised friction, k the yield stress in shear. With p_0 = 3 F_n / (2 pi a b) it is mu - k/p_0,
which is how it is computed here, so that contacts that are not Hertz's have it, too: by their largest
pressure.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import RectBivariateSpline

from femic.contact.exact.hertz import require_positive
from femic.contact.frictional import FrictionalContact
from femic.contact.pairs.quantities import main_patch
from femic.contact.rolling import RollingContact, RollingProblem
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N

# --- shakedown map ---

LINE = 0.0  # aspect a / b of a line contact, which is endless along s
SHALLOWEST, DEEPEST, REACH = 0.1, 1.6, 1.2  # of places, in half-lengths a
PLACES, FINER = (49, 37), 12  # along x and z; finer places between them, by splines
NODES = 24, 48  # radii and angles of the quadrature over half of an ellipse
SHORTEST, LONGEST = 0.2, 5.0  # aspects a / b of ellipses; 0.2 is line contact to 1 %


def patch_aspect(contact: FrictionalContact) -> float:
    """Return a/b of the main patch of a contact, within `SHORTEST` and `LONGEST`."""
    patch, grid = main_patch(contact), contact.problem.grid
    return nearest_aspect(float(np.ptp(patch.x) * grid.dx / (np.ptp(patch.s) * grid.ds)))


def nearest_aspect(aspect: float) -> float:
    """Return the nearest aspect that an ellipse of the map may have."""
    return float(np.clip(aspect, SHORTEST, LONGEST))


def utilised_friction(contact: FrictionalContact) -> float:
    """Return tangential over normal force, |sum p_t| / sum p_n: the abscissa of the shakedown map.

    Forces along x, s and n of each element are added as they are, so in conforming contacts they are not
    those in global axes. It is not the share of the available friction (`utilised` of `femic shifts`), which
    is this over the coefficient. Raises WrongInput without contact.
    """
    pressed = float(np.sum(contact.p[..., N]))
    if pressed <= 0:
        raise WrongInput("contact without pressure: there is no utilised friction; press the bodies together")
    return float(np.linalg.norm(np.sum(contact.p[..., :N], axis=(0, 1)))) / pressed


def shakedown_limit(utilised: ArrayLike, aspect: float = 1.0) -> Array:
    """Return the limit of p_0/k at utilised friction [-], of its shape; `aspect` a/b, 0: line contact.

    Residual stresses have no shear parallel to the surface along x. Raises WrongInput for negative friction,
    and aspects beyond those of the map.
    """
    mu = _require_friction(utilised)
    if aspect != LINE and not SHORTEST <= aspect <= LONGEST:
        raise WrongInput(f"aspect = {aspect!r}: a/b from {SHORTEST} to {LONGEST}, or 0 for line contact")
    normal, tangential = shears_below(aspect)
    largest = np.reshape([np.max(np.abs(normal + one * tangential)) for one in mu.ravel()], mu.shape)
    return np.asarray(1 / np.maximum(largest, mu))


@lru_cache(maxsize=32)
def shears_below(aspect: float) -> tuple[Array, Array]:
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


# --- T-gamma ---


def t_gamma(problem: RollingProblem, rolling: RollingContact) -> tuple[float, float, float]:
    """Return the longitudinal, the lateral and the spin share of T-gamma [N] of a contact in steady rolling.

    A share is negative where a force drives the motion of its own creepage, such as the lateral force that
    spin causes. Raises WrongInput without contact.
    """
    p, area = rolling.contact.p, problem.problem.grid.area
    pressed = p[..., N]
    if not np.any(pressed > 0):
        raise WrongInput("contact without pressure: there is no T-gamma; press the bodies together")
    w = problem.rolling.rigid_slip(rolling.creepages)
    x, s = np.broadcast_arrays(problem.rolling.x[:, None], problem.rolling.s)
    mean_x, mean_s, w_x, w_s = (
        float(np.average(values, weights=pressed)) for values in (x, s, w[..., 0], w[..., 1])
    )
    rest, turning = w - [w_x, w_s], np.stack([mean_s - s, x - mean_x], axis=-1)
    square = float(np.sum(pressed * np.sum(turning**2, axis=-1)))
    omega = float(np.sum(pressed * np.sum(rest * turning, axis=-1))) / square if square > 0 else 0.0
    T_x, T_s = np.sum(p[..., :N], axis=(0, 1)) * area
    M_n = float(np.sum(p[..., :N] * turning)) * area
    return -float(T_x) * w_x, -float(T_s) * w_s, -M_n * omega


# --- surface index ---


def surface_index(p_max: ArrayLike, utilised: ArrayLike, yield_shear: float) -> Array:
    """Return FI_surf [-] at largest pressures [MPa] and utilised friction [-], of their joint shape.

    Above 0 the surface is beyond its shakedown limit and cracks start by ratchetting. `yield_shear` k [MPa]
    is that of the hardened surface. Limits: full slip; Hertz pressure; where utilised friction is below about
    0.3, shakedown is lost below the surface first (`shakedown_limit`), which this index does not see.
    """
    require_positive("yield_shear", yield_shear)
    p = np.asarray(p_max, dtype=float)
    if not (np.all(p > 0) and np.all(np.isfinite(p))):
        raise WrongInput(f"p_max = {p_max!r}: must be positive and finite [MPa]")
    return np.asarray(_require_friction(utilised) - yield_shear / p)


def _require_friction(utilised: ArrayLike) -> Array:
    """Return utilised friction as an array; raise WrongInput unless it is zero or positive."""
    mu = np.asarray(utilised, dtype=float)
    if not (np.all(mu >= 0) and np.all(np.isfinite(mu))):
        raise WrongInput(f"utilised = {utilised!r}: friction must be zero or positive, and finite")
    return mu
