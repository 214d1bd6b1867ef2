"""Refinement of C until it is as accurate as asked.

Every part of the estimate that is larger than half of the tolerance is refined: the mesh part by
smaller cells, the truncation part by a larger domain, each by as many steps as its order promises.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from femic.accuracy import NotConverged, Shares
from femic.harmonic.engine import HarmonicRequest
from femic.harmonic.synthesis import LOWER
from femic.problem import Assessed, Found, Limits, Model, Problem, Refinable
from femic.reference import (
    COARSER,
    LARGER,
    MESH_ORDER,
    MODELS,
    TRUNCATION_ORDER,
    WAVES_ORDER,
    Level,
    factors,
)
from femic.solid.engine import Request
from femic.store import Store
from femic.workers import Solved, Step, Task, solve_models
from geometries.errors import WrongInput

MOST_STEPS = 3  # of refinement per round
GROWTH_OF_UNKNOWNS = {"solid": 2.7, "harmonic": 2.0}  # with 1 / cell size, measured
FURTHEST = 4  # steps of cells or domain from where a job starts


def _ignored(_: object) -> None:
    """Nobody wants to hear of it."""


@dataclass(frozen=True)
class Watch:
    """Who wants to hear of the progress: which models come next, each finished one, and what follows."""

    on_round: Callable[[list[Task]], None] = _ignored
    on_model: Callable[[Solved], None] = _ignored
    on_stage: Callable[[str], None] = _ignored
    on_step: Callable[[Step], None] = _ignored  # within a model


SILENT = Watch()


def converged(
    problem: Problem[Model, Found], *, workers: int, store: Store, watch: Watch
) -> dict[str, Found]:
    """Solve and refine all jobs of a problem until their estimates meet their tolerances.

    Raises WrongInput for points outside a model, NotConverged where a tolerance would need a larger model
    than its job allows.
    """
    jobs = problem.jobs
    for name in jobs:
        require_inside(name, problem.request(name, Level(domain=-1)))
    levels = dict.fromkeys(jobs, Level())
    models: dict[str, dict[Level, Model]] = {name: {} for name in jobs}
    while True:
        todo = [
            Task(name, level, problem.request(name, level), job.most_unknowns)
            for model in MODELS["solid"]
            for name, job in jobs.items()
            if (level := levels[name].models(job.engine).get(model)) and level not in models[name]
        ]
        watch.on_round(todo)
        for solved in solve_models(todo, workers=workers, store=store, on_step=watch.on_step):
            task = solved.task
            models[task.job][task.level] = problem.read(task.request, solved.model)
            watch.on_model(solved)
        found = {name: problem.combine(name, levels[name], models[name]) for name in jobs}
        refinements = refine(jobs, found, problem.assess(found))
        if not refinements:
            return found
        watch.on_stage(
            f"  {' and '.join(refinements)} body: not yet as accurate as engine.tolerance asks: refining"
        )
        levels |= refinements


def refine(
    jobs: Mapping[str, Limits], found: Mapping[str, Refinable], assessed: Assessed
) -> dict[str, Level]:
    """The next levels of the bodies that are not accurate enough; for the sum, of the worse one."""
    short = [name for name, job in jobs.items() if not assessed.own[name].total <= job.tolerance]
    if short or assessed.combined is None:
        return {name: refined(name, jobs[name], found[name], assessed.own[name]) for name in short}
    tolerance = next(iter(jobs.values())).tolerance
    if assessed.combined.total <= tolerance:
        return {}
    name = max(found, key=lambda name: assessed.in_combined[name].total)
    return {name: refined(name, jobs[name], found[name], assessed.in_combined[name], 1 / len(jobs))}


def require_inside(name: str, small: Request | HarmonicRequest) -> None:
    """Raise WrongInput if a point or a patch of a request lies outside its model."""
    body = small.body
    xi_end = body.xi_end
    low, high = body.s_range
    for patch in dict.fromkeys(load.patch for load in small.loads):
        ends = np.array([patch.s - patch.b, patch.s + patch.b])
        s = np.append(small.points.s, ends)
        xi = body.surface.chart_x(np.append(small.points.x, [patch.a, patch.a]), s, patch.s)
        outside = np.flatnonzero((np.abs(xi) > xi_end) | (s < low) | (s > high))
        if len(outside):
            k = int(outside[0])
            raise WrongInput(
                f"{name} body: the point s = {s[k]:g} mm, {abs(xi[k]):g} mm along x, lies outside the model "
                f"of the error estimate, which goes from s = {low:.4g} to {high:.4g} mm and "
                f"{xi_end:.4g} mm along x: shorten lines, rotation_reach or moment_arm, move the patch, "
                "or enlarge engine.far_radius and engine.half_length"
            )


def refined(name: str, job: Limits, own: Refinable, estimated: Shares, share: float = 1.0) -> Level:
    """The next level of a body: finer cells, a larger domain or both, as its parts of the error ask for.

    `estimated` is its error on the scale of refinement of its own ICs, or on that of the sum of both
    bodies', of whose tolerance it may take a share.
    """
    tolerance = share * job.tolerance
    level = Level(
        own.level.cells + _steps(estimated.mesh, tolerance, COARSER**MESH_ORDER),
        own.level.domain + _steps(estimated.truncation, tolerance, LARGER**TRUNCATION_ORDER),
        own.level.waves + _steps(estimated.waves, tolerance, LOWER**WAVES_ORDER),
    )
    if level == own.level:  # no part is too large, only their sum
        level = replace(level, cells=level.cells + 1)
    unknowns = own.models["fine"].unknowns
    growth = GROWTH_OF_UNKNOWNS[job.engine]
    expected = round(unknowns * COARSER ** (growth * (level.cells - own.level.cells)))
    if max(level.cells, level.domain, level.waves) > FURTHEST or expected > job.most_unknowns:
        raise NotConverged(_too_expensive(name, job, own, estimated, expected))
    return level


def _steps(error: float, tolerance: float, gain: float) -> int:
    """Steps that bring a part of the error to half of the tolerance, each dividing it by `gain`."""
    if error <= tolerance / 2:
        return 0
    return int(np.clip(np.ceil(np.log(2 * error / tolerance) / np.log(gain)), 1, MOST_STEPS))


def _too_expensive(name: str, job: Limits, own: Refinable, at_worst: Shares, expected: int) -> str:
    cells, domain = factors(own.level)
    return (
        f"{name} body: the estimated error of C_{at_worst.component} on the line {at_worst.line} is "
        f"{at_worst.total:.2%} with "
        f"{own.models['fine'].unknowns:,} unknowns, cells x {cells:.3g}, domain x {domain:.3g} (at worst "
        f"{at_worst.mesh:.2%} from the mesh, {at_worst.truncation:.2%} from the domain, "
        f"{at_worst.waves:.2%} from the wavenumbers); the tolerance "
        f"{job.tolerance:.2%} would take about {expected:,} unknowns (engine.most_unknowns = "
        f"{job.most_unknowns:,}) or a domain more than {LARGER**FURTHEST:g} times the first. Try a larger "
        "engine.tolerance or engine.most_unknowns, shorter lines, or only the components that matter"
    )
