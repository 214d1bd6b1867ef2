"""The patches of a contact: their shares of the load, ranges and outlines."""

from dataclasses import dataclass

import numpy as np

from femic.contact.edges import Extent
from femic.contact.normal import NormalContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.shifts.sides import Place
from geometries.arrays import Array
from geometries.grids import Grid


@dataclass(frozen=True, eq=False)
class PatchNumbers:
    """A patch: share of the vertical load, range of s on the rail and half-length along x [mm], p_max [MPa].

    `outline` are arc lengths of the rail and half-lengths along x [mm], (2, n), from the centres of the
    elements.
    """

    share: float
    s: tuple[float, float]
    half_length: float
    p_max: float
    outline: Array


def patch_numbers(place: Place, on_grid: PairOnGrid, contact: NormalContact, patch: Extent) -> PatchNumbers:
    """Return the numbers of a patch; arc lengths are those of the rail's profile."""
    grid, p = on_grid.grid, np.where(patch.elements, contact.p, 0.0)
    vertical = contact.p * on_grid.cosine
    low, high = (place.touch.s_rail + grid.strips[0] + end * grid.ds for end in patch.s)
    return PatchNumbers(
        float(np.sum(p * on_grid.cosine) / np.sum(vertical)),
        (float(low), float(high)),
        (patch.x[1] - patch.x[0]) / 2 * grid.dx,
        float(np.max(p)),
        _outline(place, grid, p, (float(low), float(high))),
    )


def _outline(place: Place, grid: Grid, p: Array, ends: tuple[float, float]) -> Array:
    """Return arc lengths of the rail and half-lengths [mm], (2, n), of strips of a patch, and of its ends.

    On a strip the squared pressure falls to 0 nearly linearly in x^2.
    """
    strips_in = np.flatnonzero(p.any(axis=0))
    x = np.asarray(grid.dx * (np.arange(grid.n_x) - (grid.n_x - 1) / 2))
    half = [_half_length(x, p[:, strip], grid.dx) for strip in strips_in]
    s = place.touch.s_rail + grid.strips[strips_in]
    return np.array([[ends[0], *s, ends[1]], [0.0, *half, 0.0]])


def _half_length(x: Array, p: Array, dx: float) -> float:
    """Return the half-length [mm] of a strip in contact."""
    inside = np.flatnonzero((p > 0) & (x >= 0))
    if len(inside) < 4:
        return float(np.count_nonzero(p > 0) * dx / 2)
    second, third = inside[-2], inside[-4]
    slope = (p[second] ** 2 - p[third] ** 2) / (x[second] ** 2 - x[third] ** 2)
    last = float(x[inside[-1]])
    edge = np.sqrt(max(x[second] ** 2 - p[second] ** 2 / slope, 0.0)) if slope < 0 else last + dx / 2
    return float(np.clip(edge, last, last + dx))
