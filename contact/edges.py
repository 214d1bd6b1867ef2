"""The edges of contact patches, interpolated within elements, and the ends of the grid that they come near.

Beyond an edge the gap of smooth surfaces grows as distance^(3/2), so gap^(2/3) is a straight line that starts
at the edge. Its values at the second and third element without contact give the edge to a twentieth of an
element (the first one is half covered by what the grid makes of the edge).
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import find_objects, label

from geometries.arrays import Array, Mask

MARGIN = 3  # elements without contact that a patch needs on all sides: their gaps show its edge
ENDS = ("x < 0", "x > 0", "s < 0", "s > 0")
TOUCHING = np.ones((3, 3))  # elements that touch at a corner belong to the same patch


@dataclass(frozen=True, eq=False)
class Extent:
    """A patch: its elements (n_x, n_s), and the ranges of x and s that it covers in elements of the grid."""

    elements: Mask
    x: tuple[float, float]
    s: tuple[float, float]


def near_ends(in_contact: Mask) -> tuple[str, ...]:
    """The ends of a grid, of `ENDS`, that a contact comes nearer to than `MARGIN` elements."""
    along_x, along_s = (np.flatnonzero(in_contact.any(axis=axis)) for axis in (1, 0))
    if not len(along_x):
        return ()
    n_x, n_s = in_contact.shape
    rooms = along_x[0], n_x - 1 - along_x[-1], along_s[0], n_s - 1 - along_s[-1]
    return tuple(end for end, room in zip(ENDS, rooms, strict=True) if room < MARGIN)


def extents(in_contact: Mask, gap: Array) -> list[Extent]:
    """The patches of a contact, whose gaps (n_x, n_s) [mm] are known beyond them, from the left to the right.

    Coordinates count elements from the centre of the first one. Patches need `MARGIN` elements on all sides.
    """
    numbers, _ = label(in_contact, TOUCHING)
    found = []
    for number, place in enumerate(find_objects(numbers), start=1):
        elements = numbers == number
        ranges = [_range(np.moveaxis(elements, axis, 0), np.moveaxis(gap, axis, 0)) for axis in (0, 1)]
        found.append((place[1].start, Extent(elements, *ranges)))
    return [extent for _, extent in sorted(found, key=lambda item: item[0])]


def _range(elements: Mask, gap: Array) -> tuple[float, float]:
    """The range that a patch covers along the first axis, at its longest."""
    lines = np.flatnonzero(elements.any(axis=0))
    n = len(elements)
    last = n - 1 - np.argmax(elements[::-1], axis=0)
    first = np.argmax(elements, axis=0)
    highest = max(last[line] + _beyond(gap[last[line] + 1 :, line]) for line in lines)
    lowest = min(first[line] - _beyond(gap[: first[line], line][::-1]) for line in lines)
    return float(lowest), float(highest)


def _beyond(gaps: Array) -> float:
    """Distance of the edge from the centre of the last element in contact, in elements, from gaps beyond it.

    Half an element where gaps do not grow, because another patch is near.
    """
    if len(gaps) < MARGIN or not (0 < gaps[1] < gaps[2] < np.inf):
        return 0.5
    second, third = gaps[1:3] ** (2 / 3)
    return float(np.clip(2 - second / (third - second), -0.5, 1.0))
