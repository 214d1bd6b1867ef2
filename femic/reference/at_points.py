"""C at points: the ICs of one loaded patch, refined until they meet the tolerance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from femic.reference.assessment import Assessment, Batch, Measure, assess
from femic.reference.job import Job
from femic.reference.level import Level
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
    return converged(AtPoints(jobs, combined), options)


@dataclass(frozen=True)
class AtPoints:
    """The ICs of bodies at points, as a problem of `femic.reference.refinement`."""

    jobs: Mapping[str, Job]
    combined: bool

    def read(self, name: str, solved: Solved) -> RawICs:
        """Return the displacements of a solved model at the points."""
        return self.jobs[name].settings.engine.models.displacements(solved.task.request, solved.model)

    def combine(self, name: str, level: Level, models: Mapping[Level, RawICs]) -> Reference:
        """Return C of a body at a level from the displacements of its models."""
        return combine(self.jobs[name], level, models)

    def assess(self, references: Mapping[str, Reference]) -> Assessment:
        """Return the estimated errors of the references and, with `combined`, of their sum."""

        def measure(bodies: Sequence[str], ic: Array) -> Measure:
            scale = scales([self.jobs[body] for body in bodies], ic)
            return lambda body, c: shares(self.jobs[body], c, scale)

        ics = {body: reference.c for body, reference in references.items()}
        return assess([Batch(ics, measure)], combined=self.combined)
