"""The first model of the harmonic engine: its cells, its far arc and its wavenumbers for a tolerance."""

import numpy as np

from femic.reference.engine import TunedCells
from femic.reference.estimate import WAVES_GAIN
from femic.reference.level import HIGHER, TRUNCATION_ORDER, WAVES_ORDER
from femic.reference.meshing.cell_size import Cells
from geometries.arrays import Array
from geometries.patches import Patch

CELLS_PER_HALF_SIDE, GROWTH = 12, 0.34
FAR_RADIUS = 1280.0  # mm, of the far arc at the tuned tolerance
HIGHEST = 2 * np.pi  # largest wavenumber times the least half-side: beyond it the half-space rules
WAVES_SHARE = 0.5  # share of the tolerance that the interpolation between wavenumbers may take
LOOSEST_WAVES = 0.01  # loosest tolerance of the interpolation: with fewer wavenumbers halving gains less


def least_side(patch: Patch) -> float:
    """The half-side [mm] that cells must resolve: across x only, along x there are no cells."""
    return patch.b


def cells(patch: Patch) -> Cells:
    """Cells that meet the tuned tolerance under a patch."""
    return Cells(least_side(patch) / CELLS_PER_HALF_SIDE, GROWTH, GROWTH)


TUNED = TunedCells(tolerance=0.001, cells=cells, coarsest=1.5)


def far_radius(tolerance: float) -> float:
    """Radius [mm] of the far arc that is likely to meet a tolerance."""
    return FAR_RADIUS * TUNED.tighter(tolerance) ** (1 / TRUNCATION_ORDER)


def waves_for(tolerance: float, least_scale: Array | float, steps: int) -> tuple[Array | float, float]:
    """Return the accuracy [mm/N] of the interpolation in k, and the factor on the largest wavenumber.

    `least_scale` [mm/N] is the least scale of refinement, `steps` the number of refinements of the waves.
    """
    accuracy = WAVES_SHARE * min(tolerance, LOOSEST_WAVES) * least_scale / WAVES_GAIN["sparser"] ** steps
    return accuracy, HIGHER**steps * TUNED.tighter(tolerance) ** (1 / WAVES_ORDER)
