"""Models of the harmonic engine for IC matrices: cells on strips, the far arc, wavenumbers, columns."""

import numpy as np

from femic.late import Late
from femic.reference.engine import Matrices, MatrixSpecification, TunedCells
from femic.reference.harmonic.request import HarmonicRequest
from femic.reference.harmonic.tuned import FAR_RADIUS, waves_for
from femic.reference.level import TRUNCATION_ORDER
from femic.reference.meshing.cell_size import Cells
from geometries.grids import Grid
from geometries.patches import Patch

CELLS_PER_HALF_STRIP, GROWTH_OF_CELLS = 2, 0.55  # displacements are read at the centres of strips only
WAVES_OVERESTIMATE = 4.0  # expected over actual error of the interpolation between wavenumbers
FAR_OVER_HALF_WIDTH = 600.0  # far radius over the half-width of the grid
HIGHEST_OF_FIT = 6 * np.pi  # largest wavenumber times the least half-side: M needs more digits than C


def _cells(patch: Patch) -> Cells:
    """Return cells that meet the tuned tolerance on strips as wide as a patch."""
    return Cells(patch.b / CELLS_PER_HALF_STRIP, GROWTH_OF_CELLS, GROWTH_OF_CELLS)


TUNED_ON_STRIPS = TunedCells(tolerance=0.001, cells=_cells, coarsest=1.25)


def far_radius_for(tolerance: float, grid: Grid) -> float:
    """Return a far radius [mm] that is likely to meet a tolerance; it grows with the width of the grid."""
    half_width = grid.n_s * grid.ds / 2
    tightening = TUNED_ON_STRIPS.tighter(tolerance) ** (1 / TRUNCATION_ORDER)
    return max(FAR_RADIUS, FAR_OVER_HALF_WIDTH * half_width) * tightening


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


MATRICES = Matrices(
    TUNED_ON_STRIPS,
    far_radius_for,
    request_on_strips,
    columns=Late("femic.reference.harmonic.lags:syntheses"),
    displacements=Late("femic.reference.harmonic.synthesis:displacements"),
)
