"""C at points: the ICs of one loaded patch, as accurate as asked."""

from collections.abc import Mapping
from dataclasses import dataclass

from femic.harmonic.engine import HarmonicRequest
from femic.harmonic.synthesis import Responses, displacements
from femic.models import RawICs
from femic.problem import Assessed
from femic.reference import Job, Level, Reference, combine, request, scales, shares, total
from femic.refinement import SILENT, Watch, converged
from femic.solid.engine import Request
from femic.store import Store


def references(
    jobs: Mapping[str, Job],
    *,
    combined: bool = False,
    workers: int = 1,
    store: Store | None = None,
    watch: Watch = SILENT,
) -> dict[str, Reference]:
    """Solve all jobs, refining each until its estimate meets its tolerance; `combined`: their sum's too.

    Solved models are kept in the store, where the next run of the same code finds them.
    Raises WrongInput for points outside a model, NotConverged where the tolerance would need a
    larger model than the job allows.
    """
    return converged(AtPoints(jobs, combined), workers=workers, store=store or Store(), watch=watch)


@dataclass(frozen=True)
class AtPoints:
    """What `femic.refinement` drives."""

    jobs: Mapping[str, Job]
    combined: bool

    def request(self, name: str, level: Level) -> Request | HarmonicRequest:
        """The model of a job at a level."""
        return request(self.jobs[name], level)

    def read(self, asked: Request | HarmonicRequest, model: RawICs | Responses) -> RawICs:
        """Displacements at the points."""
        return model if isinstance(model, RawICs) else displacements(model, asked.loads, asked.points)

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
