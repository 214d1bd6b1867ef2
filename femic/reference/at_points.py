"""C at points: the ICs of one loaded patch, refined until they meet the tolerance."""

from collections.abc import Mapping, Sequence
from functools import partial

from femic.reference.assessment import Assessment, Batch, Measure, assessed
from femic.reference.job import Job
from femic.reference.models import RawICs
from femic.reference.refinement import converged
from femic.reference.result import Reference, combine, scales, shares
from femic.reference.run_options import DEFAULT, RunOptions, Solved
from geometries.arrays import Array


def references(
    jobs: Mapping[str, Job], options: RunOptions = DEFAULT, *, combined: bool = False
) -> dict[str, Reference]:
    """Solve all jobs and refine each until its estimate meets its tolerance.

    With `combined` the estimate of the sum of the bodies must also meet it. Solved models are stored for the
    next run of the same code. Raises WrongInput for points outside a model, NotConverged where the tolerance
    would need a larger model than the job allows.
    """
    assess_all = partial(assess_references, jobs, combined=combined)
    return converged(jobs, options, read=_displacements, combine=combine, assess=assess_all)


def _displacements(job: Job, solved: Solved) -> RawICs:
    """Return the displacements of a solved model at the points."""
    return job.settings.engine.models.displacements(solved.task.request, solved.model)


def assess_references(
    jobs: Mapping[str, Job], references: Mapping[str, Reference], *, combined: bool
) -> Assessment:
    """Return the estimated errors of the references and, with `combined`, of their sum."""

    def measure(bodies: Sequence[str], ic: Array) -> Measure:
        scale = scales([jobs[body] for body in bodies], ic)
        return lambda body, c: shares(jobs[body], c, scale)

    ics = {body: reference.c for body, reference in references.items()}
    return assessed(Batch(ics, measure), combined=combined)
