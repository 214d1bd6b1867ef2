"""The contact of one side also with C, of bodies whose flanks end less steep, on a grid of their own."""

from dataclasses import replace

import numpy as np

from femic.contact.loading import Loading
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.supports import other_supports
from femic.reference.run_options import RunOptions
from femic.shifts.frictionless import SideContact, fitted, numbers_of, solved_on
from femic.shifts.sides import Place, Wanted, bodies_at, problem_of
from femic.shifts.specification import C, ProfileTable
from geometries.errors import Failure

C_FLANK = float(np.radians(60.0))  # steeper ones are pillars that bend under lateral forces


def with_c(
    place: Place, rail: ProfileTable, wheel: ProfileTable, wanted: Wanted, options: RunOptions
) -> SideContact:
    """Return the contact with all ICs and C, of bodies with flanks as C has them, on a grid of their own.

    The estimated error of C has the change by nearer supports in it. Raises Failure.
    """
    inclination = abs(place.touch.angle - place.roll)
    if inclination >= C_FLANK:
        raise Failure(
            f"the contact angle is {np.degrees(inclination):.1f} degrees; the bodies of C end in flanks of "
            f"{np.degrees(C_FLANK):.0f} degrees"
        )
    bodies = bodies_at(place, rail, wheel, C_FLANK)
    grid, load, notes = fitted(place, bodies, wanted)
    solved = solved_on(bodies, wanted, load, grid, options)
    problem = problem_of(bodies, replace(wanted, ics=(C,)), load, grid)
    on_grid = pair_on_grid(problem, grid)
    nearer = next(other_supports(problem, on_grid, options)).operator(on_grid, friction=False)
    change = abs(
        float(np.max(on_grid.solve(nearer, Loading(load)).normal.p)) - float(np.max(solved[-1].normal.p))
    )
    *others, c = (numbers_of(place, contact) for contact in solved)
    c = replace(c, estimate_p_max=c.estimate_p_max + change)
    return SideContact((*others, c), grid, load, notes, C_FLANK)
