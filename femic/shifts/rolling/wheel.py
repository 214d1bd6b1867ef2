"""One wheel of a rolling wheelset with some ICs: its creepages, its contact, forces and torque.

Axes are those of the side, parallel to the axle: x ahead, y to the field side, z up; the right side is the
mirror image of a left one. With the angular velocity omega of the axle, the speed V along the track, the
nominal radius R_0 and the radius R of the touching point at the distance y from the middle of the track,

    xi = (1 + xi_0) R / R_0 - 1 + phi y,    xi_0 = omega R_0 / V - 1,

phi the yaw rate over V, for a yaw to the left positive on the left side, and negative on the right one, like
the lateral creepage upsilon.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from femic.contact.friction.by_angle import Pairs, friction_factors
from femic.contact.friction.kinematics import Creepages
from femic.contact.frictional import FrictionalContact
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.rolling import RollingContact, RollingProblem
from femic.shifts.sides import Place
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import N, S, X

FEWEST = 8  # elements of a grid along x or s


@dataclass(frozen=True)
class Friction:
    """Coefficient of friction, and its factors by the contact angle: pairs of angle [deg] and factor."""

    coefficient: float
    by_angle: Pairs = ()


@dataclass(frozen=True)
class Motion:
    """How a wheelset moves besides rolling, in axes of the track.

    `lateral` is its velocity to the left along the axle over V, minus the yaw to the left where it is small;
    `spin` [1/mm] the yaw rate to the left over V.
    """

    lateral: float = 0.0
    spin: float = 0.0


@dataclass(frozen=True, eq=False)
class WheelContact:
    """A contact of a rolling wheel under a load perpendicular to the axle [N].

    `force` [N] is that on the wheel along x, y, z of the axes of its side, shape (3,); `torque` [N mm] the
    one about the axle against which it has to be driven.
    """

    rolling: RollingContact
    load: float
    force: Array
    torque: float
    vertical: float  # force on the wheel perpendicular to the track [N]


@dataclass(frozen=True, eq=False)
class RollingWheel:
    """One wheel with some ICs on one grid."""

    place: Place
    on_grid: PairOnGrid
    problem: RollingProblem
    motion: Motion

    @classmethod
    def of(
        cls, place: Place, on_grid: PairOnGrid, operator: FullOperator, friction: Friction, motion: Motion
    ) -> "RollingWheel":
        """Return the wheel with some ICs and friction by the contact angle in the track."""
        problem = frictional_problem(on_grid, operator, friction.coefficient)
        if friction.by_angle:
            angle = place.roll - problem.inclination
            problem = replace(problem, factor=friction_factors(friction.by_angle, angle))
        return cls(place, on_grid, rolling_problem(on_grid, problem), motion)

    @property
    def coarsened(self) -> "RollingWheel | None":
        """The wheel on elements twice as large, None where they would be too few."""
        frictional = self.problem.problem
        if not frictional.has_coarser or min(frictional.grid.n_x, frictional.grid.n_s) < 2 * FEWEST:
            return None
        return replace(self, problem=rolling_problem(self.on_grid, frictional.coarsened))

    @property
    def radius(self) -> float:
        """Rolling radius [mm] of the touching point."""
        return self.problem.rolling.radius

    @property
    def side(self) -> int:
        """1 of the left wheel, -1 of the right one."""
        return 1 if self.place.side == "left" else -1

    def creepages(self, xi_0: float) -> Creepages:
        """Return the creepages of the wheel by that of the wheelset at the nominal radius."""
        nominal = sum(self.place.layout.nominal_radius) / 2
        spin = self.side * self.motion.spin
        along = (1 + xi_0) * self.radius / nominal - 1 + spin * float(self.place.touch.point[0])
        return Creepages(along, self.side * self.motion.lateral, spin)

    def contact(self, xi_0: float, load: float, start: FrictionalContact | None) -> WheelContact:
        """Return the contact at a creepage of the wheelset under a load perpendicular to the axle [N].

        Where it is not found from `start`, it is solved anew. Raises as `RollingProblem.contact`.
        """
        creepages, loading = self.creepages(xi_0), Loading(load)
        try:
            rolling = self.problem.contact(creepages, loading, start=start)
        except Failure:
            if start is None:
                raise
            rolling = self.problem.contact(creepages, loading)
        force = rolling.contact.force
        torque = float(np.sum(self.torque_weights * rolling.contact.p))
        return WheelContact(rolling, load, force, torque, self.place.in_track(force)[1])

    def load_for(self, vertical: float, contact: WheelContact) -> float:
        """Return the load perpendicular to the axle [N] that balances a vertical one, by the last contact."""
        roll = self.place.roll
        return float((vertical - contact.force[1] * np.sin(roll)) / np.cos(roll))

    @cached_property
    def torque_weights(self) -> Array:
        """What tractions contribute to the torque about the axle, (n_x, n_s, 3) [mm^3].

        On the circle of radius r = R - z: r along x, and x along z.
        """
        rolling, frictional = self.problem.rolling, self.problem.problem
        sin, cos = rolling.contour.normal(rolling.s)
        parts = np.zeros((*frictional.distance.shape, 3))
        parts[..., X] = rolling.radius - rolling.height
        parts[..., S] = -rolling.x[:, None] * sin
        parts[..., N] = rolling.x[:, None] * cos
        return np.asarray(parts * frictional.grid.area)
