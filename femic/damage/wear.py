"""Where a rolling contact slides, the work of friction there, and depths and volumes of wear.

Per unit of rolled distance friction takes q = -p_t . s from each unit of area, s the slip per unit of rolled
distance: N/mm^2, or J per metre rolled and mm^2. With the rolling speed V in m/s, q V is the friction power
density in W/mm^2. The sum of q over the contact is the work of friction per rolled distance, in N or J/m: the
exact T-gamma.

A particle of either surface passes all elements of its strip, each in the rolled distance dx, so a contact
wears the same depth off both surfaces where laws are the same: the sum over x of rate dx. It is the depth
that the rail loses by one passage of a wheel, and the wheel in one revolution, since each place of its
circumference passes once. The rail loses it over all of the rolled length; per metre rolled a wheel loses
depth / (2 pi R(s)). Volumes per rolled distance are the same for both. Particles of the wheel pass in 1 + xi
times the distance; this is left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from femic.contact.exact.hertz import require_positive
from femic.contact.friction.motion import SteadyRolling
from femic.contact.frictional import FrictionalContact
from femic.damage.laws import WearLaw
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import Grid, N

# --- where the contact slides ---


@dataclass(frozen=True, eq=False)
class Sliding:
    """Pressures [MPa], (n_x, n_s), tangential tractions [MPa] and slip [-], (n_x, n_s, 2), of a contact.

    Slip is that of the upper over the lower surface per unit of rolled distance; `speed` [m/s] is the rolling
    speed. Raises WrongInput for a speed that is not positive, and for other shapes.
    """

    grid: Grid
    pressure: Array
    traction: Array
    slip: Array
    speed: float

    def __post_init__(self) -> None:
        require_positive("speed", self.speed)
        elements = self.grid.n_x, self.grid.n_s
        expected = {"pressure": elements, "traction": (*elements, 2), "slip": (*elements, 2)}
        for name, shape in expected.items():
            if np.shape(getattr(self, name)) != shape:
                raise WrongInput(
                    f"{name}: shape {np.shape(getattr(self, name))}, but the grid needs {shape}; give one "
                    "value per element"
                )

    @property
    def signed_work(self) -> Array:
        """Work of friction per area and rolled distance [N/mm^2], (n_x, n_s), as the solver left it.

        Tractions of leading edges follow those behind them, so a few elements there may have a negative one.
        """
        return np.asarray(-np.sum(self.traction * self.slip, axis=-1))

    @property
    def work(self) -> Array:
        """Work of friction per area and rolled distance [N/mm^2], (n_x, n_s); nowhere negative."""
        return np.maximum(self.signed_work, 0.0)

    @property
    def power_density(self) -> Array:
        """Friction power density [W/mm^2], (n_x, n_s)."""
        return self.speed * self.work

    @property
    def velocity(self) -> Array:
        """Size of the sliding velocity [m/s], (n_x, n_s)."""
        return np.asarray(self.speed * np.linalg.norm(self.slip, axis=-1))

    @property
    def total_work(self) -> float:
        """Work of friction per rolled distance [N], which is J/m."""
        return float(np.sum(self.work) * self.grid.area)

    @property
    def energy(self) -> Array:
        """Energy per area [N/mm], which is mJ/mm^2, that a passage of the contact leaves on strips, (n_s,).

        Both surfaces share it: particles run through all elements of their strip.
        """
        return np.asarray(np.sum(self.work, axis=0) * self.grid.dx)


def sliding_of(contact: FrictionalContact, speed: float) -> Sliding:
    """Return where a contact in rolling, steady or in a step, slides at a rolling speed [m/s].

    Raises WrongInput for contacts that only shift: their slip is a length.
    """
    if not isinstance(contact.motion, SteadyRolling):
        raise WrongInput(
            f"contact by a {type(contact.motion).__name__.lower()}: wear and T-gamma need rolling; solve a "
            "rolling contact"
        )
    return Sliding(contact.problem.grid, contact.p[..., N], contact.p[..., :N], contact.slip, speed)


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


# --- depths and volumes ---

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
