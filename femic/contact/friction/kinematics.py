"""How a rigid wheel that rolls on a rail moves over it, per unit of rolled distance.

Rolling is towards +x. Velocities are those of the upper surface over the lower one, in the local directions
x, s, n of the latter; those along x and s are the rigid slip.
Theory: docs/theory/friction.md. Source: Kalker (1990), Three-dimensional elastic bodies in rolling contact,
section 1.3.
"""

from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array
from geometries.contours import Contour
from geometries.errors import WrongInput
from geometries.patches import N


@dataclass(frozen=True)
class Creepages:
    """How a wheel moves besides rolling, at zero yaw.

    `longitudinal` is omega R_roll / V - 1, positive where the wheel is driven; `lateral` the lateral velocity
    of the wheel relative to the rail over V; `spin` [1/mm] an angular velocity of the wheel about z over V,
    beside that which its own rotation has about the normals of inclined places.
    """

    longitudinal: float = 0.0
    lateral: float = 0.0
    spin: float = 0.0

    def __post_init__(self) -> None:
        if not np.all(np.isfinite([self.longitudinal, self.lateral, self.spin])):
            raise WrongInput(f"creepages {self}: must be finite")


NAMES = ("longitudinal", "lateral", "spin")


@dataclass(frozen=True, eq=False)
class RollingKinematics:
    """Where a wheel of rolling radius `radius` [mm] rolls on a lower contour.

    `x` [mm], (n_x,), and `s` [mm], (n_s,), are the centres of elements; `height` [mm], (n_s,), is that of the
    wheel's surface there over its crown (`Undeformed.upper_height`): a wheel that is moved aside touches on
    other circles. An infinite radius is that of a prismatic upper body, which only slides.
    """

    contour: Contour
    radius: float
    x: Array
    s: Array
    height: Array

    def rigid_velocity(self, creepages: Creepages) -> Array:
        """Velocity along x, s, n of the rigid wheel over the rail, over V, shape (n_x, n_s, 3).

        Along n the wheel comes down ahead of the contact and rises behind it; its lateral velocity and spin
        move it along the normals of inclined places, too.
        """
        xi, upsilon, phi = creepages.longitudinal, creepages.lateral, creepages.spin
        y, _ = self.contour.position(self.s)
        sin, cos = self.contour.normal(self.s)
        x = self.x[:, None]
        along_x = -xi + (1 + xi) * self.height / self.radius - phi * y
        aside, up = upsilon + phi * x, -(1 + xi) * x / self.radius
        along = along_x, aside * cos - up * sin, aside * sin + up * cos
        return np.stack(np.broadcast_arrays(*along), axis=-1)

    def rigid_slip(self, creepages: Creepages) -> Array:
        """Rigid slip per unit of rolled distance, shape (n_x, n_s, 2)."""
        return self.rigid_velocity(creepages)[..., :N]

    def per_creepage(self, name: str) -> Array:
        """Return the rigid slip that a creepage of 1 adds, (n_x, n_s, 2): it is linear in each."""
        return self.rigid_slip(Creepages(**{name: 1.0})) - self.rigid_slip(Creepages())
