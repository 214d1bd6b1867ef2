"""A creep-force curve with some ICs, and the estimates: from larger elements, and C plus its estimate."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from femic.contact.estimates import Numbers, changes, errors
from femic.contact.frictional import FrictionalProblem
from femic.contact.operators.protocols import FullOperator
from femic.contact.pairs.creep_force import Continuation, CreepForceCurve
from femic.contact.pairs.displaced import displaced_numbers
from femic.contact.pairs.pair_with_friction import PairWithFriction
from femic.contact.pairs.quantities import OF_CURVE, OF_ROLLING, kinds
from femic.contact.pairs.variations import if_possible, on_larger_elements


@dataclass(frozen=True, eq=False)
class SolvedCurve:
    """A creep-force curve, the estimated errors of its numbers, and numbers with the displaced wheel."""

    curve: CreepForceCurve
    point_errors: Sequence[Numbers]  # of `OF_ROLLING`, by creepage
    curve_errors: Numbers  # of `OF_CURVE`
    displaced: Numbers  # of `OF_DISPLACED`
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
    change = None if perturbed is None else _change(along, curve, perturbed)
    larger = on_larger_elements(pair, problem, along.label, _curve)
    point_errors, curve_errors = _errors(along.xi, curve, larger, change)
    return SolvedCurve(curve, point_errors, curve_errors, displaced_numbers(along, curve), seconds)


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
class Change:
    """By how much numbers of a curve change with the estimated error of C: its points, and the whole."""

    points: Sequence[Numbers]
    free: Numbers


def _change(along: Continuation, curve: CreepForceCurve, operator: FullOperator) -> Change:
    """Return the change with ICs plus their estimated errors: at a few creepages, and linear between these.

    They are the one nearest 0 and those with the largest forces; NaN where no such contact is found.
    """
    pair = along.pair
    problem = pair.frictional(operator, along.problem.problem.friction)
    perturbed = Continuation.of(pair, problem, f"{along.label} plus its estimate")
    rows = {}
    for xi in deciding(curve):
        if contact := perturbed.at_if_possible(xi, curve.contacts[xi]):
            numbers = perturbed.measured(contact).numbers
            rows[xi] = changes(curve.points[xi], kinds(OF_ROLLING), numbers)
    free = if_possible(pair, "no estimates", lambda: perturbed.free([*curve.contacts.values()])[0].numbers)
    free_change = changes(curve.free, kinds(OF_CURVE), free or dict.fromkeys(OF_CURVE, np.nan))
    return Change([between(rows, xi) for xi in along.xi], free_change)


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
    change: Change | None,
) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return estimated errors of the points at all creepages, and of the curve as a whole."""
    points = [
        errors(
            kinds(OF_ROLLING),
            curve.points.get(xi),
            [coarse.points.get(xi) if coarse else None for coarse in larger],
            [change.points[number]] if change else [],
        )
        for number, xi in enumerate(xis)
    ]
    of_larger = [coarse.free if coarse else None for coarse in larger]
    return points, errors(kinds(OF_CURVE), curve.free, of_larger, [change.free] if change else [])
