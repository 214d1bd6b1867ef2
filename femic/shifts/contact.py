"""The contact of one wheel and its rail in a position of the wheelset, without friction, with several ICs."""

from dataclasses import replace

from femic.reference.run_options import DEFAULT, RunOptions
from femic.shifts.frictionless import SideContact, fitted, numbers_of, solved_on
from femic.shifts.grids import SIZING
from femic.shifts.planar import with_planar
from femic.shifts.sides import Place, Wanted, bodies_at
from femic.shifts.specification import C, ProfileTable
from femic.shifts.with_c import with_c
from geometries.errors import Failure


def contact_at(
    place: Place,
    rail: ProfileTable,
    wheel: ProfileTable,
    wanted: Wanted,
    options: RunOptions = DEFAULT,
) -> SideContact:
    """Return the contact of a side in a position with all ICs. Raises Failure and WrongInput.

    C and the planar contact are left out, with a sentence, where they have no solution.
    """
    contact = _with_ics(place, rail, wheel, wanted, options)
    return with_planar(contact, place, bodies_at(place, rail, wheel), wanted) if wanted.planar else contact


def _with_ics(
    place: Place, rail: ProfileTable, wheel: ProfileTable, wanted: Wanted, options: RunOptions
) -> SideContact:
    """Return the contact of a side with all ICs."""
    others = tuple(name for name in wanted.ics if name != C) or (SIZING,)
    without_c = replace(wanted, ics=others)
    bodies = bodies_at(place, rail, wheel)
    grid, load, notes = fitted(place, bodies, without_c)
    solved = solved_on(bodies, without_c, load, grid, options)
    numbers = tuple(numbers_of(place, contact) for contact in solved)
    contact = SideContact(numbers, grid, load, notes)
    beyond = wanted.c_above_deg is not None and max(row.angle for row in numbers) > wanted.c_above_deg
    if C not in wanted.ics and not beyond:
        return contact
    try:
        return with_c(place, rail, wheel, replace(wanted, ics=(*others, C)), options)
    except Failure as failure:
        return replace(contact, notes=(*notes, f"C is left out: {failure}"))
