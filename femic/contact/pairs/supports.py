"""What a contact owes to the supports of its bodies, and displacements by A and B-hat compared on patches.

Contact takes C with the supports of the bodies, of which only the rigid part of the approach is taken away.
How far the far arc is, and how the flanks incline that stand for the rest of a body, is a convention: so its
effect is stated beside the results, by C with a nearer far arc and with flatter flanks.

`sensitivities` are differences of displacements by A and by B-hat under given pressures, mapped from patch to
patch.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.interpolate import RegularGridInterpolator

from femic.contact.estimates import Numbers
from femic.contact.operators.dense import GridOperator
from femic.contact.pairs.frictionless import FrictionlessContacts, SolvedContact
from femic.contact.pairs.ics import ALL, NORMAL, C, c_jobs, pair_operator
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import half_length, numbers, s_range
from femic.contact.specification import ContactProblem
from femic.reference.matrix.reference import MatrixReference, matrices
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array, Mask
from geometries.contours import Contour
from geometries.errors import Failure

# --- other supports ---

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

    It is the `one_point` of the motion; empty where that has none.
    """
    points, one_point = {}, pair.motion.one_point
    if one_point is None:
        return {}
    for supports in other_supports(pair.problem, pair.on_grid, pair.options):
        operator = supports.operator(pair.on_grid, friction=True, wheel_rolls=pair.motion.wheel_rolls)
        try:
            points[supports.name] = one_point(pair, pair.frictional(operator, friction), supports.name)
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


# --- A and B-hat under the same pressures ---

REFERENCE = "Bhat"  # the ICs that A is compared with


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """(u_n by A - u_n by B-hat) / max u_n by B-hat on a patch, due to the pressures of another contact."""

    pressures: str  # the name of the contact that the pressures are from
    patch: str  # the name of the contact that the patch is from
    x: Array  # [mm], (n_x,)
    s: Array  # [mm], (n_s,)
    on_patch: Mask  # (n_x, n_s)
    difference: Array  # (n_x, n_s)

    @property
    def inside(self) -> Array:
        """The differences on the patch, (n,)."""
        return np.asarray(self.difference[self.on_patch])

    @property
    def largest(self) -> float:
        """The largest difference on the patch."""
        return float(np.max(np.abs(self.inside)))


def sensitivities(contacts: Mapping[str, SolvedContact]) -> Iterator[Sensitivity]:
    """Yield the sensitivities to the pressures of every contact on the patch of every contact."""
    for (source, pressures), (name, patch) in product(contacts.items(), repeat=2):
        p = mapped(pressures, patch)
        by_a, by_bhat = (patch.on_grid.operator(ics)(p[..., None])[..., 0] for ics in ("A", REFERENCE))
        difference = (by_a - by_bhat) / np.max(by_bhat)
        yield Sensitivity(
            source, name, patch.on_grid.x, patch.on_grid.grid.strips, patch.normal.p > 0, difference
        )


def mapped(contact: SolvedContact, patch: SolvedContact) -> Array:
    """Return the pressures of one contact on the patch of another, at equal x / a and s / b; (n_x, n_s)."""
    interpolate = RegularGridInterpolator(
        _normalised(contact), contact.normal.p, bounds_error=False, fill_value=0.0
    )
    return np.asarray(interpolate(np.stack(np.meshgrid(*_normalised(patch), indexing="ij"), axis=-1)))


def _normalised(contact: SolvedContact) -> tuple[Array, Array]:
    """Return x over the half-length, and s from the middle over the half-width of the patch."""
    on_grid = contact.on_grid
    low, high = s_range(on_grid, contact.normal)
    s = (on_grid.grid.strips - (low + high) / 2) / ((high - low) / 2)
    return on_grid.x / half_length(on_grid, contact.normal), s
