"""Contact patches on a grid: boxes around them, resultants of their tractions, and their edges.

Forces and moments, about the contact centre, are those on the upper body, in global axes. Theory:
docs/theory/contact.md.

Edges are interpolated within elements, from two readings. From gaps: beyond the edge of smooth surfaces the
gap grows as distance^(3/2), so gap^(2/3) at the second and third element without contact gives a straight
line that starts at the edge. It is right to 0.05 elements, but off by 0.3 at the tips of slender patches,
whose edge is curved within these elements. From pressures: the squared pressure vanishes at the edge; the
parabola through it at the third to fifth element from the edge (nearer ones are partly covered) is exact for
Hertz's, but off by half an element where pressures fall otherwise. Where both are there, their mean is taken,
and their difference is added to its accuracy. A reading from gaps alone, on short lines, has an accuracy of
its own; and where another patch lies beyond on the same line the gap grows and falls again, and tells the
edge to an element.
"""

from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np
from scipy.ndimage import find_objects, label

from geometries.arrays import Array, Mask
from geometries.contours import Contour
from geometries.patches import N, S, X

# --- parts of a grid, and larger elements ---


def block_mean(values: Array) -> Array:
    """Means over four neighbours, shape (n_x / 2, n_s / 2, ...)."""
    n_x, n_s, *others = values.shape
    return np.asarray(values.reshape(n_x // 2, 2, n_s // 2, 2, *others).mean(axis=(1, 3)))


Values = TypeVar("Values", Array, Mask)

ROOM = 4  # elements beside a contact, at least
STEP = 8  # ends are multiples of these numbers of elements, so that contacts of similar size have one box


@dataclass(frozen=True)
class Box:
    """Elements from the first to before the last, along x and s."""

    x: tuple[int, int]
    s: tuple[int, int]

    @classmethod
    def whole(cls, shape: tuple[int, ...]) -> Self:
        """Return the box of a grid of this shape."""
        return cls((0, shape[0]), (0, shape[1]))

    @classmethod
    def around(cls, contact: Mask) -> Self:
        """Return the box of elements in contact with room beside them."""
        ends = []
        for axis, n in enumerate(contact.shape):
            places = np.flatnonzero(contact.any(axis=1 - axis))
            first, last = (places[0] - ROOM) // STEP * STEP, -(-(places[-1] + 1 + ROOM) // STEP) * STEP
            ends.append((max(int(first), 0), min(int(last), n)))
        return cls(*ends)

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of elements along x and s."""
        return self.x[1] - self.x[0], self.s[1] - self.s[0]

    @property
    def coarsened(self) -> "Box":
        """The same of elements twice as large."""
        return Box(*((first // 2, last // 2) for first, last in (self.x, self.s)))

    @property
    def strips(self) -> slice:
        """The strips."""
        return slice(*self.s)

    def crop(self, values: Values) -> Values:
        """Return the part of values (n_x, n_s, ...) in the box."""
        return values[slice(*self.x), self.strips]

    def embed(self, values: Values, shape: tuple[int, ...]) -> Values:
        """Return values of the box on the grid of a shape, zero elsewhere."""
        result = np.zeros((*shape[:2], *values.shape[2:]), values.dtype)
        self.crop(result)[...] = values
        return np.asarray(result)

    def confines(self, contact: Mask, margin: int) -> bool:
        """Return whether a contact has a margin to those ends of the box that are not the grid's."""
        inner = Box(
            *(
                (first + margin * (first > 0), last - margin * (last < n))
                for (first, last), n in zip((self.x, self.s), contact.shape, strict=True)
            )
        )
        return bool(np.count_nonzero(inner.crop(contact)) == np.count_nonzero(contact))


# --- resultants ---


@dataclass(frozen=True, eq=False)
class Resultant:
    """Force [N] and moment about the contact centre (0, 0, 0) [N mm] on the upper body, shape (3,) each."""

    force: Array
    moment: Array


Section = tuple[Array, Array, Array, Array]


def section_at(contour: Contour, s: Array) -> Section:
    """Return y and z [mm], sine and cosine of the inclination of a lower contour at strips s (n_s,) [mm]."""
    return (*contour.position(s), *contour.normal(s))


def resultant(tractions: Array, section: Section, x: Array, area: float) -> Resultant:
    """Return the resultant of tractions (n_x, n_s, 3) [MPa] along x, s, n on elements of a lower section.

    `x` (n_x,) are the centres of elements along x, `area` is that of an element [mm^2].
    """
    y, z, sin, cos = section
    f_x, f_y, f_z = in_global_axes(area * np.sum(tractions, axis=0), sin, cos)  # of strips
    _, xf_y, xf_z = in_global_axes(area * np.tensordot(x, tractions, 1), sin, cos)
    moments = y * f_z - z * f_y, z * f_x - xf_z, xf_y - y * f_x
    return Resultant(np.sum([f_x, f_y, f_z], axis=1), np.sum(moments, axis=1))


def in_global_axes(tractions: Array, sin: Array, cos: Array) -> tuple[Array, Array, Array]:
    """Components along x, y, z of tractions (..., n_s, 3), by sine and cosine of the inclination (n_s,)."""
    p_x, p_s, p_n = (tractions[..., direction] for direction in (X, S, N))
    return p_x, p_s * cos + p_n * sin, p_n * cos - p_s * sin


def centre_of_pressure(p: Array, s: Array) -> float:
    """Return the mean arc length [mm] of pressures (n_x, n_s) [MPa] on strips at s (n_s,)."""
    return float(np.sum(p * s) / np.sum(p))


# --- edges of patches ---

ACCURACY = 0.05  # of two readings, in elements, at least
ALONE, BESIDE = 0.3, 1.0  # accuracy of a reading from gaps alone, and of one beside another patch
LEAST_SHARE = 0.5  # of the elements that a patch covers: it is at least so long
LONG = 9  # elements of lines on which pressures tell the edges
MARGIN = 3  # elements without contact that a patch needs on all sides: their gaps show its edge
ENDS = ("x < 0", "x > 0", "s < 0", "s > 0")
TOUCHING = np.ones((3, 3))  # elements that touch at a corner belong to the same patch


@dataclass(frozen=True, eq=False)
class Extent:
    """A patch: its elements (n_x, n_s), and the ranges of x and s that it covers in elements of the grid.

    `accuracy_x`, `accuracy_s` are those of half of these ranges, in elements.
    """

    elements: Mask
    x: tuple[float, float]
    s: tuple[float, float]
    accuracy_x: float
    accuracy_s: float


def near_ends(in_contact: Mask, margin: int = MARGIN) -> tuple[str, ...]:
    """Return the ends of a grid, of `ENDS`, that a contact comes nearer to than `margin` elements."""
    along_x, along_s = (np.flatnonzero(in_contact.any(axis=axis)) for axis in (1, 0))
    if not len(along_x):
        return ()
    n_x, n_s = in_contact.shape
    rooms = along_x[0], n_x - 1 - along_x[-1], along_s[0], n_s - 1 - along_s[-1]
    return tuple(end for end, room in zip(ENDS, rooms, strict=True) if room < margin)


def extents(p: Array, gap: Array) -> list[Extent]:
    """Return the patches of a contact from its pressures and gaps (n_x, n_s), from the left to the right.

    Coordinates count elements from the centre of the first one. Patches need `MARGIN` elements on all sides.
    """
    numbers, _ = label(p > 0, TOUCHING)
    patches = []
    for number, place in enumerate(find_objects(numbers), start=1):
        elements = numbers == number
        (x, accuracy_x), (s, accuracy_s) = _range(elements, p, gap), _range(elements.T, p.T, gap.T)
        extent = Extent(elements, x, s, accuracy_x, accuracy_s)
        patches.append((place[1].start, extent))
    return [extent for _, extent in sorted(patches, key=lambda item: item[0])]


def _range(elements: Mask, p: Array, gap: Array) -> tuple[tuple[float, float], float]:
    """Return the longest range that a patch covers along the first axis, and the accuracy of its half."""
    lines, last = np.flatnonzero(elements.any(axis=0)), len(elements) - 1
    highest, highest_accuracy = max(_end(elements[:, line], p[:, line], gap[:, line]) for line in lines)
    lowest, lowest_accuracy = max(
        _end(elements[::-1, line], p[::-1, line], gap[::-1, line]) for line in lines
    )
    lacking = LEAST_SHARE * np.count_nonzero(elements.any(axis=1)) - (highest - (last - lowest))
    wider = max(0.0, float(lacking)) / 2  # at either end: readings of both pass each other on few elements
    return (last - lowest - wider, highest + wider), (lowest_accuracy + highest_accuracy) / 2 + wider


def _end(elements: Mask, p: Array, gap: Array) -> tuple[float, float]:
    """Return the coordinate at which the contact on a line ends, in elements, and its accuracy."""
    last = int(np.flatnonzero(elements)[-1])
    inside = p[: last + 1][::-1]
    from_gaps = _from_gaps(gap[last + 1 :])
    from_pressures = _from_pressures(inside) if len(inside) >= LONG and np.all(inside[:LONG] > 0) else None
    beside = bool(np.any(p[last + 1 :] > 0))
    if from_pressures is None:
        return last + from_gaps, BESIDE if beside else ALONE
    accuracy = BESIDE if beside else ACCURACY + abs(from_gaps - from_pressures)
    return last + (from_gaps + from_pressures) / 2, accuracy


def _from_pressures(inside: Array) -> float | None:
    """Return the distance of the edge from the centre of the last element in contact, by pressures there.

    None where squared pressures do not fall to 0 within an element of where the contact ends.
    """
    third, fourth, fifth = inside[2:5] ** 2
    slope, bend = (fifth - third) / 2, (third - 2 * fourth + fifth) / 2
    # roots, in elements inwards from the fourth, of bend t^2 + slope t + fourth
    inside_root = slope**2 - 4 * bend * fourth
    if inside_root < 0:
        return None
    larger = -(slope + np.copysign(np.sqrt(inside_root), slope)) / 2  # no terms of it cancel
    roots = [top / below for top, below in ((larger, bend), (fourth, larger)) if below != 0]
    edges = [-3 - root for root in roots if -4 <= root <= -2.5]
    return float(min(edges, key=abs)) if edges else None


def _from_gaps(gaps: Array) -> float:
    """Return the same distance from gaps beyond the edge.

    Half an element where gaps do not grow, because another patch is near.
    """
    if len(gaps) < MARGIN or not 0 < gaps[1] < gaps[2] < np.inf:
        return 0.5
    second, third = gaps[1:3] ** (2 / 3)
    if third == second:  # to rounding
        return 0.5
    return float(np.clip(2 - second / (third - second), -0.5, 1.0))
