"""C of one body at points, and the estimate of its error, from models less accurate in one way each.

The solid engine solves every body on three models: fine, coarse (cells `COARSER` times as large) and small
(the coarse cells in a domain half as large). The harmonic engine varies a single model: coarser cells, a
nearer far arc, and fewer wavenumbers. The differences give the parts of the estimate, as in Roache's grid
convergence index. The estimate assumes order 2 in the cell size, because the errors of meshes are partly
random and two meshes may agree by chance; order 1 on the outline of the patch, where the traction is
discontinuous; and order 1 in the domain size close to the far arc.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

import numpy as np

from femic.reference.discount import fit_discount, rigid_part
from femic.reference.engine import Cost, Points, RawICs
from femic.reference.job import Job, Shares, component_of, line_scale
from femic.reference.meshing import Cells
from femic.reference.run_options import COARSER, LARGER, TRUNCATION_ORDER, Level, factors
from geometries.arrays import Array, Indices
from geometries.bodies import Body
from geometries.patches import N, Patch

# --- the estimate ---

ESTIMATE_ORDER = 2  # in cell size, assumed by the estimate
LOW_ORDER = 1  # assumed on the outline of the patch, and in 1 / domain size close to the far arc
ON_OUTLINE = 0.2  # distance from the outline, in least half-sides, up to which a point is on it
CLOSE_TO_ARC = 1 / 3  # distance from the load, in far radii, from which on a point is close to the arc
SAFETY = 1.25  # Roache's factor
WAVES_GAIN = {"sparser": 32.0, "lower": 3.0}  # error with these wavenumbers over that with all


@dataclass(frozen=True)
class EstimatedICs:
    """ICs per unit total load [mm/N], shape (3, 3, n), after the discount; NaN where nothing was solved."""

    ic: Array
    mesh_error: Array  # estimate of this part of the error of `ic` [mm/N], not negative; so the next two
    truncation_error: Array
    waves_error: Array  # from the wavenumbers; 0 for the solid engine

    @property
    def errors(self) -> tuple[Array, Array, Array]:
        """The parts of the estimated error of `ic` [mm/N], (3, 3, n) each: mesh, truncation, wavenumbers."""
        return self.mesh_error, self.truncation_error, self.waves_error

    @property
    def estimate(self) -> Array:
        """The estimated error of `ic` [mm/N], shape (3, 3, n)."""
        return self.mesh_error + self.truncation_error + self.waves_error


def total(parts: Sequence[EstimatedICs]) -> EstimatedICs:
    """Return the sum of the ICs of bodies, with the sum of their estimates."""
    return EstimatedICs(
        *(np.sum([getattr(part, field.name) for part in parts], axis=0) for field in fields(parts[0]))
    )


Orders = tuple[Array | float, Array | float]  # of convergence, in cell size and in 1 / domain size
ORDERS: Orders = (ESTIMATE_ORDER, TRUNCATION_ORDER)


def orders_at(patch: Patch, points: Points, far_radius: float) -> tuple[Array, Array]:
    """Return the orders at points, (n,) each: lower where gradients are infinite, or close to the far arc."""
    x, s = np.abs(points.x), np.abs(points.s - patch.s)
    margin = ON_OUTLINE * min(patch.a, patch.b)
    around = (x < patch.a + margin) & (s < patch.b + margin)
    on_outline = around & ((x > patch.a - margin) | (s > patch.b - margin))
    close_to_arc = np.hypot(x, s) > CLOSE_TO_ARC * far_radius
    return (
        np.where(on_outline, LOW_ORDER, ESTIMATE_ORDER),
        np.where(close_to_arc, LOW_ORDER, TRUNCATION_ORDER),
    )


def estimated(
    ic: Array,
    perturbed: Mapping[str, Array],
    *,
    safety: float,
    orders: Orders = ORDERS,
) -> EstimatedICs:
    """Return ICs (3, 3, ...) [mm/N] with their estimated errors, from less accurate ICs of the same shape.

    `perturbed` has ICs with "coarser" cells, with "nearer" boundaries unless these are part of the body, and
    with the "sparser" and "lower" wavenumbers of the harmonic engine. `safety` is the factor on the part from
    the mesh.
    """
    changes = {name: less_accurate - ic for name, less_accurate in perturbed.items()}
    return EstimatedICs(ic, *errors(changes, safety=safety, orders=orders))


def errors(
    changes: Mapping[str, Array], *, safety: float, orders: Orders = ORDERS
) -> tuple[Array, Array, Array]:
    """Return the errors [mm/N] due to mesh, truncation, wavenumbers from the `changes` of less accurate ICs.

    Their names and `safety` are those of `estimated`.
    """
    none = np.zeros_like(changes["coarser"])
    mesh = safety * np.abs(changes["coarser"]) / (COARSER ** orders[0] - 1)
    truncation = SAFETY * np.abs(changes.get("nearer", none)) / (LARGER ** orders[1] - 1)
    waves = [np.abs(changes[name]) / (gain - 1) for name, gain in WAVES_GAIN.items() if name in changes]
    return pooled(mesh), truncation, SAFETY * sum(waves, start=none)


def pooled(error: Array) -> Array:
    """Return the larger of the errors of ij and ji, in the shape (3, 3, ...) of `error`; NaN stays NaN.

    Both errors are of the same kind, and one of them may be small by chance.
    """
    larger = np.fmax(error, np.swapaxes(error, 0, 1))
    return np.where(np.isnan(error), np.nan, larger)


# --- C of a body ---


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
    level_of_model = level.models(engine.models_for(job.body))
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
        estimated(ic, perturbed, safety=engine.safety, orders=orders),
        raw,
        compliance,
        level,
        job.first_cells.scaled(cells),
        body,
        MappingProxyType(model_costs(level_of_model, models)),
        models[level].drawn,
    )


def model_costs(level_of_model: Mapping[str, Level], models: Mapping[Level, Any]) -> dict[str, Cost]:
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


# --- errors on the scale of refinement ---


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


def worst(job: Job, error: Array, scale: Mapping[str, Array]) -> tuple[float, str, str]:
    """Return the largest error over lines and components on their scale: (share, component, line)."""
    errors = np.abs(np.nan_to_num(error, nan=np.inf))
    return max(
        (component_of(np.max(errors[..., points], axis=-1) / scale[line], component), component, line)
        for component in job.components
        for line, points in job.lines.items()
    )


def shares(job: Job, c: EstimatedICs, scale: Mapping[str, Array]) -> Shares:
    """Return the largest estimate of a job's ICs, and of each part, on the scale of refinement."""
    mesh, truncation, waves = (worst(job, part, scale)[0] for part in c.errors)
    return Shares(mesh, truncation, waves, *worst(job, c.estimate, scale))
