"""Models of the solid engine are solved in parallel processes, and kept."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import partial

import xarray as xr
from joblib.externals.loky.process_executor import TerminatedWorkerError

from femic.cache.processes import in_processes
from femic.cache.store import Store
from femic.reference.models import RawICs, cost_from
from femic.reference.run_options import RunOptions, Solved, Step, Task
from femic.reference.solid.engine import raw_ics
from femic.reference.solid.request import SolidRequest
from geometries.errors import Failure


def solve_tasks(tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
    """Solve models, and yield each as it is finished; models that an earlier run finished come first.

    Raises Failure where a worker process ends without a result.
    """
    store, unsolved = options.store, []
    for task in tasks:
        entry = store.get(model_key(task.request, store))
        if entry is None:
            unsolved.append(task)
        else:
            yield Solved(task, RawICs(entry.u.values, cost_from(entry.attrs["cost"])), cached=True)
    begun_tasks, workers = _begun(unsolved, options.watch.on_step), options.workers
    try:
        yield from in_processes(partial(_solved, store=store), begun_tasks, workers)
    except TerminatedWorkerError as error:
        raise Failure(
            f"one of {workers} worker processes ended without an answer. It was killed, most likely for "
            "memory: use fewer (`workers` = 1) or larger cells (`growth`, `line_growth`). Or the "
            "mesher crashed, which it does at the same place with one process too: change the cells a "
            "little (`smallest_cell`, `growth`). Finished models are kept"
        ) from error


def _begun(tasks: Sequence[Task], on_step: Callable[[Step], None]) -> Iterator[Task]:
    """Yield tasks as processes take them, and report that each has begun."""
    for task in tasks:
        on_step(Step(task, "solid engine at work"))
        yield task


def model_key(request: SolidRequest, store: Store) -> str:
    """The key of the model of a request in the store."""
    return store.key("solid", request)


def _solved(task: Task, store: Store) -> Solved:
    """Solve the model of a task and keep its displacements."""
    raw = raw_ics(task.request, task.most_unknowns)
    u = xr.Variable(("load", "i", "point"), raw.u, {"units": "mm/N"})
    store.put(
        model_key(task.request, store), xr.Dataset({"u": u}, attrs={"cost": json.dumps(asdict(raw.cost))})
    )
    return Solved(task, raw, cached=False)
