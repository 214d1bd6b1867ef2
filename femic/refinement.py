"""Refinement of C until it is as accurate as asked.

Every part of the estimate that is larger than half of the tolerance is refined: the mesh part by
smaller cells, the truncation part by a larger domain, each by as many steps as its order promises.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from femic.accuracy import NotConverged
from femic.harmonic.engine import LOWER
from femic.reference import (
    COARSER,
    LARGER,
    MESH_ORDER,
    MODELS,
    TRUNCATION_ORDER,
    WAVES_ORDER,
    Estimated,
    Job,
    Level,
    Models,
    Reference,
    combine,
    factors,
    request,
    scales,
    total,
    worst,
)
from femic.workers import Solved, memory_in, solve_models
from geometries.errors import WrongInput

Array = NDArray[np.float64]

MOST_STEPS = 3  # of refinement per round
GROWTH_OF_UNKNOWNS = {"solid": 2.7, "harmonic": 2.0}  # with 1 / cell size, measured
FURTHEST = 4  # steps of cells or domain from where a job starts


def _ignored(_: object) -> None:
    """Nobody wants to hear of it."""


@dataclass(frozen=True)
class Watch:
    """Who wants to hear of the progress: which models come next, each finished one, and what follows."""

    on_round: Callable[[list[tuple[str, Level]]], None]
    on_model: Callable[[Solved], None]
    on_stage: Callable[[str], None] = _ignored
    on_step: Callable[[str], None] = _ignored  # within a model


SILENT = Watch(_ignored, _ignored)


def references(
    jobs: Mapping[str, Job],
    *,
    combined: bool = False,
    workers: int = 1,
    kept: Path | None = None,
    watch: Watch = SILENT,
) -> dict[str, Reference]:
    """Solve all jobs, refining each until its estimate meets its tolerance; `combined`: their sum's too.

    Solved models are kept in the folder `kept`, where the next run of the same code finds them.
    Raises WrongInput for points outside a model, NotConverged where the tolerance would need a
    larger model than the job allows.
    """
    for name, job in jobs.items():
        require_inside(name, job)
    memory = memory_in(kept)
    levels = dict.fromkeys(jobs, Level())
    models: dict[str, Models] = {name: {} for name in jobs}
    while True:
        todo = [
            (name, level)
            for model in MODELS["solid"]
            for name, job in jobs.items()
            if (level := levels[name].models(job.engine).get(model)) and level not in models[name]
        ]
        watch.on_round(todo)
        for solved in solve_models(jobs, todo, workers=workers, memory=memory, on_step=watch.on_step):
            models[solved.job][solved.level] = solved.raw
            watch.on_model(solved)
        found = {name: combine(jobs[name], levels[name], models[name]) for name in jobs}
        refinements = refine(jobs, found, combined=combined)
        if not refinements:
            return found
        watch.on_stage(
            f"  {' and '.join(refinements)} body: not yet as accurate as engine.tolerance asks: refining"
        )
        levels |= refinements


def refine(jobs: Mapping[str, Job], found: Mapping[str, Reference], *, combined: bool) -> dict[str, Level]:
    """The next levels of the bodies that are not accurate enough; for the sum, of the worse one."""
    own = {name: scales([job], found[name].c.ic) for name, job in jobs.items()}
    short = [name for name, job in jobs.items() if not converged(job, found[name].c, own[name])]
    if short or not combined:
        return {name: refined(name, jobs[name], found[name], own[name]) for name in short}
    job, c = next(iter(jobs.values())), total([reference.c for reference in found.values()])
    scale = scales(list(jobs.values()), c.ic)
    if converged(job, c, scale):
        return {}
    name = max(found, key=lambda name: worst(job, found[name].c.estimate, scale))
    shared = replace(jobs[name], tolerance=job.tolerance / len(jobs))
    return {name: refined(name, shared, found[name], scale)}


def require_inside(name: str, job: Job) -> None:
    """Raise WrongInput if a point or a patch lies outside the smallest model."""
    small = request(job, Level(domain=-1))
    body = small.body
    xi_end = body.xi_end
    low, high = body.s_range
    for load in small.loads:
        patch = load.patch
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


def converged(job: Job, c: Estimated, scale: Mapping[str, Array]) -> bool:
    """Whether the estimate meets the tolerance."""
    return worst(job, c.estimate, scale)[0] <= job.tolerance


def refined(name: str, job: Job, own: Reference, scale: Mapping[str, Array]) -> Level:
    """The next level of a body: finer cells, a larger domain or both, as its parts of the error ask for.

    `scale` is that of the body's own ICs, or that of the sum of both bodies'.
    """
    mesh, truncation, waves = _parts(job, own, scale)
    level = Level(
        own.level.cells + _steps(mesh, job, COARSER**MESH_ORDER),
        own.level.domain + _steps(truncation, job, LARGER**TRUNCATION_ORDER),
        own.level.waves + _steps(waves, job, LOWER**WAVES_ORDER),
    )
    unknowns = own.models["fine"].unknowns
    growth = GROWTH_OF_UNKNOWNS[job.engine]
    expected = round(unknowns * COARSER ** (growth * (level.cells - own.level.cells)))
    if max(level.cells, level.domain, level.waves) > FURTHEST or expected > job.most_unknowns:
        raise NotConverged(_too_expensive(name, job, own, scale, expected))
    return level


def _parts(job: Job, own: Reference, scale: Mapping[str, Array]) -> list[float]:
    """Worst shares of the parts of the estimate: mesh, truncation, wavenumbers."""
    parts = (own.c.mesh_error, own.c.truncation_error, own.c.waves_error)
    return [worst(job, part, scale)[0] for part in parts]


def _steps(error: float, job: Job, gain: float) -> int:
    """Steps that bring a part of the error to half of the tolerance, each dividing it by `gain`."""
    if error <= job.tolerance / 2:
        return 0
    return int(np.clip(np.ceil(np.log(2 * error / job.tolerance) / np.log(gain)), 1, MOST_STEPS))


def _too_expensive(name: str, job: Job, own: Reference, scale: Mapping[str, Array], expected: int) -> str:
    error, component, line = worst(job, own.c.estimate, scale)
    mesh, truncation, waves = _parts(job, own, scale)
    cells, domain = factors(own.level)
    return (
        f"{name} body: the estimated error of C_{component} on the line {line} is {error:.2%} with "
        f"{own.models['fine'].unknowns:,} unknowns, cells x {cells:.3g}, domain x {domain:.3g} (at worst "
        f"{mesh:.2%} from the mesh, {truncation:.2%} from the domain, {waves:.2%} from the wavenumbers); the "
        "tolerance "
        f"{job.tolerance:.2%} would take about {expected:,} unknowns (engine.most_unknowns = "
        f"{job.most_unknowns:,}) or a domain more than {LARGER**FURTHEST:g} times the first. Try a larger "
        "engine.tolerance or engine.most_unknowns, shorter lines, or only the components that matter"
    )
