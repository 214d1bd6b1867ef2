"""Models solved in parallel, and kept for the next run of the same code."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial

import xarray as xr
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.harmonic import engine as harmonic
from femic.harmonic.engine import HarmonicRequest
from femic.harmonic.entry import KeptWaves, from_entry, to_entry
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


def solve_models(
    tasks: Sequence[Task], *, workers: int, store: Store, on_step: Callable[[str], None]
) -> Iterator[Solved]:
    """Solve models, solid ones in parallel processes, harmonic ones by themselves in parallel threads.

    Yields them as they finish. They are kept in the store: an interrupted run resumes behind the last one,
    behind the last wavenumber of a harmonic one. `on_step` hears what is going on within a model.
    """
    for task in tasks:
        if isinstance(task.request, HarmonicRequest):
            yield _solve_harmonic(task, workers, store, on_step)
    yield from _solve_solid([task for task in tasks if isinstance(task.request, Request)], workers, store)


def _solve_harmonic(task: Task, workers: int, store: Store, on_step: Callable[[str], None]) -> Solved:
    request = task.request
    assert isinstance(request, HarmonicRequest)
    key = store.key("harmonic", *request.determined_by)
    entry = store.get(key)
    if entry is not None:
        return Solved(task, from_entry(entry, request), kept=True)
    responses = harmonic.solve(
        request,
        task.most_unknowns,
        workers=workers,
        progress=lambda solved: on_step(f"{task.job} body: {solved} wavenumbers"),
        kept=KeptWaves(store, key),
    )
    store.put(key, to_entry(responses))
    return Solved(task, responses, kept=False)


def _solve_solid(tasks: Sequence[Task], workers: int, store: Store) -> Iterator[Solved]:
    try:
        yield from in_processes(partial(_solve_once, store=store), tasks, workers)
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes ended without an answer. It was killed, most likely for "
            "memory: use fewer (--workers 1) or larger cells (engine.growth, engine.line_growth). Or the "
            "mesher crashed, which it does at the same place with one process too: change the cells a "
            "little (engine.smallest_cell, engine.growth). Finished models are kept"
        ) from error


def _solve_once(task: Task, store: Store) -> Solved:
    assert isinstance(task.request, Request)
    key = store.key("solid", task.request)
    entry = store.get(key)
    if entry is not None:
        return Solved(task, RawICs(entry.u.values, cost_from(entry.attrs["cost"])), kept=True)
    raw = solid.raw_ics(task.request, task.most_unknowns)
    u = xr.Variable(("load", "i", "point"), raw.u, {"units": "mm/N"})
    store.put(key, xr.Dataset({"u": u}, attrs={"cost": json.dumps(asdict(raw.cost))}))
    return Solved(task, raw, kept=False)
