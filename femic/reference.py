"""C with its error estimate: one body solved on several models, discounted, compared.

The estimate has two parts. Mesh: the same body with cells `COARSER` times as large. Truncation: those
larger cells in a domain half as large. With errors that fall like h^2 and L^-2, an error is at most
the observed difference over (ratio^2 - 1).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from joblib import Memory, Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError
from numpy.typing import NDArray

from femic.discount import discount_points, fit_discount, loads_needed, rigid_part
from femic.linear import SolverChoice
from femic.solid import Cost, Points, RawICs, Request, raw_ics
from femic.tetrahedra import Cells
from geometries.bodies import PrismaticBody
from geometries.errors import Failure
from geometries.patches import Patch

Array = NDArray[np.float64]

COARSER = 1.5
SMALLER = 0.5
MODELS = ("fine", "coarse", "small")  # the most expensive first
ORDER = 2  # of both errors, in cell size and in 1 / domain size


@dataclass(frozen=True)
class Job:
    """The reference ICs of one body that a scene asks for."""

    body: PrismaticBody
    patch: Patch
    directions: tuple[int, ...]
    points: Points
    cells: Cells
    rotation_reach: float
    solver: SolverChoice = "auto"


@dataclass(frozen=True)
class Reference:
    """C of one body per unit total load [mm/N], shape (3, 3, n); NaN where nothing was solved."""

    ic: Array  # after the discount
    raw: Array  # before it, with clamped far boundaries
    estimate: Array  # of the error of `ic`, not negative
    discount: Array  # M, (4, 4)
    models: Mapping[str, Cost]  # "fine", "coarse", "small"


@dataclass(frozen=True)
class Discounted:
    """One model's ICs after the discount (3, 3, n), with M (4, 4)."""

    ic: Array
    raw: Array
    m: Array


@dataclass(frozen=True)
class Solved:
    """The raw ICs of one model of one job; `kept` if an earlier run had solved it."""

    job: str
    model: str
    raw: RawICs
    kept: bool


def requests(job: Job) -> dict[str, Request]:
    """The models whose differences give the error estimate, the finest first."""
    extra = discount_points(job.patch, job.rotation_reach)
    points = Points(np.concatenate([job.points.x, extra.x]), np.concatenate([job.points.s, extra.s]))
    directions = loads_needed(job.body.contour, job.directions)
    fine = Request(job.body, job.patch, directions, points, job.cells, job.solver)
    coarse = replace(fine, cells=job.cells.scaled(COARSER))
    small_body = replace(job.body, domain=job.body.domain.scaled(SMALLER))
    return {"fine": fine, "coarse": coarse, "small": replace(coarse, body=small_body)}


def combine(job: Job, raw: Mapping[str, RawICs]) -> Reference:
    """Discount each model's ICs and estimate the error of the finest from their differences."""
    fine, coarse, small = (discounted(job, raw[name].ic) for name in MODELS)
    mesh = np.abs(fine.ic - coarse.ic) / (COARSER**ORDER - 1)
    truncation = np.abs(coarse.ic - small.ic) / (SMALLER**-ORDER - 1)
    models = MappingProxyType({name: result.cost for name, result in raw.items()})
    return Reference(fine.ic, fine.raw, mesh + truncation, fine.m, models)


def discounted(job: Job, raw: Array) -> Discounted:
    """Subtract the rigid part from the raw ICs (3, 3, n) of one of the job's models."""
    extra = discount_points(job.patch, job.rotation_reach)
    n = len(job.points.x)
    directions = loads_needed(job.body.contour, job.directions)
    m = fit_discount(job.body, job.patch, extra, raw[..., n:], directions)
    rigid = rigid_part(m, job.body.contour, job.points.s, job.patch.s)
    return Discounted(raw[..., :n] - rigid, raw[..., :n], m)


def solve_models(jobs: Mapping[str, Job], *, workers: int, memory: Memory) -> Iterator[Solved]:
    """Solve all models of all jobs in parallel processes; yields them as they finish.

    Finished models are kept in `memory`: an interrupted run resumes behind the last of them.
    """
    of_job = {name: requests(job) for name, job in jobs.items()}
    tasks = [(name, model, of_job[name][model]) for model in MODELS for name in jobs]
    run = Parallel(n_jobs=workers, return_as="generator_unordered")
    try:
        yield from run(delayed(_solve_once)(memory, *task) for task in tasks)
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes was killed, most likely for memory: use fewer (--workers 1) "
            "or larger cells (engine.growth, engine.line_growth). Finished models are kept"
        ) from error


def _solve_once(memory: Memory, job: str, model: str, request: Request) -> Solved:
    solve = memory.cache(raw_ics)
    kept = solve.check_call_in_cache(request)
    return Solved(job, model, solve(request), kept)
