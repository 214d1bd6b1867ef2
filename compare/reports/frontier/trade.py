"""The trade of speed against accuracy of a scene: every way to its ICs, within a budget of seconds."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from compare.reports.frontier import ways
from compare.reports.frontier.ways import Way
from compare.results import plan
from compare.results.compute import (
    Results,
    approximated,
    compute,
    measure_of,
    reference_of,
    refinement_shares_of,
    scene_points,
)
from compare.results.provenance import results_digest
from compare.scenes.errors import BadScene
from compare.scenes.file import EngineTable
from compare.scenes.load import load_scene, read_scene, scene_path
from compare.scenes.messages import in_keys
from compare.scenes.scene import Scene
from femic.accuracy import NotConverged, component_of
from femic.engines import ENGINES
from femic.means import DEFAULT, Means
from femic.work.provenance import versions
from geometries.arrays import Array, Mask
from geometries.errors import Failure, WrongInput

BODY_AND_SOLVER = ("far_radius", "half_length", "solver")  # keys of a scene's engine of the same kind
VANISHES = "C vanishes: by symmetry, or below ten times its estimate; errors are shares of 0.05 max |C_nn|"
Curves = Mapping[str, Array]  # by body compared, (3, 3, n_points) [mm/N]


@dataclass(frozen=True, eq=False)
class Tried:
    """What a way gave and took."""

    way: Way
    ics: Curves
    estimates: Curves  # zeros of approximations
    seconds: Mapping[str, float]  # by body compared: all that its ICs need
    unknowns: int  # of the largest model
    memory: float  # MB, likewise


@dataclass(frozen=True)
class Asked:
    """Which ways by finite elements are tried, for how long, and what of the scene is changed (its keys)."""

    ways: tuple[Way, ...]
    budget: float = np.inf  # s
    changes: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def all(cls, budget: float) -> "Asked":
        """Both engines at all tolerances."""
        if not budget > 0:
            raise WrongInput(f"--budget {budget:g}: must be positive [s]")
        return cls(tuple(way for name in ENGINES for way in ways.by_engine(name)), budget)

    def scene(self, base: str, engine: Mapping[str, Any]) -> Scene:
        """The scene with the settings of a way."""
        return load_scene(base, {**self.changes, "engine": self.engine(base, engine)})

    def engine(self, base: str, engine: Mapping[str, Any]) -> dict[str, Any]:
        """The settings of a way, with those of the scene that do not follow from its tolerance."""
        own = read_scene(scene_path(base))[1].get("engine", {})
        kind = own.get("kind", EngineTable().kind)
        kept = ("most_unknowns", *(BODY_AND_SOLVER if engine.get("kind", kind) == kind else ()))
        return {key: own[key] for key in kept if key in own} | {"kind": kind} | dict(engine)


def compute_frontier(base: str, asked: Asked, means: Means = DEFAULT) -> xr.Dataset:
    """Errors, seconds, unknowns and memory of every way to the ICs of a scene that fits into the budget.

    Those that are planned to be cheapest come first. Errors are those of `compare.results.measure` against
    the best known C, the worst over the lines. Raises BadScene as `load_scene`, Failure where no C fits into
    the budget.
    """
    scene = asked.scene(base, {"check": False})
    start, tried = perf_counter(), list(_approximations(scene))
    found: dict[str, Results] = {}
    skipped: dict[str, str] = {}
    for predicted, way in _by_cost(base, asked, means.workers, skipped):
        left = asked.budget - (perf_counter() - start)
        if predicted > left:
            skipped[way.name] = f"about {predicted:.0f} s, but {max(left, 0):.0f} s of the budget are left"
            continue
        means.watch.on_stage(f"  {way.name}: about {predicted:.0f} s")
        try:
            found[way.name] = compute(asked.scene(base, way.engine), means)
        except NotConverged as error:
            skipped[way.name] = f"did not converge: {in_keys(error)}"
            continue
        tried.append(_tried(way, found[way.name]))
    if not found:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in skipped.items())
        raise Failure(f"no reference C within the budget of {asked.budget:g} s ({reasons}): give more")
    best = min(found, key=lambda name: _worst_estimate(found[name]))
    return _dataset(scene, tried, (best, found[best]), skipped)


def _approximations(scene: Scene) -> Iterator[Tried]:
    points, _ = scene_points(scene)
    of_scene = list(ways.approximations(scene))
    ics, seconds = approximated(replace(scene, variants=tuple(way.name for way in of_scene)), points)
    for way in of_scene:
        of_way = {body: ics[way.name, body] for body in scene.compared}
        none = {body: np.zeros_like(values) for body, values in of_way.items()}
        yield Tried(way, of_way, none, {body: seconds[way.name, body] for body in scene.compared}, 0, 0.0)


def _by_cost(base: str, asked: Asked, workers: int, skipped: dict[str, str]) -> list[tuple[float, Way]]:
    """The ways that can be gone with their predicted seconds, cheapest first; others go to `skipped`."""
    costs = []
    for way in asked.ways:
        try:
            steps = plan.run_steps(asked.scene(base, way.engine), workers)
            costs.append((plan.seconds(steps, workers), way))
        except BadScene as error:
            skipped[way.name] = " ".join(str(error).split())
    return sorted(costs, key=lambda one: one[0])


def _tried(way: Way, results: Results) -> Tried:
    bodies, costs = results.scene.compared, list(results.models.values())
    c = {body: reference_of(results, body) for body in bodies}
    return Tried(
        way,
        {body: c[body].ic for body in bodies},
        {body: c[body].estimate for body in bodies},
        {body: results.seconds["C", body] for body in bodies},
        max(cost.unknowns for cost in costs),
        max(cost.peak_memory for cost in costs),
    )


def _worst_estimate(results: Results) -> float:
    """Of all bodies, lines and components; on the scale of refinement, which is the same for every way."""
    known = {body: reference_of(results, body).estimate for body in results.scene.compared}
    return float(
        np.max([_worst(results, refinement_shares_of(results, body, of)) for body, of in known.items()])
    )


def _worst(results: Results, shares: Mapping[str, Array]) -> Array:
    """The largest of the lines, per component of the scene."""
    return _of_components(results.scene, np.max(list(shares.values()), axis=0))


def _of_components(scene: Scene, values: NDArray[Any]) -> NDArray[Any]:
    """What of (3, 3) values belongs to the components of a scene."""
    return np.array([component_of(values, component) for component in scene.components])


def _dataset(
    scene: Scene, tried: Sequence[Tried], best: tuple[str, Results], skipped: Mapping[str, str]
) -> xr.Dataset:
    name, results = best
    bodies = list(scene.compared)
    shape = (len(tried), len(bodies), len(scene.components))
    error, estimate, weight = np.empty((3, *shape))
    measures = [measure_of(results, body) for body in bodies]
    for b, (body, measure) in enumerate(zip(bodies, measures, strict=True)):
        c = reference_of(results, body).ic
        for w, one in enumerate(tried):
            off = one.estimates[body] if one.way.name == name else one.ics[body] - c
            error[w, b] = _worst(results, measure.shares(off))
            weight[w, b] = _worst(results, measure.weights(off))
            estimate[w, b] = _worst(results, measure.shares(one.estimates[body]))
    gone, zero = ([_of_components(scene, getattr(m, of)) for m in measures] for of in ("vanishing", "zero"))
    over, share = ("way", "body", "component"), {"units": "1"}
    seconds = [[one.seconds[body] for body in bodies] for one in tried]
    return xr.Dataset(
        {
            "error": (over, error, share | {"meaning": "worst deviation from the best C; of that: estimate"}),
            "estimate": (over, estimate, share | {"meaning": "its own estimate of its error; 0: none"}),
            "weight": (over, weight, share | {"meaning": "the same, share of max |C_nn| on a line"}),
            "vanishes": (over[1:], np.array(gone, dtype=bool), {"meaning": VANISHES}),
            "by_symmetry": (over[1:], np.array(zero, dtype=bool), {"meaning": "C vanishes by symmetry"}),
            "seconds": (("way", "body"), seconds, {"units": "s"}),
            "unknowns": ("way", [one.unknowns for one in tried]),
            "memory": ("way", [one.memory for one in tried], {"units": "MB"}),
        },
        coords={
            "way": [one.way.name for one in tried],
            "label": ("way", [one.way.label for one in tried]),
            "kind": ("way", [one.way.kind for one in tried]),
            "body": bodies,
            "component": list(scene.components),
        },
        attrs={
            "title": scene.title,
            "scene": scene.text,
            "best": name,
            "points": len(results.points.x),
            "skipped": json.dumps(dict(skipped), ensure_ascii=False),
            "code": results_digest(),
            "versions": json.dumps(versions()),
        },
    )


def known_errors(dataset: xr.Dataset, body: str) -> xr.DataArray:
    """What the errors of a body's ICs are at most: measured, plus the best C's estimate; (way, component)."""
    of_body = dataset.sel(body=body)
    floor = of_body.estimate.sel(way=dataset.attrs["best"], drop=True)
    return of_body.error + floor.where(of_body.way != dataset.attrs["best"], 0.0)


def told_apart(dataset: xr.Dataset, body: str) -> xr.DataArray:
    """Errors of a body's ICs, none below what the best C knows of itself; (way, component)."""
    of_body = dataset.sel(body=body)
    floor = of_body.estimate.sel(way=dataset.attrs["best"], drop=True)
    return xr.DataArray(np.maximum(of_body.error, floor))


def front(seconds: Array, errors: Array) -> Mask:
    """Which of several ways no other beats: is as fast and as accurate, and better in one; (n,) each.

    NaN: there is no such way.
    """
    faster, as_fast = seconds[None] < seconds[:, None], seconds[None] <= seconds[:, None]
    closer, as_close = errors[None] < errors[:, None], errors[None] <= errors[:, None]
    return ~np.any((faster & as_close) | (as_fast & closer), axis=1) & ~np.isnan(errors)
