"""Contact with friction with the distance of the displaced body, which is linearised otherwise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from femic.contact.estimates import CREEPAGE, Kind, Measured, Numbers, changes
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.creep_force import Continuation, CreepForceCurve
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import (
    OF_CURVE,
    OF_FRICTIONLESS,
    OF_ROLLING,
    Quantity,
    kinds,
    measured,
    numbers,
)
from femic.contact.rolling import RollingContact
from geometries.errors import Failure
from geometries.patches import N

OF_DISPLACED: Mapping[str, Quantity] = {
    **OF_ROLLING,
    "zero_creepage": OF_CURVE["zero_creepage"],
    "xi": Quantity("ξ", "1", "creepage of these numbers", CREEPAGE),
}
OF_OWN = "F_y", "M_x", "area"  # change by the share of p_max, besides what they do without friction
OF_SCALES = {
    "F_x": 1.0,
    "M_z": 1.0,
    "sliding_share": 1.0,
    "dissipation": 3.0,
}  # shares of it, of their scales
STEPS = 10  # largest number of contacts
TOLERANCE = 1e-4  # of the approach: of a change of the distance that is itself small


@dataclass(frozen=True)
class Linearisation:
    """What the linearised distance does to a contact: to that without friction under the same load.

    `changes` are those of `OF_FRICTIONLESS`, `share` is that of p_max. Tangential tractions, which follow the
    size of the patch, are taken to change by this share, and their work, which follows the slip by spin on a
    wider patch, too, by three times as much (docs/theory/errors.md). NaN where the displaced bodies have no
    contact on the grid.
    """

    changes: Numbers
    share: float

    @classmethod
    def of(cls, on_grid: PairOnGrid, operator: FullOperator, load: float) -> "Linearisation":
        """Return what it does with some ICs under a load [N]."""
        of_all, normal = kinds(OF_FRICTIONLESS), operator.restricted((N,))
        try:
            linear, exact = (
                on_grid.solve(normal, Loading(load), exact=exact).normal for exact in (False, True)
            )
        except Failure:
            return cls(dict.fromkeys(of_all, np.nan), np.nan)
        fine = measured(on_grid, linear, prescribed=("load", "position"))
        away = changes(fine, of_all, numbers(on_grid, exact))
        return cls(away, away["p_max"] / fine.numbers["p_max"])

    def part(self, fine: Measured, of_all: Mapping[str, Kind]) -> dict[str, float]:
        """Return the part of the estimates of a contact with friction."""
        of_own = {name: self.share * abs(fine.numbers[name]) for name in OF_OWN}
        of_scales = {
            name: times * self.share * fine.scale(name, of_all[name]).changes
            for name, times in OF_SCALES.items()
            if name in of_all and name not in fine.exact
        }
        tangential = of_own | of_scales
        return {name: self.changes.get(name, 0.0) + tangential.get(name, 0.0) for name in of_all}

    def part_of_curve(self, fine: Measured, zero_creepage: float) -> dict[str, float]:
        """Return the part of the estimates of `OF_CURVE`, from the creepage without force as displaced."""
        free = fine.numbers
        moved = abs(zero_creepage - free["zero_creepage"])
        if not np.isfinite(moved):
            moved = self.share * fine.scales["creepage"].changes
        apart = abs(free["equal_creepage"] - free["zero_creepage"])
        return {
            "zero_creepage": moved,
            "slope": self.share * abs(free["slope"]),
            "equal_creepage": moved + self.share * apart,
        }


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


def displaced(
    continuation: Continuation, contact: RollingContact, force: float | None = None
) -> RollingContact:
    """Return the contact with the distance at its own approach: a fixed point.

    It is at the same creepages, or under the same longitudinal `force` [N].
    Heights of rolling circles stay those of the linearised contact: the displacements of the same size that
    they lack along s are not known from the approach, and would make slip depend on the rigid-body discount.
    """
    on_grid, rolling = continuation.pair.on_grid, continuation.problem
    for _ in range(STEPS):
        approach = contact.contact.approach
        distance = on_grid.distance_at(approach) + approach * on_grid.cosine
        problem = replace(rolling, problem=replace(rolling.problem, distance=distance))
        contact = replace(continuation, problem=problem).solve(contact.creepages.longitudinal, contact, force)
        if abs(contact.contact.approach - approach) <= TOLERANCE * abs(approach):
            return contact
    raise Failure(f"{continuation.label}: the approach with the exact distance does not converge")
