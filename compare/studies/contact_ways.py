"""The ways to the numbers of a contact: their solutions, and their errors against a reference.

A way is ICs, elements across the patch, and the tolerance of C. Contacts are solved as `femic contact` solves
them. Their numbers are along the dimension `case`: loads, or coefficients of friction; with friction also
along `point`: creepages, or loads.

An error is the largest over the creepages or loads of a case, each over its scale: `femic.scenes.wants`. No
error is known better than the reference is: with the reference's estimate it is at most its bound.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from approx.variants import VARIANTS, needs_effective
from compare.studies.frontier import tolerance_ladder
from femic.contact.datasets import read_grid
from femic.contact.motions import MOTIONS
from femic.contact.motions import motion as wants
from femic.contact.motions.motion import KNOWN, Scale, Want
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import C, approximation, c_jobs, full_reference_ics, normal_reference_ics
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.specification import ContactProblem, ContactSpecification
from femic.reference.matrix.job import MatrixJob
from femic.reference.refinement import plans, total_seconds
from femic.reference.run_options import Level, RunOptions, Solved, Watch
from femic.results.contact import case_names, compute_contact, map_names, to_dataset
from femic.results.friction import compute_with_friction
from femic.results.ics import seconds_of
from femic.scenes.ic_names import is_map
from femic.scenes.scene import Scene
from geometries.patches import Grid

# --- errors and their scales ----------------------------------------------------------------------------


ESTIMATE = "estimate_"  # before the name of a number
ScaleFunction = Callable[[xr.Dataset, str], xr.DataArray]


def _itself(reference: xr.Dataset, name: str) -> xr.DataArray:
    return abs(reference[name])


SCALE_FUNCTIONS: Mapping[Scale, ScaleFunction] = {
    wants.ITSELF: _itself,
    wants.ITSELF_WHERE_KNOWN: _itself,
    wants.LIMIT: lambda reference, _: reference["limit"],
    wants.LOAD: lambda reference, _: reference["load"],
    wants.HALF_WIDTH: lambda reference, _: reference["b"],
    wants.WHOLE: lambda reference, name: xr.ones_like(reference[name]),
    wants.SATURATION: lambda reference, _: abs(reference["limit"] / reference["slope"]),
}


def scale_of(want: Want, reference: xr.Dataset) -> xr.DataArray:
    """Return what errors of a number are shares of; NaN where the reference does not know it well enough."""
    scale = SCALE_FUNCTIONS[want.scale](reference, want.number)
    if want.scale.vanishing:
        scale = scale.where(scale > KNOWN * reference[ESTIMATE + want.number])
    return scale.where(scale > 0)


DIMENSIONS = ("way", "number", "case")


def error_variables(
    solutions: Mapping[str, xr.Dataset], wants: Sequence[Want], reference: str
) -> dict[str, xr.DataArray]:
    """Return errors [-] over way, number and case of solutions by the names of ways.

    `error`: the largest deviation from the reference, of the reference itself its estimate; `bound`: with the
    reference's estimate added, where the sum is largest; `estimate`: a way's own estimate. Each is NaN where
    a way has no solution, or a case has no number that is known as a share. `judged` and `points` (number,
    case): how many of the case's numbers are known so, and how many there are.
    """
    names = sorted({prefix + want.number for want in wants for prefix in ("", ESTIMATE)})
    ways = xr.DataArray(list(solutions), dims="way", name="way")
    stacked = xr.concat([solution[names] for solution in solutions.values()], ways)
    parts = [_of_want(stacked, solutions[reference], want, reference) for want in wants]
    numbers = xr.DataArray([want.name for want in wants], dims="number", name="number")
    joined = {name: xr.concat([part[name] for part in parts], numbers) for name in parts[0]}
    return {
        name: values.transpose(*(dimension for dimension in DIMENSIONS if dimension in values.dims))
        for name, values in joined.items()
    }


def _of_want(
    stacked: xr.Dataset, of_reference: xr.Dataset, want: Want, reference: str
) -> dict[str, xr.DataArray]:
    """Return the variables of a number; `stacked` has the numbers of all ways."""
    number, estimate = want.number, ESTIMATE + want.number
    scale, others = scale_of(want, of_reference), stacked.way != reference
    own = of_reference[estimate] / scale
    judged = own.notnull() & (own < np.inf)
    away = abs(stacked[number] - of_reference[number]) / scale
    return {
        "error": _largest(away.where(others, own), judged),
        "bound": _largest((away + own).where(others, own), judged),
        "estimate": _largest(stacked[estimate] / scale, judged),
        "judged": _over_points(judged.astype(int), "sum"),
        "points": _over_points(of_reference[number].notnull().astype(int), "sum"),
    }


def _largest(shares: xr.DataArray, judged: xr.DataArray) -> xr.DataArray:
    """Return the largest share over the points that are judged; NaN without one, or where one is missing."""
    missing = _over_points(judged & shares.isnull(), "any")
    return _over_points(shares.where(judged), "max").where(~missing)


def _over_points(values: xr.DataArray, how: str) -> xr.DataArray:
    return getattr(values, how)("point") if "point" in values.dims else values


def worst(dataset: xr.Dataset, names: Sequence[str], case: str | None = None) -> xr.Dataset:
    """Return the errors of the ways in the worst of some numbers, and over all cases unless one is named.

    Variables over `way`: `error`, at least the reference's estimate; `bound`, with it; `floor`, this
    estimate; `number` and `case`, where the bound is largest; `seconds`. NaN where a way has no solution, or
    where no error is known as a share.
    """
    cases = list(dataset.case.values) if case is None else [case]
    chosen = dataset.sel(number=list(names), case=cases)
    judged = np.argwhere(chosen.judged.transpose("number", "case").values > 0)
    places = judged if len(judged) else np.zeros((1, 2), dtype=int)
    bounds, errors = (chosen[name].transpose(*DIMENSIONS).values[:, *places.T] for name in ("bound", "error"))
    missing, rows = np.isnan(bounds).any(axis=1), np.arange(len(bounds))
    where = np.argmax(np.where(np.isnan(bounds), np.inf, bounds), axis=1)
    own = bounds[list(dataset.way.values).index(dataset.attrs["best"]), where]
    number, at_case = places[where].T
    unknown = missing | (len(judged) == 0)
    shares = {"error": np.maximum(errors[rows, where], own), "bound": bounds[rows, where], "floor": own}
    return dataset[["seconds"]].assign(
        {name: ("way", np.where(unknown, np.nan, values)) for name, values in shares.items()}
        | {"number": ("way", chosen.number.values[number]), "case": ("way", chosen.case.values[at_case])}
    )


# --- ways -----------------------------------------------------------------------------------------------


APPROXIMATION, MAP_OF_C = "approximation", "map"  # kinds of ways without C, beside the names of engines
FEWEST, MOST = 8, 64  # elements across the smallest patch, as a specification may have them
TIGHTEST = 0.001  # tolerance of C: estimates of contacts come from their elements long before


@dataclass(frozen=True)
class Way:
    """ICs by name, the elements across the smallest patch, and the engine and the tolerance of C.

    `elements` is None where the scene gives the grid, or a map of C does.
    """

    ics: str
    elements: int | None
    kind: str  # `APPROXIMATION`, `MAP_OF_C`, or the name of an engine
    tolerance: float | None = None

    @property
    def name(self) -> str:
        """The name of this way in files: Bhat, 20 elements; C 0.01, 40 elements."""
        ics = self.ics if self.tolerance is None else f"{self.ics} {self.tolerance:g}"
        return ics if self.elements is None else f"{ics}, {self.elements} elements"

    @property
    def changes(self) -> dict[str, Any]:
        """The keys of a scene file that this way changes."""
        contact: dict[str, Any] = {"ics": [self.ics]}
        if self.elements is not None:
            contact["elements"] = self.elements
        engine = {} if self.tolerance is None else {"engine": {"tolerance": self.tolerance, "check": False}}
        return {"contact": contact} | engine


def fineness(specification: ContactSpecification) -> Sequence[int | None]:
    """Return the elements across the smallest patch that are tried: half, as many, and twice as many."""
    if not specification.automatic:
        return [None]
    as_given = specification.elements
    return sorted({max(as_given // 2, FEWEST), as_given, min(2 * as_given, MOST)})


def approximations(scene: Scene) -> list[str]:
    """Return the approximations that are tried: all variants, and exchanged ones that the scene names.

    B-hat-prime needs effective properties of both bodies.
    """
    named = [name for name in scene.contact.ics if name != C and not is_map(name)]
    fitted = scene.pair.has_effective("combined")
    return [name for name in dict.fromkeys([*VARIANTS, *named]) if fitted or not needs_effective(name)]


def ways_of(scene: Scene, tightest: float = TIGHTEST) -> Iterator[Way]:
    """Yield all ways to the contact of a scene; of C down to the first tolerance not above `tightest`.

    On coarser grids C has the loosest tolerance, since errors of these grids are larger; on finer ones it has
    the first two, for the same reason.
    """
    numbers_of_elements = fineness(scene.contact)
    for elements in numbers_of_elements:
        for name in approximations(scene):
            yield Way(name, elements, APPROXIMATION)
        for tolerance in _tolerances(scene, elements, tightest):
            yield Way(C, elements, scene.settings.engine.name, tolerance)
    for name in map_names(scene.contact.ics):
        yield Way(name, None, MAP_OF_C)


def _tolerances(scene: Scene, elements: int | None, tightest: float) -> Sequence[float]:
    ladder = tolerance_ladder(scene.settings.engine.name)
    looser = [tolerance for tolerance in ladder if tolerance > tightest]
    tolerances = ladder[: len(looser) + 1]
    if elements is None or elements == scene.contact.elements:
        return tolerances
    return tolerances[:1] if elements < scene.contact.elements else tolerances[:2]


# --- solutions ------------------------------------------------------------------------------------------


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
    grids = (read_grid(dataset),)
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
    names = [str(name).removeprefix(ESTIMATE) for name in dataset.data_vars if str(name).startswith(ESTIMATE)]
    kept = [
        prefix + name
        for name in names
        for prefix in ("", ESTIMATE)
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
            levels = Level().models(engine.models).values()
            keys |= {engine.key(job.request(level), options.store) for level in levels}
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
