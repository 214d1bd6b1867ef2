"""Transient rolling: from rest until it is nearly steady, at constant creepages.

A wheel that was pressed on without tangential tractions rolls in steps of one element. At rest the contact
does not depend on how the load grew, so that all errors are those of the elements. On elements twice as large
there are half as many steps, and the numbers are interpolated between these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from femic.contact.estimates import Measured, Numbers, changes, errors
from femic.contact.friction.motion import Creepages
from femic.contact.loading import Loading
from femic.contact.motions.motion import Motion
from femic.contact.motions.rolling import OF_ROLLING, measured_rolling
from femic.contact.pairs.quantities import half_length, kinds, measured
from femic.lazy import lazy_imports
from geometries.arrays import Array
from geometries.errors import Failure, WrongInput

with lazy_imports():
    import xarray as xr

    from femic.contact import datasets, frictional, frictional_problem, normal
    from femic.contact.pairs import grids
    from femic.contact.pairs import pair_with_friction as pairs
    from femic.contact.specification import ContactSpecification

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
    last: frictional.FrictionalContact
    simplified: Sequence[bool]
    steady: Measured | None


def solve_transient(pair: pairs.PairWithFriction, friction: float, name: str) -> xr.Dataset:
    """Return transient rolling with the ICs of a name: numbers by rolled `distance`, maps at the last one.

    Each number has `estimate_NAME`. `steady_NAME` is that in steady rolling at the same creepages, with
    `estimate_steady_NAME`; `simplified` marks steps that were solved in the less accurate form only. Raises
    Failure where there is no contact.
    """
    operator, start = pair.operator(name), perf_counter()  # C has its own seconds
    label, problem = f"friction {friction:g}, {name}", pair.frictional(operator, friction)
    path = solve_path(pair, problem, label)
    seconds = perf_counter() - start
    pair.options.watch.on_stage(f"  {label}: {path.distances[-1]:.3g} mm, {seconds:.1f} s")
    changed = pairs.with_perturbed_ics(pair, friction, name, label, solve_path)
    estimates, steady_estimates = estimate_path(pair, problem, label, path, changed)
    steady = path.steady.numbers if path.steady else dict.fromkeys(OF_ROLLING, np.nan)
    by_distance = {"": [step.numbers for step in path.steps], "estimate_": estimates}
    numbers = {
        **datasets.variables(OF_ROLLING, "distance", by_distance),
        **datasets.variables(
            OF_ROLLING, (), {datasets.STEADY: steady, f"estimate_{datasets.STEADY}": steady_estimates}
        ),
        "simplified": ("distance", list(path.simplified), datasets.SIMPLIFIED),
        "seconds": ((), seconds, datasets.SECONDS),
    }
    distance = "distance", path.distances, {"units": "mm", "long_name": "rolled distance"}
    return xr.Dataset(numbers, coords={"distance": distance}).merge(datasets.maps(pair.on_grid, path.last))


def solve_last_distance(
    pair: pairs.PairWithFriction, problem: frictional_problem.FrictionalProblem, label: str
) -> tuple[float, Numbers]:
    """Return the rolled distance [mm] and the numbers there; raises Failure for no such contact."""
    path = solve_path(pair, problem, label)
    return float(path.distances[-1]), path.steps[-1].numbers


def rolled_distance(pair: pairs.PairWithFriction) -> float:
    """Return the rolled distance [mm], a multiple of `GROUP` elements of the grid.

    By default it is `LENGTHS` lengths of the frictionless patch with the ICs by which grids are sized. Raises
    WrongInput for more than `MOST_STEPS` steps.
    """
    distance, on_grid = pair.specification.distance, pair.on_grid
    if distance is None:
        contact = on_grid.solve(on_grid.operator(grids.SIZING), Loading(pair.loads[0])).normal
        distance = LENGTHS * 2 * half_length(on_grid, contact)
    group = GROUP * on_grid.grid.dx
    rolled = group * float(np.ceil(distance / group - ROUNDING))
    if rolled > MOST_STEPS * on_grid.grid.dx:
        raise WrongInput(
            f"contact.distance = {distance:g} mm: more than {MOST_STEPS} elements of "
            f"{on_grid.grid.dx:.3g} mm; give a shorter one"
        )
    return rolled


def solve_path(
    pair: pairs.PairWithFriction, problem: frictional_problem.FrictionalProblem, label: str
) -> TransientPath:
    """Return transient rolling with the ICs and on the grid of a problem; raises Failure."""
    rolling, dx, specification = pair.rolling(problem), problem.grid.dx, pair.specification
    creepages = Creepages(specification.creepage, specification.lateral, specification.spin)
    loading, count = Loading(pair.loads[0]), round(rolled_distance(pair) / dx)
    steps, simplified = list[Measured](), list[bool]()
    try:
        for rolled in rolling.transient(creepages, loading, count):
            steps.append(measured(pair.on_grid, rolled.contact, OF_ROLLING))
            simplified.append(rolled.simplified)
    except normal.PotentialAreaTooSmall:
        raise
    except Failure as failure:
        raise Failure(f"{label}, {len(steps) * dx:.3g} mm: {failure}") from failure
    last = rolled.contact

    def solve_steady() -> Measured:
        return measured_rolling(pair.on_grid, rolling, rolling.contact(creepages, loading, start=last))

    steady = pairs.if_possible(pair, f"{label}: no steady rolling", solve_steady)
    return TransientPath(dx * np.arange(count + 1, dtype=float), steps, last, simplified, steady)


def estimate_path(
    pair: pairs.PairWithFriction,
    problem: frictional_problem.FrictionalProblem,
    label: str,
    path: TransientPath,
    changed: TransientPath | None = None,
) -> tuple[list[dict[str, float]], dict[str, float]]:
    """Return the estimated errors of numbers by distance, and of the steady ones.

    `changed` is the path with C plus its estimate.
    """
    larger = pairs.on_larger_elements(pair, problem, label, solve_path)
    linearised = pairs.Linearisation.measure(pair.on_grid, problem.operator, pair.loads[0])
    error_kinds = kinds(OF_ROLLING)

    def estimate(
        fine: Measured | None, coarse: Sequence[Measured | None], other: Measured | None
    ) -> dict[str, float]:
        parts = []
        if fine is not None and other is not None:
            parts.append(changes(fine, error_kinds, other.numbers))
        if fine is not None:
            parts.append(linearised.part(fine, error_kinds))
        return errors(error_kinds, fine, coarse, parts)

    between = [interpolate_path(other, path.distances) if other else None for other in larger]
    by_distance = [
        estimate(
            fine, [steps[n] if steps else None for steps in between], changed.steps[n] if changed else None
        )
        for n, fine in enumerate(path.steps)
    ]
    steady = [other.steady if other else None for other in larger]
    return by_distance, estimate(path.steady, steady, changed.steady if changed else None)


def interpolate_path(path: TransientPath, distances: Array) -> list[Measured]:
    """Return the numbers of a path at other distances [mm]: linear between its steps."""
    rows = {
        name: np.interp(distances, path.distances, [step.numbers[name] for step in path.steps])
        for name in path.steps[0].numbers
    }
    return [
        replace(path.steps[-1], numbers={name: float(row[number]) for name, row in rows.items()})
        for number in range(len(distances))
    ]


def add_creepages(dataset: xr.Dataset, specification: ContactSpecification) -> xr.Dataset:
    """Return the dataset of all ICs with load [N] and creepages as attributes."""
    creepages = {
        name: float(getattr(specification.friction, name)) for name in ("creepage", "lateral", "spin")
    }
    return dataset.assign_attrs(load=specification.loads[0], **creepages)


MOTION = Motion(
    description="rolling from rest, at one load",
    title="Transient rolling with friction",
    keys=("friction", "friction_by_angle", "creepage", "lateral", "spin", "distance"),
    dimension="distance",
    quantities=OF_ROLLING,
    wheel_rolls=True,
    solve=solve_transient,
    solve_point=solve_last_distance,
    complete=add_creepages,
)
