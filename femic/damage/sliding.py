"""Where a rolling contact slides, and the work of friction there.

Per unit of rolled distance friction takes q = -p_t . s from each unit of area, s the slip per unit of rolled
distance: N/mm^2, or J per metre rolled and mm^2. With the rolling speed V in m/s, q V is the friction power
density in W/mm^2. The sum of q over the contact is the work of friction per rolled distance, in N or J/m:
the exact T-gamma.
"""

from dataclasses import dataclass

import numpy as np

from femic.contact.exact.positive import require_positive
from femic.contact.friction.motion import SteadyRolling
from femic.contact.frictional import FrictionalContact
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.grids import Grid
from geometries.patches import N


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
