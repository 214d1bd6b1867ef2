"""B-hat in the place of C of single loads and of grids, where the numbers of C are not what is tested."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from approx.halfspace import HalfSpace
from approx.variants import approximate
from femic.reference.engine import Cost
from femic.reference.matrix.job import MatrixJob
from femic.reference.result import EstimatedICs, Reference
from femic.reference.run_options import Level
from geometries.materials import one_body

NAMES = (  # of `references` and `matrices`, where they are used
    ("femic.results.ics.references", "references"),
    ("femic.interface.matrices.matrices", "matrices"),
    ("femic.contact.pairs.ics.matrices", "matrices"),
)
COST = Cost(1, 1, "B-hat", (), 0.0, {}, 0.0)


def b_hat_as_c(monkeypatch, estimate=0.01):
    """Let C be B-hat of each body, with an estimate of a share of each IC."""

    def references(jobs, *_, **__):
        return {name: _reference(job, estimate) for name, job in jobs.items()}

    def matrices(jobs, *_, **__):
        return {name: Matrix(job, estimate) for name, job in jobs.items()}

    made = {"references": references, "matrices": matrices}
    for place, name in NAMES:
        monkeypatch.setattr(place, made[name])


def _b_hat(body, patch, x, s):
    """B-hat of a body under a unit load on a patch [mm/N], (3, 3, ...)."""
    half_space = HalfSpace(one_body(body.material, body.side))
    return approximate("Bhat", half_space, body.surface, patch, (x, s)) / patch.area


def _estimated(ic, share):
    zero = np.zeros_like(ic)
    return EstimatedICs(ic, share * np.abs(ic), zero, zero)


def _reference(job, share):
    ic = _b_hat(job.body, job.patch, job.points.x, job.points.s)
    m = np.zeros((4, 4))
    c = _estimated(ic, share)
    return Reference(c, ic, m, Level(), job.first_cells, job.body, {"fine": COST})


@dataclass(frozen=True)
class Matrix:
    """What stands in for a `MatrixReference`."""

    job: MatrixJob
    share: float
    level = Level()

    @cached_property
    def _columns(self):
        lags, strips = np.meshgrid(self.job.grid.lags, self.job.grid.strips, indexing="ij")
        return [
            _b_hat(self.job.body, self.job.grid.patch(strip), lags, strips)
            for strip in range(self.job.grid.n_s)
        ]

    def raw_column(self, strip, _=""):
        """B-hat under one strip [mm/N], (3, 3, n_x, n_s)."""
        return self._columns[strip]

    paired_column = raw_column

    def column(self, strip, _=None):
        """The same with its estimate."""
        return _estimated(self._columns[strip], self.share)

    def approach(self, _=""):
        """Nothing is subtracted."""
        return 0.0
