"""Transient rolling with some ICs: from rest until it is nearly steady, with the estimates of its numbers.

A wheel that was pressed on without tangential tractions rolls at constant creepages, in steps of one element.
At rest the contact does not depend on how the load grew, so that all errors are those of the elements. On
elements twice as large there are half as many steps, and the numbers are interpolated between these.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter

import numpy as np

from femic.contact.estimates import Measured, Numbers, changes, errors
from femic.contact.friction.motion import Creepages
from femic.contact.frictional import FrictionalContact
from femic.contact.frictional_problem import FrictionalProblem
from femic.contact.loading import Loading
from femic.contact.normal import PotentialAreaTooSmall
from femic.contact.pairs.creep_force import Linearisation
from femic.contact.pairs.grids import SIZING
from femic.contact.pairs.pair_with_friction import (
    PairWithFriction,
    if_possible,
    on_larger_elements,
    with_perturbed_ics,
)
from femic.contact.pairs.quantities import OF_ROLLING, half_length, kinds, measured, measured_rolling
from femic.contact.rolling import RollingContact, RollingProblem
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

LENGTHS = 3.0  # of the patch: the rolled distance by default
GROUP = 4  # steps come in groups, so that elements four times as large end at the same distance
MOST_STEPS = 4000
ROUNDING = 1e-9  # of a group of steps


@dataclass(frozen=True, eq=False)
class TransientPath:
    """Numbers at rest and after each step, the contact after the last one, and the steady numbers.

    `steady` is None where steady rolling has no solution; `simplified`, (n,), marks steps that were solved in
    the less accurate form only.
    """

    distances: Array  # mm, (n,), from 0 on
    steps: Sequence[Measured]
    last: FrictionalContact
    simplified: Sequence[bool]
    steady: Measured | None


@dataclass(frozen=True, eq=False)
class SolvedTransient:
    """Transient rolling with some ICs, and the estimated errors of its numbers."""

    path: TransientPath
    errors: Sequence[Numbers]  # by distance
    steady_errors: Numbers
    seconds: float  # without C


def solve_transient(pair: PairWithFriction, friction: float, name: str) -> SolvedTransient:
    """Return transient rolling with the ICs of a name at a coefficient of friction; raises Failure."""
    operator, start = pair.operator(name), perf_counter()  # C has its own seconds
    label, problem = f"friction {friction:g}, {name}", pair.frictional(operator, friction)
    path = solve_path(pair, problem, label)
    seconds = perf_counter() - start
    pair.options.watch.on_stage(f"  {label}: {path.distances[-1]:.3g} mm, {seconds:.1f} s")
    larger = on_larger_elements(pair, problem, label, solve_path)
    perturbed = with_perturbed_ics(pair, friction, name, label, solve_path)
    linearised = Linearisation.measure(pair.on_grid, operator, pair.loads[0])
    return SolvedTransient(path, *_errors(path, larger, perturbed, linearised), seconds)


def last_distance(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> tuple[float, Numbers]:
    """Return the rolled distance [mm] and the numbers there; raises Failure for no such contact."""
    path = solve_path(pair, problem, label)
    return float(path.distances[-1]), path.steps[-1].numbers


def rolled_distance(pair: PairWithFriction) -> float:
    """Return the rolled distance [mm], a multiple of `GROUP` elements of the grid.

    By default it is `LENGTHS` lengths of the frictionless patch with the ICs by which grids are sized. Raises
    WrongInput for more than `MOST_STEPS` steps.
    """
    distance, on_grid = pair.specification.distance, pair.on_grid
    if distance is None:
        contact = on_grid.solve(on_grid.operator(SIZING), Loading(pair.loads[0])).normal
        distance = LENGTHS * 2 * half_length(on_grid, contact)
    group = GROUP * on_grid.grid.dx
    rolled = group * float(np.ceil(distance / group - ROUNDING))
    if rolled > MOST_STEPS * on_grid.grid.dx:
        raise WrongInput(
            f"contact.distance = {distance:g} mm: more than {MOST_STEPS} elements of "
            f"{on_grid.grid.dx:.3g} mm; give a shorter one"
        )
    return rolled


def solve_path(pair: PairWithFriction, problem: FrictionalProblem, label: str) -> TransientPath:
    """Return transient rolling with the ICs and on the grid of a problem; raises Failure."""
    rolling, dx, specification = pair.rolling(problem), problem.grid.dx, pair.specification
    creepages = Creepages(specification.creepage, specification.lateral, specification.spin)
    count = round(rolled_distance(pair) / dx)
    steps, simplified = list[Measured](), list[bool]()
    try:
        for rolled in rolling.transient(creepages, Loading(pair.loads[0]), count):
            steps.append(measured(pair.on_grid, rolled.contact, OF_ROLLING))
            simplified.append(rolled.simplified)
    except PotentialAreaTooSmall:
        raise
    except Failure as failure:
        raise Failure(f"{label}, {len(steps) * dx:.3g} mm: {failure}") from failure
    solve_steady = partial(_steady, pair, rolling, rolled)
    steady = if_possible(pair, f"{label}: no steady rolling", solve_steady)
    distances = dx * np.arange(count + 1, dtype=float)
    return TransientPath(np.asarray(distances), steps, rolled.contact, simplified, steady)


def _steady(pair: PairWithFriction, rolling: RollingProblem, last: RollingContact) -> Measured:
    """Return the numbers in steady rolling at the creepages of the last contact; raises Failure."""
    steady = rolling.contact(last.creepages, Loading(pair.loads[0]), start=last.contact)
    return measured_rolling(pair.on_grid, rolling, steady)


def _errors(
    path: TransientPath,
    larger: Sequence[TransientPath | None],
    perturbed: TransientPath | None,
    linearised: Linearisation,
) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return the estimated errors by distance, and of the steady numbers."""
    coarse = [interpolated(other, path.distances) if other else None for other in larger]
    by_distance = [
        _errors_of(
            fine,
            [steps[n] if steps else None for steps in coarse],
            perturbed.steps[n] if perturbed else None,
            linearised,
        )
        for n, fine in enumerate(path.steps)
    ]
    steady = [other.steady if other else None for other in larger]
    return by_distance, _errors_of(path.steady, steady, perturbed.steady if perturbed else None, linearised)


def _errors_of(
    fine: Measured | None,
    larger: Sequence[Measured | None],
    perturbed: Measured | None,
    linearised: Linearisation,
) -> dict[str, float]:
    """Return the estimated errors of a contact, with changes by the estimate of C and by the distance."""
    of_all = kinds(OF_ROLLING)
    others = [changes(fine, of_all, perturbed.numbers)] if fine is not None and perturbed is not None else []
    if fine is not None:
        others.append(linearised.part(fine, of_all))
    return errors(of_all, fine, larger, others)


def interpolated(path: TransientPath, distances: Array) -> list[Measured]:
    """Return the numbers of a path at other distances [mm]: linear between its steps."""
    rows = {
        name: np.interp(distances, path.distances, [step.numbers[name] for step in path.steps])
        for name in path.steps[0].numbers
    }
    return [
        replace(path.steps[-1], numbers={name: float(row[number]) for name, row in rows.items()})
        for number in range(len(distances))
    ]
