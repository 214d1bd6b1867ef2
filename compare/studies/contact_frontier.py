"""The frontier of a contact: errors of its numbers and seconds of every way to them, within a budget.

A way is ICs, elements across the patch, and the tolerance of C. Contacts are solved as `femic contact` solves
them. Their numbers are along the dimension `case`: loads [N], approaches [mm], or coefficients of friction;
with friction also along `point`: creepages, or loads.

An error is the largest over the creepages or loads of a case, each over its scale: `femic.scenes.wants`. No
error is known better than the reference is: with the reference's estimate it is at most its bound.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from approx.variants import VARIANTS, needs_effective
from compare.report.looks import ics_symbol
from compare.studies.frontier import (
    APPROXIMATION,
    Method,
    require_budget,
    require_reference,
    solve_within_budget,
    study_attributes,
    tolerance_ladder,
    vanishing,
    way_coordinates,
)
from femic.contact.datasets import read_grid
from femic.contact.motions import MOTIONS
from femic.contact.motions import motion as scales
from femic.contact.motions.motion import KNOWN, Scale, Want
from femic.contact.pairs.grids import grids_of
from femic.contact.pairs.ics import C, approximation, c_jobs, full_reference_ics, normal_reference_ics
from femic.contact.pairs.pair_on_grid import pair_on_grid
from femic.contact.specification import ContactProblem
from femic.reference.matrix.job import MatrixJob
from femic.reference.refinement import plans, total_seconds
from femic.reference.run_options import DEFAULT, Level, RunOptions, Solved, Watch
from femic.results.contact import map_names, require_solvable, solve_scene, to_dataset
from femic.results.friction import compute_with_friction
from femic.results.ics import solver_seconds
from femic.results.matrices import discounted
from femic.scenes.ic_names import is_map
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from femic.scenes.wants import chosen_wants, wants_of
from geometries.patches import Grid

# --- ways -----------------------------------------------------------------------------------------------


MAP_OF_C = "map"  # the kind of maps of C
FEWEST, MOST = 8, 64  # elements across the smallest patch, as a specification may have them
TIGHTEST = 0.001  # tolerance of C: estimates of contacts come from their elements long before
STAGES = ("ics", "operator", "contact")
ESTIMATE = "estimate_"  # before the name of a number
NO_MAPS: Mapping[str, Any] = {}
GROWTH = 2.5  # exponent of the elements across a patch in the seconds of contacts: measured 1 to 3
FURTHER = 4.0  # seconds of a contact with its estimates, over those of the contact alone


def approximations(scene: Scene) -> list[str]:
    """Return the approximations that are tried: all variants, and exchanged ones that the scene names.

    B-hat-prime needs effective properties of both bodies.
    """
    named = [name for name in scene.contact.ics if name != C and not is_map(name)]
    fitted = scene.pair.has_effective("combined")
    return [name for name in dict.fromkeys([*VARIANTS, *named]) if fitted or not needs_effective(name)]


def contact_methods(scene: Scene, tightest: float = TIGHTEST) -> Iterator[Method]:
    """Yield all ways to the contact of a scene; of C down to the first tolerance not above `tightest`.

    Grids are those of the scene, half as fine and twice as fine. On coarser ones C has the loosest tolerance,
    since errors of these grids are larger; on finer ones it has the first two, for the same reason.
    """
    given, engine = scene.contact.elements, scene.settings.engine.name
    ladder = tolerance_ladder(engine)
    tolerances = ladder[: 1 + sum(tolerance > tightest for tolerance in ladder)]
    fineness = (
        sorted({max(given // 2, FEWEST), given, min(2 * given, MOST)}) if scene.contact.automatic else [0]
    )
    for elements in fineness:
        for name in approximations(scene):
            yield contact_method(name, APPROXIMATION, elements)
        number = len(tolerances) if elements in (0, given) else 1 if elements < given else 2
        for tolerance in tolerances[:number]:
            yield contact_method(C, engine, elements, tolerance)
    for name in map_names(scene.contact.ics):
        yield contact_method(name, MAP_OF_C)


def contact_method(ics: str, kind: str, elements: int = 0, tolerance: float = np.nan) -> Method:
    """Return a way to a contact; its name is that of the ICs with the tolerance of C and elements."""
    name, label, contact = ics, ics_symbol(ics), dict[str, Any](ics=[ics])
    if elements:
        contact["elements"] = elements
    changes: dict[str, Any] = {"contact": contact}
    if not np.isnan(tolerance):
        name, label = f"{ics} {tolerance:g}", f"{label} ({tolerance:g})"
        changes["engine"] = {"tolerance": tolerance, "check": False}
    across = f", {elements} elements" if elements else ""
    return Method(name + across, label + across, kind, ics, tolerance, elements, changes)


# --- the frontier ---------------------------------------------------------------------------------------


def require_comparable(scene: Scene, names: Sequence[str] = (), budget: float = np.inf) -> tuple[Want, ...]:
    """Return the wanted numbers of a scene's contact, by default all; raise WrongInput before any work.

    Raises it for unknown numbers, contacts that are not compared, a budget [s] that is not positive, and as
    `require_solvable` with C.
    """
    require_budget(budget)
    wants = chosen_wants(scene.contact, names or [want.name for want in wants_of(scene.contact)])
    ics = tuple(dict.fromkeys([*scene.contact.ics, C]))
    require_solvable(replace(scene, contact=replace(scene.contact, ics=ics)))
    return wants


def compute_contact_frontier(
    base: str,
    names: Sequence[str] = (),
    options: RunOptions = DEFAULT,
    given: Mapping[str, Any] = NO_MAPS,
    *,
    budget: float = np.inf,
    tightest: float = TIGHTEST,
    as_shares: bool = False,
) -> xr.Dataset:
    """Compute the errors and seconds of every way to a scene's contact that fits a budget of seconds.

    `names` are the numbers compared, none: all; `given` are the maps of C that the scene names; C is tried
    down to `tightest`. Approximations come first, then C, cheapest first. Errors are those of
    `error_variables`, against the C with the smallest estimates. Raises WrongInput as `require_comparable`,
    Failure where no C fits into the budget, and, `as_shares`, before C is solved where a number vanishes with
    all approximations.
    """
    scene = load_scene(base)
    wants = require_comparable(scene, names, budget)
    solver, methods = _Solver(base, scene, options, given), list(contact_methods(scene, tightest))
    groups: dict[int, list[Method]] = {}
    for method in methods:
        if method.kind == APPROXIMATION:
            groups.setdefault(method.elements, []).append(method)
    skipped = solver.solve(groups.values(), budget)
    for want in wants if as_shares else ():
        known = [error_scale(want, numbers).notnull().any() for numbers in solver.solved.values()]
        if known and not any(known):
            raise vanishing(want.name, "its estimated error with any approximation")
    first: dict[tuple[int, frozenset[str]], Method] = {}
    for method in methods:
        if not np.isnan(method.tolerance):
            models = first_models(scene, method.tolerance, solver.grids_of_c(method), options)
            looser = first.setdefault((method.elements, models), method)
            if looser is not method:
                skipped[method.name] = f"starts with the same cells as {looser.name}"
    others = [*first.values(), *(method for method in methods if method.kind == MAP_OF_C)]
    skipped |= solver.solve([[method] for method in others], budget)
    references = {method: solver.solved[method] for method in first.values() if method in solver.solved}
    require_reference(references, skipped, budget)
    best = best_reference(references, wants, scene)
    return frontier_dataset(solver.solved, wants, best).assign_attrs(
        study_attributes(scene, best.name, skipped),
        motion=scene.contact.motion,
        discounted=discounted(scene),
    )


@dataclass(frozen=True, eq=False)
class _Solver:
    """Solves the contacts of a scene by ways, and predicts their seconds from what was solved before."""

    base: str
    scene: Scene
    options: RunOptions
    given: Mapping[str, Any]
    solved: dict[Method, xr.Dataset] = field(default_factory=dict)
    walls: dict[int, float] = field(default_factory=dict)  # seconds of all approximations, by elements
    expected: dict[Method, float] = field(default_factory=dict)  # seconds of the models of C
    grids: dict[int, tuple[Grid, ...]] = field(default_factory=dict)  # of C alone, by elements
    start: float = field(default_factory=perf_counter)

    def solve(self, groups: Iterable[Sequence[Method]], budget: float) -> dict[str, str]:
        """Solve groups of ways as long as they fit what is left of a budget; say why others are skipped."""

        def left() -> float:
            return budget - (perf_counter() - self.start)

        return solve_within_budget(groups, self.predict, self._solve, left, self.options)

    def _solve(self, group: Sequence[Method]) -> None:
        start, first = perf_counter(), group[0]
        scene, ics = load_scene(self.base, first.changes), [method.ics for method in group]
        found = solve_contacts(scene, ics, self.options, self.given)
        self.solved.update({method: found[method.ics] for method in group})
        if first.kind == APPROXIMATION:
            wall = self.walls.get(first.elements, 0.0)
            self.walls[first.elements] = wall + perf_counter() - start

    def predict(self, group: Sequence[Method]) -> float:
        """Return the expected seconds of ways that are solved together."""
        method = group[0]
        with_c, elements = not np.isnan(method.tolerance), method.elements
        if with_c and method not in self.expected:
            grids = self.grids_of_c(method)
            self.expected[method] = expected_seconds(self.scene, method.tolerance, grids, self.options)
        models = self.expected.get(method, 0.0)
        if method.kind == MAP_OF_C or not self.walls:
            return models
        nearest = min(self.walls, key=lambda other: abs(other - elements))
        growth = (elements / nearest if nearest else 1.0) ** GROWTH
        if not with_c:
            return self.walls[nearest] * growth
        slowest = max(
            numbers.contact_seconds.item()
            for other, numbers in self.solved.items()
            if other.kind == APPROXIMATION and other.elements == nearest
        )
        return models + FURTHER * slowest * growth

    def grids_of_c(self, method: Method) -> tuple[Grid, ...]:
        """Return the grids of C alone, with the elements of a way across the smallest patch."""
        elements = method.elements
        if elements not in self.grids:
            given = self.scene.contact
            specification = replace(given, ics=(C,), elements=elements or given.elements)
            problem = replace(self.scene.contact_problem, specification=specification)
            self.grids[elements] = tuple(grid for grid, _ in grids_of(problem))
        return self.grids[elements]


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


def best_reference(references: Mapping[Method, xr.Dataset], wants: Sequence[Want], scene: Scene) -> Method:
    """Return the C whose wanted numbers have the smallest worst estimate; among equal ones, all numbers.

    Of wanted numbers that may all vanish, none has an estimate that is a share.
    """
    every = wants_of(scene.contact)
    return min(references, key=lambda way: [worst_estimate(references[way], some) for some in (wants, every)])


def worst_estimate(numbers: xr.Dataset, wants: Iterable[Want]) -> float:
    """Return the largest estimate of numbers that cannot vanish, over its scale [-]; infinite if unknown."""
    shares = [0.0]
    for want in wants:
        scale = error_scale(want, numbers)
        if not want.scale.vanishing and scale.notnull().any():
            own = numbers[ESTIMATE + want.number] / scale
            shares.append(float(own.where(scale.notnull(), 0.0).max(skipna=False)))
    return float(np.max(np.nan_to_num(shares, nan=np.inf)))


# --- solutions ------------------------------------------------------------------------------------------


def solve_contacts(
    scene: Scene, ics: Sequence[str], options: RunOptions, given: Mapping[str, Any]
) -> dict[str, xr.Dataset]:
    """Return the numbers of a scene's contacts, each with `estimate_NAME`, by some ICs.

    `given` are maps of C by name. With the numbers are `ics_seconds`, `operator_seconds`,
    `contact_seconds`, and the `strips` of the finest grid. Raises as `femic contact`.
    """
    scene = replace(scene, contact=replace(scene.contact, ics=tuple(ics)))
    own = {name: maps for name, maps in given.items() if name in ics}
    if scene.contact.friction:
        dataset = compute_with_friction(scene, options, own)
        grids: tuple[Grid, ...] = (read_grid(dataset),)
        along = MOTIONS[scene.contact.motion].dimension
        load = dataset[along] if along == "load" else scene.contact.loads[0]
        dataset = dataset.assign(limit=dataset.friction * load).rename({along: "point", "friction": "case"})
        case = {"units": "1", "long_name": "coefficient of friction"}
        limits = ["limit"]
    else:
        solved = solve_scene(scene, options, own)
        grids = tuple(dict.fromkeys(contact.on_grid.grid for contact in solved.contacts.values()))
        dataset, limits = to_dataset(scene, solved), []
        case = dataset.case.attrs
    estimated = [str(name) for name in dataset.data_vars if str(name).startswith(ESTIMATE)]
    kept = [
        name
        for name in [*(name.removeprefix(ESTIMATE) for name in estimated), *estimated, *limits]
        if name in dataset and {"case", "point", "ics"}.issuperset(dataset[name].dims)
    ]
    seconds, dataset = dataset.seconds, dataset[kept].drop_attrs()
    dataset.case.attrs = case
    found = {}
    for name in ics:
        before = _seconds_before(scene.contact_problem, name, grids, options, own)
        found[name] = dataset.sel(ics=name, drop=True).assign(
            ics_seconds=before["ics"],
            operator_seconds=before["operator"],
            contact_seconds=float(seconds.sel(ics=name).sum()),
            strips=max(grid.n_s for grid in grids),
        )
    return found


def _seconds_before(
    problem: ContactProblem, name: str, grids: Sequence[Grid], options: RunOptions, given: Mapping[str, Any]
) -> dict[str, float]:
    """Return the seconds of ICs and of their operator on grids; models of C count as they were solved."""
    total, friction = dict.fromkeys(("ics", "operator"), 0.0), problem.specification.friction
    for grid in grids:
        models, start = list[Solved](), perf_counter()
        on_grid, watched = pair_on_grid(problem, grid), replace(options, watch=Watch(on_model=models.append))
        if name in given:
            given[name].at(on_grid)
        elif name == C and friction:
            rolls = MOTIONS[problem.specification.motion].wheel_rolls
            full_reference_ics(problem, on_grid, watched, wheel_rolls=rolls)
        elif name == C:
            normal_reference_ics(problem, on_grid, watched)
        elif friction:
            approximation(on_grid, name)
        else:
            on_grid.operator(name)
        wall = perf_counter() - start
        costs = {str(number): solved.model.cost for number, solved in enumerate(models)}
        solved_now = {str(k): costs[str(k)] for k, solved in enumerate(models) if not solved.cached}
        total["ics"] += solver_seconds(costs)
        total["operator"] += max(wall - solver_seconds(solved_now), 0.0)
    return total


# --- errors and their scales ----------------------------------------------------------------------------


SCALE_FUNCTIONS: Mapping[Scale, Callable[[xr.Dataset, str], xr.DataArray]] = {
    scales.ITSELF: lambda reference, name: abs(reference[name]),
    scales.ITSELF_WHERE_KNOWN: lambda reference, name: abs(reference[name]),
    scales.LIMIT: lambda reference, _: reference["limit"],
    scales.LOAD: lambda reference, _: reference["load"],
    scales.HALF_WIDTH: lambda reference, _: reference["b"],
    scales.WHOLE: lambda reference, name: xr.ones_like(reference[name]),
    scales.SATURATION: lambda reference, _: abs(reference["limit"] / reference["slope"]),
}


def error_scale(want: Want, reference: xr.Dataset) -> xr.DataArray:
    """Return what errors of a number are shares of; NaN where the reference does not know it well enough."""
    scale = SCALE_FUNCTIONS[want.scale](reference, want.number)
    if want.scale.vanishing:
        scale = scale.where(scale > KNOWN * reference[ESTIMATE + want.number])
    return scale.where(scale > 0)


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
    exact, others = solutions[reference], stacked.way != reference

    def over_points(values: xr.DataArray, how: str) -> xr.DataArray:
        return getattr(values, how)("point") if "point" in values.dims else values

    parts = []
    for want in wants:
        number, estimate = want.number, ESTIMATE + want.number
        scale = error_scale(want, exact)
        own = exact[estimate] / scale
        away = abs(stacked[number] - exact[number]) / scale
        judged = own.notnull() & (own < np.inf)
        shares = {
            "error": away.where(others, own),
            "bound": (away + own).where(others, own),
            "estimate": stacked[estimate] / scale,
        }
        part = {
            name: over_points(share.where(judged), "max").where(
                ~over_points(judged & share.isnull(), "any")  # without a solution at one point there is none
            )
            for name, share in shares.items()
        }
        part["judged"] = over_points(judged.astype(int), "sum")
        part["points"] = over_points(exact[number].notnull().astype(int), "sum")
        parts.append(part)
    numbers = xr.DataArray([want.name for want in wants], dims="number", name="number")
    joined = {name: xr.concat([part[name] for part in parts], numbers) for name in parts[0]}
    return {
        name: values.transpose("way", "number", "case", missing_dims="ignore")
        for name, values in joined.items()
    }


def frontier_dataset(solved: Mapping[Method, xr.Dataset], wants: Sequence[Want], best: Method) -> xr.Dataset:
    """Return the errors of ways against the best C, their seconds by stage, and the numbers of this C."""
    numbers = {method.name: solution for method, solution in solved.items()}
    stages = {
        f"{stage}_seconds": np.array([one[f"{stage}_seconds"].item() for one in solved.values()])
        for stage in STAGES
    }
    return xr.Dataset(
        {
            **error_variables(numbers, wants, best.name),
            **{name: ("way", seconds, {"units": "s"}) for name, seconds in stages.items()},
            "seconds": ("way", sum(stages.values()), {"units": "s"}),
            "strips": ("way", [one["strips"].item() for one in solved.values()]),
        },
        coords=way_coordinates(solved) | {"scale": ("number", [want.scale.meaning for want in wants])},
        attrs={"best": best.name, "best_estimate": worst_estimate(numbers[best.name], wants)},
    )
