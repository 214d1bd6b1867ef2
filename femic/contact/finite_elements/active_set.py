"""Which vertices are in contact: a primal-dual active set, a semismooth Newton method.

Source: Hintermueller, Ito and Kunisch (2003), SIAM Journal on Optimization 13, 865-888. Each step solves a
linear problem; vertices with tension leave, vertices with penetration join. Problems are solved
roughly as long as many do.
"""

from dataclasses import dataclass

import numpy as np

from femic.contact.finite_elements.saddle import CoupledBodies, State, solve
from femic.reference.accuracy import NotConverged
from geometries.arrays import Array, Mask

MOST_STEPS = 40
ROUGH, FINE = 1e-3, 1e-6  # relative residuals of linear problems
NEARLY = 0.03  # share of the vertices in contact that change, below which linear problems are solved finely
TENSION, PENETRATION = 1e-5, 1e-5  # that count as none: of the largest pressure, and of the approach


@dataclass(frozen=True, eq=False)
class ActiveSetSolution:
    """A contact whose area does not change any more."""

    state: State
    active: Mask  # (m,)
    steps: int
    iterations: int
    tension: float  # largest, as a share of the largest pressure
    penetration: float  # largest mean over a hat function, as a share of the approach


def solve_active_set(pair: CoupledBodies, load: float, active: Mask, start: State) -> ActiveSetSolution:
    """Return the contact under a load [N] on the model, from a first guess of the vertices in contact.

    Raises NotConverged where the area still changes after `MOST_STEPS` steps.
    """
    state, iterations, fine = start, 0, False
    for step in range(1, MOST_STEPS + 1):
        state, used = solve(pair, active, load, state, FINE if fine else ROUGH)
        iterations += used
        tension, penetration = violations(pair, active, state)
        leaving, joining = tension > TENSION, penetration > PENETRATION
        changes = int(np.count_nonzero(leaving | joining))
        if fine and not changes:
            largest = (max(0.0, float(violation.max())) for violation in (tension, penetration))
            return ActiveSetSolution(state, active, step, iterations, *largest)
        active = (active & ~leaving) | joining
        fine = bool(changes <= NEARLY * np.count_nonzero(active))
    raise NotConverged(
        f"contact of meshed bodies: {changes} of {np.count_nonzero(active)} vertices in contact still change "
        f"after {MOST_STEPS} steps (tension {tension.max():.1e} of the largest pressure, penetration "
        f"{penetration.max():.1e} of the approach). Try more `cells`, or begin with a smaller load"
    )


def violations(pair: CoupledBodies, active: Mask, state: State) -> tuple[Array, Array]:
    """Tension in contact over the largest pressure; penetration outside it over the approach; (m,) each."""
    penetration = -pair.gap(state) / pair.coupling.area / max(abs(state.approach), 1e-300)
    tension = -state.p / max(float(np.max(np.abs(state.p))), 1e-300)
    return np.where(active, tension, 0.0), np.where(active, 0.0, penetration)
