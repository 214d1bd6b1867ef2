"""What the linearised distance changes in rolling: a contact with the distance of the displaced wheel."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from compare.friction.curve import Curve, Path
from compare.friction.quantities import OF_ROLLING, Described
from femic.contact.estimates import CREEPAGE
from femic.contact.rolling import RollingContact
from geometries.errors import Failure

PREFIX = "displaced_"  # of the names of numbers with the distance of the displaced wheel
DISPLACED = {
    **OF_ROLLING,
    "zero_creepage": Described("1", "creepage without longitudinal force", kind=CREEPAGE),
    "xi": Described("1", "creepage of these numbers", kind=CREEPAGE),
}
STEPS = 10  # largest number of contacts
TOLERANCE = 1e-4  # of the approach: of a change of the distance that is itself small


def displaced_numbers(path: Path, curve: Curve) -> Mapping[str, float]:
    """The numbers of `DISPLACED` at the creepage nearest 0; NaN where there is no such contact on the grid.

    They are NaN, too, where one of both contacts is found in a less accurate form than the other: that would
    change more than the distance does. The creepage without force is moved by the change of the force over
    the slope.
    """
    try:
        first = path.at(min(path.xi, key=abs), curve.equal)
        found = displaced(path, first)
    except Failure:  # the patch is larger than the grid, or not found: the curve itself stands
        return dict.fromkeys(DISPLACED, np.nan)
    if found.contact.motion.depth != first.contact.motion.depth:
        return dict.fromkeys(DISPLACED, np.nan)
    changed = float(found.contact.force[0] - first.contact.force[0])
    moved = curve.free.numbers["zero_creepage"] - changed / curve.free.numbers["slope"]
    return {**path.measured(found).numbers, "zero_creepage": moved, "xi": found.creepages.longitudinal}


def displaced(path: Path, contact: RollingContact) -> RollingContact:
    """The contact at the same creepages with the distance at its own approach: a fixed point.

    Heights of rolling circles stay those of the linearised contact: the displacements of the same size that
    they lack along s are not known from the approach, and would make slip depend on the rigid-body discount.
    """
    placed = path.solver.placed
    for _ in range(STEPS):
        approach = contact.contact.approach
        distance = placed.distance_at(approach) + approach * placed.cosine
        problem = replace(path.problem, problem=replace(path.problem.problem, distance=distance))
        contact = replace(path, problem=problem).solved(contact.creepages.longitudinal, contact)
        if abs(contact.contact.approach - approach) <= TOLERANCE * abs(approach):
            return contact
    raise Failure(f"{path.label}: the approach with the exact distance does not settle")
