"""Check some columns of the IC matrix with the solid engine, which has no strips, lags or wavenumbers."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from femic.ic_errors.error_measure import Measure, far_from
from femic.reference.engine import Points
from femic.reference.job import Job, component_of
from femic.reference.matrix.reference import MatrixReference
from femic.reference.refinement import references
from femic.reference.run_options import DEFAULT, RunOptions
from femic.results.ics import solver_seconds
from femic.results.matrices import SOURCE
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
    n, last = scene.checked_strips, scene.grid.n_s - 1
    places = np.linspace(0, last, n) if n > 1 else np.full(n, last / 2)
    return sorted({round(place) for place in places})


def check_columns(
    scene: Scene, solved: Mapping[str, MatrixReference], options: RunOptions = DEFAULT
) -> list[ColumnCheck]:
    """Solve columns with the solid engine and compare them with C of the solved bodies, strip by strip.

    Loads on a strip are observed on some strips, at all lags but 0.
    """
    grid, checks = scene.grid, list[ColumnCheck]()
    size = CHECK_ENGINE.far_radius(CHECK_TOLERANCE)
    for strip in checked_strips(scene):
        options.watch.on_stage(f"  check with the {CHECK_ENGINE.name} engine: strip {strip}")
        observed = sorted({strip, *(round(place) for place in np.linspace(0, grid.n_s - 1, OBSERVED))})
        x, s = (values.ravel() for values in np.meshgrid(grid.lags[1:], grid.strips[observed], indexing="ij"))
        patch = grid.patch(strip)
        settings = replace(
            scene.settings,
            engine=CHECK_ENGINE,
            tolerance=np.inf,  # no refinement of these cells; the estimate says how accurate they are
            cells=CHECK_ENGINE.first_cells(CHECK_TOLERANCE, patch),
        )
        jobs = {
            body: Job(
                body=replace(scene.bodies[body], domain=Domain(size, size)),
                patch=patch,
                components=COMPONENTS,
                points=Points(x, s),
                lines={f"strip {m}": slice(k, None, len(observed)) for k, m in enumerate(observed)},
                settings=settings,
            )
            for body in solved
        }
        by_solid = references(jobs, options)
        for body, job in jobs.items():
            column, c = solved[body].column(strip, SOURCE), by_solid[body].c
            ic, estimate = (
                part[:, :, 1:, observed].reshape(3, 3, -1) for part in (column.ic, column.estimate)
            )
            measure = Measure(ic, estimate, ic[N, N], job.lines, far_from(patch, x, s))
            difference, allowed = measure.shares(c.ic - ic), measure.shares(c.estimate + estimate)
            compared = [
                (component_of(difference[line], name), name, component_of(allowed[line], name))
                for line in job.lines
                for name in COMPONENTS
            ]
            worst = max(one for one in compared if not component_of(measure.vanishing, one[1]))
            closest = max(share / bound for share, _, bound in compared if bound > 0)
            checks.append(ColumnCheck(body, strip, *worst, closest, solver_seconds(by_solid[body].models)))
    return checks
