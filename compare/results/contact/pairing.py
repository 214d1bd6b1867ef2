"""The bodies of a scene above each other: undeformed distance, and contact problems on grids."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import griddata

from approx.pair import Pair
from compare.scenes.scene import Scene
from contact.normal import NormalContact, NormalProblem, Operator, solve
from contact.operators.convolution import Convolution
from contact.operators.turned import turned
from contact.undeformed import Undeformed
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.grids import Grid
from geometries.patches import N

EXACT_TOLERANCE = 1e-6  # of the approach where the distance is that of the displaced body, as a share of it
EXACT_STEPS = 30  # largest number
NEARLY = 0.01  # of a strip: offsets that small are none


@dataclass(frozen=True)
class Case:
    """What is given: a vertical load [N], or an approach [mm]."""

    load: float | None
    approach: float | None

    def __str__(self) -> str:
        return f"{self.load:g} N" if self.load is not None else f"{self.approach:g} mm"


@dataclass(frozen=True, eq=False)
class Placed:
    """The undeformed distance of two bodies on a grid, and all that ICs do not change.

    `extra_gap` are points x, s and the gap [mm] that is added to their distance there, linear between them.
    """

    pair: Pair
    undeformed: Undeformed
    grid: Grid
    extra_gap: tuple[tuple[float, ...], ...] = ()

    @property
    def x(self) -> Array:
        """Distances of the elements' centres from the middle along x [mm], shape (n_x,)."""
        n_x = self.grid.n_x
        return np.asarray(self.grid.dx * (np.arange(n_x) - (n_x - 1) / 2))

    @cached_property
    def cosine(self) -> Array:
        """cos(delta) of the strips, shape (n_s,)."""
        return np.cos(self.undeformed.lower.contour.inclination(self.grid.strips))

    @property
    def motions(self) -> Array:
        """Normal components of rigid motions: along z, along y, and about the contact centre, (3, n_s).

        That of the rotation is the distance over the largest one.
        """
        sin, cos = self.undeformed.lower.contour.normal(self.grid.strips)
        y, z = self.undeformed.lower.contour.position(self.grid.strips)
        turned = z * sin - y * cos
        return np.stack([cos, sin, turned / max(float(np.max(np.abs(turned))), 1e-300)])

    @cached_property
    def distance(self) -> Array:
        """Undeformed distance [mm] without approach, shape (n_x, n_s)."""
        return self.distance_at(0.0)

    def distance_at(self, approach: float) -> Array:
        """Undeformed distance [mm] with an approach [mm], shape (n_x, n_s).

        That of the bodies is the same at x and -x.
        """
        ahead = self.x[self.grid.n_x // 2 :, None]
        distance = self.undeformed.distance(ahead, self.grid.strips, approach)
        behind = distance[::-1][: self.grid.n_x // 2]
        return np.concatenate([behind, distance]) + self._extra

    @cached_property
    def _extra(self) -> Array | float:
        """The gap [mm] that is added, shape (n_x, n_s); 0 without one, and beyond its points."""
        if not self.extra_gap:
            return 0.0
        x, s, gap = np.array(self.extra_gap).T
        places = self.x[:, None], self.grid.strips[None]
        return np.asarray(griddata((x, s), gap, places, method="linear", fill_value=0.0))

    @cached_property
    def flat(self) -> Convolution:
        """The nn ICs of half-spaces."""
        return turned("A", self.pair, self.grid, (N,))

    def operator(self, variant: str) -> Convolution:
        """The nn ICs of an approximation."""
        if variant == "A":
            return self.flat
        return turned(variant, self.pair, self.grid, (N,), upper_offset=self.offset)

    @property
    def offset(self) -> float:
        """Arc lengths [mm] of the upper contour less those of the lower one opposite; 0 if nearly so."""
        offset = self.undeformed.upper_offset
        return offset if abs(offset) > NEARLY * self.grid.ds else 0.0

    @property
    def upper_grid(self) -> Grid:
        """The strips opposite, on the upper contour."""
        return replace(self.grid, s=self.grid.s + self.offset)

    def contact(self, operator: Operator, case: Case, *, exact: bool = False) -> NormalContact:
        """The contact with nn ICs; `exact`: with the distance of the displaced upper body, not linearised.

        Raises as `contact.normal.solve`, and WrongInput where the bodies do not touch.
        """
        problem = NormalProblem(self.grid, operator, self.flat, self.distance, self.cosine)
        contact = solve(problem, load=case.load, approach=case.approach)
        if not contact.in_contact.any():
            raise WrongInput(
                f"contact at {case}: the bodies do not touch on s = {self.grid.extent[0]:g} ... "
                f"{self.grid.extent[1]:g} mm; give a larger approach, a load, or another grid"
            )
        return self._displaced(contact, case) if exact else contact

    def _displaced(self, contact: NormalContact, case: Case) -> NormalContact:
        """The contact with the distance at its own approach: a fixed point."""
        for _ in range(EXACT_STEPS):
            before = contact.approach
            distance = self.distance_at(before) + before * self.cosine
            problem = NormalProblem(self.grid, contact.problem.operator, self.flat, distance, self.cosine)
            contact = solve(problem, load=case.load, approach=case.approach, start=contact.p)
            if case.load is None or abs(contact.approach - before) <= EXACT_TOLERANCE * abs(before):
                return contact
        raise Failure(
            f"contact at {case}: the approach with the exact distance does not settle "
            f"({before:g}, then {contact.approach:g} mm); use the linearised distance"
        )


def placed_on(scene: Scene, grid: Grid) -> Placed:
    """The bodies of a scene on a grid."""
    return Placed(scene.pair, undeformed_of(scene), grid, scene.contact.extra_gap)


def undeformed_of(scene: Scene) -> Undeformed:
    """The surfaces of a scene, the upper one moved along y as it says."""
    lower, upper = scene.bodies["lower"].surface, scene.bodies["upper"].surface
    return Undeformed(upper, lower, _reach(scene), scene.contact.shift)


def _reach(scene: Scene) -> tuple[float, float]:
    """Arc lengths [mm] between which contact is sought: to the contours' ends, on flanks as far as these."""
    start, end = scene.bodies["lower"].contour.limits
    half = max((end - start) / 2, scene.reference_length) if scene.contact.flanks or start == end else 0.0
    low, high = scene.extent
    return max(low, start - half), min(high, end + half)
