"""The edges of contact patches, interpolated within elements, and the ends of the grid that they come near.

Within an edge the squared pressure is a smooth function that vanishes at the edge; of Hertz's it is a
quadratic one. The parabola through the third to fifth element from the edge (nearer ones are partly covered)
meets 0 at the edge to 0.03 elements. On short lines, and where pressures do not fall so, the gap tells: beyond
the edge of smooth surfaces it grows as distance^(3/2) near it, so gap^(2/3) at the second and third element
without contact gives a straight line that starts at the edge. At the tips of slender patches this is off by
0.3 elements.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import find_objects, label

from geometries.arrays import Array, Mask

ACCURACY = 0.05  # of an edge, in elements, on grids fine enough for pressures to tell it
LONG = 9  # elements of lines on which pressures tell the edges
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


def extents(p: Array, gap: Array) -> list[Extent]:
    """The patches of a contact from its pressures and gaps (n_x, n_s), from the left to the right.

    Coordinates count elements from the centre of the first one. Patches need `MARGIN` elements on all sides.
    """
    numbers, _ = label(p > 0, TOUCHING)
    found = []
    for number, place in enumerate(find_objects(numbers), start=1):
        elements = numbers == number
        extent = Extent(elements, _range(elements, p, gap), _range(elements.T, p.T, gap.T))
        found.append((place[1].start, extent))
    return [extent for _, extent in sorted(found, key=lambda item: item[0])]


def _range(elements: Mask, p: Array, gap: Array) -> tuple[float, float]:
    """The range that a patch covers along the first axis, at its longest."""
    lines, last = np.flatnonzero(elements.any(axis=0)), len(elements) - 1
    highest = max(_end(elements[:, line], p[:, line], gap[:, line]) for line in lines)
    lowest = min(last - _end(elements[::-1, line], p[::-1, line], gap[::-1, line]) for line in lines)
    return float(lowest), float(highest)


def _end(elements: Mask, p: Array, gap: Array) -> float:
    """The coordinate at which the contact on a line ends, in elements."""
    last = int(np.flatnonzero(elements)[-1])
    inside = p[: last + 1][::-1]
    of_pressures = _from_pressures(inside) if np.all(inside[:LONG] > 0) and len(inside) >= LONG else None
    return last + (_from_gaps(gap[last + 1 :]) if of_pressures is None else of_pressures)


def _from_pressures(inside: Array) -> float | None:
    """Distance of the edge from the centre of the last element in contact, from pressures from there inwards.

    None where squared pressures do not fall to 0 within an element of where the contact ends.
    """
    third, fourth, fifth = inside[2:5] ** 2
    slope, bend = (fifth - third) / 2, (third - 2 * fourth + fifth) / 2
    roots = np.roots([bend, slope, fourth])  # in elements inwards from the fourth
    edges = [-3 - root.real for root in roots if abs(root.imag) == 0 and -4 <= root.real <= -2.5]
    return float(min(edges, key=abs)) if edges else None


def _from_gaps(gaps: Array) -> float:
    """The same distance from gaps beyond the edge.

    Half an element where gaps do not grow, because another patch is near.
    """
    if len(gaps) < MARGIN or not (0 < gaps[1] < gaps[2] < np.inf):
        return 0.5
    second, third = gaps[1:3] ** (2 / 3)
    return float(np.clip(2 - second / (third - second), -0.5, 1.0))
