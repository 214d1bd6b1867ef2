"""C of one body at points with an estimate of its error, from solved models."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from femic.reference.accuracy import Shares, component_of, line_scale
from femic.reference.discount import fit_discount, rigid_part
from femic.reference.estimate import EstimatedICs, estimated, orders_at
from femic.reference.job import Job
from femic.reference.level import Level, factors
from femic.reference.meshing.cell_size import Cells
from femic.reference.models import Cost, RawICs
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.patches import N


@dataclass(frozen=True)
class Reference:
    """C of one body with its estimate, and the models that it comes from."""

    c: EstimatedICs
    raw: Array  # C before the discount [mm/N], with clamped far boundaries, (3, 3, n)
    discount: Array  # M [mm/N, 1/N, 1/(N mm)], (4, 4)
    level: Level
    cells: Cells  # of the fine model
    body: Body  # with the domain of the fine model
    models: Mapping[str, Cost]  # "fine", "coarse", "small", and the models of earlier rounds
    drawn: tuple[Array, Indices] | None = None  # mesh of the section, where the engine has one


def combine(job: Job, level: Level, models: Mapping[Level, RawICs]) -> Reference:
    """Discount each model's displacements and estimate the error of the finest from their differences."""
    engine = job.settings.engine
    level_of_model = level.models(engine.estimate.models_of(job.body))
    ic, raw, compliance = discounted(job, models[level].u)
    perturbed = {name: discounted(job, u)[0] for name, u in models[level].perturbed.items()}
    others = {name: discounted(job, models[at].u)[0] for name, at in level_of_model.items() if name != "fine"}
    if "coarse" in others:
        perturbed["coarser"] = others["coarse"]
    if "small" in others:  # "nearer" differs from C as "small" does from "coarse"
        perturbed["nearer"] = ic - others["coarse"] + others["small"]
    if not job.body.truncated:
        perturbed.pop("nearer", None)
    cells, domain = factors(level)
    body = job.body.enlarged(domain)
    orders = orders_at(job.patch, job.points, body.domain.far_radius)
    return Reference(
        estimated(ic, perturbed, safety=engine.estimate.safety, orders=orders),
        raw,
        compliance,
        level,
        job.first_cells.scaled(cells),
        body,
        MappingProxyType(costs_of(level_of_model, models)),
        models[level].drawn,
    )


def costs_of(level_of_model: Mapping[str, Level], models: Mapping[Level, Any]) -> dict[str, Cost]:
    """Return the costs of the models at a level by name, then the costs of models of earlier rounds."""
    costs = {name: models[level].cost for name, level in level_of_model.items()}
    earlier = [model.cost for level, model in models.items() if level not in level_of_model.values()]
    return costs | {f"earlier {k + 1}": cost for k, cost in enumerate(earlier)}


def discounted(job: Job, u: Array) -> tuple[Array, Array, Array]:
    """Return ICs [mm/N] (3, 3, n) after and before the subtraction of the rigid part, and M (4, 4).

    `u` (load, 3, n) are the displacements [mm/N] of a model.
    """
    n = len(job.points.x)
    at_fit_points = {load: load_u[:, n:] for load, load_u in zip(job.solved_loads, u, strict=True)}
    compliance = fit_discount(job.body, job.rule, job.fit, at_fit_points)
    raw, rigid = np.full((2, 3, 3, n), np.nan)
    for load, load_u in zip(job.loads, u, strict=False):  # the job's own loads come first
        raw[:, load.direction] = load_u[:, :n]
        rigid[:, load.direction] = rigid_part(compliance, job.body, job.points, load)
    return raw - rigid, raw, compliance


def scales(jobs: Sequence[Job], ic: Array) -> dict[str, Array]:
    """Return the scale of refinement [mm/N] per line, (3, 3), of the summed ICs (3, 3, n) of jobs.

    Where C_nn is not solved, the sum of the bodies' A_nn replaces it.
    """
    nn = ic[N, N]
    if np.any(np.isnan(nn)):
        nn = np.sum([job.half_space_nn for job in jobs], axis=0)
    return {
        line: line_scale(ic[..., line_points], nn[line_points]) for line, line_points in jobs[0].lines.items()
    }


def estimated_errors(job: Job, error: Array, scale: Mapping[str, Array]) -> dict[str, Array]:
    """Return the largest of the errors (3, 3, n) on each line, (3, 3), as shares of its scale."""
    return {
        line: np.max(np.abs(error[..., line_points]), axis=-1) / scale[line]
        for line, line_points in job.lines.items()
    }


def worst(job: Job, error: Array, scale: Mapping[str, Array]) -> tuple[float, str, str]:
    """Return the largest error over lines and components on their scale: (share, component, line)."""
    errors = estimated_errors(job, np.nan_to_num(error, nan=np.inf), scale)
    return max(
        (component_of(errors[line], component), component, line)
        for component in job.components
        for line in errors
    )


def shares(job: Job, c: EstimatedICs, scale: Mapping[str, Array]) -> Shares:
    """Return the largest estimate of a job's ICs, and of each part, on the scale of refinement."""
    mesh, truncation, waves = (worst(job, part, scale)[0] for part in c.errors)
    return Shares(mesh, truncation, waves, *worst(job, c.estimate, scale))
