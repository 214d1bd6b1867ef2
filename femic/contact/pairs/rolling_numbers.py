"""The numbers of steady rolling, with what the work of friction is known to."""

from dataclasses import replace

import numpy as np

from femic.contact.estimates import Measured
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.quantities import OF_ROLLING, measured
from femic.contact.rolling import RollingContact, RollingProblem

OF_EDGE = 0.015  # part of the work on elements at the edge
FORCES = {"longitudinal": "F_x", "lateral": "F_y", "spin": "M_z"}  # that creepages bring about


def measured_rolling(on_grid: PairOnGrid, problem: RollingProblem, rolling: RollingContact) -> Measured:
    """Return the numbers of `OF_ROLLING`; the floor of work is that which the slip misses, and of the edge.

    Where little of a contact slides, grids miss much of the slip, and changes from grid to grid do not show
    that. Forces that creepages follow from are exact.
    """
    prescribed = [FORCES[name] for name in rolling.prescribed]
    known = measured(on_grid, rolling.contact, OF_ROLLING, prescribed)
    largest = known.scales["work"].changes
    if largest == 0.0:
        return known
    at_edge = float(np.sum(rolling.contact.dissipation[rolling.contact.slip_state.at_edge]))
    missed = problem.missed_work(rolling) + OF_EDGE * at_edge * problem.problem.grid.area
    return replace(known, floors={**known.floors, "work": missed / largest})
