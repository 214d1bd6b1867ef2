"""A rectangular part of a grid, to which a contact is confined."""

from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from geometries.arrays import Array, Mask

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

    def of(self, values: Values) -> Values:
        """Return the part of values (n_x, n_s, ...) in the box."""
        return values[slice(*self.x), self.strips]

    def filled(self, values: Values, shape: tuple[int, ...]) -> Values:
        """Return values of the box on the grid of a shape, zero elsewhere."""
        result = np.zeros((*shape[:2], *values.shape[2:]), values.dtype)
        self.of(result)[...] = values
        return np.asarray(result)

    def confines(self, contact: Mask, margin: int) -> bool:
        """Return whether a contact has a margin to those ends of the box that are not the grid's."""
        inner = Box(*map(_inner, (self.x, self.s), contact.shape, (margin, margin)))
        return bool(np.count_nonzero(inner.of(contact)) == np.count_nonzero(contact))


def _inner(ends: tuple[int, int], n: int, margin: int) -> tuple[int, int]:
    """Return ends with a margin, but where they are those of n elements."""
    first, last = ends
    return first + margin * (first > 0), last - margin * (last < n)
