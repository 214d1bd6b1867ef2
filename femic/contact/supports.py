"""What a contact owes to the supports of its bodies.

Contact takes C with the supports of the bodies, of which only the rigid part of the approach is taken away.
How far the far arc is, and how the flanks incline that stand for the rest of a body, is a convention: so its
effect is stated beside the results, by C with a nearer far arc and with flatter flanks.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from femic.contact.estimates import Numbers
from femic.contact.motions import find_motion
from femic.contact.motions.none import FrictionlessContacts
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.ics import ALL, NORMAL, C, c_jobs, pair_operator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import numbers
from femic.contact.specification import ContactProblem
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.contours import Contour
from geometries.errors import Failure

FLATTER_DEG = 5.0  # by which flanks are flatter
SAMPLES = 4001  # arc lengths among which flatter flanks begin
NEARER, FLATTER = "far arc of half the radius", f"flanks {FLATTER_DEG:g} degrees flatter"


@dataclass(frozen=True, eq=False)
class OtherSupports:
    """Bodies with other supports: what is other, C of each body, and the variation of C that has them."""

    name: str
    references: Mapping[str, MatrixReference]
    variation: str = ""

    def operator(self, on_grid: PairOnGrid, *, friction: bool, wheel_rolls: bool = False) -> GridOperator:
        """C of both bodies with these supports, in all directions if there is `friction`, else along n."""
        directions = ALL if friction else NORMAL
        return pair_operator(
            self.references, on_grid, directions, variation=self.variation, wheel_rolls=wheel_rolls
        )


def changed_supports(
    contacts: FrictionlessContacts, options: RunOptions = DEFAULT
) -> dict[str, dict[str, float]]:
    """Return the numbers of the largest contact with other supports of C, by name; empty without C.

    C with flatter flanks has to be solved: it is only where the contact is not symmetric, since supports
    hardly matter where it is.
    """
    with_c = [contact for (_, ics), contact in contacts.contacts.items() if ics == C]
    if not with_c or not contacts.problem.specification.supports:
        return {}
    largest, rows = max(with_c, key=lambda contact: contact.normal.load), {}
    for supports in other_supports(contacts.problem, largest.on_grid, options):
        operator = supports.operator(largest.on_grid, friction=False)
        try:
            contact = largest.on_grid.solve(operator, largest.loading)
        except Failure as failure:
            options.watch.on_stage(f"  left out, {supports.name}: {failure}")
            continue
        rows[supports.name] = numbers(contact.on_grid, contact.normal)
    return rows


def changed_supports_with_friction(
    pair: PairWithFriction, friction: float
) -> dict[str, tuple[float, Numbers]]:
    """Return the place and the numbers of one contact with C with other supports, by what is other.

    It is the one of the motion's `solve_point`; empty where that has none.
    """
    points, solve_point = {}, find_motion(pair.problem.specification).solve_point
    if solve_point is None:
        return {}
    for supports in other_supports(pair.problem, pair.on_grid, pair.options):
        operator = supports.operator(pair.on_grid, friction=True, wheel_rolls=pair.wheel_rolls)
        try:
            points[supports.name] = solve_point(pair, pair.frictional(operator, friction), supports.name)
        except Failure as failure:
            pair.options.watch.on_stage(f"  left out, {supports.name}: {failure}")
    return points


def other_supports(
    problem: ContactProblem, on_grid: PairOnGrid, options: RunOptions
) -> Iterator[OtherSupports]:
    """Yield bodies with other supports, where they have no outline; raises NotConverged as `matrices`."""
    if all(body.outline is not None for body in problem.bodies.values()):
        return  # their supports are their own
    yield OtherSupports(NEARER, matrices(c_jobs(problem, on_grid), options, combined=True), "nearer")
    flatter = None if on_grid.symmetric else flatter_problem(problem)
    if flatter is not None:
        options.watch.on_stage(f"  C with {FLATTER}")
        yield OtherSupports(FLATTER, matrices(c_jobs(flatter, on_grid), options, combined=True))


def flatter_problem(problem: ContactProblem) -> ContactProblem | None:
    """Return the problem with flatter flanks on both bodies; None for contours through points."""
    if any(np.all(np.isfinite(body.contour.extent)) for body in problem.bodies.values()):
        return None
    bodies = {
        name: replace(body, contour=with_flatter_flanks(body.contour)) if body.outline is None else body
        for name, body in problem.bodies.items()
    }
    return replace(problem, bodies=bodies)


def with_flatter_flanks(contour: Contour) -> Contour:
    """Return the contour with flanks that begin earlier, where its core inclines by `FLATTER_DEG` less."""
    s = np.linspace(*contour.limits, SAMPLES)
    delta = contour.inclination(s)
    steepest = np.abs(delta[[0, -1]]) - np.radians(FLATTER_DEG)
    core = s[(delta >= -max(steepest[0], 0.0)) & (delta <= max(steepest[1], 0.0))]
    return replace(contour, limits=(float(core[0]), float(core[-1])))
