"""C of one body at points with its error estimate, of solved models."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from femic.accuracy import Shares, component_of, line_scale
from femic.discount import fit_discount, rigid_part
from femic.estimate import Estimated, estimated, orders_at
from femic.job import Job
from femic.level import Level, factors
from femic.meshing.cell_size import Cells
from femic.models import Cost, RawICs
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.patches import N


@dataclass(frozen=True)
class Reference:
    """C of one body with its estimate, and how it was got."""

    c: Estimated
    raw: Array  # C before the discount [mm/N], with clamped far boundaries, (3, 3, n)
    discount: Array  # M, (4, 4)
    level: Level
    cells: Cells  # of the fine model, as its domain
    body: Body
    models: Mapping[str, Cost]  # "fine", "coarse", "small", and those of earlier rounds
    drawn: tuple[Array, Indices] | None = None  # mesh of the section, of the harmonic engine


def combine(job: Job, level: Level, models: Mapping[Level, RawICs]) -> Reference:
    """Discount each model's displacements and estimate the error of the finest from their differences."""
    engine = job.settings.engine
    of_level = level.models(engine.models)
    after = {name: discounted(job, models[model].u) for name, model in of_level.items()}
    (ic, raw, m), coarse = after["fine"], after["coarse"][0]
    less = {name: discounted(job, u)[0] for name, u in models[level].perturbed.items()}
    if "small" in after:
        less["nearer"] = ic - coarse + after["small"][0]  # as far from C as "small" is from "coarse"
    cells, domain = factors(level)
    body = job.body.enlarged(domain)
    orders = orders_at(job.patch, job.points, body.domain.far_radius)
    return Reference(
        estimated(ic, coarse, less, safety=engine.safety, orders=orders),
        raw,
        m,
        level,
        job.first_cells.scaled(cells),
        body,
        MappingProxyType(costs_of(of_level, {other: model.cost for other, model in models.items()})),
        models[level].drawn,
    )


def costs_of(of_level: Mapping[str, Level], costs: Mapping[Level, Cost]) -> dict[str, Cost]:
    """What the models at a level took, then those of earlier rounds."""
    earlier = [other for other in costs if other not in of_level.values()]
    return {name: costs[model] for name, model in of_level.items()} | {
        f"earlier {k + 1}": costs[other] for k, other in enumerate(earlier)
    }


def discounted(job: Job, u: Array) -> tuple[Array, Array, Array]:
    """ICs (3, 3, n) after and before the subtraction of the rigid part, and M, of a model's displacements."""
    n = len(job.points.x)
    at_fit_points = {load: of_load[:, n:] for load, of_load in zip(job.solved_loads, u, strict=True)}
    m = fit_discount(job.body, job.rule, job.fit, at_fit_points)
    raw, rigid = np.full((2, 3, 3, n), np.nan)
    for load, of_load in zip(job.loads, u, strict=False):  # the job's own loads come first
        raw[:, load.direction] = of_load[:, :n]
        rigid[:, load.direction] = rigid_part(m, job.body, job.points, load)
    return raw - rigid, raw, m


def scales(jobs: Sequence[Job], ic: Array) -> dict[str, Array]:
    """Scale of refinement per line, shape (3, 3), of the ICs (3, 3, n) that some bodies have together.

    Where nn was not solved, the sum of the bodies' A_nn takes its place.
    """
    nn = ic[N, N]
    if np.any(np.isnan(nn)):
        nn = np.sum([job.half_space_nn for job in jobs], axis=0)
    return {line: line_scale(ic[..., p], nn[p]) for line, p in jobs[0].lines.items()}


def estimated_errors(job: Job, error: Array, scale: Mapping[str, Array]) -> dict[str, Array]:
    """Errors (3, 3, n) per line as shares of its scale of refinement, shape (3, 3)."""
    return {line: np.max(np.abs(error[..., p]), axis=-1) / scale[line] for line, p in job.lines.items()}


def worst(job: Job, error: Array, scale: Mapping[str, Array]) -> tuple[float, str, str]:
    """Largest error over lines and components on the scale of refinement: (share, component, line)."""
    errors = estimated_errors(job, np.nan_to_num(error, nan=np.inf), scale)
    return max((component_of(errors[line], c), c, line) for c in job.components for line in errors)


def shares(job: Job, c: Estimated, scale: Mapping[str, Array]) -> Shares:
    """The estimate of a job's ICs, and its parts, at worst, on the scale of refinement."""
    mesh, truncation, waves = (
        worst(job, part, scale)[0] for part in (c.mesh_error, c.truncation_error, c.waves_error)
    )
    return Shares(mesh, truncation, waves, *worst(job, c.estimate, scale))
