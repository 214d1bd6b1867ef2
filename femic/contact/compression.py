"""Static compression with friction: bodies pressed on each other in steps, without rolling.

A vertical approach moves surfaces on inclined places along s, so that they slip or stick there even where
bodies are of equal material. Each step is a shift from the displacements of the step before.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from femic.contact.friction.motion import Shift
from femic.contact.frictional import FrictionalContact, solve
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from geometries.errors import WrongInput


def compressed(problem: FrictionalProblem, steps: Sequence[Loading]) -> Iterator[FrictionalContact]:
    """Yield the contact after each of some steps of vertical load or approach, from none on.

    Elements that come into contact in a step slip from where they were before it: the error is of the first
    order in the steps. Raises WrongInput for no steps, and otherwise as `frictional.solve`.
    """
    if not steps:
        raise WrongInput("steps of the load: give one at least")
    sines, none = np.sin(problem.inclination), np.zeros((*problem.distance.shape, 2))
    motion, contact = Shift(none, per_approach=sines), None
    for step in steps:
        contact = solve(problem, motion, step, start=contact)
        yield contact
        motion = Shift(none, before=contact.u[..., :2], per_approach=sines, approach_before=contact.approach)
