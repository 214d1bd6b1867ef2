"""Rolling with the distance of the displaced wheel, which is linearised otherwise."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from femic.contact.estimates import CREEPAGE
from femic.contact.pairs.creep_force import Continuation, CreepForceCurve
from femic.contact.pairs.quantities import OF_CURVE, OF_ROLLING, Quantity
from femic.contact.rolling import RollingContact
from geometries.errors import Failure

OF_DISPLACED: Mapping[str, Quantity] = {
    **OF_ROLLING,
    "zero_creepage": OF_CURVE["zero_creepage"],
    "xi": Quantity("ξ", "1", "creepage of these numbers", CREEPAGE),
}
STEPS = 10  # largest number of contacts
TOLERANCE = 1e-4  # of the approach: of a change of the distance that is itself small


def displaced_numbers(continuation: Continuation, curve: CreepForceCurve) -> Mapping[str, float]:
    """Return the numbers of `OF_DISPLACED` at the creepage nearest 0; NaN where the grid has no such contact.

    They are NaN, too, where one of both contacts is found in a less accurate form than the other: that would
    change more than the distance does. The creepage without force is moved by the change of the force over
    the slope.
    """
    try:
        linear = continuation.at(min(continuation.xi, key=abs), curve.equal)
        exact = displaced(continuation, linear)
    except Failure:  # the patch is larger than the grid, or not found: the curve itself stands
        return dict.fromkeys(OF_DISPLACED, np.nan)
    if exact.contact.motion.depth != linear.contact.motion.depth:
        return dict.fromkeys(OF_DISPLACED, np.nan)
    change = float(exact.contact.force[0] - linear.contact.force[0])
    moved = curve.free.numbers["zero_creepage"] - change / curve.free.numbers["slope"]
    numbers = continuation.measured(exact).numbers
    return {**numbers, "zero_creepage": moved, "xi": exact.creepages.longitudinal}


def displaced(continuation: Continuation, contact: RollingContact) -> RollingContact:
    """Return the contact at the same creepages with the distance at its own approach: a fixed point.

    Heights of rolling circles stay those of the linearised contact: the displacements of the same size that
    they lack along s are not known from the approach, and would make slip depend on the rigid-body discount.
    """
    on_grid, rolling = continuation.pair.on_grid, continuation.problem
    for _ in range(STEPS):
        approach = contact.contact.approach
        distance = on_grid.distance_at(approach) + approach * on_grid.cosine
        problem = replace(rolling, problem=replace(rolling.problem, distance=distance))
        contact = replace(continuation, problem=problem).solve(contact.creepages.longitudinal, contact)
        if abs(contact.contact.approach - approach) <= TOLERANCE * abs(approach):
            return contact
    raise Failure(f"{continuation.label}: the approach with the exact distance does not converge")
