"""The request for a model of the harmonic engine, and the cells, far arc and wavenumbers that it needs.

`TUNED` and `TUNED_ON_STRIPS` are the cells of the first model, under a patch and on strips.
"""

from dataclasses import dataclass, replace

import numpy as np

from femic.reference.engine import MatrixSpecification, Request, Specification, TunedCells
from femic.reference.harmonic.wavenumbers import Axis
from femic.reference.meshing import Cells
from femic.reference.result import WAVES_GAIN
from femic.reference.run_options import COARSER, HIGHER, TRUNCATION_ORDER, WAVES_ORDER
from geometries.arrays import Array
from geometries.bodies import Body
from geometries.patches import Grid, Load, Patch

# --- the first model ---

CELLS_PER_HALF_SIDE, GROWTH = 12, 0.34
CELLS_PER_HALF_STRIP, GROWTH_ON_STRIPS = 2, 0.5  # displacements are read at the centres of strips only
FAR_RADIUS = 1280.0  # mm, of the far arc at the tuned tolerance
FAR_OVER_HALF_WIDTH = 600.0  # far radius over the half-width of a grid
HIGHEST = 2 * np.pi  # largest wavenumber times the least half-side: beyond it the half-space rules
WAVES_SHARE = 0.5  # share of the tolerance that the interpolation between wavenumbers may take
LOOSEST_WAVES = 0.01  # loosest tolerance of the interpolation: with fewer wavenumbers halving gains less


def least_side(patch: Patch) -> float:
    """The half-side [mm] that cells must resolve: across x only, along x there are no cells."""
    return patch.b


def cells(patch: Patch) -> Cells:
    """Cells that meet the tuned tolerance under a patch."""
    return Cells(least_side(patch) / CELLS_PER_HALF_SIDE, GROWTH, GROWTH)


def cells_on_strips(patch: Patch) -> Cells:
    """Return cells that meet the tuned tolerance on strips as wide as a patch."""
    return Cells(patch.b / CELLS_PER_HALF_STRIP, GROWTH_ON_STRIPS, GROWTH_ON_STRIPS)


TUNED = TunedCells(tolerance=0.001, cells=cells, coarsest=1.5)
TUNED_ON_STRIPS = TunedCells(tolerance=0.001, cells=cells_on_strips, coarsest=1.25)


def far_radius(tolerance: float) -> float:
    """Radius [mm] of the far arc that is likely to meet a tolerance."""
    return FAR_RADIUS * TUNED.tighter(tolerance) ** (1 / TRUNCATION_ORDER)


def far_radius_of_grid(tolerance: float, grid: Grid) -> float:
    """Return a far radius [mm] that is likely to meet a tolerance; it grows with the width of the grid."""
    half_width = grid.n_s * grid.ds / 2
    tightening = TUNED_ON_STRIPS.tighter(tolerance) ** (1 / TRUNCATION_ORDER)
    return max(FAR_RADIUS, FAR_OVER_HALF_WIDTH * half_width) * tightening


def waves_for(tolerance: float, least_scale: Array | float, steps: int) -> tuple[Array | float, float]:
    """Return the accuracy [mm/N] of the interpolation in k, and the factor on the largest wavenumber.

    `least_scale` [mm/N] is the least scale of refinement, `steps` the number of refinements of the waves.
    """
    accuracy = WAVES_SHARE * min(tolerance, LOOSEST_WAVES) * least_scale / WAVES_GAIN["sparser"] ** steps
    return accuracy, HIGHER**steps * TUNED.tighter(tolerance) ** (1 / WAVES_ORDER)


# --- the request ---

SCALE_LOWEST = 0.7  # scale of the wavenumbers times the far radius: below it the clamped far arc rules
CURVED_FROM = 0.05  # half-side over radius of curvature beyond which larger wavenumbers are needed
FAR_REACH = 7.0  # lengths 1 / k beyond which the far arc has no effect
WAVES_OVERESTIMATE = 4.0  # on strips: expected over actual error of the interpolation between wavenumbers
HIGHEST_OF_FIT = 9 * np.pi  # largest wavenumber times the least half-side: M needs more digits than C
COLUMNS_NEED = 1 / 2  # largest wavenumber that columns of an IC matrix need over the one that M needs
NEARER = 2.0  # far radius over the radius of the nearer far arc, which shows the truncation error


@dataclass(frozen=True)
class HarmonicRequest(Request):
    """The input of one model; of the points, only s matters here.

    `cells` gives the smallest cell and its growth away from the ends of the loaded strips. With `even_strips`
    all cells on the strips have the smallest size; near `fit_patches`, where M is fitted, they are smaller
    (`femic.reference.harmonic.engine.FINER`). `accuracy` [mm/N], a number or an array (load, 1, observer),
    limits the error of the interpolation between wavenumbers. `highest` is the largest wavenumber times the
    least half-side of loads.

    Spare loads and arc lengths are included for later requests only (`femic.reference.harmonic.stored`). With
    `given_domain` the far arc is part of the body, so that a model with a farther one does not serve.
    """

    accuracy: Array | float
    highest: float = HIGHEST
    even_strips: bool = False
    fit_patches: tuple[Patch, ...] = ()
    spare_loads: tuple[Load, ...] = ()
    spare_s: tuple[float, ...] = ()
    given_domain: bool = False

    @property
    def requested_loads(self) -> tuple[Load, ...]:
        """The loads without the spare ones."""
        return tuple(load for load in self.loads if load not in self.spare_loads)

    @property
    def requested_s(self) -> Array:
        """The arc lengths of `observed` without the spare ones [mm], shape (n,)."""
        return np.setdiff1d(self.observed, self.spare_s)

    @property
    def k_max(self) -> float:
        """Largest wavenumber [1/mm]: the more curved the surface under the loads, the larger."""
        patches = [load.patch for load in self.requested_loads]
        relative_curvature = max(
            _curvature(self.body, patch.s, patch.b) * max(patch.a, patch.b) for patch in patches
        )
        a, b = min(patch.a for patch in patches), min(patch.b for patch in patches)
        return self.highest / min(a, b) * max(1.0, relative_curvature / CURVED_FROM) ** 0.5

    @property
    def coarser(self) -> "HarmonicRequest":
        """The same request with coarser cells, which show the error of the mesh."""
        return replace(self, cells=self.cells.scaled(COARSER))

    @property
    def observed(self) -> Array:
        """Arc lengths [mm] where the responses are read, in growing order without repetitions, shape (n,)."""
        return np.unique(self.points.s)

    @property
    def shares(self) -> tuple[float, ...]:
        """Shares of the far radius at which the far arc lies: its own, and the nearer one.

        A body with an outline has its supports only.
        """
        return (1.0, 1 / NEARER) if self.body.outline is None else (1.0,)

    @property
    def cutoff_wavenumber(self) -> float:
        """Wavenumber [1/mm] from which on the nearer far arc has no effect on the responses."""
        return FAR_REACH * NEARER / self.body.domain.far_radius

    @property
    def determined_by(self) -> tuple[object, ...]:
        """All inputs that the responses depend on."""
        size = self.cells, self.even_strips, self.fit_patches
        return self.body, self.loads, self.observed, size, self.accuracy, self.axis

    @property
    def axis(self) -> Axis:
        """The axis of wavenumbers."""
        return Axis(SCALE_LOWEST / self.body.domain.far_radius, self.k_max, self.body.rolling_radius)


def _curvature(body: Body, s: float, b: float) -> float:
    """Curvature [1/mm] of the surface over the strip s - b ... s + b: the larger of both directions."""
    turn = float(np.ptp(body.contour.inclination(np.linspace(s - b, s + b, 9)))) / (2 * b)
    return max(turn, 1 / float(body.surface.circle_radius(s)))


def request_for(model: Specification) -> HarmonicRequest:
    """Return the request for a model, with wavenumbers as dense as the least scale of refinement needs."""
    accuracy, factor = waves_for(model.tolerance, model.least_scale, model.waves)
    return HarmonicRequest(model.body, model.loads, model.points, model.cells, accuracy, factor * HIGHEST)


def request_on_strips(model: MatrixSpecification) -> HarmonicRequest:
    """Return the request for the model of a grid."""
    least_scale = WAVES_OVERESTIMATE * model.least_scale
    accuracy, factor = waves_for(model.tolerance, least_scale, model.waves)
    return HarmonicRequest(
        model.body,
        model.loads,
        model.points,
        model.cells,
        accuracy,
        factor * HIGHEST_OF_FIT,
        even_strips=True,
        fit_patches=model.fit_patches,
        spare_loads=model.spare_loads,
        spare_s=model.spare_s,
        given_domain=model.given_domain,
    )
