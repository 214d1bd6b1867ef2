"""C with its error estimate, refined until it is as accurate as asked.

Every body is solved on three models: fine, coarse (cells `COARSER` times as large) and small (the
coarse cells in a domain half as large). Their differences give the two parts of the estimate, as in
Roache's grid convergence index; the larger part says what to refine. Errors fall like h^3 and L^-2
(measured: docs/solid-engine.md); the estimate assumes h^2, because mesh errors are partly random.
"""

import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from joblib import Memory, Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError
from numpy.typing import NDArray

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.accuracy import component_of, line_errors
from femic.discount import DiscountRule, conditions, fit_discount, observers, rigid_part
from femic.linear import NotConverged, SolverChoice
from femic.provenance import code_digest
from femic.solid import Cost, Points, RawICs, Request, directions_of, raw_ics
from femic.symmetry import N
from femic.tetrahedra import Cells
from geometries.bodies import Body
from geometries.errors import Failure, WrongInput
from geometries.materials import one_body
from geometries.patches import Load, Patch

Array = NDArray[np.float64]

COARSER = 1.5
LARGER = 2.0
MESH_ORDER, TRUNCATION_ORDER = 3, 2  # of the errors, in cell size and in 1 / domain size
ESTIMATE_ORDER = 2  # assumed by the estimate of both parts
SAFETY = 1.25  # Roache's factor
MODELS = ("fine", "coarse", "small")  # the most expensive first
MOST_STEPS = 3  # of refinement per round
GROWTH_OF_UNKNOWNS = 2.7  # with 1 / cell size, measured
FURTHEST = 4  # steps of cells or domain from where a job starts

# Cells that meet TUNED_TOLERANCE on the built-in scenes
TUNED_TOLERANCE = 0.01
CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH = 12, 0.14, 0.05
COARSEST = 3.0  # times these cells, however large the tolerance


def cells_for(tolerance: float, patch: Patch) -> Cells:
    """Cells that are likely to meet a tolerance: errors fall like the cube of the cell size."""
    factor = min((tolerance / TUNED_TOLERANCE) ** (1 / MESH_ORDER), COARSEST)
    return Cells(min(patch.a, patch.b) / CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH).scaled(factor)


@dataclass(frozen=True)
class Job:
    """The reference ICs of one body: what is asked, how accurately, and with which cells to start.

    `lines` says which points lie on which line: errors refer to the scale of a line. Lengths in mm;
    `rotation_reach` and `moment_arm` say where M is fitted (`femic.discount`); `cells` are those to
    start with, by default what the tolerance needs. No model may have more than `most_unknowns`.
    """

    body: Body
    patch: Patch
    components: tuple[str, ...]
    points: Points
    lines: Mapping[str, slice]
    tolerance: float = TUNED_TOLERANCE
    cells: Cells | None = None
    rotation_reach: float = 20.0
    moment_arm: float = 5.0
    most_unknowns: int = 1_000_000
    solver: SolverChoice = "auto"

    @property
    def first_cells(self) -> Cells:
        """The cells to start with."""
        return self.cells or cells_for(self.tolerance, self.patch)

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads whose displacements are asked for."""
        return tuple(Load(self.patch, direction) for direction in directions_of(self.components))

    @property
    def rule(self) -> DiscountRule:
        """How M is fitted."""
        return DiscountRule(self.patch.a, self.patch.b, self.rotation_reach, self.moment_arm)


@dataclass(frozen=True)
class Level:
    """Steps of refinement of a model from what the job starts with."""

    cells: int = 0
    domain: int = 0

    def models(self) -> dict[str, "Level"]:
        """The models that give C at this level, and its error."""
        coarse = replace(self, cells=self.cells - 1)
        return {"fine": self, "coarse": coarse, "small": replace(coarse, domain=self.domain - 1)}


@dataclass(frozen=True)
class Reference:
    """C of one body per unit total load [mm/N], shape (3, 3, n); NaN where nothing was solved."""

    ic: Array  # after the discount
    raw: Array  # before it, with clamped far boundaries
    mesh_error: Array  # estimates of the two parts of the error of `ic`, not negative
    truncation_error: Array
    discount: Array  # M, (4, 4)
    level: Level
    cells: Cells  # of the fine model, as its domain
    body: Body
    models: Mapping[str, Cost]  # "fine", "coarse", "small", and those of earlier rounds

    @property
    def estimate(self) -> Array:
        """Estimate of the error of `ic`."""
        return self.mesh_error + self.truncation_error


@dataclass(frozen=True)
class Solved:
    """The raw ICs of one model of one job; `kept` if an earlier run had solved it."""

    job: str
    level: Level
    raw: RawICs
    kept: bool


Models = dict[Level, RawICs]


def _ignored(_: object) -> None:
    """Nobody wants to hear of it."""


@dataclass(frozen=True)
class Watch:
    """Who wants to hear of the progress: which models come next, each finished one, and what follows."""

    on_round: Callable[[list[tuple[str, Level]]], None]
    on_model: Callable[[Solved], None]
    on_stage: Callable[[str], None] = _ignored


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
    memory = Memory(kept and _folder_of_this_code(kept), verbose=0)
    levels = dict.fromkeys(jobs, Level())
    models: dict[str, Models] = {name: {} for name in jobs}
    while True:
        todo = [
            (name, level)
            for model in MODELS
            for name in jobs
            if (level := levels[name].models()[model]) not in models[name]
        ]
        watch.on_round(todo)
        for solved in solve_models(jobs, todo, workers=workers, memory=memory):
            models[solved.job][solved.level] = solved.raw
            watch.on_model(solved)
        found = {name: combine(jobs[name], levels[name], models[name]) for name in jobs}
        refinements = refine(jobs, found, combined=combined)
        if not refinements:
            return found
        levels |= refinements


def refine(jobs: Mapping[str, Job], found: Mapping[str, Reference], *, combined: bool) -> dict[str, Level]:
    """The next levels of the bodies that are not accurate enough; for the sum, of the worse one."""
    short = [name for name, job in jobs.items() if not converged(job, found[name])]
    if short or not combined:
        return {name: refined(name, jobs[name], found[name], found[name]) for name in short}
    job, total = next(iter(jobs.values())), summed(list(found.values()))
    if converged(job, total):
        return {}
    name = max(found, key=lambda name: worst(job, total, found[name].estimate))
    shared = replace(jobs[name], tolerance=job.tolerance / len(jobs))
    return {name: refined(name, shared, found[name], total)}


def summed(parts: list[Reference]) -> Reference:
    """The combined ICs of some bodies; their estimates add up."""
    ic, mesh, truncation = (
        np.sum([getattr(part, name) for part in parts], axis=0)
        for name in ("ic", "mesh_error", "truncation_error")
    )
    return replace(parts[0], ic=ic, mesh_error=mesh, truncation_error=truncation)


def require_inside(name: str, job: Job) -> None:
    """Raise WrongInput if a point or a patch lies outside the smallest model."""
    small = request(job, Level().models()["small"])
    body = small.body
    low, high = body.s_range
    for load in small.loads:
        patch = load.patch
        ends = np.array([patch.s - patch.b, patch.s + patch.b])
        s = np.append(small.points.s, ends)
        xi = body.surface.chart_x(np.append(small.points.x, [patch.a, patch.a]), s, patch.s)
        outside = np.flatnonzero((np.abs(xi) > body.xi_end) | (s < low) | (s > high))
        if len(outside):
            k = int(outside[0])
            raise WrongInput(
                f"{name} body: the point s = {s[k]:g} mm, {abs(xi[k]):g} mm along x, lies outside the model "
                f"of the error estimate, which goes from s = {low:.4g} to {high:.4g} mm and "
                f"{body.xi_end:.4g} mm along x: shorten lines, rotation_reach or moment_arm, move the patch, "
                "or enlarge engine.far_radius and engine.half_length"
            )


def request(job: Job, level: Level) -> Request:
    """The model of a job at a level: all loads and points that C and its discount need."""
    fit = conditions(job.body, job.rule, job.loads)
    loads = tuple(dict.fromkeys([*job.loads, *(load for c in fit for load in c.loads)]))
    extra = observers(job.body, job.rule, fit)
    points = Points(np.concatenate([job.points.x, extra.x]), np.concatenate([job.points.s, extra.s]))
    body, cells = scaled(job, level)
    return Request(body, loads, points, cells, job.solver)


def scaled(job: Job, level: Level) -> tuple[Body, Cells]:
    """Body and cells of a job at a level."""
    cells, domain = factors(level)
    body = replace(job.body, domain=job.body.domain.scaled(domain))
    return body, job.first_cells.scaled(cells)


def factors(level: Level) -> tuple[float, float]:
    """Size of the cells and of the domain at a level, as multiples of the job's own."""
    return COARSER**-level.cells, LARGER**level.domain


def combine(job: Job, level: Level, models: Models) -> Reference:
    """Discount each model's displacements and estimate the error of the finest from their differences."""
    of_level = level.models()
    (ic, raw, m), (coarse, *_), (small, *_) = (discounted(job, models[of_level[name]]) for name in MODELS)
    costs = {name: models[of_level[name]].cost for name in MODELS}
    earlier = [other for other in models if other not in of_level.values()]
    costs |= {f"earlier {k + 1}": models[other].cost for k, other in enumerate(earlier)}
    body, cells = scaled(job, level)
    return Reference(
        ic,
        raw,
        SAFETY * np.abs(ic - coarse) / (COARSER**ESTIMATE_ORDER - 1),
        SAFETY * np.abs(coarse - small) / (LARGER**ESTIMATE_ORDER - 1),
        m,
        level,
        cells,
        body,
        MappingProxyType(costs),
    )


def discounted(job: Job, model: RawICs) -> tuple[Array, Array, Array]:
    """ICs (3, 3, n) after and before the subtraction of the rigid part, and M, of one model of a job."""
    fit = conditions(job.body, job.rule, job.loads)
    loads = request(job, Level()).loads
    n = len(job.points.x)
    at_fit_points = {load: u[:, n:] for load, u in zip(loads, model.u, strict=True)}
    m = fit_discount(job.body, job.rule, fit, at_fit_points)
    raw, rigid = np.full((2, 3, 3, n), np.nan)
    for load, u in zip(job.loads, model.u, strict=False):  # the job's own loads come first
        raw[:, load.direction] = u[:, :n]
        rigid[:, load.direction] = rigid_part(m, job.body, job.points, load)
    return raw - rigid, raw, m


def estimated_errors(job: Job, reference: Reference, error: Array) -> dict[str, Array]:
    """Estimated errors per line as shares of its scale, shape (3, 3): of `estimate` or a part of it."""
    nn = scale_nn(job, reference.ic)
    return {line: line_errors(error[..., p], reference.ic[..., p], nn[p]) for line, p in job.lines.items()}


def scale_nn(job: Job, ic: Array) -> Array:
    """The nn ICs that set the scale of small components, shape (n,): C's, A's where not solved."""
    if not np.any(np.isnan(ic[N, N])):
        return ic[N, N]
    half_space = HalfSpace(one_body(job.body.material, job.body.side))
    at = job.points.x, job.points.s
    return approximate("A", half_space, job.body.surface, job.patch, at)[N, N] / job.patch.area


def worst(job: Job, reference: Reference, error: Array) -> tuple[float, str, str]:
    """Largest estimated error over lines and components: (share, component, line)."""
    errors = estimated_errors(job, reference, np.nan_to_num(error, nan=np.inf))
    return max((component_of(errors[line], c), c, line) for c in job.components for line in errors)


def converged(job: Job, reference: Reference) -> bool:
    """Whether the estimate meets the tolerance."""
    return worst(job, reference, reference.estimate)[0] <= job.tolerance


def refined(name: str, job: Job, own: Reference, scale: Reference) -> Level:
    """The next level of a body: finer cells, a larger domain or both, as its parts of the error ask for.

    Errors are shares of the scales of `scale`: the body's own ICs, or the sum of both bodies'.
    """
    parts = {
        "mesh": worst(job, scale, own.mesh_error)[0],
        "truncation": worst(job, scale, own.truncation_error)[0],
    }
    level = Level(
        own.level.cells + _steps(parts["mesh"], job, COARSER**MESH_ORDER),
        own.level.domain + _steps(parts["truncation"], job, LARGER**TRUNCATION_ORDER),
    )
    unknowns = own.models["fine"].unknowns
    expected = round(unknowns * COARSER ** (GROWTH_OF_UNKNOWNS * (level.cells - own.level.cells)))
    if max(level.cells, level.domain) > FURTHEST or expected > job.most_unknowns:
        raise NotConverged(_too_expensive(name, job, (own, scale), parts, expected))
    return level


def _steps(error: float, job: Job, gain: float) -> int:
    """Steps that bring a part of the error to half of the tolerance, each dividing it by `gain`."""
    if error <= job.tolerance / 2:
        return 0
    return int(np.clip(np.ceil(np.log(2 * error / job.tolerance) / np.log(gain)), 1, MOST_STEPS))


def _too_expensive(
    name: str, job: Job, found: tuple[Reference, Reference], parts: Mapping[str, float], expected: int
) -> str:
    own, scale = found
    error, component, line = worst(job, scale, own.estimate)
    cells, domain = factors(own.level)
    return (
        f"{name} body: the estimated error of C_{component} on the line {line} is {error:.2%} with "
        f"{own.models['fine'].unknowns:,} unknowns, cells x {cells:.3g}, domain x {domain:.3g} (at worst "
        f"{parts['mesh']:.2%} from the mesh, {parts['truncation']:.2%} from the domain); the tolerance "
        f"{job.tolerance:.2%} would take about {expected:,} unknowns (engine.most_unknowns = "
        f"{job.most_unknowns:,}) or a domain more than {LARGER**FURTHEST:g} times the first. Try a larger "
        "engine.tolerance or engine.most_unknowns, shorter lines, or only the components that matter"
    )


def solve_models(
    jobs: Mapping[str, Job], todo: list[tuple[str, Level]], *, workers: int, memory: Memory
) -> Iterator[Solved]:
    """Solve models in parallel processes; yields them as they finish.

    Finished models are kept in `memory`: an interrupted run resumes behind the last of them.
    """
    run = Parallel(n_jobs=workers, return_as="generator_unordered")
    try:
        yield from run(
            delayed(_solve_once)(memory, name, level, request(jobs[name], level), jobs[name].most_unknowns)
            for name, level in todo
        )
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes was killed, most likely for memory: use fewer (--workers 1) "
            "or larger cells (engine.growth, engine.line_growth). Finished models are kept"
        ) from error


def _folder_of_this_code(kept: Path) -> Path:
    """Where this code keeps its models; deletes those of other versions, and nothing else."""
    folder = kept / code_digest()
    folder.mkdir(parents=True, exist_ok=True)
    for other in kept.iterdir():
        if other != folder and re.fullmatch("[0-9a-f]{12}", other.name):
            shutil.rmtree(other)
    return folder


def _solve_once(memory: Memory, job: str, level: Level, asked: Request, most_unknowns: int) -> Solved:
    solve = memory.cache(raw_ics, ignore=["most_unknowns"])
    kept = solve.check_call_in_cache(asked, most_unknowns)
    return Solved(job, level, solve(asked, most_unknowns), kept)
