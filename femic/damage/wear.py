"""Wear of a rolling contact: where it slides, and how its gap grows as both surfaces wear.

In each step the rolling contact is solved with the present gap, and both surfaces lose the depths of so many
passages (`femic.damage.laws`): an explicit step. Along the lower surface's normals the gap grows by the sum
of both depths, the same at all x, as an `extra_gap` of a scene does; the wheel's surface rises, so its
rolling circles become smaller. Load, forces, ICs, and the bodies below their surfaces stay as they were;
`turned` says how far surfaces have turned since.

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
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy

from femic.contact.friction.motion import SteadyRolling
from femic.contact.frictional import FrictionalContact
from femic.contact.loading import Loading
from femic.contact.rolling import RollingContact, RollingProblem
from femic.damage.estimates import RollingSolution
from femic.damage.laws import Sliding, WearLaw, depth
from geometries.arrays import Array
from geometries.errors import WrongInput
from geometries.patches import N

CATALAN = 0.915965594177219
LARGEST_FACTOR = 1.0  # of a step: ripples do not change sign
REACH = 4.0  # standard deviations of the average along s


class UnstableSteps(WrongInput):
    """Steps of wear so large that ripples of the gap oscillate."""


@dataclass(frozen=True)
class WearSteps:
    """So many steps of wear of both bodies by a law, at a rolling speed [m/s].

    `passages` are those over the rail, and revolutions of the wheel, in one step, 0: none. `spread` [mm] is
    the standard deviation of the places along s at which wheels run.
    """

    steps: int
    passages: tuple[float, float]
    law: WearLaw
    speed: float
    spread: float = 0.0


@dataclass(frozen=True, eq=False)
class WornContact:
    """A contact before its step of wear, with the depths [mm] worn off both bodies before and in this step.

    `depths` and `worn` have the lower body first, (2, n_s).
    """

    rolling: RollingContact
    sliding: Sliding
    depths: Array
    worn: Array

    @property
    def turned(self) -> float:
        """The largest change of a surface's inclination, -d(depth)/ds [rad]."""
        return float(np.max(np.abs(np.gradient(self.depths, self.sliding.grid.ds, axis=1))))


def find_sliding(contact: FrictionalContact, speed: float) -> Sliding:
    """Return where a contact in rolling, steady or in a step, slides at a rolling speed [m/s].

    Raises WrongInput for contacts that only shift: their slip is a length.
    """
    if not isinstance(contact.motion, SteadyRolling):
        raise WrongInput(
            f"contact by a {type(contact.motion).__name__.lower()}: wear and T-gamma need rolling; solve a "
            "rolling contact"
        )
    return Sliding(contact.problem.grid, contact.p[..., N], contact.p[..., :N], contact.slip, speed)


def wear_contact(solution: RollingSolution, steps: WearSteps) -> Iterator[WornContact]:
    """Yield a contact for each step of wear, then one more, which wears no further: the worn contact.

    Load and longitudinal force stay, or the creepages where these are prescribed. Raises as
    `RollingProblem.contact`, and UnstableSteps for passages per step that would not be stable.
    """
    creepages, start = solution.rolling.creepages, None
    forces = {} if np.isinf(solution.slope) else {"longitudinal": float(solution.contact.force[0])}
    depths = np.zeros((2, len(solution.problem.rolling.s)))
    for number in range(steps.steps + 1):
        problem = worn_problem(solution.problem, depths)
        rolling = problem.contact(creepages, Loading(solution.load), forces=forces, start=start)
        sliding = find_sliding(rolling.contact, steps.speed)
        worn = np.zeros_like(depths)
        if number < steps.steps:
            if (factor := ripple_factor(rolling.contact, sliding, steps)) > LARGEST_FACTOR:
                lower, upper = steps.passages
                most = " and ".join(f"{LARGEST_FACTOR / factor * one:.3g}" for one in steps.passages)
                raise UnstableSteps(
                    f"passages = {lower:g} (lower), {upper:g} (upper) per step: pressures would oscillate "
                    f"from strip to strip; use {most} at most and more steps, or a larger spread"
                )
            per_passage = _spread(depth(sliding, steps.law), steps.spread, sliding.grid.ds)
            worn = np.outer(steps.passages, per_passage)
        yield WornContact(rolling, sliding, depths, worn)
        depths, creepages, start = depths + worn, rolling.creepages, rolling.contact


def worn_problem(problem: RollingProblem, depths: Array) -> RollingProblem:
    """Return a rolling problem whose bodies have lost depths [mm], (2, n_s), the lower one first."""
    frictional, rolling = problem.problem, problem.rolling
    return replace(
        problem,
        problem=replace(frictional, distance=frictional.distance + np.sum(depths, axis=0)),
        rolling=replace(rolling, height=rolling.height + depths[1] * np.cos(frictional.inclination)),
    )


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
    grid, problem = sliding.grid, contact.problem
    unit = np.zeros((grid.n_x, grid.n_s, 3))
    middle = grid.n_x // 2, grid.n_s // 2, N
    unit[middle] = 1.0
    a, b = grid.dx / 2, grid.ds / 2
    displacement = 4 / np.pi * (b * np.arcsinh(a / b) + a * np.arcsinh(b / a))  # in the middle, times E*
    modulus = displacement / float(problem.flat(unit)[middle])
    largest = 1 / (2 * steps.spread * np.exp(0.5)) if steps.spread > 0 else np.inf
    stiffness = modulus * min(np.pi**2 / (8 * CATALAN * grid.ds), largest)  # MPa/mm
    pressure = np.where(sliding.pressure > 0, sliding.pressure, np.inf)
    per_pressure = sum(steps.passages) * np.sum(steps.law.rate(sliding) / pressure, axis=0)  # (n_s,)
    return float(np.max(stiffness * grid.dx * per_pressure))
