"""Models solved in parallel, and kept for the next run of the same code."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial

import xarray as xr
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.accuracy import NotConverged
from femic.harmonic import engine as harmonic
from femic.harmonic.engine import HarmonicRequest
from femic.harmonic.entry import KeptWaves, from_entry, to_entry
from femic.harmonic.expected import expected_wavenumbers
from femic.harmonic.synthesis import Responses
from femic.models import RawICs, cost_from
from femic.processes import in_processes
from femic.reference import Level
from femic.solid import engine as solid
from femic.solid.engine import Request
from femic.store import Store
from geometries.errors import Failure


@dataclass(frozen=True)
class Task:
    """A model of a job that is to be solved, and how large it may be."""

    job: str
    level: Level
    request: Request | HarmonicRequest
    most_unknowns: int


@dataclass(frozen=True)
class Solved:
    """A solved model of a job; `kept` if an earlier run had solved it."""

    task: Task
    model: RawICs | Responses
    kept: bool


@dataclass(frozen=True)
class Step:
    """What a model that is being solved is at; how many wavenumbers it has, and may need."""

    task: Task
    stage: str
    wavenumbers: int = 0
    expected: int | None = None


OnStep = Callable[[Step], None]


def solve_models(tasks: Sequence[Task], *, workers: int, store: Store, on_step: OnStep) -> Iterator[Solved]:
    """Solve models, solid ones in parallel processes, harmonic ones by themselves in parallel threads.

    Yields them as they finish. They are kept in the store: an interrupted run resumes behind the last one,
    behind the last wavenumber of a harmonic one. `on_step` hears what is going on within a model.
    """
    for task in tasks:
        if isinstance(task.request, HarmonicRequest):
            yield _solve_harmonic(task, workers, store, on_step)
    solids = [task for task in tasks if isinstance(task.request, Request)]
    yield from _solve_solid(solids, workers, store, on_step)


def _solve_harmonic(task: Task, workers: int, store: Store, on_step: OnStep) -> Solved:
    request = task.request
    assert isinstance(request, HarmonicRequest)
    key = store.key("harmonic", *request.determined_by)
    entry = store.get(key)
    if entry is not None:
        return Solved(task, from_entry(entry, request), kept=True)
    on_step(Step(task, "mesh and assembly"))
    expected = _expected(request)
    responses = harmonic.solve(
        request,
        task.most_unknowns,
        workers=workers,
        progress=lambda solved: on_step(Step(task, "first wavenumbers", solved, expected)),
        kept=KeptWaves(store, key),
    )
    store.put(key, to_entry(responses))
    return Solved(task, responses, kept=False)


def _expected(request: HarmonicRequest) -> int | None:
    try:
        return expected_wavenumbers(request)
    except NotConverged:  # of the half-space: the body itself will tell
        return None


def _solve_solid(tasks: Sequence[Task], workers: int, store: Store, on_step: OnStep) -> Iterator[Solved]:
    new = []
    for task in tasks:
        entry = store.get(_solid_key(task, store))
        if entry is None:
            new.append(task)
        else:
            yield Solved(task, RawICs(entry.u.values, cost_from(entry.attrs["cost"])), kept=True)
    try:
        yield from in_processes(partial(_solve_new, store=store), _begun(new, on_step), workers)
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes ended without an answer. It was killed, most likely for "
            "memory: use fewer (--workers 1) or larger cells (engine.growth, engine.line_growth). Or the "
            "mesher crashed, which it does at the same place with one process too: change the cells a "
            "little (engine.smallest_cell, engine.growth). Finished models are kept"
        ) from error


def _begun(tasks: Sequence[Task], on_step: OnStep) -> Iterator[Task]:
    """Tasks as processes take them: each is worked at from then on."""
    for task in tasks:
        on_step(Step(task, "solid engine at work"))
        yield task


def _solid_key(task: Task, store: Store) -> str:
    return store.key("solid", task.request)


def _solve_new(task: Task, store: Store) -> Solved:
    assert isinstance(task.request, Request)
    raw = solid.raw_ics(task.request, task.most_unknowns)
    u = xr.Variable(("load", "i", "point"), raw.u, {"units": "mm/N"})
    store.put(_solid_key(task, store), xr.Dataset({"u": u}, attrs={"cost": json.dumps(asdict(raw.cost))}))
    return Solved(task, raw, kept=False)
