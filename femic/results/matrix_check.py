"""Check some columns of the IC matrix with the solid engine, which has no strips, lags or wavenumbers."""

from dataclasses import dataclass, replace

import numpy as np

from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.engine import Points
from femic.reference.job import Job, component_of
from femic.reference.refinement import references
from femic.reference.result import Reference
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.ics import seconds_of
from femic.results.matrices import SOURCE, MatrixResults
from femic.scenes.engine import CHECK_ENGINE, CHECK_TOLERANCE
from femic.scenes.scene import Scene
from geometries.bodies import Domain
from geometries.patches import COMPONENTS, N

OBSERVED = 3  # observed strips besides the loaded one


@dataclass(frozen=True)
class ColumnCheck:
    """The difference between both engines for one body and loaded strip, and the sum of their estimates."""

    body: str
    strip: int
    difference: float  # the largest: share of the component itself, among components that do not vanish
    component: str  # the one that has this difference
    allowed: float  # sum of both estimates of that component on the same line, as the same share
    closest: float  # largest ratio of a difference to the sum of both estimates
    seconds: float


def checked_strips(scene: Scene) -> list[int]:
    """Return the strips to check, evenly spread over the grid; two or more include its ends."""
    n = scene.checked_strips
    places = np.linspace(0, scene.grid.n_s - 1, n) if n > 1 else np.full(n, (scene.grid.n_s - 1) / 2)
    return sorted({round(place) for place in places})


def check_columns(results: MatrixResults, options: RunOptions = DEFAULT) -> list[ColumnCheck]:
    """Solve columns with the solid engine and compare them with the matrix, strip by strip."""
    checks = []
    for strip in checked_strips(results.scene):
        options.watch.on_stage(f"  check with the {CHECK_ENGINE.name} engine: strip {strip}")
        jobs = {body: _job(results, body, strip) for body in results.matrices}
        solved = references(jobs, options)
        checks += [_column_check(results, body, strip, job, solved[body]) for body, job in jobs.items()]
    return checks


def _observed_strips(results: MatrixResults, strip: int) -> list[int]:
    n_s = results.scene.grid.n_s
    return sorted({strip, *(round(place) for place in np.linspace(0, n_s - 1, OBSERVED))})


def _job(results: MatrixResults, body: str, strip: int) -> Job:
    """Return the job of a single load on a strip, observed on some strips at all lags but 0."""
    scene, grid = results.scene, results.scene.grid
    observed_strips = _observed_strips(results, strip)
    lags = grid.lags[1:]
    x, s = (values.ravel() for values in np.meshgrid(lags, grid.strips[observed_strips], indexing="ij"))
    domain_size = CHECK_ENGINE.far_radius(CHECK_TOLERANCE)
    return Job(
        body=replace(scene.bodies[body], domain=Domain(domain_size, domain_size)),
        patch=grid.patch(strip),
        components=COMPONENTS,
        points=Points(x, s),
        lines={f"strip {m}": slice(k, None, len(observed_strips)) for k, m in enumerate(observed_strips)},
        settings=replace(
            scene.settings,
            engine=CHECK_ENGINE,
            tolerance=np.inf,  # no refinement of these cells; the estimate says how accurate they are
            cells=CHECK_ENGINE.first_cells(CHECK_TOLERANCE, grid.patch(strip)),
        ),
    )


def _column_check(results: MatrixResults, body: str, strip: int, job: Job, solved: Reference) -> ColumnCheck:
    observed_strips = _observed_strips(results, strip)
    column = results.matrices[body].column(strip, SOURCE)
    ic, estimate = (
        part[:, :, 1:, observed_strips].reshape(3, 3, -1) for part in (column.ic, column.estimate)
    )
    measure = Measure(ic, estimate, ic[N, N], job.lines, far_from(job.patch, job.points.x, job.points.s))
    difference, allowed = measure.shares(solved.c.ic - ic), measure.shares(solved.c.estimate + estimate)
    compared = [
        (component_of(difference[line], component), component, component_of(allowed[line], component))
        for line in job.lines
        for component in COMPONENTS
    ]
    worst = max(comparison for comparison in compared if not component_of(measure.vanishing, comparison[1]))
    closest = max(share / bound for share, _, bound in compared if bound > 0)
    return ColumnCheck(body, strip, *worst, closest, seconds_of(solved.models))
