"""C on a grid: the IC matrix of each body at all lags and strips, with the estimate of its error.

One model serves all strips: the wavenumbers are solved once, with every strip as a load. Displacements at the
lags are made of them strip by strip, when they are asked for: no more than one loaded strip is in memory.
The discount is that of `femic.discount`: one matrix M per body.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from approx.halfspace import HalfSpace
from femic.accuracy import FLOOR, Shares
from femic.cell_size import Cells
from femic.discount import (
    Condition,
    DiscountRule,
    conditions,
    discount,
    fit_discount,
    motions,
    observers,
)
from femic.harmonic.engine import HarmonicRequest
from femic.harmonic.lags import LagSynthesis
from femic.harmonic.synthesis import Responses, displacements
from femic.models import Cost, Points, RawICs
from femic.problem import Assessed
from femic.reference import (
    FAR_RADIUS,
    MESH_ORDER,
    TRUNCATION_ORDER,
    Estimated,
    Level,
    costs_of,
    estimated,
    factors,
    total,
    waves_for,
)
from femic.refinement import SILENT, Watch, converged
from femic.solid.engine import Request
from femic.store import Store
from femic.symmetry import N, S, X
from geometries.bodies import Body
from geometries.grids import Grid
from geometries.materials import one_body
from geometries.patches import DIRECTIONS, Load, Patch

Array = NDArray[np.float64]

TUNED_TOLERANCE = 0.001  # for these cells, observed at the centres of strips only:
CELLS_PER_HALF_SIDE, GROWTH = 2, 0.55
COARSEST = 1.25  # times these, however large the tolerance
WAVES = 4.0  # expected error of the interpolation between wavenumbers over what it turns out to be
FAR_OVER_HALF_WIDTH = 600.0  # of the grid
NEAR, NEAR_SHARE = 4, 5.0  # elements from the load within which errors are shares of 5 A_nn
HIGHEST = 6 * np.pi  # wavenumber, times the least half-side: M must be right to more digits than all else
REMEMBERED = 10_000_000  # entries of a matrix whose columns are made once and not each time


def far_radius_for(tolerance: float, grid: Grid) -> float:
    """Radius [mm] of the far arc that is likely to meet a tolerance: in proportion to the grid."""
    half = grid.n_s * grid.ds / 2
    closer = max(1.0, TUNED_TOLERANCE / tolerance) ** (1 / TRUNCATION_ORDER)
    return max(FAR_RADIUS["harmonic"], FAR_OVER_HALF_WIDTH * half) * closer


def cells_for(tolerance: float, grid: Grid) -> Cells:
    """Cells that are likely to meet a tolerance."""
    factor = min((tolerance / TUNED_TOLERANCE) ** (1 / MESH_ORDER), COARSEST)
    return Cells(grid.ds / 2 / CELLS_PER_HALF_SIDE, GROWTH, GROWTH).scaled(factor)


@dataclass(frozen=True)
class MatrixJob:
    """The IC matrix of one body: how accurately, and with which cells to start; see `femic.reference.Job`."""

    body: Body
    grid: Grid
    tolerance: float = 0.001
    cells: Cells | None = None
    rotation_reach: float = 20.0
    moment_arm: float = 5.0
    most_unknowns: int = 1_000_000

    engine: Literal["harmonic"] = "harmonic"

    @property
    def first_cells(self) -> Cells:
        """The cells to start with."""
        return self.cells or cells_for(self.tolerance, self.grid)

    @property
    def strip_loads(self) -> tuple[Load, ...]:
        """Unit loads on every strip in every direction."""
        patches = [self.grid.patch(strip) for strip in range(self.grid.n_s)]
        return tuple(Load(patch, direction) for patch in patches for direction in (X, S, N))

    @property
    def rule(self) -> DiscountRule:
        """How M is fitted."""
        return DiscountRule(self.grid.dx / 2, self.grid.ds / 2, self.rotation_reach, self.moment_arm)

    @cached_property
    def fit(self) -> list[Condition]:
        """What determines M."""
        return conditions(self.body, self.rule, self.strip_loads)

    @property
    def fit_loads(self) -> tuple[Load, ...]:
        """The loads of these conditions."""
        return tuple(dict.fromkeys(load for condition in self.fit for load in condition.loads))

    @property
    def fit_points(self) -> Points:
        """Where these conditions look."""
        return observers(self.body, self.rule, self.fit)

    def request(self, level: Level) -> HarmonicRequest:
        """The model at a level: all strips as loads and observers, and what M needs."""
        cells, domain = factors(level)
        strips, extra = self.grid.strips, self.fit_points
        points = Points(
            np.append(np.full_like(strips, self.grid.lags[-1]), extra.x), np.append(strips, extra.s)
        )
        loads = tuple(dict.fromkeys([*self.strip_loads, *self.fit_loads]))
        relative, larger = waves_for(self.tolerance, WAVES, level)
        return HarmonicRequest(
            replace(self.body, domain=self.body.domain.scaled(domain)),
            loads,
            points,
            self.first_cells.scaled(cells),
            relative * self._least_scales(loads, np.unique(points.s)),
            larger * HIGHEST,
            even_strips=True,
            exact=tuple(dict.fromkeys(load.patch for load in self.fit_loads)),
        )

    def half_space_nn(self, x: ArrayLike, s: ArrayLike) -> Array:
        """A_nn per unit load [mm/N] at distances x, s [mm]."""
        half_space = HalfSpace(one_body(self.body.material, self.body.side))
        patch = Patch(self.grid.dx / 2, self.grid.ds / 2)
        return half_space.ics(patch, x, s)[N, N] / self.grid.area

    def _least_scales(self, loads: Sequence[Load], s: Array) -> Array:
        """Least scale of errors [mm/N], (load, 1, len(s)); of M's conditions the least A_nn of all."""
        of_load = np.array([load.patch.s for load in loads])
        scales = FLOOR * self.half_space_nn(0.0, s - of_load[:, None])
        of_fit = np.array([load in self.fit_loads for load in loads])
        fitted = np.ix_(of_fit, np.isin(s, self.fit_points.s))
        scales[fitted] = np.min(scales) / FLOOR
        return scales[:, None]


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
    _remembered: dict[int, Estimated] = field(default_factory=dict, repr=False)

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

    def column(self, strip: int) -> Estimated:
        """C due to unit loads on one strip, arrays (3, 3, n_x, n_s); small matrices are remembered."""
        if strip not in self._remembered:
            found = self._column(strip)
            if found.ic.size * self.job.grid.n_s > REMEMBERED:
                return found
            self._remembered[strip] = found
        return self._remembered[strip]

    def _column(self, strip: int) -> Estimated:
        grid = self.job.grid
        x, s = (values.ravel() for values in np.meshgrid(grid.lags, grid.strips, indexing="ij"))
        unit = motions(self.job.body, Points(x, s), float(grid.strips[strip]))
        shape = (3, 3, grid.n_x, grid.n_s)
        found = {
            name: synthesis.column(strip) - discount(m, unit).reshape(shape)
            for name, (synthesis, m) in self._made.items()
        }
        return estimated("harmonic", found.pop(""), found.pop("coarse"), found)


def matrices(
    jobs: Mapping[str, MatrixJob],
    *,
    combined: bool = False,
    workers: int = 1,
    store: Store | None = None,
    watch: Watch = SILENT,
) -> dict[str, MatrixReference]:
    """Solve all bodies, refining each until its estimate meets its tolerance; `combined`: their sum's too.

    How errors are measured: `column_scale`. Raises as `femic.at_points.references`.
    """
    return converged(AtLags(jobs, combined), workers=workers, store=store or Store(), watch=watch)


@dataclass(frozen=True)
class AtLags:
    """What `femic.refinement` drives."""

    jobs: Mapping[str, MatrixJob]
    combined: bool

    def request(self, name: str, level: Level) -> Request | HarmonicRequest:
        """The model of a job at a level."""
        return self.jobs[name].request(level)

    def read(self, asked: Request | HarmonicRequest, model: RawICs | Responses) -> Responses:
        """All of it."""
        assert isinstance(model, Responses), asked
        return model

    def combine(self, name: str, level: Level, models: Mapping[Level, Responses]) -> MatrixReference:
        """C of a body."""
        job, of_level = self.jobs[name], level.models("harmonic")
        fine, coarse = models[of_level["fine"]], models[of_level["coarse"]]
        costs = costs_of("harmonic", level, {other: model.cost for other, model in models.items()})
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


def column_scale(strip: int, c: Array, jobs: Sequence[MatrixJob]) -> Array:
    """Scale of refinement of ICs (3, 3, n_x, n_s) that jobs have together, of the same shape.

    `NEAR` elements from the load and further: per pair of strips, the larger of max |C_ij| and 0.05 max A_nn
    over these lags. Nearer: 5 times A_nn there.
    """
    a_nn, far = half_spaces_nn(strip, jobs), is_far(strip, jobs[0].grid)
    of_line = np.maximum(np.max(np.abs(c) * far, axis=2), FLOOR * np.max(a_nn * far, axis=0))
    return np.where(far, of_line[:, :, None], NEAR_SHARE * a_nn)


def half_spaces_nn(strip: int, jobs: Sequence[MatrixJob]) -> Array:
    """A_nn of bodies together under a unit load on a strip [mm/N], (n_x, n_s)."""
    grid = jobs[0].grid
    x, s = grid.lags[:, None], grid.strips - grid.strips[strip]
    return np.asarray(np.sum([job.half_space_nn(x, s) for job in jobs], axis=0))


def is_far(strip: int, grid: Grid) -> NDArray[np.bool_]:
    """Which elements are `NEAR` elements from a load on a strip or further, (n_x, n_s)."""
    lag, apart = np.arange(grid.n_x)[:, None], np.arange(grid.n_s) - strip
    return np.asarray(np.hypot(lag, apart) >= NEAR)


def column_shares(strip: int, c: Estimated, scale: Array) -> Shares:
    """The estimate of a column, and its parts, at worst, as shares of its scale of refinement."""
    mesh, truncation, waves, whole = (
        np.nan_to_num(part / scale, nan=np.inf)
        for part in (c.mesh_error, c.truncation_error, c.waves_error, c.estimate)
    )
    i, j, lag, observer = np.unravel_index(np.argmax(whole), whole.shape)
    where = f"of strip {observer} under strip {strip} (worst at lag {lag})"
    component = DIRECTIONS[i] + DIRECTIONS[j]
    parts = float(np.max(mesh)), float(np.max(truncation)), float(np.max(waves))
    return Shares(*parts, float(np.max(whole)), component, where)


def worst_of(of_strips: list[Shares]) -> Shares:
    """The worst of several, parts by themselves."""
    at_worst = max(of_strips, key=lambda shares: shares.total)
    parts = {part: max(getattr(one, part) for one in of_strips) for part in ("mesh", "truncation", "waves")}
    return replace(at_worst, **parts)
