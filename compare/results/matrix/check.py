"""Some columns of the IC matrix by the solid engine, which knows nothing of strips, lags or wavenumbers."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from compare.results.matrix.compute import MatrixResults
from compare.results.measure import Measure, far_from
from compare.scenes.load import CHECK, CHECK_TOLERANCE
from compare.scenes.scene import Scene
from femic.accuracy import component_of
from femic.at_points import references
from femic.job import Job
from femic.means import DEFAULT, Means
from femic.models import Points
from femic.reference import Reference
from geometries.bodies import Domain
from geometries.patches import COMPONENTS, N

OBSERVED = 3  # strips, of which one is the loaded one


@dataclass(frozen=True)
class Checked:
    """One body and loaded strip: how far both engines are apart, how far their estimates let them be."""

    body: str
    strip: int
    apart: float  # worst share of the component itself, of those that do not vanish
    component: str
    allowed: float  # sum of both estimates, at that line and component
    closest: float  # largest difference over the sum of the estimates
    seconds: float


def checked_strips(scene: Scene) -> list[int]:
    """The strips whose columns are checked: spread over the grid, its ends among them if there are two."""
    n = scene.checked_strips
    places = np.linspace(0, scene.grid.n_s - 1, n) if n > 1 else np.full(n, (scene.grid.n_s - 1) / 2)
    return sorted({round(place) for place in places})


def check(results: MatrixResults, means: Means = DEFAULT) -> list[Checked]:
    """Solve the columns and compare them with those of the matrix, strip by strip."""
    found = []
    for strip in checked_strips(results.scene):
        means.watch.on_stage(f"  check by the {CHECK.name} engine: strip {strip}")
        jobs = {name: _job(results, name, strip) for name in results.found}
        solved = references(jobs, means)
        found += list(_compared(results, jobs, solved, strip))
    return found


def _observers(results: MatrixResults, strip: int) -> list[int]:
    n_s = results.scene.grid.n_s
    return sorted({strip, *(round(place) for place in np.linspace(0, n_s - 1, OBSERVED))})


def _job(results: MatrixResults, name: str, strip: int) -> Job:
    """A single load, observed at the lags on some strips; not on the element itself."""
    scene, grid = results.scene, results.scene.grid
    observed = _observers(results, strip)
    lags = grid.lags[1:]
    x, s = (values.ravel() for values in np.meshgrid(lags, grid.strips[observed], indexing="ij"))
    length = CHECK.far_radius(CHECK_TOLERANCE)
    return Job(
        body=replace(scene.bodies[name], domain=Domain(length, length)),
        patch=grid.patch(strip),
        components=COMPONENTS,
        points=Points(x, s),
        lines={f"strip {m}": slice(k, None, len(observed)) for k, m in enumerate(observed)},
        settings=replace(
            scene.settings,
            engine=CHECK,
            tolerance=np.inf,  # as well as these cells can: its own estimate says how well
            cells=CHECK.tuned.cells_for(CHECK_TOLERANCE, grid.patch(strip)),
        ),
    )


def _compared(
    results: MatrixResults, jobs: Mapping[str, Job], solved: Mapping[str, Reference], strip: int
) -> Iterator[Checked]:
    observed = _observers(results, strip)
    for name, job in jobs.items():
        column, single = results.found[name].column(strip), solved[name].c
        ic, estimate = (part[:, :, 1:, observed].reshape(3, 3, -1) for part in (column.ic, column.estimate))
        far = far_from(job.patch, job.points.x, job.points.s)
        measure = Measure(ic, estimate, ic[N, N], job.lines, far)
        apart, allowed = measure.shares(single.ic - ic), measure.shares(single.estimate + estimate)
        each = [
            (component_of(apart[line], c), c, component_of(allowed[line], c))
            for line in job.lines
            for c in COMPONENTS
        ]
        worst = max(one for one in each if not component_of(measure.vanishing, one[1]))
        closest = max(share / limit for share, _, limit in each if limit > 0)
        seconds = sum(sum(cost.seconds.values()) for cost in solved[name].models.values())
        yield Checked(name, strip, *worst, closest, seconds)
