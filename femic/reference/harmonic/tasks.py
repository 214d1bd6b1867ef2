"""Solve the models of the harmonic engine one after the other, each in parallel, and store them."""

from collections.abc import Iterator, Sequence

from femic.reference.accuracy import NotConverged
from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.entry import StoredWaves
from femic.reference.harmonic.expected import expected_samples
from femic.reference.harmonic.modulus import with_unit_modulus
from femic.reference.harmonic.nesting import model_key, requested_part, store_model, stored_model
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.run_options import RunOptions, Solved, Step, Task


def solve_tasks(tasks: Sequence[Task], options: RunOptions) -> Iterator[Solved]:
    """Solve models, and yield each when it is finished.

    A model that an interrupted run has begun continues after its last finished wavenumber.
    """
    for task in tasks:
        yield _solved(task, options)


def _solved(task: Task, options: RunOptions) -> Solved:
    """Return the model of a task from the store, or solve it and put it there."""
    stored = stored_model(task.request, options.store)
    if stored is not None:
        return Solved(task, stored, cached=True)
    request = with_unit_modulus(task.request)
    options.watch.on_step(Step(task, "mesh and assembly"))
    expected = _expected(request)
    responses = solve(
        request,
        task.most_unknowns,
        workers=options.workers,
        progress=lambda solved: options.watch.on_step(Step(task, "wavenumbers", solved, expected)),
        cache=StoredWaves(options.store, model_key(request, options.store)),
    )
    store_model(responses, request, options.store)
    return Solved(task, requested_part(responses, task.request), cached=False)


def _expected(request: HarmonicRequest) -> int | None:
    """Return the expected number of solutions, None if a half-space needs too many wavenumbers."""
    try:
        samples = expected_samples(request)
        return len(samples.k) + len(samples.sparser.k)
    except NotConverged:  # for the half-space; the body may still converge
        return None
