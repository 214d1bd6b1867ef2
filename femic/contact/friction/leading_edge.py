"""Elements at the leading edge of a rolling contact, whose tractions follow those behind them.

A surface that rolls into contact takes up tangential tractions from zero, in proportion to the pressures at
first: their ratio is smooth there, while both rise like the square root of the distance from the edge.
Elements of constant traction follow this rise badly: where slip is made zero on the outermost ones, forces
have errors of the first order, which depend on how the edge cuts elements. So the last `DEPTH` elements of
each row take the same share of their bounds as the one behind them.

In short rows bounds hardly fall between these elements: then their tractions, raised together, would move the
followed one ahead instead of back, and no tractions at all might obey Coulomb's law. So only one element
follows in rows of less than two times `LEAST_PER_DEPTH` elements, and none in rows of less than that.
"""

from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array, Indices, Mask

DEPTH = 2  # elements of each row that follow
LEAST_PER_DEPTH = 6  # elements of a row for each that follows


@dataclass(frozen=True, eq=False)
class LeadingEdge:
    """The row of the element that each one's tractions follow, and the ratio of both bounds, (n_x, n_s)."""

    followed: Indices
    ratio: Array

    @classmethod
    def of(cls, bound: Array, depth: int = DEPTH) -> "LeadingEdge":
        """Return the leading edge of where bounds are positive; rolling is towards +x."""
        places = np.arange(len(bound))[:, None]
        ahead, behind = _neighbours(bound[::-1] > 0)[::-1], _neighbours(bound > 0)
        following = np.minimum(depth, (ahead + 1 + behind) // LEAST_PER_DEPTH)
        steps = np.maximum(following - ahead, 0)
        followed = places - np.where(bound > 0, steps, 0)
        of_followed = np.take_along_axis(bound, followed, axis=0)
        ratio = np.divide(bound, of_followed, out=np.zeros_like(bound), where=of_followed > 0)
        return cls(followed, ratio)

    @property
    def behind(self) -> Indices:
        """How many elements behind each one that is which it follows, shape (n_x, n_s); 0 of a free one."""
        return np.arange(len(self.followed))[:, None] - self.followed

    @property
    def free(self) -> Mask:
        """Elements with bounds that follow no other, shape (n_x, n_s)."""
        return np.asarray((self.behind == 0) & (self.ratio > 0))

    def with_followers(self, of_free: Mask) -> Mask:
        """Return which elements have what some free ones (m,) have, with those that follow, (n_x, n_s)."""
        everywhere = np.zeros(self.followed.shape, bool)
        everywhere[self.free] = of_free
        return np.take_along_axis(everywhere, self.followed, axis=0)

    def spread(self, p: Array) -> Array:
        """Return tractions of all elements from those of the free ones, shape (n_x, n_s, 2)."""
        return np.asarray(np.take_along_axis(p, self.followed[..., None], axis=0) * self.ratio[..., None])


def _neighbours(mask: Mask) -> Indices:
    """Return how many elements before each one, without a gap, are in a mask, shape (n_x, n_s)."""
    counts = np.zeros(mask.shape, dtype=int)
    for row in range(1, len(mask)):
        counts[row] = np.where(mask[row - 1], counts[row - 1] + 1, 0)
    return counts
