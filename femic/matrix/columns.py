"""Columns of an IC matrix: the scale of their errors, and how large the estimates are on it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from femic.accuracy import FLOOR, Shares
from femic.estimate import Estimated
from femic.matrix.job import MatrixJob
from geometries.arrays import Array, Mask
from geometries.grids import Grid
from geometries.patches import DIRECTIONS

NEAR_ELEMENTS, NEAR_SHARE = 4, 5.0  # elements from the load within which errors are shares of 5 A_nn


def column_scale(strip: int, c: Array, jobs: Sequence[MatrixJob]) -> Array:
    """Scale of refinement of ICs (3, 3, n_x, n_s) that jobs have together, of the same shape.

    `NEAR_ELEMENTS` from the load and further: per pair of strips, the larger of max |C_ij| and 0.05 max A_nn
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


def is_far(strip: int, grid: Grid) -> Mask:
    """Which elements are `NEAR_ELEMENTS` elements from a load on a strip or further, (n_x, n_s)."""
    lag, apart = np.arange(grid.n_x)[:, None], np.arange(grid.n_s) - strip
    return np.asarray(np.hypot(lag, apart) >= NEAR_ELEMENTS)


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
