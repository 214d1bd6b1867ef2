"""C with its error estimate.

By the solid engine every body is solved on three models: fine, coarse (cells `COARSER` times as large) and
small (the coarse cells in a domain half as large); by the harmonic engine on two, fine and coarse, each
also with a nearer far arc and with fewer wavenumbers. The differences give the parts of the
estimate, as in Roache's grid convergence index. Errors fall like h^3 (harmonic: h^4) and L^-2 (measured:
docs/solid-engine.md, docs/harmonic-engine.md); the estimate assumes order 2 of the mesh, because its errors
are partly random: two meshes may agree by luck; order 1 on the outline of the patch, where the traction
jumps; and order 1 of the truncation close to the far arc.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from approx.halfspace import HalfSpace
from femic.accuracy import FLOOR, Shares, component_of, line_scale
from femic.cell_size import Cells
from femic.discount import DiscountRule, conditions, fit_discount, observers, rigid_part
from femic.harmonic.engine import HIGHEST, HarmonicRequest
from femic.harmonic.synthesis import LOWER
from femic.models import Cost, Points, RawICs
from femic.solid.engine import Request, directions_of
from femic.solid.linear import SolverChoice
from femic.symmetry import N
from geometries.bodies import Body
from geometries.materials import one_body
from geometries.patches import Load, Patch

Array = NDArray[np.float64]

Engine = Literal["solid", "harmonic"]
COARSER = 1.5
LARGER = 2.0
MESH_ORDER, TRUNCATION_ORDER = 3, 2  # of the errors, in cell size and in 1 / domain size
ESTIMATE_ORDER = 2  # in cell size, assumed by the estimate
LOW_ORDER = 1  # likewise on the outline of the patch; and in 1 / domain size, close to the far arc
ON_OUTLINE = 0.2  # least half-sides: what is on the outline
CLOSE_TO_ARC = 1 / 3  # far radii from the load on
SAFETY = 1.25  # Roache's factor
MESH_SAFETY = {"solid": SAFETY, "harmonic": 2.0}  # so that 99 of 100 errors are bounded where C is known
MODELS = {  # the most expensive first
    "solid": ("fine", "coarse", "small"),
    "harmonic": ("fine", "coarse"),
}
WAVES_GAIN = {"sparser": 32.0, "lower": 3.0}  # error with the perturbed wavenumbers over that with all
WAVES_ORDER = 3  # of the error due to the largest wavenumber
WAVES_SHARE = 0.5  # of the tolerance that the interpolation between wavenumbers may take
LOOSEST_WAVES = 0.01  # tolerance: with fewer wavenumbers their gain is not yet that of the spline

# Cells that meet the tolerance on the built-in scenes, and the largest that may be begun with
TUNED_TOLERANCE = {"solid": 0.01, "harmonic": 0.001}
COARSEST = {"solid": 3.0, "harmonic": 1.5}  # times the tuned ones, however large the tolerance
CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH = 12, 0.14, 0.05
SECTION_CELLS_PER_HALF_SIDE, SECTION_GROWTH = 12, 0.34  # of the harmonic engine
FAR_RADIUS = {"solid": 320.0, "harmonic": 1280.0}  # [mm] that meet the tuned tolerance


def cells_for(tolerance: float, patch: Patch, engine: Engine = "solid") -> Cells:
    """Cells that are likely to meet a tolerance: errors fall like the cube of the cell size."""
    factor = min((tolerance / TUNED_TOLERANCE[engine]) ** (1 / MESH_ORDER), COARSEST[engine])
    if engine == "harmonic":
        smallest = patch.b / SECTION_CELLS_PER_HALF_SIDE
        return Cells(smallest, SECTION_GROWTH, SECTION_GROWTH).scaled(factor)
    return Cells(min(patch.a, patch.b) / CELLS_PER_HALF_SIDE, GROWTH, LINE_GROWTH).scaled(factor)


def far_radius_for(tolerance: float, engine: Engine) -> float:
    """Radius [mm] of the far arc that is likely to meet a tolerance: errors fall like its square."""
    if engine == "solid":
        return FAR_RADIUS[engine]
    return FAR_RADIUS[engine] * tighter(tolerance) ** (1 / TRUNCATION_ORDER)


def tighter(tolerance: float) -> float:
    """How much tighter a tolerance is than the one for which the harmonic engine is tuned, at least 1."""
    return max(1.0, TUNED_TOLERANCE["harmonic"] / tolerance)


@dataclass(frozen=True)
class Job:
    """The reference ICs of one body: what is asked, how accurately, and with which cells to start.

    `lines` says which points lie on which line: tolerance and estimates refer to the scale of refinement of
    a line. Lengths in mm;
    `rotation_reach` and `moment_arm` say where M is fitted (`femic.discount`); `cells` are those to
    start with, by default what the tolerance needs. No model may have more than `most_unknowns`.
    `solver` is that of the solid engine.
    """

    body: Body
    patch: Patch
    components: tuple[str, ...]
    points: Points
    lines: Mapping[str, slice]
    tolerance: float = 0.01
    cells: Cells | None = None
    rotation_reach: float = 20.0
    moment_arm: float = 5.0
    most_unknowns: int = 1_000_000
    solver: SolverChoice = "auto"
    engine: Engine = "solid"

    @property
    def first_cells(self) -> Cells:
        """The cells to start with."""
        return self.cells or cells_for(self.tolerance, self.patch, self.engine)

    @property
    def loads(self) -> tuple[Load, ...]:
        """The loads whose displacements are asked for, by the harmonic engine those of C_ji, too.

        Its loads share a factorisation, and the error of C_ij is estimated by that of C_ji, too (`pooled`):
        then the estimate does not depend on what else is asked for.
        """
        asked = set(self.components)
        if self.engine == "harmonic":
            asked |= {component[::-1] for component in asked}
        return tuple(Load(self.patch, direction) for direction in directions_of(asked))

    @property
    def rule(self) -> DiscountRule:
        """How M is fitted."""
        return DiscountRule(self.patch.a, self.patch.b, self.rotation_reach, self.moment_arm)


@dataclass(frozen=True)
class Level:
    """Steps of refinement of a model from what the job starts with."""

    cells: int = 0
    domain: int = 0
    waves: int = 0  # of the harmonic engine: larger wavenumbers, and more of them

    def models(self, engine: Engine = "solid") -> dict[str, "Level"]:
        """The models that give C at this level, and its error."""
        coarse = replace(self, cells=self.cells - 1)
        small = replace(coarse, domain=self.domain - 1)
        found = {"fine": self, "coarse": coarse, "small": small}
        return {name: found[name] for name in MODELS[engine]}


@dataclass(frozen=True)
class Estimated:
    """ICs per unit total load [mm/N], shape (3, 3, n), after the discount; NaN where nothing was solved."""

    ic: Array
    mesh_error: Array  # estimates of the parts of its error, not negative
    truncation_error: Array
    waves_error: Array  # of the interpolation between wavenumbers; 0 of the solid engine

    @property
    def estimate(self) -> Array:
        """Estimate of the error of `ic`."""
        return self.mesh_error + self.truncation_error + self.waves_error


def total(parts: Sequence[Estimated]) -> Estimated:
    """The sum over some bodies; their estimates add up."""
    return Estimated(
        *(np.sum([getattr(part, field.name) for part in parts], axis=0) for field in fields(parts[0]))
    )


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
    drawn: tuple[Array, NDArray[np.int64]] | None = None  # mesh of the section, of the harmonic engine


Models = Mapping[Level, RawICs]


def request(job: Job, level: Level) -> Request | HarmonicRequest:
    """The model of a job at a level, for the job's engine."""
    if job.engine == "solid":
        return solid_request(job, level)
    return harmonic_request(job, level)


def harmonic_request(job: Job, level: Level) -> HarmonicRequest:
    """The model of a job at a level, its wavenumbers as dense as the least scale of refinement needs."""
    asked = solid_request(job, level)
    nn = _half_space_nn(job)
    least = FLOOR * min(float(np.max(nn[line])) for line in job.lines.values())
    accuracy, larger = waves_for(job.tolerance, least, level)
    return HarmonicRequest(asked.body, asked.loads, asked.points, asked.cells, accuracy, larger * HIGHEST)


def waves_for(tolerance: float, least_scale: float, level: Level) -> tuple[float, float]:
    """How accurate the interpolation between wavenumbers must be [mm/N], and how much larger the largest."""
    asked = min(tolerance, LOOSEST_WAVES)
    accuracy = WAVES_SHARE * asked * least_scale / WAVES_GAIN["sparser"] ** level.waves
    return accuracy, LOWER**level.waves * tighter(tolerance) ** (1 / WAVES_ORDER)


def solid_request(job: Job, level: Level) -> Request:
    """The model of a job at a level: all loads and points that C and its discount need."""
    fit = conditions(job.body, job.rule, job.loads)
    loads = tuple(dict.fromkeys([*job.loads, *(load for c in fit for load in c.loads)]))
    extra = observers(job.body, job.rule, fit)
    points = Points(np.concatenate([job.points.x, extra.x]), np.concatenate([job.points.s, extra.s]))
    body, cells = scaled(job, level)
    return Request(body, loads, points, cells, job.solver)


def scaled(job: Job, level: Level) -> tuple[Body, Cells]:
    """Body and cells of a job at a level."""
    cells, domain = factors(level)
    body = replace(job.body, domain=job.body.domain.scaled(domain))
    return body, job.first_cells.scaled(cells)


def factors(level: Level) -> tuple[float, float]:
    """Size of the cells and of the domain at a level, as multiples of the job's own."""
    return COARSER**-level.cells, LARGER**level.domain


def combine(job: Job, level: Level, models: Models) -> Reference:
    """Discount each model's displacements and estimate the error of the finest from their differences."""
    of_level = level.models(job.engine)
    found = {name: discounted(job, models[model].u) for name, model in of_level.items()}
    (ic, raw, m), coarse = found["fine"], found["coarse"][0]
    less = {name: discounted(job, u)[0] for name, u in models[level].perturbed.items()}
    if "small" in found:
        less["nearer"] = ic - coarse + found["small"][0]  # as far from C as "small" is from "coarse"
    body, cells = scaled(job, level)
    costs = MappingProxyType(costs_of(job.engine, level, {other: raw.cost for other, raw in models.items()}))
    c = estimated(job.engine, ic, coarse, less, orders_at(job, body.domain.far_radius))
    return Reference(c, raw, m, level, cells, body, costs, models[level].drawn)


def costs_of(engine: Engine, level: Level, costs: Mapping[Level, Cost]) -> dict[str, Cost]:
    """What the models at a level took, then those of earlier rounds."""
    of_level = level.models(engine)
    earlier = [other for other in costs if other not in of_level.values()]
    return {name: costs[model] for name, model in of_level.items()} | {
        f"earlier {k + 1}": costs[other] for k, other in enumerate(earlier)
    }


@dataclass(frozen=True)
class Orders:
    """Orders of convergence that an estimate assumes, everywhere or at each point, (n,)."""

    mesh: Array | float = ESTIMATE_ORDER
    truncation: Array | float = TRUNCATION_ORDER


def orders_at(job: Job, far_radius: float) -> Orders:
    """Lower ones where gradients are infinite, and where half the domain hardly contains a point."""
    patch, points = job.patch, job.points
    x, s = np.abs(points.x), np.abs(points.s - patch.s)
    reach = ON_OUTLINE * min(patch.a, patch.b)
    around = (x < patch.a + reach) & (s < patch.b + reach)
    on_outline = around & ((x > patch.a - reach) | (s > patch.b - reach))
    close = np.hypot(x, s) > CLOSE_TO_ARC * far_radius
    return Orders(
        np.where(on_outline, LOW_ORDER, ESTIMATE_ORDER), np.where(close, LOW_ORDER, TRUNCATION_ORDER)
    )


ALIKE_EVERYWHERE = Orders()


def estimated(
    engine: Engine, ic: Array, coarse: Array, less: Mapping[str, Array], orders: Orders = ALIKE_EVERYWHERE
) -> Estimated:
    """ICs with estimates of their error, from those with coarser cells and with less of other things.

    `less`: "nearer" boundaries, and of the harmonic engine "sparser" and "lower" wavenumbers.
    """
    waves = [np.abs(ic - less[name]) / (gain - 1) for name, gain in WAVES_GAIN.items() if name in less]
    return Estimated(
        ic,
        pooled(MESH_SAFETY[engine] * np.abs(ic - coarse) / (COARSER**orders.mesh - 1)),
        SAFETY * np.abs(ic - less["nearer"]) / (LARGER**orders.truncation - 1),
        SAFETY * np.sum([np.zeros_like(ic), *waves], axis=0),
    )


def pooled(error: Array) -> Array:
    """Errors (3, 3, ...) of ij not below those of ji: they are errors of the same kind, one lucky or not."""
    both = np.fmax(error, np.swapaxes(error, 0, 1))
    return np.where(np.isnan(error), np.nan, both)


def discounted(job: Job, u: Array) -> tuple[Array, Array, Array]:
    """ICs (3, 3, n) after and before the subtraction of the rigid part, and M, of a model's displacements."""
    fit = conditions(job.body, job.rule, job.loads)
    loads = solid_request(job, Level()).loads
    n = len(job.points.x)
    at_fit_points = {load: of_load[:, n:] for load, of_load in zip(loads, u, strict=True)}
    m = fit_discount(job.body, job.rule, fit, at_fit_points)
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
        nn = np.sum([_half_space_nn(job) for job in jobs], axis=0)
    return {line: line_scale(ic[..., p], nn[p]) for line, p in jobs[0].lines.items()}


def _half_space_nn(job: Job) -> Array:
    """A_nn of a body per unit total load [mm/N], shape (n,)."""
    half_space = HalfSpace(one_body(job.body.material, job.body.side))
    return half_space.ics(job.patch, job.points.x, job.points.s - job.patch.s)[N, N] / job.patch.area


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
