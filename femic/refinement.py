"""Models solved and refined until the estimate of C's error meets the tolerance.

One driver for C at points and on grids (`Problem`). Each body is refined until its own estimate meets the
tolerance, and further where what is compared is the sum of both bodies: there the errors add up while the
scale may be that of a component of the sum that is smaller than its parts. Refined is what is too large:
the mesh part by smaller cells, the truncation part by a larger domain, each by as many steps as its order
promises.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Protocol, TypeVar

import numpy as np

from femic.accuracy import NotConverged, Shares
from femic.engine import Engine, Request
from femic.job import Settings
from femic.level import (
    COARSER,
    HIGHER,
    LARGER,
    MESH_ORDER,
    MODELS,
    TRUNCATION_ORDER,
    WAVES_ORDER,
    Level,
    factors,
)
from femic.means import Means, Solved, Task
from femic.models import Cost
from geometries.errors import WrongInput

MOST_STEPS = 3  # of refinement per round
FURTHEST = 4  # steps of cells or domain from where a job starts


@dataclass(frozen=True)
class Assessed:
    """Estimated errors of the bodies; of their sum, where it is judged; of each in the sum."""

    own: Mapping[str, Shares]
    combined: Shares | None = None
    in_combined: Mapping[str, Shares] = field(default_factory=lambda: MappingProxyType({}))


class Refinable(Protocol):
    """A result that may be not accurate enough."""

    @property
    def level(self) -> Level:
        """How far it has been refined."""

    @property
    def models(self) -> Mapping[str, Cost]:
        """What its models took."""


class Asked(Protocol):
    """A job: what is wanted of one body."""

    @property
    def settings(self) -> Settings:
        """By which engine, how accurately, and how large it may become."""

    def request(self, level: Level) -> Any:
        """The model at a level, as the job's engine takes it."""


Found = TypeVar("Found", bound=Refinable)


class Problem(Protocol[Found]):
    """Jobs that are solved together: how solved models are read, combined, and judged."""

    @property
    def jobs(self) -> Mapping[str, Asked]:
        """By body."""

    def read(self, name: str, solved: Solved) -> Any:
        """What is needed of a solved model."""

    def combine(self, name: str, level: Level, models: Mapping[Level, Any]) -> Found:
        """The result of a job at a level, with its estimate, of what was read."""

    def assess(self, found: Mapping[str, Found]) -> Assessed:
        """How large the estimates are."""


def converged(problem: Problem[Found], means: Means) -> dict[str, Found]:
    """Solve and refine all jobs of a problem until their estimates meet their tolerances.

    Raises WrongInput for points outside a model, NotConverged where a tolerance would need a larger model
    than its job allows.
    """
    jobs = problem.jobs
    for name, job in jobs.items():
        require_inside(name, job.request(Level(domain=-1)))
    levels = dict.fromkeys(jobs, Level())
    models: dict[str, dict[Level, Any]] = {name: {} for name in jobs}
    while True:
        todo = [
            (job.settings.engine, Task(name, level, job.request(level), job.settings.most_unknowns))
            for model in MODELS
            for name, job in jobs.items()
            if (level := levels[name].models(job.settings.engine.models).get(model))
            and level not in models[name]
        ]
        means.watch.on_round([task for _, task in todo])
        for solved in solve_models(todo, means):
            models[solved.task.job][solved.task.level] = problem.read(solved.task.job, solved)
            means.watch.on_model(solved)
        found = {name: problem.combine(name, levels[name], models[name]) for name in jobs}
        refinements = refine(jobs, found, problem.assess(found))
        if not refinements:
            return found
        means.watch.on_stage(
            f"  {' and '.join(refinements)} body: not yet as accurate as the tolerance asks: refining"
        )
        levels |= refinements


def solve_models(todo: Sequence[tuple[Engine, Task]], means: Means) -> Iterator[Solved]:
    """Solve models, engine by engine, and yield them as they finish.

    They are kept in the store: an interrupted run of the same code does not solve them again.
    """
    engines = dict.fromkeys(engine for engine, _ in todo)
    for engine in engines:
        yield from engine.solve([task for of, task in todo if of is engine], means)


def refine(jobs: Mapping[str, Asked], found: Mapping[str, Refinable], assessed: Assessed) -> dict[str, Level]:
    """The next levels of the bodies that are not accurate enough; for the sum, of the worse one."""
    short = [name for name, job in jobs.items() if not assessed.own[name].total <= job.settings.tolerance]
    if short or assessed.combined is None:
        return {name: refined(name, jobs[name], found[name], assessed.own[name]) for name in short}
    tolerance = next(iter(jobs.values())).settings.tolerance
    if assessed.combined.total <= tolerance:
        return {}
    name = max(found, key=lambda name: assessed.in_combined[name].total)
    return {name: refined(name, jobs[name], found[name], assessed.in_combined[name], 1 / len(jobs))}


def require_inside(name: str, small: Request) -> None:
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
                f"{xi_end:.4g} mm along x: shorten lines, `rotation_reach` or `moment_arm`, move the patch, "
                "or enlarge `far_radius` and `half_length`"
            )


def refined(name: str, job: Asked, own: Refinable, estimated: Shares, share: float = 1.0) -> Level:
    """The next level of a body: finer cells, a larger domain or both, as its parts of the error ask for.

    `estimated` is its error on the scale of refinement of its own ICs, or on that of the sum of both
    bodies', of whose tolerance it may take a share.
    """
    tolerance = share * job.settings.tolerance
    level = Level(
        own.level.cells + _steps(estimated.mesh, tolerance, COARSER**MESH_ORDER),
        own.level.domain + _steps(estimated.truncation, tolerance, LARGER**TRUNCATION_ORDER),
        own.level.waves + _steps(estimated.waves, tolerance, HIGHER**WAVES_ORDER),
    )
    if level == own.level:  # no part is too large, only their sum
        level = replace(level, cells=level.cells + 1)
    unknowns = own.models["fine"].unknowns
    growth = job.settings.engine.growth_of_unknowns
    expected = round(unknowns * COARSER ** (growth * (level.cells - own.level.cells)))
    if max(level.cells, level.domain, level.waves) > FURTHEST or expected > job.settings.most_unknowns:
        raise NotConverged(_too_expensive(name, job, own, estimated, expected))
    return level


def _steps(error: float, tolerance: float, gain: float) -> int:
    """Steps that bring a part of the error to half of the tolerance, each dividing it by `gain`."""
    if error <= tolerance / 2:
        return 0
    return int(np.clip(np.ceil(np.log(2 * error / tolerance) / np.log(gain)), 1, MOST_STEPS))


def _too_expensive(name: str, job: Asked, own: Refinable, at_worst: Shares, expected: int) -> str:
    cells, domain = factors(own.level)
    settings = job.settings
    return (
        f"{name} body: the estimated error of C_{at_worst.component} on the line {at_worst.line} is "
        f"{at_worst.total:.2%} with "
        f"{own.models['fine'].unknowns:,} unknowns, cells x {cells:.3g}, domain x {domain:.3g} (at worst "
        f"{at_worst.mesh:.2%} from the mesh, {at_worst.truncation:.2%} from the domain, "
        f"{at_worst.waves:.2%} from the wavenumbers); the tolerance "
        f"{settings.tolerance:.2%} would take about {expected:,} unknowns (`most_unknowns` = "
        f"{settings.most_unknowns:,}) or a domain more than {LARGER**FURTHEST:g} times the first. Try a "
        "larger `tolerance` or `most_unknowns`, shorter lines, or only the components that matter"
    )
