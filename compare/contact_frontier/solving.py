"""Contacts by one way, solved as `femic contact` solves them: their numbers with estimates, and seconds.

Numbers are along the dimension `case`: loads, or coefficients of friction; with friction also along `point`:
creepages, or loads.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import xarray as xr

from compare.contact.compute import compute_contact
from compare.contact.dataset import case_names, to_dataset
from compare.friction.compute import compute_with_friction
from compare.friction.supports import grid_of
from compare.ics.compute import seconds_of
from femic.contact.motions import MOTIONS
from femic.contact.pairs.automatic_grid import grids_of
from femic.contact.pairs.c_jobs import c_jobs
from femic.contact.pairs.given_ics import C
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.pairs.reference_ics import approximation, full_reference_ics, normal_reference_ics
from femic.contact.specification import ContactProblem
from femic.reference.level import Level
from femic.reference.matrix.job import MatrixJob
from femic.reference.plan import plans, total_seconds
from femic.reference.run_options import RunOptions, Solved, Watch
from femic.scenes.scene import Scene
from geometries.grids import Grid

STAGES = ("ics", "operator", "contact")


@dataclass(frozen=True, eq=False)
class Solution:
    """The numbers of the contacts by some ICs, each with `estimate_NAME`, on their grids, and seconds."""

    numbers: xr.Dataset
    seconds: Mapping[str, float]  # by `STAGES`
    grids: tuple[Grid, ...]

    @property
    def total(self) -> float:
        """All seconds."""
        return sum(self.seconds.values())


def solutions(
    scene: Scene, ics: Sequence[str], options: RunOptions, given: Mapping[str, Any]
) -> dict[str, Solution]:
    """Return the contacts of a scene with some ICs, by their names; `given` are its maps of C.

    Raises as `femic contact`.
    """
    scene = replace(scene, contact=replace(scene.contact, ics=tuple(ics)))
    own = {name: maps for name, maps in given.items() if name in ics}
    of_all = _with_friction if scene.contact.friction else _frictionless
    numbers, seconds, grids = of_all(scene, options, own)
    problem, found = scene.contact_problem, {}
    for name in ics:
        before = _seconds_before(problem, name, grids, options, own)
        of_name = numbers.sel(ics=name, drop=True)
        found[name] = Solution(of_name, before | {"contact": seconds[name]}, grids)
    return found


Parts = tuple[xr.Dataset, Mapping[str, float], tuple[Grid, ...]]  # numbers, seconds of contacts, grids


def _frictionless(scene: Scene, options: RunOptions, given: Mapping[str, Any]) -> Parts:
    results = compute_contact(scene, options, given)
    dataset = to_dataset(results)
    seconds = {str(name): float(dataset.seconds.sel(ics=name).sum()) for name in dataset.ics.values}
    grids = tuple(dict.fromkeys(contact.on_grid.grid for contact in results.solved.contacts.values()))
    return _numbers(dataset).assign_coords(case=case_names(dataset)), seconds, grids


def _with_friction(scene: Scene, options: RunOptions, given: Mapping[str, Any]) -> Parts:
    dataset = compute_with_friction(scene, options, given)
    seconds = {str(name): float(dataset.seconds.sel(ics=name).sum()) for name in dataset.ics.values}
    grids = (grid_of(dataset),)
    along = MOTIONS[scene.contact.motion].dimension
    numbers = _numbers(dataset.rename({along: "point"}))
    load = numbers["point"] if along == "load" else scene.contact.loads[0]
    limit = numbers.friction * load
    cases = [f"friction {friction:g}" for friction in numbers.friction.values]
    with_limit = numbers.assign(limit=limit).drop_vars("friction").rename(friction="case")
    return with_limit.assign_coords(case=cases), seconds, grids


def _numbers(dataset: xr.Dataset) -> xr.Dataset:
    """Return the numbers of a dataset of contacts with their estimates, without maps and pressures."""
    dimensions = {"case", "friction", "point", "ics"}
    names = [str(name)[len("estimate_") :] for name in dataset.data_vars if str(name).startswith("estimate_")]
    kept = [
        prefix + name
        for name in names
        for prefix in ("", "estimate_")
        if prefix + name in dataset and dimensions.issuperset(dataset[prefix + name].dims)
    ]
    return dataset[kept].drop_attrs()


def _seconds_before(
    problem: ContactProblem, name: str, grids: Sequence[Grid], options: RunOptions, given: Mapping[str, Any]
) -> dict[str, float]:
    """Return the seconds of ICs and of their operator on grids; models of C count as they were solved."""
    total = dict.fromkeys(("ics", "operator"), 0.0)
    for grid in grids:
        models = list[Solved]()
        start = perf_counter()
        _prepare(problem, name, grid, replace(options, watch=Watch(on_model=models.append)), given)
        wall = perf_counter() - start
        total["ics"] += _seconds_of(models)
        total["operator"] += max(wall - _seconds_of([model for model in models if not model.cached]), 0.0)
    return total


def _seconds_of(models: Sequence[Solved]) -> float:
    return seconds_of({str(number): solved.model.cost for number, solved in enumerate(models)})


def _prepare(
    problem: ContactProblem, name: str, grid: Grid, options: RunOptions, given: Mapping[str, Any]
) -> None:
    """Make the operator of some ICs, as it is made for a contact."""
    on_grid, friction = pair_on_grid(problem, grid), problem.specification.friction
    if name in given:
        given[name].at(on_grid)
    elif name == C and friction:
        rolls = MOTIONS[problem.specification.motion].wheel_rolls
        full_reference_ics(problem, on_grid, options, wheel_rolls=rolls)
    elif name == C:
        normal_reference_ics(problem, on_grid, options)
    elif friction:
        approximation(on_grid, name)
    else:
        on_grid.operator(name)


def first_models(
    scene: Scene, tolerance: float, grids: Sequence[Grid], options: RunOptions
) -> frozenset[str]:
    """Return the keys of the models with which C begins on grids; equal where all of its cells are."""
    keys = set[str]()
    for jobs in _jobs(scene, tolerance, grids):
        for job in jobs.values():
            engine = job.settings.engine
            levels = Level().models(engine.estimate.models).values()
            keys |= {engine.models.key(job.request(level), options.store) for level in levels}
    return frozenset(keys)


def expected_seconds(scene: Scene, tolerance: float, grids: Sequence[Grid], options: RunOptions) -> float:
    """Return the expected seconds of the models with which C begins on grids at a tolerance."""
    return sum(
        total_seconds(list(plans(jobs, options.workers)), options.workers)
        for jobs in _jobs(scene, tolerance, grids)
    )


def _jobs(scene: Scene, tolerance: float, grids: Sequence[Grid]) -> Iterator[dict[str, MatrixJob]]:
    problem = scene.contact_problem
    problem = replace(problem, settings=replace(problem.settings, tolerance=tolerance))
    for grid in grids:
        yield c_jobs(problem, pair_on_grid(problem, grid))


def grids_for(scene: Scene, elements: int | None) -> tuple[Grid, ...]:
    """Return the grids of C alone in a scene's contact, with some elements across the smallest patch."""
    specification = replace(scene.contact, ics=(C,))
    if elements is not None:
        specification = replace(specification, elements=elements)
    problem = replace(scene.contact_problem, specification=specification)
    return tuple(grid for grid, _ in grids_of(problem))
