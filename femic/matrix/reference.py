"""The IC matrix of each body at all lags and strips, with the estimate of its error.

One model serves all strips: the wavenumbers are solved once, with every strip as a load. Displacements at the
lags are made of them strip by strip, when they are asked for: of a large matrix no more than one loaded strip
is in memory. The discount is that of `femic.discount`: one matrix M per body.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from femic.accuracy import Shares
from femic.discount import discount, fit_discount, motions
from femic.estimate import Estimated, estimated, total
from femic.harmonic.lags import LagSynthesis
from femic.harmonic.record import HARMONIC
from femic.harmonic.synthesis import Responses, displacements
from femic.level import Level, factors
from femic.matrix.columns import column_scale, column_shares, worst_of
from femic.matrix.job import MatrixJob
from femic.means import DEFAULT, Means, Solved
from femic.meshing.cell_size import Cells
from femic.models import Cost, Points
from femic.reference import costs_of
from femic.refinement import Assessed, converged
from geometries.arrays import Array
from geometries.bodies import Body

REMEMBERED = 10_000_000  # entries of a matrix whose columns are made once and not each time


@dataclass(frozen=True)
class MatrixReference:
    """The IC matrix of one body: made strip by strip of what was solved, per unit total load [mm/N]."""

    job: MatrixJob
    level: Level
    cells: Cells
    body: Body
    models: Mapping[str, Cost]
    fine: Responses
    coarse: Responses

    @cached_property
    def _made(self) -> dict[str, tuple[LagSynthesis, Array]]:
        """How displacements are made, and M, of the fine model, of less of it, and of the coarse one."""
        at_lags = {
            name: LagSynthesis.of(self.fine, found, k_max, self.job.grid)
            for name, found, k_max in self.fine.variations()
            if name != "nearer"
        }
        at_lags["nearer"] = replace(at_lags[""], found=self.fine.nearer)  # at the same wavenumbers
        fine, coarse = (
            displacements(solved, self.job.fit_loads, self.job.fit_points)
            for solved in (self.fine, self.coarse)
        )
        fitted = {"": fine.u, **fine.perturbed}
        made = {name: (synthesis, self._m(fitted[name])) for name, synthesis in at_lags.items()}
        _, found, k_max = next(self.coarse.variations())
        made["coarse"] = LagSynthesis.of(self.coarse, found, k_max, self.job.grid), self._m(coarse.u)
        return made

    def _m(self, u: Array) -> Array:
        of_load = dict(zip(self.job.fit_loads, u, strict=True))
        return fit_discount(self.job.body, self.job.rule, self.job.fit, of_load)

    @property
    def discount(self) -> Array:
        """M, (4, 4)."""
        return self._made[""][1]

    def raw_column(self, strip: int) -> Array:
        """C before the discount due to unit loads on one strip, (3, 3, n_x, n_s)."""
        return self._made[""][0].column(strip)

    @cached_property
    def _columns(self) -> list[Estimated] | None:
        """All columns of a small matrix, None of a large one."""
        n_x, n_s = self.job.grid.n_x, self.job.grid.n_s
        if 9 * n_x * n_s**2 > REMEMBERED:
            return None
        return [self._column(strip) for strip in range(n_s)]

    def column(self, strip: int) -> Estimated:
        """C due to unit loads on one strip, arrays (3, 3, n_x, n_s)."""
        return self._column(strip) if self._columns is None else self._columns[strip]

    def _column(self, strip: int) -> Estimated:
        grid = self.job.grid
        x, s = (values.ravel() for values in np.meshgrid(grid.lags, grid.strips, indexing="ij"))
        unit = motions(self.job.body, Points(x, s), float(grid.strips[strip]))
        shape = (3, 3, grid.n_x, grid.n_s)
        of_name = {
            name: synthesis.column(strip) - discount(m, unit).reshape(shape)
            for name, (synthesis, m) in self._made.items()
        }
        return estimated(of_name.pop(""), of_name.pop("coarse"), of_name, safety=HARMONIC.safety)


def matrices(
    jobs: Mapping[str, MatrixJob], means: Means = DEFAULT, *, combined: bool = False
) -> dict[str, MatrixReference]:
    """Solve all bodies, refining each until its estimate meets its tolerance; `combined`: their sum's too.

    How errors are measured: `column_scale`. Raises as `femic.at_points.references`.
    """
    return converged(AtLags(jobs, combined), means)


@dataclass(frozen=True)
class AtLags:
    """What `femic.refinement` drives."""

    jobs: Mapping[str, MatrixJob]
    combined: bool

    def read(self, _name: str, solved: Solved) -> Responses:
        """All of it."""
        responses: Responses = solved.model
        return responses

    def combine(self, name: str, level: Level, models: Mapping[Level, Responses]) -> MatrixReference:
        """C of a body."""
        job, of_level = self.jobs[name], level.models(HARMONIC.models)
        fine, coarse = models[of_level["fine"]], models[of_level["coarse"]]
        costs = costs_of(of_level, {other: model.cost for other, model in models.items()})
        cells = job.first_cells.scaled(factors(level)[0])
        return MatrixReference(job, level, cells, fine.body, costs, fine, coarse)

    def assess(self, found: Mapping[str, MatrixReference]) -> Assessed:
        """Estimated errors, strip by strip."""
        worst: dict[str, list[Shares]] = {name: [] for name in (*found, "combined", *map(_in_sum, found))}
        for strip in range(next(iter(self.jobs.values())).grid.n_s):
            of_body = {name: reference.column(strip) for name, reference in found.items()}
            for name, c in of_body.items():
                worst[name].append(column_shares(strip, c, column_scale(strip, c.ic, [self.jobs[name]])))
            if self.combined:
                c = total(list(of_body.values()))
                scale = column_scale(strip, c.ic, list(self.jobs.values()))
                worst["combined"].append(column_shares(strip, c, scale))
                for name, own in of_body.items():
                    worst[_in_sum(name)].append(column_shares(strip, own, scale))
        own_worst = {name: worst_of(worst[name]) for name in found}
        if not self.combined:
            return Assessed(own_worst)
        in_sum = {name: worst_of(worst[_in_sum(name)]) for name in found}
        return Assessed(own_worst, worst_of(worst["combined"]), in_sum)


def _in_sum(name: str) -> str:
    return f"{name} in the sum"
