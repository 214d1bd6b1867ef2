"""Contact with friction on a curvilinear grid: normal and tangential tractions, with any ICs.

Both are sought at once (`femic.contact.coupled`), beginning with the contact on elements twice as large, or
with a given one. Where there is none to begin with, or it does not lead to the contact, pressures for given
tangential tractions (`femic.contact.normal`) and tangential tractions for given pressures
(`femic.contact.friction.coulomb`) are found in turn until neither changes (Panagiotopoulos 1975,
Ingenieur-Archiv 44, 421-432): ICs couple both, bounds are friction times pressure, and tangential tractions
on inclined places carry load. Where tractions of an element oscillate, as at edges with large friction, its
steps become smaller.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from femic.contact import coupled
from femic.contact.compiled import TINY
from femic.contact.coupled import Coupled, State
from femic.contact.estimates import SlipState
from femic.contact.friction import coulomb
from femic.contact.friction.coulomb import Coulomb, ForcesBeyondFriction, FreeAmplitudes, Tangential
from femic.contact.friction.motion import LeadingEdge, Motion
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall, pressures
from femic.contact.patch import Box, Extent, extents, in_global_axes, near_ends
from femic.contact.small import Guess, solve_frictional
from geometries.arrays import Array, Mask
from geometries.errors import Failure
from geometries.patches import N, S

# of pressures over the largest one; of tangential tractions over the largest friction bound, if this is less
TOLERANCE = 1e-6
MOST_TURNS = 200  # of normal and tangential problem
AT_ONCE_AFTER = 2, 5, 20  # turns: both problems at once are tried again
FIRST_CHANGE = 0.1  # assumed before the first turn
UNDAMPED_TURNS = 5  # after these, elements whose tractions oscillate take a share of the steps
BACK, ON = 0.7, 1.1  # factors of this share
LEAST_PRESSED = 0.05  # share of a load that tangential tractions on inclined places must leave to pressures
SHARPER = 0.1  # tolerance of each problem over the last change
COARSEST = 16  # elements along x or s below which the solution does not begin on a coarser grid
ROOM_KEPT = 2  # elements beside a contact in a box
COARSE_TOLERANCE = 1e-4  # of contacts on coarser grids


@dataclass(frozen=True, eq=False)
class FrictionalContact:
    """Tractions on the upper body [MPa], (n_x, n_s, 3), and what follows from them.

    `slip` (n_x, n_s, 2) is that of the upper over the lower surface, per unit of rolled distance or [mm] of a
    shift; `stick` (n_x, n_s) are the elements that stick; `coarser` is the same contact on elements twice as
    large, None where there is none.
    """

    problem: FrictionalProblem
    motion: Motion
    p: Array
    u: Array
    gap: Array
    approach: float
    tangential: Tangential
    turns: int  # of the normal and the tangential problem, 0 where both were solved at once from the guess
    coarser: "FrictionalContact | None" = None

    @property
    def amplitudes(self) -> Array:
        """Amplitudes of the free modes of the motion, shape (k,)."""
        return self.tangential.amplitudes

    @property
    def pressures(self) -> Array:
        """Pressures [MPa], shape (n_x, n_s)."""
        return np.asarray(self.p[..., N])

    @property
    def tractions(self) -> Array:
        """Tractions on the upper body [MPa], shape (n_x, n_s, 3)."""
        return self.p

    @property
    def in_contact(self) -> Mask:
        """The elements in contact, shape (n_x, n_s)."""
        return self.p[..., N] > 0

    @property
    def slip(self) -> Array:
        """Slip at the centres of elements, shape (n_x, n_s, 2); 0 where they stick and outside contact."""
        slips = self.in_contact & ~self.stick
        return np.where(slips[..., None], self.tangential.slip, 0.0)

    @property
    def stick(self) -> Mask:
        """The elements that stick, shape (n_x, n_s)."""
        return self.tangential.stick

    @property
    def force(self) -> Array:
        """Force on the upper body along x, y, z [N], shape (3,)."""
        along = in_global_axes(self.p, np.sin(self.problem.inclination), np.cos(self.problem.inclination))
        return np.array([np.sum(part) for part in along]) * self.problem.grid.area

    @property
    def area(self) -> float:
        """Contact area [mm^2]."""
        return float(np.count_nonzero(self.in_contact) * self.problem.grid.area)

    @property
    def sliding_share(self) -> float:
        """Area of slip over the area of contact."""
        slips = np.count_nonzero(self.in_contact & ~self.stick)
        return float(slips / max(int(np.count_nonzero(self.in_contact)), 1))

    @property
    def dissipation(self) -> Array:
        """Work of friction per area: - p . slip [MPa times the unit of slip], (n_x, n_s).

        It is not negative but on elements whose tractions follow others (`LeadingEdge`).
        In steady rolling its sum tends, with smaller elements, to the work of the tractions on the rigid
        motion, the pressures' included (`femic.contact.rolling`).
        """
        return np.asarray(-np.sum(self.p[..., :2] * self.slip, axis=-1))

    @property
    def largest_work(self) -> float:
        """Work of friction if the whole contact slid with the rigid slip, or its own work if more.

        In N times the unit of slip.
        """
        rigid, area = self.motion.rigid, self.problem.grid.area
        for free, amplitude in zip(self.motion.free, self.amplitudes, strict=True):
            rigid = rigid + amplitude * free.slip
        bound = self.problem.bound(self.p[..., N]) * area
        own = float(np.sum(self.dissipation) * area)
        return max(float(np.sum(bound * np.linalg.norm(rigid, axis=-1))), own)

    @property
    def slip_state(self) -> SlipState:
        """Tractions, and where they stick or slip."""
        edge = LeadingEdge.find(self.problem.bound(self.p[..., N]), self.motion.depth)
        return SlipState(self.p, self.stick, self.slip, self.problem.coefficients, edge.behind)

    @cached_property
    def patches(self) -> list[Extent]:
        """The contact patches, from the left to the right."""
        return extents(self.p[..., N], self.gap)


def solve(
    problem: FrictionalProblem,
    motion: Motion,
    loading: Loading,
    *,
    start: FrictionalContact | None = None,
    tolerance: float = TOLERANCE,
) -> FrictionalContact:
    """Return the contact after a motion.

    `start` is an initial guess; without one the solution begins on coarser grids, where the motion has a form
    on these.

    Raises WrongInput for bad input, and Failure as `normal.pressures` and `coulomb.tractions` do, where both
    do not agree after `MOST_TURNS`, and where the contact comes too near to an end of the grid.
    """
    contact = _Solution(problem, motion, loading, tolerance).from_start(start)
    if ends := near_ends(contact.in_contact, problem.margin):
        raise PotentialAreaTooSmall(ends, loading)
    return contact


@dataclass(frozen=True, eq=False)
class _Solution:
    """How a contact is found."""

    problem: FrictionalProblem
    motion: Motion
    loading: Loading
    tolerance: float

    def from_start(self, start: FrictionalContact | None) -> FrictionalContact:
        """Return the contact, from one to begin with, or from those on coarser grids."""
        if contact := self.in_compiled_loops(start):
            return contact
        if start is not None:
            same = len(start.amplitudes) == len(self.motion.free)
            amplitudes = start.amplitudes if same else np.zeros(len(self.motion.free))
            return self.robustly(Guess(start.p, amplitudes, start.approach))
        coarser = self.coarser()
        if coarser is None:
            nothing = np.zeros((*self.problem.distance.shape, 3))
            return self.robustly(Guess(nothing, np.zeros(len(self.motion.free)), 0.0))
        p = coarser.p.repeat(2, axis=0).repeat(2, axis=1)
        contact = self.robustly(Guess(p, coarser.amplitudes, coarser.approach))
        return replace(contact, coarser=coarser)

    def in_compiled_loops(self, start: FrictionalContact | None) -> FrictionalContact | None:
        """Return the contact on a small grid, None where it is large, or the contact is not found."""
        problem, motion, small, begin = self.problem, self.motion, self.problem.small, None
        if small is None or (motion.free and not np.any(problem.coefficients)):
            return None
        if start is not None and np.any(start.pressures > 0):
            same = len(start.amplitudes) == len(motion.free)
            amplitudes = start.amplitudes if same else np.zeros(len(motion.free))
            begin = Guess(start.p, amplitudes, start.approach)
        found = solve_frictional(small, motion, self.loading, begin, self.tolerance)
        if found is None or self.share_of_pressures(found.p) < LEAST_PRESSED:
            return None
        p, u, slip, stick, amplitudes, approach = found
        gap = u[..., N] + problem.distance - approach * np.cos(problem.inclination)
        tangential = Tangential(p[..., :N], motion.at_elements(slip), stick, amplitudes)
        gap = np.where(p[..., N] > 0, 0.0, gap)
        return FrictionalContact(problem, motion, p, u, gap, approach, tangential, turns=0)

    def coarser(self) -> FrictionalContact | None:
        """Return the contact on elements twice as large, None where it has no solution or is not possible."""
        sizes = self.problem.grid.n_x, self.problem.grid.n_s
        if min(sizes) < 2 * COARSEST or not (self.problem.normal.has_coarser and self.motion.has_coarser):
            return None
        tolerance = max(self.tolerance, COARSE_TOLERANCE)
        solution = _Solution(self.problem.coarsened, self.motion.coarsened(), self.loading, tolerance)
        try:
            return solution.from_start(None)
        except Failure:
            return None

    def robustly(self, guess: Guess) -> FrictionalContact:
        """Return the contact, with the motion in a simpler form if it is not found in its own."""
        try:
            return self.at_once(guess) or self.in_turns(guess)
        except ForcesBeyondFriction:
            raise
        except Failure:
            if self.motion.simpler is None:
                raise
        return replace(self, motion=self.motion.simpler).robustly(guess)

    def at_once(self, guess: Guess) -> FrictionalContact | None:
        """Return the contact by Newton's method for all tractions, None where a guess does not lead to it.

        It is sought near the guess, and on the whole grid if it is not confined to a box there.
        """
        if not np.any(guess.p[..., N] > 0):
            return None
        whole = Box.whole(guess.p.shape)
        for box in (Box.around(guess.p[..., N] > 0), whole):
            system = Coupled(self.problem.within(box), self.motion.within(box), self.loading)
            solution = coupled.solve(system, replace(guess, p=box.crop(guess.p)), self.tolerance)
            if solution is None:
                return None
            contact = self.on_grid(solution, box)
            if box == whole or (box.confines(contact.in_contact, ROOM_KEPT) and np.all(contact.gap >= 0)):
                return contact if self.share_of_pressures(contact.p) >= LEAST_PRESSED else None
            guess = Guess(contact.p, contact.amplitudes, contact.approach)
        return None

    def on_grid(self, solution: State, box: Box) -> FrictionalContact:
        """Return a contact in a box as one on the whole grid."""
        problem, shape = self.problem, self.problem.distance.shape
        p, slip = box.embed(solution.p, shape), box.embed(solution.law.centred, shape)
        stick = solution.edge.with_followers(solution.law.stick)
        u = problem.operator(p)
        gap = u[..., N] + problem.distance - solution.approach * np.cos(problem.inclination)
        gap = np.where(p[..., N] > 0, 0.0, gap)
        tangential = Tangential(p[..., :N], slip, box.embed(stick, shape), solution.c)
        return FrictionalContact(problem, self.motion, p, u, gap, solution.approach, tangential, turns=0)

    def in_turns(self, guess: Guess) -> FrictionalContact:
        """Return the contact at which neither problem changes the other."""
        p, amplitudes = guess.p, guess.amplitudes
        largest = max(float(np.max(self.problem.coefficients)), 1.0)
        change, sharpest = FIRST_CHANGE, SHARPER / largest  # of bounds, too
        share, last_step = np.ones((*self.problem.distance.shape, 1)), np.zeros_like(p[..., :N])
        for turn in range(1, MOST_TURNS + 1):
            before, sharp = p, sharpest * max(min(change, FIRST_CHANGE), self.tolerance)
            p, approach, gap = self.pressed(p, sharp)
            tangential = self.slipped(p, approach, amplitudes, sharp)
            p, amplitudes = _joined(tangential.p, p), tangential.amplitudes
            peak, limit = self.problem.scales(p[..., N])
            change = float(np.max(np.abs(p - before) / np.maximum([limit, limit, peak], TINY)))
            pressed_too_little = self.share_of_pressures(p) < LEAST_PRESSED
            if (max(change, sharp) <= self.tolerance and not pressed_too_little) or not np.any(p):
                u = self.fast.operator(p)
                return FrictionalContact(self.problem, self.motion, p, u, gap, approach, tangential, turn)
            if turn in AT_ONCE_AFTER and (contact := self.at_once(Guess(p, amplitudes, approach))):
                return replace(contact, turns=turn)
            step = (p - before)[..., :N]
            if turn > UNDAMPED_TURNS:  # smaller where a step goes back on the last one, else larger
                back = np.sum(step * last_step, axis=-1, keepdims=True) < 0
                share = np.where(back, BACK * share, np.minimum(ON * share, 1.0))
            last_step = step
            p = _joined(before[..., :N] + share * step, p)
        if pressed_too_little:
            raise Failure(
                "contact with friction: tangential tractions on inclined parts carry almost the whole "
                "load and leave little pressure; use a larger load, smaller creepages or less friction"
            )
        raise Failure(
            f"contact with friction: pressures and tangential tractions still change by {change:.1e} of "
            f"the largest pressure or bound after {MOST_TURNS} iterations, not {self.tolerance:.1e}; use "
            "smaller steps of load or less friction"
        )

    @property
    def fast(self) -> FrictionalProblem:
        """The problem with ICs in the form whose products are fastest."""
        return self.problem.within(Box.whole(self.problem.distance.shape))

    def share_of_pressures(self, p: Array) -> float:
        """Return the share of the load that tangential tractions on inclined places leave to pressures."""
        load = self.loading.load
        carried = np.sum(p[..., S] * np.sin(self.problem.inclination)) * self.problem.grid.area
        return 1.0 if load is None else 1.0 + float(carried) / load

    def pressed(self, p: Array, tolerance: float) -> tuple[Array, float, Array]:
        """Return tractions with new pressures, the approach, and gaps."""
        problem, bounded = self.fast, self.fast.normal.bounded
        bounded = replace(bounded, h=bounded.h + problem.operator(p * [1.0, 1.0, 0.0])[..., N])
        load = self.loading.load
        if load is not None:
            load *= max(self.share_of_pressures(p), LEAST_PRESSED) / problem.grid.area
        solution = pressures(
            bounded, load=load, approach=self.loading.approach, start=p[..., N], tolerance=tolerance
        )
        gap = np.where(solution.p > 0, 0.0, solution.gap)
        return _joined(p, solution.p[..., None]), solution.approach, gap

    def slipped(self, p: Array, approach: float, amplitudes: Array, tolerance: float) -> Tangential:
        """Return the tangential tractions for given pressures."""
        problem, motion = self.fast, self.motion
        bound = problem.bound(p[..., N])
        by_pressures = problem.operator(p * [0.0, 0.0, 1.0])[..., :N]
        weights = np.reshape([free.weights for free in motion.free], (-1, *p.shape))
        targets = np.array([free.force for free in motion.free]) - np.tensordot(weights[..., N], p[..., N], 2)
        law = Coulomb(
            lambda q: motion.elastic_slip(problem.tangential(q)),
            problem.strips(motion),
            motion.given_at(approach) + motion.elastic_slip(by_pressures),
            bound,
            LeadingEdge.find(bound, motion.depth),
            motion,
            FreeAmplitudes(motion.free_slips, weights[..., :N], targets),
        )
        return coulomb.tractions(law, start=p[..., :N], amplitudes=amplitudes, tolerance=tolerance)


def _joined(tangential: Array, normal: Array) -> Array:
    """Tangential tractions of the first, the last ones of the other, shape (n_x, n_s, 3)."""
    return np.concatenate([tangential[..., :N], normal[..., -1:]], axis=-1)
