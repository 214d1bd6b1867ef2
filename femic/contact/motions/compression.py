"""Compression: bodies pressed on each other with friction, in steps of load.

The load grows in steps half as large as between the loads that are given: errors are of the first order in
them, and estimated from steps that are twice as large. Where compressions are compared, elements and steps
are made larger together: both errors are of the first order, and so is their sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

import numpy as np

from femic.contact.estimates import SAFETY, Measured, changes, errors
from femic.contact.loading import Loading
from femic.contact.motions.motion import COMMON, WITH_FRICTION, Motion
from femic.contact.pairs.quantities import kinds, measured, select
from femic.lazy import lazy_imports
from geometries.errors import Failure

with lazy_imports():
    import xarray as xr

    from femic.contact import datasets, frictional, frictional_problem, normal
    from femic.contact import rolling as solver
    from femic.contact.pairs import pair_with_friction as pairs

OF_COMPRESSION = select("F_y", "M_x", "M_z", "approach", "p_max", "a", "b", "angle", "area", "sliding_share")
Steps = Sequence[Measured]  # after each load


def solve_compression(pair: pairs.PairWithFriction, friction: float, name: str) -> xr.Dataset:
    """Return the compression with the ICs of a name: numbers by load, and maps at the last load.

    Each number has `estimate_NAME`, and `larger_NAME`, `change_NAME` and `floor_NAME` as in
    `femic.contact.datasets`. Raises Failure where there is no contact.
    """
    operator, start = pair.operator(name), perf_counter()  # C has its own seconds
    label, problem = f"friction {friction:g}, {name}", pair.frictional(operator, friction)
    steps, last = solve_steps(pair, problem, label)
    seconds = perf_counter() - start
    pair.options.watch.on_stage(f"  {label}: {len(steps)} loads, {seconds:.1f} s")
    changed = pairs.with_perturbed_ics(pair, friction, name, label, solve_steps)
    estimates = estimate_steps(pair, problem, label, steps, changed[0] if changed else None)
    changed_steps, changed_last = changed or (steps, last)
    larger = None
    if problem.has_coarser:
        larger = pairs.if_possible(
            pair,
            "not in estimates",
            lambda: solve_steps(pair, problem.coarsened, f"{label}, larger elements and steps", halves=False),
        )
    larger_steps, larger_last = larger or (None, None)
    unknown = dict.fromkeys(OF_COMPRESSION, np.nan)
    tables = {
        "": [step.numbers for step in steps],
        "estimate_": estimates,
        datasets.LARGER: [step.numbers for step in larger_steps] if larger_steps else [unknown] * len(steps),
        datasets.CHANGE: [
            pairs.differences(step.numbers, other.numbers)
            for step, other in zip(steps, changed_steps, strict=True)
        ],
        **datasets.difference_errors_of_all(steps, OF_COMPRESSION),
    }
    dataset = xr.Dataset(
        datasets.variables(OF_COMPRESSION, "load", tables) | {"seconds": ((), seconds, datasets.SECONDS)},
        {"load": ("load", list(pair.loads), {"units": "N", "long_name": "prescribed load"})},
    )
    return dataset.merge(datasets.maps(pair.on_grid, last, "mm")).merge(
        datasets.varied_tractions(pair.on_grid, larger_last, changed_last.p - last.p)
    )


def solve_last_load(
    pair: pairs.PairWithFriction, problem: frictional_problem.FrictionalProblem, label: str
) -> tuple[float, dict[str, float]]:
    """Return the last load [N] and the numbers after it; raises Failure where there is no such contact."""
    return pair.loads[-1], dict(solve_steps(pair, problem, label)[0][-1].numbers)


def in_halves(loads: Sequence[float]) -> list[float]:
    """Return loads [N] with one more half way before each of them, from 0 on."""
    before = [0.0, *loads[:-1]]
    return [step for low, load in zip(before, loads, strict=True) for step in ((low + load) / 2, load)]


def solve_steps(
    pair: pairs.PairWithFriction,
    problem: frictional_problem.FrictionalProblem,
    label: str,
    *,
    halves: bool = True,
) -> tuple[Steps, frictional.FrictionalContact]:
    """Return the numbers after each load, and the last contact; in steps from load to load, or in halves."""
    loads, steps = in_halves(pair.loads) if halves else list(pair.loads), list[Measured]()
    try:
        for contact in solver.compressed(problem, [Loading(load) for load in loads]):
            steps.append(measured(pair.on_grid, contact, OF_COMPRESSION))
    except normal.PotentialAreaTooSmall:
        raise
    except Failure as failure:
        raise Failure(f"{label}, {loads[len(steps)]:g} N: {failure}") from failure
    return steps[1::2] if halves else steps, contact


def estimate_steps(
    pair: pairs.PairWithFriction,
    problem: frictional_problem.FrictionalProblem,
    label: str,
    steps: Steps,
    changed: Steps | None = None,
) -> list[dict[str, float]]:
    """Return the estimated errors after each load; `changed` are numbers with C plus its estimate."""
    larger = pairs.on_larger_elements(pair, problem, label, lambda *coarse: solve_steps(*coarse)[0])
    larger_steps, _ = solve_steps(pair, problem, f"{label}, larger steps", halves=False)
    linearised = [pairs.Linearisation.measure(pair.on_grid, problem.operator, load) for load in pair.loads]
    return sum_estimates(steps, larger, larger_steps, changed, linearised)


def sum_estimates(
    steps: Steps,
    on_larger: Sequence[Steps | None],
    larger_steps: Steps,
    changed: Steps | None = None,
    linearised: Sequence[pairs.Linearisation] = (),
) -> list[dict[str, float]]:
    """Return sums of what larger elements, steps of load, C plus its estimate, and other distances change.

    Steps twice as large have twice the error, with the safety factor of elements.
    """
    error_kinds, estimated = kinds(OF_COMPRESSION), []
    for number, fine in enumerate(steps):
        by_steps = changes(fine, error_kinds, larger_steps[number].numbers)
        others = [{name: SAFETY * value for name, value in by_steps.items()}]
        if changed is not None:
            others.append(changes(fine, error_kinds, changed[number].numbers))
        others += [each.part(fine, error_kinds) for each in linearised[number : number + 1]]
        larger = [coarse[number] if coarse else None for coarse in on_larger]
        estimated.append(errors(error_kinds, fine, larger, others))
    return estimated


MOTION = Motion(
    description="with friction, loaded in steps",
    title="Compression with friction",
    keys=("friction", "friction_by_angle"),
    dimension="load",
    quantities=OF_COMPRESSION,
    wants=(*COMMON, *WITH_FRICTION),
    growing=("loads",),
    solve=solve_compression,
    solve_point=solve_last_load,
)
