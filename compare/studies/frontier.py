"""The frontier of a scene: errors and seconds of every way to its ICs, within a budget of seconds.

Ways are the approximations, and every engine at several tolerances. Advice is on the cheapest ICs that meet a
tolerance, with the evidence for it; a scene that does not name its ICs uses these.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from approx.variants import VARIANTS, needs_effective
from compare.report.looks import APPROXIMATION_MARK, ENGINE_MARKS, OTHER_ENGINE_MARK
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.reference.engines import ENGINES, SOLID
from femic.reference.job import NotConverged
from femic.reference.refinement import total_seconds
from femic.reference.result import EstimatedICs
from femic.reference.run_options import DEFAULT, RunOptions
from femic.reference.solid.pardiso import available as direct_available
from femic.results.ics import (
    Results,
    approximated,
    compute,
    measure_of,
    reference_of,
    refinement_shares_of,
    run_plans,
    scene_points,
)
from femic.scenes.engine import EngineTable
from femic.scenes.errors import BadScene
from femic.scenes.load import in_keys, load_scene, read_scene, scene_path
from femic.scenes.scene import Scene
from geometries.arrays import Array, Mask
from geometries.errors import Failure, WrongInput
from geometries.patches import places

# --- ways -----------------------------------------------------------------------------------------------


APPROXIMATION = "approximation"  # the kind of ways that are no engines


@dataclass(frozen=True)
class Way:
    """A variant, or an engine with settings: keys of the table `engine` of a scene file."""

    name: str
    kind: str  # `APPROXIMATION`, or the name of an engine
    engine: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The label of this way in figures and tables."""
        return VARIANTS[self.name].symbol if self.name in VARIANTS else f"C, {self.name}"


def approximations(scene: Scene) -> Iterator[Way]:
    """Yield all variants; B-hat-prime only if one of the bodies compared has effective properties."""
    for variant in VARIANTS:
        if scene.fitted or not needs_effective(variant):
            yield Way(variant, APPROXIMATION)


# The tolerances that are compared, from loose to tight.
LADDERS = {"harmonic": (1e-1, 1e-2, 1e-3, 1e-4), "solid": (1e-1, 3e-2, 1e-2)}


def tolerance_ladder(engine: str) -> tuple[float, ...]:
    """Return the tolerances of an engine that are compared, from loose to tight."""
    return LADDERS.get(engine, (1e-1, 1e-2))


def engine_ways(name: str, tightest: float = 0.0) -> Iterator[Way]:
    """Yield an engine at its tolerances, loose to tight, with all of its options at each.

    The last tolerance is the first that is not above `tightest`.
    """
    ladder = tolerance_ladder(name)
    looser = [tolerance for tolerance in ladder if tolerance > tightest]
    solvers = ["multigrid", *(["direct"] if direct_available() else [])] if name == SOLID.name else []
    all_options = [{"solver": solver} for solver in solvers] or [{}]
    for tolerance, options in product(ladder[: len(looser) + 1], all_options):
        engine = {"kind": name, "tolerance": tolerance, "check": False, **options}
        yield Way(", ".join([f"{name} {tolerance:g}", *options.values()]), name, engine)


def styles() -> dict[str, tuple[str, str]]:
    """Return the colour and the marker of each kind of ways."""
    engines = {name: ENGINE_MARKS.get(name, OTHER_ENGINE_MARK) for name in ENGINES}
    return {APPROXIMATION: APPROXIMATION_MARK} | engines


# --- the frontier ---------------------------------------------------------------------------------------


BODY_AND_SOLVER = ("far_radius", "half_length", "solver")  # keys that remain for an engine of the same kind
VANISHES = "C vanishes: by symmetry, or below ten times its estimate; errors are shares of 0.05 max |C_nn|"


@dataclass(frozen=True, eq=False)
class WayResult:
    """The ICs of a way, with their time and memory."""

    way: Way
    ics: Mapping[str, EstimatedICs]  # by body compared; estimates of approximations are 0
    seconds: Mapping[str, float]  # by body compared: of all models that its ICs need
    unknowns: int  # of the largest model
    memory: float  # MB, largest of the process so far


@dataclass(frozen=True)
class FrontierRequest:
    """The ways by finite elements to try, their budget of seconds, and changes to keys of the scene."""

    ways: tuple[Way, ...]
    budget: float = np.inf  # s
    changes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def all(cls, budget: float, changes: Mapping[str, Any] = MappingProxyType({})) -> "FrontierRequest":
        """Request all engines at all tolerances; raises WrongInput unless the budget [s] is positive."""
        if not budget > 0:
            raise WrongInput(f"--budget {budget:g}: must be positive [s]")
        return cls(tuple(way for name in ENGINES for way in engine_ways(name)), budget, changes)

    def scene(self, base: str, engine: Mapping[str, Any]) -> Scene:
        """Load the scene with the changes of this request and the engine settings of a way."""
        return load_scene(base, {**self.changes, "engine": self.engine(base, engine)})

    def engine(self, base: str, engine: Mapping[str, Any]) -> dict[str, Any]:
        """Return the engine settings of a way, and of the scene where they do not follow from a tolerance."""
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
    scene = request.scene(base, {"check": False})
    start, way_results = perf_counter(), list(_approximations(scene))
    computed: dict[str, Results] = {}
    skipped: dict[str, str] = {}
    for predicted, way in _sorted_by_cost(base, request, options.workers, skipped):
        seconds_left = request.budget - (perf_counter() - start)
        if predicted > seconds_left:
            skipped[way.name] = (
                f"about {predicted:.0f} s, but {max(seconds_left, 0):.0f} s of the budget are left"
            )
            continue
        options.watch.on_stage(f"  {way.name}: about {predicted:.0f} s")
        try:
            computed[way.name] = compute(request.scene(base, way.engine), options)
        except NotConverged as error:
            skipped[way.name] = f"did not converge: {in_keys(error)}"
            continue
        way_results.append(_way_result(way, computed[way.name]))
    if not computed:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in skipped.items())
        raise Failure(
            f"no reference C within the budget of {request.budget:g} s ({reasons}): give a larger --budget"
        )
    best = min(computed, key=lambda name: _worst_estimate(computed[name]))
    return _dataset(scene, way_results, (best, computed[best]), skipped)


def _approximations(scene: Scene) -> Iterator[WayResult]:
    points, _ = scene_points(scene)
    scene_ways = list(approximations(scene))
    ics, seconds = approximated(replace(scene, variants=tuple(way.name for way in scene_ways)), points)
    for way in scene_ways:
        way_ics = {body: _without_estimate(ics[way.name, body]) for body in scene.compared}
        yield WayResult(way, way_ics, {body: seconds[way.name, body] for body in scene.compared}, 0, 0.0)


def _without_estimate(ics: Array) -> EstimatedICs:
    return EstimatedICs(ics, *np.zeros((3, *ics.shape)))


def _sorted_by_cost(
    base: str, request: FrontierRequest, workers: int, skipped: dict[str, str]
) -> list[tuple[float, Way]]:
    """Return ways with a valid scene and their predicted seconds, cheapest first; others go to `skipped`."""
    costs = []
    for way in request.ways:
        try:
            plans = run_plans(request.scene(base, way.engine), workers)
            costs.append((total_seconds(plans, workers), way))
        except BadScene as error:
            skipped[way.name] = " ".join(str(error).split())
    return sorted(costs, key=lambda cost_and_way: cost_and_way[0])


def _way_result(way: Way, results: Results) -> WayResult:
    bodies, costs = results.scene.compared, list(results.models.values())
    return WayResult(
        way,
        {body: reference_of(results, body) for body in bodies},
        {body: results.seconds["C", body] for body in bodies},
        max(cost.unknowns for cost in costs),
        max(cost.peak_memory for cost in costs),
    )


def _worst_estimate(results: Results) -> float:
    """Return the largest estimate of C over bodies, lines and components, on the scale of refinement [-].

    This scale is the same for every way.
    """
    shares = (
        refinement_shares_of(results, body, reference_of(results, body).estimate)
        for body in results.scene.compared
    )
    return float(np.max([worst_shares(results.scene, shares_of_lines) for shares_of_lines in shares]))


def worst_shares(scene: Scene, shares: Mapping[str, Array]) -> Array:
    """Return the largest of shares (..., 3, 3) by line, for the components of the scene, (..., n) [-]."""
    return np.max(list(shares.values()), axis=0)[..., *places(scene.components)]


def _dataset(
    scene: Scene, way_results: Sequence[WayResult], best: tuple[str, Results], skipped: Mapping[str, str]
) -> xr.Dataset:
    """Return errors against the best C, seconds, unknowns and memory of all computed ways."""
    best_name, results = best
    return xr.Dataset(
        _error_variables(way_results, best)
        | {
            "seconds": (
                ("way", "body"),
                [[result.seconds[body] for body in scene.compared] for result in way_results],
                {"units": "s"},
            ),
            "unknowns": ("way", [result.unknowns for result in way_results]),
            "memory": ("way", [result.memory for result in way_results], {"units": "MB"}),
        },
        coords={
            "way": [result.way.name for result in way_results],
            "label": ("way", [result.way.label for result in way_results]),
            "kind": ("way", [result.way.kind for result in way_results]),
            "body": list(scene.compared),
            "component": list(scene.components),
        },
        attrs={
            "title": scene.title,
            "scene": scene.text,
            "best": best_name,
            "points": len(results.points.x),
            "skipped": json.dumps(dict(skipped), ensure_ascii=False),
            "code": results_digest(*STUDY_FOLDERS),
            "versions": json.dumps(versions()),
        },
    )


MEANINGS = {
    "error": "worst deviation from the best C; of that: estimate",
    "weight": "the same, share of max |C_nn| on a line",
    "estimate": "its own estimate of its error; 0: none",
}


def _error_variables(
    way_results: Sequence[WayResult], best: tuple[str, Results]
) -> dict[str, tuple[Any, ...]]:
    """Return errors, weights and estimates of every way, and which components of C vanish, for all bodies."""
    best_name, results = best
    scene, chosen = results.scene, places(results.scene.components)
    number_of_best = [result.way.name for result in way_results].index(best_name)
    values, vanishing, by_symmetry = [], [], []
    for body in scene.compared:
        measure, c = measure_of(results, body), reference_of(results, body).ic
        estimates = np.stack([result.ics[body].estimate for result in way_results])
        deviations = np.stack([result.ics[body].ic - c for result in way_results])
        deviations[number_of_best] = estimates[number_of_best]
        shares = measure.shares(deviations), measure.weights(deviations), measure.shares(estimates)
        values.append(np.stack([worst_shares(scene, share) for share in shares]))
        vanishing.append(measure.vanishing[chosen])
        by_symmetry.append(measure.zero_by_symmetry[chosen])
    dims = ("way", "body", "component")
    by_meaning = np.stack(values, axis=2)  # (meaning, way, body, component)
    return {
        name: (dims, way_values, {"units": "1", "meaning": meaning})
        for (name, meaning), way_values in zip(MEANINGS.items(), by_meaning, strict=True)
    } | {
        "vanishes": (dims[1:], vanishing, {"meaning": VANISHES}),
        "by_symmetry": (dims[1:], by_symmetry, {"meaning": "C vanishes by symmetry"}),
    }


def error_bounds(dataset: xr.Dataset, body: str) -> xr.DataArray:
    """Return upper bounds of a body's errors: measured, plus the best C's estimate; (way, component) [-]."""
    way_errors = dataset.error.sel(body=body)
    return way_errors + _estimate_of_best(dataset, body).where(dataset.way != dataset.attrs["best"], 0.0)


def resolved_errors(dataset: xr.Dataset, body: str) -> xr.DataArray:
    """Return a body's errors, at least the best C's estimate; (way, component) [-]."""
    return xr.DataArray(np.maximum(dataset.error.sel(body=body), _estimate_of_best(dataset, body)))


def _estimate_of_best(dataset: xr.Dataset, body: str) -> xr.DataArray:
    return dataset.estimate.sel(body=body, way=dataset.attrs["best"], drop=True)


def front(seconds: Array, errors: Array) -> Mask:
    """Return which ways are Pareto optimal, (n,), from their seconds (n,) [s] and errors (n,) [-].

    No other way is at least as fast and as accurate, and better in one of the two. A way with the error NaN
    does not exist.
    """
    faster, as_fast = seconds[None] < seconds[:, None], seconds[None] <= seconds[:, None]
    closer, as_close = errors[None] < errors[:, None], errors[None] <= errors[:, None]
    return ~np.any((faster & as_close) | (as_fast & closer), axis=1) & ~np.isnan(errors)


# --- advice ---------------------------------------------------------------------------------------------


AS_CHEAP = 3.0  # times the fastest way's seconds: faster ways count as equally cheap, as clocks vary
RETRY_FACTOR = 10.0  # times tighter is the next C, if one leaves open whether a component vanishes
REFERENCE_FACTOR = 4  # how many times tighter than the tolerance the reference C is


@dataclass(frozen=True)
class Question:
    """The body and the components whose ICs are to be chosen, and the tolerance of their errors [-]."""

    body: str
    components: tuple[str, ...]
    tolerance: float


@dataclass(frozen=True)
class Advice:
    """A way to ICs that meets a tolerance, with its error and its seconds."""

    question: Question
    way: str
    label: str
    error: float  # upper bound, of the worst component
    seconds: float
    component: str  # the worst one
    vanishes: bool  # whether this component vanishes in C: the error is then a share of 0.05 max |C_nn|


def advise(dataset: xr.Dataset, question: Question) -> Advice:
    """Return the cheapest way of a frontier whose error bounds meet the tolerance: see `cheapest`.

    Raises WrongInput for components or bodies that the frontier does not have, Failure if no way meets the
    tolerance.
    """
    body, components, tolerance = question.body, list(question.components), question.tolerance
    for dimension, names in (("component", components), ("body", [body])):
        unknown = [name for name in names if name not in dataset[dimension].values]
        if unknown:
            raise WrongInput(
                f"{dimension} = {', '.join(unknown)}: the scene has {', '.join(dataset[dimension].values)}"
            )
    errors = error_bounds(dataset, body).sel(component=components)
    worst, seconds = errors.max("component"), dataset.seconds.sel(body=body)
    number = cheapest(worst.values, seconds.values, tolerance)
    if number < 0:
        best = str(worst.way.values[int(np.nanargmin(worst.values))])
        raise Failure(
            f"no way meets {tolerance:g}: the best, {best}, has errors up to {float(worst.min()):.2g}: give "
            "a larger tolerance, or fewer components"
        )
    way, way_errors = dataset.isel(way=number), errors.isel(way=number)
    component = str(way_errors.component.values[int(np.argmax(way_errors.values))])
    return Advice(
        question,
        str(way.way.item()),
        str(way.label.item()),
        float(way_errors.max()),
        float(seconds[number]),
        component,
        bool(dataset.vanishes.sel(body=body, component=component)),
    )


def cheapest(bounds: Array, seconds: Array, tolerance: float) -> int:
    """Return the number of the cheapest ICs whose error bound meets a tolerance, -1 if none does.

    Among equally cheap ICs (`AS_CHEAP`) the most accurate are chosen.
    """
    good = np.flatnonzero(bounds <= tolerance)
    if not good.size:
        return -1
    cheap = good[seconds[good] <= AS_CHEAP * np.min(seconds[good])]
    return int(cheap[np.argmin(bounds[cheap])])


def sentence(advice: Advice) -> str:
    """Return the advice as a sentence."""
    share_note = "; it vanishes in C, so that is a share of 0.05 C_nn" if advice.vanishes else ""
    return (
        f"Use {advice.label}: {advice.question.body} ICs to {advice.error:.2%} of a component (worst: "
        f"{advice.component}{share_note}; tolerance {advice.question.tolerance:.2%})."
    )


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


def request_for(base: str, question: Question) -> FrontierRequest:
    """Return the request for the approximations of one body, and C of the scene's engine to measure them.

    Raises WrongInput unless the tolerance is above 0 and at most 1.
    """
    if not 0 < question.tolerance <= 1:
        raise WrongInput(f"--tolerance {question.tolerance:g}: must be above 0 and at most 1")
    changes = {"components": list(question.components), "bodies": [question.body]}
    kind, tightest = engine_table(base)["kind"], question.tolerance / REFERENCE_FACTOR
    return FrontierRequest(tuple(engine_ways(kind, tightest)), changes=changes)


# --- the choice of ICs ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Choice:
    """Chosen ICs: C or the name of an approximation, why, and keys of the table `engine` for that C."""

    ics: str
    advice: Advice
    engine: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sentence(self) -> str:
        """A sentence on the choice and its evidence."""
        return f"{sentence(self.advice)} Errors are measured on the scene's lines, at its patch."


def question_of(scene: Scene) -> Question:
    """Return the question for all components that a scene compares, and the first of its bodies."""
    return Question(scene.compared[0], scene.components, scene.ics_tolerance)


def choose(base: str, question: Question, options: RunOptions = DEFAULT) -> Choice:
    """Return the ICs that `femic advise` would name, measured on the lines and at the patch of a scene.

    Raises Failure if no way meets the tolerance.
    """
    request, frontier = frontier_for(base, question, options)
    advice = advise(frontier, question)
    settings = {way.name: way.engine for way in request.ways}
    if advice.way not in settings:
        return Choice(advice.way, advice)
    return Choice("C", advice, request.engine(base, settings[advice.way]))
