"""Grids of the areas of a contact: where bodies may touch, how large patches are, how narrow strips.

Pressures only push surfaces apart, so that patches lie within the overlaps of the undeformed bodies at the
approach of the contact. The contact is solved on a coarse grid over each overlap, which tells the patches.
Patches far apart have a grid each. Strips are so narrow that the grid resolves the undeformed distance: where
its curvature changes, pressures lack something otherwise (`PairOnGrid.unresolved`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from femic.contact.loading import Loading
from femic.contact.normal import NormalContact
from femic.contact.pairs.areas import Areas, AreasContact, AreaTooSmall
from femic.contact.pairs.grids import COARSE_MARGIN, ROOM, extend_grid, hertz, keep_on_contours, round_up
from femic.contact.pairs.pair_on_grid import RESOLVED, PairOnGrid
from femic.contact.patch import MARGIN
from femic.contact.undeformed import TangentPlane, Undeformed
from geometries.arrays import Array
from geometries.errors import Failure
from geometries.patches import Grid

SAMPLES = 6001  # arc lengths among which overlaps are sought
COARSE_X, COARSE_S, MOST_COARSE = 24, 40, 240  # elements over an overlap, while patches are sought
BESIDE = 0.3  # room beside an overlap, as a share of its length: its distance is linearised there
MOST_TRIES = 60  # approaches with which overlaps are sought, and lengths of grids
GROWTH = 1.1  # of an approach at which overlaps cannot bear the load, at least
SMALL_GAP = 0.05  # between overlaps, as a share of the longer one
LITTLE_MORE = 1.01  # of the approach at which overlaps were sought, at most
TOO_MUCH = 0.8  # of the approach at which overlaps were sought, at least, that the contact has
COUNTS = 0.01  # share of the pressures from which on a patch counts
ACROSS = 8  # elements across patches beside the main one, at least
COARSER_SHARE = (
    0.7  # of the change by elements twice as large: the error of p_max (`femic.contact.estimates`)
)
MOST_ALONG_X, MOST_STRIPS = 160, 1024  # elements of a grid
MOST_ELEMENTS = 60_000  # of all grids of a contact


@dataclass(frozen=True)
class Box:
    """A patch: half-length along x, range of s [mm], and its share of all pressures."""

    half_x: float
    s: tuple[float, float]
    share: float

    @property
    def width(self) -> float:
        """Width along s [mm]."""
        return self.s[1] - self.s[0]


def overlaps(surfaces: Undeformed | TangentPlane, approach: float, roll: float) -> list[tuple[float, float]]:
    """Return the ranges of arc length [mm] in which bodies displaced by an approach [mm] overlap at x = 0.

    The upper body comes down along the direction at an angle `roll` [rad] to the z axis. Ranges end where the
    contours do.
    """
    s = np.linspace(*surfaces.s_range, SAMPLES)
    distance = surfaces.distance(0.0, s, approach * np.cos(roll), -approach * np.sin(roll))
    closed = np.concatenate([[False], distance[1:-1] < 0, [False]])
    edges = np.flatnonzero(closed[1:] != closed[:-1])
    return [
        (float(s[first]), float(s[last + 1])) for first, last in zip(edges[::2], edges[1::2], strict=True)
    ]


@dataclass(frozen=True)
class Sought:
    """A contact by some ICs: its load [N] at an angle `roll` [rad] to the z axis, its approach [mm]."""

    variant: str
    load: float
    roll: float
    approach: float


def find_patches(bodies: PairOnGrid, variant: str, load: float, roll: float) -> tuple[list[Box], Sought]:
    """Return the patches of a contact on coarse grids, by growing s, and the contact with its approach.

    Raises Failure where no approach is found, and where a patch comes near the end of a contour.
    """
    approach, low, high = max(hertz(bodies, Loading(load)).approach, 1e-9), 0.0, np.inf
    for _ in range(MOST_TRIES):
        ranges = merge_ranges(overlaps(bodies.undeformed, approach, roll), share=SMALL_GAP)
        grids = [*_coarse_grids(bodies, ranges, approach, roll)]
        try:
            contact = Areas.with_approximation(variant, bodies, grids, roll).solve(load, approach)
            found = contact.approach
        except AreaTooSmall as short:
            found = short.short.loading.approach or 0.0
            if TOO_MUCH * approach <= found <= LITTLE_MORE * approach:  # only the contour ends there
                start, end = bodies.undeformed.s_range
                raise Failure(
                    f"at an approach of {found:.4g} mm a patch comes near the end of a contour, which "
                    f"reaches from {start:.2f} to {end:.2f} mm about the touching point; give longer "
                    "profiles or a smaller load"
                ) from short
        if found > LITTLE_MORE * approach:  # these overlaps cannot bear the load
            low = max(low, approach)
            higher = float(np.clip(1.05 * found, GROWTH * approach, 2 * approach))
            approach = higher if higher < high else (low + high) / 2
        elif found < TOO_MUCH * approach:
            high, approach = approach, max(1.02 * found, (low + 1.02 * found) / 2)
        else:
            totals = [float(np.sum(each.p)) * each.problem.grid.area for each in contact.contacts]
            boxes = [
                replace(box, share=box.share * own / sum(totals))
                for (on_grid, pressed), own in zip(contact.parts, totals, strict=True)
                for box in boxes_on_grid(on_grid.grid, pressed)
            ]
            return boxes, Sought(variant, load, roll, found)
    raise Failure(f"contact at {load:g} N: no approach found at which the overlaps of the bodies bear it")


def fitting_grids(bodies: PairOnGrid, boxes: Sequence[Box], elements: int, most_strips: int) -> list[Grid]:
    """Return grids over groups of patches: some elements across the main one, half as many across others."""
    main = max(boxes, key=lambda box: box.share)
    groups = [(group, elements if main in group else elements // 2) for group in _groups(boxes)]
    grids = [fitting_grid(group, across, most_strips) for group, across in groups]
    ranges = [(min(box.s[0] for box in group), max(box.s[1] for box in group)) for group, _ in groups]
    return [keep_on_contours(grid, bodies.undeformed.s_range) for grid in _apart(grids, ranges)]


def fitting_grid(group: Sequence[Box], elements: int, most_strips: int = MOST_STRIPS) -> Grid:
    """Return a grid over some patches with elements across the main one of them, `ACROSS` in others."""
    main = max(group, key=lambda box: box.share)
    counting = [box for box in group if box.share >= COUNTS * sum(other.share for other in group)]
    across = [(box, max(ACROSS, elements if box is main else elements // 2)) for box in counting]
    dx, ds = min(2 * box.half_x / n for box, n in across), min(box.width / n for box, n in across)
    half_x = max(box.half_x for box in group)
    low, high = min(box.s[0] for box in group), max(box.s[1] for box in group)
    ds = max(ds, (high - low) / (most_strips / (1 + 2 * ROOM) - 2 * COARSE_MARGIN))
    room_x, room_s = 2 * ROOM * half_x + COARSE_MARGIN * dx, ROOM * (high - low) + COARSE_MARGIN * ds
    n_x, n_s = round_up(2 * (half_x + room_x) / dx), round_up((high - low + 2 * room_s) / ds)
    return Grid(n_x, n_s, dx, ds, (low + high) / 2)


def longer(areas: Areas, short: AreaTooSmall) -> list[Grid]:
    """Return the grids of areas, of which one is made longer where it is too short.

    Raises Failure where a contour ends there, or another area begins.
    """
    grids = list(areas.grids)
    grid = grids[short.number]
    grown = extend_grid(grid, short.short.ends)
    others = [other.extent for number, other in enumerate(grids) if number != short.number]
    low, high = areas.on_grids[0].undeformed.s_range
    start, end = grown.extent
    if start < low or end > high:
        raise Failure(
            f"the patch at s = {grid.extent[0]:.2f} ... {grid.extent[1]:.2f} mm from the touching point "
            "comes near the end of a contour; give longer profiles or a smaller load"
        )
    if any(start < other_end and other_start < end for other_start, other_end in others):
        raise Failure(
            f"the patch at s = {grid.extent[0]:.2f} ... {grid.extent[1]:.2f} mm grows into the grid of "
            "another one; give another number of elements"
        )
    grids[short.number] = grown
    return grids


def unresolved(contact: AreasContact, number: int) -> float:
    """Return what pressures lack in an area [MPa], because the distance changes between its strips."""
    on_grid, near = contact.areas.on_grids[number], contact.contacts[number].in_contact.any(axis=0)
    if np.count_nonzero(near) < 2:
        return 0.0
    down, aside = contact.approach * np.cos(contact.areas.roll), contact.approach * np.sin(contact.areas.roll)
    return float(np.max(on_grid.unresolved(down, -aside)[near]))


def refined_grids(
    bodies: PairOnGrid, boxes: Sequence[Box], sought: Sought, elements: int
) -> tuple[Grid, ...]:
    """Return grids over patches, `refine`d."""
    return refine(bodies, fitting_grids(bodies, boxes, elements, MOST_STRIPS), sought, MOST_STRIPS)


def refine(bodies: PairOnGrid, grids: Sequence[Grid], sought: Sought, most_strips: int) -> tuple[Grid, ...]:
    """Return grids made long enough, with enough elements across each patch and for p_max.

    Grids of more than `MOST_ELEMENTS` elements or `most_strips` strips are not made finer.
    """
    for _ in range(MOST_TRIES):
        areas = Areas.with_approximation(sought.variant, bodies, grids, sought.roll)
        try:
            contact = areas.solve_about(sought.approach, sought.load).with_room()
        except AreaTooSmall as short:
            grids = longer(areas, short)
            continue
        totals = [float(np.sum(each.p)) * each.problem.grid.area for each in contact.contacts]
        largest = max(float(np.max(each.p)) for each in contact.contacts)
        finer = [
            (finer_grid(own, unresolved(contact, number), most_strips, largest) or grid)
            if total >= COUNTS * sum(totals)
            else grid
            for number, (grid, own, total) in enumerate(zip(grids, contact.contacts, totals, strict=True))
        ]
        if finer == list(grids) or sum(grid.n_x * grid.n_s for grid in finer) > MOST_ELEMENTS:
            return tuple(grids)
        grids = finer
    raise Failure(f"contact at {sought.load:g} N: no grids found that it fits")


def finer_grid(
    contact: NormalContact, lacking: float, most_strips: int, largest: float | None = None
) -> Grid | None:
    """Return a grid of smaller elements where a contact needs them; None where not, or beyond the finest.

    `lacking` [MPa] is what pressures lack because of narrow changes of the distance; it, and the change by
    elements twice as large, are compared with the `largest` pressure [MPa], None: of this contact.
    """
    grid, total = contact.problem.grid, float(np.sum(contact.p))
    counting = [patch for patch in contact.patches if np.sum(contact.p[patch.elements]) >= COUNTS * total]
    few_x = any(patch.x[1] - patch.x[0] < ACROSS for patch in counting)
    few_s = any(patch.s[1] - patch.s[0] < ACROSS for patch in counting)
    allowed = RESOLVED * (float(np.max(contact.p)) if largest is None else largest)
    coarser = contact if contact.coarser is None else contact.coarser
    change = abs(float(np.max(contact.p)) - float(np.max(coarser.p)))
    rough = lacking > allowed or COARSER_SHARE * change > allowed
    along_x, along_s = 2 if few_x else 1, 2 if few_s or rough else 1
    finer = Grid(along_x * grid.n_x, along_s * grid.n_s, grid.dx / along_x, grid.ds / along_s, grid.s)
    return None if finer == grid or finer.n_x > MOST_ALONG_X or finer.n_s > most_strips else finer


def boxes_on_grid(grid: Grid, pressed: NormalContact) -> list[Box]:
    """Return the patches on a grid and their shares of its pressures; they are as large as their elements."""
    boxes, middle, total = [], (grid.n_x - 1) / 2, float(np.sum(pressed.p))
    for patch in pressed.patches:
        half = max(abs(patch.x[0] - middle), abs(patch.x[1] - middle), 0.5) * grid.dx
        low, high = (float(grid.strips[0] + place * grid.ds) for place in patch.s)
        share = float(np.sum(pressed.p[patch.elements])) / total
        boxes.append(Box(half, (low, max(high, low + grid.ds / 2)), share))
    return boxes


def _coarse_grids(
    bodies: PairOnGrid, ranges: Sequence[tuple[float, float]], approach: float, roll: float
) -> Iterator[Grid]:
    """Yield a coarse grid over each overlap with room beside it, as far as the middle of the gap to the next.

    Where there is little room, strips are so narrow that patches do not come near the ends of their grid.
    """
    start, end = bodies.undeformed.s_range
    middles = [(one[1] + other[0]) / 2 for one, other in pairwise(ranges)]
    for (low, high), before, after in zip(ranges, [start, *middles], [*middles, end], strict=True):
        beside = BESIDE * (high - low)
        first, last = max(before, low - beside), min(after, high + beside)
        room = min(low - first, last - high) / (MARGIN + 2)
        ds = max(min((last - first) / COARSE_S, room), (last - first) / MOST_COARSE)
        half_x = (1 + BESIDE / 2) * _half_length(bodies.undeformed, (low, high), approach, roll)
        n_s = round_up((last - first) / ds)
        dx = 2 * half_x / (COARSE_X - 2 * MARGIN - 2)
        yield Grid(COARSE_X, n_s, dx, (last - first) / n_s, (first + last) / 2)


def _half_length(
    surfaces: Undeformed | TangentPlane, s: tuple[float, float], approach: float, roll: float
) -> float:
    """Return half of the length [mm] along x of an overlap."""
    radius, moved = surfaces.upper.rolling_radius, (approach * np.cos(roll), -approach * np.sin(roll))
    about = float(np.sqrt(2 * approach * min(radius, 1e6)))
    return overlap_half_length(surfaces, np.linspace(*s, 129), moved, about, 0.9 * radius)


def overlap_half_length(
    surfaces: Undeformed | TangentPlane,
    s: Array,
    moved: tuple[float, float],
    about: float,
    longest: float = np.inf,
) -> float:
    """Return half of the length [mm] along x of an overlap, of which `about` is a guess.

    It is sought at places s of bodies that are moved down and aside [mm]; 1e-3 of the guess between samples.
    """

    def least(x: float) -> float:
        return float(np.min(surfaces.distance(x, s, *moved)))

    if least(0.0) >= 0:
        return 1e-3 * about
    while least(about) < 0 and about < longest:
        about *= 1.5
    return float(scipy.optimize.brentq(least, 0.0, about, rtol=1e-3))


def merge_ranges(
    ranges: Sequence[tuple[float, float]], *, share: float = 0.0, gap: float = 0.0
) -> list[tuple[float, float]]:
    """Return ranges; neighbours nearer than a share of the longer one, or than a gap [mm], are one."""
    merged = list(ranges[:1])
    for low, high in ranges[1:]:
        before = merged[-1]
        if low - before[1] < max(share * max(high - low, before[1] - before[0]), gap):
            merged[-1] = (before[0], high)
        else:
            merged.append((low, high))
    return merged


def _groups(boxes: Sequence[Box]) -> list[list[Box]]:
    """Return patches by growing s, of which neighbours share a grid where it is not mostly empty.

    Far apart is a gap as long as the longer one of both is, along x or s.
    """
    boxes = sorted(boxes, key=lambda box: box.s)
    groups = [[boxes[0]]]
    for before, box in pairwise(boxes):
        size = max(before.half_x, box.half_x, before.width / 2, box.width / 2)
        if box.s[0] - before.s[1] < size:
            groups[-1].append(box)
        else:
            groups.append([box])
    return groups


def _apart(grids: Sequence[Grid], ranges: Sequence[tuple[float, float]]) -> list[Grid]:
    """Return grids by growing s of which none reaches into the next one.

    `ranges` [mm] are what each grid is about: two that would meet end in the middle of the gap between these.
    """
    grids = list(grids)
    for k, (one, other) in enumerate(pairwise(grids)):
        middle = (ranges[k][1] + ranges[k + 1][0]) / 2
        if one.extent[1] > other.extent[0]:
            grids[k] = _shortened(one, after=max(0, int(np.ceil((one.extent[1] - middle) / one.ds))))
            before = max(0, int(np.ceil((middle - other.extent[0]) / other.ds)))
            grids[k + 1] = _shortened(other, before=before)
    return grids


def _shortened(grid: Grid, *, before: int = 0, after: int = 0) -> Grid:
    """Return a grid without some strips at its ends, and as many more as make the number a multiple of 2."""
    n_s = grid.n_s - before - after
    odd = n_s % 2
    before, after = before + odd * (before > 0), after + odd * (after > 0)
    return replace(grid, n_s=grid.n_s - before - after, s=grid.s + (before - after) * grid.ds / 2)
