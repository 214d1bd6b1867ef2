"""The frontier of a contact: errors of its numbers and seconds of every way to them, within a budget."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

from compare.studies.contact_ways import (
    APPROXIMATION,
    ESTIMATE,
    MAP_OF_C,
    STAGES,
    TIGHTEST,
    Solution,
    Way,
    error_variables,
    expected_seconds,
    first_models,
    grids_for,
    scale_of,
    solutions,
    ways_of,
)
from femic.cache.digests import STUDY_FOLDERS, results_digest, versions
from femic.contact.motions.motion import Want
from femic.contact.pairs.ics import C
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.contact import require_solvable
from femic.results.matrices import discounted
from femic.scenes.load import in_keys, load_scene
from femic.scenes.scene import Scene
from femic.scenes.wants import chosen_wants, wants_of
from geometries.errors import Failure, WrongInput
from geometries.patches import Grid

BEYOND_BUDGET = "of the budget are left"
NO_MAPS: Mapping[str, Any] = {}
GROWTH = 2.5  # exponent of the elements across a patch in the seconds of contacts: measured 1 to 3
FURTHER = 4.0  # seconds of a contact with its estimates, over those of the contact alone


@dataclass(frozen=True)
class ContactRequest:
    """The numbers whose errors are compared, the budget of seconds, and the tightest tolerance of C.

    `as_shares`: errors of a number that vanishes answer nothing.
    """

    wants: tuple[str, ...] = ()  # none: all that the contact has
    budget: float = np.inf  # s
    tightest: float = TIGHTEST
    as_shares: bool = False

    def __post_init__(self) -> None:
        """Raise WrongInput unless the budget is positive."""
        if not self.budget > 0:
            raise WrongInput(f"--budget {self.budget:g}: must be positive [s]")


def require_comparable(scene: Scene, names: Sequence[str] = ()) -> tuple[Want, ...]:
    """Return the wanted numbers of a scene's contact, by default all; raise WrongInput before any work.

    Raises it for unknown numbers, contacts that are not compared, and as `require_solvable` with C.
    """
    wants = chosen_wants(scene.contact, names or [want.name for want in wants_of(scene.contact)])
    ics = tuple(dict.fromkeys([*scene.contact.ics, C]))
    require_solvable(replace(scene, contact=replace(scene.contact, ics=ics)))
    return wants


def compute_contact_frontier(
    base: str, request: ContactRequest, options: RunOptions = DEFAULT, given: Mapping[str, Any] = NO_MAPS
) -> xr.Dataset:
    """Compute the errors and seconds of every way to a scene's contact that fits the budget.

    Approximations come first, then C, cheapest first; `given` are the maps of C that the scene names. Errors
    are those of `error_variables`, against the C with the smallest estimates. Raises WrongInput as
    `require_comparable`, Failure where no C fits into the budget, and before C is solved where the request is
    of shares and a number vanishes with all approximations.
    """
    scene = load_scene(base)
    wants = require_comparable(scene, request.wants)
    solver, ways = _Solver(base, scene, options, given), list(ways_of(scene, request.tightest))
    solver.solve((way for way in ways if way.kind == APPROXIMATION), request.budget)
    for want in wants if request.as_shares else ():
        scales = [scale_of(want, solution.numbers) for solution in solver.solved.values()]
        if scales and not any(scale.notnull().any() for scale in scales):
            raise vanishing(want.name, "its estimate with any approximation")
    solver.solve((way for way in ways if way.kind != APPROXIMATION), request.budget)
    references = [way for way in solver.solved if way.kind not in (APPROXIMATION, MAP_OF_C)]
    if not references:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in solver.skipped.items())
        raise Failure(
            f"no reference C within the budget of {request.budget:g} s ({reasons}): give a larger --budget"
        )
    best = best_reference({way: solver.solved[way].numbers for way in references}, wants, scene)
    dataset = frontier_dataset(solver.solved, wants, best)
    return dataset.assign_attrs(
        {
            "title": scene.title,
            "scene": scene.text,
            "motion": scene.contact.motion,
            "discounted": discounted(scene),
            "skipped": json.dumps(solver.skipped, ensure_ascii=False),
            "code": results_digest(*STUDY_FOLDERS),
            "versions": json.dumps(versions()),
        }
    )


def vanishing(name: str, least: str) -> Failure:
    """Return what is raised where a number is nowhere large enough for errors that are shares of itself."""
    instead = (
        f"want {name}/limit, a share of friction times load" if name.startswith("F_") else "leave it out"
    )
    return Failure(
        f"{name}: nowhere does it exceed ten times {least}, so its errors are no shares of itself: {instead}"
    )


def best_reference(references: Mapping[Way, xr.Dataset], wants: Sequence[Want], scene: Scene) -> Way:
    """Return the C whose wanted numbers have the smallest worst estimate; among equal ones, all numbers.

    Of wanted numbers that may all vanish, none has an estimate that is a share.
    """
    every = wants_of(scene.contact)
    return min(references, key=lambda way: [worst_estimate(references[way], some) for some in (wants, every)])


def worst_estimate(numbers: xr.Dataset, wants: Iterable[Want]) -> float:
    """Return the largest estimate of numbers that cannot vanish, over its scale [-]; infinite if unknown."""
    shares = [0.0]
    for want in wants:
        scale = scale_of(want, numbers)
        if not want.scale.vanishing and scale.notnull().any():
            own = numbers[ESTIMATE + want.number] / scale
            shares.append(float(own.where(scale.notnull(), 0.0).max(skipna=False)))
    return float(np.max(np.nan_to_num(shares, nan=np.inf)))


def frontier_dataset(solved: Mapping[Way, Solution], wants: Sequence[Want], best: Way) -> xr.Dataset:
    """Return the errors of ways against the best C, their seconds by stage, and the numbers of this C."""
    numbers = {way.name: solution.numbers for way, solution in solved.items()}
    by_stage = {
        f"{stage}_seconds": ("way", [solution.seconds[stage] for solution in solved.values()], {"units": "s"})
        for stage in STAGES
    }
    return xr.Dataset(
        {
            **error_variables(numbers, wants, best.name),
            **by_stage,
            "seconds": ("way", [solution.total for solution in solved.values()], {"units": "s"}),
            "strips": ("way", [max(grid.n_s for grid in solution.grids) for solution in solved.values()]),
        },
        coords={
            "kind": ("way", [way.kind for way in solved]),
            "ics": ("way", [way.ics for way in solved]),
            "elements": ("way", [way.elements or 0 for way in solved]),
            "tolerance": ("way", [way.tolerance or np.nan for way in solved]),
            "scale": ("number", [want.scale.meaning for want in wants]),
        },
        attrs={"best": best.name, "best_estimate": worst_estimate(numbers[best.name], wants)},
    )


@dataclass(frozen=True, eq=False)
class _Solver:
    """Solves the contacts of a scene by ways; `skipped` says why some have none."""

    base: str
    scene: Scene
    options: RunOptions
    given: Mapping[str, Any]
    solved: dict[Way, Solution] = field(default_factory=dict)
    skipped: dict[str, str] = field(default_factory=dict)
    walls: dict[int, float] = field(default_factory=dict)  # seconds of all approximations, by elements
    grids: dict[int | None, tuple[Grid, ...]] = field(default_factory=dict)  # of C alone, by elements
    expected: dict[Way, float] = field(default_factory=dict)  # of the models of C [s]
    start: float = field(default_factory=perf_counter)

    def solve(self, ways: Iterable[Way], budget: float) -> None:
        """Solve ways as long as they fit what is left of the budget, approximations first, cheapest first."""
        groups = _groups(self._distinct(ways))
        while groups:
            group = min(groups, key=self._turn)
            groups.remove(group)
            predicted, left = self._predicted(group), budget - (perf_counter() - self.start)
            names = [way.name for way in group]
            if predicted > left:
                reason = f"about {predicted:.0f} s, but {max(left, 0):.0f} s {BEYOND_BUDGET}"
                self.skipped.update(dict.fromkeys(names, reason))
                continue
            in_all = min(predicted + sum(map(self._predicted, groups)), left)
            of_all = "" if group[0].kind == APPROXIMATION else f" of {in_all:.0f} s that are left"
            self.options.watch.on_stage(f"  {'; '.join(names)}: about {predicted:.0f} s{of_all}")
            self._solve_group(group)

    def _turn(self, group: Sequence[Way]) -> tuple[bool, float]:
        """Return what orders ways that are solved together."""
        return group[0].kind != APPROXIMATION, self._predicted(group)

    def _solve_group(self, group: Sequence[Way]) -> None:
        """Solve ways together, or one by one where that fails."""
        start, way = perf_counter(), group[0]
        try:
            scene = load_scene(self.base, way.changes)
            found = solutions(scene, [one.ics for one in group], self.options, self.given)
        except (Failure, WrongInput) as error:
            if len(group) > 1:
                for one in group:
                    self._solve_group([one])
            else:
                self.skipped[way.name] = f"no solution: {' '.join(in_keys(error).split())}"
            return
        self.solved.update({one: found[one.ics] for one in group})
        if way.kind == APPROXIMATION:
            elements = way.elements or 0
            self.walls[elements] = self.walls.get(elements, 0.0) + perf_counter() - start

    def _distinct(self, ways: Iterable[Way]) -> Iterator[Way]:
        """Yield ways, less C that begins with the same cells as C at a larger tolerance: it is skipped."""
        known: dict[tuple[int | None, frozenset[str]], Way] = {}
        for way in ways:
            if way.tolerance is None:
                yield way
                continue
            models = first_models(self.scene, way.tolerance, self._grids(way), self.options)
            first = known.setdefault((way.elements, models), way)
            if first is way:
                yield way
            else:
                self.skipped[way.name] = f"begins with the same cells as {first.name}"

    def _predicted(self, group: Sequence[Way]) -> float:
        """Return the expected seconds of ways that are solved together."""
        way = group[0]
        if way.kind == MAP_OF_C or not self.walls:
            return 0.0 if way.tolerance is None else self._expected(way)
        elements = way.elements or 0
        nearest = min(self.walls, key=lambda other: abs(other - elements))
        wall = self.walls[nearest] * (elements / nearest if nearest else 1.0) ** GROWTH
        if way.tolerance is None:
            return wall
        slowest = max(
            solution.seconds["contact"]
            for other, solution in self.solved.items()
            if other.kind == APPROXIMATION and (other.elements or 0) == nearest
        )
        return self._expected(way) + FURTHER * slowest * (wall / self.walls[nearest])

    def _grids(self, way: Way) -> tuple[Grid, ...]:
        if way.elements not in self.grids:
            self.grids[way.elements] = grids_for(self.scene, way.elements)
        return self.grids[way.elements]

    def _expected(self, way: Way) -> float:
        """Return the expected seconds of the models of C."""
        assert way.tolerance is not None
        if way not in self.expected:
            self.expected[way] = expected_seconds(self.scene, way.tolerance, self._grids(way), self.options)
        return self.expected[way]


def _groups(ways: Iterable[Way]) -> list[list[Way]]:
    """Return the ways that are solved together: approximations on the same elements; others alone."""
    groups: dict[object, list[Way]] = {}
    for way in ways:
        key: object = (way.kind, way.elements) if way.kind == APPROXIMATION else way
        groups.setdefault(key, []).append(way)
    return list(groups.values())
