"""The load perpendicular to the axle that gives the vertical load in the track.

The given load is vertical, perpendicular to the track. Rolled by phi to it, the contact is solved under the
load perpendicular to the axle F_z' that gives F_y' sin(phi) + F_z' cos(phi) = load; the lateral one follows.
"""

from dataclasses import replace

import numpy as np

from femic.contact.loading import Loading
from femic.contact.pairs.automatic_grid import sizing_of
from femic.shifts.grids import SIZING
from femic.shifts.sides import Place, Wanted, problem_of
from femic.shifts.specification import C
from geometries.bodies import Body
from geometries.errors import Failure
from geometries.grids import Grid

BALANCE, BALANCE_STEPS = 1e-6, 8  # of the vertical load, as a share of it


def first_load(place: Place, load: float) -> float:
    """Return the load perpendicular to the axle [N] of a small patch without friction."""
    return float(load * np.cos(place.touch.angle - place.roll) / np.cos(place.touch.angle))


def balanced(
    place: Place, bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid
) -> tuple[Grid, float]:
    """Return a grid that fits all ICs, and the load perpendicular to the axle [N] that balances."""
    names = [name for name in wanted.ics if name != C] or [SIZING]
    sizing = sizing_of(problem_of(bodies, wanted, load))
    for _ in range(BALANCE_STEPS):
        grid = sizing.large_enough(grid, [Loading(load)], [*dict.fromkeys((*names, SIZING))])
        on_grid = replace(sizing.bodies, grid=grid)
        contact = on_grid.solve(on_grid.operator(SIZING), Loading(load)).normal
        vertical = place.in_track(on_grid.resultant(contact.tractions).force)[1]
        if abs(vertical / wanted.load - 1) <= BALANCE:
            return grid, load
        load *= wanted.load / vertical
    raise Failure(
        f"load = {wanted.load:g} N: the vertical force does not settle ({vertical:.1f} N); "
        "take a smaller shift"
    )
