"""Contacts of one side without friction on one grid, with several ICs: their numbers."""

from dataclasses import dataclass

import numpy as np

from femic.contact.pairs.frictionless import SolvedContact, solve_frictionless
from femic.contact.pairs.quantities import angle
from femic.reference.run_options import RunOptions
from femic.shifts.balance import balanced, first_load
from femic.shifts.grids import covering, refined
from femic.shifts.patches import PatchNumbers, patch_numbers
from femic.shifts.sides import Place, Wanted, problem_of
from geometries.bodies import Body
from geometries.grids import Grid
from geometries.profiles.placement import STEEPEST


@dataclass(frozen=True, eq=False)
class ICsNumbers:
    """The contact with some ICs: pressures in MPa, lengths in mm, forces in N, angle in degrees.

    `vertical` and `lateral` are forces on the wheel in axes of the track, the latter positive towards its
    middle. `angle` is the change of the rail's inclination across the main patch.
    """

    ics: str
    p_max: float
    estimate_p_max: float
    approach: float
    vertical: float
    lateral: float
    angle: float
    a: float
    b: float
    seconds: float
    patches: tuple[PatchNumbers, ...]


@dataclass(frozen=True, eq=False)
class SideContact:
    """The contact of a side with all ICs, on one grid; sentences about what was left out.

    `steepest` [rad] is the inclination at which the bodies end in flanks.
    """

    numbers: tuple[ICsNumbers, ...]
    grid: Grid
    load: float  # perpendicular to the axle [N]
    notes: tuple[str, ...] = ()
    steepest: float = STEEPEST


def fitted(place: Place, bodies: dict[str, Body], wanted: Wanted) -> tuple[Grid, float, tuple[str, ...]]:
    """Return a grid, the load perpendicular to the axle [N], and sentences about what is left out."""
    load = first_load(place, wanted.load)
    grid, notes = covering(place, bodies, wanted, load)
    return *balanced(place, bodies, wanted, load, refined(bodies, wanted, load, grid)), notes


def solved_on(
    bodies: dict[str, Body], wanted: Wanted, load: float, grid: Grid, options: RunOptions
) -> list[SolvedContact]:
    """Return the contacts with all ICs on a grid."""
    contacts = solve_frictionless(problem_of(bodies, wanted, load, grid), options)
    return [contacts.contacts[loading, name] for loading in contacts.loadings for name in contacts.ics]


def numbers_of(place: Place, solved: SolvedContact) -> ICsNumbers:
    """Return the numbers of a contact."""
    on_grid, contact = solved.on_grid, solved.normal
    lateral, vertical = place.in_track(on_grid.resultant(contact.tractions).force)
    patches = tuple(patch_numbers(place, on_grid, contact, patch) for patch in contact.patches)
    main = max(patches, key=lambda patch: patch.share)
    return ICsNumbers(
        solved.ics,
        float(np.max(contact.p)),
        solved.estimated_errors()["p_max"],
        contact.approach,
        vertical,
        -lateral,
        angle(on_grid, contact),
        main.half_length,
        (main.s[1] - main.s[0]) / 2,
        solved.seconds,
        patches,
    )
