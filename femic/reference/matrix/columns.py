"""Columns of an IC matrix: their scale of refinement, and the estimates of their errors on it."""

from collections.abc import Sequence

import numpy as np

from femic.reference.accuracy import FLOOR, Shares
from femic.reference.estimate import EstimatedICs
from femic.reference.matrix.job import MatrixJob
from geometries.arrays import Array, Mask
from geometries.grids import Grid
from geometries.patches import COMPONENTS, places

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
    mesh, truncation, waves, total_share = (
        _infinite_where_nan(part[chosen] / scale[chosen]) for part in (*c.errors, c.estimate)
    )
    number, lag, observer = np.unravel_index(np.argmax(total_share), total_share.shape)
    line = f"of strip {observer} under strip {strip} (worst at lag {lag})"
    parts = float(np.max(mesh)), float(np.max(truncation)), float(np.max(waves))
    return Shares(*parts, float(np.max(total_share)), components[int(number)], line)


def _infinite_where_nan(shares: Array) -> Array:
    shares[np.isnan(shares)] = np.inf
    return shares
