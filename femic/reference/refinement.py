"""Refinement: models are solved and refined until the estimated error of C meets the tolerance.

One driver serves C at points (`references`) and on grids (`femic.reference.matrix.reference`). Each body is
refined until its own estimate meets the tolerance. Where the sum of both bodies is compared, refinement goes
on until the sum meets it as well: the errors add up, while a component of the sum, and with it the scale of
refinement, may be smaller than its parts. Each part of the error that is too large is reduced by as many
steps as its order of convergence predicts: the mesh part with smaller cells, the truncation part with a
larger domain, the wave part with more and larger wavenumbers. Boundaries that are given are supports of the
body: they have no truncation part, and stay.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from femic.reference.engine import Engine, ExpectedCost
from femic.reference.job import Job, NotConverged, Shares
from femic.reference.matrix.job import MatrixJob
from femic.reference.result import EstimatedICs, Reference, combine, scales, shares, total
from femic.reference.run_options import (
    COARSER,
    DEFAULT,
    HIGHER,
    LARGER,
    MESH_ORDER,
    MODELS,
    TRUNCATION_ORDER,
    WAVES_ORDER,
    Level,
    RunOptions,
    Solved,
    Task,
    factors,
)
from geometries.arrays import Array
from geometries.errors import WrongInput

# --- errors of the bodies and of their sum ---

Measure = Callable[[str, EstimatedICs], Shares]  # the estimated errors of a body's ICs on some scale


@dataclass(frozen=True)
class Assessment:
    """Estimated errors of the bodies and, where their sum is compared, of the sum and of each body in it."""

    own: Mapping[str, Shares]
    combined: Shares | None = None
    in_combined: Mapping[str, Shares] = field(default_factory=dict)

    def meets(self, tolerances: Mapping[str, float]) -> bool:
        """Whether the bodies meet their tolerances, and their sum that of the first body."""
        sum_tolerance = next(iter(tolerances.values()))
        return all(errors.total <= tolerances[body] for body, errors in self.own.items()) and (
            self.combined is None or self.combined.total <= sum_tolerance
        )


def assess_bodies(
    ics: Mapping[str, EstimatedICs], measure: Callable[[Sequence[str], Array], Measure], *, combined: bool
) -> Assessment:
    """Return the errors of ICs of bodies: of each body and, with `combined`, of the sum of all bodies.

    The ICs share a scale of refinement: they are at all points, or due to loads on one strip. `measure` takes
    names of bodies and the sum of their ICs, and returns the measure on the scale of this sum.
    """
    own = {body: measure([body], c.ic)(body, c) for body, c in ics.items()}
    if not combined:
        return Assessment(own)
    bodies, c = list(ics), total(list(ics.values()))
    of_sum = measure(bodies, c.ic)
    return Assessment(own, of_sum(bodies[0], c), {body: of_sum(body, part) for body, part in ics.items()})


def worst_assessment(assessments: Sequence[Assessment]) -> Assessment:
    """Return the worst errors of several assessments of the same bodies."""
    first = assessments[0]
    combined = [assessment.combined for assessment in assessments if assessment.combined is not None]
    own = {body: worst_shares([one.own[body] for one in assessments]) for body in first.own}
    in_sum = {
        body: worst_shares([one.in_combined[body] for one in assessments]) for body in first.in_combined
    }
    return Assessment(own, worst_shares(combined) if combined else None, in_sum)


def worst_shares(shares: Sequence[Shares]) -> Shares:
    """Return the worst of several shares, with the largest of each part."""
    worst = max(shares, key=lambda row: row.total)
    parts = {part: max(getattr(row, part) for row in shares) for part in ("mesh", "truncation", "waves")}
    return replace(worst, **parts)


# --- the driver ---

MOST_STEPS = 3  # largest number of steps of refinement per round
FURTHEST = 4  # largest number of steps of cells, domain or waves from where a job starts


AnyJob = TypeVar("AnyJob", Job, MatrixJob)
Result = TypeVar("Result")


def solve_to_tolerance(
    jobs: Mapping[str, AnyJob],
    options: RunOptions,
    *,
    read: Callable[[AnyJob, Solved], Any],
    combine: Callable[[AnyJob, Level, Mapping[Level, Any]], Result],
    assess: Callable[[Mapping[str, Result]], Assessment],
) -> dict[str, Result]:
    """Solve and refine jobs, by the names of their bodies, until their estimates meet their tolerances.

    `read` returns what a solved model contributes, `combine` the result of a job at a level from that of its
    models, `assess` the estimated errors of the results. Raises WrongInput for points outside a model,
    NotConverged where a tolerance would need a larger model than its job allows.
    """
    for name, job in jobs.items():
        require_inside(name, job)
    levels = dict.fromkeys(jobs, Level())
    models: dict[str, dict[Level, Any]] = {name: {} for name in jobs}
    while True:
        unsolved = [
            (job.settings.engine, Task(name, level, job.request(level), job.settings.most_unknowns))
            for model in MODELS
            for name, job in jobs.items()
            if (level := levels[name].models(job.settings.engine.models_for(job.body)).get(model))
            and level not in models[name]
        ]
        options.watch.on_round([task for _, task in unsolved])
        for solved in solve_models(unsolved, options):
            models[solved.task.job][solved.task.level] = read(jobs[solved.task.job], solved)
            options.watch.on_model(solved)
        results = {name: combine(job, levels[name], models[name]) for name, job in jobs.items()}
        refinements = next_levels(jobs, results, assess(results))
        if not refinements:
            return results
        options.watch.on_stage(f"  {' and '.join(refinements)} body: not yet within the tolerance; refining")
        levels |= refinements


def solve_models(unsolved: Sequence[tuple[Engine, Task]], options: RunOptions) -> Iterator[Solved]:
    """Solve models, engine by engine, and yield them as they finish."""
    engines = dict.fromkeys(engine for engine, _ in unsolved)
    for engine in engines:
        yield from engine.solve([task for task_engine, task in unsolved if task_engine is engine], options)


def next_levels(
    jobs: Mapping[str, AnyJob], results: Mapping[str, Any], assessed: Assessment
) -> dict[str, Level]:
    """Return the next levels of the bodies that are not accurate enough.

    If only their sum is not accurate enough, the body with the larger estimate is refined.
    """
    inaccurate = [
        name for name, job in jobs.items() if not assessed.own[name].total <= job.settings.tolerance
    ]
    if inaccurate or assessed.combined is None:
        return {name: next_level(name, jobs[name], results[name], assessed.own[name]) for name in inaccurate}
    tolerance = next(iter(jobs.values())).settings.tolerance
    if assessed.combined.total <= tolerance:
        return {}
    name = max(results, key=lambda name: assessed.in_combined[name].total)
    return {name: next_level(name, jobs[name], results[name], assessed.in_combined[name], 1 / len(jobs))}


def require_inside(name: str, job: Job | MatrixJob) -> None:
    """Raise WrongInput if a point or a patch of a job lies outside its smallest model."""
    smallest = job.request(Level(domain=-1))
    body, xi_end, (low, high) = smallest.body, smallest.body.xi_end, smallest.body.s_range
    for patch in dict.fromkeys(load.patch for load in smallest.loads):
        ends = np.array([patch.s - patch.b, patch.s + patch.b])
        s = np.append(smallest.points.s, ends)
        xi = body.surface.chart_x(np.append(smallest.points.x, [patch.a, patch.a]), s, patch.s)
        outside = np.flatnonzero((np.abs(xi) > xi_end) | (s < low) | (s > high))
        if len(outside):
            k = int(outside[0])
            raise WrongInput(
                f"{name} body: the point s = {s[k]:g} mm, {abs(xi[k]):g} mm along x, lies outside the model "
                f"of the error estimate, which goes from s = {low:.4g} to {high:.4g} mm and "
                f"{xi_end:.4g} mm along x: shorten lines, `rotation_reach` or `moment_arm`, move the patch, "
                "or enlarge `far_radius` and `half_length`"
            )


def next_level(name: str, job: Job | MatrixJob, result: Any, estimated: Shares, share: float = 1.0) -> Level:
    """Return the next level of a body: finer cells, a larger domain, more waves, as its error requires.

    `result` is a `Reference` or `MatrixReference`, `estimated` its error on the scale of refinement of its
    own ICs or of the sum of both bodies; `share` is its share of the tolerance. Raises NotConverged where the
    next level would be too expensive.
    """
    settings, now = job.settings, result.level
    tolerance = share * settings.tolerance
    level = Level(
        now.cells + _steps(estimated.mesh, tolerance, COARSER**MESH_ORDER),
        now.domain + _steps(estimated.truncation, tolerance, LARGER**TRUNCATION_ORDER),
        now.waves + _steps(estimated.waves, tolerance, HIGHER**WAVES_ORDER),
    )
    if level == now:  # no part is too large, only their sum
        level = replace(level, cells=level.cells + 1)
    unknowns = result.models["fine"].unknowns
    growth = settings.engine.growth_of_unknowns
    expected = round(unknowns * COARSER ** (growth * (level.cells - now.cells)))
    if max(level.cells, level.domain, level.waves) > FURTHEST or expected > settings.most_unknowns:
        cells, domain = factors(now)
        raise NotConverged(
            f"{name} body: the estimated error of C_{estimated.component} on the line {estimated.line} is "
            f"{estimated.total:.2%} with {unknowns:,} unknowns, cells x {cells:.3g}, domain x {domain:.3g} "
            f"(at worst {estimated.mesh:.2%} from the mesh, {estimated.truncation:.2%} from the domain, "
            f"{estimated.waves:.2%} from the wavenumbers); the tolerance {settings.tolerance:.2%} would take "
            f"about {expected:,} unknowns (`most_unknowns` = {settings.most_unknowns:,}) or a domain more "
            f"than {LARGER**FURTHEST:g} times the first. Try a larger `tolerance` or `most_unknowns`, "
            "shorter lines, or only the components that matter"
        )
    return level


def _steps(error: float, tolerance: float, gain: float) -> int:
    """Return the steps that reduce a part of the error to half the tolerance, each by the factor `gain`."""
    if error <= tolerance / 2:
        return 0
    return int(np.clip(np.ceil(np.log(2 * error / tolerance) / np.log(gain)), 1, MOST_STEPS))


# --- C at points ---


def references(
    jobs: Mapping[str, Job], options: RunOptions = DEFAULT, *, combined: bool = False
) -> dict[str, Reference]:
    """Solve all jobs and refine each until its estimate meets its tolerance.

    With `combined` the estimate of the sum of the bodies must also meet it. Solved models are stored for the
    next run of the same code. Raises WrongInput for points outside a model, NotConverged where the tolerance
    would need a larger model than the job allows.
    """
    return solve_to_tolerance(
        jobs,
        options,
        read=lambda job, solved: job.settings.engine.displacements(
            solved.model, solved.task.request.loads, solved.task.request.points
        ),
        combine=combine,
        assess=partial(assess_references, jobs, combined=combined),
    )


def assess_references(
    jobs: Mapping[str, Job], references: Mapping[str, Reference], *, combined: bool
) -> Assessment:
    """Return the estimated errors of the references and, with `combined`, of their sum."""

    def measure(bodies: Sequence[str], ic: Array) -> Measure:
        scale = scales([jobs[body] for body in bodies], ic)
        return lambda body, c: shares(jobs[body], c, scale)

    ics = {body: reference.c for body, reference in references.items()}
    return assess_bodies(ics, measure, combined=combined)


# --- plans ---


@dataclass(frozen=True)
class ModelPlan:
    """A model before it is solved: its name, engine, size, and expected cost."""

    name: str
    engine: Engine
    cells: float  # their size over the size of the scene's first cells
    far_radius: float  # mm
    along_x: str  # extent of the model along x, in words
    expected: ExpectedCost


def plans(
    jobs: Mapping[str, Job] | Mapping[str, MatrixJob], workers: int, prefix: str = ""
) -> Iterator[ModelPlan]:
    """Yield the plans of the models of the first round; `prefix` comes before their names."""
    for name, job in jobs.items():
        engine = job.settings.engine
        for model, level in Level().models(engine.models_for(job.body)).items():
            request = job.request(level)
            body, expected = request.body, engine.expected_cost(request, workers)
            length_along_x = "infinite" if np.isinf(body.xi_end) else f"{body.xi_end:.4g} mm"
            yield ModelPlan(
                f"{prefix}{name}, {model}",
                engine,
                factors(level)[0],
                body.domain.far_radius,
                "full circle" if body.closed else length_along_x,
                expected,
            )


def total_seconds(model_plans: Sequence[ModelPlan], workers: int) -> float:
    """Return the expected seconds of all models.

    Engines that share a model among workers solve models one by one, others solve them side by side.
    """
    return sum(plan.expected.seconds / (1 if plan.engine.shares_a_model else workers) for plan in model_plans)
