"""The frontier of a scene: errors and seconds of every way to its ICs, within a budget of seconds."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from compare.frontier import ways
from compare.frontier.ways import Way
from compare.ics.compute import Results, approximated, compute, reference_of, run_plans, scene_points
from compare.ics.errors import measure_of, refinement_shares_of
from femic.cache.digests import results_digest, versions
from femic.reference.accuracy import NotConverged
from femic.reference.engines import ENGINES
from femic.reference.estimate import EstimatedICs
from femic.reference.plan import total_seconds
from femic.reference.run_options import DEFAULT, RunOptions
from femic.scenes.engine import EngineTable
from femic.scenes.errors import BadScene
from femic.scenes.load import load_scene, read_scene, scene_path
from femic.scenes.messages import in_keys
from femic.scenes.scene import Scene
from geometries.arrays import Array, Mask
from geometries.errors import Failure, WrongInput
from geometries.patches import places

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
        return cls(tuple(way for name in ENGINES for way in ways.engine_ways(name)), budget, changes)

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
    scene_ways = list(ways.approximations(scene))
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
            "code": results_digest(__name__),
            "module": __name__,
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
