"""The IC matrix of each body at all lags and strips, with the estimate of its error.

One model serves all strips, with every strip as a load. Displacements at the lags are computed from the
solved model when a strip is requested, so that a large matrix never has more than one loaded strip in memory.
The discount has one matrix M per body (`discount_rules`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import cast

import numpy as np

from femic.reference.assessment import Assessment, Batch, Measure, assess
from femic.reference.discount import FZ, discount, fit_discount, motions
from femic.reference.engine import ColumnSynthesis, GridModel
from femic.reference.estimate import EstimatedICs, estimated
from femic.reference.level import Level, factors
from femic.reference.matrix.columns import column_scale, column_shares
from femic.reference.matrix.job import Discount, MatrixJob
from femic.reference.meshing.cell_size import Cells
from femic.reference.models import Cost, Points
from femic.reference.refinement import converged
from femic.reference.result import costs_of
from femic.reference.run_options import DEFAULT, RunOptions
from geometries.arrays import Array
from geometries.bodies import Body

REMEMBERED_ENTRIES = 40_000_000  # of the largest matrix that is held in memory as a whole


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
    solved: GridModel

    @cached_property
    def _syntheses(self) -> Mapping[str, ColumnSynthesis]:
        """The syntheses of columns: of the model (""), and of its variations."""
        return self.job.matrices.columns(self.solved, self.job.grid, self.job.solved)

    @cached_property
    def _compliances(self) -> dict[Discount, dict[str, Array]]:
        """M (4, 4) by discount: of the model (""), and of its variations."""
        return {name: self._fitted(name) for name in self.job.discounts}

    def _fitted(self, name: Discount) -> dict[str, Array]:
        job = self.job
        if not job.fits[name]:
            return dict.fromkeys(self._syntheses, np.zeros((4, 4)))
        u = job.matrices.displacements(self.solved, job.fit_loads, job.fit_points(name))
        return {
            variation: fit_discount(
                job.body, job.rules[name], job.fits[name], dict(zip(job.fit_loads, load_u, strict=True))
            )
            for variation, load_u in {"": u.u, **u.perturbed}.items()
        }

    @property
    def discount(self) -> Array:
        """M of the first discount [mm/N, 1/N, 1/(N mm)], shape (4, 4)."""
        return self._compliances[self.job.discounts[0]][""]

    def raw_column(self, strip: int, variation: str = "") -> Array:
        """Return C before the discount [mm/N] due to unit total loads on one strip, (3, 3, n_x, n_s)."""
        return self._syntheses[variation].column(strip)

    @cached_property
    def _columns(self) -> list[EstimatedICs] | None:
        """All columns of a small matrix; None for a large one."""
        n_x, n_s = self.job.grid.n_x, self.job.grid.n_s
        if 9 * n_x * n_s**2 > REMEMBERED_ENTRIES:
            return None
        return [self._column(strip, self.job.discounts[0]) for strip in range(n_s)]

    def column(self, strip: int, discount: Discount | None = None) -> EstimatedICs:
        """Return C [mm/N] due to unit total loads on one strip, arrays (3, 3, n_x, n_s).

        `discount` is one of the discounts of the job, by default the first.
        """
        if discount in (None, self.job.discounts[0]) and self._columns is not None:
            return self._columns[strip]
        return self._column(strip, discount or self.job.discounts[0])

    def _column(self, strip: int, name: Discount) -> EstimatedICs:
        """C [mm/N] due to unit total loads on one strip, after a discount, with its estimate."""
        unit = self._motions(strip)
        by_variation = {
            variation: self._varied(strip, name, variation, unit)
            for variation in self._syntheses
            if variation != "nearer" or name == "source"  # elsewhere the far arc is a part of the body
        }
        safety = self.job.settings.engine.estimate.safety
        column = estimated(by_variation.pop(""), by_variation, safety=safety)
        return EstimatedICs(column.ic, *(cast(Array, error.astype(np.float32)) for error in column.errors))

    def paired_column(self, strip: int, variation: str = "") -> Array:
        """Return C [mm/N] for a pair of bodies, before their approach is subtracted, (3, 3, n_x, n_s).

        Only the discount "source" is applied. `variation` is the variation of the model: "nearer" has a far
        arc of half the radius.
        """
        name = self.job.discounts[0]
        if name != "source":
            return self.raw_column(strip, variation)
        return self._varied(strip, name, variation, self._motions(strip))

    def approach(self, variation: str = "") -> float:
        """Return M_zz [mm/N], which is subtracted from the approach of a pair; 0 for other discounts."""
        name = self.job.discounts[0]
        return float(self._compliances[name][variation][FZ, FZ]) if name == "approach" else 0.0

    def _motions(self, strip: int) -> Array:
        """The `motions` of all elements under loads on one strip, shape (7, 3, 3, n_x, n_s)."""
        elements = Points(self.job.grid.lags[:, None], self.job.grid.strips[None])
        return motions(self.job.body, elements, float(self.job.grid.strips[strip]))

    def _varied(self, strip: int, name: Discount, variation: str, unit: Array) -> Array:
        """A variation of C [mm/N] after a discount, from its `motions`, shape (3, 3, n_x, n_s)."""
        rigid = discount(self._compliances[name][variation], unit)
        return np.asarray(self.raw_column(strip, variation) - rigid)


def matrices(
    jobs: Mapping[str, MatrixJob], options: RunOptions = DEFAULT, *, combined: bool = False
) -> dict[str, MatrixReference]:
    """Solve all bodies and refine each until its estimate meets its tolerance.

    With `combined` the estimate of the sum of the bodies must also meet it. Errors are measured on the scale
    of `column_scale`. Raises as `femic.reference.at_points.references`.
    """
    assess_all = partial(assess_matrices, jobs, combined=combined)
    return converged(
        jobs, options, read=lambda _, solved: solved.model, combine=_matrix_reference, assess=assess_all
    )


def _matrix_reference(job: MatrixJob, level: Level, models: Mapping[Level, GridModel]) -> MatrixReference:
    """Return the IC matrix of a body at a level from its models."""
    level_of_model = level.models(job.settings.engine.estimate.models)
    solved, costs = models[level], costs_of(level_of_model, models)
    cells = job.first_cells.scaled(factors(level)[0])
    return MatrixReference(job, level, cells, solved.body, costs, solved)


def assess_matrices(
    jobs: Mapping[str, MatrixJob], references: Mapping[str, MatrixReference], *, combined: bool
) -> Assessment:
    """Return the estimated errors of the bodies, at worst over all strips, and of their sum."""

    def batch(strip: int) -> Batch:
        def measure(bodies: Sequence[str], ic: Array) -> Measure:
            scale = column_scale(strip, ic, [jobs[body] for body in bodies])
            return lambda body, c: column_shares(strip, c, scale, jobs[body].components)

        return Batch({body: reference.column(strip) for body, reference in references.items()}, measure)

    strips = range(next(iter(jobs.values())).grid.n_s)
    return assess((batch(strip) for strip in strips), combined=combined)
