"""A creep-force curve with some ICs, and the estimates: from larger elements, and C plus its estimate.

Before it is solved, `forces_beyond_creepages` tells whether its creepages reach the force at which ICs are
compared, as far as that can be known.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from femic.contact.estimates import Numbers, changes, errors
from femic.contact.exact.creepage_coefficients import WIDEST, creepage_coefficients
from femic.contact.friction.motion import largest_factor
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.creep_force import Continuation, CreepForceCurve, Linearisation, displaced_numbers
from femic.contact.pairs.grids import Sizing, hertz
from femic.contact.pairs.pair_with_friction import (
    Change,
    PairWithFriction,
    change_of_tractions,
    differences,
    if_possible,
    on_larger_elements,
)
from femic.contact.pairs.quantities import OF_CURVE, OF_ROLLING, kinds
from femic.contact.rolling import RollingContact
from femic.contact.specification import CREEPAGES, ContactProblem, FrictionSpecification

# --- curve with estimates ---


@dataclass(frozen=True, eq=False)
class SolvedCurve:
    """A creep-force curve, the estimated errors of its numbers, and numbers with the displaced wheel.

    `larger` is the curve on elements twice as large, None where there is none.
    """

    curve: CreepForceCurve
    point_errors: Sequence[Numbers]  # of `OF_ROLLING`, by creepage
    curve_errors: Numbers  # of `OF_CURVE`
    displaced: Numbers  # of `OF_DISPLACED`
    larger: CreepForceCurve | None
    change: Change
    free_change: Numbers  # of `OF_CURVE`, signed as `change`
    seconds: float  # without C


def solve_curve(pair: PairWithFriction, friction: float, name: str) -> SolvedCurve:
    """Return the creep-force curve with the ICs of a name at a coefficient of friction.

    Raises Failure where no contact is found at any creepage, or where the curve does not reach the force at
    which ICs are compared.
    """
    operator, start = pair.operator(name), perf_counter()  # C has its own seconds
    problem = pair.frictional(operator, friction)
    along = Continuation.of(pair, problem, f"friction {friction:g}, {name}")
    curve = along.curve()
    seconds = perf_counter() - start
    pair.options.watch.on_stage(
        f"  {along.label}: {len(curve.points)} of {len(along.xi)} creepages, {seconds:.1f} s"
    )
    perturbed = pair.perturbed(name)
    changed = None if perturbed is None else _with_ics(along, curve, perturbed)
    larger = on_larger_elements(pair, problem, along.label, _curve)
    displaced = displaced_numbers(along, curve)
    linearised = Linearisation.measure(pair.on_grid, operator, pair.loads[0])
    of_points = [
        [linearised.part(curve.points[xi], kinds(OF_ROLLING))] if xi in curve.points else []
        for xi in along.xi
    ]
    of_free = [linearised.part_of_curve(curve.free, displaced["zero_creepage"])]
    if changed is not None:
        points, free = _sizes_of_change(along.xi, curve, changed)
        of_points = [[*parts, more] for parts, more in zip(of_points, points, strict=True)]
        of_free.append(free)
    return SolvedCurve(
        curve,
        *_errors(along.xi, curve, larger, of_points, of_free),
        displaced,
        larger[0] if larger else None,
        *_change(along.xi, curve, changed),
        seconds,
    )


def _curve(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> CreepForceCurve:
    """Return the curve of a problem; raises Failure."""
    return Continuation.of(pair, problem, label).curve()


def nearest_to_no_creepage(
    pair: PairWithFriction, problem: FrictionalProblem, label: str
) -> tuple[float, Numbers]:
    """Return the creepage nearest 0 and the numbers there; raises Failure where there is no such contact."""
    along = Continuation.of(pair, problem, label)
    xi = min(along.xi, key=abs)
    return xi, along.measured(along.at(xi, None)).numbers


@dataclass(frozen=True, eq=False)
class ChangedCurve:
    """What is known of a curve with other ICs: numbers at a few creepages, and at certain forces."""

    points: Mapping[float, Numbers]  # of `OF_ROLLING` by creepage, growing
    free: Numbers | None  # of `OF_CURVE`
    equal: RollingContact | None  # with the force at which ICs are compared


def _with_ics(along: Continuation, curve: CreepForceCurve, operator: FullOperator) -> ChangedCurve:
    """Return a curve with other ICs, from the contacts of the curve with the ICs of `along`.

    Its creepages are the one nearest 0 and those with the largest forces, without those of no contact.
    """
    pair = along.pair
    problem = pair.frictional(operator, along.problem.problem.friction)
    changed = Continuation.of(pair, problem, f"{along.label} plus its estimate")
    found = {xi: changed.at_if_possible(xi, curve.contacts[xi]) for xi in deciding(curve)}
    points = {xi: changed.measured(contact).numbers for xi, contact in found.items() if contact}
    free = if_possible(pair, "no estimates", lambda: changed.free([*curve.contacts.values()]))
    return ChangedCurve(points, *((free[0].numbers, free[1]) if free else (None, None)))


def _change(
    xis: Sequence[float], curve: CreepForceCurve, changed: ChangedCurve | None
) -> tuple[Change, dict[str, float]]:
    """Return the change of numbers and tractions with changed ICs, by creepage linear; and of `OF_CURVE`."""
    if changed is None:
        changed = ChangedCurve(
            {xi: curve.points[xi].numbers for xi in deciding(curve)}, curve.free.numbers, curve.equal
        )
    rows = {xi: differences(curve.points[xi].numbers, numbers) for xi, numbers in changed.points.items()}
    p = change_of_tractions(curve.equal.contact, changed.equal.contact if changed.equal else None)
    return Change([between(rows, xi) for xi in xis], p), differences(curve.free.numbers, changed.free)


def _sizes_of_change(
    xis: Sequence[float], curve: CreepForceCurve, changed: ChangedCurve
) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return what estimates get from changed ICs, at all creepages, and of the numbers of `OF_CURVE`."""
    rows = {xi: changes(curve.points[xi], kinds(OF_ROLLING), row) for xi, row in changed.points.items()}
    free = changed.free or dict.fromkeys(OF_CURVE, np.nan)
    return [between(rows, xi) for xi in xis], changes(curve.free, kinds(OF_CURVE), free)


def deciding(curve: CreepForceCurve) -> list[float]:
    """Return the creepages nearest 0, and with the largest forces both ways, growing."""
    force = {xi: point.numbers["F_x"] for xi, point in curve.points.items()}
    return sorted({min(force, key=abs), min(force, key=force.__getitem__), max(force, key=force.__getitem__)})


def between(rows: Mapping[float, Numbers], xi: float) -> dict[str, float]:
    """Return numbers at a creepage from rows at growing ones: linear between them, and constant beyond."""
    if not rows:
        return dict.fromkeys(OF_ROLLING, np.nan)
    return {
        name: float(np.interp(xi, list(rows), [row[name] for row in rows.values()])) for name in OF_ROLLING
    }


def _errors(
    xis: Sequence[float],
    curve: CreepForceCurve,
    larger: Sequence[CreepForceCurve | None],
    of_points: Sequence[Sequence[Numbers]],
    of_free: Sequence[Numbers],
) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return estimated errors of the points at all creepages, and of the curve as a whole.

    `of_points` and `of_free` are further parts of these.
    """
    points = [
        errors(
            kinds(OF_ROLLING),
            curve.points.get(xi),
            [coarse.points.get(xi) if coarse else None for coarse in larger],
            parts,
        )
        for xi, parts in zip(xis, of_points, strict=True)
    ]
    of_larger = [coarse.free if coarse else None for coarse in larger]
    return points, errors(kinds(OF_CURVE), curve.free, of_larger, of_free)


# --- whether creepages reach a force ---

BEYOND = 3.0  # times the force without slip from which no curve reaches a force: patches are no ellipses


def forces_beyond_creepages(problem: ContactProblem, sizing: Sizing) -> Iterator[str]:
    """Yield with which friction the force at which ICs are compared is beyond all creepages.

    It need not be within those of the scene: it is found up to the default ones at least. Without slip forces
    are the largest. They are Kalker's, of the ellipse of Hertz, which is larger than the patch of bodies that
    fit each other; circles of other radii beside the crown add to the creepage.
    """
    friction = problem.specification.friction
    if friction is None or problem.specification.extra_gap is not None:
        return
    yield from _beyond_factors(friction)
    (load,) = problem.specification.loads
    ellipse, combined = hertz(sizing.bodies, Loading(load)), problem.pair.constants
    G, nu = float(combined.G), float(combined.nu)
    b = float(np.clip(ellipse.b, ellipse.a / WIDEST, ellipse.a * WIDEST))
    coefficients = creepage_coefficients(ellipse.a, b, nu)
    creepage = max(*map(abs, friction.longitudinal), *CREEPAGES)
    rise = np.ptp(problem.bodies["lower"].contour.position(np.array([-1.0, 0.0, 1.0]) * ellipse.b)[1])
    beside = float(rise) / problem.bodies["upper"].rolling_radius
    reached, _, _ = coefficients.forces(G, creepage + abs(friction.lateral) + beside, 0.0, 0.0)
    for number, coefficient in enumerate(friction.coefficients):
        force = abs(friction.equal_force) * coefficient * load
        if force > BEYOND * reached:
            yield (
                f"contact.friction.{number} = {coefficient:g}: tractions are compared at F_x = equal_force "
                f"friction load = {force:.3g} N, and creepages to {creepage:g} give about {reached:.2g} N "
                "even without slip: give larger ones in contact.longitudinal, less friction, or a smaller "
                "equal_force"
            )


def _beyond_factors(friction: FrictionSpecification) -> Iterator[str]:
    """Yield whether friction that depends on the contact angle is too small for the force everywhere."""
    largest = largest_factor(friction.friction_by_angle)
    if abs(friction.equal_force) > BEYOND * largest:
        yield (
            f"contact.equal_force = {friction.equal_force:g}: tractions are compared at F_x = equal_force "
            f"friction load, and the factors of friction_by_angle are at most {largest:g}: give a smaller "
            "equal_force, or larger factors"
        )
