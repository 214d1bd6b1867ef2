"""Frontiers: errors of all ways to ICs, or to a contact, over their seconds; and the cheapest good enough.

A way is an approximation, or C of an engine at some tolerance. The dataset of a frontier has errors [-] over
`way`: of ICs over body and component, as computed here; of a contact over case and number
(`compare.studies.contact_frontier`). All that follows from errors and seconds is the same for both.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from approx.variants import VARIANTS, needs_effective
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.reference.engines import ENGINES, SOLID
from femic.reference.refinement import total_seconds
from femic.reference.run_options import DEFAULT, RunOptions
from femic.reference.solid.pardiso import available as direct_available
from femic.results.ics import (
    Results,
    approximate_all,
    compute,
    ics_measure,
    reference_ics,
    refinement_shares,
    run_plans,
)
from femic.scenes.engine import EngineTable
from femic.scenes.errors import BadScene
from femic.scenes.load import in_keys, load_scene, read_scene, scene_path
from femic.scenes.scene import Scene
from geometries.arrays import Array, Mask
from geometries.errors import Failure, WrongInput
from geometries.patches import places

# --- ways, and what fits a budget -----------------------------------------------------------------------


APPROXIMATION = "approximation"  # the kind of ways without C
BEYOND_BUDGET = "of the budget are left"


@dataclass(frozen=True)
class Method:
    """A way to ICs or to a contact: the ICs by name, and the tolerance of C, NaN without.

    `kind` is `APPROXIMATION`, the name of an engine, or that of maps of C. `elements` across the smallest
    patch belong to contacts; 0: the scene or a map of C gives the grid. `changes` are keys of a scene file.
    """

    name: str  # in files
    label: str  # in figures and tables
    kind: str
    ics: str
    tolerance: float = np.nan
    elements: int = 0
    changes: Mapping[str, Any] = field(default_factory=dict, compare=False)


def solve_within_budget(
    groups: Iterable[Sequence[Method]],
    predict: Callable[[Sequence[Method]], float],
    solve: Callable[[Sequence[Method]], None],
    left: Callable[[], float],
    options: RunOptions,
) -> dict[str, str]:
    """Solve groups of ways, cheapest first, as long as they fit; return why others are left out, by name.

    `predict` gives the expected seconds of a group, `left` those of the budget. A group without a solution is
    solved one by one.
    """
    waiting, skipped = list(groups), dict[str, str]()
    while waiting:
        group = min(waiting, key=predict)
        waiting.remove(group)
        predicted, seconds = predict(group), left()
        if predicted > seconds:
            reason = f"about {predicted:.0f} s, but {max(seconds, 0):.0f} s {BEYOND_BUDGET}"
            skipped |= dict.fromkeys([method.name for method in group], reason)
            continue
        rest = ""
        if group[0].kind != APPROXIMATION:
            rest = f" of {min(predicted + sum(map(predict, waiting)), seconds):.0f} s that are left"
        names = "; ".join(method.name for method in group)
        options.watch.on_stage(f"  {names}: about {predicted:.0f} s{rest}")
        try:
            solve(group)
        except (Failure, WrongInput) as error:
            if len(group) > 1:
                waiting += [[method] for method in group]
            else:
                skipped[names] = f"no solution: {' '.join(in_keys(error).split())}"
    return skipped


def require_budget(budget: float) -> None:
    """Raise WrongInput unless a budget of seconds is positive."""
    if not budget > 0:
        raise WrongInput(f"--budget {budget:g}: must be positive [s]")


def require_reference(found: object, skipped: Mapping[str, str], budget: float) -> None:
    """Raise Failure without any C to measure errors against."""
    if not found:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in skipped.items())
        raise Failure(f"no reference C within the budget of {budget:g} s ({reasons}); give a larger --budget")


def way_coordinates(methods: Iterable[Method]) -> dict[str, Any]:
    """Return what a dataset says of its ways."""
    methods = list(methods)
    columns = {key: [getattr(method, key) for method in methods] for key in ("label", "kind", "ics")}
    columns |= {key: [getattr(method, key) for method in methods] for key in ("elements", "tolerance")}
    return {"way": [method.name for method in methods]} | {
        key: ("way", values) for key, values in columns.items()
    }


def study_attributes(scene: Scene, best: str, skipped: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes of all frontiers: the scene, the best C, the ways left out, code, versions."""
    return {
        "title": scene.title,
        "scene": scene.text,
        "best": best,
        "skipped": json.dumps(dict(skipped), ensure_ascii=False),
        "code": results_digest(*STUDY_FOLDERS),
        "versions": json.dumps(versions()),
    }


# --- errors and seconds ---------------------------------------------------------------------------------


AS_CHEAP = 3.0  # times the fastest way's seconds: faster ways count as equally cheap, as clocks vary


def by_number(dataset: xr.Dataset) -> xr.Dataset:
    """Return a frontier over way, number and case, with bounds: components are numbers, bodies are cases.

    A bound is an error with the estimate of the best C added, of this C its estimate.
    """
    if "number" in dataset.dims:
        return dataset
    floor = dataset.estimate.sel(way=dataset.attrs["best"], drop=True)
    bound = dataset.error + floor.where(dataset.way != dataset.attrs["best"], 0.0)
    judged = xr.ones_like(floor, dtype=int)
    return dataset.assign(bound=bound, judged=judged).rename(component="number", body="case")


def worst(dataset: xr.Dataset, names: Sequence[str], case: str | float | None = None) -> xr.Dataset:
    """Return the errors of the ways in the worst of some numbers, and over all cases unless one is named.

    Variables over `way`: `error`, at least the best C's estimate; `bound`, with it; `floor`, this estimate;
    `number` and `case`, where the bound is largest; `seconds`. NaN where a way has no solution, or where no
    error is known as a share.
    """
    dataset = by_number(dataset)
    chosen = dataset.sel(number=list(names), case=dataset.case.values if case is None else [case])
    judged = np.argwhere(chosen.judged.transpose("number", "case").values > 0)
    points = judged if len(judged) else np.zeros((1, 2), dtype=int)
    bounds, errors = (
        chosen[name].transpose("way", "number", "case").values[:, *points.T] for name in ("bound", "error")
    )
    unknown, rows = np.isnan(bounds).any(axis=1) | (len(judged) == 0), np.arange(len(bounds))
    where = np.argmax(np.where(np.isnan(bounds), np.inf, bounds), axis=1)
    floor = bounds[list(dataset.way.values).index(dataset.attrs["best"]), where]
    shares = {"error": np.maximum(errors[rows, where], floor), "bound": bounds[rows, where], "floor": floor}
    number, at_case = points[where].T
    seconds = dataset.seconds.sel(case=case, drop=True) if "case" in dataset.seconds.dims else dataset.seconds
    return xr.Dataset(
        {name: ("way", np.where(unknown, np.nan, values)) for name, values in shares.items()}
        | {"number": ("way", chosen.number.values[number]), "case": ("way", chosen.case.values[at_case])}
    ).assign(seconds=seconds)


def front(seconds: Array, errors: Array) -> Mask:
    """Return which ways are Pareto optimal, (n,), from their seconds (n,) [s] and errors (n,) [-].

    No other way is at least as fast and as accurate, and better in one of the two. A way with the error NaN
    does not exist.
    """
    faster, as_fast = seconds[None] < seconds[:, None], seconds[None] <= seconds[:, None]
    closer, as_close = errors[None] < errors[:, None], errors[None] <= errors[:, None]
    return ~np.any((faster & as_close) | (as_fast & closer), axis=1) & ~np.isnan(errors)


def cheapest(bounds: Array, seconds: Array, tolerance: float) -> int:
    """Return the number of the cheapest ICs whose error bound meets a tolerance, -1 if none does.

    Among equally cheap ICs (`AS_CHEAP`) the most accurate are chosen.
    """
    good = np.flatnonzero(bounds <= tolerance)
    if not good.size:
        return -1
    cheap = good[seconds[good] <= AS_CHEAP * np.min(seconds[good])]
    return int(cheap[np.argmin(bounds[cheap])])


# --- advice ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Question:
    """The numbers of a contact, or components of the ICs of a body, that are wanted to a tolerance [-].

    Raises WrongInput for no number, and unless the tolerance is above 0 and at most 1.
    """

    names: tuple[str, ...]
    tolerance: float
    body: str = ""

    def __post_init__(self) -> None:
        """Validate."""
        if not self.names:
            raise WrongInput("--want: name at least one number, such as p_max,F_x")
        if not 0 < self.tolerance <= 1:
            raise WrongInput(f"--tolerance {self.tolerance:g}: must be above 0 and at most 1")


@dataclass(frozen=True)
class Advice:
    """ICs that meet a tolerance, the keys of a scene file that they change, and a text that says why.

    `bound` is what the error of what is wanted is at most. `way` is the name in the frontier, "" where C was
    not solved; `label` is what stands in the text.
    """

    question: Question
    ics: str
    changes: Mapping[str, Any]
    bound: float
    text: str
    way: str = ""
    label: str = ""
    seconds: float = np.nan


def advise(dataset: xr.Dataset, question: Question) -> Advice:
    """Return the cheapest way of a frontier whose error bounds meet the tolerance: see `cheapest`.

    Raises WrongInput for components or bodies that the frontier does not have; Failure where no way meets the
    tolerance, and where no error of a wanted number is known as a share.
    """
    about_ics, best, tolerance = "component" in dataset.dims, dataset.attrs["best"], question.tolerance
    for dimension, names in (("component", question.names), ("body", [question.body])) if about_ics else ():
        if unknown := [name for name in names if name not in dataset[dimension].values]:
            raise WrongInput(
                f"{dimension} = {', '.join(unknown)}: the scene has {', '.join(dataset[dimension].values)}"
            )
    numbers = by_number(dataset)
    for name in question.names:
        if not numbers.judged.sel(number=name).any():
            raise vanishing(name, f"the estimate of the reference, {best}")
    errors = worst(dataset, question.names, question.body if about_ics else None)
    number = cheapest(errors.bound.values, errors.seconds.values, tolerance)
    if number < 0:
        nearest = errors.isel(way=int(np.argmin(np.nan_to_num(errors.bound.values, nan=np.inf))))
        known = (
            f"no choice of ICs is within the tolerance of {100 * tolerance:.6g} %. The most accurate, "
            f"{nearest.way.item()}, "
        )
        if about_ics:
            raise Failure(
                f"{known}has errors up to {nearest.bound.item():.2%}. Give a larger tolerance or fewer "
                "components"
            )
        skipped = json.loads(dataset.attrs.get("skipped", "{}"))
        left_out = [name for name, reason in skipped.items() if BEYOND_BUDGET in reason]
        more = (
            f", or a larger --budget; the present budget excluded {', '.join(left_out)}" if left_out else ""
        )
        raise Failure(
            f"{known}has an error of up to {nearest.bound.item():.2%} in {nearest.number.item()} at "
            f"{case_text(dataset, nearest.case.item())} (estimated error of the reference, {best}, there: "
            f"{nearest.floor.item():.2%}). Give a larger tolerance, fewer numbers, or more "
            f"contact.elements{more}"
        )
    way = errors.isel(way=number)
    name, ics, bound = (way[key].item() for key in ("way", "ics", "bound"))
    if about_ics:
        label, changes = str(way.label.item()), dict[str, Any]()
        vanishes = dataset.vanishes.sel(body=question.body, component=way.number.item()).item()
        note = "; it vanishes in C, so its error is relative to 0.05 C_nn" if vanishes else ""
        text = (
            f"Use {label}: the {question.body} ICs have errors up to {bound:.2%} of a component (tolerance "
            f"{tolerance:.2%}). Largest error: {way.number.item()}{note}."
        )
    else:
        elements, tolerance_of_c = way.elements.item(), way.tolerance.item()
        changes = {"contact": {"ics": [ics]} | ({"elements": elements} if elements else {})}
        settings = [f"contact.elements = {elements}"] if elements else []
        if not np.isnan(tolerance_of_c):
            changes["engine"] = {"tolerance": tolerance_of_c}
            settings.append(f"engine.tolerance = {tolerance_of_c:g}")
        label = " with ".join(filter(None, [f"contact.ics = [{ics!r}]", " and ".join(settings)]))
        how = "the estimated error of this C" if name == best else f"measured against {best}"
        judged, points = (dataset[count].sum("case") for count in ("judged", "points"))
        counts = {
            one: (judged.sel(number=one).item(), points.sel(number=one).item()) for one in question.names
        }
        text = " ".join(
            [
                f"Use {label}: the error of {', '.join(question.names)} is at most {bound:.2%} (tolerance "
                f"{tolerance:.2%}).",
                f"Largest error: {way.number.item()} at {case_text(dataset, way.case.item())}, {how}.",
                *(
                    f"The error of {one} is evaluated at {known} of {all_points} points; elsewhere it is "
                    "smaller than ten times the estimated error of the reference."
                    for one, (known, all_points) in counts.items()
                    if known < all_points
                ),
            ]
        )
    return Advice(question, ics, changes, bound, text, name, label, way.seconds.item())


def vanishing(name: str, least: str) -> Failure:
    """Return what is raised where a number is nowhere large enough for errors that are shares of itself."""
    instead = (
        f"want {name}/limit, which is relative to friction times load"
        if name.startswith("F_")
        else "leave it out"
    )
    return Failure(
        f"{name}: it nowhere exceeds ten times {least}, so it has no meaningful relative error; {instead}"
    )


def case_text(dataset: xr.Dataset, case: str | float) -> str:
    """Return a case in words: a body, 4000 N, 0.01 mm, friction 0.3."""
    if isinstance(case, str):
        return case
    unit = dataset.case.attrs["units"]
    return f"friction {case:g}" if unit == "1" else f"{case:.12g} {unit}"


# --- the frontier of ICs --------------------------------------------------------------------------------


BODY_AND_SOLVER = ("far_radius", "half_length", "solver")  # keys that remain for an engine of the same kind
VANISHES = (
    "C vanishes by symmetry, or is smaller than ten times its estimated error; errors are relative "
    "to 0.05 max |C_nn|"
)
RETRY_FACTOR = 10.0  # times tighter is the next C, if one leaves open whether a component vanishes
REFERENCE_FACTOR = 4  # how many times tighter than the tolerance the reference C is
MEANINGS = {
    "error": "largest deviation from the best C; for the best C: its estimated error",
    "weight": "the same, relative to max |C_nn| on a line",
    "estimate": "its own estimated error; 0: none",
}


LADDERS = {"harmonic": (1e-1, 1e-2, 1e-3, 1e-4), "solid": (1e-1, 3e-2, 1e-2)}  # tolerances, loose to tight


def tolerance_ladder(engine: str) -> tuple[float, ...]:
    """Return the tolerances of an engine that are compared, from loose to tight."""
    return LADDERS.get(engine, (1e-1, 1e-2))


def engine_methods(name: str, tightest: float = 0.0) -> Iterator[Method]:
    """Yield an engine at its tolerances, loose to tight, with all of its options at each.

    The last tolerance is the first that is not above `tightest`.
    """
    ladder = tolerance_ladder(name)
    looser = [tolerance for tolerance in ladder if tolerance > tightest]
    solvers = ["multigrid", *(["direct"] if direct_available() else [])] if name == SOLID.name else []
    all_options = [{"solver": solver} for solver in solvers] or [{}]
    for tolerance, options in product(ladder[: len(looser) + 1], all_options):
        keys = {"kind": name, "tolerance": tolerance, "check": False, **options}
        settings = ", ".join([f"{name} {tolerance:g}", *options.values()])
        yield Method(settings, f"C, {settings}", name, "C", tolerance, changes={"engine": keys})


@dataclass(frozen=True)
class FrontierRequest:
    """The ways by finite elements to try, their budget of seconds, and changes to keys of the scene."""

    methods: tuple[Method, ...]
    budget: float = np.inf  # s
    changes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def all(cls, budget: float, changes: Mapping[str, Any] = MappingProxyType({})) -> "FrontierRequest":
        """Request all engines at all tolerances; raises WrongInput unless the budget [s] is positive."""
        require_budget(budget)
        return cls(tuple(method for name in ENGINES for method in engine_methods(name)), budget, changes)

    def scene(self, base: str, engine: Mapping[str, Any]) -> Scene:
        """Load the scene with the changes of this request and some keys of the table `engine`."""
        return load_scene(base, {**self.changes, "engine": self.engine(base, engine)})

    def engine(self, base: str, engine: Mapping[str, Any]) -> dict[str, Any]:
        """Return keys of the table `engine`, and those of the scene that do not follow from a tolerance."""
        table = engine_table(base)
        same_kind = engine.get("kind", table["kind"]) == table["kind"]
        keys = ("kind", "most_unknowns", *(BODY_AND_SOLVER if same_kind else ()))
        return {key: table[key] for key in keys if key in table} | dict(engine)


def engine_table(base: str) -> dict[str, Any]:
    """Return the keys of the table `engine` of a scene file, always with `kind`."""
    return {"kind": EngineTable().kind} | read_scene(scene_path(base))[1].get("engine", {})


def compute_frontier(base: str, request: FrontierRequest, options: RunOptions = DEFAULT) -> xr.Dataset:
    """Compute the errors, seconds, unknowns and memory of every way to a scene's ICs that fits the budget.

    Ways run in the order of their predicted seconds. Errors (way, body, component) [-] are measured with
    `femic.ic_errors.error_measure` against the best C, at worst over the lines. Raises BadScene as
    `load_scene` does, Failure if no C fits into the budget.
    """
    start, scene = perf_counter(), request.scene(base, {"check": False})
    scenes, seconds, computed = dict[Method, Scene](), dict[Method, float](), dict[Method, Results]()
    skipped: dict[str, str] = {}
    for method in request.methods:
        try:
            scenes[method] = request.scene(base, method.changes["engine"])
            plans = run_plans(scenes[method], options.workers)
            seconds[method] = total_seconds(plans, options.workers)
        except BadScene as error:
            skipped[method.name] = " ".join(str(error).split())

    def solve(group: Sequence[Method]) -> None:
        computed[group[0]] = compute(scenes[group[0]], options)

    skipped |= solve_within_budget(
        [[method] for method in seconds],
        lambda group: seconds[group[0]],
        solve,
        lambda: request.budget - (perf_counter() - start),
        options,
    )
    require_reference(computed, skipped, request.budget)
    return frontier_dataset(scene, computed, skipped)


def frontier_dataset(
    scene: Scene, computed: Mapping[Method, Results], skipped: Mapping[str, str]
) -> xr.Dataset:
    """Return errors of all approximations and of C against the best C, seconds, unknowns and memory."""
    best = min(computed, key=lambda method: _largest_estimate(computed[method]))
    results, chosen = computed[best], places(scene.components)
    variants = [name for name in VARIANTS if scene.fitted or not needs_effective(name)]
    approximate, clocked = approximate_all(replace(results.scene, variants=tuple(variants)), results.points)
    methods = [Method(name, VARIANTS[name].symbol, APPROXIMATION, name) for name in variants] + list(computed)
    tables: dict[str, list[Any]] = {name: [] for name in (*MEANINGS, "vanishes", "by_symmetry")}
    for body in scene.compared:
        measure, c = ics_measure(results, body), reference_ics(results, body).ic
        found = [reference_ics(one, body) for one in computed.values()]
        ics = np.stack([*(approximate[name, body] for name in variants), *(one.ic for one in found)])
        estimates = np.stack([*([np.zeros_like(c)] * len(variants)), *(one.estimate for one in found)])
        deviations = ics - c
        deviations[methods.index(best)] = estimates[methods.index(best)]
        shares = measure.shares(deviations), measure.weights(deviations), measure.shares(estimates)
        for name, share in zip(MEANINGS, shares, strict=True):
            tables[name].append(worst_shares(scene, share))
        tables["vanishes"].append(measure.vanishing[chosen])
        tables["by_symmetry"].append(measure.zero_by_symmetry[chosen])
    dims = ("way", "body", "component")
    costs = [list(one.models.values()) for one in computed.values()]
    seconds = [[clocked[name, body] for body in scene.compared] for name in variants]
    seconds += [[one.seconds["C", body] for body in scene.compared] for one in computed.values()]
    none = [0] * len(variants)
    unknowns = [*none, *(max(cost.unknowns for cost in models) for models in costs)]
    memory = [*map(float, none), *(max(cost.peak_memory for cost in models) for models in costs)]
    return xr.Dataset(
        {
            name: (dims, np.stack(tables[name], axis=1), {"units": "1", "meaning": meaning})
            for name, meaning in MEANINGS.items()
        }
        | {
            "vanishes": (dims[1:], tables["vanishes"], {"meaning": VANISHES}),
            "by_symmetry": (dims[1:], tables["by_symmetry"], {"meaning": "C vanishes by symmetry"}),
            "seconds": (dims[:2], seconds, {"units": "s"}),
            "unknowns": ("way", unknowns),
            "memory": ("way", memory, {"units": "MB"}),
        },
        coords=way_coordinates(methods) | {"body": list(scene.compared), "component": list(scene.components)},
        attrs={**study_attributes(scene, best.name, skipped), "points": len(results.points.x)},
    )


def _largest_estimate(results: Results) -> float:
    """Return the largest estimate of C over bodies, lines and components, on the scale of refinement [-].

    This scale is the same for every way.
    """
    shares = (
        refinement_shares(results, body, reference_ics(results, body).estimate)
        for body in results.scene.compared
    )
    return float(np.max([worst_shares(results.scene, shares_of_lines) for shares_of_lines in shares]))


def worst_shares(scene: Scene, shares: Mapping[str, Array]) -> Array:
    """Return the largest of shares (..., 3, 3) by line, for the components of the scene, (..., n) [-]."""
    return np.max(list(shares.values()), axis=0)[..., *places(scene.components)]


def request_for(base: str, question: Question) -> FrontierRequest:
    """Return the request for the approximations of one body, and C of the scene's engine to measure them."""
    changes = {"components": list(question.names), "bodies": [question.body]}
    kind, tightest = engine_table(base)["kind"], question.tolerance / REFERENCE_FACTOR
    return FrontierRequest(tuple(engine_methods(kind, tightest)), changes=changes)


def frontier_for(
    base: str, question: Question, options: RunOptions = DEFAULT
) -> tuple[FrontierRequest, xr.Dataset]:
    """Return the request that answers a question, and its frontier.

    If a component vanishes in C, but not by symmetry, a tighter C is computed: the component may only be
    small, and its errors would then be shares of itself.
    """
    tightest = tolerance_ladder(engine_table(base)["kind"])[-1]
    while True:
        request = request_for(base, question)
        frontier = compute_frontier(base, request, options)
        body = frontier.sel(body=question.body)
        undecided = bool(np.any(body.vanishes & ~body.by_symmetry))
        if not undecided or question.tolerance / REFERENCE_FACTOR <= tightest:
            return request, frontier
        question = replace(question, tolerance=question.tolerance / RETRY_FACTOR)


def question_of(scene: Scene) -> Question:
    """Return the question for all components that a scene compares, and the first of its bodies."""
    return Question(scene.components, scene.ics_tolerance, scene.compared[0])


def choose(base: str, question: Question, options: RunOptions = DEFAULT) -> Advice:
    """Return the ICs that `femic advise` would name, measured on the lines and at the patch of a scene.

    `changes` are keys of a scene file for C of that accuracy. Raises Failure if no way meets the tolerance.
    """
    request, frontier = frontier_for(base, question, options)
    advice = advise(frontier, question)
    text = f"{advice.text} The errors were measured on the lines of the scene, with its patch."
    engines = {method.name: method.changes["engine"] for method in request.methods}
    changes = {"engine": request.engine(base, engines[advice.way])} if advice.way in engines else {}
    return replace(advice, text=text, changes=changes)
