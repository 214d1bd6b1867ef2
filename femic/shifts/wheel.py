"""One wheel of a rolling wheelset with some ICs: its creepages, its patches, forces and torque.

Axes are those of the side, parallel to the axle: x ahead, y to the field side, z up; the right side is the
mirror image of a left one. With the angular velocity omega of the axle, the speed V along the track, the
nominal radius R_0 of the wheel and the radius R of the touching point at the distance y from the middle of
the track,

    xi = (1 + xi_0) R / R_0 - 1 + phi y,    xi_0 = omega R_0 / V - 1,

phi the yaw rate over V, for a yaw to the left positive on the left side, and negative on the right one, like
the lateral creepage upsilon. All patches of a wheel roll with the same motion of the wheel, under one
approach; each slips as its own circles and inclinations have it. The distance is that of the displaced wheel
at an approach nearby, `about`, and the pressures of other patches displace a patch as they do without
friction (`femic.contact.pairs.areas`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from femic.contact.friction.motion import Creepages, friction_factors
from femic.contact.frictional import FrictionalContact
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.areas import AreasContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import frictional_problem, rolling_problem
from femic.contact.patch import block_mean
from femic.contact.rolling import RollingContact, RollingProblem
from femic.shifts.sides import Place
from femic.shifts.specification import RollingTable
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import N, S, X

FEWEST = 8  # elements of a grid along x or s
POINT_CONTACT = 1.5  # of load over approach: the stiffness of a contact of Hertz
STIFFEST = 4.0  # of the same: the largest one that is believed, and its inverse the least


class PatchBeyondGrid(Failure):
    """A patch of a wheel in a `place` comes near the end of the grid with this `number`."""

    def __init__(self, place: Place, number: int, short: PotentialAreaTooSmall) -> None:
        super().__init__(str(short))
        self.place, self.number, self.short = place, number, short


@dataclass(frozen=True, eq=False)
class WheelContact:
    """The patches of a rolling wheel under one approach [mm].

    `force` [N] is that on the wheel along x, y, z of the axes of its side, shape (3,); `torque` [N mm] the
    one about the axle against which it has to be driven; `vertical` [N] the force on the wheel perpendicular
    to the track, `stiffness` [N/mm] its derivative by the approach.
    """

    patches: tuple[RollingContact, ...]
    approach: float
    force: Array
    torque: float
    vertical: float
    stiffness: float

    @property
    def states(self) -> list[FrictionalContact]:
        """The contacts with friction."""
        return [patch.contact for patch in self.patches]

    @property
    def creepages(self) -> Creepages:
        """Creepages at the touching point."""
        return self.patches[0].creepages

    @property
    def finer(self) -> "WheelContact":
        """The contact whose tractions are those on elements half as large: a first guess there."""
        finer = [
            replace(patch, contact=replace(state, p=state.p.repeat(2, axis=0).repeat(2, axis=1)))
            for patch, state in zip(self.patches, self.states, strict=True)
        ]
        return replace(self, patches=tuple(finer))


@dataclass(frozen=True, eq=False)
class RollingWheel:
    """One wheel with some ICs on the grids of its patches; distances are those about an approach [mm].

    It was `pressed` on without friction. `doublings` says how often elements were made twice as large.
    """

    place: Place
    on_grids: tuple[PairOnGrid, ...]
    problems: tuple[RollingProblem, ...]
    about: float
    motion: RollingTable
    pressed: AreasContact
    doublings: int = 0

    @classmethod
    def on_areas(
        cls, place: Place, pressed: AreasContact, operators: Sequence[FullOperator], motion: RollingTable
    ) -> "RollingWheel":
        """Return a wheel that was `pressed` on without friction, with ICs on the grids of its areas."""
        problems = []
        for on_grid, operator in zip(pressed.areas.on_grids, operators, strict=True):
            problem = frictional_problem(on_grid, operator, motion.friction)
            if motion.by_angle:
                angle = place.roll - problem.inclination
                problem = replace(problem, factor=friction_factors(motion.by_angle, angle))
            problems.append(rolling_problem(on_grid, problem))
        wheel = cls(place, pressed.areas.on_grids, tuple(problems), 0.0, motion, pressed)
        return wheel.linearised_about(pressed.approach)

    def linearised_about(self, approach: float) -> "RollingWheel":
        """Return the wheel with the distances of one that is displaced by an approach [mm]."""
        distances = zip(self.pressed.areas.distances_at(approach), self.pressed.displacements(), strict=True)
        problems = []
        for problem, (own, by_others) in zip(self.problems, distances, strict=True):
            distance = own + by_others
            for _ in range(self.doublings):
                distance = block_mean(distance)
            problems.append(replace(problem, problem=replace(problem.problem, distance=distance)))
        return replace(self, problems=tuple(problems), about=approach)

    @property
    def coarsened(self) -> "RollingWheel | None":
        """The wheel on elements twice as large, None where they would be too few."""
        frictional = [problem.problem for problem in self.problems]
        if not all(
            each.has_coarser and min(each.grid.n_x, each.grid.n_s) >= 2 * FEWEST for each in frictional
        ):
            return None
        pairs = zip(self.on_grids, frictional, strict=True)
        problems = tuple(rolling_problem(on_grid, each.coarsened) for on_grid, each in pairs)
        return replace(self, problems=problems, doublings=self.doublings + 1)

    @property
    def radius(self) -> float:
        """Rolling radius [mm] of the touching point."""
        return self.problems[0].rolling.radius

    @property
    def nominal_radius(self) -> float:
        """Mean nominal radius [mm] of the wheelset."""
        return sum(self.place.layout.nominal_radius) / 2

    def creepages(self, xi_0: float) -> Creepages:
        """Return the creepages of the wheel by that of the wheelset at the nominal radius."""
        side = 1 if self.place.side == "left" else -1
        spin = side * self.motion.spin
        along = (1 + xi_0) * self.radius / self.nominal_radius - 1 + spin * float(self.place.touch.point[0])
        return Creepages(along, side * self.motion.lateral, spin)

    def contact(self, xi_0: float, approach: float, start: WheelContact | None) -> WheelContact:
        """Return the contact at a creepage of the wheelset under an approach [mm].

        Where it is not found from `start`, it is solved anew. Raises as `RollingProblem.contact`, and
        `PatchBeyondGrid`.
        """
        creepages, loading = self.creepages(xi_0), Loading(approach=approach - self.about)
        patches = []
        for number, problem in enumerate(self.problems):
            try:
                try:
                    guess = None if start is None else start.states[number]
                    patch = problem.contact(creepages, loading, start=guess)
                except PotentialAreaTooSmall:
                    raise
                except Failure:
                    if start is None:
                        raise
                    patch = problem.contact(creepages, loading)
            except PotentialAreaTooSmall as short:
                raise PatchBeyondGrid(self.place, number, short) from short
            patches.append(patch)
        force = np.sum([patch.contact.force for patch in patches], axis=0)
        torque = sum(
            float(np.sum(weights * patch.contact.p))
            for weights, patch in zip(self.torque_weights, patches, strict=True)
        )
        vertical = self.place.in_track(force)[1]
        stiffness = POINT_CONTACT * vertical / approach
        if start is not None and abs(approach - start.approach) > 1e-6 * approach:
            secant = (vertical - start.vertical) / (approach - start.approach)
            stiffness = float(np.clip(secant, stiffness / STIFFEST, stiffness * STIFFEST))
        elif start is not None:
            stiffness = start.stiffness
        return WheelContact(tuple(patches), approach, force, torque, vertical, stiffness)

    def approach_for(self, vertical: float, contact: WheelContact) -> float:
        """Return the approach [mm] that balances a vertical load [N], by the last contact."""
        return contact.approach + (vertical - contact.vertical) / contact.stiffness

    @cached_property
    def torque_weights(self) -> list[Array]:
        """What tractions contribute to the torque about the axle, (n_x, n_s, 3) [mm^3] of each patch.

        On the circle of radius r = R - z: r along x, and x along z.
        """
        weights = []
        for problem in self.problems:
            rolling, frictional = problem.rolling, problem.problem
            sin, cos = rolling.contour.normal(rolling.s)
            parts = np.zeros((*frictional.distance.shape, 3))
            parts[..., X] = rolling.radius - rolling.height
            parts[..., S] = -rolling.x[:, None] * sin
            parts[..., N] = rolling.x[:, None] * cos
            weights.append(np.asarray(parts * frictional.grid.area))
        return weights
