"""The IC matrix of each body at all lags and strips, with the estimate of its error, and C of a pair.

One model serves all strips, with every strip as a load. Displacements at the lags are computed from the
solved model when a strip is requested, so that a large matrix never has more than one loaded strip in memory.
The discount has one matrix M per body (`femic.reference.discount`).

C of a pair of bodies is the sum of their columns, less the approach of the pair. The subtracted approach
moves the bodies like the approach of a contact: along z, without rotation, with components along the normals
of the lower body. So the tractions of a contact do not depend on it. The separate M_zz of each body would not
serve: C - A at the load contains the local effect of curvature, which makes M_zz of a convex and of a concave
body large and of opposite signs. They cancel only along the same normals.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import chain
from typing import Any, Protocol

import numpy as np

from femic.cache.workers import in_threads, one_blas_thread
from femic.reference.discount import FZ, discount, fit_discount, motions
from femic.reference.engine import Cost, Points
from femic.reference.job import FLOOR, Shares
from femic.reference.matrix.job import Discount, MatrixJob
from femic.reference.meshing import Cells
from femic.reference.refinement import (
    Assessment,
    Measure,
    assess_bodies,
    solve_to_tolerance,
    worst_assessment,
)
from femic.reference.result import EstimatedICs, errors, model_costs, total
from femic.reference.run_options import DEFAULT, Level, RunOptions, factors
from geometries.arrays import Array, Mask
from geometries.bodies import Body
from geometries.contours import Contour
from geometries.patches import COMPONENTS, Grid, places

# --- the scale of a column ---

NEAR_ELEMENTS, NEAR_SHARE = 4, 5.0  # closer to the load than 4 elements the scale is 5 A_nn


def column_scale(strip: int, c: Array, jobs: Sequence[MatrixJob]) -> Array:
    """Return the scale of refinement [mm/N] of the summed ICs `c` of jobs, in their shape (3, 3, n_x, n_s).

    At `NEAR_ELEMENTS` elements from the load and further it is, per pair of strips, the larger of max |C_ij|
    and 0.05 max A_nn over these lags. Nearer to the load it is 5 times A_nn at the same element.
    """
    a_nn, is_far_away = half_spaces_nn(strip, jobs), is_far(strip, jobs[0].grid)
    far_scale = np.maximum(
        np.max(np.abs(c) * is_far_away, axis=2), FLOOR * np.max(a_nn * is_far_away, axis=0)
    )
    return np.where(is_far_away, far_scale[:, :, None], NEAR_SHARE * a_nn)


def half_spaces_nn(strip: int, jobs: Sequence[MatrixJob]) -> Array:
    """Return the sum of the bodies' A_nn under a unit load on a strip [mm/N], shape (n_x, n_s)."""
    strips_apart = np.abs(np.arange(jobs[0].grid.n_s) - strip)
    return np.asarray(np.sum([job.half_space_column[:, strips_apart] for job in jobs], axis=0))


def is_far(strip: int, grid: Grid) -> Mask:
    """Whether elements are `NEAR_ELEMENTS` elements from a load on a strip or further, shape (n_x, n_s)."""
    elements_along_x, strips_apart = np.arange(grid.n_x)[:, None], np.arange(grid.n_s) - strip
    return np.asarray(np.hypot(elements_along_x, strips_apart) >= NEAR_ELEMENTS)


def column_shares(
    strip: int, c: EstimatedICs, scale: Array, components: Sequence[str] = COMPONENTS
) -> Shares:
    """Return the largest estimate of components in a column, and of each part, on the column's scale."""
    chosen = places(components)
    shares = [part[chosen] / scale[chosen] for part in (*c.errors, c.estimate)]
    mesh, truncation, waves, total_share = (np.where(np.isnan(part), np.inf, part) for part in shares)
    number, lag, observer = np.unravel_index(np.argmax(total_share), total_share.shape)
    line = f"of strip {observer} under strip {strip} (worst at lag {lag})"
    parts = float(np.max(mesh)), float(np.max(truncation)), float(np.max(waves))
    return Shares(*parts, float(np.max(total_share)), components[int(number)], line)


# --- the matrix of a body ---

ELEMENTS_FOR_THREADS = 16_000  # of a grid, from which on two threads compute columns faster than one
MOST_THREADS = 4  # that compute columns
REMEMBERED_ENTRIES = 20_000_000  # of the largest matrix that is held in memory as a whole
REMEMBERED_COLUMNS = 2 * MOST_THREADS  # of larger matrices


@dataclass(frozen=True)
class MatrixReference:
    """The IC matrix of one body per unit total load [mm/N], computed strip by strip from a solved model.

    Components that are not solved are NaN.
    """

    job: MatrixJob
    level: Level
    cells: Cells
    body: Body
    models: Mapping[str, Cost]
    solved: Any  # the model, as its engine has solved it

    @cached_property
    def _columns(self) -> Mapping[str, Callable[[int], Array]]:
        """What computes columns: of the model (""), and of its variations."""
        return self.job.settings.engine.columns(self.solved, self.job.grid, self.job.solved)

    @cached_property
    def _compliances(self) -> dict[Discount, dict[str, Array]]:
        """M (4, 4) by discount: of the model (""), and of its variations."""
        job, compliances = self.job, {}
        for name, fit in job.fits.items():
            compliances[name] = dict.fromkeys(self._columns, np.zeros((4, 4)))
            if not fit:
                continue
            raw = job.settings.engine.displacements(self.solved, job.fit_loads, job.fit_points(name))
            for variation, u in {"": raw.u, **raw.perturbed}.items():
                u_of_load = dict(zip(job.fit_loads, u, strict=True))
                compliances[name][variation] = fit_discount(job.body, job.rules[name], fit, u_of_load)
        return compliances

    @property
    def discount(self) -> Array:
        """M of the first discount [mm/N, 1/N, 1/(N mm)], shape (4, 4)."""
        return self._compliances[self.job.discounts[0]][""]

    @cached_property
    def _raw(self) -> Callable[[int], tuple[Array, dict[str, Array]]]:
        """Return C before the discount under loads on a strip, (3, 3, n_x, n_s) [mm/N], and its changes.

        These are by each variation of the model that the estimate needs, in single precision. All columns of
        a small matrix are remembered.
        """

        def synthesise(strip: int) -> tuple[Array, dict[str, Array]]:
            ic = self._columns[""](strip)
            return ic, {
                variation: (column(strip) - ic).astype(np.float32)
                for variation, column in self._columns.items()
                if variation and (variation != "nearer" or self.job.truncated("source"))
            }

        n_x, n_s = self.job.grid.n_x, self.job.grid.n_s
        is_small = 9 * n_x * n_s**2 <= REMEMBERED_ENTRIES
        return lru_cache(maxsize=n_s if is_small else REMEMBERED_COLUMNS)(synthesise)

    def raw_column(self, strip: int, variation: str = "") -> Array:
        """Return C before the discount [mm/N] due to unit total loads on one strip, (3, 3, n_x, n_s)."""
        return self._columns[variation](strip) if variation else self._raw(strip)[0]

    def column(self, strip: int, discount: Discount | None = None) -> EstimatedICs:
        """Return C [mm/N] due to unit total loads on one strip, arrays (3, 3, n_x, n_s).

        `discount` is one of the discounts of the job, by default the first.
        """
        name = discount or self.job.discounts[0]
        (raw, raw_changes), m, rigid = self._raw(strip), self._compliances[name], self._rigid(strip, name)
        ic = raw - rigid(m[""])
        changes = {
            variation: change - rigid(m[variation] - m[""]).astype(np.float32)
            for variation, change in raw_changes.items()
            if variation != "nearer" or self.job.truncated(name)  # elsewhere the far arc is a support
        }
        return EstimatedICs(ic, *errors(changes, safety=self.job.settings.engine.safety))

    def paired_column(self, strip: int, variation: str = "") -> Array:
        """Return C [mm/N] for a pair of bodies, before their approach is subtracted, (3, 3, n_x, n_s).

        Only the discount "source" is applied. `variation` is the variation of the model: "nearer" has a far
        arc of half the radius.
        """
        name, raw = self.job.discounts[0], self.raw_column(strip, variation)
        if name != "source":
            return raw
        return np.asarray(raw - self._rigid(strip, name)(self._compliances[name][variation]))

    def approach(self, variation: str = "") -> float:
        """Return M_zz [mm/N], which is subtracted from the approach of a pair; 0 for other discounts."""
        name = self.job.discounts[0]
        return float(self._compliances[name][variation][FZ, FZ]) if name == "approach" else 0.0

    def _rigid(self, strip: int, name: Discount) -> Callable[[Array], Array]:
        """Return D [mm/N] of all elements under loads on one strip as a function of the M of a discount.

        Its shape is (3, 3, n_x, n_s), or (3, 3, 1, n_s) on a prismatic body.
        """
        body, grid = self.job.body, self.job.grid
        lags = grid.lags if np.isfinite(body.rolling_radius) else grid.lags[:1]
        elements = Points(lags[:, None], grid.strips[None])
        entries = [condition.entry for condition in self.job.fits[name]]
        unit = motions(body, elements, float(grid.strips[strip]), entries)
        return lambda m: discount(m, unit, entries)


# --- solving and refining ---


class ColumnConsumer(Protocol):
    """Takes the columns of matrices as they are assessed, so that they are synthesised only once."""

    def begin(self, references: Mapping[str, MatrixReference]) -> None:
        """Begin with matrices."""

    def made(self, strip: int, columns: Mapping[str, EstimatedICs]) -> Any:
        """Return what is made of the columns of bodies under loads on a strip; several threads call this."""

    def add(self, made: Any) -> None:
        """Add what has been made of a strip, strip by strip."""

    def discard(self) -> None:
        """Drop all since the beginning: the matrices are not accurate enough, and better ones follow."""


def matrices(
    jobs: Mapping[str, MatrixJob],
    options: RunOptions = DEFAULT,
    *,
    combined: bool = False,
    consumer: ColumnConsumer | None = None,
) -> dict[str, MatrixReference]:
    """Solve all bodies and refine each until its estimate meets its tolerance.

    With `combined` the estimate of the sum of the bodies must also meet it. Errors are measured on the scale
    of `column_scale`. `consumer` gets all columns of the matrices that are returned. Raises as
    `femic.reference.refinement.references`.
    """
    assess = partial(assess_matrices, jobs, combined=combined, consumer=consumer, workers=options.workers)
    return solve_to_tolerance(
        jobs, options, read=lambda _, solved: solved.model, combine=_matrix_reference, assess=assess
    )


def _matrix_reference(job: MatrixJob, level: Level, models: Mapping[Level, Any]) -> MatrixReference:
    """Return the IC matrix of a body at a level from its models."""
    level_of_model = level.models(job.settings.engine.models_for(job.body))
    solved, costs = models[level], model_costs(level_of_model, models)
    cells = job.first_cells.scaled(factors(level)[0])
    return MatrixReference(job, level, cells, solved.body, costs, solved)


def assess_matrices(
    jobs: Mapping[str, MatrixJob],
    references: Mapping[str, MatrixReference],
    *,
    combined: bool,
    consumer: ColumnConsumer | None = None,
    workers: int = 1,
) -> Assessment:
    """Return the estimated errors of the bodies, at worst over all strips, and of their sum.

    `consumer` gets no further columns after one that is not accurate enough.
    """
    job = next(iter(jobs.values()))
    tolerances = {name: one.settings.tolerance for name, one in jobs.items()}
    assessments: list[Assessment] = []
    taking = [consumer] if consumer is not None else []  # empty after a column that is not accurate enough

    def assess_strip(strip: int) -> tuple[Assessment, list[Any]]:
        columns = {body: reference.column(strip) for body, reference in references.items()}
        made = [one.made(strip, columns) for one in taking]

        def measure(bodies: Sequence[str], ic: Array) -> Measure:
            scale = column_scale(strip, ic, [jobs[body] for body in bodies])
            return lambda body, c: column_shares(strip, c, scale, jobs[body].components)

        return assess_bodies(columns, measure, combined=combined), made

    with one_blas_thread():
        for one in taking:
            one.begin(references)
        first = assess_strip(0)  # what all columns need is computed here, before several threads ask for it
        large = job.grid.n_x * job.grid.n_s >= ELEMENTS_FOR_THREADS
        others = in_threads(assess_strip, range(1, job.grid.n_s), min(workers, MOST_THREADS) if large else 1)
        for assessment, made in chain([first], others):
            assessments.append(assessment)
            if not assessment.meets(tolerances):
                taking.clear()
            for one, part in zip(taking, made, strict=False):
                one.add(part)
    if consumer is not None and not taking:
        consumer.discard()
    return worst_assessment(assessments)


# --- a pair of bodies ---


def pair_column(
    references: Mapping[str, MatrixReference],
    contour: Contour,
    strip: int,
    columns: Mapping[str, EstimatedICs] | None = None,
) -> EstimatedICs:
    """Return the summed C of bodies due to unit total loads on a strip [mm/N], arrays (3, 3, n_x, n_s).

    `contour` belongs to the lower body, on which the strips of the pair lie. `columns` of the bodies need not
    be computed again.
    """
    lower = references["lower"].job.grid
    columns = columns or {name: reference.column(strip) for name, reference in references.items()}
    estimated = total(list(columns.values()))
    paired = np.sum([reference.paired_column(strip) for reference in references.values()], axis=0)
    moved = vertical(contour, lower.strips)  # (n_s, 3)
    approach = sum(reference.approach() for reference in references.values())
    rigid = approach * np.einsum("ai,j->ija", moved, moved[strip])
    return replace(estimated, ic=paired - rigid[:, :, None])


def vertical(contour: Contour, s: Array) -> Array:
    """Return the x, s, n components of a unit displacement along z at arc lengths s [mm], (n_s, 3)."""
    sin, cos = contour.normal(s)
    return np.stack([np.zeros_like(sin), -sin, cos], axis=-1)
