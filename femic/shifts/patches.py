"""The patches of a wheel: what each carries, where it lies, and its outline."""

from dataclasses import dataclass

import numpy as np

from femic.contact.edges import Extent
from femic.contact.normal import NormalContact
from femic.contact.pairs.pair_on_grid import PairOnGrid
from femic.contact.pairs.planar import PlanarPatch
from femic.shifts.sides import Place
from geometries.arrays import Array
from geometries.grids import Grid


@dataclass(frozen=True, eq=False)
class PatchNumbers:
    """A patch: force [N] along its normal, share of the vertical load, largest pressure [MPa], area [mm^2].

    `angle` [rad] is the contact angle to the track plane, positive on a flange, the mean weighted with
    pressures. `centre` [mm] is the mean arc length of the rail's profile weighted so, `s` the range, and
    `half_length` that along x. `outline` are arc lengths of the rail and half-lengths along x [mm], (2, n).
    """

    normal_force: float
    share: float
    p_max: float
    angle: float
    centre: float
    s: tuple[float, float]
    half_length: float
    area: float
    outline: Array


def patches_on_grid(
    place: Place, on_grid: PairOnGrid, contact: NormalContact, vertical: float
) -> list[PatchNumbers]:
    """Return the patches of a contact on a grid; `vertical` [N] is the load of all patches of the wheel."""
    return [_numbers(place, on_grid, contact, patch, vertical) for patch in contact.patches]


def planar_patches(place: Place, patch: PlanarPatch, vertical: float) -> list[PatchNumbers]:
    """Return the patches in a plane; coordinates in it are turned into arc lengths of the rail."""

    def arc_length(s: Array) -> Array:
        on_rail = patch.plane.lower_arc_length(s - place.touch.s_rail)
        return np.where(np.isnan(on_rail), s, on_rail + place.touch.s_rail)

    turned = []
    for own in patches_on_grid(place, patch.on_grid, patch.contact, vertical):
        start, end = arc_length(np.array(own.s)).tolist()
        centre = float(arc_length(np.array([own.centre]))[0])
        outline = np.stack([arc_length(own.outline[0]), own.outline[1]])
        turned.append(
            PatchNumbers(
                own.normal_force,
                own.share,
                own.p_max,
                own.angle,
                centre,
                (start, end),
                own.half_length,
                own.area,
                outline,
            )
        )
    return turned


def _numbers(
    place: Place, on_grid: PairOnGrid, contact: NormalContact, patch: Extent, vertical: float
) -> PatchNumbers:
    grid, p = on_grid.grid, np.where(patch.elements, contact.p, 0.0)
    strips = np.sum(p, axis=0)
    angles = place.roll - on_grid.undeformed.lower.contour.inclination(grid.strips)
    low, high = (place.touch.s_rail + grid.strips[0] + end * grid.ds for end in patch.s)
    carried = float(np.sum(strips * np.cos(angles))) * grid.area
    return PatchNumbers(
        normal_force=float(np.sum(strips)) * grid.area,
        share=carried / vertical,
        p_max=float(np.max(p)),
        angle=float(np.average(angles, weights=strips)),
        centre=float(place.touch.s_rail + np.average(grid.strips, weights=strips)),
        s=(float(low), float(high)),
        half_length=(patch.x[1] - patch.x[0]) / 2 * grid.dx,
        area=int(np.count_nonzero(p)) * grid.area,
        outline=_outline(place, grid, p, (float(low), float(high))),
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
