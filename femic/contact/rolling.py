"""Contact with friction in rolling, from rest or steady, and in compression by steps of the load.

A wheel rolls on a rail at given creepages, or at those that follow from given forces. Transient rolling
begins at rest and proceeds in steps of one element.

In steady rolling the elastic energy does not change, so all work of the tractions on the rigid motion is lost
to friction. Pressures do work, too: the wheel comes down ahead of the contact centre and rises behind it, and
where tractions along x cause displacements along n, pressures ahead and behind differ. With reciprocal ICs
that depend on the lag along x alone, the sum of p . du/dx vanishes; where the gap is closed, du_n/dx =
-dh/dx, h the undeformed distance. So

    sum -p_t . slip = sum (-p_t . w_t + p_n dh/dx),

and a wheel that rotates as a rigid body has dh/dx = -w_n, nearly x cos(delta) / R.

In compression the bodies are pressed on each other in steps, without rolling. A vertical approach moves
surfaces on inclined places along s, so that they slip or stick there even where bodies are of equal material.
Each step is a shift from the displacements of the step before.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from femic.contact.estimates import Places
from femic.contact.friction.motion import (
    NAMES,
    Creepages,
    FreeSlip,
    RollingKinematics,
    RollingStep,
    Shift,
    SteadyRolling,
)
from femic.contact.frictional import TOLERANCE, FrictionalContact, solve
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N

# --- rolling ---


@dataclass(frozen=True, eq=False)
class RollingContact:
    """A contact in steady rolling and the creepages at which it rolls.

    `simplified` says whether it has a solution in a less accurate form only than the specified order;
    `prescribed` are the names of the creepages that follow from prescribed forces.
    """

    contact: FrictionalContact
    creepages: Creepages
    simplified: bool = False
    prescribed: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class RollingProblem:
    """A contact with friction, and where its wheel rolls."""

    problem: FrictionalProblem
    rolling: RollingKinematics
    order: int = 2

    def contact(
        self,
        creepages: Creepages,
        loading: Loading,
        *,
        forces: Mapping[str, float] = MappingProxyType({}),
        start: FrictionalContact | None = None,
        tolerance: float = TOLERANCE,
    ) -> RollingContact:
        """Return the contact in steady rolling.

        `forces` [N, for spin N mm] are prescribed forces on the upper body by the names of the creepages that
        follow from them: longitudinal for F_x, lateral for F_y, spin for M_z about the contact centre. The
        values in `creepages` are then the first guess. Raises as `solve`, and WrongInput for other
        names.
        """
        if unknown := set(forces) - set(NAMES):
            raise WrongInput(f"forces of {', '.join(sorted(unknown))}: creepages are {', '.join(NAMES)}")
        free = tuple(
            FreeSlip(self.rolling.per_creepage(name), self.weights[name], force)
            for name, force in forces.items()
        )
        rigid = self.rolling.rigid_slip(creepages)
        motion = SteadyRolling(rigid, free, dx=self.problem.grid.dx, order=self.order)
        contact = solve(self.problem, motion, loading, start=start, tolerance=tolerance)
        solved = {
            name: getattr(creepages, name) + amplitude
            for name, amplitude in zip(forces, contact.amplitudes, strict=True)
        }
        simplified = contact.motion.depth < motion.depth
        return RollingContact(contact, replace(creepages, **solved), simplified, tuple(forces))

    def at_rest(self, loading: Loading) -> FrictionalContact:
        """Return the contact of a wheel that was pressed on without tangential tractions.

        Raises as `solve`.
        """
        still = np.zeros((*self.problem.distance.shape, 2))
        pressed = solve(replace(self.problem, friction=0.0), Shift(still), loading)
        return solve(self.problem, Shift(still, before=pressed.u[..., :2]), loading, start=pressed)

    def transient(self, creepages: Creepages, loading: Loading, steps: int) -> Iterator[RollingContact]:
        """Yield the contact at rest, then after each step of rolling by the length of an element.

        Raises as `solve`.
        """
        rigid, dx = self.rolling.rigid_slip(creepages), self.problem.grid.dx
        contact = self.at_rest(loading)
        yield RollingContact(contact, creepages)
        for _ in range(steps):
            step = RollingStep(rigid, dx=dx, order=self.order, before=contact.u[..., :2])
            contact = solve(self.problem, step, loading, start=contact)
            yield RollingContact(contact, creepages, contact.motion.depth < step.depth)

    def power(self, rolling: RollingContact) -> float:
        """Work of the tractions on the rigid motion per unit of rolled distance, - sum p . w area [N].

        It is the torque about the axle times (1 + xi) / R less F_x, lateral F_y and spin M_z: what drives the
        wheel less what it gives away. Less `climbing` it is the work that friction takes, but for shares of
        the pressures' work as small as creepages and height over radius; with ICs of `operators.rolled` also
        but for the sum of p_x u_z / R, which is the torque about the axle of tractions on a raised surface.
        """
        velocity = self.rolling.rigid_velocity(rolling.creepages)
        return -float(np.sum(rolling.contact.p * velocity)) * self.problem.grid.area

    def climbing(self, rolling: RollingContact) -> float:
        """That part of `power` [N] with which lateral velocity and spin press inclined surfaces together.

        The distance of a wheel at zero yaw does not follow this motion. So it is not lost to friction: while
        a wheel moves aside, it is raised along a flank, and the contact is steady at each moment only.
        """
        turning = replace(rolling.creepages, lateral=0.0, spin=0.0)
        moves, turns = (
            self.rolling.rigid_velocity(creepages)[..., N] for creepages in (rolling.creepages, turning)
        )
        return -float(np.sum(rolling.contact.p[..., N] * (moves - turns))) * self.problem.grid.area

    def missed_work(self, rolling: RollingContact) -> float:
        """By how much the work of friction on the slip differs from that on the rigid motion [N].

        Both are the same in the limit of small elements, but for what `power` says.
        """
        on_slip = float(np.sum(rolling.contact.dissipation)) * self.problem.grid.area
        return abs(self.power(rolling) - self.climbing(rolling) - on_slip)

    @cached_property
    def weights(self) -> Mapping[str, Array]:
        """What tractions contribute to the forces of each creepage, shape (n_x, n_s, 3) [mm^2, spin mm^3]."""
        sin, cos = np.sin(self.problem.inclination), np.cos(self.problem.inclination)
        y, z = self.rolling.contour.position(self.rolling.s)
        levers = Places(self.rolling.x, y, z, sin, cos, self.problem.grid.area).levers
        return dict(zip(NAMES, (levers["longitudinal"], levers["lateral"], levers["about_z"]), strict=True))


# --- compression ---


def compressed(problem: FrictionalProblem, steps: Sequence[Loading]) -> Iterator[FrictionalContact]:
    """Yield the contact after each of some steps of vertical load or approach, from none on.

    Elements that come into contact in a step slip from where they were before it: the error is of the first
    order in the steps. Raises WrongInput for no steps, and otherwise as `solve`.
    """
    if not steps:
        raise WrongInput("steps of the load: give one at least")
    sines, none = np.sin(problem.inclination), np.zeros((*problem.distance.shape, 2))
    motion, contact = Shift(none, per_approach=sines), None
    for step in steps:
        contact = solve(problem, motion, step, start=contact)
        yield contact
        motion = Shift(none, before=contact.u[..., :2], per_approach=sines, approach_before=contact.approach)
