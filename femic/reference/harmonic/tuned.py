"""The first model of the harmonic engine, under a patch or on strips: cells, far arc, wavenumbers."""

import numpy as np

from femic.reference.engine import TunedCells
from femic.reference.estimate import WAVES_GAIN
from femic.reference.level import HIGHER, TRUNCATION_ORDER, WAVES_ORDER
from femic.reference.meshing.cell_size import Cells
from geometries.arrays import Array
from geometries.grids import Grid
from geometries.patches import Patch

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
