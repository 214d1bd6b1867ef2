"""A contact that wears: the gap that wear leaves is fed back, step by step.

In each step the rolling contact is solved with the present gap, and both surfaces lose the depths of so many
passages (`femic.damage.wear`): an explicit step. Along the lower surface's normals the gap grows by the sum
of both depths, the same at all x, as a new `extra_gap`; the wheel's surface rises, so its rolling circles
become smaller. Load, creepages or forces, and the bodies below their surfaces stay as they were.

Stability. A ripple of the gap from strip to strip changes pressures most: elements of constant pressure, +1
and -1 in turn, on a half-space are displaced by +-8 G ds / (pi^2 E*), G Catalan's constant. Where pressure is
larger, more is worn off: in a step the ripple is multiplied by

    1 - f,  f = pi^2 E* / (8 G ds) (sum over x of rate / p) dx passages,

with the sum of both bodies. So it vanishes in one step of f = 1, oscillates beyond, and grows beyond 2. Steps
of f > `LARGEST_FACTOR` are refused, and WrongInput says how many passages are possible. E* is taken from the
ICs of half-spaces of an element. Where wheels run at scattered places, depths are averages along s with a
normal distribution of the standard deviation `spread`; a wave of the gap, of the stiffness E* kappa / 2, then
takes part by exp(-(kappa spread)^2 / 2) only, and the largest stiffness is E* / (2 spread e^1/2) at most: so
steps may be larger, too.

ICs. Those at hand are used until the inclination of one of the surfaces, -d(depth)/ds, has changed by more
than `largest_turn` since they were made: differences of inclination, on which B-hat depends, then change by
twice that at most, and each of its components by no more than that angle times the largest one of A. Then
`renew` is asked for new ones; without it, those at hand stay, and `turned` says how far the surface turned.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from femic.contact.exact.hertz import require_positive
from femic.contact.friction.motion import Creepages
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.rolling import RollingContact, RollingProblem
from femic.contact.specification import Profile
from femic.damage.laws import WearLaw
from femic.damage.wear import Sliding, depth, sliding_of
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N

CATALAN = 0.915965594177219
LARGEST_FACTOR = 1.0  # of a step: ripples do not change sign
REACH = 4.0  # standard deviations of the average along s
LARGEST_TURN = float(np.radians(1.0))


class UnstableSteps(WrongInput):
    """Steps of wear so large that ripples of the gap oscillate."""


@dataclass(frozen=True, eq=False)
class Operation:
    """How a wheel rolls: load, creepages, prescribed forces [N], rolling speed [m/s].

    `forces` as in `RollingProblem.contact`: creepages then follow, anew in each step.
    """

    loading: Loading
    creepages: Creepages
    speed: float
    forces: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_positive("speed", self.speed)


@dataclass(frozen=True)
class BodyWear:
    """Wear of one body: its law, and the passages (rail) or revolutions (wheel) in one step, 0: none."""

    law: WearLaw
    passages: float

    def __post_init__(self) -> None:
        if not 0 <= self.passages < np.inf:
            raise WrongInput(f"passages = {self.passages!r} per step: must be zero or positive, and finite")


@dataclass(frozen=True)
class WearSteps:
    """Steps of wear of both bodies.

    `largest_turn` [rad] is the angle by which surfaces may turn before ICs are renewed, `spread` [mm] the
    standard deviation of the places along s at which wheels run.
    """

    steps: int
    lower: BodyWear
    upper: BodyWear
    largest_turn: float = LARGEST_TURN
    spread: float = 0.0

    def __post_init__(self) -> None:
        if self.steps < 1:
            raise WrongInput(f"steps = {self.steps!r}: one or more")
        require_positive("largest_turn", self.largest_turn)
        if not 0 <= self.spread < np.inf:
            raise WrongInput(f"spread = {self.spread!r}: must be zero or positive, and finite [mm]")


@dataclass(frozen=True, eq=False)
class WornSurfaces:
    """Depths [mm] worn off strips at `s` [mm], (n_s,), of the lower and the upper body."""

    s: Array
    lower: Array
    upper: Array

    @classmethod
    def new(cls, s: Array) -> "WornSurfaces":
        """Return surfaces without wear."""
        return cls(s, np.zeros_like(s), np.zeros_like(s))

    @property
    def extra_gap(self) -> Profile:
        """The gap [mm] that wear adds: an extra gap of a scene, 0 beyond the strips."""
        return Profile(self.s, self.lower + self.upper)

    @property
    def turns(self) -> Array:
        """Slopes d(depth)/ds [rad] of both, (2, n_s)."""
        return np.stack([np.gradient(depths, self.s) for depths in (self.lower, self.upper)])


@dataclass(frozen=True, eq=False)
class WornContact:
    """A contact before its step of wear, the surfaces at which it was solved, and what the step wears off.

    `turned` [rad] is the largest change of inclination since the ICs were made, `renewals` how often they
    were renewed. `worn` are the depths [mm] of the step, those of the lower body first, (2, n_s).
    """

    rolling: RollingContact
    sliding: Sliding
    surfaces: WornSurfaces
    worn: Array
    turned: float
    renewals: int

    @property
    def after(self) -> WornSurfaces:
        """The surfaces after the step."""
        lower, upper = self.worn
        return replace(self.surfaces, lower=self.surfaces.lower + lower, upper=self.surfaces.upper + upper)


Renewal = Callable[[WornSurfaces], FullOperator]


@dataclass(frozen=True, eq=False)
class _ICs:
    """ICs in use, the surfaces for which they were made, and how often they were renewed."""

    operator: FullOperator
    surfaces: WornSurfaces
    renewals: int = 0

    def turned(self, surfaces: WornSurfaces) -> float:
        return float(np.max(np.abs(surfaces.turns - self.surfaces.turns)))

    def for_surfaces(self, surfaces: WornSurfaces, steps: WearSteps, renew: Renewal | None) -> "_ICs":
        if renew is None or self.turned(surfaces) <= steps.largest_turn:
            return self
        return _ICs(renew(surfaces), surfaces, self.renewals + 1)


def worn_contacts(
    problem: RollingProblem, operation: Operation, steps: WearSteps, renew: Renewal | None = None
) -> Iterator[WornContact]:
    """Yield a contact for each step of wear, then one more, which wears no further: the worn contact.

    `problem` is that of new surfaces; `renew` returns the ICs of worn surfaces. Raises as
    `RollingProblem.contact`, and UnstableSteps for passages per step that would not be stable.
    """
    surfaces = WornSurfaces.new(problem.rolling.s)
    ics, start = _ICs(problem.problem.operator, surfaces), None
    for number in range(steps.steps + 1):
        ics = ics.for_surfaces(surfaces, steps, renew)
        rolling = _solve(worn_problem(problem, surfaces, ics.operator), operation, start)
        sliding = sliding_of(rolling.contact, operation.speed)
        worn = np.zeros((2, len(surfaces.s)))
        if number < steps.steps:
            _require_stable(ripple_factor(rolling.contact, sliding, steps), steps)
            worn = _step_depths(sliding, steps)
        step = WornContact(rolling, sliding, surfaces, worn, ics.turned(surfaces), ics.renewals)
        yield step
        surfaces, start = step.after, rolling


def worn_problem(problem: RollingProblem, surfaces: WornSurfaces, operator: FullOperator) -> RollingProblem:
    """Return a rolling problem with the gap of worn surfaces and these ICs."""
    frictional, rolling = problem.problem, problem.rolling
    gap = surfaces.extra_gap.at(rolling.x[:, None], rolling.s)
    cosine = np.cos(frictional.inclination)
    return replace(
        problem,
        problem=replace(frictional, distance=frictional.distance + gap, operator=operator),
        rolling=replace(rolling, height=rolling.height + surfaces.upper * cosine),
    )


def _solve(problem: RollingProblem, operation: Operation, start: RollingContact | None) -> RollingContact:
    """Return the contact, from that of the step before."""
    creepages = operation.creepages if start is None else start.creepages
    return problem.contact(
        creepages,
        operation.loading,
        forces=operation.forces,
        start=None if start is None else start.contact,
    )


def _step_depths(sliding: Sliding, steps: WearSteps) -> Array:
    """Return the depths [mm] that a step wears off both bodies, (2, n_s)."""
    depths = [body.passages * depth(sliding, body.law) for body in (steps.lower, steps.upper)]
    return np.stack([_spread(one, steps.spread, sliding.grid.ds) for one in depths])


def _spread(depths: Array, spread: float, ds: float) -> Array:
    """Return depths (n_s,) averaged along s; raises WrongInput where the average needs more strips."""
    if spread == 0:
        return depths
    reach = strips_beside(spread, ds)
    if np.any(depths[:reach]) or np.any(depths[len(depths) - reach :]):
        raise WrongInput(
            f"damage.spread = {spread:g} mm: wear reaches the ends of the grid; {reach} strips are needed "
            "beside the contact: take more strips, or a smaller spread"
        )
    averaged = scipy.ndimage.gaussian_filter1d(depths, spread / ds, mode="constant", truncate=REACH)
    return np.asarray(averaged)


def strips_beside(spread: float, ds: float) -> int:
    """Return how many strips [mm] are needed on either side of a contact, over which wear is averaged."""
    return int(REACH * spread / ds + 0.5)


def ripple_factor(contact: FrictionalContact, sliding: Sliding, steps: WearSteps) -> float:
    """Return the largest share f [-] by which a step takes a ripple or wave of the gap away, over strips."""
    grid = contact.problem.grid
    largest = 1 / (2 * steps.spread * np.exp(0.5)) if steps.spread > 0 else np.inf
    stiffness = _modulus(contact.problem) * min(np.pi**2 / (8 * CATALAN * grid.ds), largest)  # MPa/mm
    pressure = np.where(sliding.pressure > 0, sliding.pressure, np.inf)
    per_pressure = sum(
        body.passages * np.sum(body.law.rate(sliding) / pressure, axis=0)
        for body in (steps.lower, steps.upper)
    )  # (n_s,)
    return float(np.max(stiffness * grid.dx * per_pressure))


def _modulus(problem: FrictionalProblem) -> float:
    """Return E* [MPa] of the ICs of half-spaces: from the displacement in the middle of a loaded element."""
    grid = problem.grid
    unit = np.zeros((grid.n_x, grid.n_s, 3))
    middle = grid.n_x // 2, grid.n_s // 2
    unit[(*middle, N)] = 1.0
    a, b = grid.dx / 2, grid.ds / 2
    of_rectangle = 4 / np.pi * (b * np.arcsinh(a / b) + a * np.arcsinh(b / a))
    return of_rectangle / float(problem.flat(unit)[(*middle, N)])


def _require_stable(factor: float, steps: WearSteps) -> None:
    """Raise UnstableSteps where a step makes ripples from strip to strip oscillate."""
    if factor > LARGEST_FACTOR:
        passages = steps.lower.passages, steps.upper.passages
        most = " and ".join(f"{LARGEST_FACTOR / factor * one:.3g}" for one in passages)
        raise UnstableSteps(
            f"passages = {passages[0]:g} (lower), {passages[1]:g} (upper) per step: pressures oscillate "
            f"from strip to strip; take {most} at most and more steps, or a larger spread"
        )
