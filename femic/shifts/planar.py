"""The classical planar contact of one side, beside the contacts on the curved surfaces.

All elements lie in the tangent plane at the touching point, with half-space ICs and one contact angle.
Several patches would need a plane each, so it is solved where one patch carries the load.
"""

from dataclasses import replace

import numpy as np

from femic.contact.loading import Loading
from femic.contact.pairs.frictionless import SolvedContact
from femic.contact.pairs.planar import solve_planar
from femic.contact.tangent_plane import TangentPlane
from femic.shifts.balance import first_load
from femic.shifts.frictionless import ICsNumbers, SideContact, numbers_of
from femic.shifts.grids import COUNTS, REFINEMENTS, finer_if_needed
from femic.shifts.patches import PatchNumbers
from femic.shifts.sides import Place, Wanted, problem_of
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput


def with_planar(contact: SideContact, place: Place, bodies: dict[str, Body], wanted: Wanted) -> SideContact:
    """Return the contacts of a side and the planar one, or a sentence about why it is left out."""
    try:
        planar = _planar(contact, place, bodies, wanted)
    except (Failure, WrongInput) as error:
        return replace(contact, notes=(*contact.notes, f"planar contact is left out: {error}"))
    return replace(contact, numbers=(*contact.numbers, planar))


def _planar(contact: SideContact, place: Place, bodies: dict[str, Body], wanted: Wanted) -> ICsNumbers:
    """Return the numbers of the planar contact; raises Failure where several patches carry the load."""
    carrying = [patch for patch in contact.numbers[0].patches if patch.share >= COUNTS]
    if len(carrying) > 1:
        raise Failure(f"{len(carrying)} patches carry the load, and it has one plane")
    solved = _solved(bodies, wanted, first_load(place, wanted.load))
    numbers, plane = numbers_of(place, solved), solved.on_grid.undeformed
    assert isinstance(plane, TangentPlane)
    patches = tuple(_on_the_rail(place, plane, patch) for patch in numbers.patches)
    main = max(patches, key=lambda patch: patch.share)
    return replace(numbers, b=(main.s[1] - main.s[0]) / 2, patches=patches)


def _solved(bodies: dict[str, Body], wanted: Wanted, load: float) -> SolvedContact:
    """Return the planar contact on a grid fine enough for its patch and p_max, or on the finest one."""
    problem, loading = problem_of(bodies, wanted, load), Loading(load)
    solved = solve_planar(problem, loading, 0.0)
    for _ in range(REFINEMENTS):
        finer = finer_if_needed(solved)
        if finer is None:
            break
        solved = solve_planar(problem, loading, 0.0, grid=finer)
    return solved


def _on_the_rail(place: Place, plane: TangentPlane, patch: PatchNumbers) -> PatchNumbers:
    """Return a patch whose coordinates in the plane are turned into arc lengths of the rail [mm]."""

    def arc_length(s: Array) -> Array:
        on_rail = plane.lower_arc_length(s - place.touch.s_rail)
        return np.where(np.isnan(on_rail), s, on_rail + place.touch.s_rail)

    start, end = arc_length(np.array(patch.s)).tolist()
    outline = np.stack([arc_length(patch.outline[0]), patch.outline[1]])
    return replace(patch, s=(start, end), outline=outline)
