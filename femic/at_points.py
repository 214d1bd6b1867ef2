"""C at points: the ICs of one loaded patch, as accurate as asked."""

from collections.abc import Mapping
from dataclasses import dataclass

from femic.estimate import total
from femic.job import Job
from femic.level import Level
from femic.means import DEFAULT, Means, Solved
from femic.models import RawICs
from femic.reference import Reference, combine, scales, shares
from femic.refinement import Assessed, converged


def references(
    jobs: Mapping[str, Job], means: Means = DEFAULT, *, combined: bool = False
) -> dict[str, Reference]:
    """Solve all jobs, refining each until its estimate meets its tolerance; `combined`: their sum's too.

    Solved models are kept in the store, where the next run of the same code finds them.
    Raises WrongInput for points outside a model, NotConverged where the tolerance would need a
    larger model than the job allows.
    """
    return converged(AtPoints(jobs, combined), means)


@dataclass(frozen=True)
class AtPoints:
    """What `femic.refinement` drives."""

    jobs: Mapping[str, Job]
    combined: bool

    def read(self, name: str, solved: Solved) -> RawICs:
        """Displacements at the points."""
        return self.jobs[name].settings.engine.displacements(solved.task.request, solved.model)

    def combine(self, name: str, level: Level, models: Mapping[Level, RawICs]) -> Reference:
        """C of a body."""
        return combine(self.jobs[name], level, models)

    def assess(self, found: Mapping[str, Reference]) -> Assessed:
        """Estimated errors."""
        return assess(self.jobs, found, combined=self.combined)


def assess(jobs: Mapping[str, Job], found: Mapping[str, Reference], *, combined: bool) -> Assessed:
    """Estimated errors of references, `combined`: of their sum, too."""
    own = {name: shares(job, found[name].c, scales([job], found[name].c.ic)) for name, job in jobs.items()}
    if not combined:
        return Assessed(own)
    c = total([reference.c for reference in found.values()])
    scale = scales(list(jobs.values()), c.ic)
    in_combined = {name: shares(job, found[name].c, scale) for name, job in jobs.items()}
    return Assessed(own, shares(next(iter(jobs.values())), c, scale), in_combined)
