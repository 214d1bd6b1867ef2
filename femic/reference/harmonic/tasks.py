"""Models of the harmonic engine are solved one after the other, each by parallel threads, and kept."""

from collections.abc import Iterator, Sequence

from femic.reference.accuracy import NotConverged
from femic.reference.harmonic.engine import solve
from femic.reference.harmonic.entry import KeptWaves
from femic.reference.harmonic.expected import expected_samples
from femic.reference.harmonic.modulus import kept, with_modulus_of, with_unit_modulus
from femic.reference.harmonic.nesting import keep, model_key, wanted
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.run_options import Means, Solved, Step, Task


def solve_tasks(tasks: Sequence[Task], means: Means) -> Iterator[Solved]:
    """Solve models, and yield each when it is finished.

    A model that an interrupted run has begun goes on behind its last finished wavenumber.
    """
    for task in tasks:
        yield _solved(task, means)


def _solved(task: Task, means: Means) -> Solved:
    """The model of a task, from the store or solved and kept there."""
    found = kept(task.request, means.store)
    if found is not None:
        return Solved(task, found, kept=True)
    request = with_unit_modulus(task.request)
    means.watch.on_step(Step(task, "mesh and assembly"))
    expected = _expected(request)
    responses = solve(
        request,
        task.most_unknowns,
        workers=means.workers,
        progress=lambda found: means.watch.on_step(Step(task, "wavenumbers", found, expected)),
        kept=KeptWaves(means.store, model_key(request, means.store)),
    )
    keep(responses, request, means.store)
    return Solved(task, with_modulus_of(task.request.body, wanted(responses, request)), kept=False)


def _expected(request: HarmonicRequest) -> int | None:
    """Expected number of answers, None where the half-space would need too many wavenumbers."""
    try:
        samples = expected_samples(request)
        return len(samples.k) + len(samples.sparser.k)
    except NotConverged:  # for the half-space; whether the body converges is seen when it is solved
        return None
