"""Even and odd: how the planes of symmetry halve a body, and what its other half does.

Every body is its own mirror image in x. A patch sits at x = 0, so one parity in x serves each load.
Where the section is its own mirror image in y, half of it is enough too: a load at s = 0 has one
parity in y, any other load is the sum of an even and an odd part.
"""

from dataclasses import dataclass

import numpy as np

from geometries.arrays import Array, Mask
from geometries.patches import Load, S, X

Y = S


@dataclass(frozen=True)
class Parity:
    """+1: the field is its own mirror image in x (in y); -1: the opposite of it. y = 0: no symmetry used."""

    x: int
    y: int

    def signs(self, mirrored: int) -> Array:
        """What the mirror does to the components, shape (3,): +1 even, -1 odd in the mirrored coordinate."""
        whole = self.x if mirrored == X else self.y
        return whole * np.where(np.arange(3) == mirrored, -1.0, 1.0)


def parities(load: Load, *, half_section: bool) -> tuple[Parity, ...]:
    """Parities of the fields that add up to the field of a load."""
    in_x = -1 if load.direction == X else +1
    if not half_section:
        return (Parity(in_x, 0),)
    if load.patch.s == 0:
        return (Parity(in_x, -1 if load.direction == S else +1),)
    return Parity(in_x, +1), Parity(in_x, -1)


def held_by_symmetry(nodes: Array, parity: Parity) -> Mask:
    """Components (n_nodes, 3) that vanish on the planes of symmetry, where they are odd."""
    held = np.zeros((nodes.shape[1], 3), dtype=bool)
    for mirrored in (X, Y) if parity.y else (X,):
        held |= on_plane(nodes, mirrored)[:, None] & (parity.signs(mirrored) < 0)
    return held


def on_plane(nodes: Array, mirrored: int) -> Mask:
    """Whether nodes (3, n) lie on the plane of symmetry x = 0 (y = 0)."""
    return np.asarray(np.abs(nodes[mirrored]) < 1e-9 * np.ptp(nodes, axis=1).max())
