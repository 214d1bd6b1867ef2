"""Two bodies above each other on a grid: undeformed distance, pairing, frictionless contact with any ICs."""

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from approx.pair import Pair
from femic.contact.exact.hertz import combined_modulus
from femic.contact.lateral_force import contact_at_lateral_force
from femic.contact.loading import Loading
from femic.contact.normal import NormalContact, NormalProblem, solve
from femic.contact.operators.approximations import approximate_operator, half_space_operator
from femic.contact.operators.convolution import Convolution
from femic.contact.operators.dense import GridOperator
from femic.contact.operators.protocols import Operator
from femic.contact.patch import Resultant, Section, resultant, section_at
from femic.contact.specification import ContactProblem, ExtraGap
from femic.contact.undeformed import TangentPlane, Undeformed
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid, N
from geometries.surfaces import Surface

RESOLVED = 0.02  # of p_max: what it lacks on strips that are narrow enough
OF_CHANGE = 0.07  # of E* ds dk: what pressures lack where the curvature of the distance changes by dk
EXACT_TOLERANCE = 1e-6  # of the approach where the distance is that of the displaced body, as a share of it
EXACT_STEPS = 30  # largest number
SYMMETRY = 1e-6  # relative difference of mirrored distances that are the same
FIRST_STEP, POSITION = 0.05, 1e-6  # of a lateral movement, and the accuracy of a position, in strips
NEARLY = 0.01  # of a strip: offsets that small are none


@dataclass(frozen=True, eq=False)
class PairOnGrid:
    """The undeformed distance of two bodies on a grid, and all that ICs do not change.

    `extra_gap` is added to their distance.
    `paired` is where the upper body is as far as ICs are concerned, None: where it is.
    """

    pair: Pair
    undeformed: Undeformed | TangentPlane
    grid: Grid
    extra_gap: ExtraGap | None = None
    paired: Undeformed | TangentPlane | None = None

    @property
    def x(self) -> Array:
        """Distances of the elements' centres from the middle along x [mm], shape (n_x,)."""
        n_x = self.grid.n_x
        return np.asarray(self.grid.dx * (np.arange(n_x) - (n_x - 1) / 2))

    @cached_property
    def cosine(self) -> Array:
        """cos(delta) of the strips, shape (n_s,)."""
        return np.cos(self.undeformed.lower.contour.inclination(self.grid.strips))

    def resultant(self, tractions: Array) -> Resultant:
        """Force and moment on the upper body of tractions on the grid [MPa], shape (n_x, n_s, 3)."""
        return resultant(tractions, self._section, self.x, self.grid.area)

    @cached_property
    def _section(self) -> Section:
        """The lower section at the strips."""
        return section_at(self.undeformed.lower.contour, self.grid.strips)

    @property
    def symmetric(self) -> bool:
        """Whether distance and inclination are symmetric about the middle of the grid, to rounding."""
        even = self.distance, self.cosine
        pairs = [(values, values[..., ::-1]) for values in even]
        return all(np.allclose(one, mirrored, rtol=SYMMETRY, atol=0.0) for one, mirrored in pairs)

    @cached_property
    def distance(self) -> Array:
        """Undeformed distance [mm] without approach, shape (n_x, n_s)."""
        return self.distance_at(0.0)

    def distance_at(self, approach: float, lateral: float = 0.0) -> Array:
        """Undeformed distance [mm] with an approach and a lateral movement [mm], shape (n_x, n_s).

        That of the bodies is the same at x and -x.
        """
        ahead = self.x[self.grid.n_x // 2 :, None]
        distance = self.undeformed.distance(ahead, self.grid.strips, approach, lateral)
        behind = distance[::-1][: self.grid.n_x // 2]
        return np.concatenate([behind, distance]) + self._extra

    @cached_property
    def _extra(self) -> Array | float:
        """The gap [mm] that is added, shape (n_x, n_s); 0 without one."""
        return 0.0 if self.extra_gap is None else self.extra_gap.at(self.x[:, None], self.grid.strips[None])

    @cached_property
    def flat(self) -> Convolution:
        """The nn ICs of half-spaces."""
        return half_space_operator(self.pair, self.grid, (N,))

    def operator(self, variant: str) -> Convolution | GridOperator:
        """Return the nn ICs of an approximation."""
        if variant == "A":
            return self.flat
        return approximate_operator(variant, self.pair, self.grid, (N,), upper_offset=self.offset)

    def unresolved(self, approach: float, lateral: float = 0.0) -> Array:
        """Return what pressures lack at strips because the distance changes between these [MPa], (n_s,).

        That is `OF_CHANGE` E* ds dk where the curvature of the distance of the bodies, displaced by an
        approach and a lateral movement [mm], changes by dk from one strip to the next. As this constant of
        order 1 was measured, it is an estimate (docs/theory/errors.md). Without the gap that is added.
        """
        distance = self.undeformed.distance(0.0, self.grid.strips, approach, lateral)
        with np.errstate(invalid="ignore"):
            change = np.abs(np.diff(distance, 3)) / self.grid.ds**2
        change = np.where(np.isfinite(change), change, 0.0)
        modulus = combined_modulus(self.pair.upper.material, self.pair.lower.material)
        beside = np.pad(change, 2)  # strips k and k + 1 are the inner ones of a third difference
        return np.asarray(OF_CHANGE * modulus * self.grid.ds * np.maximum(beside[:-1], beside[1:]))

    @property
    def offset(self) -> float:
        """Arc lengths [mm] of the upper contour less those of the lower one opposite; 0 if nearly so."""
        offset = (self.paired or self.undeformed).upper_offset
        return offset if abs(offset) > NEARLY * self.grid.ds else 0.0

    @property
    def upper_grid(self) -> Grid:
        """The strips opposite, on the upper contour."""
        return replace(self.grid, s=self.grid.s + self.offset)

    def moved_to(self, shift: float) -> "PairOnGrid":
        """Return the upper body moved along y to another position [mm], with the ICs of this one."""
        return replace(
            self, undeformed=self.undeformed.moved_to(shift), paired=self.paired or self.undeformed
        )

    def solve(self, operator: Operator, loading: Loading, *, exact: bool = False) -> "PairContact":
        """Return the contact with nn ICs, in the position given or the one that gives it the lateral force.

        Raises as `solve_in_place`, and Failure where no position has the force.
        """
        if loading.lateral_force is None:
            return PairContact(self, self.solve_in_place(operator, loading, exact=exact))

        def contact_at(shift: float) -> tuple[float, PairContact]:
            moved = self.moved_to(shift)
            contact = PairContact(moved, moved.solve_in_place(operator, loading, exact=exact))
            return contact.lateral_force, contact

        contact, _, stiffness = contact_at_lateral_force(
            contact_at,
            loading.lateral_force,
            start=self.undeformed.shift,
            step=FIRST_STEP * self.grid.ds,
            accuracy=POSITION * self.grid.ds,
        )
        return replace(contact, lateral_stiffness=stiffness)

    def solve_in_place(self, operator: Operator, loading: Loading, *, exact: bool = False) -> NormalContact:
        """Return the contact with nn ICs where the upper body is now, whatever lateral force that needs.

        `exact`: with the distance of the displaced upper body instead of the linearised one. Raises as
        `femic.contact.normal.solve`, and WrongInput where the bodies do not touch.
        """
        if not np.any(np.isfinite(self.distance)):
            raise WrongInput(
                f"contact at {loading}: at a shift of {self.undeformed.shift:g} mm no part of the bodies is "
                f"opposite on s = {self.grid.extent[0]:g} ... {self.grid.extent[1]:g} mm; give another "
                "shift, a smaller lateral_force, or another grid"
            )
        problem = NormalProblem(self.grid, operator, self.flat, self.distance, self.cosine)
        contact = solve(problem, load=loading.load, approach=loading.approach)
        if not contact.in_contact.any():
            raise WrongInput(
                f"contact at {loading}: the bodies do not touch on s = {self.grid.extent[0]:g} ... "
                f"{self.grid.extent[1]:g} mm; give a larger approach, a load, or another grid"
            )
        if not exact:
            return contact
        for _ in range(EXACT_STEPS):  # the fixed point of the distance at the contact's own approach
            before = contact.approach
            distance = self.distance_at(before) + before * self.cosine
            problem = replace(problem, distance=distance)
            contact = solve(problem, load=loading.load, approach=loading.approach, start=contact.p)
            if loading.load is None or abs(contact.approach - before) <= EXACT_TOLERANCE * abs(before):
                return contact
        raise Failure(
            f"contact at {loading}: the approach with the exact distance does not settle "
            f"({before:g}, then {contact.approach:g} mm); use the linearised distance"
        )


@dataclass(frozen=True, eq=False)
class PairContact:
    """A frictionless contact and where its bodies are.

    `lateral_stiffness` [N/mm], against lateral movements, is known where a lateral force was given.
    """

    on_grid: PairOnGrid
    normal: NormalContact
    lateral_stiffness: float = np.inf

    @property
    def lateral_force(self) -> float:
        """Lateral force on the upper body [N]."""
        return float(self.on_grid.resultant(self.normal.tractions).force[1])


def pair_on_grid(problem: ContactProblem, grid: Grid) -> PairOnGrid:
    """Return the bodies of a problem on a grid."""
    return PairOnGrid(problem.pair, undeformed_surfaces(problem), grid, problem.specification.extra_gap)


def undeformed_surfaces(problem: ContactProblem) -> Undeformed:
    """Return the surfaces of a problem, the upper one moved along y as it says.

    Contact is sought to the ends of the contours, and on flanks as far as these.
    """
    lower, upper = problem.bodies["lower"].surface, problem.bodies["upper"].surface
    start, end = lower.contour.limits
    on_flanks = problem.specification.flanks or start == end
    half = max((end - start) / 2, problem.reference_length) if on_flanks else 0.0
    low, high = problem.extent
    s_range = max(low, start - half), min(high, end + half)
    return _undeformed(upper, lower, s_range, problem.specification.shift)


@lru_cache(maxsize=16)
def _undeformed(upper: Surface, lower: Surface, s_range: tuple[float, float], shift: float) -> Undeformed:
    """Return the surfaces, the same object each time: the point of first contact is found once."""
    return Undeformed(upper, lower, s_range, shift)
